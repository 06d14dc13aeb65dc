"""Traces of GA and SQP over the seeds, and their band."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from optimizer.problem.step import Problem
from optimizer.search import genetic, sqp
from optimizer.study import convergence
from optimizer.study.convergence import Trace, band, traces
from optimizer.study.front import at_side
from optimizer.synthesis.checkpoint import Checkpoint
from tests.optimizer.front_tasks import joystick


@pytest.fixture
def problem(monkeypatch: pytest.MonkeyPatch) -> Problem:
    """Step 3 at 36 mm, with a small GA."""
    true = genetic.evolve
    monkeypatch.setattr(
        convergence.genetic, "evolve", lambda p, seed, **named: true(p, seed, population=20, generations=8, **named)
    )
    return at_side(joystick(), 36.0)


def test_traces_fall_to_the_optimum(problem: Problem) -> None:
    found = traces(problem, 2)
    other = sqp.search(problem, sqp.start_points(problem, seed=9)).best
    assert other is not None
    assert [(t.method, t.seed) for t in found] == [("sqp", 0), ("ga", 0), ("sqp", 1), ("ga", 1)]
    for trace in found:
        best = np.array(trace.best)
        finite = best[np.isfinite(best)]
        assert len(trace.evaluations) == len(best)
        assert (np.diff(trace.evaluations) > 0).all()
        assert (np.diff(finite) <= 0.0).all()
        assert np.isfinite(best[len(best) - len(finite) :]).all()  # once there is one there always is
        if trace.method == "ga":
            assert trace.evaluations == tuple(range(20, 161, 20))
        else:
            assert best[-1] == pytest.approx(1.0 / other.level, rel=1e-8)
    assert found[0].evaluations != found[2].evaluations


def test_band_is_least_median_and_largest() -> None:
    runs = [
        Trace("ga", 0, (10, 20), (5.0, 3.0)),
        Trace("ga", 1, (10, 30), (math.nan, 2.0)),
        Trace("ga", 2, (15, 20), (4.0, 4.0)),
        Trace("sqp", 0, (1,), (1.0,)),
    ]
    least, median, largest = band(runs, "ga", np.array([5, 10, 15, 25, 30]))
    assert list(least) == [math.inf, 5.0, 4.0, 3.0, 2.0]
    assert list(median) == [math.inf, math.inf, 5.0, 4.0, 3.0]
    assert list(largest) == [math.inf, math.inf, math.inf, math.inf, 4.0]


def test_stopped_and_resumed_is_as_unbroken(problem: Problem, tmp_path: Path) -> None:
    unbroken = traces(problem, 1)
    seen: list[str] = []
    store = Checkpoint(tmp_path / "kept", {}, resume=False)
    first = traces(problem, 1, lambda method, *_: seen.append(method), lambda: "ga" in seen, store)
    store.close()
    assert [t.method for t in first] == ["sqp"]
    store = Checkpoint(tmp_path / "kept", {}, resume=True)
    reported: list[str] = []
    assert traces(problem, 1, lambda method, *_: reported.append(method), store=store) == unbroken
    store.close()
    assert reported == ["ga"]
