"""The unknowns of a device: parameters of each chain, their tolerances, and the angle that belongs to a reading."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.chains import PARAMETERS, UnequalDelta, equal_chains, unequal
from delta_cad.mechanism.geometry import THREE_FOLD, DeltaGeometry

LENGTHS = len(PARAMETERS)
ANGLES = ("zero", "cos_1", "sin_1", "cos_2", "sin_2")
"""What is added to a reading: a constant, and two waves a turn of the encoder."""
NAMES = (*PARAMETERS, *ANGLES)
COUNT = len(NAMES)  # parameters of a chain
ZERO = LENGTHS
_ITERATIONS = 30  # of a reading: 0.3 degrees of wave on a motor 10 times as fast leave a tenth a step
# Standard deviations of what is not measured. A length or offset: parts are made to 0.1 mm, joints are bonded, magnets
# and balls sit somewhere. A zero may be anywhere. A wave: an on-axis magnet half a millimetre off its chip has some
# tenths of a degree, and catalogue rows that tell more get more.
_LENGTH_SIGMA, _ZERO_SIGMA, WAVE_SIGMA = 0.2e-3, math.pi, math.radians(0.3)


@dataclass(frozen=True)
class Unknowns:
    """Parameters of a device.

    Attributes:
        table: (3 chains, 11) in the order of `NAMES`, m and rad.
        turns: Turns of an encoder in one of the arm: 1 on the shoulder, the drive's ratio on the motor.
        side_cosine: Cosine of the azimuth of chain 1, as drawn.
    """

    table: np.ndarray
    turns: float = 1.0
    side_cosine: float = THREE_FOLD

    @property
    def mechanism(self) -> UnequalDelta:
        """The lengths and offsets."""
        return unequal(self.table[:, :LENGTHS], self.side_cosine)

    def angles(self, readings: ArrayLike) -> np.ndarray:
        """Computes the shoulder angles behind readings.

        Args:
            readings: (..., 3 chains) rad.

        Returns:
            (..., 3 chains) reading + zero + cos_1 cos a + sin_1 sin a + cos_2 cos 2a + sin_2 sin 2a, a being the
            encoder's own turn.
        """
        return np.asarray(readings, dtype=float) + (self.waves(readings) * self.table[:, ZERO:]).sum(axis=-1)

    def readings(self, theta: ArrayLike) -> np.ndarray:
        """Computes the readings at shoulder angles, (..., 3 chains) rad: the inverse of `angles` by iteration.

        Waves as small as encoders have, of which a turn changes less than it turns, make each step a contraction.
        """
        theta = np.asarray(theta, dtype=float)
        out = theta
        for _ in range(_ITERATIONS):
            out = theta - (self.waves(out) * self.table[:, ZERO:]).sum(axis=-1)
        return out

    def waves(self, readings: ArrayLike) -> np.ndarray:
        """Gives what the angles of `ANGLES` are multiplied by, (..., 3 chains, 5)."""
        a = self.turns * np.asarray(readings, dtype=float)
        return np.stack([np.ones_like(a), np.cos(a), np.sin(a), np.cos(2 * a), np.sin(2 * a)], axis=-1)


def nominal(g: DeltaGeometry, turns: float = 1.0) -> Unknowns:
    """Gives the device as it was drawn, its encoders without an error."""
    return Unknowns(np.hstack([equal_chains(g), np.zeros((3, len(ANGLES)))]), turns, g.side_cosine)


def sigmas(wave: float = WAVE_SIGMA) -> np.ndarray:
    """Gives how far each parameter may be off before it is measured, (3 chains, 11) standard deviations, m and rad.

    Args:
        wave: That of each wave's sine and cosine, rad.
    """
    return np.tile([_LENGTH_SIGMA] * LENGTHS + [_ZERO_SIGMA] + [wave] * 4, (3, 1))
