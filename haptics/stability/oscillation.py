"""Oscillation of a recorded push against a wall: one criterion for simulated and measured series.

After the push the hand holds still, so position and force should settle. The last two windows of the record are
compared, each with its straight line (creep) taken off. It oscillates if in the last one the position

- still swings by more than a few counts of the encoder, as seen at the handle: a cycle of one count is quantisation,
  and is reported as an amplitude but not called an oscillation;
- swings to and fro, at least `REVERSALS` times across half a count (a quarter to each side): a bend of the creep
  does not;
- has not fallen below `decay` times what it was in the window before: what is halved each half second dies away. Here
  the root mean square is compared under a Hann window, which the phase of two or three swings hardly touches.

A record with a value that is not finite has diverged, and oscillates.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

# Two full swings in a window of half a second are 4 Hz; the softest wall of the protocol with the heaviest hand of the
# set, 1100 N/m on 0.27 kg, swings at 10 Hz.
REVERSALS = 4
GROWS = 1.1  # Ratio of two windows' swings from which growth is distinguished from beats and rounding of a steady cycle

Kind = Literal["settles", "sustained", "grows", "diverged"]


@dataclass(frozen=True)
class Oscillation:
    """Oscillation of a record: its swing, its decay and its frequency.

    Attributes:
        kind: "settles", "sustained", "grows" or "diverged".
        swing: Peak to peak of the position in the last window, m.
        ratio: Ratio of the root mean squares of the last window and the one before; 0 if both are still, infinite if it
            began in the last.
        force_swing: Peak to peak of the force in the last window, N.
        frequency: From the reversals in the last window, Hz; 0 without any.
        contact: Share of both windows in which the wall pushes; below 1 the handle bounces.
    """

    kind: Kind
    swing: float
    ratio: float
    force_swing: float
    frequency: float
    contact: float

    @property
    def oscillates(self) -> bool:
        """Whether it would be called an oscillation."""
        return self.kind != "settles"


def oscillation(
    position: ArrayLike,
    force: ArrayLike,
    period: float,
    resolution: float,
    *,
    window: float = 0.5,
    counts: float = 3.0,
    decay: float = 0.5,
) -> Oscillation:
    """Decides whether a record oscillates, from where the push is steady.

    Args:
        position: (n,) true position along the wall's normal, m; measured ones will do, a count coarser.
        force: (n,) force of the wall, N; 0 outside.
        period: Between samples, s.
        resolution: One count of the encoder at the handle along the normal, m.
        window: s; the record must hold two.
        counts: Swings up to so many counts are quantisation.
        decay: Ratio of the last window's swing to the one's before, below which it dies away.

    Returns:
        The decision with the amplitudes behind it.

    Raises:
        ValueError: The series differ in length or are shorter than two windows, a parameter is not positive, or the
            handle was not at the wall at all in both windows.
    """
    x, f = np.asarray(position, dtype=float), np.asarray(force, dtype=float)
    for name, value in (("period", period), ("resolution", resolution), ("window", window)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r}; it must be finite and positive")
    n = round(window / period)
    if x.ndim != 1 or x.shape != f.shape or len(x) < 2 * n or n < 2:
        raise ValueError(f"position {x.shape} and force {f.shape} must be alike and hold two windows of {n} samples")
    if not (np.isfinite(x).all() and np.isfinite(f).all()):
        return Oscillation("diverged", np.inf, np.inf, np.inf, 0.0, float(np.mean(f[-2 * n :] != 0.0)))
    contact = float(np.mean(f[-2 * n :] != 0.0))
    if contact == 0.0:
        raise ValueError(
            f"the handle was not at the wall in the last {2.0 * window:g} s; the record says nothing of it"
        )
    last, ratio = off_line(x[-n:]), decay_ratio(x[-2 * n :])
    swing, reversals = float(np.ptp(last)), _reversals(last, resolution / 4.0)
    small = swing <= counts * resolution or reversals < REVERSALS
    kind: Kind = "settles" if small or ratio < decay else "grows" if ratio > GROWS else "sustained"
    return Oscillation(kind, swing, ratio, float(np.ptp(off_line(f[-n:]))), reversals / (2.0 * window), contact)


def decay_ratio(series: np.ndarray) -> float:
    """Root mean square of the second half of a series to that of the first, each off its straight line; 0 if both are
    still, infinite if the motion began in the second.
    """
    n = len(series) // 2
    now, was = (_root_mean_square(off_line(half)) for half in (series[-n:], series[-2 * n : -n]))
    return now / was if was > 0.0 else (np.inf if now > 0.0 else 0.0)


def strongest_line(series: np.ndarray, period: float) -> float:
    """Frequency of the strongest line of a series off its straight line, Hz, to an eighth of its length's inverse."""
    n = len(series)
    _, weight = _hann(n)
    spectrum = np.abs(np.fft.rfft(weight * off_line(series), 8 * n))
    return float(np.argmax(spectrum)) / (8 * n * period)


def off_line(series: np.ndarray) -> np.ndarray:
    """A series less its straight line of least squares, weighted by a Hann window: from two swings on, a swing itself
    hardly tilts that line, whatever its phase.
    """
    t, weight = _hann(len(series))
    level = (weight @ series) / weight.sum()
    slope = (weight * t @ series) / (weight * t @ t)
    return series - level - slope * t


def _root_mean_square(series: np.ndarray) -> float:
    _, weight = _hann(len(series))
    return float(np.sqrt(weight @ series**2 / weight.sum()))


def _hann(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Places from -1 to 1 and their weights."""
    t = np.linspace(-1.0, 1.0, n)
    return t, np.cos(np.pi / 2.0 * t) ** 2


def _reversals(series: np.ndarray, dead: float) -> int:
    """Changes of side, where only values beyond a dead band take a side."""
    sides = np.sign(series[np.abs(series) > dead])
    return int(np.count_nonzero(sides[1:] != sides[:-1]))
