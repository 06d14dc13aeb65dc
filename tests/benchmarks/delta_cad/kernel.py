"""The compiled kernel: points a second, against NumPy's `solve` and `cond`, and as a share of the core's peak."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np

from delta_cad.mechanism import Cube, DeltaGeometry, cube_grid
from tests.benchmarks.delta_cad.mechanism_time import evaluation_by_solve
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import interleaved, ratios, slope

SUBJECT = "evaluation kernel"
PUBLISHED, CUBE = DeltaGeometry(0.040, 0.030, 0.082, 0.112079), Cube(0.057112, 0.0375)
EDGE = 21  # 9,261 points
ROUNDS = 15
SIZES = (1_000, 10_000, 100_000, 1_000_000)
FLOP = 370  # +, -, *, / and square roots a point, counted in the source; squares hoisted out of the loop are not
DIVISIONS, ROOTS = 17, 11  # a point, among them; the count of vdivpd and vsqrtpd in the one vector loop there is
TERMS = 64  # of the polynomial whose speed stands for the core's peak


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    from delta_cad.mechanism import kernel

    p = cube_grid(CUBE, EDGE)
    say("compiling, or reading the cache")
    ours = kernel.figures(PUBLISHED, p)
    margin, arms, kappa = evaluation_by_solve(PUBLISHED, p)
    for mine, theirs in ((ours.closure_margin, margin.min(axis=1)), (ours.torque_arms, arms), (ours.kappa, kappa)):
        if not np.allclose(mine, theirs, rtol=1e-10):  # kappa is below 3 here
            raise RuntimeError("the kernel and NumPy solve and cond disagree: nothing to compare")
    say(f"{len(p):,} points, {ROUNDS} rounds")
    horner, room = _peak(), np.linspace(0.0, 0.5, 1024)
    divide, root = _divider()
    numbers, results = np.linspace(1.0, 2.0, 1024), np.empty(1024)
    coordinates, out = np.ascontiguousarray(p.T), np.empty((5, len(p)))
    times = interleaved(
        {
            # ten times, for the clock's sake
            "kernel": lambda: [kernel.figures_into(PUBLISHED, coordinates, out) for _ in range(10)],
            "figures": lambda: [kernel.figures(PUBLISHED, p) for _ in range(10)],
            "numpy": partial(evaluation_by_solve, PUBLISHED, p),
            "peak": lambda: horner(room, 2_000),
            "divisions": lambda: divide(numbers, results, 2_000),
            "roots": lambda: root(numbers, results, 2_000),
        },
        ROUNDS,
        process_time,  # one thread, and the machine is shared
    )
    seconds = [t / 10 for t in times["kernel"]]
    rate = [len(p) / t for t in seconds]
    peak = [2.0 * TERMS * len(room) * 2_000 / t for t in times["peak"]]
    share = [100.0 * FLOP * r / top for r, top in zip(rate, peak, strict=True)]
    alone = [
        (DIVISIONS * d + ROOTS * r) / (len(room) * 2_000)
        for d, r in zip(times["divisions"], times["roots"], strict=True)
    ]
    divider = [100.0 * a * r for a, r in zip(alone, rate, strict=True)]
    say("growth with the number of points")
    rng = np.random.default_rng(1)
    grown = []
    for n in SIZES:
        some = p[rng.integers(0, len(p), n)]
        repeat = SIZES[-1] // n
        clock = interleaved(
            {"": lambda s=some, r=repeat: [kernel.figures(PUBLISHED, s) for _ in range(r)]}, 3, process_time
        )
        grown.append(min(clock[""]) / repeat)
    return [
        of_repeats(SUBJECT, "points a second and core", [r / 1e6 for r in rate], "M/s", 65.0, False, "room used again"),
        of_repeats(
            SUBJECT,
            "speed against NumPy solve and cond",
            ratios(times["numpy"], seconds),
            "x",
            100.0,
            False,
            "same points",
        ),
        of_repeats(
            SUBJECT,
            "points a second and core, new arrays at each call",
            [len(p) / (t / 10) / 1e6 for t in times["figures"]],
            "M/s",
        ),
        of_repeats(
            SUBJECT,
            "share of the core's peak",
            share,
            "%",
            note=f"{FLOP} flop a point against fused Horner of {TERMS} terms, {np.median(peak) / 1e9:.0f} Gflop/s",
        ),
        of_repeats(
            SUBJECT,
            "share of the time in which the core's divider is busy",
            divider,
            "%",
            note=f"{DIVISIONS} divisions and {ROOTS} square roots a point, which alone would allow "
            f"{1e-6 / np.median(alone):.0f} M points/s",
        ),
        Figure(
            SUBJECT,
            "growth: time against points, log-log slope",
            slope(SIZES, grown),
            "",
            note=f"{SIZES[0]:,} to {SIZES[-1]:,} points, processor time",
        ),
    ]


def _peak() -> Callable[[np.ndarray, int], object]:
    """A compiled polynomial over an array in the first cache: as many fused operations as the core can do."""
    from numba import njit  # noqa: TID251 - the fused operations that our own code must not have

    @njit(fastmath={"contract"})
    def horner(x: np.ndarray, rounds: int) -> float:
        total, a, b, half = 0.0, 0.5, 0.25, len(x) // 2
        for _ in range(rounds):
            for k in range(half):
                # two at a time, so that no operation waits for another's end
                u, v = x[k], x[k + half]
                # written out, or the compiler makes the wrong loop the inner one
                for _ in range(TERMS // 8):
                    u, v = (u * a + b) * a + b, (v * a + b) * a + b
                    u, v = (u * a + b) * a + b, (v * a + b) * a + b
                    u, v = (u * a + b) * a + b, (v * a + b) * a + b
                    u, v = (u * a + b) * a + b, (v * a + b) * a + b
                x[k], x[k + half] = u, v
            total += x[0]
        return total

    horner(np.zeros(8), 1)
    return horner


def _divider() -> tuple[Callable[[np.ndarray, np.ndarray, int], object], ...]:
    """Compiled loops of nothing but divisions and of nothing but square roots, over arrays in the first cache."""
    from numba import njit  # noqa: TID251 - outside of what is kept

    @njit(error_model="numpy")
    def divide(x: np.ndarray, out: np.ndarray, rounds: int) -> None:
        for n in range(rounds):
            for k in range(len(x)):
                out[k] = n / x[k]

    @njit(error_model="numpy")
    def root(x: np.ndarray, out: np.ndarray, rounds: int) -> None:
        for n in range(rounds):
            for k in range(len(x)):
                out[k] = np.sqrt(n + x[k])

    for function in (divide, root):
        function(np.ones(8), np.ones(8), 1)
    return divide, root
