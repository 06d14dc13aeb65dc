"""The machine as equations: the exact plant, its encoders, and the time that a torque takes. Loads numba."""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.devices.device import DeviceError, Reading, three_torques
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import chosen_loop
from haptics.loop.hardware import reading_age, real_plant, sensor_errors
from haptics.loop.simulation import timing
from haptics.model.drive_train import TWIST
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, STATES, Hand, Plant, advance, angles
from haptics.model.sensor import EXACT, SensorErrors, reading

_STEP_S = 5e-5  # of the simulation, somewhat less than in `loop.wall_trial`
_MIDDLE = 0.5  # place of the encoders' counts: a count is read about its middle


class SimulatedDevice:
    """A plant, a hand, and a clock that moves on by one period from reading to reading.

    A torque acts on the motors a delay after the reading that it answers, and with it how much the drives damp.
    Readings have counts, and errors that a seed draws.

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
        delay: float = 0.0,
        errors: SensorErrors = EXACT,
        seed: int = 0,
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
        self._clock, self._errors, self._random = timing(period, delay, steps), errors, np.random.default_rng(seed)
        self._noise = self._random.standard_normal(3)
        self._commands = deque([(np.zeros(3), False)] * (self._clock.ticks + 2), self._clock.ticks + 2)
        angles(par, self.state, self._theta)
        if not np.isfinite(self._theta).all():
            raise ValueError(f"the handle cannot be at {self.anchor.tolist()} m: a chain cannot be closed")
        none = np.zeros(3)  # compiled before a host waits for it
        advance(par, hand, self.anchor, none, none, period, 1, self.state.copy(), self._room)
        _read(errors, self._theta, none, none, float(count), none.copy())

    @property
    def time(self) -> float:
        """Time of the last reading, s."""
        return max(self._tick, 0) * self.period

    def read(self) -> Reading:
        """Moves the plant on by a period, but for the first time, and reads its encoders; see `Device`."""
        self._require_open()
        if self._tick >= 0:
            self._move()
            kept = self._errors.kept
            self._noise = kept * self._noise + math.sqrt(1.0 - kept * kept) * self._random.standard_normal(3)
        self._tick += 1
        angles(self.par, self.state, self._theta)
        read, twist = np.empty(3), self.state[TWIST : TWIST + 3]
        _read(self._errors, self._theta, twist, self._noise, float(self.count), read)
        return Reading(read, self.time)

    def _move(self) -> None:
        """A period of the plant: with the command before the newest that has arrived, then with that one."""
        clock = self._clock
        self._commands.append((self.torques, self._touched))
        parts = ((0, clock.late, clock.before), (1, clock.period - clock.late, clock.after))
        for place, seconds, steps in parts:
            torques, touched = self._commands[place]
            if steps > 0:
                advance(
                    self.par.in_contact if touched else self.par, self.hand, self.anchor, self.force, torques,
                    seconds, steps, self.state, self._room,
                )  # fmt: skip

    def recover(self) -> None:
        """Puts the handle back to where it began, at rest, if the simulation has lost it; its clock goes on."""
        if not np.isfinite(self.state).all() or not np.isfinite(self._theta).all():
            self.state[:] = 0.0
            self.state[:3], self.torques = self._start, np.zeros(3)
            self._commands.extend([(self.torques, False)] * len(self._commands))
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


@compiled
def _read(errors, theta, twist, noise, count, out):
    for i in range(3):
        sound = math.isfinite(theta[i])
        out[i] = reading(errors, i, theta[i], twist[i], noise[i], count, _MIDDLE) if sound else math.nan


def simulated_machine(machine: MachineModel, period: float = 1e-3, *, linked: bool = False) -> SimulatedDevice:
    """Makes the simulated device of a design, with all that `simulate` gives it.

    Cable and structure give way, joints rub, motors lag and ripple, arms meet their stops; encoders have counts, noise
    and waves; a torque acts as late as the loop of that rate is nominally, a reading's age included.

    Args:
        machine: The design and its masses.
        period: Of its tick, s.
        linked: Whether a host closes the loop, a period late; see `LoopChoice.linked`.

    Returns:
        The device, its handle in the middle of the cube.
    """
    loop = chosen_loop(machine.design, 1.0 / period)
    loop = loop.linked if linked else loop
    return SimulatedDevice(
        real_plant(machine, loop),
        machine.centre,
        period=period,
        count=encoder_count(machine),
        steps=max(2, round(period / _STEP_S)),
        delay=loop.delay + reading_age(machine, loop),
        errors=sensor_errors(machine, loop),
    )
