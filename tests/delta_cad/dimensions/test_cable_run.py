"""The cable as a line in space, drawn by its definition: it stays in its grooves, of one length, at every angle."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.dimensions.cable_run import CableRun, groove_pitch_mm

STUDY = CableRun(40.0, 40.0 / 4.3, 1.0, 0.7, 4, np.radians(127.0), 0.2)
RUNS = [
    CableRun(rs, rs / ratio, 1.0, groove_pitch_mm(d), 4, np.radians(stroke), 0.2)
    for rs in (30.0, 40.0, 60.0)
    for ratio in (3.0, 4.3, 6.0, 12.0)
    for d in (0.45, 0.54, 0.8)
    for stroke in (80.0, 127.0, 150.0)
]


def path(run: CableRun, turned: float, steps: int = 4000) -> np.ndarray:
    """(n, 3) points of the cable from end to end: line of centres along x, axes along z, the arm turned by an angle."""
    half = run.stroke_rad / 2 + run.beyond_rad + turned  # on the rim, of the strand that grows longer
    other = run.stroke_rad / 2 + run.beyond_rad - turned
    psi, a = run.tangent_rad, run.centre_distance_mm
    angle = np.linspace(psi + half, psi, steps)
    first = run.sector_mm * np.column_stack([np.cos(angle), np.sin(angle)])
    angle = np.pi + psi + np.linspace(0.0, run.wrap_rad, steps)
    middle = np.array([a, 0.0]) + run.pinion_mm * np.column_stack([np.cos(angle), np.sin(angle)])
    angle = np.linspace(-psi, -psi - other, steps)
    last = run.sector_mm * np.column_stack([np.cos(angle), np.sin(angle)])
    flat = np.concatenate([first, middle, last])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0), axis=1))])
    return np.column_stack([flat, run.lug_mm - run.climb * way])


@pytest.mark.parametrize("run", RUNS[::7])
def test_the_cable_keeps_its_length_and_ends_at_the_other_lug(run: CableRun) -> None:
    for turned in np.linspace(-run.stroke_rad / 2, run.stroke_rad / 2, 5):
        points = path(run, float(turned))
        assert np.linalg.norm(np.diff(points, axis=0), axis=1).sum() == pytest.approx(run.length_mm(), rel=1e-5)
        assert points[-1, 2] == pytest.approx(-run.lug_mm, abs=1e-4)


@pytest.mark.parametrize("run", RUNS[::7])
def test_strands_are_tangents_and_take_off_where_they_are_said_to(run: CableRun) -> None:
    turned = 0.3 * run.stroke_rad
    points = path(run, turned)
    leaves, arrives = points[3999], points[4000]
    assert np.linalg.norm((arrives - leaves)[:2]) == pytest.approx(run.free_mm)
    for point, centre in ((leaves, np.zeros(2)), (arrives, np.array([run.centre_distance_mm, 0.0]))):
        assert (arrives - leaves)[:2] @ (point[:2] - centre) == pytest.approx(0.0, abs=1e-9)
    assert run.take_off_mm(turned) == pytest.approx((arrives[2], points[7999][2]), abs=1e-5)
    assert run.fleet_rad(turned, (run.lug_mm, -run.lug_mm)) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_the_take_offs_walk_the_same_way_and_neighbouring_turns_keep_the_pitch() -> None:
    run = STUDY
    low, high = run.take_off_mm(-run.stroke_rad / 2), run.take_off_mm(run.stroke_rad / 2)
    assert low[0] - high[0] == pytest.approx(run.walk_mm)
    assert low[1] - high[1] == pytest.approx(run.walk_mm)
    wound = path(run, 0.0)[4000:8000]
    turn = int(4000 * 2 * np.pi / run.wrap_rad)
    assert wound[0, 2] - wound[turn, 2] == pytest.approx(run.pitch_mm, rel=1e-3)
    assert run.grooved_mm == pytest.approx(np.ptp([*low, *high]) + 2 * run.pitch_mm)


def test_a_lug_off_by_its_tolerance_has_the_largest_angle_at_the_near_stop() -> None:
    run = STUDY
    off = run.lug_tolerance_mm()
    angles = [
        max(np.abs(run.fleet_rad(t, (run.lug_mm + off, -run.lug_mm))))
        for t in np.linspace(-run.stroke_rad / 2, run.stroke_rad / 2, 101)
    ]
    assert max(angles) + run.lead_rad == pytest.approx(np.radians(2.5), rel=0.01)
    assert int(np.argmax(angles)) == 0


def test_the_study_s_figures() -> None:
    """Worked by hand beforehand: RE 30, 4.3:1, 0.54 mm cable; there the spread counted whole turns."""
    run = STUDY
    assert run.free_mm == pytest.approx(9.98, abs=0.005)
    assert np.degrees(run.tangent_rad) == pytest.approx(11.4, abs=0.05)
    assert np.degrees(run.lead_rad) == pytest.approx(0.69, abs=0.005)
    assert run.walk_mm == pytest.approx(1.06, abs=0.005)
    assert run.middle_mm == pytest.approx(62.3, abs=0.05)
    assert run.lug_mm == pytest.approx(2.15, abs=0.03)
    assert run.lug_tolerance_mm() == pytest.approx(0.57, abs=0.01)
    rim = run.stroke_rad + 2 * run.beyond_rad + 2 * run.tangent_rad
    assert np.degrees(rim) == pytest.approx(173.0, abs=0.5)


def test_a_pitch_is_one_that_a_lathe_cuts() -> None:
    assert [groove_pitch_mm(d) for d in (0.45, 0.54, 0.8, 3.0)] == [0.6, 0.7, 1.0, 3.75]


def test_stiffness_is_that_of_two_springs_of_the_strands_lengths() -> None:
    run = STUDY
    at = 0.5
    lengths = [run.middle_mm + s * run.sector_mm * at for s in (1, -1)]
    assert run.stiffness_N_mm(9000.0, at) == pytest.approx(sum(9000.0 / length for length in lengths))
    assert run.stiffness_N_mm(9000.0, 0.0) == min(run.stiffness_N_mm(9000.0, t) for t in np.linspace(-1.0, 1.0, 21))
