"""Figures of placed designs, against the mechanism's own functions and trigonometry in NumPy; their files."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import design_from_dict
from delta_cad.mechanism import closure_margin, conditioning, direct_margin, joint_angles, worst_joint_torque
from delta_cad.mechanism.limits import LIMITS, HandleInertia
from delta_cad.mechanism.limits.friction import HandleFriction
from optimizer.problem.evaluator import figures, half_surface
from optimizer.problem.requirements import requirements_hash
from optimizer.problem.step import step_problem
from optimizer.problem.variables import (
    PER_SI,
    VARIABLES,
    azimuth_deg,
    completed,
    design_fields,
    mechanism_of,
    named,
    variables_mm,
)
from tests.optimizer.placed_task import FREE, joystick_task
from tests.optimizer.problem.figures_numpy import figures_numpy
from tests.optimizer.problem.requirements import first_edition, lines_of_requirements
from tests.optimizer.tasks import sample_points

LOW = np.array([75.0, 130.0, 30.0, 20.0, 55.0, 20.0, -8.0, -0.75, -15.0])
HIGH = np.array([100.0, 170.0, 45.0, 28.0, 90.0, 42.0, 12.0, -0.1, 15.0])


def random_designs(count: int, seed: int) -> np.ndarray:
    """(count, 9) designs about the joystick's, SI units; the first as far from symmetric as the bounds go."""
    u = np.random.default_rng(seed).random((count, 9))
    u[0, 6:] = 1.0
    return (LOW + (HIGH - LOW) * u) / PER_SI


def test_compiled_figures_of_placed_designs_are_those_of_trigonometry() -> None:
    designs = random_designs(100, 1)
    points = sample_points(designs, 5)
    a, b = figures(designs, points), figures_numpy(designs, points)
    assert (b.closure < 0.0).any()
    for name, x, y in zip(a._fields[:6], a, b, strict=False):
        close = np.isclose(x, y, rtol=1e-11, atol=1e-12 if name != "quality" else 1e-7)
        assert close.all(), (name, np.abs(x - y)[~close])
    far = b.closure > 1e-3
    masses = HandleInertia(carried_mass=0.09, elbow_mass=0.011, cross_mass=0.004, joint_inertia=2.9e-4)
    sources = HandleFriction(0.01, 0.12, 0.18)
    for x, y in (
        (a.couple_index(), b.couple_index()),
        (a.inverse_friction(sources), b.inverse_friction(sources)),
        (a.mass_ratio(masses), b.mass_ratio(masses)),
        (a.scaled_step(), b.scaled_step()),
    ):
        np.testing.assert_allclose(x[far], y[far], rtol=1e-9, atol=1e-12)


def test_figures_of_placed_designs_are_those_of_the_mechanism() -> None:
    points, compared = half_surface(4), 0
    for design in random_designs(20, 2):
        f = figures(design[None], points)
        if f.closure.min() <= 1e-6 or f.determinant.min() <= 0.0:
            continue
        g, cube = mechanism_of(design * PER_SI)
        p = cube.centre + cube.half_side * points
        np.testing.assert_allclose(f.closure[0], closure_margin(g, p).min(axis=-1) / g.forearm_length**2, atol=1e-13)
        np.testing.assert_allclose(f.determinant[0], direct_margin(g, p), atol=1e-13)
        torque = 3.0 * f.moment[0] / f.determinant[0]
        np.testing.assert_allclose(torque, worst_joint_torque(g, p, 3.0).max(axis=-1), rtol=1e-10)
        np.testing.assert_allclose(1.0 / f.quality[0], conditioning(g, p), rtol=1e-9)
        np.testing.assert_allclose(f.shoulder_min[0], joint_angles(g, p).min(axis=-1), atol=1e-12)
        compared += 1
    assert compared > 5


def test_reach_of_placed_designs_on_the_coarsest_sample_is_that_of_the_finest() -> None:
    designs = random_designs(300, 3)
    coarse = figures(designs, sample_points(designs, 3), conditioning=False).closure.min(axis=1)
    fine = figures(designs, half_surface(25), conditioning=False).closure.min(axis=1)
    assert ((coarse >= 0) <= (fine >= 0)).all()
    assert 20 < (coarse >= 0).sum() < 280


def test_folds_of_placed_designs_are_the_angles_between_arms_and_rods() -> None:
    designs = random_designs(40, 4)
    points = sample_points(designs, 5)
    f, low = figures(designs, points), []
    for design, own in zip(designs, points, strict=True):
        g, cube = mechanism_of(design * PER_SI)
        p = cube.centre + cube.half_side * own
        wrists = p[:, None] + g.platform_radius * g.radial - g.base_radii[:, None] * g.radial
        squares = (wrists**2).sum(axis=-1).min(axis=-1)
        la, lb = g.upper_arm_length, g.forearm_length
        low.append((squares - la * la - lb * lb) / (2.0 * la * lb))
    np.testing.assert_allclose(f.folds(), low, atol=1e-12)


def test_six_variables_are_the_symmetric_nine() -> None:
    six = np.array([[82.0, 112.079, 40.0, 30.0, 57.112, 35.0]]) / 1000.0
    nine = completed(six)
    np.testing.assert_array_equal(nine[0, 6:], [0.0, -0.5, 0.0])
    points = half_surface(5)
    assert all(np.array_equal(x, y) for x, y in zip(figures(six, points), figures(nine, points), strict=True))


def test_design_file_has_the_placement_only_where_there_is_one() -> None:
    symmetric = (82.0, 112.079, 40.0, 30.0, 57.112, 35.0)
    mechanism, cube = design_fields(symmetric)
    assert {*mechanism, *cube}.isdisjoint({"azimuths_deg", "base_radii_mm", "centre_x_mm"})
    assert "azimuth_deg" not in named(symmetric)
    placed = (*symmetric, 7.25, float(np.cos(np.radians(116.3))), 11.125)
    mechanism, cube = design_fields(placed)
    assert mechanism["azimuths_deg"] == [0.0, 116.3, -116.3]
    assert mechanism["base_radii_mm"] == [40.0, 47.25, 47.25]
    assert cube["centre_x_mm"] == 11.125
    assert variables_mm(mechanism, cube) == pytest.approx(placed, abs=1e-12)
    data = {
        "schema": "delta-design/1",
        "name": "p",
        "mechanism": mechanism | {"parallelogram_width_mm": 40.0},
        "cube": cube,
    }
    task = {"envelope_width_mm": 300.0, "envelope_depth_mm": 260.0, "force_N": 3.0, "joint_torque_N_m": 0.8}
    design = design_from_dict(data | {"requirements": task}, "p.json")
    g, own = mechanism_of(placed)
    assert design.geometry.base_radii == pytest.approx(g.base_radii, abs=1e-15)
    assert design.geometry.side_cosine == pytest.approx(g.side_cosine, abs=1e-15)
    assert design.workspace == own
    assert named(placed)["azimuth_deg"] == pytest.approx(116.3)


def test_bounds_free_the_placement_and_are_fixed_without_them() -> None:
    symmetric, free = step_problem(joystick_task(), 2), step_problem(joystick_task(FREE), 2)
    assert symmetric.symmetric
    assert not free.symmetric
    assert free.free == (*symmetric.free, "side_shift", "side_cosine", "centre_x")
    assert [azimuth_deg(x[VARIABLES.index("side_cosine")]) for x in (free.upper, free.lower)] == pytest.approx(
        [95, 140]
    )
    exact = step_problem(joystick_task({"bounds_deg": {"azimuth": [120, 130]}}), 2)
    assert exact.upper[VARIABLES.index("side_cosine")] == -0.5
    fixed = step_problem(joystick_task({"bounds_mm": {"centre_x": [4, 4]}}), 2)
    assert fixed.free == symmetric.free
    assert not fixed.symmetric
    assert requirements_hash(joystick_task()) != requirements_hash(joystick_task(FREE))


@pytest.mark.parametrize(
    ("table", "field", "value", "words"),
    [
        ("bounds_deg", "azimuth", [50, 130], ">= 60"),
        ("bounds_deg", "azimuth", [130, 100], "swapped"),
        ("bounds_mm", "centre_x", [3, -3], "swapped"),
        ("bounds_mm", "side_shift", [-50, 3], "> -40 mm"),
        ("bounds_mm", "side_shift", 3, "two numbers"),
        ("bounds_deg", "phi", [100, 130], "azimuth"),
    ],
)
def test_a_placement_that_is_none_is_refused(table: str, field: str, value: object, words: str) -> None:
    data = first_edition()
    data[table] = data.get(table, {}) | {field: value}
    (line,) = lines_of_requirements(data)
    assert f"{table}.{field}" in line
    assert words in line


def test_smooth_parts_have_the_margin_as_their_least() -> None:
    designs = random_designs(200, 6)
    rows = designs.T * PER_SI[:, None]
    values, seen = joystick_task(FREE).values, 0
    for limit in LIMITS:
        stated = limit.stated(values)
        margin = None if stated is None else stated.design_margin(rows)
        if stated is None or margin is None:
            continue
        parts = stated.smooth_margins(rows)
        assert parts is not None
        np.testing.assert_allclose(parts.min(axis=0), margin, atol=1e-14)
        seen += len(parts) > 1
    assert seen >= 3
