"""Two proofs of one question: a certificate of a design, and the proven optimum of bounds that hold it alone."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, closure_margin, direct_margin
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import cube_grid
from optimizer.globalopt.optimum import prove_optimum
from optimizer.problem.requirements import Requirements, requirements_from_dict
from optimizer.problem.step import step_problem
from optimizer.problem.variables import PER_SI
from optimizer.synthesis.infeasible import explain
from tests.designs import below_elbows

DESIGNS, OF_EITHER_MODE = 1_000, 300
LENGTHS = ("base_radius", "platform_radius", "upper_arm_length", "forearm_length", "bottom_height", "half_side")


def only(lengths: tuple[float, ...]) -> Requirements:
    """Requirements whose bounds hold one design, lengths in mm in the order of `LENGTHS`."""
    required = {"envelope_width_mm": 5000.0, "envelope_depth_mm": 5000.0, "force_N": 3.0, "joint_torque_N_m": 0.8}
    bounds = {name: [value, value] for name, value in zip(LENGTHS, lengths, strict=True)}
    return requirements_from_dict({"name": "one", "requirements": required, "bounds_mm": bounds})


def drawn(rng: np.random.Generator) -> tuple[tuple[float, ...], DeltaGeometry, Cube, float]:
    """A random design whose corners are within reach, and det S / L_B^3 in its cube's centre."""
    while True:
        *link, bottom, half = lengths = tuple(
            np.round(rng.uniform([20, 10, 40, 40, 1, 3], [60, 60, 100, 160, 120, 25]), 1).tolist()
        )
        g, cube = DeltaGeometry(*(x / 1000.0 for x in link)), Cube(bottom / 1000.0, half / 1000.0)
        corners = cube_grid(cube, 2)
        if closure_margin(g, corners).min() > 0.0:
            return lengths, g, cube, float(direct_margin(g, corners.mean(axis=0)))


@pytest.mark.slow
def test_certificates_and_proven_optima_never_contradict_each_other() -> None:
    rng = np.random.default_rng(2018)
    seen: Counter[tuple[str, str]] = Counter()
    modes: Counter[bool] = Counter()
    while modes.total() < DESIGNS:
        lengths, g, cube, mode = drawn(rng)
        if modes[mode > 0.0] >= DESIGNS - OF_EITHER_MODE:
            continue
        problem = step_problem(only(lengths), 2)
        of_design = problem.design_margins(np.array(problem.lower)[None] / PER_SI)
        if min(float(margin.min()) for margin in of_design.values()) < 0.0:  # balls that meet: no limit of a pose
            assert prove_optimum(problem).status == "infeasible", lengths
            continue
        modes[mode > 0.0] += 1
        certificate, optimum = prove(g, cube, problem.pose_limits(), max_boxes=200_000), prove_optimum(problem)
        seen[certificate.verdict, optimum.status] += 1
        assert (certificate.verdict, optimum.status) in {
            ("proved", "proved"),
            ("refuted", "infeasible"),
            ("undecided", "undecided"),
        }, lengths
    assert min(modes.values()) >= OF_EITHER_MODE
    assert seen["proved", "proved"] > 200
    assert seen["refuted", "infeasible"] > OF_EITHER_MODE
    assert seen["undecided", "undecided"] < 5


def test_a_platform_below_its_elbows_is_infeasible_for_its_assembly_mode_not_for_torque() -> None:
    data = below_elbows()
    lengths = {key.removesuffix("_mm"): value for key, value in (data["mechanism"] | data["cube"]).items()}
    given = only(tuple(lengths[name] for name in LENGTHS))
    found = explain(given, step_problem(given, 2), None, seed=0)
    assert found is not None
    assert found.conflict == ("assembly_mode",)
