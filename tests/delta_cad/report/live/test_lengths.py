"""The live page's mechanism: its skeleton closes, its cube is a cube, its figures are the mechanism's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.design import Design, design_from_dict
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.statics import conditioning
from delta_cad.report.live.lengths import Lengths, readings, skeleton
from tests.designs import placed

INERTIA = HandleInertia(0.071, 0.0043, 0.0011, 3.1e-4)
WIDTH_MM = 54.0


@pytest.fixture
def lengths(best: Design) -> Lengths:
    return Lengths.of(best)


def long(lines: np.ndarray) -> np.ndarray:
    return np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)


@pytest.mark.parametrize("share", [(0.0, 0.0, 0.0), (0.9, -0.4, 1.0), (-1.0, 1.0, -1.0)])
def test_lines_are_as_long_as_the_parts_they_stand_for(lengths: Lengths, share: tuple[float, ...]) -> None:
    p = lengths.centre_mm + lengths.half_side_mm * np.array(share)
    lines = skeleton(lengths, WIDTH_MM, p)
    assert long(lines["arms"]) == pytest.approx([lengths.upper_arm_length_mm] * 3)
    assert long(lines["rods"])[:6] == pytest.approx([lengths.forearm_length_mm] * 6)
    assert long(lines["rods"])[6:] == pytest.approx([WIDTH_MM] * 6)
    assert long(lines["base"]) == pytest.approx([np.sqrt(3.0) * lengths.base_radius_mm] * 3)
    assert lines["platform"][3:, 1] == pytest.approx(np.tile(p, (3, 1)))
    assert long(lines["platform"])[3:] == pytest.approx([lengths.platform_radius_mm] * 3)
    theta = inverse_kinematics(lengths.geometry, p / 1000.0)
    rise = lines["arms"][:, 1, 2] - lines["arms"][:, 0, 2]
    assert rise == pytest.approx(lengths.upper_arm_length_mm * np.sin(theta))
    middles = lines["rods"][:6].reshape(3, 2, 2, 3).mean(axis=1)[:, 0]
    assert middles == pytest.approx(lines["arms"][:, 1])


def test_the_cube_has_twelve_edges(lengths: Lengths) -> None:
    edges = lengths.cube_edges()
    assert long(edges) == pytest.approx([2.0 * lengths.half_side_mm] * 12)
    assert len({tuple(np.round(edge.mean(axis=0), 6)) for edge in edges}) == 12
    assert edges.mean(axis=(0, 1)) == pytest.approx(lengths.centre_mm)


def test_the_handle_stays_in_the_cube(lengths: Lengths) -> None:
    half, (x, y, z) = lengths.half_side_mm, lengths.centre_mm
    assert lengths.within(np.array([500.0, -7.0, -500.0])) == pytest.approx([x + half, -7.0, z - half])
    assert lengths.within(lengths.centre_mm) == pytest.approx([x, y, z])


def test_figures_are_the_mechanisms(lengths: Lengths) -> None:
    p = lengths.centre_mm + np.array([10.0, -20.0, 5.0])
    found = {reading.words: reading for reading in readings(lengths, 3.0, INERTIA, p)}
    g, over = lengths.geometry, lengths.positions_mm() / 1000.0
    assert float(found["conditioning"].here) == pytest.approx(float(conditioning(g, p / 1000.0)), rel=1e-3)
    assert float(found["conditioning"].worst) == pytest.approx(float(conditioning(g, over).max()), rel=1e-3)
    mass = float(effective_mass(g, over, INERTIA).max())
    assert found["effective mass"].worst == f"{mass:.4g} kg"
    theta = np.degrees(inverse_kinematics(g, p / 1000.0))
    assert [float(v) for v in found["shoulders"].here.removesuffix(" deg").split(", ")] == pytest.approx(
        theta, rel=1e-3
    )
    assert "effective mass" not in {reading.words for reading in readings(lengths, 3.0, None, p)}


def test_out_of_reach_is_reported(lengths: Lengths) -> None:
    short = replace(lengths, forearm_length_mm=80.0)  # the centre, not the corners
    assert not short.reaches(short.positions_mm())
    assert {r.worst for r in readings(short, 3.0, None, short.centre_mm)} == {"out of reach"}
    assert readings(short, 3.0, None, np.array([0.0, 0.0, 900.0])) == []


def test_the_mechanism_of_a_placed_design_keeps_its_placement() -> None:
    design = design_from_dict(placed())
    lengths = Lengths.of(design)
    assert lengths.geometry == design.geometry
    assert lengths.centre_mm == pytest.approx([11.1, 0.0, 119.7])
    lines = skeleton(lengths, WIDTH_MM, lengths.centre_mm)
    assert np.linalg.norm(lines["arms"][:, 0], axis=1) == pytest.approx([30.8, 38.45, 38.45])
    assert np.degrees(np.arctan2(*lines["arms"][:, 0, 1::-1].T)) == pytest.approx([0.0, 116.3, -116.3])
    assert long(lines["rods"])[:6] == pytest.approx([148.4] * 6)
