"""A ball joint with its rod's end against finite elements of the parts themselves, the ball free to roll in its cup."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import LINER_GLUE_MM
from delta_cad.dimensions.joint import CUP_MATERIAL, FRICTION, POCKET_MM, POISSON, sliding_torques_N_mm
from delta_cad.solids.forearm import make_cup_shell, make_rod_cup
from delta_cad.solids.primitive import box
from delta_cad.structure.beam_model import beam_model, moduli_N_mm2
from delta_cad.structure.rod_end import SLICES, end_mm_N, section
from tests.delta_cad.dimensions.edited import edited
from tests.delta_cad.structure.machines import committed
from tests.delta_cad.structure.seat_model import Seat, meshed_together

REQUIRED = 0.15
WITHIN_RAD = 0.46  # beyond what the contact reaches at rest
METAL, METAL_POISSON = 70e3, 0.3


def seat_of(d: Dimensions, folder: Path) -> Seat:
    """The end of a rod and its shell, which fills its bond, halved."""
    f = d.forearm
    filled = replace(d, forearm=replace(f, liner_radius_mm=f.liner_radius_mm + LINER_GLUE_MM))
    half = box((-50.0, -50.0, 0.0), (50.0, 50.0, 50.0))
    shapes = [make(of).solid.intersect(half) for make, of in ((make_rod_cup, d), (make_cup_shell, filled))]
    radius = f.seat_diameter_mm / 2

    def size_mm(x: float, y: float, z: float) -> float:
        near = y > 0.0 and sqrt(x * x + y * y + z * z) < filled.forearm.liner_radius_mm + 0.05
        return 0.1 * radius if near and x * x + z * z < (0.5 * radius) ** 2 else 0.4 * radius

    mesh, owner = meshed_together(shapes, size_mm, folder)
    plastic = catalogue.material(CUP_MATERIAL).youngs_modulus_Pa * 1e-6
    moduli = np.array([[METAL, METAL_POISSON], [plastic, POISSON]])[owner]

    def held(x: np.ndarray) -> np.ndarray:
        return (x[0] > f.shoulder_mm + 0.01) & (np.hypot(x[1], x[2]) > 0.8 * f.spigot_diameter_mm / 2)

    return Seat(mesh, moduli, radius, WITHIN_RAD, held)


@pytest.mark.parametrize("ball_mm", [6.0, 8.0])
def test_a_ball_joint_gives_as_its_formula_says(ball_mm: float, tmp_path: Path) -> None:
    """Pushed towards the tube and pulled from it, by a tenth of the preload that closes it."""
    d = committed() if ball_mm == 6.0 else edited(ball_diameter_mm=ball_mm)
    assert d.forearm.ball_diameter_mm == ball_mm
    joint, seat = d.forearm.joint, seat_of(d, tmp_path)
    preload, clearance = joint.preload_N, joint.clearance_mm
    rest = seat.resting_mm(np.array([0.0, preload]), clearance, np.array([0.0, clearance + 1e-3]))
    found = []
    for force in (-0.1 * preload, 0.1 * preload):
        moved = seat.resting_mm(np.array([force, preload]), clearance, rest)
        found.append(force / (moved - rest)[0])
    assert found == pytest.approx([beam_model(d).joint_N_mm] * 2, rel=REQUIRED)
    assert min(found) >= 500.0
    # the contact is a ring about the grease pocket, no wider than the formula has it, and rubs in no longer an arm
    force = seat.forces(rest, clearance)
    off_axis = d.forearm.seat_diameter_mm / 2 * np.sqrt(1.0 - seat.directions[:, 1] ** 2)
    apart, radius = 0.0075, ball_mm / 2
    hertz = (0.75 * preload * radius * (radius + apart) / apart / joint.pair_N_mm2) ** (1 / 3)
    assert off_axis[force > 0.0].max() <= 1.05 * hypot(hertz, POCKET_MM / 2)
    arm = float((force * off_axis).sum() / force.sum())
    assert arm <= sliding_torques_N_mm(ball_mm, np.array(joint.spring_N))[1] / (FRICTION * joint.spring_N)


def test_sections_of_a_rods_end_fill_its_solid() -> None:
    """Volume of what is before the spigot, by sections and by the kernel; the stem's section by hand."""
    f = committed().forearm
    step = f.shoulder_mm / 400
    volume = sum(step * section(f, (k + 0.5) * step)[0] for k in range(400))
    beyond = box((0.0, -50.0, -50.0), (f.shoulder_mm, 50.0, 50.0))
    assert volume == pytest.approx(make_rod_cup(committed()).solid.intersect(beyond).Volume(), rel=0.02)
    area, aside, second = section(f, f.shoulder_mm - 0.5)
    side = f.tube_outer_mm
    assert (area, second) == pytest.approx((side**2, side**4 / 12.0), rel=0.03)
    assert abs(aside) < 0.05


def test_an_end_is_as_stiff_as_its_metal_and_less_so_when_it_is_long() -> None:
    f = committed().forearm
    young, _ = moduli_N_mm2("aluminium-6082")
    assert young == pytest.approx(METAL)
    assert end_mm_N(f, young / 2.0) == pytest.approx(2.0 * end_mm_N(f, young))
    longer = replace(f, shoulder_mm=f.shoulder_mm + 4.0)
    stem = 4.0 / (f.tube_outer_mm**2 * young)
    assert end_mm_N(longer, young) > end_mm_N(f, young) + stem
    assert 1.0 / end_mm_N(f, young) > 5.0 * beam_model(committed()).joint_N_mm
    assert end_mm_N(replace(f, spigot_diameter_mm=2.0), young) == pytest.approx(
        end_mm_N(f, young) + (4.0 / (pi * 2.0) - 4.0 / (pi * f.spigot_diameter_mm)) / young
    )
    assert SLICES >= 20
