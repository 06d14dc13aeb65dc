"""The host over the simulated device, over scripts, and over a real board process: force, stops, losses, other laws."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import inverse_kinematics
from haptics.control.controller import FORCE as WANTED
from haptics.control.controller import Controller, fresh, tick
from haptics.control.filters import low_pass
from haptics.control.pose import RATES, model
from haptics.control.supervisor.faults import FaultCode, State
from haptics.control.supervisor.memory import ENABLE, REQUEST, SIGNALS
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.devices.device import DeviceError, DeviceLostError, Reading, run
from haptics.devices.host import Host
from haptics.devices.link import UdpLink
from haptics.devices.recording import Recorder
from haptics.devices.remote import RemoteDevice
from haptics.rendering import law_table
from haptics.rendering.law import GAIN, LawError
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.registry import COLUMNS
from tests.committed import ROOT
from tests.haptics.control.supervisor.rig import DESIGN, GEOMETRY, HOME, LIMITS, MASSES
from tests.haptics.devices.boards.host_board import HAND, simulated
from tests.haptics.devices.fake import DisturbedDevice, FakeDevice, signalling

FORCE = np.array([0.2, -0.1, 1.0])
"""N; upwards in all joints, as the torque that holds the moving bodies: so the sum of both falls evenly at a stop."""
LAWS = law_table(ConstantForce(FORCE), SpringDamper(stiffness=100.0, damping=1.0, point=HOME))
REST = inverse_kinematics(GEOMETRY, HOME)
STEP = (LIMITS.slew + LIMITS.gravity_slew) * LIMITS.period
ROUNDING = 1e-12
"""N m: torques below 1 N m, added up a few times."""
PATIENT = 5.0
"""Seconds that a board in a test waits for its host: longer than any pause of a busy machine."""
PRESSED = 0.8
"""Time at which the emergency stop is pressed, s: half a second of ramp and time to come to rest before it."""


def controller(**changes: float) -> Controller:
    known = model(GEOMETRY, MASSES, DESIGN.requirements.gravity_m_s2)
    return Controller(known, low_pass(1e-3, 100.0), LIMITS._replace(**changes), np.inf)


def host(laws: Any = LAWS, **changes: float) -> Host:
    made = Host(controller(**changes), laws)
    made.enable()
    return made


@contextmanager
def board(pressed: float = 1e9, released: float = 1e9, limit: float = 0.8) -> Iterator[tuple[Any, RemoteDevice]]:
    """A board process, and the device that speaks to it."""
    words = [str(word) for word in (PATIENT, pressed, released, limit)]
    with subprocess.Popen(
        [sys.executable, "-m", "tests.haptics.devices.boards.host_board", *words],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    ) as process:
        assert process.stdout is not None
        try:
            yield process, RemoteDevice(UdpLink("127.0.0.1", int(process.stdout.readline())), timeout=PATIENT)
        finally:
            process.kill()


def test_it_is_the_controllers_tick() -> None:
    project_own, memory, out = host(), fresh(controller()), np.zeros(3)
    memory.supervisor[REQUEST] = ENABLE
    for k in range(50):
        theta = REST + 1e-3 * np.sin(0.1 * k)
        bits = tick(controller(), memory, LAWS, k * 1e-3, theta, theta, ALL_FRESH, out)
        np.testing.assert_array_equal(project_own(Reading(theta, k * 1e-3)), out)
        assert project_own.bits == bits
    assert np.abs(out).max() > 0.01


def test_force_is_rendered_on_the_simulated_device() -> None:
    project_own, felt = host(), simulated()
    still: list[np.ndarray] = []
    project_own.drive(felt, ticks=1500, until=lambda _sample: bool(still.append(felt.state[:3].copy())))
    # at rest the hand's spring, which begins at HOME, holds the constant force together with the scene's spring
    expected = HOME + FORCE / (HAND.stiffness + 100.0)
    np.testing.assert_allclose(still[-1], expected, atol=6e-5)  # two counts of an encoder, 0.03 mm each
    assert project_own.supervisor.state is State.DISABLED  # afterwards
    assert project_own.bits == 0


def stopping(project_own: Host) -> Callable[[Reading], bool]:
    """An operator: resets while it is pressed (after 0.1 s) and after its release (0.3 s), enables, and leaves."""

    def until(sample: Reading) -> bool:
        ticks = round(1e3 * (sample.time - PRESSED))
        if 0 <= ticks <= 300:
            assert project_own.supervisor.state is State.FAULT
            assert FaultCode.EMERGENCY_STOP in project_own.supervisor.latched
            # a board whose stop is released holds its torque back, by flag 1, until the reset
            assert set(project_own.supervisor.latched) <= {FaultCode.EMERGENCY_STOP, FaultCode.WATCHDOG}
        if ticks in (100, 300):
            project_own.reset()
        if ticks == 301:
            assert project_own.supervisor.state is State.DISABLED
            assert project_own.supervisor.latched == ()
            project_own.enable()
        if ticks == 950:
            assert project_own.supervisor.state is State.ACTIVE
        return ticks == 950

    return until


def stopped(times: np.ndarray, torques: np.ndarray) -> None:
    """The torque is there, goes to zero along the slew without a rise, stays away, and comes back."""
    first = int(np.searchsorted(times, PRESSED - 0.5e-3))
    assert np.abs(torques[first - 1]).min() > 0.02
    after = torques[first - 1 : first + 300]
    assert np.abs(np.diff(after, axis=0)).max() <= STEP + ROUNDING
    assert (np.diff(np.abs(after), axis=0) <= ROUNDING).all()
    assert after[1].all()  # not cut in one tick
    np.testing.assert_array_equal(after[60:], 0.0)
    np.testing.assert_allclose(torques[-1], torques[first - 1], atol=2e-3)  # the scene is there again, at its rest
    assert np.abs(torques).max() <= LIMITS.torque


def test_an_emergency_stop_of_the_simulated_device() -> None:
    project_own = host()
    first = round(PRESSED * 1e3)
    device = DisturbedDevice(
        simulated(), {k: signalling(FaultCode.EMERGENCY_STOP.bit) for k in range(first, first + 200)}
    )
    recording = project_own.drive(device, until=stopping(project_own))
    stopped(recording.time, recording.torques)


def test_an_emergency_stop_of_a_board_in_another_process() -> None:
    project_own, near = host(), host()
    with board(PRESSED, PRESSED + 0.2) as (_, device):
        recording = project_own.drive(device, until=stopping(project_own))
    stopped(recording.time, recording.torques)
    before = round(PRESSED * 1e3)
    same = near.drive(simulated(), ticks=before)
    # whole nanoseconds against sums of periods: 1e-15 s of a tick, far below one count; so the counts are the same
    np.testing.assert_array_equal(recording.angles[:before], same.angles)
    np.testing.assert_allclose(recording.torques[:before], same.torques, atol=1e-9)


@pytest.mark.slow
def test_a_board_that_dies_ends_in_device_lost_and_another_one_can_follow() -> None:
    project_own, recorder = host(), Recorder()
    with board() as (process, device):
        write = device.write

        def unplugged(torques: Any) -> None:  # before a packet is sent, so that the port's refusal is seen
            if device.time > 0.6 and process.poll() is None:
                process.kill()
                process.wait()
            write(torques)

        device.write = unplugged
        with pytest.raises(DeviceLostError):
            project_own.drive(device, recorder=recorder)
    assert np.abs(recorder.recording().torques[-1]).max() > 0.02
    assert project_own.supervisor.latched == (FaultCode.DEVICE_LOST,)
    assert project_own.supervisor.state is State.FAULT
    assert project_own.bits & FaultCode.DEVICE_LOST.bit
    with board() as (_, device):
        assert again(project_own, device)


def again(project_own: Host, device: Any) -> bool:
    """The next device answers: the signal is down, reset and enable bring the force back from zero."""

    def until(sample: Reading) -> bool:
        if len(recorder) == 1:
            assert not project_own.memory.supervisor[SIGNALS]
            assert project_own.supervisor.latched == (FaultCode.DEVICE_LOST,)
            project_own.reset()
        if len(recorder) == 2:
            assert project_own.supervisor.state is State.DISABLED
            project_own.enable()
        return sample.time > 0.6

    recorder = Recorder()
    torques = project_own.drive(device, until=until, recorder=recorder).torques
    np.testing.assert_array_equal(torques[:2], 0.0)
    assert np.abs(np.diff(torques, axis=0)).max() <= STEP + ROUNDING
    return bool(np.abs(torques[-1]).min() > 0.02)


def test_a_device_lost_at_once_or_while_writing() -> None:
    project_own = host()
    with pytest.raises(DeviceLostError):
        project_own.drive(FakeDevice([DeviceLostError("cable out")]))
    assert project_own.supervisor.state is State.DISABLED  # nothing was enabled yet
    device = FakeDevice([REST] * 9, refusals={5: DeviceLostError("cable out")})
    project_own.enable()
    with pytest.raises(DeviceLostError):
        project_own.drive(device)
    assert project_own.supervisor.latched == (FaultCode.DEVICE_LOST,)


def test_a_device_is_closed_and_the_host_disabled_whatever_ends_the_run() -> None:
    project_own = host()
    for error in (KeyboardInterrupt(), None):
        device = FakeDevice([REST] * 30 + ([error] if error else []))
        if error:
            with pytest.raises(KeyboardInterrupt):
                project_own.drive(device)
        else:
            written = project_own.drive(device).torques
            np.testing.assert_array_equal(written[0], 0.0)  # not the last torque of the run before: it ramps anew
            assert project_own.bits == 0
        assert device.closed == 1
        np.testing.assert_array_equal(device.written[-1], 0.0)
        assert project_own.supervisor.state is State.DISABLED


def test_the_next_device_is_not_compared_with_the_last_one() -> None:
    project_own = host()
    project_own.drive(FakeDevice([Reading(REST, 5.0 + 1e-3 * k) for k in range(20)]))
    project_own.enable()
    seen: list[int] = []
    project_own.drive(FakeDevice([REST + 0.1] * 20), until=lambda _sample: bool(seen.append(project_own.bits)))
    assert not np.any(seen)  # neither a clock that went back nor a jump of three joints
    np.testing.assert_allclose(project_own.memory.work[RATES], 0.0)  # nor a joint rate


def test_the_hosts_own_stop_joins_that_of_the_device() -> None:
    project_own = Host(controller(), LAWS)
    project_own.emergency_stop()
    project_own(Reading(REST, 0.0, FaultCode.WATCHDOG.bit))
    assert project_own.supervisor.latched == (FaultCode.EMERGENCY_STOP,)  # even while nothing is enabled
    assert project_own.supervisor.present == (FaultCode.WATCHDOG, FaultCode.EMERGENCY_STOP)
    project_own.emergency_stop(False)
    project_own(Reading(REST, 1e-3, FaultCode.ANGLE_JUMP.bit))  # not for a device to say
    assert project_own.supervisor.present == ()
    assert project_own.supervisor.latched == (FaultCode.EMERGENCY_STOP,)


def test_it_works_with_the_plain_runner_and_can_be_disabled() -> None:
    project_own = host()
    recording = run(
        FakeDevice([REST] * 60), project_own, until=lambda sample: bool(sample.time > 0.03 and project_own.disable())
    )
    assert np.abs(recording.torques[30]).max() > 0.01
    np.testing.assert_array_equal(recording.torques[-1], 0.0)
    assert project_own.supervisor.state is State.DISABLED


class WatchedDevice(FakeDevice):
    """Its watchdog has cut the torque until it is told otherwise."""

    tripped = True

    def reset_watchdog(self) -> None:
        """What a device with a watchdog of its own has."""
        self.tripped = False

    def read(self) -> Reading:
        """See `Device`."""
        return super().read()._replace(flags=FaultCode.WATCHDOG.bit * self.tripped)


def test_a_reset_ends_what_the_boards_watchdog_began() -> None:
    project_own, device = host(), WatchedDevice([REST] * 10)

    def until(sample: Reading) -> bool:
        k = round(1e3 * sample.time)
        if k == 0:  # a flag at the first reading forbids to enable
            assert project_own.supervisor.state is State.DISABLED
            project_own.reset()
        if k == 1:
            assert project_own.supervisor.present == ()
            project_own.enable()
        if k == 3:
            assert project_own.supervisor.state is State.RAMPING
            device.tripped = True
        if k == 4:
            assert project_own.supervisor.latched == (FaultCode.WATCHDOG,)
        return False

    project_own.drive(device, until=until)
    assert not project_own.supervisor.memory[REQUEST]


def test_force_fades_when_nobody_speaks_and_comes_back_when_somebody_does() -> None:
    project_own, device, spoken = host(stale=0.1), simulated(), range(700, 1300)
    seen: list[tuple[FaultCode, ...]] = []

    def until(sample: Reading) -> bool:
        if round(1e3 * sample.time) in spoken:
            project_own.heard()
        seen.append(project_own.supervisor.present)
        return False

    project_own.drive(device, ticks=1301, until=until)
    stale = [k for k, found in enumerate(seen) if FaultCode.COMMAND_STALE in found]
    assert stale == list(range(101, 701))  # 0.1 s after enabling, until the tick after the word


def test_laws_change_without_a_step_and_count_as_a_word() -> None:
    project_own, device = host(stale=0.6), simulated()
    other = law_table(ConstantForce(-FORCE), ConstantForce(0.1 * FORCE))
    forces: list[np.ndarray] = []

    def until(sample: Reading) -> bool:
        k = round(1e3 * sample.time)
        if k in (550, 560):  # again, while it fades
            project_own.change(other, 0.05)
        forces.append(project_own.memory.work[WANTED].copy())
        return False

    project_own.drive(device, ticks=900, until=until)
    np.testing.assert_allclose(forces[-1], -0.9 * FORCE, rtol=1e-12)
    np.testing.assert_array_equal(project_own.laws, other)  # what has faded is dropped
    change = np.abs(np.diff(forces[540:650], axis=0)).max()
    assert change <= 1.1 * np.abs(FORCE).max() * 3.0 / 50.0  # three tables at most, each a fiftieth a tick
    assert change > 0.0
    assert project_own.bits == 0


def test_laws_can_change_at_once_and_to_none() -> None:
    project_own = host()
    assert project_own.laws.shape == (2, COLUMNS)
    project_own.change(law_table(), 0.0)
    project_own(Reading(REST, 0.0))
    assert project_own.laws.shape == (0, COLUMNS)
    half = law_table(ConstantForce(FORCE))
    half[0, GAIN] = 0.5
    project_own.change(half, 0.0)
    project_own(Reading(REST, 1e-3))
    np.testing.assert_array_equal(project_own.laws, half)
    project_own.change(law_table())  # over limits.fade
    project_own(Reading(REST, 2e-3))
    assert project_own.laws[0, GAIN] == pytest.approx(0.5 - LIMITS.period / LIMITS.fade)


def test_what_is_refused_leaves_everything_as_it_was() -> None:
    with pytest.raises(LawError, match="shape"):
        Host(controller(), np.zeros(3))
    with pytest.raises(ValueError, match=r"late is 1\.0.* missed"):
        Host(controller(late=1.0), LAWS)
    project_own = host()
    with pytest.raises(LawError, match=r"law 0 .*nan"):
        project_own.change(np.full(COLUMNS, np.nan))
    for seconds in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=f"{seconds!r} s"):
            project_own.change(LAWS, seconds)
    np.testing.assert_array_equal(project_own.laws, LAWS)
    with pytest.raises(ValueError, match=r"angles .*\(2,\)"):
        project_own(Reading(np.zeros(2), 0.0))


def test_a_device_that_does_not_fit_is_refused_and_closed() -> None:
    project_own = host()
    device = simulated()
    device.period = 2e-3
    with pytest.raises(ValueError, match=r"period .*0\.002 s.* 0\.001 s"):
        project_own.drive(device)
    with pytest.raises(DeviceError):
        device.read()
    with board(limit=0.5) as (process, weak):
        with pytest.raises(ValueError, match=r"0\.5 N m.* 0\.8 N m"):
            project_own.drive(weak)
        assert process.wait(30) == 0  # the board has had its BYE
