"""One small interface for every device with three joints: simulated, recorded, scripted, or a board on a socket.

A controller reads angles, thinks, and writes torques; the device holds them until the next write. `read` waits for the
device's next tick, so the device is the clock. `run` drives any device and leaves it without torque, whatever happens.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike

from haptics.devices.recording import Recorder, Recording


class DeviceError(RuntimeError):
    """The device cannot do what it is called for; the message names it and the cause."""


class DeviceLostError(DeviceError):
    """The device does not answer any more."""


class EndOfRecordingError(DeviceError):
    """A recording has no further sample; `run` ends there as planned."""


class Reading(NamedTuple):
    """What a device read.

    Attributes:
        angles: (3,) shoulder angles, rad; NaN for an encoder that knows of its own fault.
        time: Time of the reading on the device's clock, s.
        flags: Bits of `faults.EXTERNAL` that the device holds up.
        fresh: Bit i is set if the reading of joint i was taken since the last one and its own check passed.
        readings: (3,) what the encoders read, rad, where a calibration makes other angles of it; None for the angles.
    """

    angles: np.ndarray
    time: float
    flags: int = 0
    fresh: int = 7
    readings: np.ndarray | None = None


class Device(Protocol):
    """What every device can do."""

    @property
    def time(self) -> float:
        """The device's clock at its last reading, s."""
        ...

    def read(self) -> Reading:
        """Waits for the device's next tick and reads the joints.

        Raises:
            DeviceError: It is closed, lost, or has no more to read.
        """
        ...

    def write(self, torques: ArrayLike) -> None:
        """Sets the torques that are held until the next write.

        Args:
            torques: (3,) N m.

        Raises:
            ValueError: They are not three finite numbers; what was held stays.
            DeviceError: It is closed or lost.
        """
        ...

    def close(self) -> None:
        """Lets all torque go and the device too; a second time does nothing."""
        ...


def three_torques(torques: ArrayLike) -> np.ndarray:
    """The torques as an array of their own.

    Args:
        torques: (3,) N m.

    Returns:
        (3,) a copy.

    Raises:
        ValueError: They are not three finite numbers.
    """
    values = np.array(torques, dtype=float)
    if values.shape != (3,) or not np.isfinite(values).all():
        raise ValueError(f"torques are {values.tolist()!r}; a device takes three finite numbers in N m")
    return values


def run(
    device: Device,
    tick: Callable[[Reading], ArrayLike],
    *,
    ticks: int | None = None,
    until: Callable[[Reading], bool] | None = None,
    recorder: Recorder | None = None,
) -> Recording:
    """Drives a device tick by tick, and leaves it closed and without torque.

    Args:
        device: Any.
        tick: From what was read to the torques to write, N m.
        ticks: Their number; None for as many as there are.
        until: Says after a tick that it was the last.
        recorder: Where ticks are kept; given, it still has them after an exception.

    Returns:
        What was read and written.

    Raises:
        ValueError: `ticks` is negative.
        BaseException: Whatever `tick`, `until` or the device raised, Ctrl-C included, after zero torque was written and
            the device closed; what failed while doing that is added as a note.
    """
    recorder = Recorder() if recorder is None else recorder
    try:
        if ticks is not None and ticks < 0:
            raise ValueError(f"ticks is {ticks}; it must not be negative")
        done = 0
        while ticks is None or done < ticks:
            try:
                sample = device.read()
            except EndOfRecordingError:
                break
            torques = three_torques(tick(sample))
            device.write(torques)
            recorder.add(sample.time, sample.angles, torques)
            done += 1
            if until is not None and until(sample):
                break
    except BaseException as error:
        for leave in (lambda: device.write(np.zeros(3)), device.close):
            try:
                leave()
            except (DeviceError, OSError) as also:
                error.add_note(f"while leaving the device: {also}")
        raise
    try:
        device.write(np.zeros(3))
    finally:
        device.close()
    return recorder.recording()
