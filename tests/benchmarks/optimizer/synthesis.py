"""The three steps by GA+SQP: time, against the same search on NumPy, beside other optimisers, memory and growth."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import process_time

import numpy as np

from optimizer.problem.requirements import load_requirements
from optimizer.problem.step import Problem, step_problem
from optimizer.search import genetic
from optimizer.search.sqp import sampled
from optimizer.synthesis.three_step import Run
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.optimizer.numpy_objective import agree, numpy_objective
from tests.benchmarks.optimizer.peers import PEERS, Outcome, own, peer
from tests.benchmarks.timing import ROOT, interleaved, python, slope, succeeded
from tests.optimizer.tasks import task

SUBJECT = "synthesis"
ROUNDS = 5
PUBLISHED = task(half_side_mm=35.0)  # [RCIM2018] table 3's bounds, step 3 for the prototype's cube
GRIDS = (9, 17, 33, 65)
POPULATIONS = (55, 110, 220, 440, 880)
CLOSE = 5e-3
"""Of the best objective: what counts as the same."""
PROJECT_OWN = ("ga+sqp", "sqp")


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.

    Raises:
        RuntimeError: Something did not do its work, so that there is nothing to compare.
    """
    joystick = load_requirements(ROOT / "examples/synthesized.toml")
    say(f"three steps, {ROUNDS} rounds")
    times = interleaved({"": Run(joystick).results}, ROUNDS, process_time)[""]
    return [
        *_against_numpy(say),
        of_repeats(SUBJECT, "three steps GA+SQP, synthesized.toml, warm", times, "s", 10.0),
        *_peers(say),
        *_memory(say),
        *_growth(say),
    ]


def _against_numpy(say: Callable[[str], None]) -> list[Figure]:
    agree()
    say("the same search on the NumPy objective, between rounds of ours")
    before = interleaved({"": Run(PUBLISHED).results}, ROUNDS, process_time)[""]
    start = process_time()
    with numpy_objective():
        theirs = Run(PUBLISHED).results()
    seconds = process_time() - start
    after = interleaved({"": Run(PUBLISHED).results}, ROUNDS, process_time)[""]
    # roundings of 1e-16 decide ties otherwise, so that generations part ways; the optimum is the same
    for a, b in zip(Run(PUBLISHED).results(), theirs, strict=True):
        if not np.isclose(a.objective, b.objective, rtol=CLOSE):
            raise RuntimeError(f"step {a.problem.step}: {a.objective:.6g} on ours, {b.objective:.6g} on NumPy")
    note = (
        f"solve and cond: {seconds:.1f} s once, {sum(r.evaluations for r in theirs):,} designs; ours before and after"
    )
    return [
        of_repeats(
            SUBJECT, "three steps GA+SQP, published bounds, warm", before + after, "s", 10.0,
            note="populations 100, 220, 220, 100 generations each; processor time",
        ),
        of_repeats(
            SUBJECT, "three steps against the same search on NumPy", [seconds / t for t in before + after], "x", 20.0,
            False, note,
        ),
    ]  # fmt: skip


def _peers(say: Callable[[str], None]) -> list[Figure]:
    figures = []
    for step, what in ((2, "half side in mm"), (3, "worst kappa")):
        problem = step_problem(PUBLISHED, step)
        found: dict[str, Outcome] = {}
        for method in PROJECT_OWN:
            say(f"step {step}: our {method} on the NumPy objective")
            found[f"our {method}"] = own(PUBLISHED, method, step)
        for name in PEERS:
            say(f"step {step}: {name} on the NumPy objective")
            found[name] = peer(name, problem)
        feasible = [o.objective for o in found.values() if o.feasible]
        best = min(feasible) if step == 3 else max(feasible)
        for name, o in found.items():
            note = f"{what} {o.wording(best)}"
            figures.append(Figure(SUBJECT, f"step {step} on NumPy by {name}", o.seconds, "s", note=note))
        figures += _verdict(step, found, best)
    return figures


def _verdict(step: int, found: dict[str, Outcome], best: float) -> list[Figure]:
    """The fastest feasible peer that comes near enough, against our GA+SQP on the same objective."""
    project = found["our ga+sqp"].seconds
    near = {n: o.seconds for n, o in found.items() if n in PEERS and o.feasible and o.off(best) <= CLOSE}
    if not near:
        return []
    name = f"step {step} on NumPy: fastest peer within {100.0 * CLOSE:g} % of the best, against our GA+SQP"
    first = min(near, key=lambda n: near[n])
    who = f"{first} wins" if near[first] < project else f"{first} is the next"
    return [Figure(SUBJECT, name, project / near[first], "x", note=f"{who}; above 1 the peer is faster")]


def _memory(say: Callable[[str], None]) -> list[Figure]:
    say("peak memory")
    with TemporaryDirectory() as folder:
        out = str(Path(folder) / "best.json")
        child = succeeded(python("-m", "optimizer", "synthesize", "examples/synthesized.toml", "--out", out))
    peak, wall = child.largest_bytes / 1e6, child.wall_s
    return [
        Figure(
            SUBJECT, "peak memory of `optimizer synthesize`", peak, "MB", 400.0, note="synthesized.toml, whole process"
        ),
        Figure(SUBJECT, "`optimizer synthesize`, from start to end", wall, "s", note="the same; compiled before"),
    ]


def _growth(say: Callable[[str], None]) -> list[Figure]:
    say("growth with points and with designs")
    problem = step_problem(PUBLISHED, 3)
    x = np.random.default_rng(1).random((220, len(problem.free)))
    points = [_least(partial(sampled, problem, x, n)) for n in GRIDS]
    counts = [_count(problem, x, n) for n in GRIDS]
    designs = [_least(partial(genetic.evolve, problem, 1, size, 10)) for size in POPULATIONS]
    return [
        Figure(
            SUBJECT, "growth: time against points of the sample, log-log slope", slope(counts, points), "",
            note=f"{counts[0]:,} to {counts[-1]:,} points of 220 designs: {1e3 * points[0]:.2g} to "
            f"{1e3 * points[-1]:.3g} ms",
        ),
        Figure(
            SUBJECT, "growth: time against designs of a generation, log-log slope", slope(POPULATIONS, designs), "",
            note=f"{POPULATIONS[0]} to {POPULATIONS[-1]} designs, 10 generations of GA: {1e3 * designs[0]:.3g} to "
            f"{1e3 * designs[-1]:.3g} ms; each is compared with each",
        ),
    ]  # fmt: skip


def _count(problem: Problem, x: np.ndarray, n: int) -> int:
    from tests.optimizer.tasks import sample_points

    return sample_points(problem.designs(x[:1]), n).shape[1]


def _least(function: Callable[[], object]) -> float:
    return min(interleaved({"": function}, 3, process_time)[""])
