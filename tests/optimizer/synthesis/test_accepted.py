"""What `synthesize` proves is a design that its reader takes, whatever the requirements."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.design import DesignError, load_design
from optimizer.globalopt.bound import Effort
from optimizer.problem.requirements import Requirements, requirements_from_dict
from optimizer.problem.step import step_problem
from optimizer.search.result import Result
from optimizer.synthesis.infeasible import InfeasibleError
from optimizer.synthesis.output import design_of, write_design
from optimizer.synthesis.three_step import Run
from tests.optimizer.tasks import task

EFFORT = Effort(gap=0.05, boxes=5_000)
SETS = 60


def drawn(seed: int) -> Requirements:
    """Draws requirements whose bounds leave room to break every condition of the design file's reader."""
    random = np.random.default_rng(seed)

    def one(low: float, high: float) -> float:
        return round(float(random.uniform(low, high)), 1)

    limits: dict[str, Any] = {"parallelogram_width_mm": one(10, 90)}
    if seed % 3 == 0:
        limits |= {"kappa_max": one(2.5, 6.0)}
    if seed % 5 == 0:
        limits |= {"clearance_min_mm": one(0, 3), "joint_diameter_mm": one(2, 12)}
    arm, base = one(30, 90), one(15, 40)
    wide = {"forearm_length": (40, 200), "platform_radius": (5, 140), "bottom_height": (20, 150)}
    return requirements_from_dict(
        {
            "name": f"drawn-{seed}",
            "requirements": {
                "envelope_width_mm": one(250, 400),
                "envelope_depth_mm": one(250, 400),
                "force_N": one(1, 5),
                "joint_torque_N_m": one(0.5, 3),
            },
            "bounds_mm": {
                "upper_arm_length": [arm, arm],
                "base_radius": [base, base],
                **{name: sorted((one(*ends), one(*ends))) for name, ends in wide.items()},
                "half_side": [0, 100],
            },
            "limits": limits,
            "hardware": {"ball_diameter_mm": one(4, 15)},
        }
    )


@pytest.mark.quick(12)
@pytest.mark.parametrize("seed", range(SETS))
def test_what_is_proved_is_read(seed: int, tmp_path: Path) -> None:
    given, step = drawn(seed), 1 + seed % 2
    try:
        results = Run(given, "proven", 0, (step,), effort=EFFORT).results()
    except InfeasibleError:
        return
    if results[-1].tiny or not results[-1].feasible:
        return
    path = tmp_path / "drawn.json"
    write_design(design_of(given, results, "proven", 0, path.name), path)
    assert load_design(path).cube.half_side_mm > 0.0


@pytest.mark.parametrize(
    ("lengths", "field", "shortfall"),
    [
        ((82.0, 112.079, 40.0, 18.47, 57.112, 35.0), "mechanism.parallelogram_width_mm", "balls"),
        ((40.0, 112.079, 40.0, 80.1, 57.112, 35.0), "mechanism.platform_radius_mm", "elbow_outside"),
    ],
)
def test_what_the_reader_refuses_is_a_condition_of_every_step(
    lengths: tuple[float, ...], field: str, shortfall: str
) -> None:
    """At the reader's own bound: just within it the step has no violation of that kind, just beyond it has."""
    wide = task(platform_radius=(5, 140), upper_arm_length=(30, 82), limits={"outline_radius_max_mm": 122.0})
    for step in (1, 2):
        result = Result(step_problem(wide, step), "sqp", lengths, "converged")
        with pytest.raises(DesignError) as caught:
            design_of(wide, [result], "sqp", 0, "x.json")
        fields = [caught.value.field, *(re.split(": | = ", line)[1] for line in caught.value.more)]
        assert field in fields
        assert result.violations[shortfall] > 0.0


def test_bounds_that_keep_a_condition_leave_it_out() -> None:
    kept = step_problem(task(), 2).constraints  # r of 20 mm or more: wrists 10.6 mm apart, elbows far out
    assert not {"balls", "elbow_outside"} & set(kept)
