"""The design file of a result: lengths in whole micrometres that still hold, and the committed one made again."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import load_design
from delta_cad.mechanism import conditioning, joint_angles, rod_lean, worst_joint_torque
from delta_cad.mechanism.geometry import THREE_FOLD, directions
from delta_cad.mechanism.inverse import forearm_vectors
from optimizer.problem.requirements import Requirements, load_requirements, requirements_hash
from optimizer.problem.step import SIDE, step_problem
from optimizer.problem.variables import COSINE, VARIABLES, azimuth_deg, mechanism_of, variables_mm
from optimizer.search.result import Result
from optimizer.search.sqp import search, start_points
from optimizer.synthesis.output import design_of, presentable
from optimizer.synthesis.three_step import Run
from tests.optimizer.placed_task import FREE, joystick_task

ROOT = Path(__file__).parents[3]
BEST = ROOT / "examples/synthesized.json"


@pytest.fixture(scope="module")
def given() -> Requirements:
    return load_requirements(ROOT / "examples/synthesized.toml")


@pytest.fixture(scope="module")
def first() -> Requirements:
    """A task whose optimum is known to the last digit."""
    return load_requirements(ROOT / "tests" / "references" / "joystick.toml")


@pytest.fixture(scope="module")
def solved(given: Requirements) -> list[Result]:
    """The steps by SQP alone: another way to the same optimum, in a second."""
    return Run(given, "sqp", seed=1).results()


def test_the_committed_design_is_what_synthesize_writes_from_the_committed_requirements(
    given: Requirements, solved: list[Result]
) -> None:
    design = load_design(BEST)
    reported = design.provenance
    assert reported["requirements_sha256"] == requirements_hash(given)
    assert (
        reported["command"]
        == f"python -m optimizer synthesize synthesized.toml --method {reported['method']} --seed {reported['seed']}"
    )
    again = design_of(given, solved, "sqp", 1, "again.json")
    assert again.mechanism == design.mechanism  # to the last digit: both are whole micrometres
    assert again.cube == design.cube
    assert again.requirements == design.requirements
    assert again.hardware == design.hardware
    found = dict(zip(VARIABLES, solved[1].design_mm, strict=True))
    steps = reported["steps"]
    assert isinstance(steps, list)
    assert steps[1]["objective"] == pytest.approx(found["half_side"], rel=1e-6)  # type: ignore[call-overload,index]
    bound = steps[1]["proven_bound"]  # type: ignore[call-overload,index]
    assert design.cube.half_side_mm <= bound <= design.cube.half_side_mm * (1.0 + 1e-4)  # type: ignore[operator]


def test_the_committed_design_meets_its_limits_by_the_mechanism_s_own_figures() -> None:
    """A dense grid on the surface of the cube through `delta_cad.mechanism`, not through the optimizer's kernel."""
    design = load_design(BEST)
    required, half, low = design.requirements, design.cube.half_side_mm / 1e3, design.cube.bottom_height_mm / 1e3
    axis = np.linspace(-1.0, 1.0, 81)
    a, b = (v.ravel() for v in np.meshgrid(axis, axis))
    faces = [np.insert(np.stack([a, b], axis=1), k, side, axis=1) for k in range(3) for side in (-1.0, 1.0)]
    p = half * np.concatenate(faces) + np.array([0.0, 0.0, low + half])
    g = design.geometry
    assert required.kappa_max is not None
    assert required.lean_max_deg is not None
    assert required.shoulder_min_deg is not None
    assert required.shoulder_max_deg is not None
    assert required.couple_index_min is not None
    kappa, lean = float(conditioning(g, p).max()), float(np.degrees(np.abs(rod_lean(g, p)).max()))
    theta = np.degrees(joint_angles(g, p))
    assert 0.9999 * required.kappa_max < kappa <= required.kappa_max  # binds
    rods = forearm_vectors(g, p) / g.forearm_length
    index = np.linalg.svd(np.cross(directions(THREE_FOLD)[1], rods), compute_uv=False)[:, -1].min()
    assert required.couple_index_min <= index < 1.0001 * required.couple_index_min  # binds, in corners
    assert lean < required.lean_max_deg
    assert (
        required.shoulder_min_deg < theta.min() < required.shoulder_min_deg + 0.01
    )  # binds, on an edge between grid points
    assert theta.max() < required.shoulder_max_deg
    assert worst_joint_torque(g, p, required.force_N).max() < required.joint_torque_N_m


def test_lengths_are_whole_micrometres_that_still_hold_and_no_better_choice_was_near(first: Requirements) -> None:
    found = (82.0, 122.3465807327546, 40.0, 30.000000000001787, 47.72975679997513, 42.047709417613625)
    for step in (2, 3):
        result = Result(step_problem(first, step, found[SIDE]), "sqp", found, "converged")
        assert result.feasible
        lengths = presentable(result)
        assert lengths == tuple(round(v, 3) for v in lengths)
        assert math.dist(lengths[:6], found) < 2e-3
        assert lengths[SIDE] <= found[SIDE] < lengths[SIDE] + 2e-3
        assert Result(step_problem(first, step, lengths[SIDE]), "sqp", lengths, "converged").feasible
    nearest = (*(round(v, 3) for v in found[:SIDE]), 42.047)
    assert not Result(step_problem(first, 2, 43.0), "sqp", nearest, "converged").feasible  # plain rounding would fail


def test_lengths_stay_as_they_are_where_rounding_cannot_hold(first: Requirements) -> None:
    found = (82.0, 122.3465807327546, 40.0, 30.000000000001787, 47.72975679997513, 42.047709417613625)
    step_3 = first.step_3.model_copy(update={"half_side_mm": found[SIDE]})
    fixed = first.model_copy(update={"step_3": step_3})
    assert presentable(Result(step_problem(fixed, 3), "sqp", found, "converged"))[:6] == found
    too_large = (*found[:SIDE], 45.0004)
    assert presentable(Result(step_problem(first, 2, 46.0), "sqp", too_large, "interrupted"))[:6] == too_large


def test_a_placed_design_is_written_where_it_stands() -> None:
    """Rounded or, where too many limits bind for that, as it was found; the file's own geometry keeps every limit."""
    problem = step_problem(joystick_task(FREE), 2)
    best = search(problem, start_points(problem, 0, 1)).best
    assert best is not None
    result = Result(problem, "sqp", problem.lengths_mm(best.x), "converged")
    design = design_of(problem.requirements, [result], "sqp", 0, "placed.json")
    _, azimuth, _ = design.mechanism.azimuths_deg or (0.0, 120.0, -120.0)
    assert abs(azimuth - azimuth_deg(result.design_mm[COSINE])) < 2e-4
    assert design.mechanism.base_radii_mm is not None
    assert design.cube.centre_x_mm == pytest.approx(result.design_mm[8], abs=2e-3)
    written = variables_mm(design.mechanism.model_dump(), design.cube.model_dump())
    assert Result(problem, "sqp", written, "converged").feasible
    assert result.design_mm[SIDE] - 0.1 <= written[SIDE] <= result.design_mm[SIDE]
    g, cube = mechanism_of(written)
    assert design.geometry.base_radii == pytest.approx(g.base_radii, abs=1e-15)
    assert design.workspace == cube


def test_a_cube_below_a_micrometre_is_not_rounded_away(given: Requirements) -> None:
    found = (82.0, 122.34, 40.0, 30.0, 90.0, 1e-9)
    for problem in (step_problem(given, 2), step_problem(given, 3, 1e-9)):
        result = Result(problem, "sqp", found, "converged")
        assert result.feasible
        assert presentable(result)[:6] == found
