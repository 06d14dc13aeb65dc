"""The host: the compiled controller that `device.run` calls at each tick, and the operator's functions.

What a device reports of itself (watchdog, emergency stop) reaches the supervisor at every tick, beside the host's own
emergency stop; a device that does not answer any more is the supervisor's DEVICE_LOST. Importing this module loads
numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from haptics.control.controller import TOUCHED, Controller, Memory, fresh, tick
from haptics.control.filters import fresh_memory
from haptics.control.supervisor.faults import EXTERNAL, FaultCode
from haptics.control.supervisor.memory import GRAVITY, KNOWN, OUT, PLACED, RENDERED, SIGNALS, STARTED
from haptics.control.supervisor.safety import Supervisor
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.devices.device import Device, DeviceError, DeviceLostError, Reading, run
from haptics.devices.recording import Recorder, Recording
from haptics.rendering import law_table
from haptics.rendering.law import GAIN, ForceLaw
from haptics.rendering.table import fade

_SAME_PERIOD = 1e-6  # Relative difference of two periods that are the same: less than the error of any quartz


def ticked(controller: Controller, memory: Memory, laws: np.ndarray, sample: Reading, out: np.ndarray) -> int:
    """One tick of a controller on a reading; see `controller.tick`."""
    theta = np.array(sample.angles, dtype=float)
    readings = theta if sample.readings is None else np.array(sample.readings, dtype=float)
    return tick(controller, memory, laws, sample.time, theta, readings, sample.fresh, out)


class Host:
    """A controller at work: call it with a `Reading` to get torques, or let `drive` do that.

    The supervisor begins disabled; `enable` asks for force. Buttons (`enable`, `disable`, `reset`, `emergency_stop`,
    `heard`) only leave a mark for the next tick and may be pressed in another thread; `change` belongs to the thread of
    the ticks, where `drive` calls `until`.

    Args:
        controller: Controller of the device.
        laws: A law or a table of laws, as `haptics.rendering.law_table` takes them.

    Attributes:
        controller: The controller.
        supervisor: Supervisor of the controller: `state`, `latched`, `present`.
        memory: Memory of the controller; its supervisor's part is that of `supervisor`.
        bits: Findings of the last tick and latched faults; `faults.described` gives their text.

    Raises:
        LawError: The laws are refused.
        ValueError: The controller's limits contradict each other.
    """

    def __init__(self, controller: Controller, laws: ForceLaw | ArrayLike) -> None:
        self.controller, self.supervisor = controller, Supervisor(controller.limits)
        self.memory: Memory = fresh(controller)._replace(supervisor=self.supervisor.memory)
        self.bits = 0
        self._laws = law_table(laws)
        self._gains, self._step = self._laws[:, GAIN].copy(), 1.0
        self._stopped, self._lost = False, False
        self._device: Device | None = None
        self._last: Reading | None = None
        self._torques = np.zeros(3)
        # compiled before a device waits for it
        tick(controller, fresh(controller), self._laws, 0.0, np.zeros(3), np.zeros(3), ALL_FRESH, self._torques)

    @property
    def table(self) -> np.ndarray:
        """(n, COLUMNS) laws that act now, those that fade included; the table itself, for a compiled tick."""
        return self._laws

    @property
    def laws(self) -> np.ndarray:
        """(n, COLUMNS) laws that act now, those that fade included; a copy."""
        return self._laws.copy()

    def __call__(self, sample: Reading) -> np.ndarray:
        """One tick.

        Args:
            sample: What the device has read.

        Returns:
            (3,) torques for the device, N m: finite and within the limits, whatever was read.

        Raises:
            ValueError: The sample has not three angles.
        """
        if np.shape(sample.angles) != (3,):
            raise ValueError(f"a sample has angles of the shape {np.shape(sample.angles)}; it must be (3,)")
        self._lost = False
        return self._tick(sample)

    def drive(
        self,
        device: Device,
        *,
        ticks: int | None = None,
        until: Callable[[Reading], bool] | None = None,
        recorder: Recorder | None = None,
    ) -> Recording:
        """Drives a device as `device.run` does, and signals its loss to the supervisor.

        Afterwards the device is closed and without torque, and the supervisor disabled, or in FAULT if something has
        latched; another device may be driven next, and has its own clock and its own angles.

        Args:
            device: Any.
            ticks: Their number; None for as many as there are.
            until: Says after a tick that it was the last; the place for an operator, too.
            recorder: Where ticks are kept; given, it still has them after an exception.

        Returns:
            What was read and written.

        Raises:
            ValueError: The device has another period than the controller, or clips torques that the controller allows,
                each joint for itself, which would turn the force. It is closed.
            DeviceLostError: It does not answer; DEVICE_LOST is latched then, if force was enabled.
            BaseException: See `device.run`.
        """
        try:
            self.begin(device)
        except (ValueError, DeviceError):
            device.close()
            raise
        try:
            return run(device, self, ticks=ticks, until=until, recorder=recorder)
        except DeviceLostError:
            self.lost()
            raise
        finally:
            self._leave()

    def begin(self, device: Device) -> None:
        """Takes a device whose ticks another loop than `drive` calls.

        Raises:
            ValueError: It does not fit, see `drive`.
            DeviceLostError: It does not answer.
        """
        self._require_fit(device)
        if rouse := getattr(device, "rouse", None):  # of a board, whose watchdog has waited for us
            rouse()
        self._device = device

    def lost(self) -> None:
        """Signals that the device does not answer, in a tick that is not written to it."""
        self._lost = True
        self._tick_unread()

    def enable(self) -> None:
        """Lets force come in from the next tick on, if nothing forbids it; see `supervisor.state` then."""
        self.supervisor.enable()

    def disable(self) -> None:
        """Takes all torque away, along its slew, from the next tick on."""
        self.supervisor.disable()

    def reset(self) -> None:
        """Clears what is latched, and ends what the device's own watchdog began; `enable` is a request of its own."""
        if reset_watchdog := getattr(self._device, "reset_watchdog", None):
            reset_watchdog()
        self.supervisor.reset()

    def emergency_stop(self, pressed: bool = True) -> None:
        """The host's own emergency stop; the device's comes with its samples.

        Args:
            pressed: False when it is released; what it has latched waits for a reset.
        """
        self._stopped = pressed

    def heard(self) -> None:
        """A sign of life of whoever gives the commands; force fades when there is none for `limits.stale`."""
        self.supervisor.heard()

    def change(self, laws: ForceLaw | ArrayLike, seconds: float | None = None) -> None:
        """Other laws from now on, which is a sign of life too; the old ones fade out while the new ones fade in.

        Args:
            laws: A law or a table of laws, as `haptics.rendering.law_table` takes them.
            seconds: Time of the fade, s; 0 for at once, None for `limits.fade`.

        Raises:
            LawError: The laws are refused; the old ones stay.
            ValueError: The time is negative or not finite; likewise.
        """
        seconds = self.controller.limits.fade if seconds is None else seconds
        if not (math.isfinite(seconds) and seconds >= 0.0):
            raise ValueError(f"a fade of {seconds!r} s; it must be finite and not negative")
        table = law_table(laws)
        gains = table[:, GAIN].copy()
        self._step = self.controller.limits.period / seconds if seconds > 0.0 else 1.0
        table[:, GAIN] = 0.0
        self._gains = np.concatenate([np.zeros(len(self._laws)), gains])
        self._laws = np.vstack([self._laws, table])
        self.heard()

    def set_row(self, row: int, column: int, values: ArrayLike) -> None:
        """Changes parameters of a law at once, which is a sign of life; whoever does that at each tick bears for steps.

        Args:
            row: Of the table.
            column: First column that changes.
            values: (n,) finite numbers.
        """
        given = np.asarray(values, dtype=float)
        self._laws[row, column : column + len(given)] = given
        self.heard()

    def _tick(self, sample: Reading) -> np.ndarray:
        mine = self._stopped * FaultCode.EMERGENCY_STOP.bit | self._lost * FaultCode.DEVICE_LOST.bit
        self.supervisor.memory[SIGNALS] = float(sample.flags & EXTERNAL | mine)
        self._fade()
        self.bits = int(ticked(self.controller, self.memory, self._laws, sample, self._torques))
        if touch := getattr(self._device, "touch", None):
            touch(bool(self.memory.work[TOUCHED]))
        self._last = sample
        return self._torques.copy()

    def _tick_unread(self) -> None:
        """A tick without a reading: the last one again, a period later, so that only signals and requests act."""
        if self._last is not None:
            later = self._last.time + self.controller.limits.period
            self._tick(self._last._replace(time=later, fresh=ALL_FRESH))

    def _fade(self) -> None:
        """Moves the gains on, and drops laws that have faded out."""
        gains = self._laws[:, GAIN]
        if np.array_equal(gains, self._gains):
            return
        for i, target in enumerate(self._gains):
            gains[i] = fade(gains[i], target, self._step)
        keep = (gains > 0.0) | (self._gains > 0.0)
        self._laws, self._gains = np.ascontiguousarray(self._laws[keep]), self._gains[keep]

    def _leave(self) -> None:
        """The device is without torque, and so is the memory; the next device is not compared with this one."""
        self.disable()
        self._tick_unread()
        memory = self.supervisor.memory
        memory[[STARTED, KNOWN, PLACED]] = 0.0
        for row in (RENDERED, GRAVITY, OUT):
            memory[row : row + 3] = 0.0
        self.memory.filters[:] = fresh_memory()
        self._device = self._last = None

    def _require_fit(self, device: Device) -> None:
        limits = self.controller.limits
        period, torque = getattr(device, "period", limits.period), getattr(device, "torque_limit", limits.torque)
        if not math.isclose(period, limits.period, rel_tol=_SAME_PERIOD):
            raise ValueError(f"the device has a period of {period:g} s, the controller one of {limits.period:g} s")
        if torque < limits.torque:
            raise ValueError(f"the device clips at {torque:g} N m, the controller allows {limits.torque:g} N m a joint")
