"""The mechanism's functions per point, beside NumPy's `solve` and `cond` on the same points, and how they grow."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np

from delta_cad import mechanism
from delta_cad.design import load_design
from delta_cad.mechanism import DeltaGeometry
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT, interleaved, ratios, slope

SUBJECT = "mechanism"
EDGE = 21  # 9,261 points
ROUNDS = 9
SIZES = (1_000, 3_000, 10_000, 30_000, 100_000)
FUNCTIONS = ("inverse_kinematics", "closure_margin", "jacobian", "worst_joint_torque", "conditioning")


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    design = load_design(ROOT / "best.json")
    g, low = design.geometry, np.array([0.0, 0.0, design.cube.bottom_height_mm / 1000.0])
    half = design.cube.half_side_mm / 1000.0
    axis = np.linspace(-half, half, EDGE)
    p = np.stack(np.meshgrid(axis, axis, axis + half, indexing="ij"), axis=-1).reshape(-1, 3) + low
    say(f"{len(FUNCTIONS)} functions and the peers on {len(p):,} points, {ROUNDS} rounds")
    functions: dict[str, Callable[[], object]] = {name: partial(_function(name), g, p) for name in FUNCTIONS}
    functions["forward_kinematics"] = partial(mechanism.forward_kinematics, g, mechanism.inverse_kinematics(g, p))
    own, peer = "margin, torque row norms and kappa", "the same by NumPy solve and cond"
    functions[own] = partial(evaluation, g, p)
    functions[peer] = partial(evaluation_by_solve, g, p)
    _agree(g, p)
    times = interleaved(functions, ROUNDS)
    figures = [of_repeats(SUBJECT, n, [t / len(p) * 1e9 for t in times[n]], "ns/point") for n in functions]
    figures.append(
        of_repeats(
            SUBJECT,
            "speed against NumPy solve and cond",
            ratios(times[peer], times[own]),
            "x",
            note="NumPy only on our side too; the compiled kernel, with >= 100x to reach, belongs to the synthesis",
        )
    )
    say("growth with the number of points")
    grown = [min(interleaved({"": partial(evaluation, g, _random(p, n))}, 3, process_time)[""]) for n in SIZES]
    note = f"{SIZES[0]:,} to {SIZES[-1]:,} points, processor time: {grown[0] * 1e3:.1f} to {grown[-1] * 1e3:.0f} ms"
    return [*figures, Figure(SUBJECT, "growth: time against points, log-log slope", slope(SIZES, grown), "", note=note)]


def _function(name: str) -> Callable[..., object]:
    """A function of the mechanism; torques for 3 N."""
    function: Callable[..., object] = getattr(mechanism, name)
    return partial(function, force=3.0) if name == "worst_joint_torque" else function


def _random(p: np.ndarray, n: int) -> np.ndarray:
    """(n, 3) of the points p (m, 3), with repeats."""
    return p[np.random.default_rng(1).integers(0, len(p), n)]


def evaluation(g: DeltaGeometry, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Reach margin (n, 3), torque for 1 N (n, 3) and kappa (n,) of points (n, 3), by the library."""
    return (
        mechanism.closure_margin(g, p),
        mechanism.worst_joint_torque(g, p, 1.0),
        mechanism.conditioning(g, p),
    )


def evaluation_by_solve(g: DeltaGeometry, p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The same as one writes it from the paper: trigonometry, `numpy.linalg.solve`, `numpy.linalg.cond`."""
    phi = g.azimuths
    a, arm, forearm = g.base_radii - g.platform_radius, g.upper_arm_length, g.forearm_length
    u = p[:, :1] * np.cos(phi) + p[:, 1:2] * np.sin(phi)
    t = p[:, 1:2] * np.cos(phi) - p[:, :1] * np.sin(phi)
    z = p[:, 2:]
    q = u - a
    m = (q**2 + t**2 + z**2 + arm**2 - forearm**2) / (2.0 * arm)
    margin = q**2 + z**2 - m**2
    theta = np.arctan2(z, q) - np.arctan2(np.sqrt(margin), m)
    s = np.stack(
        [
            (q - arm * np.cos(theta)) * np.cos(phi) - t * np.sin(phi),
            (q - arm * np.cos(theta)) * np.sin(phi) + t * np.cos(phi),
            z - arm * np.sin(theta),
        ],
        axis=-1,
    )
    lever = arm * (z * np.cos(theta) - q * np.sin(theta))
    jacobian = np.linalg.solve(s, lever[..., None] * np.eye(3))
    return margin, np.linalg.norm(jacobian, axis=1), np.linalg.cond(jacobian)


def _agree(g: DeltaGeometry, p: np.ndarray) -> None:
    """Both ways must come to the same, or their times say nothing.

    Raises:
        RuntimeError: They do not.
    """
    for own, theirs in zip(evaluation(g, p), evaluation_by_solve(g, p), strict=True):
        if not np.allclose(own, theirs, rtol=1e-8):  # kappa is below 10 here: 1e-15 times that, with room
            raise RuntimeError("the library and NumPy solve and cond disagree: nothing to compare")
