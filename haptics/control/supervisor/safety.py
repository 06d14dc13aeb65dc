"""Interface of the supervisor for operator, host and stop button; the two calls of a tick are compiled."""

from __future__ import annotations

import numpy as np

from haptics.control.supervisor import memory as m
from haptics.control.supervisor import supervisor as s
from haptics.control.supervisor.faults import EXTERNAL, FaultCode, State, findings
from haptics.control.supervisor.limits import SafetyLimits, checked


class Supervisor:
    """Limits and memory together, with names for what may be done to them.

    A compiled loop takes `limits` and `memory` and calls `supervisor.check` and `supervisor.limit` itself.

    Attributes:
        limits: The limits.
        memory: (MEMORY,) as laid out in `memory`.

    Raises:
        ValueError: The limits contradict each other.
    """

    def __init__(self, limits: SafetyLimits) -> None:
        self.limits = checked(limits)
        self.memory = m.reset_memory(limits)

    @property
    def state(self) -> State:
        """The state after the last call."""
        return State(int(self.memory[m.STATE]))

    @property
    def latched(self) -> tuple[FaultCode, ...]:
        """Faults that wait for a reset."""
        return findings(int(self.memory[m.LATCHED]))

    @property
    def present(self) -> tuple[FaultCode, ...]:
        """Findings of the last check."""
        return findings(int(self.memory[m.PRESENT]))

    def enable(self) -> None:
        """Lets force come in at the next check, if no fault is present and no motor warm; see `state` then."""
        self.memory[m.REQUEST] = m.ENABLE

    def disable(self) -> None:
        """Takes all torque away from the next check on."""
        self.memory[m.REQUEST] = m.DISABLE

    def reset(self) -> None:
        """Clears what is latched at the next check; the state is DISABLED then; `enable` is a request of its own."""
        self.memory[m.REQUEST] = m.RESET

    def heard(self) -> None:
        """The host has spoken: a new scene, or a sign of life."""
        self.memory[m.HEARD] = self.memory[m.NOW]

    def signal(self, fault: FaultCode, present: bool = True) -> None:
        """Holds up a finding from outside, or takes it down.

        Args:
            fault: EMERGENCY_STOP, WATCHDOG or DEVICE_LOST.
            present: Whether it holds.

        Raises:
            ValueError: The supervisor finds this one itself.
        """
        if not fault.bit & EXTERNAL:
            names = ", ".join(f.name for f in findings(EXTERNAL))
            raise ValueError(f"{fault.name} cannot be signalled; only {names} come from outside")
        held = int(self.memory[m.SIGNALS])
        self.memory[m.SIGNALS] = float(held | fault.bit if present else held & ~fault.bit)

    def check(self, now: float, theta: np.ndarray, p: np.ndarray, reach: float, volume: float) -> int:
        """Looks for faults in a reading before the controller computes anything; arguments as `supervisor.check`.

        The readings are the angles, as of a device without calibration.
        """
        return s.check(self.limits, self.memory, now, theta, theta, p, reach, volume)

    def limit(self, rendered: np.ndarray, gravity: np.ndarray, out: np.ndarray) -> int:
        """Bounds what the controller computed to what is safe; arguments as `supervisor.limit`."""
        return s.limit(self.limits, self.memory, rendered, gravity, out)
