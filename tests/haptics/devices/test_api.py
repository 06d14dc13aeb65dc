"""The interface for programs: where the handle is, what force it feels, what happens when something is wrong."""

from __future__ import annotations

import threading
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptics
from delta_cad.design import Design
from delta_cad.mechanism import inverse_kinematics
from haptics.calibration.unknowns import nominal
from haptics.control.supervisor.faults import FaultCode, State
from haptics.devices.api import HapticDevice, opened_device
from haptics.devices.calibrated import CalibratedDevice
from haptics.devices.device import DeviceError, DeviceLostError, EndOfRecordingError, Reading
from haptics.devices.recording import Recording
from haptics.devices.simulated import SimulatedDevice
from haptics.loop.assumptions import nominal_plant
from haptics.loop.choice import at_rate
from haptics.loop.hardware import board_controller
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand
from tests.committed import BEST
from tests.haptics.devices.fake import FakeDevice
from tests.haptics.devices.served import served
from tests.haptics.scene_machine import WITHOUT_NOISE
from tests.optimizer.certify.designs import masses
from tests.terminal import HANGS_S


def smooth(machine: MachineModel) -> SimulatedDevice:
    """A device without friction whose handle a stiff spring holds, which is the force gauge."""
    par = nominal_plant(machine)._replace(coulomb=0.0)
    return SimulatedDevice(par, machine.centre, steps=10, hand=Hand(0.1, 40.0, 2000.0))


def handle(machine: MachineModel, device: object) -> HapticDevice:
    return HapticDevice(device, board_controller(machine, at_rate(1000.0), **WITHOUT_NOISE))  # type: ignore[arg-type]


def test_a_force_is_felt_as_it_was_given(machine: MachineModel) -> None:
    plant = smooth(machine)
    force = np.array([0.6, -0.4, 0.5])
    with handle(machine, plant) as device:
        assert device.state is State.DISABLED
        np.testing.assert_allclose(device.position(), machine.centre, atol=1e-12)
        for _ in range(1500):
            device.set_force(force)
        assert device.state is State.ACTIVE
        assert device.faults == ()
        assert device.time == pytest.approx(1.5)
        # spring of the gauge: its stretch is the force; the weight is held by the device
        np.testing.assert_allclose(2000.0 * (plant.state[:3] - machine.centre), force, atol=2e-3)
        np.testing.assert_allclose(device.position(), plant.state[:3], atol=1e-9)
        np.testing.assert_allclose(device.angles(), inverse_kinematics(machine.geometry, device.position()), atol=1e-9)
    assert not plant.torques.any()
    device.close()
    with pytest.raises(DeviceError, match="closed"):
        device.set_force(force)


def test_velocity_is_that_of_the_handle(machine: MachineModel) -> None:
    plant, speed = smooth(machine), np.array([0.03, 0.02, -0.02])
    with handle(machine, plant) as device:
        for n in range(400):
            plant.anchor = machine.centre + speed * n * device.period
            device.set_force(np.zeros(3))
        np.testing.assert_allclose(device.velocity(), speed, atol=1e-3)


def test_looking_twice_changes_nothing(machine: MachineModel) -> None:
    one, other = smooth(machine), smooth(machine)
    with handle(machine, one) as a, handle(machine, other) as b:
        for n in range(200):
            force = np.array([0.3 * np.sin(0.1 * n), 0.0, 0.0])
            for _ in range(n % 3):
                a.position(), a.velocity(), a.angles()
            a.set_force(force)
            b.set_force(force)
    np.testing.assert_array_equal(one.state, other.state)


@pytest.mark.parametrize(
    "force", [[1.0, 2.0], [np.nan, 0.0, 0.0], [np.inf, 0.0, 0.0], None, ["a", 0.0, 0.0], [1j, 0.0, 0.0], [[1.0]], 5]
)
def test_a_force_that_is_none(machine: MachineModel, force: Any) -> None:
    with handle(machine, smooth(machine)) as device:
        before = device.time
        with pytest.raises(ValueError, match="three finite numbers"):
            device.set_force(force)
        assert device.time == before


def test_an_encoder_that_fails_latches_until_the_reset(machine: MachineModel) -> None:
    good = inverse_kinematics(machine.geometry, machine.centre)
    count = 1e-5 * np.eye(3)[0]  # an encoder that keeps one count under torque is suspected
    script = [good + (n % 2) * count for n in range(700)]
    script[300:310] = [np.array([np.nan, 0.0, 0.0])] * 10
    fake = FakeDevice(script)
    with handle(machine, fake) as device:
        for _ in range(299):
            device.set_force([0.1, 0.0, 0.0])
        device.set_force([0.1, 0.0, 0.0])
        assert np.isnan(device.position()).all()
        for _ in range(20):
            device.set_force([0.1, 0.0, 0.0])
        assert device.state is State.FAULT
        assert FaultCode.ANGLE_INVALID in device.faults
        device.reset()
        for _ in range(20):
            device.set_force([0.1, 0.0, 0.0])
        assert device.state is State.RAMPING
        assert FaultCode.ANGLE_INVALID not in device.faults
    assert not np.any(fake.written[-1])


def test_a_device_that_is_lost_says_so_and_can_be_closed(machine: MachineModel) -> None:
    good = inverse_kinematics(machine.geometry, machine.centre)
    fake = FakeDevice([good, good, DeviceLostError("gone")])
    with handle(machine, fake) as device:
        device.set_force(np.zeros(3))
        with pytest.raises(DeviceLostError, match="gone"):
            device.set_force(np.zeros(3))
        assert FaultCode.DEVICE_LOST in device.faults
    assert fake.closed == 1


def test_a_device_that_does_not_fit_or_read_is_closed(machine: MachineModel) -> None:
    fake = FakeDevice([])
    with pytest.raises(EndOfRecordingError):
        handle(machine, fake)
    assert fake.closed == 1
    slow = SimulatedDevice(nominal_plant(machine), machine.centre, period=2e-3)
    with pytest.raises(ValueError, match="period"):
        handle(machine, slow)
    with pytest.raises(DeviceError, match="closed"):
        slow.read()


def test_open_takes_a_design_and_its_masses(best: Design, tmp_path: Path) -> None:
    weights = masses(tmp_path, best, 1e-5)
    with haptics.open(BEST, masses=weights, rate_Hz=500.0) as device:
        assert device.period == pytest.approx(2e-3)
        for _ in range(20):
            device.set_force(np.zeros(3))
        assert device.time == pytest.approx(0.04)


def test_a_program_may_take_its_time_before_its_first_force(machine: MachineModel) -> None:
    """The board's watchdog trips meanwhile; later it is a fault."""

    def nobody_commands() -> None:
        for _ in range(40):
            up.listening.sendto(up.board.tick() or b"", up.board.peer)
        assert up.board.tripped

    with served(machine) as up, handle(machine, opened_device(machine, "socket", port=up.port, timeout=20.0)) as device:
        nobody_commands()
        for _ in range(30):
            device.set_force([0.0, 0.0, 0.1])
        assert (device.state, device.faults) == (State.RAMPING, ())
        nobody_commands()
        device.set_force([0.0, 0.0, 0.1])
        device.set_force([0.0, 0.0, 0.1])
        assert device.state is State.FAULT
        assert FaultCode.WATCHDOG in device.faults


def test_each_kind_is_opened(machine: MachineModel) -> None:
    with served(machine) as up:
        remote = opened_device(machine, "socket", port=up.port, timeout=20.0)
        with handle(machine, remote) as device:
            for _ in range(50):
                device.set_force([0.0, 0.0, 0.1])
            assert device.position()[2] == pytest.approx(machine.centre[2], abs=1e-3)
        assert not up.board.connected
    recording = Recording(np.arange(3) * 1e-3, np.zeros((3, 3)), np.zeros((3, 3)))
    recorded = CalibratedDevice(FakeDevice([Reading(a, t) for t, a in zip(*recording[:2], strict=True)]),
                                machine.geometry, nominal(machine.geometry))  # fmt: skip
    with handle(machine, recorded) as device:
        device.set_force(np.zeros(3))
        device.set_force(np.zeros(3))
        with pytest.raises(EndOfRecordingError):
            device.set_force(np.zeros(3))


@pytest.mark.parametrize(
    ("kind", "more", "word"),
    [
        ("serial", {}, "simulated, socket, recorded"),
        ("socket", {}, "port"),
        ("recorded", {}, "recording"),
        ("simulated", {"rate_Hz": 5.0}, "rate"),
    ],
)
def test_what_cannot_be_opened_is_refused(machine: MachineModel, kind: str, more: dict[str, float], word: str) -> None:
    with pytest.raises(ValueError, match=word):
        opened_device(machine, kind, **more)  # type: ignore[arg-type]


class Slow(FakeDevice):
    """A device that never ends and takes a while to write, in which another thread may come."""

    def __init__(self, angles: np.ndarray) -> None:
        super().__init__(Reading(angles, 1e-3 * n) for n in count())
        self.inside, self.most, self.driven = 0, 0, threading.Event()

    def write(self, torques: Any) -> None:
        self.inside += 1
        self.most = max(self.most, self.inside)
        threading.Event().wait(2e-4)
        super().write(torques)
        self.inside -= 1
        if len(self.written) > 20:
            self.driven.set()


def test_a_thread_closes_what_others_drive(machine: MachineModel) -> None:
    """No tick is cut in two, and zero is the last that the device is told."""
    plant = Slow(inverse_kinematics(machine.geometry, machine.centre))
    device, ended = handle(machine, plant), []

    def drive(force: float) -> None:
        try:
            while True:
                device.set_force([force, 0.0, 0.0])
        except DeviceError as error:
            ended.append(str(error))

    threads = [threading.Thread(target=drive, args=(force,)) for force in (1.0, -1.0)]
    for thread in threads:
        thread.start()
    was_driven = plant.driven.wait(HANGS_S)
    device.close()
    for thread in threads:
        thread.join(HANGS_S)
    assert was_driven
    assert ended == ["the device is closed"] * 2
    assert plant.most == 1
    assert not np.any(plant.written[-1])


def test_another_machine_must_be_allowed(machine: MachineModel) -> None:
    with pytest.raises(ValueError, match="allow_remote"):
        opened_device(machine, "socket", host="192.0.2.1", port=5005)
    with pytest.raises(DeviceLostError):  # an address that nobody has: it is tried
        opened_device(machine, "socket", host="192.0.2.1", port=5005, timeout=0.01, allow_remote=True)
