"""SLSQP on active points: closed forms, a brute-force grid, gradients, every way a start can end."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar

from optimizer.problem.extremes import design_worst
from optimizer.problem.step import SIDE, Problem, step_problem
from optimizer.search import sqp
from optimizer.search.active_set import DIFFERENCE, SLACK, Active, Program
from tests.optimizer.tasks import sample_points, task


def solved(problem: Problem, starts: int = 2) -> tuple[float, np.ndarray]:
    """Objective (mm or kappa) and design (mm) of the best start."""
    best = sqp.search(problem, sqp.start_points(problem, 0, starts)).best
    assert best is not None
    design = problem.designs(np.array(best.x)[None])[0] * 1000.0
    return (1.0 / best.level if problem.step == 3 else design[SIDE]), design


def largest_half_side(L_A: float, L_B: float, a: float, H: float) -> float:
    """Closed form of step 1 for L_B >= L_A and |a| <= L, README (4), (21) of the mechanism.

    The cube's bottom face must clear the hole of each chain, rho >= L_B - L_A at t = 0; its nearest point has rho = H,
    so H >= L_B - L_A. What is too far begins in a top corner: t^2 + (rho - L_A)^2 = L_B^2 with rho^2 = (u - a)^2 +
    (H + 2 L)^2. Chain 1 sees the corners at t = L (sin 60 + cos 60), u = +-L (sin 60 - cos 60) and the other way round;
    chain 0 at u, t = +-L.
    """
    if H < L_B - L_A:
        return 0.0
    long, short = (math.sqrt(3.0) + 1.0) / 2.0, (math.sqrt(3.0) - 1.0) / 2.0
    corners = [(s * u, t) for u, t in ((short, long), (long, short), (1.0, 1.0)) for s in (-1.0, 1.0)]

    def excess(L: float) -> float:
        return max((t * L) ** 2 + (math.hypot(u * L - a, H + 2.0 * L) - L_A) ** 2 for u, t in corners) - L_B**2

    return brentq(excess, 0.0, 200.0, xtol=1e-12)


# near tables 4, 6 and 9, micrometres clear of the fold: L_B, r, H, and what the half side is by two other computations
PUBLISHED = [(130.0, 40.0, 48.001, 64.2015), (163.023, 39.717, 81.03, 67.155), (142.0, 40.0, 60.0, 65.425)]


@pytest.mark.parametrize(("L_B", "r", "H", "half_side"), PUBLISHED)
def test_step_1_at_the_published_designs_is_the_closed_form(L_B: float, r: float, H: float, half_side: float) -> None:
    problem = step_problem(task((L_B, L_B), (r, r), (H, H)), 1)
    assert problem.free == ("half_side",)
    found, _ = solved(problem, 1)
    assert found == pytest.approx(largest_half_side(82.0, L_B, 40.0 - r, H), rel=1e-6)  # SLACK of 1e-8, times slopes
    assert found == pytest.approx(half_side, rel=1e-4)  # five digits were noted


@pytest.mark.parametrize(
    ("forearm", "platform", "height", "published"),
    [((82, 130), (20, 45), (40, 100), 64.2), ((1, 142), (30, 50), (40, 60), 65.4)],
    ids=["table 4", "table 9"],
)
def test_step_1_is_the_papers(forearm, platform, height, published: float) -> None:
    found, design = solved(step_problem(task(forearm, platform, height), 1))
    assert found == pytest.approx(published, rel=3e-3)
    # the optimum lies on the fold, H = L_B - L_A, with r = R, at the longest forearm
    assert design[4] == pytest.approx(design[1] - design[0], abs=1e-3)
    assert design[3] == pytest.approx(40.0, abs=0.01)
    assert design[1] == pytest.approx(forearm[1], abs=1e-3)
    # no height and no radius difference does better in the closed form
    best = max(
        largest_half_side(82.0, forearm[1], a, H)
        for a in np.linspace(-10, 10, 41)
        for H in np.linspace(forearm[1] - 82.0, forearm[1] - 72.0, 41)
    )
    assert found == pytest.approx(best, rel=1e-6)


def test_step_1_of_table_6_beats_the_published_design() -> None:
    """The paper's GA stopped at L_B = 163.023 with 67.16; up to 170 mm the closed form still rises."""
    found, design = solved(step_problem(task((40, 170)), 1))
    best = minimize_scalar(
        lambda L_B: -largest_half_side(82.0, L_B, 0.0, L_B - 82.0), bounds=(82, 170), method="bounded"
    )
    assert found == pytest.approx(-float(best.fun), rel=1e-4)  # the bounded search stays 1e-5 off its bound
    assert found > 67.16
    assert design[1] == pytest.approx(170.0, rel=1e-9)


def test_step_2_meets_the_torque_limit_and_the_bounds() -> None:
    found, design = solved(step_problem(task((40, 130), (30, 50), (40, 60)), 2))
    assert found == pytest.approx(62.02, abs=0.005)
    np.testing.assert_allclose(design[[1, 3, 4]], [130, 30, 48], atol=0.01)


def test_step_3_reaches_the_known_optimum() -> None:
    found, design = solved(step_problem(task((80, 130), (30, 45), half_side_mm=35), 3))
    assert found == pytest.approx(1.767, abs=5e-4)
    np.testing.assert_allclose(design[[1, 3, 4]], [108.4, 30.0, 42.2], atol=0.05)  # three digits were noted


def test_step_3_against_a_brute_force_grid() -> None:
    """L_B and H on an even grid, nothing else free: no grid point is better, and the best is one grid step away."""
    problem = step_problem(task((95, 125), (30, 30), (35, 70), half_side_mm=35), 3)
    line = np.linspace(0.0, 1.0, 41)
    x = np.stack(np.meshgrid(line, line, indexing="ij"), axis=-1).reshape(-1, 2)
    objective, margins = sqp.sampled(problem, x, 5)
    objective[(margins < 0).any(axis=1)] = np.inf
    kappa, design = solved(problem)
    best = -1.0 / objective.min()
    # the grid's sample has 5 points along an edge: its kappa may be 0.5 % too good
    assert best * 0.995 < kappa <= -1.0 / np.sort(objective)[1] * 1.001
    np.testing.assert_allclose(
        design[[1, 4]], problem.designs(x[[np.argmin(objective)]])[0, [1, 4]] * 1000.0, atol=2 * 35 / 40
    )


def test_every_limit_binds_where_it_is_required() -> None:
    limits = {"outline_radius_max_mm": 122, "kappa_max": 2.27, "lean_max_deg": 25, "gravity_torque_N_m": 0.1}
    problem = step_problem(task((80, 180), (30, 45), (20, 150), limits=limits), 2)
    best = sqp.search(problem, sqp.start_points(problem, 0, 2)).best
    assert best is not None
    design = problem.designs(np.array(best.x)[None])
    worst = {name: w.values[0] for name, w in design_worst(problem, design[0], 41).items()}
    worst |= {name: margin[0] for name, margin in problem.design_margins(design).items()}
    assert min(worst.values()) >= -1e-9
    assert min(worst["kappa"], worst["lean"]) < 1e-6


@pytest.mark.parametrize("kind", ["half_side", "quality", "feasibility"])
def test_gradients_are_those_of_a_higher_order_formula(kind: str) -> None:
    step = 3 if kind == "quality" else 2
    problem = step_problem(task((90, 130), limits={"kappa_max": 4, "lean_max_deg": 30}, half_side_mm=35), step, 60.0)
    program = Program(problem, kind)
    names = ("reach", "torque", "kappa", *(("quality",) if step == 3 else ()))
    program.add([Active(name, point) for name in names for point in ((1.0, 1.0, 1.0), (0.2, 0.3, -1.0))])
    x = np.array([0.55, 0.4, 0.4, 0.35][: len(problem.free)])
    unknowns = np.append(x, 0.1) if program.has_level else x
    gradient = program.jacobian(unknowns)
    n = len(x)
    h = 10.0 * DIFFERENCE
    for k in range(n):
        e = np.eye(n)[k]
        table, _ = program.margins(np.array([x + h * e, x - h * e, x + 2 * h * e, x - 2 * h * e]))
        fourth = (8.0 * (table[0] - table[1]) - (table[2] - table[3])) / (12.0 * h)
        # h^2 / 6 = 2e-11 here times third derivatives of up to 1e4, where two singular values nearly meet; there h^4
        np.testing.assert_allclose(gradient[:, k], fourth, atol=1e-6)
    assert program.evaluations > 0
    value, slope = program.objective(unknowns)
    assert value == -unknowns[program.level_index]
    assert slope[program.level_index] == -1.0


def test_a_point_next_to_an_active_one_takes_its_place() -> None:
    program = Program(step_problem(task(), 2), "half_side")
    assert program.add([Active("reach", (1.0, 1.0, 1.0)), Active("torque", (0.5, 1.0, 1.0))]) == 2
    assert program.add([Active("torque", (0.5, 1.0, 1.0))]) == 0
    assert program.add([Active("torque", (0.5004, 1.0, 1.0)), Active("torque", (0.6, 1.0, 1.0))]) == 2
    assert [item.point[0] for item in program.active if item.name == "torque"] == [0.5004, 0.6]


def test_exchange_leaves_no_point_of_a_fine_surface_worse() -> None:
    """Without exchange, points of a 5 x 5 grid alone let kappa through between them."""
    problem = step_problem(task((80, 130), (30, 45), half_side_mm=35), 3)
    kappa, design = solved(problem, 1)
    f = problem.figures(design[None] / 1000.0, sample_points(design[None] / 1000.0, 81))
    assert 1.0 / f.quality.min() <= kappa * (1.0 + 1e-9)


def test_points_that_become_worse_on_the_way_are_exchanged_until_none_is() -> None:
    """The worst kappa of the start is in a top corner, that of the optimum on the bottom face near an edge as well."""
    problem = step_problem(task((80, 180), (30, 45), (20, 150), limits={"kappa_max": 2.27, "lean_max_deg": 28}), 2)
    ending = sqp.descend(problem, np.full(4, 0.5), sqp.Search())
    assert ending.converged
    assert len(ending.history) > 1
    # each exchange adds constraints, so that the level can only fall
    assert (np.diff(ending.history) < 1e-9).all()


def test_starts_are_seeded_and_begin_in_the_middle() -> None:
    problem = step_problem(task(), 1)
    first = sqp.start_points(problem, 5, 4)
    np.testing.assert_array_equal(first, sqp.start_points(problem, 5, 4))
    np.testing.assert_array_equal(first[0], [0.5] * 4)
    assert not np.array_equal(first, sqp.start_points(problem, 6, 4))


def test_a_start_without_feasible_design_says_so() -> None:
    problem = step_problem(task(limits={"kappa_max": 1.2}, half_side_mm=40), 3)
    found = sqp.search(problem, sqp.start_points(problem, 0, 2))
    assert found.best is None
    assert len(found.endings) == 2
    for ending in found.endings:
        assert not ending.converged
        assert ending.reason.startswith("no feasible design near this start: the worst margin stays at -0.")


def test_nothing_free_is_only_checked() -> None:
    fixed = {"forearm_length": (112, 112), "platform_radius": (30, 30), "bottom_height": (57, 57)}
    problem = step_problem(task(**fixed, half_side_mm=35), 3)
    assert problem.free == ()
    ending = sqp.search(problem, sqp.start_points(problem, 0)).best
    assert ending is not None
    assert ending.reason == "nothing to vary: every variable's bounds are equal"
    assert 1.0 / ending.level == pytest.approx(2.03, abs=0.01)


def test_every_start_is_reported_and_a_stop_leaves_out_the_rest() -> None:
    reported: list[tuple[int, int]] = []
    problem = step_problem(task(), 1)
    starts = sqp.start_points(problem, 0, 3)
    found = sqp.search(
        problem, starts, lambda done, total, _: reported.append((done, total)), lambda: len(reported) == 2
    )
    assert reported == [(1, 3), (2, 3)]
    assert len(found.endings) == 2


def test_slack_keeps_every_margin_above_zero() -> None:
    problem = step_problem(task(), 1)
    best = sqp.search(problem, sqp.start_points(problem, 0, 1)).best
    assert best is not None
    worst = design_worst(problem, problem.designs(np.array(best.x)[None])[0], 41)["reach"].values[0]
    assert 0.0 < worst < 10.0 * SLACK


TABLES = json.loads((Path(__file__).parents[2] / "references" / "rcim2018.json").read_text())
STARTS = [
    (step, k, row)
    for step, table in ((1, "table_9_step1_sqp"), (2, "table_10_step2_sqp"))
    for k, row in enumerate(TABLES[table]["rows"])
]


@pytest.mark.parametrize(
    ("step", "row"), [(s, r) for s, _, r in STARTS], ids=[f"step {s} row {k + 1}" for s, k, _ in STARTS]
)
def test_every_published_start_converges_those_without_result_too(step: int, row: dict[str, Any]) -> None:
    bounds = [(max(1.0, low), high) for low, high in zip(row["lower"][:5], row["upper"][:5], strict=True)]
    L_A, L_B, R, r, H = bounds
    given = task(L_B, r, H, (row["lower"][5], row["upper"][5]), base_radius=R, upper_arm_length=L_A)
    problem = step_problem(given, step)
    ending = sqp.descend(problem, problem.scaled(np.array(row["start"], dtype=float)), sqp.Search())
    assert ending.converged, ending.reason
    found = problem.designs(np.array(ending.x)[None])[0, SIDE] * 1000.0
    # what others printed with three digits, 64.4 where 64.2 is the most there is
    assert found >= (row["result"][5] if row["result"] else 0.0) * (1.0 - 3.2e-3)
    assert len(ending.history) <= 6


@pytest.mark.parametrize("step", [1, 2, 3])
def test_objective_and_margins_are_the_worst_over_grid_and_fold_points(step: int) -> None:
    problem = step_problem(task((90, 130), (20, 45), limits={"kappa_max": 2.5, "shoulder_deg": [-45, 80]}), step, 40.0)
    x = np.random.default_rng(2).random((30, len(problem.free)))
    objective, margins = sqp.sampled(problem, x, 5)
    designs = problem.designs(x)
    f = problem.figures(designs, sample_points(designs, 5))
    expected = list(problem.point_margins(f).values())
    for k, margin in enumerate(expected):
        np.testing.assert_array_equal(margins[:, k], margin.min(axis=1))
    for k, margin in enumerate(problem.design_margins(designs).values()):
        np.testing.assert_array_equal(margins[:, len(expected) + k], margin)
    np.testing.assert_array_equal(objective, -f.quality.min(axis=1) if step == 3 else -x[:, -1])


def test_a_start_from_which_slsqp_stops_just_short_is_taken_up_once_more() -> None:
    """The GA's design of table 9, row 6, seed 16: SLSQP ends 1.4e-8 outside with "no direction downhill is left"."""
    problem = step_problem(task((100, 130), (40, 40), (40, 60), (30, 150)), 1)
    start = problem.scaled(np.array([82, 125.9126088404612, 40, 40, 43.96006223966936, 63.71800430382527]))
    ending = sqp.descend(problem, start, sqp.Search())
    assert ending.converged
    low, high = problem.lower[SIDE], problem.upper[SIDE]
    assert low + ending.level * (high - low) == pytest.approx(64.20146, rel=1e-6)  # as from every other start


def test_a_peak_between_the_points_of_the_exchange_is_found_before_an_ending_is_believed() -> None:
    """From this start 17 points along an edge miss a peak of kappa that 41 show: the margin lacked 4.4e-4 there."""
    limits = {"outline_radius_max_mm": 120.0, "kappa_max": 2.27, "lean_max_deg": 28.0, "gravity_torque_N_m": 0.11}
    given = task((80, 180), (30, 45), (20, 150), upper_arm_length=(60, 90), limits=limits, torque=0.31)
    problem = step_problem(given, 2, 66.89905)
    start = problem.scaled(np.array([63.03863, 80.28191, 40, 37.99404, 21.27644, 27.59105]))
    ending = sqp.descend(problem, start, sqp.Search())
    assert ending.converged
    design = problem.designs(np.array(ending.x)[None])[0]
    # a finer look yet; the compass search ends on this narrow ridge 1e-7 below its top
    assert sqp.violation(problem, np.array(ending.x), design_worst(problem, design, 81)) <= 1e-6


HELD = {"clearance_min_mm": 2.0, "joint_diameter_mm": 11.0, "parallelogram_width_mm": 54.0}


def test_an_ending_at_a_design_that_held_is_believed_on_the_fine_grid_only() -> None:
    """Where 17 points along an edge saw it hold, 41 saw 2.6e-5 short; being larger it took the place of a sound one."""
    limits = {"kappa_max": 2.344065109591024, "lean_max_deg": 22.982020160142472, **HELD}
    limits["outline_radius_max_mm"] = 126.68896961679215
    given = task((80, 180), (30, 45), (20, 150), upper_arm_length=(60, 100), limits=limits, torque=0.21441465624230546)
    problem = step_problem(given, 2)
    best = sqp.search(problem, sqp.start_points(problem, 65)).best
    assert best is not None
    worst = design_worst(problem, problem.designs(np.array(best.x)[None])[0], sqp.CONFIRMING_GRID)
    assert sqp.violation(problem, np.array(best.x), worst) <= sqp.ROUNDING


def test_a_level_of_feasibility_may_stand_still_before_it_is_met() -> None:
    """Its exchanges come to -0.437, -0.470, -0.474, -0.475 and then to where all is met."""
    limits = {"kappa_max": 2.163833795149974, "lean_max_deg": 25.441974673767817, **HELD}
    limits |= {"outline_radius_max_mm": 106.70208486235823, "gravity_torque_N_m": 0.11}
    given = task((80, 180), (30, 45), (20, 150), upper_arm_length=(60, 100), limits=limits, torque=0.24069104813522993)
    problem = step_problem(given, 2)
    assert sqp.descend(problem, sqp.start_points(problem, 25, 1)[0], sqp.Search()).converged
