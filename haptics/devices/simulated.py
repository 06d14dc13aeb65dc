"""The machine as equations: the exact plant with a quantised encoder. Importing this module loads numba."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from haptics.devices.device import DeviceError, Reading, three_torques
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, STATES, Hand, Plant, advance, angles
from haptics.simulation.assumptions import encoder_count
from haptics.simulation.hardware import real_plant, stiff_plant

STEP_S = 1e-4  # of the simulation: a tenth of the time in which a motor's current and an arm on its stop move


class SimulatedDevice:
    """A plant, a hand, and a clock that moves on by one period from reading to reading.

    Attributes:
        state: (STATES,) of the plant; may be set between ticks.
        hand: The hand; may be changed between ticks.
        anchor: (3,) where the person wants the handle, m; may be changed between ticks.
        force: (3,) further force on the handle, N; likewise.
        torques: (3,) held at the motors, N m.

    Raises:
        ValueError: The handle cannot be where it is to start, or period, steps or count are not positive.
    """

    def __init__(
        self,
        par: Plant,
        position: ArrayLike,
        *,
        period: float = 1e-3,
        count: float = 0.0,
        hand: Hand = FREE,
        steps: int = 4,
    ) -> None:
        if not (period > 0.0 and steps > 0 and count >= 0.0):
            raise ValueError(f"period {period!r} s, steps {steps!r} and count {count!r} rad must be positive")
        self.par, self.period, self.count, self.hand, self.steps = par, period, count, hand, steps
        self.state, self.anchor = np.zeros(STATES), np.array(position, dtype=float)
        self.state[:3] = self.anchor
        self._start = self.anchor.copy()
        self.force, self.torques = np.zeros(3), np.zeros(3)
        self._room, self._theta = np.zeros((13, STATES)), np.zeros(3)
        self._tick, self._closed, self._touched = -1, False, False
        angles(par, self.state, self._theta)
        if not np.isfinite(self._theta).all():
            raise ValueError(f"the handle cannot be at {self.anchor.tolist()} m: a chain cannot be closed")

    @property
    def time(self) -> float:
        """Time of the last reading, s."""
        return max(self._tick, 0) * self.period

    def read(self) -> Reading:
        """Moves the plant on by a period, but for the first time, and reads its encoders; see `Device`."""
        self._require_open()
        if self._tick >= 0:
            advance(
                self.par.in_contact if self._touched else self.par, self.hand, self.anchor, self.force, self.torques,
                self.period, self.steps, self.state, self._room,
            )  # fmt: skip
        self._tick += 1
        angles(self.par, self.state, self._theta)
        read = np.round(self._theta / self.count) * self.count if self.count > 0.0 else self._theta.copy()
        return Reading(read, self.time)

    def recover(self) -> None:
        """Puts the handle back to where it began, at rest, if the simulation has lost it; its clock goes on."""
        if not np.isfinite(self.state).all() or not np.isfinite(self._theta).all():
            self.state[:] = 0.0
            self.state[:3], self.torques = self._start, np.zeros(3)
            angles(self.par, self.state, self._theta)

    def touch(self, touched: bool) -> None:
        """Says whether a wall is touched: the drives then damp more; see `Plant.contact_damping`."""
        self._touched = touched

    def write(self, torques: ArrayLike) -> None:
        """Sets the torques that the motors are asked for until the next call, (3,) N m."""
        self._require_open()
        self.torques = three_torques(torques)

    def close(self) -> None:
        """Takes the torques away; a later reading or command raises `DeviceError`."""
        self.torques, self._closed = np.zeros(3), True

    def _require_open(self) -> None:
        if self._closed:
            raise DeviceError("the simulated device is closed")


def simulated_machine(machine: MachineModel, period: float = 1e-3) -> SimulatedDevice:
    """Makes the simulated device of a design: rigid, with nominal friction, motors that lag, end stops and counts.

    What noise, compliance, ripple, and the delay of a loop do, `simulation.loop` has with `hardware.real_plant`: here a
    reading is exact but for its count, and a torque acts on the motors at once.

    Args:
        machine: The design and its masses.
        period: Of its tick, s.

    Returns:
        The device, its handle in the middle of the cube.
    """
    whole = real_plant(machine)
    par = stiff_plant(machine)._replace(
        stop_low=whole.stop_low,
        stop_high=whole.stop_high,
        stop_stiffness=whole.stop_stiffness,
        stop_damping=whole.stop_damping,
        bezel_half=whole.bezel_half,
        bezel_limit=whole.bezel_limit,
        bezel_stiffness=whole.bezel_stiffness,
        bezel_damping=whole.bezel_damping,
    )
    steps = max(1, round(period / STEP_S))
    return SimulatedDevice(par, machine.centre, period=period, count=encoder_count(machine), steps=steps)
