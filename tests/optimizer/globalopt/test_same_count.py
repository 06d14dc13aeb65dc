"""A proof takes the same boxes in every process: last digits, in which two processes may differ, do not reach it."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from optimizer.globalopt import optimum
from optimizer.globalopt.optimum import prove_optimum
from optimizer.problem.step import step_problem
from tests.optimizer.front_tasks import joystick

LAST = 1e-14  # relative, some 50 units in the last place: more than sums in another order differ by


@pytest.fixture(scope="module")
def boxes() -> int:
    return prove_optimum(step_problem(joystick(), 2)).boxes


@pytest.mark.parametrize("seed", range(3))
def test_other_last_digits_of_what_is_searched_change_no_count(
    seed: int, boxes: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    rng = np.random.default_rng(seed)
    descend, worst = optimum.sqp.descend, optimum.design_worst

    def jitter(values: Any) -> Any:
        return np.asarray(values) * (1.0 + LAST * rng.uniform(-1.0, 1.0, np.shape(values)))

    def descended(*given: Any) -> Any:
        ending = descend(*given)
        return ending._replace(x=tuple(np.clip(jitter(ending.x), 0.0, 1.0)))

    def searched(*given: Any) -> Any:
        return {
            name: one._replace(points=np.clip(jitter(one.points), -1.0, 1.0)) for name, one in worst(*given).items()
        }

    monkeypatch.setattr(optimum.sqp, "descend", descended)
    monkeypatch.setattr(optimum, "design_worst", searched)
    assert prove_optimum(step_problem(joystick(), 2)).boxes == boxes


CODE = """
import json
from optimizer.globalopt.optimum import prove_optimum
from optimizer.problem.step import step_problem
from tests.optimizer.front_tasks import joystick
found = prove_optimum(step_problem(joystick(), 2))
print(json.dumps([found.boxes, found.objective, found.bound]))
"""
SURROUNDINGS = (
    {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
    {"OMP_NUM_THREADS": "2", "OPENBLAS_NUM_THREADS": "2", "MALLOC_PERTURB_": "165"},
    {"PYTHONHASHSEED": "7", "MALLOC_PERTURB_": "90", "MALLOC_ARENA_MAX": "1"},
)


@pytest.mark.slow
def test_processes_with_other_threads_and_memory_take_the_same_boxes(boxes: int) -> None:
    """Box for box and bit for bit."""
    reported = [
        subprocess.run([sys.executable, "-c", CODE], env=os.environ | one, capture_output=True, text=True, check=True)
        for one in SURROUNDINGS
    ]
    found = [json.loads(run.stdout) for run in reported]
    assert found == [found[0]] * len(found)
    assert found[0][0] == boxes


def test_descents_run_on_one_thread_wherever_they_are_called_from(monkeypatch: pytest.MonkeyPatch) -> None:
    from threadpoolctl import threadpool_info, threadpool_limits

    minimize: Callable[..., Any] = optimum.sqp.minimize
    threads: set[int] = set()

    def watched(*given: Any, **more: Any) -> Any:
        threads.update(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
        return minimize(*given, **more)

    monkeypatch.setattr(optimum.sqp, "minimize", watched)
    with threadpool_limits(2):
        optimum.sqp.descend(step_problem(joystick(), 2), np.full(4, 0.5), optimum.sqp.Search())
    assert threads == {1}
