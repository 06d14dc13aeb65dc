"""Velocity from sampled positions: difference, low-pass, adaptive window; pure compiled steps on a memory array.

One signal (one joint) has one memory, a row of doubles:

| place | holds |
|---|---|
| HELD = 0 | positions held, 0 to window + 1; 0: fresh, the next sample gives velocity 0 |
| VELOCITY = 1 | the last estimate |
| WINDOW = 2 | periods that it spans |
| POSITIONS + j, j = 0 to window | the position j samples ago |

All zeros is a fresh memory. A sample that is not finite, or so far off that the estimate is not, is not taken: it makes
the memory fresh and gives velocity 0, and nothing of it is left.

Estimators, with T the period and y_i the position i samples ago:

- backward difference `(y_0 - y_1) / T`; half a sample late; an error of one quantum q is an error q / T of velocity.
- low-pass: the difference d through `v := a v + (1 - a) d`, `a = exp(-2 pi f T)`: the lag of corner f solved exactly
  for motion that is linear from sample to sample.
- FOAW, first-order adaptive windowing: the longest window, growing from one period until it first fails, whose line
  through its two ends (y_0 and y_n) misses no sample in between by more than the noise band. `end-fit` gives the
  slope of that line, `best-fit` that of least squares over the same window. A window fails at i < n where
  `|y_0 - y_i - i s| > band`, s = (y_0 - y_n) / n, so s has to lie in a funnel that each sample narrows: n steps, not
  n^2. A steady motion read in quanta q is at most q off that line (each end and the sample by q / 2): with the band q
  the window of a steady motion grows to its maximum, and the estimate is at most q / (n T) off (best-fit
  3/2 q / ((n + 1) T)).

Positions may be of any unit; the velocity is in that unit a second. Importing this module loads numba.

Source:
    F. Janabi-Sharifi, V. Hayward, C.-S. J. Chen, "Discrete-time adaptive windowing for velocity estimation", IEEE
    Transactions on Control Systems Technology 8 (2000) 1003-1009. Ours: best-fit takes the window of the end-fit line,
    for the guarantee above, where common implementations test the fitted slope through the newest sample.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.common.jit import compiled

DIFFERENCE, LOW_PASS, FOAW_END, FOAW_BEST = 1, 2, 3, 4
HELD, VELOCITY, WINDOW, POSITIONS = 0, 1, 2, 3
WINDOW_MAX = 1000  # Longest window that is accepted, periods
# Share by which the band is widened: quantised samples lie on its edge, up to the rounding of their doubles.
BAND_SLACK = 1e-6


class Estimator(NamedTuple):
    """A velocity estimator; numbers only, so that compiled code takes it as it is.

    Attributes:
        kind: DIFFERENCE, LOW_PASS, FOAW_END or FOAW_BEST.
        period: T, s.
        pole: a of the low-pass; else 0.
        band: Noise band of FOAW in the unit of the positions; else 0.
        window: Longest window, periods; 1 without FOAW.
    """

    kind: int
    period: float
    pole: float
    band: float
    window: int


def backward_difference(period: float) -> Estimator:
    """Difference of the last two samples.

    Args:
        period: T, s.

    Raises:
        ValueError: The period is not finite and positive.
    """
    return Estimator(DIFFERENCE, _positive("period", period, "s"), 0.0, 0.0, 1)


def low_pass(period: float, corner: float) -> Estimator:
    """Backward difference behind a first-order low-pass, discretised exactly.

    Args:
        period: T, s.
        corner: Frequency at which the continuous filter lets 1/sqrt(2) through, Hz.

    Raises:
        ValueError: A figure is not finite and positive.
    """
    pole = math.exp(-2.0 * math.pi * _positive("corner", corner, "Hz") * _positive("period", period, "s"))
    return Estimator(LOW_PASS, float(period), pole, 0.0, 1)


def foaw(period: float, band: float, window: int, *, best_fit: bool = False) -> Estimator:
    """First-order adaptive windowing.

    Args:
        period: T, s.
        band: Noise band; one step of the encoder. Unit of the positions.
        window: Longest window, periods, 1 to WINDOW_MAX.
        best_fit: Slope by least squares over the window, in place of the line through its ends.

    Raises:
        ValueError: A figure is out of its bounds.
    """
    if not (window == int(window) and 1 <= window <= WINDOW_MAX):
        raise ValueError(f"window is {window!r} periods; it must be a whole number from 1 to {WINDOW_MAX}")
    kind = FOAW_BEST if best_fit else FOAW_END
    return Estimator(kind, _positive("period", period, "s"), 0.0, _positive("band", band, "of a position"), int(window))


def fresh_memory(estimator: Estimator, signals: int = 3) -> np.ndarray:
    """Memory for several signals.

    Args:
        estimator: The estimator.
        signals: Number of joints.

    Returns:
        (signals, POSITIONS + window + 1) zeros.
    """
    return np.zeros((signals, POSITIONS + estimator.window + 1))


@compiled
def reset(memory):
    """Makes a memory of any shape fresh, in place."""
    memory[...] = 0.0


@compiled
def _adaptive(estimator, memory, periods):
    newest = memory[POSITIONS]
    band = estimator.band * (1.0 + BAND_SLACK)
    low, high = -math.inf, math.inf
    total = weighted = slope = 0.0
    n = 0
    for i in range(1, periods + 1):
        rise, over = newest - memory[POSITIONS + i], 1.0 / i
        trial = rise * over
        if trial < low or trial > high:
            break
        n, slope = i, trial
        total += rise
        weighted += i * rise
        low, high = max(low, (rise - band) * over), min(high, (rise + band) * over)
    memory[WINDOW] = n
    if estimator.kind == FOAW_BEST:
        # sum of (n/2 - i)(y_i - y_0) over sum of (n/2 - i)^2 = n (n + 1)(n + 2) / 12
        slope = 6.0 * (2.0 * weighted - n * total) / (n * (n + 1.0) * (n + 2.0))
    return slope / estimator.period


@compiled
def velocity(estimator, memory, position):
    """One sample of one signal.

    Args:
        estimator: The estimator.
        memory: (POSITIONS + window + 1,) memory of the signal, moved on in place.
        position: The new sample.

    Returns:
        Velocity, units a second; always finite.
    """
    held = int(memory[HELD])
    for j in range(min(held, estimator.window), 0, -1):
        memory[POSITIONS + j] = memory[POSITIONS + j - 1]
    memory[POSITIONS] = position
    estimate = 0.0
    memory[WINDOW] = 0.0
    if held > 0:
        if estimator.kind >= FOAW_END:
            estimate = _adaptive(estimator, memory, min(held, estimator.window))
        else:
            memory[WINDOW] = 1.0
            difference = (position - memory[POSITIONS + 1]) / estimator.period
            estimate = estimator.pole * memory[VELOCITY] + (1.0 - estimator.pole) * difference
    if not (math.isfinite(position) and math.isfinite(estimate)):
        reset(memory)
        return 0.0
    memory[HELD] = min(held, estimator.window) + 1
    memory[VELOCITY] = estimate
    return estimate


def transfer(estimator: Estimator, window: int | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Transfer function from position to velocity in powers of 1/z: `N(1/z) / D(1/z)`.

    Args:
        estimator: The estimator.
        window: For FOAW, which is linear for a window that is held: that window, periods; else None.

    Returns:
        N and D, coefficients of z^0, z^-1, ...; D starts with 1.

    Raises:
        ValueError: A window is missing, out of the estimator's bounds, or given to one that has none.
    """
    a, T = estimator.pole, estimator.period
    if estimator.kind < FOAW_END:
        if window is not None:
            raise ValueError(f"window is {window!r}; this estimator has none")
        numerator = (1.0 - a) / T * np.array([1.0, -1.0])
        return numerator, np.array([1.0]) if estimator.kind == DIFFERENCE else np.array([1.0, -a])
    if window is None or not 1 <= window <= estimator.window:
        raise ValueError(
            f"window is {window!r}; FOAW is linear for a window held, from 1 to {estimator.window} periods"
        )
    n = int(window)
    if estimator.kind == FOAW_BEST:
        return 6.0 * (n - 2.0 * np.arange(n + 1)) / (T * n * (n + 1) * (n + 2)), np.array([1.0])
    ends = np.zeros(n + 1)
    ends[0], ends[n] = 1.0 / (n * T), -1.0 / (n * T)
    return ends, np.array([1.0])


def _positive(field: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{field} is {value!r} {unit}; it must be finite and positive")
    return float(value)
