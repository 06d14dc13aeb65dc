"""The three steps as problems, and the worst points of a cube."""

from __future__ import annotations

import math

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, cube_extremes, cube_grid, rod_lean
from delta_cad.mechanism.limits import HandleFriction, HandleInertia
from delta_cad.mechanism.limits.couple_index import couple_index
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.limits.friction import friction
from delta_cad.mechanism.limits.position_step import position_step
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.problem.evaluator import half_surface
from optimizer.problem.extremes import design_worst, worst_points
from optimizer.problem.step import CONSTRAINTS, ProblemError, outline_of, step_problem
from optimizer.problem.variables import VARIABLES
from tests.optimizer.messages import refuses
from tests.optimizer.tasks import INERTIA, JOINTS, sample_points, task

PUBLISHED = np.array([82, 112.079, 40, 30, 57.112, 35])


def test_only_variables_whose_bounds_differ_are_free() -> None:
    problem = step_problem(task(), 1)
    assert problem.free == ("forearm_length", "platform_radius", "bottom_height", "half_side")
    assert step_problem(task(half_side_mm=35), 3).free == ("forearm_length", "platform_radius", "bottom_height")


def test_scaling_goes_to_the_bounds_and_back() -> None:
    problem = step_problem(task(), 1)
    designs = problem.designs(np.array([[0.0] * 4, [1.0] * 4, [0.25, 0.5, 0.75, 0.1]])) * 1000.0
    np.testing.assert_allclose(designs[0, :6], [82, 40, 40, 20, 40, 0], rtol=1e-15)
    np.testing.assert_allclose(designs[1, :6], [82, 130, 40, 45, 100, 100], rtol=1e-15)
    np.testing.assert_array_equal(designs[:, 6:], [[0.0, -500.0, 0.0]] * 3)  # three-fold symmetric
    np.testing.assert_allclose(problem.scaled(designs[2]), [0.25, 0.5, 0.75, 0.1], atol=1e-14)
    np.testing.assert_array_equal(problem.scaled(np.array([82, 500, 40, 1, 70, 50])), [1.0, 0.0, 0.5, 0.5])


ABSENT = ("holding_torque", "balls", "elbow_outside", "height")
"""A synthesis has no build yet, these bounds keep what every design is held to, and no height is stated."""


def test_a_height_is_a_constraint_of_every_step_and_counts_what_parts_take() -> None:
    given = task(limits={"height_beyond_mm": 120.0})
    high = given.model_copy(update={"requirements": given.requirements.model_copy(update={"height_max_mm": 300.0})})
    assert "height" not in step_problem(given, 2).constraints
    for step in (1, 2):
        problem = step_problem(high, step, 40.0)
        assert "height" in problem.constraints
        lengths = np.array([[82.0, 112.0, 40.0, 30.0, 100.0, 40.0], [82.0, 112.0, 40.0, 30.0, 101.5, 40.0]])
        margin = problem.design_margins(lengths / 1e3)["height"]
        assert margin == pytest.approx([0.0, -1.5 / 300.0])
    assert "requirements.height_max_mm" in step_problem(high, 2).describe("height")
    assert "limits.height_beyond_mm = 120 mm" in step_problem(high, 2).describe("height")


def test_steps_ask_what_the_paper_asks_and_the_limits_join_from_step_2() -> None:
    limits = {
        "outline_radius_max_mm": 122,
        "kappa_max": 3,
        "lean_max_deg": 28,
        "elbow_angle_min_deg": 40,
        "shoulder_deg": [-45, 80],
        "clearance_min_mm": 2,
        "effective_mass_max_kg": 0.4,
        "friction_max_N": 0.7,
        "position_step_max_mm": 0.1,
        "couple_index_min": 0.4,
    }
    given = task(limits=limits, half_side=(10, 100), inertia=INERTIA, joints=JOINTS)
    assert step_problem(given, 1).constraints == ("outline", "reach", "half_side")
    without_masses = tuple(name for name in CONSTRAINTS if name not in ABSENT)
    assert step_problem(given, 2).constraints == without_masses
    assert step_problem(task(), 2).constraints == ("outline", "reach", "assembly_mode", "torque")
    assert step_problem(given, 2, without=frozenset({"torque", "half_side"})).constraints == tuple(
        name for name in without_masses if name not in ("torque", "half_side")
    )
    assert step_problem(given, 2, without=frozenset({"half_side"})).lower[5] == 0.0


def test_what_a_step_reaches_bounds_the_next() -> None:
    assert step_problem(task(), 2, 64.2).upper[5] == 64.2
    assert step_problem(task(half_side=(70, 100)), 2, 64.2).upper[5] == 70
    third = step_problem(task(), 3, 62.0)
    assert (third.lower[5], third.upper[5]) == (62.0, 62.0)
    assert step_problem(task(half_side_mm=35), 3, 62.0).upper[5] == 35.0


def test_steps_and_constraints_that_do_not_exist_are_refused() -> None:
    with refuses(ProblemError, "4", "1", "2", "3"):
        step_problem(task(), 4)
    with pytest.raises(ProblemError, match="'speed'"):
        step_problem(task(), 1, without=frozenset({"speed"}))
    with refuses(ProblemError, "3", "step_3.half_side_mm", "2"):
        step_problem(task(), 3)
    with refuses(ProblemError, "3", "0"):
        step_problem(task(), 3, 0.0)


def margins_at(problem, design_mm: np.ndarray, n: int = 21) -> dict[str, float]:
    designs = design_mm[None] / 1000.0
    f = problem.figures(designs, sample_points(designs, n))
    found = {name: float(m.min()) for name, m in problem.point_margins(f).items()}
    return found | {name: float(m[0]) for name, m in problem.design_margins(designs).items()}


def test_margins_vanish_where_the_figures_of_the_mechanism_meet_their_limits() -> None:
    """Limits set to what `cube_extremes`, another search on other formulas, finds for the published design."""
    L_A, L_B, R, r, H, L = PUBLISHED / 1000.0
    g, cube = DeltaGeometry(R, r, L_A, L_B), Cube(H, L)
    e = cube_extremes(g, cube, 3.0, 21)
    limits = {
        "outline_radius_max_mm": 122.0,
        "kappa_max": e.kappa_max.value,
        "lean_max_deg": math.degrees(e.lean_max.value),
        "shoulder_deg": [math.degrees(e.shoulder_min.value), math.degrees(e.shoulder_max.value)],
        "elbow_angle_min_deg": 180.0 - math.degrees(e.forearm_angle_max.value),
        "clearance_min_mm": math.sqrt(3.0) * 30.0 - 24.0 - 8.0,
        "gravity_torque_N_m": 0.1,
    }
    masses = HandleInertia(*INERTIA.values())
    heaviest = CubeSearch(cube)(lambda p: effective_mass(g, p, masses), -1.0).value
    limits["effective_mass_max_kg"] = heaviest
    limits["couple_index_min"] = CubeSearch(cube)(lambda p: couple_index(g, p), 1.0).value
    sources, count = HandleFriction(*list(JOINTS.values())[:3]), math.radians(JOINTS["encoder_count_deg"])
    limits["friction_max_N"] = CubeSearch(cube)(lambda p: friction(g, p, sources), -1.0).value
    limits["position_step_max_mm"] = 1000.0 * CubeSearch(cube)(lambda p: position_step(g, p, count), -1.0).value
    problem = step_problem(task(limits=limits, torque=e.torque_max.value + 0.1, inertia=INERTIA, joints=JOINTS), 2)
    found = margins_at(problem, PUBLISHED)
    # the grid misses an extreme between its points by (step / 2)^2 of the curvature: 0.1 %
    searched = ("torque", "kappa", "shoulder", "effective_mass", "friction", "position_step", "couple_index")
    searched += ("elbow_angle",)
    for name in (*searched, "lean", "clearance", "outline"):
        assert abs(found[name]) < 1e-3, name
    found = design_worst(problem, PUBLISHED / 1000.0, 9)
    # polished to 1e-5 of L; `cube_extremes` to 2^-22 of its step
    for name in searched:
        assert abs(found[name].values[0]) < 1e-8, name


def test_lean_in_closed_form_is_that_of_the_corners() -> None:
    L_A, L_B, R, r, H, L = PUBLISHED / 1000.0
    lean = np.abs(rod_lean(DeltaGeometry(R, r, L_A, L_B), cube_grid(Cube(H, L), 2))).max()
    problem = step_problem(task(limits={"lean_max_deg": math.degrees(lean)}), 2)
    # one sine there and back: a few roundings
    assert abs(problem.design_margins(PUBLISHED[None] / 1000.0)["lean"][0]) < 1e-14


def test_outline_of_the_paper_is_exact_in_both_readings() -> None:
    """W = 270, D = 220 with L_c = 85.4 mm, or turned with L_c = 17.4 mm, allows R + L_A = 122 and no more."""
    straight = task(limits={"parallelogram_width_mm": 85.4})
    margin, turned = outline_of(straight).room(np.array([121.9, 122.1]))
    assert margin[0] > 0 > margin[1]
    assert not turned[0]
    # 35 mm more along the depth forbid the straight reading: 17.4 / 2 + sqrt(3) 122 = 220.01 decides
    turned_only = task(limits={"parallelogram_width_mm": 17.4, "outline_overhead_mm": [0.0, 35.0]})
    margin, turned = outline_of(turned_only).room(np.array([121.9, 122.1]))
    assert turned.all()
    assert margin[0] > 0 > margin[1]
    half = task(limits={"parallelogram_width_mm": 54, "outline_overhead_mm": [11, 11]})
    half = outline_of(half).room(np.array([122]))
    assert half[0][0] == pytest.approx((220 - (54 * math.sqrt(3) / 4 + 183 + 11)) / 220, rel=1e-14)


HIDDEN = np.array([82, 94.266, 40, 40 - 16.122, 22.648, 43.363])
"""Eight good corners (kappa <= 6.03) and a determinant of the other sign at the bottom centre."""


def test_a_singularity_hidden_behind_good_corners_is_caught() -> None:
    problem = step_problem(task(limits={"kappa_max": 7.0}, torque=50.0), 2)
    designs = HIDDEN[None] / 1000.0
    corners = problem.point_margins(problem.figures(designs, half_surface(2)))
    assert corners["kappa"].min() > 0
    assert corners["torque"].min() > 0
    found = margins_at(problem, HIDDEN, 5)
    assert found["torque"] < 0
    assert found["kappa"] < 0


def test_a_platform_below_its_elbows_is_refused_though_it_is_well_conditioned() -> None:
    problem = step_problem(task(), 2)
    f = problem.figures(PUBLISHED[None] / 1000.0, half_surface(3))
    assert (problem.point_margins(f)["torque"] > 0).all()
    assert (problem.point_margins(f._replace(determinant=-f.determinant))["torque"] < 0).all()


def test_the_centre_is_sampled() -> None:
    points = sample_points(PUBLISHED[None] / 1000.0, 3)[0]
    assert (np.abs(points) < 1.0).all(axis=1).any()


def test_worst_points_find_a_minimum_between_the_grid_points_and_stay_on_their_face() -> None:
    spot = np.array([0.137, 0.411, 1.0])

    def margins(points: np.ndarray) -> dict[str, np.ndarray]:
        return {"bowl": ((points - spot) ** 2).sum(axis=1), "slope": points[:, 0]}

    found = worst_points(margins, 5)
    np.testing.assert_allclose(found["bowl"].points[0], spot, atol=1e-4)
    assert found["bowl"].values[0] < 1e-8
    assert found["slope"].values[0] == -1.0
    assert (np.diff(found["bowl"].values) >= 0).all()
    top = [p for p in found["bowl"].points if p[2] == 1.0]
    assert len(top) >= 2


def test_every_constraint_is_described_with_its_field() -> None:
    limits = {
        "kappa_max": 3,
        "lean_max_deg": 28,
        "shoulder_deg": [-45, 80],
        "clearance_min_mm": 2,
        "gravity_torque_N_m": 0.1,
        "effective_mass_max_kg": 0.4,
        "friction_max_N": 0.7,
        "position_step_max_mm": 0.1,
        "couple_index_min": 0.35,
        "elbow_angle_min_deg": 35,
    }
    problem = step_problem(task(limits=limits, half_side=(10, 100), inertia=INERTIA, joints=JOINTS), 2)
    words = {name: problem.describe(name) for name in problem.constraints}
    assert words["outline"] == "outline 270 x 220 mm (requirements.envelope_*_mm)"
    assert words["torque"] == "0.7 N m for 3 N (requirements.joint_torque_N_m)"
    assert words["kappa"] == "limits.kappa_max = 3.0"
    assert words["effective_mass"] == "limits.effective_mass_max_kg = 0.4"
    assert words["friction"] == "limits.friction_max_N = 0.7"
    assert words["position_step"] == "limits.position_step_max_mm = 0.1"
    assert words["couple_index"] == "limits.couple_index_min = 0.35"
    assert words["elbow_angle"] == "limits.elbow_angle_min_deg = 35.0"
    assert words["shoulder"] == "limits.shoulder_deg = [-45, 80]"
    assert words["half_side"] == "bounds_mm.half_side >= 10 mm"
    assert step_problem(task(half_side_mm=35), 3).describe("half_side") == "step_3.half_side_mm = 35 mm"
    assert step_problem(task(), 3, 50.0).describe("half_side") == "half side that step 2 reached"
    assert step_problem(task(), 1).describe("outline") == "R + L_A <= 122 mm (limits.outline_radius_max_mm)"


def test_names_are_those_of_the_requirements_file() -> None:
    assert {*type(task().bounds_mm).model_fields, "side_cosine"} == set(VARIABLES)
