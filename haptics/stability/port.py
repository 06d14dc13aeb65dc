"""Passivity of a device with its wall at the handle, whatever gives way between: exact, and averaged.

A force f at the handle and the velocity v there, in the frequencies w + 2 pi k / T that a sampler mixes. With G the
device's transfer functions, H the wall's filter and h the hold with its delay,

    v_k = Y_k f_k - c a_k sum_j b_j f_j,   a = G_vu h,  b = G_yf,  c = H / (T (1 + H P)),  P = sum G_yu h / T.

It takes energy at every f if and only if `D - Re(c a b^T)` is positive, D = Re Y_k: diagonal less rank two, so that the
question is one number, the largest eigenvalue of the second in the metric of the first:

    2 lambda = Re s + sqrt(|x|^2 |y|^2 - (Im s)^2),
    s = c sum a b / D,  |x|^2 = |c|^2 sum |a|^2 / D,  |y|^2 = sum |b|^2 / D.

lambda <= 1 at all w below pi / T, and a loop that is stable by itself: passive with any hand that is. On a rigid axis
this is the condition of Colgate and Schenkel, b > K T / 2 + B, with its terms for delay, lag and filter (`passivity`).
Averaged, k is 0 alone: `Re v_0 / f_0 >= 0`, what a measurement of the impedance would show; frequencies folded by the
sampler are left out, which a hand hardly has.

Source:
    J. E. Colgate, G. G. Schenkel, Journal of Robotic Systems 14(1), 1997 (not opened), for the rigid axis; derived
    above for the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from haptics.stability.bodies import Ports, SampledBody, continuous
from haptics.stability.discrete import Timing
from haptics.stability.estimator_models import LinearEstimator

# Frequencies from `LOWEST` of pi / T on, evenly in the logarithm, half of them in the upper decade; aliases to each
# side: the sums' terms fall with the square of k and faster, so that what is left out is below 1 %.
FREQUENCIES, LOWEST, ALIASES = 600, 1e-4, 48


@dataclass(frozen=True)
class Handle:
    """A device at its handle, along one direction, over frequencies and their aliases; each (n, 2 ALIASES + 1).

    Attributes:
        frequency: (n,) w, rad/s, up to pi / T.
        own: Y, handle's velocity by its force, m/(N s).
        pushed: G_vu h, its velocity by a command, m/N.
        seen: G_yf, what is read by its force, m/N.
        moved: G_yu h / T, what is read by a command, m/N.
        filter_z: (n,) e^(jwT).
        period: T, s.
    """

    frequency: np.ndarray
    own: np.ndarray
    pushed: np.ndarray
    seen: np.ndarray
    moved: np.ndarray
    filter_z: np.ndarray
    period: float


def handle(body: SampledBody, ports: Ports, place: np.ndarray, timing: Timing) -> Handle:
    """A device at its handle.

    Args:
        body: Device without a hand, n coordinates.
        ports: Of the wall's command and what it reads, m = 1.
        place: (n,) row of the handle's way along the wall's normal.
        timing: Period, delay, lag.
    """
    n, T = len(body.mass), timing.period
    rate, asked = continuous(body, ports.push, timing.current_lag)
    size = len(rate)
    forced = np.zeros(size)
    forced[n : 2 * n] = np.linalg.solve(body.mass, place)
    roots, shapes = np.linalg.eig(rate + 1e-9 * np.diag(np.arange(size)))  # apart, so that it can be diagonalised
    by_hand, by_command = np.linalg.solve(shapes, forced + 0j), np.linalg.solve(shapes, asked[:, 0] + 0j)
    way, speed = np.zeros(size), np.zeros(size)
    way[:n], speed[n : 2 * n] = ports.see[0], place
    top = math.pi / T
    low, high = np.geomspace(LOWEST * top, 0.1 * top, FREQUENCIES // 2), np.linspace(0.1 * top, top, FREQUENCIES // 2)
    w = np.concatenate([low[:-1], high])
    s = 1j * (w[:, None] + 2.0 * math.pi / T * np.arange(-ALIASES, ALIASES + 1))
    hold = (1.0 - np.exp(-s * T)) / s * np.exp(-s * timing.delay)

    def response(seen: np.ndarray, by: np.ndarray) -> np.ndarray:
        weights = (seen @ shapes) * by
        total = np.zeros(s.shape, dtype=complex)
        for weight, root in zip(weights, roots, strict=True):
            total += weight / (s - root)
        return total

    return Handle(
        frequency=w,
        own=response(speed, by_hand),
        pushed=response(speed, by_command) * hold,
        seen=response(way, by_hand),
        moved=response(way, by_command) * hold / T,
        filter_z=np.exp(1j * w * T),
        period=T,
    )


def strain(at: Handle, estimator: LinearEstimator, stiffness: float, damping: float) -> np.ndarray:
    """How near to active a wall is at each frequency: passive up to 1, exact for the sampled loop.

    Args:
        at: The device at its handle.
        estimator: Of the velocity.
        stiffness: K, N/m.
        damping: B, N s/m.

    Returns:
        (n,) lambda; infinite where the device takes nothing at a frequency by itself.
    """
    law = stiffness + damping * estimator.response(at.filter_z)
    c = law / (at.period * (1.0 + law * at.moved.sum(axis=1)))
    weight = np.real(at.own)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = c * (at.pushed * at.seen / weight).sum(axis=1)
        x2 = np.abs(c) ** 2 * (np.abs(at.pushed) ** 2 / weight).sum(axis=1)
        y2 = (np.abs(at.seen) ** 2 / weight).sum(axis=1)
        found = (np.real(s) + np.sqrt(np.maximum(x2 * y2 - np.imag(s) ** 2, 0.0))) / 2.0
    return np.where((weight > 0.0).all(axis=1) & np.isfinite(found), found, np.inf)


def impedance(at: Handle, estimator: LinearEstimator, stiffness: float, damping: float) -> np.ndarray:
    """Averaged impedance at the handle, (n,) complex N s/m: force over velocity at the frequency itself."""
    zero = ALIASES
    law = stiffness + damping * estimator.response(at.filter_z)
    closed = law / (at.period * (1.0 + law * at.moved[:, zero]))
    return 1.0 / (at.own[:, zero] - closed * at.pushed[:, zero] * at.seen[:, zero])
