"""The table's bars against solid models of the parts themselves: meshed by gmsh, solved by scikit-fem.

15 % is asked of sections that can be computed, closed or solid ones; the parts are made of such.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest

from delta_cad.solids.brackets import make_encoder_cheek, make_foot_block, make_motor_cheek
from delta_cad.solids.forearm import make_cross_bar
from delta_cad.solids.part import Part
from delta_cad.solids.platform import make_platform, turned_to_chain
from delta_cad.solids.primitive import ball, bore_y, box, fuse
from delta_cad.solids.upper_arm import make_upper_arm
from delta_cad.structure import beam, section
from delta_cad.structure.beam_model import beam_model, moduli_N_mm2
from tests.delta_cad.structure.machines import committed
from tests.delta_cad.structure.solid_model import flexibility, meshed

ALUMINIUM, _ = moduli_N_mm2("aluminium-7075")
FORCES_AND_TORQUE = np.eye(6)[[1, 2, 3]]  # sideways, in plane, torsion
REQUIRED = 0.15
FACET_MM = 0.3  # a bore's facets lie so far inside its circle at most


def compared(bar: beam.Beam) -> np.ndarray:
    """Formula's flexibility sideways, in plane and in torsion."""
    return np.diag(beam.flexibility(bar))[[1, 2, 3]]


def around(radius: float, x0: float = 0.0):
    """Points on a bore along y."""
    return lambda x: np.hypot(x[0] - x0, x[2]) < radius + 0.02


def test_a_square_bar(tmp_path: Path) -> None:
    length = 82.0
    mesh = meshed(box((0, -7.5, -7.5), (length, 7.5, 7.5)), 6.0, tmp_path)
    end = np.array([length, 0.0, 0.0])
    solid = flexibility(mesh, ALUMINIUM, lambda x: x[0] < 1e-6, lambda x: x[0] > length - 1e-6, end, FORCES_AND_TORQUE)
    shear = ALUMINIUM / 2.6
    bar = beam.Beam((beam.BeamSlice(length, section.rectangle(15.0, 15.0), ALUMINIUM, shear),))
    np.testing.assert_allclose(compared(bar), np.diag(solid), rtol=REQUIRED)
    assert abs(solid[0, 1]) < 1e-3 * solid[0, 0]


def test_an_upper_arm(tmp_path: Path) -> None:
    d = committed()
    a, face = d.arm, d.layers.elbow_boss_mm[1]

    def held(x: np.ndarray) -> np.ndarray:
        """Bore on the shaft, and the sector's face as far as its dowels, between which the arm is clamped."""
        clamped = (x[1] > d.layers.arm_mm[1] - 1e-6) & (np.hypot(x[0], x[2]) < a.dowel_circle_mm / 2)
        return around(a.shaft_bore_mm / 2)(x) | clamped

    solid = flexibility(
        meshed(make_upper_arm(d).solid, 5.0, tmp_path),
        ALUMINIUM,
        held,
        lambda x: (np.abs(x[1]) > face - 1e-6) & (x[0] > a.length_mm / 2),
        np.array([a.length_mm, 0.0, 0.0]),
        FORCES_AND_TORQUE,
    )
    np.testing.assert_allclose(compared(beam_model(d).arm), np.diag(solid), rtol=REQUIRED)


@pytest.mark.slow
@pytest.mark.parametrize(("make", "k"), [(make_encoder_cheek, 0), (make_motor_cheek, 1)])
def test_a_cheek_on_its_block(make, k: int, tmp_path: Path) -> None:
    d = committed()
    shoulder = beam_model(d).shoulder
    assert shoulder is not None
    y, low = shoulder.y_mm[k], d.bracket.base_top_mm
    both = fuse(_shape(make(d)), _shape(make_foot_block(d)))
    outer, width = d.bearing.outer_mm / 2, d.bearing.width_mm / 2

    def seat(x: np.ndarray) -> np.ndarray:
        radius = np.hypot(x[0], x[2])
        return (radius < outer + 0.02) & (radius > outer - FACET_MM) & (np.abs(x[1] - y) < width + 0.02)

    young, _ = moduli_N_mm2("aluminium-6082")
    solid = flexibility(
        meshed(both, 6.0, tmp_path),  # at 10 the mesher folds over itself beside the tips of drills
        young,
        lambda x: x[2] < low + 1e-6,
        seat,
        np.array([0.0, y, 0.0]),
        np.eye(6)[[1]],
    )
    formula = beam.flexibility(shoulder.cheeks[k])[1, 1]
    assert formula == pytest.approx(solid[0, 0], rel=REQUIRED)


@pytest.mark.slow
def test_a_stud_on_its_bar_in_the_elbows_boss(tmp_path: Path) -> None:
    """All of aluminium, so that the bonded ball, which is stiffer, has its share in both computations."""
    d = committed()
    f, table = d.forearm, beam_model(d)
    boss = bore_y(2 * d.arm.boss_radius_mm, (0.0, 0.0), d.layers.elbow_boss_mm)
    at = f.width_mm / 2
    joint = ball(f.ball_diameter_mm, (0.0, at, 0.0), (0.0, 1.0, 0.0))
    solid = flexibility(
        meshed(fuse(_shape(make_cross_bar(d)), boss, joint), 2.0, tmp_path),
        ALUMINIUM,
        lambda x: np.hypot(x[0], x[2]) > d.arm.boss_radius_mm - FACET_MM,
        lambda x: (
            (np.linalg.norm(x - np.array([[0.0], [at], [0.0]]), axis=0) < f.ball_diameter_mm / 2 + 0.02)
            & (x[1] > at - 0.5 * f.ball_diameter_mm / 2)
        ),
        np.array([0.0, at, 0.0]),
        np.eye(6)[[0]],
    )
    shear = ALUMINIUM / 2.6
    slices = (*table.elbow_bar.slices, *table.stud.slices)
    same = [replace(one, youngs_N_mm2=ALUMINIUM, shear_N_mm2=shear) for one in slices]
    assert beam.flexibility(beam.Beam(tuple(same)))[1, 1] == pytest.approx(solid[0, 0], rel=REQUIRED)


@pytest.mark.slow
def test_a_platforms_spoke(tmp_path: Path) -> None:
    d = committed()
    p, table = d.platform, beam_model(d)
    r, end, wide = p.radius_mm, p.boss_length_mm / 2, p.boss_diameter_mm / 2 + 0.1

    def bosses_ends(x: np.ndarray) -> np.ndarray:
        return (np.abs(np.abs(x[1]) - end) < 1e-3) & (np.abs(x[0] - r) < wide) & (np.abs(x[2]) < wide)

    filled = _shape(make_platform(d))
    for i in range(3):  # with its cross-bars
        filled = fuse(filled, turned_to_chain(d, bore_y(p.bar_bore_mm, (r, 0.0), (-end, end)), i))
    solid = flexibility(
        meshed(filled, 7.0, tmp_path),
        ALUMINIUM,
        lambda x: np.hypot(x[0], x[1]) < 2.52,  # the stem's thread
        bosses_ends,
        np.array([r, 0.0, 0.0]),
        np.eye(6)[[2, 3, 4]],
    )
    lift = np.eye(6)
    lift[3, 1], lift[4, 0] = table.spoke_up_mm, -table.spoke_up_mm
    formula = np.diag(lift.T @ beam.flexibility(table.spoke) @ lift)[[2, 3, 4]]
    # vertical, torsion, tilt: 15 % are asked of arm, bracket and joint; of a web with a window, a fifth
    np.testing.assert_allclose(formula, np.diag(solid), rtol=0.2)


def _shape(part: Part) -> cq.Shape:
    return part.solid
