"""The start-up on the simulated device, as it should be and with faults planted: each is refused by its name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from haptics.control.startup import record as r
from haptics.control.startup.record import ABOUT, Refusal, StartUp, Step
from haptics.control.supervisor.faults import FaultCode
from haptics.loop.start_up import start_up
from haptics.model.machine import MachineModel
from tests.haptics.control.startup.planted import PERIOD, Fault, Held, exchanged, mirrored, run, scaled


@pytest.fixture(scope="module")
def par(machine: MachineModel) -> StartUp:
    return start_up(machine, PERIOD, absolute=True)


def test_a_device_as_designed_is_ready_in_the_cube_s_centre(machine: MachineModel, par: StartUp) -> None:
    ended = run(machine, par, Fault())
    assert (ended.step, ended.refusal) == (Step.READY, Refusal.NONE)
    assert ended.readings[-1, 1:] == pytest.approx([par.centre] * 3, abs=0.05)
    gains = ended.memory.start[r.GAINS : r.GAINS + 3]
    assert np.all((gains > 0.8) & (gains < 1.2))
    assert np.abs(ended.torques).max() < par.limits.torque
    assert np.abs(np.diff(ended.readings[:, 1:], axis=0)).max() / PERIOD < 8.0  # rad/s, of the pulses


def test_encoders_of_any_zero_get_theirs_from_the_lower_stops(machine: MachineModel) -> None:
    par, off = start_up(machine, PERIOD, absolute=False), np.array([0.4, -2.0, 7.0])
    ended = run(machine, par, Fault(read=lambda theta, _: theta + off))
    assert ended.step is Step.READY
    # the stop bends by a thousandth under the weight
    assert ended.memory.start[r.OFFSET : r.OFFSET + 3] == pytest.approx(-off, abs=3e-3)


# what is told first is tried in the quick tier: every refusal once
FAULTS = {
    "an encoder's sign": (Fault(read=mirrored(1)), Refusal.SIGN, 1),
    "a motor's sign": (Fault(drive=scaled(2, -1.0)), Refusal.NO_MOTION, 2),
    "motors exchanged": (Fault(drive=exchanged), Refusal.SWAPPED, 0),
    "twice the torque": (Fault(drive=scaled(1, 2.2)), Refusal.GAIN, 1),
    "half the torque": (Fault(drive=scaled(2, 0.45)), Refusal.GAIN, 2),
    "a weight on the handle": (Fault(push=(0.0, 0.0, -0.8)), Refusal.GRAVITY, 0),
    "counts a turn": (
        Fault(read=lambda theta, _: -1.0995 + 0.96 * (theta + 1.0995)),
        Refusal.RANGE,
        0,
    ),
    "a zero that was never set": (
        Fault(read=lambda theta, _: theta + np.array([0.0, 0.0, 0.06])),
        Refusal.ZERO,
        2,
    ),
    "a hand that plays": (
        Fault(read=lambda theta, t: theta + 0.01 * math.sin(20.0 * t)),
        Refusal.NOT_STILL,
        2,
    ),
    "an encoder that falls silent": (Fault(read=Held(0, 2.0, math.nan)), Refusal.SUPERVISOR, 3),
    "an encoder that sticks on the way": (Fault(read=Held(0, 1.9)), Refusal.SUPERVISOR, 3),
    "an encoder that flickers on the way": (Fault(read=Held(0, 1.9, flicker=1e-5)), Refusal.LOST, 0),
    "a dead motor": (Fault(drive=scaled(0, 0.0)), Refusal.NO_MOTION, 0),
    "a dead encoder": (Fault(read=Held(1)), Refusal.SUPERVISOR, 3),
    "a dead encoder that flickers": (Fault(read=Held(1, flicker=1e-5)), Refusal.SWAPPED, 1),
    "encoders exchanged": (Fault(read=exchanged), Refusal.SWAPPED, 0),
    "a jammed joint": (Fault(plant=lambda par: par._replace(arm_coulomb=1.0)), Refusal.NO_MOTION, 0),
    "mounted askew": (
        Fault(plant=lambda par: par._replace(gravity_x=9.81 * math.sin(0.7), gravity_z=-9.81 * math.cos(0.7))),
        Refusal.GRAVITY,
        0,
    ),
    "emergency stop": (
        Fault(signal=lambda t: FaultCode.EMERGENCY_STOP.bit * (t > 1.0)),
        Refusal.SUPERVISOR,
        3,
    ),
}


@pytest.mark.quick(11)
@pytest.mark.parametrize("name", FAULTS)
def test_a_planted_fault_is_refused_by_its_name(machine: MachineModel, par: StartUp, name: str) -> None:
    fault, refusal, joint = FAULTS[name]
    ended = run(machine, par, fault)
    start = ended.memory.start
    assert (ended.step, ended.refusal, ended.joint) == (Step.REFUSED, refusal, joint), start[: r.BEGUN]
    assert not np.any(ended.torques[-20:])  # 0.1 s later all torque is gone
    if refusal in (Refusal.GAIN, Refusal.GRAVITY, Refusal.RANGE, Refusal.ZERO, Refusal.LOST):
        low = refusal is Refusal.GAIN and start[r.BOUND] < 1.0
        assert abs(start[r.VALUE]) < start[r.BOUND] if low else abs(start[r.VALUE]) > start[r.BOUND]


def test_every_refusal_is_planted_and_says_what_to_do() -> None:
    assert {refusal for _, refusal, _ in FAULTS.values()} == set(ABOUT) == set(Refusal) - {Refusal.NONE}
