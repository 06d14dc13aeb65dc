"""A device for programs of others: open it, ask where the handle is, say what force it shall feel, close it.

`haptics.open` is the way in. Under it lie the controller with its supervisor, gravity compensation, and any device
of this package. Importing this module loads numba.
"""

from __future__ import annotations

import math
from pathlib import Path
from threading import RLock
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.design import Design
from haptics.calibration.record import load_calibration
from haptics.control.controller import VELOCITY, Controller, Memory
from haptics.control.pose import POSITION
from haptics.control.supervisor.faults import FaultCode, State, findings
from haptics.devices.calibrated import CalibratedDevice
from haptics.devices.device import Device, DeviceError, DeviceLostError, Reading
from haptics.devices.host import Host, ticked
from haptics.devices.link import UdpLink
from haptics.devices.recorded import RecordedDevice
from haptics.devices.remote import RemoteDevice
from haptics.devices.simulated import simulated_machine
from haptics.loop.choice import LoopChoice, chosen_loop
from haptics.loop.hardware import board_controller
from haptics.model.machine import MachineModel, load_machine
from haptics.rendering.laws.constant_force import FORCE, ConstantForce

_KINDS = ("simulated", "socket", "recorded")
_WAIT_S = 0.1  # for a board's STATE; a program that is slower than a period is late, not lost


class HapticDevice:
    """A device as a program sees it: positions and forces at the handle, in the base frame.

    The device is the clock: `set_force` writes the torques for the last reading and waits for the next one, so that a
    loop of `position` and `set_force` runs once a tick. Who does not call any more gets the device's watchdog; before
    the first call a program may take its time.
    A thread may close or reset what another drives: no tick is cut in two, and after `close` no force comes any more.
    The supervisor lets force in over half a second, bounds it, and takes it away when something is wrong: see
    `faults`, and `reset`.

    Args:
        device: Any device.
        controller: Controller of that device.

    Raises:
        ValueError: They do not fit, see `Host.drive`.
        DeviceError: The device has nothing to read.
    """

    def __init__(self, device: Device, controller: Controller) -> None:
        self.device, self._open, self._again, self._begun = device, True, False, False
        self._lock = RLock()
        self._room = np.zeros(3)
        try:
            self._host = Host(controller, ConstantForce(np.zeros(3)))
            self._memory: Memory = self._host.memory
            self._host.begin(device)
            self._sample: Reading = device.read()
        except BaseException:
            device.close()
            raise
        self._host.enable()
        self._look()

    @property
    def period(self) -> float:
        """Time between two ticks, s."""
        return self._host.controller.limits.period

    @property
    def time(self) -> float:
        """The device's clock at the last reading, s."""
        return self._sample.time

    def position(self) -> np.ndarray:
        """Gives the position of the platform's centre at the last reading, (3,) m; NaN if it is not known."""
        return self._memory.work[POSITION].copy()

    def velocity(self) -> np.ndarray:
        """Gives its velocity, (3,) m/s, low-passed as the controller has it."""
        return self._memory.work[VELOCITY].copy()

    def angles(self) -> np.ndarray:
        """Gives the shoulder angles, (3,) rad."""
        return np.array(self._sample.angles, dtype=float)

    @property
    def state(self) -> State:
        """State of the supervisor: force is felt in RAMPING, ACTIVE and DEGRADED."""
        return self._host.supervisor.state

    @property
    def faults(self) -> tuple[FaultCode, ...]:
        """Findings of the last tick, and faults that wait for `reset`; `faults.TABLE` says what each means."""
        return findings(self._host.bits)

    def set_force(self, force: ArrayLike) -> None:
        """Gives the hand a force, beside the weight that is held anyway, and waits for the device's next tick.

        Args:
            force: (3,) on the handle, base frame, N. What motors or supervisor do not give is taken off.

        Raises:
            ValueError: It is not three finite numbers; nothing happens then.
            DeviceError: The device is closed or lost, or a recording is at its end.
        """
        try:
            wanted = np.array(force, dtype=float)
        except (TypeError, ValueError):
            wanted = np.full(1, np.nan)
        if wanted.shape != (3,) or not np.isfinite(wanted).all():
            raise ValueError(f"force is {force!r}; it must be three finite numbers in N")
        with self._lock:
            self._tick(wanted)

    def _tick(self, wanted: np.ndarray) -> None:
        if not self._open:
            raise DeviceError("the device is closed")
        self._host.set_row(0, FORCE, wanted)
        try:
            rouse = None if self._begun else getattr(self.device, "rouse", None)
            self._begun = True
            if rouse and rouse(wait=False):  # a board's watchdog, while the program was getting ready
                self._sample = self.device.read()
            self.device.write(self._host(self._sample))
            if self._again:  # the reset took this tick, so that force is asked for in the next
                self._again = False
                self._host.enable()
            self._sample = self.device.read()
        except DeviceLostError:
            self._host.lost()
            raise
        self._look()

    def reset(self) -> None:
        """Clears latched faults and lets force in again, over half a second from the next tick on, if what caused
        them is gone.
        """
        with self._lock:
            self._host.reset()
            self._again = True

    def close(self) -> None:
        """Takes all force away and lets the device go; a second time does nothing."""
        with self._lock:
            if not self._open:
                return
            self._open = False
            try:
                self.device.write(np.zeros(3))
            except DeviceError:
                pass  # lost already: its watchdog has cut the torque
            finally:
                self.device.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _look(self) -> None:
        """Position and velocity of the last reading: its tick is run on a copy of the memory, and forgotten."""
        host = self._host
        self._memory = Memory(*(part.copy() for part in host.memory))
        ticked(host.controller, self._memory, host.table, self._sample, self._room)


def open_device(
    design: str | Path,
    device: str = "simulated",
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    recording: str | Path | None = None,
    calibration: str | Path | None = None,
    masses: str | Path | None = None,
    rate_Hz: float = 1000.0,
    allow_remote: bool = False,
) -> HapticDevice:
    """Opens a haptic device.

        with haptics.open("best.json", "socket", port=5005) as device:
            while True:
                device.set_force(-300.0 * (device.position() - centre))

    Args:
        design: Design file.
        device: "simulated", "socket" for a board, "recorded".
        host: Numeric address of a board.
        port: Its port.
        recording: File of a recorded device.
        calibration: `calibration.json` of this one device.
        masses: `mass_properties.json`; None for `out/<name>/mass_properties.json`.
        rate_Hz: Ticks a second of a simulated device; a board has its own, a recording the one given.
        allow_remote: Whether the board may be at the end of a cable, not on this machine: the protocol has no password,
            so use a cable of its own.

    Returns:
        The device, a context manager, its force on.

    Raises:
        DesignError, MassError, CalibrationError, RecordingError: A file is refused.
        ValueError: An argument is.
        DeviceError: No board answers, or it refuses.
    """
    machine = load_machine(Path(design), None if masses is None else Path(masses))
    opened = opened_device(
        machine, device, host=host, port=port, recording=recording, calibration=calibration, rate_Hz=rate_Hz,
        allow_remote=allow_remote,
    )  # fmt: skip
    try:
        period = getattr(opened, "period", 1.0 / rate_Hz)
        controller = board_controller(machine, loop_of(machine.design, opened, period))
    except BaseException:
        opened.close()
        raise
    return HapticDevice(opened, controller)


def opened_device(
    machine: MachineModel,
    device: str,
    *,
    host: str = "127.0.0.1",
    port: int = 0,
    recording: str | Path | None = None,
    calibration: str | Path | None = None,
    rate_Hz: float = 1000.0,
    timeout: float = _WAIT_S,
    allow_remote: bool = False,
) -> Device:
    """Opens what a controller drives.

    Args:
        machine: The device's design and masses.
        device: One of `_KINDS`.
        host: Numeric address of a board.
        port: Its port.
        recording: File of what is replayed.
        calibration: `calibration.json` of the device, or None.
        rate_Hz: Ticks a second of a simulated device.
        timeout: Time without a reading after which a board is lost, s.
        allow_remote: Whether the board may be at the end of a cable and not on this machine: the protocol has no
            password.

    Returns:
        The device, behind its calibration where there is one.

    Raises:
        ValueError: The kind is unknown, the recording missing, a rate or port out of bounds.
        CalibrationError, RecordingError: Their file is refused.
        DeviceError: No board answers, or it refuses.
    """
    known = None if calibration is None else load_calibration(Path(calibration), machine.design)
    if device == "simulated":
        if not 100.0 <= rate_Hz <= 1e5:
            raise ValueError(f"rate is {rate_Hz!r} Hz; it must be from 100 to 100000")
        opened: Device = simulated_machine(machine, 1.0 / rate_Hz)
    elif device == "socket":
        if not (isinstance(port, int) and 0 < port < 65536):
            raise ValueError(f"port is {port!r}; a board's is from 1 to 65535, and `haptics board` prints its own")
        # all that is compiled is, before the board's watchdog begins to wait for it
        Host(board_controller(machine, chosen_loop(machine.design, rate_Hz)), ConstantForce(np.zeros(3)))
        opened = RemoteDevice(UdpLink(host, port, allow_remote=allow_remote), timeout=timeout)
    elif device == "recorded":
        if recording is None:
            raise ValueError("a recorded device needs its recording, .csv or .npz")
        opened = RecordedDevice(recording)
    else:
        raise ValueError(f"device is {device!r}; it must be one of {', '.join(_KINDS)}")
    return opened if known is None else CalibratedDevice(opened, machine.geometry, known.unknowns)


def loop_of(design: Design, device: Device, period: float) -> LoopChoice:
    """Gives the loop that a device closes: what its walls are held to.

    Args:
        design: Whose `loop` says how its drives damp.
        device: The device; a board says itself whether its drives damp more at a wall, and is a period late.
        period: Of its tick, s.
    """
    loop = chosen_loop(design, 1.0 / period)
    damps = getattr(device, "damps_at_walls", None)  # of a board
    if damps is not None:
        loop = loop.linked
    reported = getattr(device, "touch", None) is not None and damps is not False
    return loop if reported else loop.untouched


def finite(values: np.ndarray) -> list[float | None]:
    """Numbers as JSON has them: what is not finite becomes None."""
    return [float(v) if math.isfinite(v) else None for v in values]
