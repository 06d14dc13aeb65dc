"""A simulated device with something wrong between controller and joints, and a start-up that runs on it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism import forward_kinematics
from haptics.control.controller import WORK
from haptics.control.startup import record as r
from haptics.control.startup.record import Refusal, StartMemory, StartUp, Step
from haptics.control.startup.steps import start
from haptics.control.supervisor.memory import SIGNALS, reset_memory
from haptics.devices.simulated import SimulatedDevice
from haptics.loop.choice import chosen_loop
from haptics.loop.hardware import real_plant, sensor_errors
from haptics.model.machine import MachineModel
from haptics.model.plant import Plant

PERIOD = 5e-4
LONGEST = 12.0  # s


@dataclass
class Fault:
    """What is wrong; all of it left out is a device as it should be.

    Attributes:
        read: From the angles as they are, and the time, to what the encoders say.
        drive: From the torques that are commanded to those that the motors give.
        plant: Changes the device.
        push: (3,) N on the handle.
        signal: From the time to bits of the supervisor's `SIGNALS`.
    """

    read: Callable[[np.ndarray, float], np.ndarray] = lambda theta, _: theta
    drive: Callable[[np.ndarray], np.ndarray] = lambda torque: torque
    plant: Callable[[Plant], Plant] = lambda par: par
    push: tuple[float, float, float] = (0.0, 0.0, 0.0)
    signal: Callable[[float], int] = lambda _: 0


class Ended(NamedTuple):
    """How a start-up ended.

    Attributes:
        step: READY or REFUSED, or where it was when the time was over.
        refusal: Why.
        joint: Which.
        memory: Of the start-up.
        readings: (ticks, 4) time and angles as read.
        torques: (ticks, 3) as commanded.
        bits: (ticks,) findings.
        signals: (ticks,) as signalled.
    """

    step: Step
    refusal: Refusal
    joint: int
    memory: StartMemory
    readings: np.ndarray
    torques: np.ndarray
    bits: np.ndarray
    signals: np.ndarray


def lying(machine: MachineModel, par: StartUp, truth: Plant) -> SimulatedDevice:
    """A device at rest on its lower stops."""
    rest = forward_kinematics(machine.geometry, np.full(3, par.stop_low + 1e-3))
    period = par.limits.period
    errors = sensor_errors(machine, chosen_loop(machine.design, 1.0 / period))._replace(once=0.0, twice=0.0)
    return SimulatedDevice(truth, rest, period=period, count=par.limits.encoder_count, steps=6, errors=errors)


def _begun(par: StartUp) -> StartMemory:
    """The memory of a start-up that has not begun."""
    return StartMemory(np.zeros(r.MEMORY), reset_memory(par.limits), np.zeros(WORK))


def run(machine: MachineModel, par: StartUp, fault: Fault, after: float = 0.1) -> Ended:
    """Runs a start-up from the lower stops.

    Args:
        machine: The device as designed.
        par: Parameters of the start-up.
        fault: What is wrong with the device.
        after: How long it goes on after its end, s.
    """
    period = par.limits.period
    device = lying(machine, par, fault.plant(real_plant(machine)))
    device.force = np.array(fault.push)
    memory, out, ended = _begun(par), np.zeros(3), 0.0
    readings, torques, bits, signals = [], [], [], []
    while device.time < LONGEST and ended <= after:
        sample = device.read()
        theta = fault.read(sample.angles.copy(), sample.time)
        signal = fault.signal(sample.time)
        memory.supervisor[SIGNALS] = float(signal)
        bits.append(int(start(par, memory, sample.time, theta, sample.fresh, out)))
        readings.append((sample.time, *theta))
        torques.append(out.copy())
        signals.append(signal)
        device.write(fault.drive(out.copy()))
        if memory.start[r.STEP] >= Step.READY:
            ended += period
    step, code = Step(int(memory.start[r.STEP])), Refusal(int(memory.start[r.CODE]))
    reported = (np.array(readings), np.array(torques), np.array(bits), np.array(signals))
    return Ended(step, code, int(memory.start[r.JOINT]), memory, *reported)


def scaled(joint: int, factor: float) -> Callable[[np.ndarray], np.ndarray]:
    """A drive whose torque at one joint is another."""

    def drive(torque: np.ndarray) -> np.ndarray:
        torque[joint] *= factor
        return torque

    return drive


def mirrored(joint: int) -> Callable[[np.ndarray, float], np.ndarray]:
    """An encoder of the other sign, whose zero was set on the lower stop."""
    first: list[float] = []

    def read(theta: np.ndarray, _: float) -> np.ndarray:
        first.append(theta[joint]) if not first else None
        theta[joint] = 2.0 * first[0] - theta[joint]
        return theta

    return read


def exchanged(values: np.ndarray, *_: float) -> np.ndarray:
    """The first two joints' wires exchanged."""
    return values[[1, 0, 2]]


@dataclass
class Held:
    """An encoder that keeps one count, or says nothing from a time on.

    Attributes:
        joint: Which.
        begin: s.
        value: What it says; None for its last count.
        flicker: What every other reading has more, rad.
    """

    joint: int
    begin: float = 0.0
    value: float | None = None
    flicker: float = 0.0
    last: list[float] = field(default_factory=list)
    odd: bool = False

    def __call__(self, theta: np.ndarray, time: float) -> np.ndarray:
        """The angles as read."""
        if time >= self.begin:
            if not self.last:
                self.last.append(theta[self.joint])
            theta[self.joint] = self.last[0] if self.value is None else self.value
            self.odd = not self.odd
            theta[self.joint] += self.flicker * self.odd
        return theta
