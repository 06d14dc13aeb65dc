"""Passivity of a rendered wall, and what holds where it is not passive: three verdicts that are kept apart.

The wall as a sampled-data system, v(t) -> f(t): the position is sampled, `u_k` follows by the filter
`H(z) = K + B E(z)`, is held, delayed and passed through the motor's lag. In one period `f(t) = s_z(t) u` for a signal
z^k, where s_z is the shape of the hold: 1 for an undelayed one, `1/z` before the delay's fraction has passed, and
exponentials between them with a lag. With W = H(z) z^-n / (z - 1) the displacement of one period makes
`u = W * (integral of v)`, so the wall is the operator `g <1, .>` with `g = W s_z` on a period's velocities: of rank
one, its Hermitian part of rank two. Device friction b makes it passive if and only if at each frequency

    b >= ( sqrt( Re(W S)^2 + |W|^2 V ) - Re(W S) ) / 2,   S = integral of s_z,   V = T integral |s_z|^2 - |S|^2.

For a plain hold V = 0 and S = T, which leaves `-T Re W`: the condition of Colgate and Schenkel,
`b > T / (2 (1 - cos wT)) Re{(1 - e^-jwT) H(e^jwT)}`. Whole delays, filters and the shape of the hold are exact. The
device's mass does not enter. Of a spring and a backward difference without delay `b > K T / 2 + |B|` is left.

`handle` and `strain` ask the same of a device with compliance between handle and drives. A force f at the handle and
the velocity v there, in the frequencies w + 2 pi k / T that a sampler mixes. With G the device's transfer functions, H
the wall's filter and h the hold with its delay,

    v_k = Y_k f_k - c a_k sum_j b_j f_j,   a = G_vu h,  b = G_yf,  c = H / (T (1 + H P)),  P = sum G_yu h / T.

It takes energy at every f if and only if `D - Re(c a b^T)` is positive, D = Re Y_k: diagonal less rank two, so that the
question is one number, the largest eigenvalue of the second in the metric of the first:

    2 lambda = Re s + sqrt(|x|^2 |y|^2 - (Im s)^2),
    s = c sum a b / D,  |x|^2 = |c|^2 sum |a|^2 / D,  |y|^2 = sum |b|^2 / D.

lambda <= 1 at all w below pi / T, and a loop that is stable by itself: passive with any hand that is. On a rigid axis
this is the condition of Colgate and Schenkel, b > K T / 2 + B, with its terms for delay, lag and filter, which
`friction_demand` has. Averaged, k is 0 alone: `Re v_0 / f_0 >= 0`, what a measurement of the impedance would show;
frequencies folded by the sampler are left out, which a hand hardly has.

Source:
    J. E. Colgate, G. G. Schenkel, "Passivity of a class of sampled-data systems: application to haptic interfaces",
    Journal of Robotic Systems 14(1), 1997 (not opened), for the rigid axis; the terms for a fraction of a period, for
    the lag and for compliance are derived above.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from haptics.loop.discrete import LinearEstimator, Ports, SampledBody, Timing, axis, continuous, sampled_loop

if TYPE_CHECKING:
    from haptics.model.plant import Hand

# Lowest frequency of the grid as a share of pi / T. Below it the demand is that at 0 to its square, 1e-8 (it is even in
# the frequency), unless a filter's corner lies below 1e-4 of it, 0.05 Hz at 1 kHz.
_LOWEST = 1e-4
# Points of the first grid; points of each refinement of the interval about the best one, which shrinks by SHRINK each
# round: after 8 rounds the frequency is known to 1e-9 of its place. The maximum is refined, not enclosed: a peak
# narrower than the first grid's step, which no filter of first order and no window below 100 samples can make, could be
# missed.
GRID, _REFINED, _SHRINK, _ROUNDS = 1024, 33, 16.0, 8


class PassivityClass(StrEnum):
    """Class of a wall, from the strictest promise to none."""

    PASSIVE = "PASSIVE"
    STABLE_WITH_HAND_SET = "STABLE_WITH_HAND_SET"
    FAILS = "FAILS"


class _Demand(NamedTuple):
    """Friction that passivity asks of a device.

    Attributes:
        friction: The most that any frequency asks for, N s/m.
        frequency: Where, rad/s.
    """

    friction: float
    frequency: float


@dataclass(frozen=True)
class Verdict:
    """What is known of a wall of one axis.

    Attributes:
        kind: PASSIVE: with any passive hand, steady or not; STABLE_WITH_HAND_SET: not passive, but each hand of the set
            makes a stable linear loop; FAILS: at least one hand of the set does not.
        friction: Friction of the device, N s/m.
        demand: What passivity asks for.
        missing_friction: By how much the device falls short, N s/m; 0 where it is passive.
        radii: Spectral radius with each hand.
        spectral_margin: Smallest `1 - radius` of the set.
        worst_hand: Hand with that radius.
        reason: Explanation with its figures.
    """

    kind: PassivityClass
    friction: float
    demand: _Demand
    missing_friction: float
    radii: dict[str, float]
    spectral_margin: float
    worst_hand: str
    reason: str


def friction_demand(
    frequency: np.ndarray, timing: Timing, estimator: LinearEstimator, stiffness: float, damping: float
) -> np.ndarray:
    """Friction that passivity asks for at each frequency.

    Args:
        frequency: (...) rad/s, above 0 and up to pi / T.
        timing: Period, delay, lag.
        estimator: Estimator of the velocity.
        stiffness: K, N/m.
        damping: B, N s/m.

    Returns:
        (...) N s/m, none negative.
    """
    T, part = timing.period, timing.fraction
    back = np.exp(-1j * np.asarray(frequency, dtype=float) * T)  # 1 / z
    step = 1.0 - back
    own, square = _deficit(timing, back)
    wall = (stiffness + damping * estimator.response(1.0 / back)) * back ** (timing.whole_periods + 1) / step  # W
    passed = (wall * (T - step * own)).real  # Re(W S); the hold's shape is 1 - (1 - 1/z) r(t)
    spread = np.abs(wall * step) ** 2 * np.maximum(T * square - np.abs(own) ** 2, 0.0)  # |W|^2 V, no cancellation
    if part == 0.0 and timing.current_lag == 0.0:
        return np.maximum(-passed, 0.0)
    root = np.sqrt(passed**2 + spread)
    # the same twice: each form where it does not cancel
    return np.where(passed > 0.0, spread / np.maximum(2.0 * (root + passed), 1e-300), (root - passed) / 2.0)


def _deficit(timing: Timing, back: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Integrals over a period of r and |r|^2, s, where the hold's shape is `1 - (1 - 1/z) r(t)`: what of the last
    change has not arrived.
    """
    T, lag, part = timing.period, timing.current_lag, timing.fraction
    early, late = part * T, (1.0 - part) * T
    if lag == 0.0:
        return early + 0.0 * back, np.full(back.shape, early)
    q, after = math.exp(-T / lag), math.exp(-late / lag)
    memory = 1.0 / (1.0 - back * q)
    carried = back * after * memory
    own = early + lag * (carried * -math.expm1(-early / lag) + memory * -math.expm1(-late / lag))
    square = early + 2.0 * carried.real * lag * -math.expm1(-early / lag)
    square = square + np.abs(carried) ** 2 * lag / 2.0 * -math.expm1(-2.0 * early / lag)
    square = square + np.abs(memory) ** 2 * lag / 2.0 * -math.expm1(-2.0 * late / lag)
    return own, square


def required_friction(timing: Timing, estimator: LinearEstimator, stiffness: float, damping: float) -> _Demand:
    """The most friction that any frequency asks for: the maximum on a grid, refined about its best points.

    Args:
        timing: Period, delay, lag.
        estimator: Estimator of the velocity.
        stiffness: K, N/m.
        damping: B, N s/m.

    Returns:
        The demand and its frequency; by refining a grid, not enclosed (`GRID`).
    """
    top = math.pi / timing.period
    grid = np.concatenate([np.geomspace(_LOWEST * top, top / 100.0, GRID // 4), np.linspace(top / 100.0, top, GRID)])

    def demand(frequency: np.ndarray) -> np.ndarray:
        return friction_demand(frequency, timing, estimator, stiffness, damping)

    values = demand(grid)
    inner = values[1:-1]
    peaks = np.flatnonzero((inner >= values[:-2]) & (inner >= values[2:])) + 1
    starts = {0, len(grid) - 1, *peaks[np.argsort(values[peaks])[-4:]].tolist()}
    return max((_refined(demand, grid, i) for i in starts), key=lambda peak: peak.friction)


def _refined(demand, grid: np.ndarray, i: int) -> _Demand:
    low, high = float(grid[max(i - 1, 0)]), float(grid[min(i + 1, len(grid) - 1)])
    best = _Demand(float(demand(grid[i : i + 1])[0]), float(grid[i]))
    for _ in range(_ROUNDS):
        points = np.linspace(low, high, _REFINED)
        values = demand(points)
        j = int(np.argmax(values))
        if values[j] > best.friction:
            best = _Demand(float(values[j]), float(points[j]))
        half = (high - low) / (2.0 * _SHRINK)
        low, high = max(low, best.frequency - half), min(high, best.frequency + half)
    return best


def verdict(
    mass: float,
    friction: float,
    timing: Timing,
    estimator: LinearEstimator,
    stiffness: float,
    damping: float,
    hands: Mapping[str, Hand],
) -> Verdict:
    """What is known of a wall of one axis.

    Args:
        mass: Effective mass of the device, kg.
        friction: Viscous friction of the device, N s/m; Coulomb friction is not counted on.
        timing: Period, delay, lag.
        estimator: Estimator of the velocity.
        stiffness: K, N/m.
        damping: B, N s/m.
        hands: The set, by name.

    Returns:
        The verdict, with both margins whatever it is.

    Raises:
        ValueError: No hand is given, or mass or friction cannot be.
    """
    if not hands:
        raise ValueError("the set of hands is empty; at least one is needed")
    demand = required_friction(timing, estimator, stiffness, damping)
    radii = {
        name: float(sampled_loop(axis(mass, friction, hand), timing, estimator).radius(stiffness, damping))
        for name, hand in hands.items()
    }
    worst = max(radii, key=lambda name: radii[name])
    margin = 1.0 - radii[worst]
    passive = friction > demand.friction
    kind = (
        PassivityClass.PASSIVE
        if passive
        else PassivityClass.STABLE_WITH_HAND_SET
        if margin > 0.0
        else PassivityClass.FAILS
    )
    at = f"{demand.frequency / (2.0 * math.pi):.3g} Hz"
    asks = f"passivity asks for {demand.friction:.3g} N s/m of friction (at {at})"
    if passive:
        reason = f"{asks} and the device has {friction:.3g}: no passive hand makes it unstable"
    else:
        short = f"{asks}, the device has {friction:.3g}; "
        if kind is PassivityClass.STABLE_WITH_HAND_SET:
            reason = f"{short}yet each of {len(hands)} hands makes a stable loop, the {worst} one by {margin:.3g}"
        else:
            reason = f"{short}and with the {worst} hand an oscillation grows by {-margin:.3g} of itself each period"
    missing = 0.0 if passive else demand.friction - friction
    return Verdict(kind, friction, demand, missing, radii, margin, worst, reason)


# Frequencies from `_LOWEST` of pi / T on, evenly in the logarithm, half of them in the upper decade; aliases to each
# side: the sums' terms fall with the square of k and faster, so that what is left out is below 1 %.
_FREQUENCIES, ALIASES = 600, 48


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
    rate, required = continuous(body, ports.push, timing.current_lag)
    size = len(rate)
    forced = np.zeros(size)
    forced[n : 2 * n] = np.linalg.solve(body.mass, place)
    roots, shapes = np.linalg.eig(rate + 1e-9 * np.diag(np.arange(size)))  # apart, so that it can be diagonalised
    by_hand, by_command = np.linalg.solve(shapes, forced + 0j), np.linalg.solve(shapes, required[:, 0] + 0j)
    way, speed = np.zeros(size), np.zeros(size)
    way[:n], speed[n : 2 * n] = ports.see[0], place
    top = math.pi / T
    low, high = (
        np.geomspace(_LOWEST * top, 0.1 * top, _FREQUENCIES // 2),
        np.linspace(0.1 * top, top, _FREQUENCIES // 2),
    )
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
