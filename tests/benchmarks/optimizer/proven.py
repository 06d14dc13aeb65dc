"""Proven optimum: time and boxes to a gap of 1e-3 and 1e-5, growth with the gap, L_A free, a peer without proof."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from tempfile import TemporaryDirectory
from time import process_time

from optimizer.globalopt.optimum import Proven, prove_optimum
from optimizer.problem.requirements import load_requirements
from optimizer.problem.step import Problem, step_problem
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.optimizer.peers import peer
from tests.benchmarks.timing import ROOT, interleaved, python, slope, succeeded
from tests.optimizer.tasks import task

SUBJECT = "proven optimum"
ROUNDS = 5
GAPS = (1e-2, 1e-3, 1e-4, 1e-5)
PEER = "SciPy's differential_evolution"
COLD = """
import sys, time
sys.path.insert(0, sys.argv[1])
start = time.process_time()
from tests.optimizer.tasks import task
from optimizer.problem.step import step_problem
from optimizer.globalopt.optimum import prove_optimum
prove_optimum(step_problem(task(half_side_mm=35.0), 3), gap=1e-3)
print(time.process_time() - start)
"""


def three_variables() -> dict[str, Problem]:
    """Steps of [RCIM2018] with L_B, r and H free, by name."""
    joystick = load_requirements(ROOT / "examples/synthesized.toml")
    return {
        "table 6, step 1": step_problem(task((40, 170)), 1),
        "table 10, step 2": step_problem(task((1, 130), (30, 50), (40, 60), (35, 100)), 2),
        "table 11, step 3": step_problem(task((1, 130), (30, 50), (40, 150), half_side_mm=35.0), 3),
        "synthesized.toml, step 2": step_problem(joystick, 2),
    }


def free_arm() -> dict[str, Problem]:
    """Steps with L_A and R free as well."""
    wide = partial(task, (60, 200), (20, 45), (20, 200), (0, 100), (30, 60), (50, 90))
    return {
        "L_A free, step 2": step_problem(wide({"outline_radius_max_mm": 122.0, "kappa_max": 2.5}), 2),
        "L_A free, step 3": step_problem(wide(None, 35.0), 3),
    }


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.

    Raises:
        RuntimeError: A gap was not reached, or the peer beat a bound.
    """
    say("cold start: nothing compiled")
    with TemporaryDirectory() as empty:
        cold, warm = (float(succeeded(python("-c", _cached(empty), str(ROOT))).stdout) for _ in range(2))
    return [
        *_three(say),
        *_arm(say),
        Figure(
            SUBJECT,
            "first proof of a process, nothing compiled",
            cold,
            "s",
            note="processor time, most of it the compiler",
        ),
        Figure(
            SUBJECT,
            "first proof of a process, compiled before",
            warm,
            "s",
            note="processor time; imports and reading the cache",
        ),
        *_peer(say),
    ]


def _cached(folder: str) -> str:
    return f"import os\nos.environ['NUMBA_CACHE_DIR'] = {folder!r}\n{COLD}"


def _solved(problem: Problem, gap: float) -> Proven:
    found = prove_optimum(problem, gap=gap)
    if found.status != "proved":
        raise RuntimeError(f"step {problem.step} ended with {found.status} at a gap of {found.gap:.2g}, not {gap:g}")
    return found


def _three(say: Callable[[str], None]) -> list[Figure]:
    out: list[Figure] = []
    for name, problem in three_variables().items():
        say(name)
        found = {gap: _solved(problem, gap) for gap in GAPS}
        times = interleaved({str(gap): partial(_solved, problem, gap) for gap in (1e-3, 1e-5)}, ROUNDS, process_time)
        for gap, most in ((1e-3, 10.0), (1e-5, 5.0)):
            note = (
                f"{found[gap].boxes:,} boxes, {found[gap].cutting_points} cutting points; "
                "processor time, with the incumbent"
            )
            out.append(of_repeats(SUBJECT, f"{name}, gap {gap:g}, warm", times[str(gap)], "s", most, note=note))
        boxes = [float(found[gap].boxes) for gap in GAPS]
        note = "boxes against 1 / gap, 1e-2 to 1e-5"
        out.append(Figure(SUBJECT, f"growth, {name}", slope([1.0 / gap for gap in GAPS], boxes), "", note=note))
    return out


def _arm(say: Callable[[str], None]) -> list[Figure]:
    out: list[Figure] = []
    for name, problem in free_arm().items():
        for gap, most in ((1e-2, 120.0), (1e-5, None)):
            say(f"{name}, gap {gap:g}")
            start = process_time()
            found = _solved(problem, gap)
            seconds = process_time() - start
            note = f"{found.boxes:,} boxes, {found.cutting_points} cutting points"
            out.append(Figure(SUBJECT, f"{name}, gap {gap:g}, warm", seconds, "s", most, note=note))
    return out


def _peer(say: Callable[[str], None]) -> list[Figure]:
    """It needs neither derivation nor compiler and takes any objective; what it finds it cannot vouch for."""
    out: list[Figure] = []
    for name, problem in {**three_variables(), **free_arm()}.items():
        if not name.startswith(("table 10", "table 11", "L_A free, step 3")):
            continue
        say(f"{PEER} on NumPy, {name}")
        theirs = peer(PEER, problem)
        start = process_time()
        own = _solved(problem, 1e-5)
        seconds = process_time() - start
        beats = theirs.objective < own.bound if problem.step == 3 else theirs.objective > own.bound
        if beats and theirs.feasible:
            raise RuntimeError(f"{name}: {PEER} found {theirs.objective:.8g}, beyond the bound {own.bound:.8g}")
        note = f"{theirs.seconds:.1f} s: {theirs.wording(own.objective)}; proves nothing, but takes any black box"
        out.append(Figure(SUBJECT, f"{PEER} against ours at 1e-5, {name}", theirs.seconds / seconds, "x", note=note))
    return out
