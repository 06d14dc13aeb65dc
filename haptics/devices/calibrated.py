"""A made device with its calibration: it behaves like the drawn one. Importing this module loads numba."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.geometry import DeltaGeometry
from haptics.calibration.unknowns import Unknowns
from haptics.control.correction import DRAWN, POSITION, ROWS, Correction, correct, correction, turned
from haptics.devices.device import Device, Reading, three_torques


class CalibratedDevice:
    """Another device with its readings put right, and torques turned to fit; see `control.correction`.

    A reading from which no position follows stays NaN, which the supervisor knows as an invalid angle.

    Args:
        device: The other device.
        g: The device as drawn, which the controller knows.
        unknowns: As it was measured.

    Attributes:
        device: The other device; what it has beyond a `Device`, such as its period, is had from here as well.
        position: (3,) of the handle at the last reading, m.
    """

    def __init__(self, device: Device, g: DeltaGeometry, unknowns: Unknowns) -> None:
        self.device = device
        self._known: Correction = correction(g, unknowns)
        self._out = np.full((ROWS, 3), np.nan)

    def __getattr__(self, name: str) -> object:
        return getattr(self.device, name)

    @property
    def time(self) -> float:
        """Time of the other device, s."""
        return self.device.time

    @property
    def position(self) -> np.ndarray:
        """(3,) of the handle at the last reading, m; NaN before the first."""
        return self._out[POSITION].copy()

    def read(self) -> Reading:
        """Reads the other device, and gives the angles that the drawn one would have there; see `Device`."""
        sample = self.device.read()
        if sample.fresh == 7:  # else the last torques stand, and the last place with them
            correct(self._known, np.asarray(sample.angles, dtype=float), self._out)
        return sample._replace(angles=self._out[DRAWN].copy(), readings=sample.angles)

    def write(self, torques: ArrayLike) -> None:
        """Writes the torques that do the same at the handle; none, where it is not known where that is."""
        made = np.empty(3)
        turned(self._out, three_torques(torques), np.inf, made)
        self.device.write(made)

    def close(self) -> None:
        """Closes the other device; see `Device`."""
        self.device.close()
