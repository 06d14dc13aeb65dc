"""Certificates: boxes and time, warm and cold, its replay, random designs, 10 million points against one."""

from __future__ import annotations

from collections.abc import Callable
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np

from delta_cad.design import load_design
from delta_cad.mechanism import Cube, CubeExtremes, DeltaGeometry, MechanismError, cube_extremes, joint_angles, rod_lean
from delta_cad.mechanism.limits import AssemblyMode, Kappa, Lean, Limits, Reach, Shoulder, Torque
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT, interleaved, python, succeeded

SUBJECT = "certificates"
PUBLISHED, CUBE = DeltaGeometry(0.040, 0.030, 0.082, 0.112079), Cube(0.057112, 0.0375)
ROUNDS = 15
DESIGNS = 300
POINTS = 10_000_000
COLD = """
import os, sys, time
os.environ["NUMBA_CACHE_DIR"] = sys.argv[1]
start = time.perf_counter()
from delta_cad.mechanism import Cube, DeltaGeometry
from delta_cad.mechanism.limits import Kappa, Limits, AssemblyMode, Torque
from delta_cad.mechanism.proof.prove import prove
limits = Limits.of(AssemblyMode(), Torque(force=3.0, torque_max=0.8), Kappa(3.0))
prove(DeltaGeometry(0.040, 0.030, 0.082, 0.112079), Cube(0.057112, 0.0375), limits)
print(time.perf_counter() - start)
"""


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    say("cold start: nothing compiled")
    with TemporaryDirectory() as empty:
        cold, warm = (float(succeeded(python("-c", COLD, empty)).stdout) for _ in range(2))
    return [
        *_published(say),
        Figure(SUBJECT, "first proof of a process, nothing compiled", cold, "s", 20.0),
        Figure(SUBJECT, "first proof of a process, compiled before", warm, "s", note="imports and reading the cache"),
        *_random(say),
    ]


def limits_near(e: CubeExtremes, factor: float) -> Limits:
    """All six conditions at the extremes times a factor."""
    return Limits.of(
        Reach(float(np.sqrt(e.closure_margin_min.value)) / factor),
        AssemblyMode(),
        Torque(force=3.0, torque_max=e.torque_max.value * factor),
        Kappa(e.kappa_max.value * factor),
        Shoulder(e.shoulder_min.value - (factor - 1.0), e.shoulder_max.value + (factor - 1.0)),
        Lean(min(e.lean_max.value * factor, 1.57)),
    )


def _published(say: Callable[[str], None]) -> list[Figure]:
    from delta_cad.mechanism.proof.prove import prove
    from optimizer.certify.certificate import certify, verify
    from optimizer.problem.evaluator import figures

    limits = limits_near(cube_extremes(PUBLISHED, CUBE, 3.0), 1.001)
    say("proof and replay of the published design 0.1 % above its extremes")
    proof = prove(PUBLISHED, CUBE, limits)
    if proof.verdict != "proved":
        raise RuntimeError(f"the published design 0.1 % above its extremes is {proof.verdict}")
    design = load_design(ROOT / "examples/synthesized.json")
    certificate = certify(design)
    times = interleaved(
        {
            "prove": lambda: prove(PUBLISHED, CUBE, limits),
            "certify": lambda: certify(design),
            "verify": lambda: verify(certificate, design),
        },
        ROUNDS,
    )
    say(f"{POINTS:,} points against the proof")
    reach, torque, kappa, angles, lean = (limits.get(kind) for kind in (Reach, Torque, Kappa, Shoulder, Lean))
    rng, worst = np.random.default_rng(1), np.full(6, np.inf)
    lengths = (PUBLISHED.upper_arm_length, PUBLISHED.forearm_length, PUBLISHED.base_radius, PUBLISHED.platform_radius)
    machine = np.array([[*lengths, CUBE.bottom_height, CUBE.half_side]])
    for _ in range(POINTS // 1_000_000):
        unit = rng.uniform(-1.0, 1.0, (1_000_000, 3))
        face = rng.integers(0, 3, 500_000)
        unit[np.arange(500_000), face] = np.sign(unit[np.arange(500_000), face])
        p = np.clip(
            np.array([0.0, 0.0, CUBE.bottom_height + CUBE.half_side]) + CUBE.half_side * unit, CUBE.lower, CUBE.upper
        )
        found = figures(machine, unit)
        theta = joint_angles(PUBLISHED, p)
        margins = (
            PUBLISHED.forearm_length**2 * found.closure - reach.elbow_arm_min**2,
            torque.torque_max - torque.force * found.moment / found.determinant,
            kappa.kappa_max - 1.0 / found.quality,
            theta - angles.shoulder_min,
            angles.shoulder_max - theta,
            lean.lean_max - np.abs(rod_lean(PUBLISHED, p)),
        )
        worst = np.minimum(worst, [m.min() for m in margins])
    if not (worst >= 0.0).all():
        raise RuntimeError("a point violates a design that was proved")
    return [
        of_repeats(SUBJECT, "proof at 0.1 %, warm", [1e3 * t for t in times["prove"]], "ms", 20.0),
        Figure(
            SUBJECT, "boxes of that proof", proof.boxes, "", 5_000, note="six conditions, half the cube by symmetry"
        ),
        of_repeats(SUBJECT, "certificate of the committed design", [1e3 * t for t in times["certify"]], "ms", 20.0),
        of_repeats(SUBJECT, "replay of the committed design's, NumPy", times["verify"], "s"),
        Figure(
            SUBJECT, "violations in random points of the proved cube", 0, "", 0, note=f"{POINTS:,}, half on the surface"
        ),
    ]


def _random(say: Callable[[str], None]) -> list[Figure]:
    """Random designs at 0.1 % and 1 % below."""
    from delta_cad.mechanism.proof.prove import prove

    rng, seconds, undecided, kept = np.random.default_rng(2), [], 0, 0
    while len(seconds) < DESIGNS:
        a, lb, bottom, half = rng.uniform([-0.02, 0.06, 0.02, 0.01], [0.04, 0.25, 0.2, 0.06])
        g, cube = DeltaGeometry(a + 0.05, 0.05, 0.082, lb), Cube(bottom, half)
        try:
            e = cube_extremes(g, cube, 3.0, 15)
        except MechanismError:
            continue
        if not e.kappa_max.value < 50.0:
            continue
        start = perf_counter()
        above = prove(g, cube, limits_near(e, 1.001))
        seconds.append(perf_counter() - start)
        undecided += above.verdict == "undecided"
        kept += (
            prove(g, cube, Limits.of(AssemblyMode(), Torque(force=3.0, torque_max=e.torque_max.value * 0.99))).verdict
            != "refuted"
        )
        if len(seconds) % 50 == 0:
            say(f"{len(seconds)} of {DESIGNS} random designs")
    return [
        Figure(
            SUBJECT, "random designs left undecided at 0.1 %", undecided, "", 0, note=f"of {DESIGNS}, kappa below 50"
        ),
        Figure(SUBJECT, "random designs not refuted 1 % below", kept, "", 0, note="by their torque"),
        of_repeats(SUBJECT, "proof of a random design at 0.1 %", [1e3 * t for t in seconds], "ms"),
    ]
