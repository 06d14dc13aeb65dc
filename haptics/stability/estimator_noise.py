"""What a velocity estimator costs: its error, lag and noise on a motion read in quanta, over speed.

The motion is a sine of a hand's frequency whose largest speed is given, read through an encoder with rounding. The part
of the estimate that has the motion's frequency says how late it is; what is left is noise. Several passes with the
encoder's steps shifted stand for all phases: no random numbers.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np

from haptics.control.filters import Estimator, fresh_memory, velocities

HAND_FREQUENCY = 2.0  # Frequency of the motion, Hz: a brisk voluntary movement of the hand
PASSES = 16
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0  # Shift between passes in quanta: its multiples fill the interval evenly


class EstimatorFigure(NamedTuple):
    """Error of an estimator at a speed.

    Attributes:
        name: Of the estimator.
        speed: Largest speed of the motion, units a second.
        rms_error: Of the estimate against the true velocity, units a second.
        lag: Time by which the estimate is late, s; NaN where the motion stays within one step.
        noise: Root mean square of what does not have the motion's frequency, units a second.
    """

    name: str
    speed: float
    rms_error: float
    lag: float
    noise: float


def estimator_figure(
    name: str, estimator: Estimator, quantum: float, speed: float, frequency: float = HAND_FREQUENCY
) -> EstimatorFigure:
    """Error, lag and noise of an estimator on a sine read in quanta.

    Args:
        name: Carried along.
        estimator: The estimator.
        quantum: Step of the encoder in the unit of the positions.
        speed: Largest speed, units a second.
        frequency: Of the motion, Hz; taken to the nearest that has a whole number of samples.

    Returns:
        The figures.

    Raises:
        ValueError: A figure is not finite and positive, or the motion has fewer than 8 samples a cycle.
    """
    for field, value in (("quantum", quantum), ("speed", speed), ("frequency", frequency)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{field} is {value!r}; it must be finite and positive")
    cycle = round(1.0 / (frequency * estimator.period))
    if cycle < 8:
        raise ValueError(f"frequency is {frequency!r} Hz; it must leave at least 8 samples a cycle")
    omega = 2.0 * math.pi / (cycle * estimator.period)
    before = cycle * (
        2 + estimator.window // cycle
    )  # whole cycles, in which the start is forgotten and the window filled
    phase = 2.0 * math.pi * np.arange(before + cycle) / cycle
    true = speed * np.cos(phase[before:])
    estimates = np.empty((PASSES, cycle))
    out = np.empty(before + cycle)
    for k in range(PASSES):
        shift = k * GOLDEN % 1.0
        read = quantum * np.round(speed / omega / quantum * np.sin(phase) + shift)
        velocities(estimator, fresh_memory(estimator, 1)[0], read, out)
        estimates[k] = out[before:]
    mean = estimates.mean(axis=0)
    in_phase, late = (2.0 * np.mean(mean * wave) for wave in (np.cos(phase[before:]), np.sin(phase[before:])))
    seen = math.hypot(in_phase, late) > 0.0
    motion = in_phase * np.cos(phase[before:]) + late * np.sin(phase[before:])
    return EstimatorFigure(
        name=name,
        speed=speed,
        rms_error=float(np.sqrt(np.mean((estimates - true) ** 2))),
        lag=math.atan2(late, in_phase) / omega if seen else math.nan,
        noise=float(np.sqrt(np.mean((estimates - motion) ** 2))),
    )


def compare_estimators(
    estimators: Mapping[str, Estimator], quantum: float, speeds: Iterable[float], frequency: float = HAND_FREQUENCY
) -> list[EstimatorFigure]:
    """Figures of several estimators at several speeds, speed by speed.

    Args:
        estimators: By name.
        quantum: Step of the encoder in the unit of the positions.
        speeds: Largest speeds of the motion, units a second.
        frequency: Of the motion, Hz.

    Returns:
        One figure for each pair.

    Raises:
        ValueError: As `estimator_figure`.
    """
    return [
        estimator_figure(name, estimator, quantum, speed, frequency)
        for speed in speeds
        for name, estimator in estimators.items()
    ]


def estimator_table(figures: Iterable[EstimatorFigure], unit: str = "rad/s") -> str:
    """The figures as a table of plain text.

    Args:
        figures: Of `compare_estimators`.
        unit: Of the speeds.

    Returns:
        Lines, the columns aligned.
    """
    head = f"{'estimator':<24}{'speed':>12}{'rms error':>12}{'lag':>10}{'noise':>12}"
    units = f"{'':<24}{unit:>12}{unit:>12}{'ms':>10}{unit:>12}"
    rows = [f"{f.name:<24}{f.speed:12.4g}{f.rms_error:12.4g}{1e3 * f.lag:10.3f}{f.noise:12.4g}" for f in figures]
    return "\n".join([head, units, *rows])
