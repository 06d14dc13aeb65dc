"""Limits on friction and position step up to the proven optimum, against the mechanism itself on a fine grid."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.limits import Friction, HandleFriction, PositionStep
from delta_cad.mechanism.limits.friction import friction
from delta_cad.mechanism.limits.position_step import position_step
from delta_cad.mechanism.proof.prove import prove
from optimizer.globalopt.optimum import prove_optimum
from optimizer.problem.requirements import Requirements
from optimizer.problem.step import step_problem
from optimizer.search.result import Result
from optimizer.synthesis.three_step import Run
from tests.optimizer.globalopt.wide import LIMITS, ROUNDING, WIDE, mechanism
from tests.optimizer.tasks import JOINTS, task

RUBS, COUNT = HandleFriction(*list(JOINTS.values())[:3]), math.radians(JOINTS["encoder_count_deg"])
ASKED = (("friction_max_N", 0.9), ("position_step_max_mm", 0.075))


def given(**asked: float) -> Requirements:
    return task(*WIDE, limits=LIMITS | asked, joints=JOINTS)


def most(design_mm: tuple[float, ...], n: int = 61) -> dict[str, float]:
    """The largest friction, N, and step, mm, on n^3 points of the cube, inside too."""
    g, cube = mechanism(np.array(design_mm) / MM_PER_M)
    axes = [np.linspace(low, high, n) for low, high in zip(cube.lower, cube.upper, strict=True)]
    p = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    step = float(position_step(g, p, COUNT).max())
    return {"friction_max_N": float(friction(g, p, RUBS).max()), "position_step_max_mm": step * MM_PER_M}


@pytest.mark.quick(1)
@pytest.mark.parametrize(("field", "bound"), ASKED)
def test_the_incumbent_keeps_it_binds_and_is_certified(field: str, bound: float) -> None:
    free = prove_optimum(step_problem(given(), 2), gap=1e-3)
    problem = step_problem(given(**{field: bound}), 2)
    found = prove_optimum(problem, gap=1e-3)
    assert (found.status, found.certified) == ("proved", True)
    assert found.bound < free.objective  # it costs side
    # the grid misses the largest by less than the square of its step, (1 / 60)^2, times curvatures of about 1
    assert bound * (1.0 - 1e-3) < most(found.design_mm)[field] <= bound * (1.0 + ROUNDING)
    g, cube = mechanism(np.array(found.design_mm) / MM_PER_M)
    assert prove(g, cube, problem.pose_limits()).verdict == "proved"


@pytest.mark.slow
def test_synthesis_finds_the_same_optimum_and_tells_both() -> None:
    asked: dict[str, Any] = dict(ASKED)
    proved = prove_optimum(step_problem(given(**asked), 2), gap=1e-3)
    result: Result = Run(given(**asked), "sqp", 1, steps=(2,)).results()[0]
    assert result.feasible
    assert proved.objective * (1.0 - 1e-4) <= result.objective <= proved.bound
    worst = {"friction_max_N": result.worst(Friction), "position_step_max_mm": MM_PER_M * result.worst(PositionStep)}
    assert worst == pytest.approx(most(result.design_mm), rel=1e-3)
    assert max(worst[field] / bound for field, bound in ASKED) == pytest.approx(1.0, rel=1e-5)
