"""Devices and their runner: nothing is left with torque on, whatever goes wrong; recordings come back bit by bit."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import inverse_kinematics
from haptics.calibration.unknowns import nominal
from haptics.control.controller import TOUCHED
from haptics.control.supervisor.faults import FaultCode
from haptics.devices.calibrated import CalibratedDevice
from haptics.devices.device import Device, DeviceError, EndOfRecordingError, Reading, run, three_torques
from haptics.devices.host import Host
from haptics.devices.recorded import RecordedDevice
from haptics.devices.recording import COLUMNS, Recorder, Recording, RecordingError, load_recording, save_recording
from haptics.devices.simulated import SimulatedDevice, simulated_machine
from haptics.loop.choice import at_rate
from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors
from haptics.loop.simulation import simulate, timing
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, STATES, Hand, advance
from haptics.model.sensor import EXACT
from haptics.rendering import law_table
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import axis_wall
from tests.haptics.control.supervisor.rig import GEOMETRY, HOME, LIMITS, PLANT
from tests.haptics.devices.fake import DisturbedDevice, FakeDevice, invalid, jumped, late, signalling, stuck
from tests.haptics.devices.test_remote import Wire, board, remote
from tests.haptics.scene_machine import WITHOUT_NOISE

ANGLES = np.array([[0.1, 0.2, 0.3], [0.11, 0.21, np.nan], [0.12, 0.22, 0.31]])
PULL = np.array([0.01, -0.02, 0.03])


def holding(_sample: Reading) -> np.ndarray:
    return PULL


def simulated(**more: Any) -> SimulatedDevice:
    return SimulatedDevice(PLANT, HOME, **more)


# ---- the runner ----


def test_it_reads_thinks_writes_records_and_leaves_without_torque() -> None:
    device = FakeDevice(ANGLES)
    seen: list[Reading] = []
    recording = run(device, lambda sample: (seen.append(sample), PULL)[1])
    np.testing.assert_array_equal(recording.angles, ANGLES)
    np.testing.assert_array_equal(recording.torques, np.tile(PULL, (3, 1)))
    np.testing.assert_allclose(recording.time, [0.0, 1e-3, 2e-3])
    assert len(seen) == 3
    np.testing.assert_array_equal(device.written, [PULL, PULL, PULL, np.zeros(3)])
    assert device.closed == 1


@pytest.mark.parametrize("ticks", [0, 1, 2])
def test_it_stops_after_so_many_ticks(ticks: int) -> None:
    device = FakeDevice(ANGLES)
    assert len(run(device, holding, ticks=ticks).time) == ticks
    assert len(device.written) == ticks + 1
    assert device.closed == 1


def test_it_stops_when_reported() -> None:
    device = FakeDevice(ANGLES)
    assert len(run(device, holding, until=lambda sample: sample.time > 0.0).time) == 2
    assert device.closed == 1


def fail(error: BaseException) -> Any:
    def tick(sample: Reading) -> np.ndarray:
        if sample.time > 0.0:
            raise error
        return PULL

    return tick


@pytest.mark.parametrize("error", [KeyboardInterrupt(), ZeroDivisionError(), SystemExit(3)], ids=repr)
def test_whatever_the_controller_raises_the_torque_goes(error: BaseException) -> None:
    device, recorder = FakeDevice(ANGLES), Recorder()
    with pytest.raises(type(error)):
        run(device, fail(error), recorder=recorder)
    np.testing.assert_array_equal(device.written, [PULL, np.zeros(3)])
    assert device.closed == 1
    assert len(recorder.recording().time) == 1


@pytest.mark.parametrize("error", [KeyboardInterrupt(), DeviceError("cable out"), OSError("bus")], ids=repr)
def test_whatever_the_device_raises_the_torque_goes(error: BaseException) -> None:
    device = FakeDevice([ANGLES[0], error])
    with pytest.raises(type(error)):
        run(device, holding)
    np.testing.assert_array_equal(device.written, [PULL, np.zeros(3)])
    assert device.closed == 1
    refusing = FakeDevice(ANGLES, refusals={1: error})
    with pytest.raises(type(error)):
        run(refusing, holding)
    np.testing.assert_array_equal(refusing.written, [PULL, np.zeros(3)])
    assert refusing.closed == 1


def test_a_device_that_refuses_zero_torque_is_closed_all_the_same_and_the_first_error_stays() -> None:
    device = FakeDevice(ANGLES, refusals={1: DeviceError("no power")})
    with pytest.raises(ZeroDivisionError) as caught:
        run(device, fail(ZeroDivisionError()))
    assert device.closed == 1
    assert caught.value.__notes__ == ["while leaving the device: no power"]
    at_the_end = FakeDevice(ANGLES, refusals={3: DeviceError("no power")})
    with pytest.raises(DeviceError, match="no power"):
        run(at_the_end, holding)
    assert at_the_end.closed == 1


@pytest.mark.parametrize("wrong", [[np.nan, 0.0, 0.0], [0.0, np.inf, 0.0], [0.0, 0.0], 1.0, [[0.0, 0.0, 0.0]]])
def test_torques_that_are_none_never_reach_a_device(wrong: Any) -> None:
    with pytest.raises(ValueError, match=r"^torques"):
        three_torques(wrong)
    device = FakeDevice(ANGLES)
    with pytest.raises(ValueError, match=r"^torques"):
        run(device, lambda _sample: wrong)
    np.testing.assert_array_equal(device.written, [np.zeros(3)])
    assert device.closed == 1


def test_a_negative_number_of_ticks_is_refused_and_the_device_closed() -> None:
    device = FakeDevice(ANGLES)
    with pytest.raises(ValueError, match="ticks is -1"):
        run(device, holding, ticks=-1)
    assert device.closed == 1


# ---- the simulated device ----


def test_the_simulated_device_is_the_plant() -> None:
    hand = Hand(0.1, 3.0, 200.0)
    device = simulated(hand=hand)
    device.anchor = HOME + np.array([0.005, 0.0, 0.0])
    recording = run(device, holding, ticks=51)
    state, room = np.zeros(STATES), np.zeros((13, STATES))
    state[:3] = HOME
    for k in range(51):
        expected = inverse_kinematics(GEOMETRY, state[:3])
        np.testing.assert_allclose(recording.angles[k], expected, atol=1e-13)  # rounding
        advance(PLANT, hand, device.anchor, np.zeros(3), PULL, 1e-3, 4, state, room)
    np.testing.assert_allclose(recording.time, np.arange(51) * 1e-3, atol=1e-15)
    assert np.abs(recording.angles[-1] - recording.angles[0]).max() > 0.01


def test_its_encoders_have_counts() -> None:
    device, count = simulated(count=LIMITS.encoder_count), LIMITS.encoder_count
    for _ in range(20):
        read = device.read().angles
        np.testing.assert_allclose(read / count, np.round(read / count), atol=1e-9)
        assert np.abs(read - inverse_kinematics(GEOMETRY, device.state[:3])).max() <= 0.5 * count + 1e-13
        device.write(PULL)


def test_the_force_on_the_handle_is_felt() -> None:
    device = simulated(hand=FREE)
    device.force = np.array([0.0, 0.0, 20.0])
    run(device, lambda _sample: np.zeros(3), ticks=10)
    assert device.state[2] > HOME[2] + 1e-3


def test_what_cannot_be_simulated_is_refused() -> None:
    with pytest.raises(ValueError, match=r"\[1\.0, 0\.0, 0\.0\] m"):
        SimulatedDevice(PLANT, [1.0, 0.0, 0.0])
    for wrong in ({"period": 0.0}, {"steps": 0}, {"count": -1.0}, {"period": np.nan}):
        with pytest.raises(ValueError, match=r"^period"):
            simulated(**wrong)


@pytest.mark.parametrize(("rate_Hz", "linked"), [(1000.0, False), (1000.0, True), (8000.0, False)])
def test_the_device_of_run_is_that_of_simulate(machine: MachineModel, rate_Hz: float, linked: bool) -> None:
    """What gives way, ripple, stops and delay: a spring that pulls the handle into a wall, by the other loop's code."""
    loop = at_rate(rate_Hz).linked if linked else at_rate(rate_Hz)
    controller, ticks = board_controller(machine, loop, **WITHOUT_NOISE), round(0.7 * rate_Hz)
    laws = law_table(
        SpringDamper(200.0, 1.0, machine.centre + 0.01), axis_wall("+x", machine.centre[0] + 2e-3, stiffness=500.0)
    )
    device = simulated_machine(machine, loop.period, linked=linked)
    device.count, device._errors = 0.0, EXACT
    host, touched = Host(controller, laws), []
    host.enable()
    near = host.drive(device, ticks=ticks, until=lambda _: touched.append(host.memory.work[TOUCHED]) is not None)
    still = np.zeros((ticks, 3))
    clock = timing(loop.period, loop.delay + reading_age(machine, loop), device.steps)
    reported = simulate(
        real_plant(machine, loop),
        controller,
        laws,
        clock,
        machine.centre,
        hand=FREE,
        anchor=still,
        push=still,
        count=0.0,
    )
    np.testing.assert_allclose(near.torques, reported.torque, atol=1e-9)
    assert np.ptp(reported.position, axis=0).max() > 2e-3
    assert 0 < sum(touched) < ticks


def test_it_reads_with_the_noise_and_the_counts_of_its_encoders(machine: MachineModel) -> None:
    """Its handle held by a hand that is stiff; one reading keeps as much of the last as the chip's filter does."""
    device = simulated_machine(machine, 1.25e-4)
    device.hand, errors = Hand(1.0, 2000.0, 1e6), sensor_errors(machine, at_rate(8000.0))
    read = run(device, lambda _sample: np.zeros(3), ticks=9000).angles[1000:]
    noise = np.diff(read, axis=0)  # what moves slowly is gone
    expected = errors.noise * np.sqrt(2.0 * (1.0 - errors.kept))
    np.testing.assert_allclose(noise.std(axis=0), expected, rtol=0.05)
    assert 0.2 < errors.kept < 0.9


# ---- what all have in common ----


def devices() -> list[Device]:
    recording = Recording(np.arange(3.0), ANGLES, np.zeros((3, 3)))
    return [
        simulated(),
        FakeDevice(ANGLES),
        RecordedDevice(recording),
        DisturbedDevice(FakeDevice(ANGLES), {}),
        CalibratedDevice(FakeDevice(ANGLES), GEOMETRY, nominal(GEOMETRY)),
        remote(Wire(board())),
    ]


@pytest.mark.parametrize("device", devices(), ids=lambda d: type(d).__name__)
def test_the_contract_of_a_device(device: Device) -> None:
    """Its clock does not go back, torques that are none are refused and what was held stays, closed it does nothing."""
    before = device.time
    sample = device.read()
    assert device.time == sample.time >= before
    assert sample.angles.shape == (3,)
    device.write(PULL)
    for wrong in ([np.nan, 0.0, 0.0], [0.0, 0.0]):
        with pytest.raises(ValueError, match=r"^torques"):
            device.write(wrong)
    assert device.read().time > sample.time
    device.close()
    device.close()
    with pytest.raises(DeviceError):
        device.read()
    with pytest.raises(DeviceError):
        device.write(np.zeros(3))


# ---- recordings ----


def recorded() -> Recording:
    rng = np.random.default_rng(3)
    angles = rng.normal(size=(7, 3))
    angles[4, 1] = np.nan
    return Recording(np.cumsum(rng.uniform(1e-3, 2e-3, 7)), angles, rng.normal(size=(7, 3)))


@pytest.mark.parametrize("name", ["log.csv", "log.npz"])
def test_a_recording_comes_back_bit_by_bit(tmp_path: Path, name: str) -> None:
    save_recording(recorded(), tmp_path / name)
    for kept, back in zip(recorded(), load_recording(tmp_path / name), strict=True):
        np.testing.assert_array_equal(kept, back)


@pytest.mark.parametrize("name", ["log.csv", "log.npz"])
def test_an_empty_recording_does_too(tmp_path: Path, name: str) -> None:
    save_recording(Recorder().recording(), tmp_path / name)
    assert len(load_recording(tmp_path / name).time) == 0


def test_a_recording_is_replayed_and_what_is_written_logged(tmp_path: Path) -> None:
    save_recording(recorded(), tmp_path / "first.csv")
    device = RecordedDevice(tmp_path / "first.csv", tmp_path / "second.npz")
    assert device.time == recorded().time[0]
    run(device, lambda sample: 2.0 * np.nan_to_num(sample.angles))
    again = load_recording(tmp_path / "second.npz")
    np.testing.assert_array_equal(again.angles, recorded().angles)
    np.testing.assert_array_equal(again.torques, 2.0 * np.nan_to_num(recorded().angles))


def test_a_replay_takes_one_write_for_each_reading() -> None:
    device = RecordedDevice(recorded())
    with pytest.raises(DeviceError):
        device.write(PULL)
    device.read()
    device.write(PULL)
    with pytest.raises(DeviceError):
        device.write(PULL)
    device.write(np.zeros(3))
    for _ in range(6):
        device.read()
    with pytest.raises(EndOfRecordingError, match="7 ticks"):
        device.read()


def test_an_empty_replay_ends_at_once() -> None:
    device = RecordedDevice(Recorder().recording())
    assert device.time == 0.0
    assert len(run(device, holding).time) == 0


HEAD = ",".join(COLUMNS) + "\n"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ""),
        ("time,angle\n1,2\n", ".*time_s, shoulder_angle_0_rad"),
        (HEAD + "0,1,2,3,4,5\n", ".*time_s, shoulder_angle_0_rad"),
        (HEAD + "0,1,2,3,4,5,x\n", ""),
        (HEAD + "0,1,2,3,4,5,6\n1,2\n", ""),
        (HEAD + "0,1,2,3,4,5,6\n0,1,2,3,4,5,6\n", "time_s "),
        (HEAD + "nan,1,2,3,4,5,6\n", "time_s "),
        (HEAD + "0,1,2,3,4,5,\0\n", "is not a recording"),
        (HEAD + "0,1,2,3,4,5,\x1b[2J" + "x" * 100_000 + "\n", "is not a recording"),
        (HEAD + '0,"' + "1" * 200_000, "is not a recording"),
    ],
)
def test_a_table_that_is_no_recording_is_refused(tmp_path: Path, text: str, says: str) -> None:
    path = tmp_path / "log.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(RecordingError, match=rf"^log\.csv: {says}") as caught:
        load_recording(path)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300


def test_other_files_are_refused(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"^log\.txt: .*\.csv or \.npz"):
        load_recording(tmp_path / "log.txt")
    with pytest.raises(RecordingError, match=r"^log\.txt: .*\.csv or \.npz"):
        save_recording(recorded(), tmp_path / "log.txt")
    with pytest.raises(RecordingError, match=r"^gone\.csv: "):
        load_recording(tmp_path / "gone.csv")
    for content in (b"nonsense", b"PK\x03\x04nonsense", b""):
        (tmp_path / "bad.npz").write_bytes(content)
        with pytest.raises(RecordingError, match=r"^bad\.npz: "):
            load_recording(tmp_path / "bad.npz")
    np.savez(tmp_path / "other.npz", values=np.zeros(3))
    with pytest.raises(RecordingError, match=r"^other\.npz: "):
        load_recording(tmp_path / "other.npz")


def test_a_damaged_npz_file_is_a_recording_or_refused(tmp_path: Path) -> None:
    """Each byte changed in turn, and the file cut off there: readers of zip files raise ten kinds of errors."""
    save_recording(recorded(), tmp_path / "whole.npz")
    whole, path, lines = (tmp_path / "whole.npz").read_bytes(), tmp_path / "bad.npz", []
    for k in range(len(whole)):
        for content in (whole[:k], whole[:k] + bytes([whole[k] ^ 0xFF]) + whole[k + 1 :]):
            path.write_bytes(content)
            try:
                load_recording(path)
            except RecordingError as error:
                lines.append(str(error))
    assert len(lines) > len(whole)
    assert all(line.startswith("bad.npz: ") and line.isprintable() for line in lines)


def test_an_npz_file_that_unpacks_to_too_much_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptics.devices.recording.MOST_BYTES", 100_000)
    long = Recording(np.arange(3000.0), np.zeros((3000, 3)), np.zeros((3000, 3)))
    save_recording(long, tmp_path / "log.npz")
    assert (tmp_path / "log.npz").stat().st_size < 100_000
    with pytest.raises(RecordingError, match=r"^log\.npz: .* more than 0\.1 MB"):
        load_recording(tmp_path / "log.npz")


def test_a_log_appears_whole_or_not_at_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(28, "No space left on device")

    for name in ("log.csv", "log.npz"):
        (tmp_path / name).write_text("before")
        with monkeypatch.context() as patch:
            patch.setattr("delta_cad.common.files.os.pwrite", full)
            with pytest.raises(OSError, match="No space"):
                save_recording(recorded(), tmp_path / name)
        assert (tmp_path / name).read_text() == "before"
    assert len(list(tmp_path.iterdir())) == 2


# ---- disturbances ----


def test_disturbances_come_when_they_are_ordered_to() -> None:
    disturbances = {
        1: invalid(0),
        2: jumped(1, 0.5),
        3: stuck(2, 9.0),
        4: late(0.02),
        5: signalling(FaultCode.WATCHDOG.bit),
    }
    device = DisturbedDevice(FakeDevice([ANGLES[0]] * 7), disturbances)
    samples: list[Reading] = []
    run(device, lambda sample: (samples.append(sample), PULL)[1])
    np.testing.assert_array_equal(samples[0].angles, ANGLES[0])
    assert np.isnan(samples[1].angles[0])
    assert samples[2].angles[1] == ANGLES[0, 1] + 0.5
    assert samples[3].angles[2] == 9.0
    assert samples[4].time == pytest.approx(0.024)
    assert samples[5].flags == FaultCode.WATCHDOG.bit
    np.testing.assert_array_equal(samples[6].angles, ANGLES[0])
    assert samples[6].flags == 0


def test_a_script_may_hold_whole_samples() -> None:
    device = FakeDevice([Reading(ANGLES[0], 5.0, 3)])
    assert device.read().time == 5.0
    with pytest.raises(EndOfRecordingError, match=" 1 readings"):
        device.read()
