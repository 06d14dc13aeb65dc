"""Devices for tests: one that plays a script, and one that disturbs another device's readings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from haptics.devices.device import Device, DeviceError, EndOfRecordingError, Reading, three_torques

Disturbance = Callable[[Reading], Reading]


class FakeDevice:
    """Plays a script of readings and keeps every write.

    Args:
        script: For each reading angles (3) in rad, a `Reading`, or an exception to raise.
        period: Between two readings given as angles, s.
        refusals: Exceptions to raise at writing, by the number of the write.

    Attributes:
        written: (3,) torques, in order.
        closed: How often it was closed.
    """

    def __init__(
        self,
        script: Iterable[ArrayLike | Reading | BaseException],
        period: float = 1e-3,
        refusals: Mapping[int, BaseException] | None = None,
    ) -> None:
        self._script, self._period, self._refusals = iter(script), period, dict(refusals or {})
        self._reads, self._writes = 0, 0
        self.time = 0.0
        self.written: list[np.ndarray] = []
        self.closed = 0

    def read(self) -> Reading:
        """The script's next entry; see `Device`."""
        self._require_open()
        try:
            entry = next(self._script)
        except StopIteration:
            raise EndOfRecordingError(f"the script has no more than {self._reads} readings") from None
        if isinstance(entry, BaseException):
            raise entry
        self.time = entry.time if isinstance(entry, Reading) else self._reads * self._period
        self._reads += 1
        return entry if isinstance(entry, Reading) else Reading(np.array(entry, dtype=float), self.time)

    def write(self, torques: ArrayLike) -> None:
        """Keeps the torques, (3,) N m, in `written`; raises what the script refuses them with."""
        self._require_open()
        self._writes += 1
        refusal = self._refusals.get(self._writes - 1)
        if refusal is not None:
            raise refusal
        self.written.append(three_torques(torques))

    def close(self) -> None:
        """Counts the calls in `closed`; a later reading or command raises `DeviceError`."""
        self.closed += 1

    def _require_open(self) -> None:
        if self.closed:
            raise DeviceError("the fake device is closed")


class DisturbedDevice:
    """Another device with faults in its readings, by the number of the reading.

    Args:
        device: The other device.
        disturbances: What is done to a reading; see the functions below.
    """

    def __init__(self, device: Device, disturbances: Mapping[int, Disturbance]) -> None:
        self.device, self._disturbances, self._reads = device, dict(disturbances), 0
        self.write, self.close = device.write, device.close

    @property
    def time(self) -> float:
        """Time of the other device, s."""
        return self.device.time

    def read(self) -> Reading:
        """Reads the other device, and puts in the fault that is due at this reading."""
        sample = self.device.read()
        self._reads += 1
        disturbance = self._disturbances.get(self._reads - 1)
        return sample if disturbance is None else disturbance(sample)


def invalid(joint: int) -> Disturbance:
    """An encoder that reads no number."""
    return stuck(joint, float("nan"))


def jumped(joint: int, turn: float) -> Disturbance:
    """An encoder that is off by `turn`, rad."""
    return lambda sample: _turned(sample, joint, float(sample.angles[joint]) + turn)


def stuck(joint: int, angle: float) -> Disturbance:
    """An encoder that reads `angle`, rad, whatever the joint does."""
    return lambda sample: _turned(sample, joint, angle)


def late(seconds: float) -> Disturbance:
    """A reading whose time is later by `seconds`."""
    return lambda sample: sample._replace(time=sample.time + seconds)


def signalling(flags: int) -> Disturbance:
    """A reading that also holds up these bits of `faults.EXTERNAL`."""
    return lambda sample: sample._replace(flags=sample.flags | flags)


def _turned(sample: Reading, joint: int, angle: float) -> Reading:
    changed = sample.angles.copy()
    changed[joint] = angle
    return sample._replace(angles=changed)
