"""The front of cube size against worst kappa: 50 points, their proofs, and the whole command with its pictures."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import TYPE_CHECKING

from tests.benchmarks.figure import Figure
from tests.benchmarks.timing import ROOT, python, slope, succeeded

if TYPE_CHECKING:
    from optimizer.problem.requirements import Requirements
    from optimizer.study.front import Curve

SUBJECT = "front"
POINTS = 50
GROWTH = (13, 25, 50, 100)
"""Numbers of points; up to 9 are started cold, so that fewer would not show how the front grows."""


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.

    Raises:
        RuntimeError: The command failed, or a point or a bound is missing.
    """
    from optimizer.problem.requirements import load_requirements
    from optimizer.study.front import Tracer, proved

    given = load_requirements(ROOT / "examples/synthesized.toml")
    say(f"front command, {POINTS} points, with the fronts beside it, proofs, seeds and pictures")
    with TemporaryDirectory() as out:
        task = str(ROOT / "examples/synthesized.toml")
        arguments = ("-m", "optimizer", "front", task, "--points", str(POINTS), "--out", out)
        command = succeeded(python(*arguments, "--json"))
        facts = json.loads(command.stdout)
        pictures = len(list(Path(out).glob("*-front/*.png")))
    say(f"front alone, {GROWTH[0]} to {GROWTH[-1]} points")
    Tracer(given, GROWTH[0]).curve()  # compiles
    wall, busy, curve = {}, {}, None
    for count in GROWTH:
        start, processor = perf_counter(), process_time()
        traced = Tracer(given, count).curve()
        wall[count], busy[count] = perf_counter() - start, process_time() - processor
        if count == POINTS:
            curve = traced
    if curve is None or len(curve.points) != POINTS:
        raise RuntimeError(f"the front has not {POINTS} points")
    say(f"{POINTS} proofs")
    start = process_time()
    with_bounds = proved(curve)
    proofs = process_time() - start
    gaps = [1.0 - p.bound / p.kappa for p in with_bounds.points if p.bound is not None]
    if len(gaps) != POINTS:
        raise RuntimeError(f"{POINTS - len(gaps)} points have no bound")
    cold = _cold(given, curve, say)
    adjacent = sum(len(found["points"]) for found in facts["curves"][1:])
    shown = f"{adjacent} points of other fronts, proofs, 6 seeds, {pictures} pictures"
    grown = slope(GROWTH, [busy[n] for n in GROWTH])
    cold_note = "five points, six starts of another seed"
    return [
        Figure(SUBJECT, "front of cube size against worst kappa, 50 points", wall[POINTS], "s", 60.0, note="warm"),
        Figure(SUBJECT, "processor time of the whole command", command.processor_s, "s", 60.0, note=shown),
        Figure(SUBJECT, "the whole command", command.wall_s, "s", note="by the clock, beside whatever else runs"),
        Figure(SUBJECT, "memory of the whole command", command.largest_bytes / 1e6, "MB", 400.0),
        Figure(SUBJECT, "proofs of the 50 points", proofs, "s", note="processor time"),
        Figure(SUBJECT, "largest proven gap of the 50 points", 100.0 * max(gaps), "%", 0.1),
        Figure(SUBJECT, "best of cold starts below the front", cold, "%", 1e-3, note=cold_note),
        Figure(SUBJECT, "growth of the front with its points", grown, "", 1.1, note="log-log slope"),
    ]


def _cold(given: Requirements, curve: Curve, say: Callable[[str], None]) -> float:
    """By how much cold starts are better than the front at most, %; negative where they never are."""
    from optimizer.search import sqp
    from optimizer.study.front import at_side

    say("cold starts at five points")
    best = -100.0
    for point in curve.points[:: POINTS // 5]:
        problem = at_side(given, point.half_side)
        found = sqp.search(problem, sqp.start_points(problem, 1234)).best
        if found is not None:
            best = max(best, 100.0 * (1.0 - 1.0 / (found.level * point.kappa)))
    return best
