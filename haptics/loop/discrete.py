"""Exact discrete-time model of a sampled haptic loop, its eigenvalues, and the largest stable gains.

Between samples `M q'' + D q' + S q = P f`: device and hand, whatever gives way between them as springs and dampers.
Every period the controller reads y = C q, estimates its rate and asks for `u = -(K y + B rate)`. u is held for a
period and arrives `delay` later: whole periods and a fraction. The motor follows as `f' = (u - f) / lag`, or at once.
Matrix exponentials carry the state over a period, in two steps where the held value changes within it; nothing is
approximated. Left out, because the model is linear: Coulomb friction, quantisation, saturation, leaving the wall.

The loop matrix is affine in K and B, so gains are scanned as stacks of matrices.

A body grows by what is attached to a place `L q` of it: a mass behind a spring and damper, or a spring and damper to
ground. Velocity estimators are linear filters here, made from those of `haptics.control.filters`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import expm

if TYPE_CHECKING:
    from haptics.control.filters import Estimator
    from haptics.model.plant import Hand

# Eigenvalues as near to 1 as this count as at rest: they would need 1e5 periods, 100 s at 1 kHz, to move by e. A free
# handle has such modes (it may rest anywhere), and rounding splits a double one by the root of 1e-16.
_NEUTRAL = 1e-5
_ALIGNED = 1e-9  # Share of a period below which a rest of a delay is rounding
# Range of gains that is scanned, as a share of m / T^2 and m / T. With one sample a spring above 4 m / T^2 or a damper
# above 2 m / T throws the handle over in one period; delays and filters lower that. A millionth is below 1 N/m.
_SCAN = (1e-6, 10.0)
_GROWTH = 1e-10  # Spectral radius above 1 that rounding may cause: single eigenvalues are computed to 1e-13 or better


@dataclass(frozen=True)
class Timing:
    """When a held command arrives.

    Attributes:
        period: s.
        delay: From the sample to the command's arrival, s.
        current_lag: Time constant of the current loop, s; 0 for none.

    Raises:
        ValueError: The period is not positive, or another is negative.
    """

    period: float = 1e-3
    delay: float = 0.0
    current_lag: float = 0.0

    def __post_init__(self) -> None:
        figures = (self.period, self.delay, self.current_lag)
        if not all(math.isfinite(f) and f >= 0.0 for f in figures) or not self.period > 0.0:
            raise ValueError(f"{self}: all must be finite, none negative, and the period positive")

    @property
    def whole_periods(self) -> int:
        """Whole periods of the delay."""
        return math.floor(self.delay / self.period + _ALIGNED)

    @property
    def fraction(self) -> float:
        """The rest of the delay as a share of a period, 0 up to 1."""
        rest = self.delay / self.period - self.whole_periods
        return rest if rest > _ALIGNED else 0.0


@dataclass(frozen=True)
class SampledLoop:
    """Transition of the closed loop over one period, affine in the gains.

    Attributes:
        free: (N, N) without gains.
        by_stiffness: (N, N) to be multiplied with K.
        by_damping: (N, N) to be multiplied with B.
        scale: Mass that the gains see, kg; `m / T^2` and `m / T` are the scales of K and B.
        period: s.
        ask: (2, m, N + m) command as it depends on the state and on an error of what is read, for K = 1 and B = 1.
        error: (3, N, m) what an error of what is read adds to the state: without gains, for K = 1, for B = 1.
    """

    free: np.ndarray
    by_stiffness: np.ndarray
    by_damping: np.ndarray
    scale: float
    period: float
    ask: np.ndarray
    error: np.ndarray

    def matrix(self, stiffness: float | np.ndarray, damping: float | np.ndarray) -> np.ndarray:
        """Transition matrices.

        Args:
            stiffness: K, (...) N/m.
            damping: B, (...) N s/m.

        Returns:
            (..., N, N).
        """
        k, b = (np.asarray(g, dtype=float)[..., None, None] for g in (stiffness, damping))
        return self.free + k * self.by_stiffness + b * self.by_damping

    def eigenvalues(self, stiffness: float | np.ndarray, damping: float | np.ndarray) -> np.ndarray:
        """Eigenvalues of the transition, (..., N) complex."""
        return np.linalg.eigvals(self.matrix(stiffness, damping)).astype(complex)

    def radius(self, stiffness: float | np.ndarray, damping: float | np.ndarray) -> np.ndarray:
        """Largest modulus of an eigenvalue that is not at rest (`_NEUTRAL`), (...); below 1 is stable."""
        z = self.eigenvalues(stiffness, damping)
        return np.where(np.abs(z - 1.0) > _NEUTRAL, np.abs(z), 0.0).max(axis=-1)

    def stiffness_limit(self, damping: float = 0.0) -> StableGains:
        """Stable stiffnesses at a damping, N/m."""
        unit = self.scale / self.period**2
        return limits(lambda k: self.radius(k, damping), _SCAN[0] * unit, _SCAN[1] * unit)

    def damping_limit(self, stiffness: float = 0.0) -> StableGains:
        """Stable dampings at a stiffness, N s/m."""
        unit = self.scale / self.period
        return limits(lambda b: self.radius(stiffness, b), _SCAN[0] * unit, _SCAN[1] * unit)


class StableGains(NamedTuple):
    """Range of gains that are stable.

    Attributes:
        intervals: Stable intervals, ascending; those that begin at the foot of the scan begin at 0.
        reach: Top of the scan.
    """

    intervals: tuple[tuple[float, float], ...]
    reach: float

    @property
    def value(self) -> float:
        """Largest gain up to which all are stable; 0 where small gains are unstable already."""
        return self.intervals[0][1] if self.intervals and self.intervals[0][0] == 0.0 else 0.0

    @property
    def first(self) -> float:
        """Top of the lowest stable interval, wherever that begins; 0 where there is none."""
        return self.intervals[0][1] if self.intervals else 0.0


def sampled_loop(
    body: SampledBody,
    timing: Timing,
    estimator: LinearEstimator,
    ports: Ports | None = None,
    scale: float | None = None,
) -> SampledLoop:
    """The closed loop over one period.

    Args:
        body: Device and hand, n coordinates.
        timing: Period, delay, lag.
        estimator: Estimator of the rate of each of the m things read.
        ports: Where the commands act and what is read; each coordinate by itself if left out. A plane wall of normal n
            seen in coordinates q with `x = J q` has m = 1, `P = J^T n` and `C = n^T J`.
        scale: Mass along which the gains act, kg; the largest mass of the body if left out.

    Returns:
        The loop. Its state: q and q' (n each), the motors' force (m, with a lag), the estimators, the commands on
        their way (m each).
    """
    n = len(body.mass)
    push, see = (np.eye(n), np.eye(n)) if ports is None else ports
    m = push.shape[1]
    step, early, late = _hold(body, timing, push)
    plant = len(step)
    filter_step, filter_in, direct = estimator.realisation()
    filters = len(filter_step)
    way = timing.whole_periods + (timing.fraction > 0.0)
    first_filter, first_way = plant, plant + m * filters
    size = first_way + m * way

    ask = np.zeros((2, m, size + m))  # the last m: of an error of what is read
    ask[0, :, :n], ask[0, :, size:] = -see, -np.eye(m)
    ask[1] = direct * ask[0]
    if filters:
        ask[1, :, first_filter : first_filter + m] = -np.eye(m)

    free = np.zeros((size, size + m))
    free[:plant, :plant] = step
    free[first_filter:first_way, first_filter:first_way] = np.kron(filter_step, np.eye(m))
    for columns, read in ((slice(0, n), see), (slice(size, None), np.eye(m))):
        free[first_filter:first_way, columns] = np.kron(filter_in[:, None], read)
    gains = np.zeros((2, size, size + m))
    arrivals = [(timing.whole_periods, late)] + ([(timing.whole_periods + 1, early)] if timing.fraction > 0.0 else [])
    for age, moves in arrivals:
        if age == 0:
            gains[:, :plant] += moves @ ask
        else:
            free[:plant, first_way + m * (age - 1) : first_way + m * age] += moves
    if way:
        gains[:, first_way : first_way + m] = ask
        free[first_way + m :, first_way : size - m] += np.eye(m * (way - 1))
    return SampledLoop(
        free=free[:, :size],
        by_stiffness=gains[0, :, :size],
        by_damping=gains[1, :, :size],
        scale=float(np.linalg.eigvalsh(body.mass).max()) if scale is None else scale,
        period=timing.period,
        ask=ask,
        error=np.stack([free[:, size:], gains[0, :, size:], gains[1, :, size:]]),
    )


def _hold(body: SampledBody, timing: Timing, push: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Transition of q, q' (and the motors' force) over a period, and what a command adds that is there before the
    delay's fraction has passed, or after it.
    """
    rate, required = continuous(body, push, timing.current_lag)
    size, m = required.shape

    def over(seconds: float) -> tuple[np.ndarray, np.ndarray]:
        joint = np.zeros((size + m, size + m))
        joint[:size, :size], joint[:size, size:] = rate * seconds, required * seconds
        moved = expm(joint)
        return moved[:size, :size], moved[:size, size:]

    before, early = over(timing.fraction * timing.period)
    after, late = over((1.0 - timing.fraction) * timing.period)
    return after @ before, after @ early, late


def limits(
    radius: Callable[[np.ndarray], np.ndarray], lowest: float, highest: float, points: int = 96, rounds: int = 36
) -> StableGains:
    """Where a spectral radius stays below 1: scanned on a logarithmic grid, each change then bisected.

    Args:
        radius: (m,) gains -> (m,) spectral radii.
        lowest: Foot of the scan; what is stable there counts as stable from 0.
        highest: Top of the scan.
        points: Points of the grid; an island narrower than its step (18 % at 96 over seven decades) may be overlooked.
        rounds: Rounds of the bisection, all changes at once; 36 leave 1e-11 of the gain.
    """
    gains = np.geomspace(lowest, highest, points)
    stable = radius(gains) < 1.0 + _GROWTH
    turns = np.flatnonzero(stable[1:] != stable[:-1])
    low, high, kept = gains[turns], gains[turns + 1], stable[turns]
    for _ in range(rounds if len(turns) else 0):
        middle = np.sqrt(low * high)
        same = (radius(middle) < 1.0 + _GROWTH) == kept
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    edges = list(np.where(kept, low, high))
    if stable[0]:
        edges.insert(0, 0.0)
    if stable[-1]:
        edges.append(highest)
    edges = [float(edge) for edge in edges]
    return StableGains(tuple(zip(edges[::2], edges[1::2], strict=True)), highest)


def bisect(
    holds: Callable[[float], bool], low: float, high: float, *, ratio: float = 1.0, width: float = 0.0
) -> tuple[float, float]:
    """Narrows an interval at whose low end a condition holds and at whose high end it does not.

    Args:
        holds: The condition at a value.
        low: Low end; positive if the interval is to end by its ratio.
        high: High end.
        ratio: Ratio of the ends to reach, halved in the logarithm each time.
        width: Width to reach instead, halved each time; 0 for the ratio.

    Returns:
        Both ends, which differ by no more than that.
    """
    while high - low > width if width > 0.0 else high > ratio * low:
        middle = (low + high) / 2.0 if width > 0.0 else math.sqrt(low * high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low, high


def scanned(holds: Callable[[float], bool], values: Sequence[float], ratio: float) -> float:
    """Last of the rising values before a condition fails for the first time, bisected to a ratio from where it fails.

    Returns:
        0 where it does not hold at the first value, the last value where it holds at all.
    """
    low = 0.0
    for value in values:
        if not holds(value):
            return bisect(holds, low, value, ratio=ratio)[0] if low > 0.0 else 0.0
        low = value
    return low


@dataclass(frozen=True)
class DampingCap:
    """Largest stable damping of a loop, and the cap applied.

    Attributes:
        limit: Where it becomes unstable, N s/m.
        margin: Factor that is kept from it.
    """

    limit: float
    margin: float

    @property
    def cap(self) -> float:
        """Largest damping that is applied, N s/m."""
        return self.limit / self.margin

    def applied(self, requested: float) -> float:
        """What becomes of a requested damping, N s/m; report both."""
        return min(requested, self.cap)


def damping_cap(
    effective_mass: float,
    period: float,
    delay: float,
    estimator: LinearEstimator,
    margin: float = 2.0,
    *,
    current_lag: float = 0.0,
    stiffness: float = 0.0,
) -> DampingCap:
    """Largest stable damping of a released handle without friction: a hand cannot be relied on.

    Args:
        effective_mass: Smallest mass of the device in any direction of the damping, kg: for damping alike in all
            directions the smallest eigenvalue of the mass matrix.
        period: s.
        delay: From the sample to the force, s.
        estimator: Estimator of the velocity.
        margin: Factor that is kept from the limit, at least 1; 2 is the usual gain margin of 6 dB.
        current_lag: Time constant of the current loop, s.
        stiffness: Stiffness of a spring rendered with it, N/m.

    Raises:
        ValueError: Mass, period, delay, lag or margin cannot be.
    """
    if not (math.isfinite(margin) and margin >= 1.0):
        raise ValueError(f"margin is {margin!r}; it must be finite and at least 1")
    body, timing = axis(effective_mass), Timing(period, delay, current_lag)
    return DampingCap(sampled_loop(body, timing, estimator).damping_limit(stiffness).first, margin)


class SampledBody(NamedTuple):
    """Device and hand between samples.

    Attributes:
        mass: (n, n), kg or kg m^2.
        damping: (n, n), N s/m or N m s/rad.
        stiffness: (n, n), N/m or N m/rad.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray


class Ports(NamedTuple):
    """Where a loop touches a body.

    Attributes:
        push: (n, m) P, how its commands act on the coordinates.
        see: (m, n) C, what it reads of them.
    """

    push: np.ndarray
    see: np.ndarray


def axis(mass: float, friction: float = 0.0, hand: Hand | None = None) -> SampledBody:
    """One axis of a device in a hand.

    Args:
        mass: Effective mass of the device along the axis, kg.
        friction: Viscous friction, N s/m.
        hand: Who holds it; nobody if left out.

    Returns:
        The body; n = 1, or 2 with a hand behind its grasp.

    Raises:
        ValueError: A figure is not finite or negative, or there is no mass.
    """
    figures = (mass, friction) if hand is None else (mass, friction, *hand)
    if not all(math.isfinite(f) and f >= 0.0 for f in figures) or not mass > 0.0:
        raise ValueError(f"mass {mass!r} kg, friction {friction!r} N s/m, hand {hand}: must be finite, none negative")
    alone = SampledBody(np.array([[mass]]), np.array([[friction]]), np.zeros((1, 1)))
    return alone if hand is None else held(alone, np.eye(1), hand)


def loaded(
    body: SampledBody,
    place: np.ndarray,
    mass: float = 0.0,
    damping: float | np.ndarray = 0.0,
    stiffness: float | np.ndarray = 0.0,
) -> SampledBody:
    """The body with a mass at a place, and a spring and damper from there to ground.

    Args:
        body: n coordinates.
        place: (k, n) L.
        mass: kg, in each of the k directions.
        damping: N s/m, alike in all directions, or (k, k).
        stiffness: N/m, likewise.
    """

    def seen(figure: float | np.ndarray) -> np.ndarray:
        return place.T @ (figure * np.eye(len(place)) if np.ndim(figure) == 0 else figure) @ place

    return SampledBody(body.mass + seen(mass), body.damping + seen(damping), body.stiffness + seen(stiffness))


def attached(
    body: SampledBody, place: np.ndarray, mass: float, damping: float | np.ndarray, stiffness: float | np.ndarray
) -> tuple[SampledBody, np.ndarray]:
    """The body with a mass behind a spring and damper at a place.

    Args:
        body: n coordinates.
        place: (k, n) L.
        mass: kg; its k coordinates come last.
        damping: Between place and mass, N s/m, alike in all directions, or (k, k).
        stiffness: N/m, likewise.

    Returns:
        The body of n + k coordinates, and (k, n + k) the place of the mass.
    """
    n, k = body.mass.shape[0], len(place)
    between = np.hstack([-place, np.eye(k)])
    grown = SampledBody(*(np.pad(matrix, (0, k)) for matrix in body))
    grown = loaded(grown, between, damping=damping, stiffness=stiffness)
    own = np.hstack([np.zeros((k, n)), np.eye(k)])
    return loaded(grown, own, mass=mass), own


def held(body: SampledBody, place: np.ndarray, hand: Hand) -> SampledBody:
    """The body in a hand, alike in the k directions of the place (k, n) that it holds."""
    if hand.grasp_stiffness > 0.0:
        body, place = attached(body, place, hand.mass, hand.grasp_damping, hand.grasp_stiffness)
        return loaded(body, place, damping=hand.damping, stiffness=hand.stiffness)
    return loaded(body, place, hand.mass, hand.damping, hand.stiffness)


def continuous(body: SampledBody, push: np.ndarray, lag: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Rate of q, q' and, with a lag, of the motors' force (m), and how commands change it.

    Args:
        body: n coordinates.
        push: (n, m).
        lag: Time constant of the motors, s; 0 for none.

    Returns:
        (N, N), (N, m) with N = 2 n + m, or 2 n without a lag.
    """
    n, m = push.shape
    size = 2 * n + (m if lag > 0.0 else 0)
    rate, required = np.zeros((size, size)), np.zeros((size, m))
    rate[:n, n : 2 * n] = np.eye(n)
    rate[n : 2 * n, :n] = -np.linalg.solve(body.mass, body.stiffness)
    rate[n : 2 * n, n : 2 * n] = -np.linalg.solve(body.mass, body.damping)
    acts = np.linalg.solve(body.mass, push)
    if lag > 0.0:
        rate[n : 2 * n, 2 * n :] = acts
        rate[2 * n :, 2 * n :] = -np.eye(m) / lag
        required[2 * n :] = np.eye(m) / lag
    else:
        required[n:] = acts
    return rate, required


# Response to a constant position, as a share of the largest coefficient, up to which rounding explains it.
_SETTLED = 1e-9


@dataclass(frozen=True)
class LinearEstimator:
    """A linear filter from sampled positions to a velocity.

    `v_k = sum_i numerator[i] x_(k-i) - sum_(j >= 1) denominator[j] v_(k-j)`.

    Attributes:
        name: Name in reports.
        numerator: 1/s, from the newest sample back.
        denominator: Dimensionless, its first is 1.

    Raises:
        ValueError: A coefficient is not finite, the first of the denominator is not 1, or a handle that stands still
            would have a velocity.
    """

    name: str
    numerator: tuple[float, ...]
    denominator: tuple[float, ...] = (1.0,)

    def __post_init__(self) -> None:
        if not self.numerator or not all(math.isfinite(c) for c in (*self.numerator, *self.denominator)):
            raise ValueError(f"estimator {self.name}: its coefficients must be finite")
        if not self.denominator or self.denominator[0] != 1.0:
            raise ValueError(f"estimator {self.name}: the first coefficient of the denominator must be 1")
        if abs(sum(self.numerator)) > _SETTLED * max(abs(c) for c in self.numerator):
            raise ValueError(f"estimator {self.name}: a handle that stands still would have a velocity")

    def response(self, z: np.ndarray) -> np.ndarray:
        """Transfer function at points of the complex plane.

        Args:
            z: (...) complex.

        Returns:
            (...) complex, 1/s.
        """
        back = 1.0 / np.asarray(z, dtype=complex)
        top = np.polynomial.polynomial.polyval(back, np.array(self.numerator))
        return top / np.polynomial.polynomial.polyval(back, np.array(self.denominator))

    def realisation(self) -> tuple[np.ndarray, np.ndarray, float]:
        """State space `w+ = A w + b x`, `v = w[0] + d x` (transposed direct form).

        Returns:
            A (n, n), b (n,) in 1/s, d in 1/s; n may be 0.
        """
        n = max(len(self.numerator), len(self.denominator)) - 1
        top, bottom = np.zeros(n + 1), np.zeros(n + 1)
        top[: len(self.numerator)] = self.numerator
        bottom[: len(self.denominator)] = self.denominator
        step = np.eye(n, k=1)
        step[:, :1] -= bottom[1:, None]
        return step, top[1:] - bottom[1:] * top[0], float(top[0])


def linear_model(estimator: Estimator) -> LinearEstimator:
    """Linear filter that an estimator of the controller is equivalent to.

    Args:
        estimator: Estimator of `haptics.control.filters`.
    """
    from haptics.control.filters import transfer

    top, bottom = transfer(estimator)
    return LinearEstimator("low-pass", tuple(top.tolist()), tuple(bottom.tolist()))
