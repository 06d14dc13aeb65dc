"""The POSIX ports: a board by itself through its start-up, and a board of the socket protocol with our host at it."""

from __future__ import annotations

import signal
import socket
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.design.record import Loop
from haptics.control.startup.record import Refusal, Step
from haptics.control.supervisor.faults import FaultCode, State
from haptics.control.supervisor.memory import LATCHED
from haptics.devices.device import Reading, run
from haptics.devices.host import Host
from haptics.devices.link import UdpLink
from haptics.devices.protocol import Packet, PacketKind, Reason, decode, encode
from haptics.devices.remote import RemoteDevice
from haptics.devices.simulated import SimulatedDevice
from haptics.firmware.project import STEPS, firmware, write_firmware
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import DAMPED
from haptics.loop.hardware import board_controller, real_plant
from haptics.model.machine import MachineModel
from haptics.rendering.laws.spring import SpringDamper
from tests.haptics.firmware.rig import FLAGS, compile_bare, emulate, tool
from tests.haptics.scene_machine import scene_machine

COMMON = ("simulated/hal_simulated.c", "simulated/device.c", "delta_joints.c", "delta_controller.c")
CHECKED = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
REFUSED, CODE = 3, 4  # Events of delta_run.h


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    """With drives that damp at a wall, as its design says."""
    return scene_machine(best.model_copy(update={"loop": Loop(drive_damping=DAMPED.contact_damping)}))


def written(machine: MachineModel, folder: Path, single: bool) -> Path:
    write_firmware(firmware(machine, 1.0 / DAMPED.period, single=single), folder)
    return folder


@pytest.fixture(scope="module")
def folder(machine: MachineModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(machine, tmp_path_factory.mktemp("ports") / "board", False)


def compiled(folder: Path, name: str, *parts: str, compiler: str = "gcc", flags: tuple[str, ...] = ()) -> Path:
    program = folder / "-".join([name, *flags])
    named = [str(folder / part) for part in (f"posix/{name}.c", *parts, *COMMON)]
    subprocess.run([tool(compiler), *FLAGS, *CHECKED, *flags, *named, "-o", str(program), "-lm"], check=True)
    return program


@pytest.mark.slow
def test_a_bare_cortex_m7_starts_up_by_itself(machine: MachineModel, tmp_path: Path) -> None:
    """The whole device on a bare core: start-up, then a spring; at 2 kHz, of which QEMU makes 9 s in some 20."""
    folder = tmp_path / "board"
    write_firmware(firmware(machine, 2000.0), folder)
    parts = [folder / "cortex-m" / name for name in ("alone.c", "start.c", "semihosting.c")]
    image = compile_bare(folder, "m7", *parts, folder / "delta_run.c", *(folder / name for name in COMMON))
    assert emulate(image) == 0
    reported = np.fromfile(
        folder / "alone.out", np.dtype([("event", "i4"), ("joint", "i4"), ("value", "f8"), ("bound", "f8")])
    )
    assert reported["event"][-1] == 2  # ready
    assert reported["joint"][-2] == Step.READY


@pytest.mark.slow
def test_a_board_by_itself_starts_up_in_single_precision(machine: MachineModel, tmp_path: Path) -> None:
    test_a_board_by_itself_starts_up_and_renders(written(machine, tmp_path / "board", True))


def test_a_board_by_itself_starts_up_and_renders(folder: Path) -> None:
    program = compiled(folder, "alone", "delta_run.c")
    fine = subprocess.run([program, "9"], capture_output=True, text=True, timeout=120)
    steps = [int(line.split()[2]) for line in fine.stdout.splitlines() if line.startswith("event 1 ")]
    assert (fine.returncode, steps[-1], fine.stderr) == (0, Step.READY, "")
    assert fine.stdout.splitlines()[-1].endswith("damped as at a wall")  # into which the spring has pulled it
    for wire, joint, refusal in (
        ("motor", 1, Refusal.NO_MOTION),
        ("encoder", 2, Refusal.ZERO),
    ):  # its zero shows it first
        wrong = subprocess.run([program, "9", wire, str(joint)], capture_output=True, text=True, timeout=120)
        events = [line.split()[1:4] for line in wrong.stdout.splitlines() if line.startswith("event")]
        assert wrong.returncode == 2
        assert wrong.stdout.splitlines()[-1].endswith("without a wall")
        assert events[-1][:2] == [str(CODE), str(int(refusal))]
        assert events[-2][:2] == [str(REFUSED), str(joint)]


@pytest.fixture(scope="module")
def program(folder: Path) -> Path:
    return compiled(folder, "board", "posix/link.c", "delta_board.c", compiler="clang")


@pytest.fixture
def board(program: Path) -> Iterator[tuple[subprocess.Popen[str], int]]:
    started = subprocess.Popen([program], stdout=subprocess.PIPE, text=True)
    assert started.stdout is not None
    try:
        yield started, int(started.stdout.readline().split()[-1])
    finally:
        started.kill()
        started.wait()
        started.stdout.close()


@pytest.mark.parametrize("touched", [False, True])
def test_the_device_at_the_other_end_is_the_simulated_one(machine: MachineModel, program: Path, touched: bool) -> None:
    """Whether or not a wall is touched, by which the drives damp more; without noise, which each draws alone."""

    def wavy(sample: Reading) -> np.ndarray:
        return np.array([0.02, -0.03, 0.06]) * np.cos(100.0 * sample.time)

    process = subprocess.Popen([program, "0", "exact"], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    device = RemoteDevice(UdpLink("127.0.0.1", int(process.stdout.readline().split()[-1])), timeout=5.0)
    assert device.damps_at_walls
    device.touch(touched)
    far = run(device, wavy, ticks=400)
    count = encoder_count(machine)
    twin = SimulatedDevice(real_plant(machine, DAMPED), machine.centre, period=DAMPED.period, count=count, steps=STEPS)
    twin.touch(touched)
    near = run(twin, wavy, ticks=400)
    assert np.ptp(near.angles, axis=0).min() > (20.0 if touched else 30.0) * count
    # a count where another sine's last bit tips the rounding
    np.testing.assert_allclose(far.angles, near.angles, atol=1.01 * count, rtol=0.0)
    assert process.communicate(timeout=30)[0].startswith("1 sessions, 4")
    assert process.returncode == 0


def test_a_paced_board_keeps_its_period(program: Path) -> None:
    started = subprocess.Popen([program, "0", "paced"], stdout=subprocess.PIPE, text=True)
    assert started.stdout is not None
    device = RemoteDevice(UdpLink("127.0.0.1", int(started.stdout.readline().split()[-1])), timeout=5.0)
    begun = time.monotonic()
    last = [device.read().time for _ in range(40)][-1]
    took = time.monotonic() - begun
    device.close()
    assert started.wait(timeout=30) == 0
    started.stdout.close()
    assert 38 * DAMPED.period < last <= 2.0 * took + 0.1  # nobody commands: it ticks all the same, no faster than time


def test_our_host_renders_on_it_and_its_stop_stops(
    machine: MachineModel, board: tuple[subprocess.Popen[str], int]
) -> None:
    process, port = board
    place = machine.centre + np.array([0.004, 0.0, 0.0])
    host = Host(board_controller(machine), SpringDamper(stiffness=300.0, damping=3.0, point=place))
    host.enable()
    seen: list[State] = []

    def until(_: Reading) -> bool:
        seen.append(host.supervisor.state)
        if len(seen) == 6000:
            process.send_signal(signal.SIGUSR1)
        return bool(host.supervisor.memory[LATCHED]) or len(seen) > 20_000

    reported = host.drive(RemoteDevice(UdpLink("127.0.0.1", port), timeout=5.0), until=until)
    assert State.ACTIVE in seen
    assert np.abs(reported.torques).max() > 0.02
    assert int(host.supervisor.memory[LATCHED]) == FaultCode.EMERGENCY_STOP.bit
    assert 6000 <= len(seen) < 20_000


@pytest.mark.parametrize("pace", ["", "paced"])
def test_a_flood_does_not_hold_the_watchdog_up(program: Path, pace: str) -> None:
    """A stranger sends without a pause while the host is silent: the torque is gone all the same."""
    started = subprocess.Popen([program, "0", *([pace] if pace else [])], stdout=subprocess.PIPE, text=True)
    assert started.stdout is not None
    place = ("127.0.0.1", int(started.stdout.readline().split()[-1]))
    host, stranger = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    flooding = threading.Event()

    def flood() -> None:
        while not flooding.is_set():
            stranger.sendto(b"DHAP" * 9, place)

    floods = [threading.Thread(target=flood) for _ in range(2)]
    try:
        host.settimeout(5.0)
        host.sendto(encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (1e-3,))), place)
        welcome = decode(host.recv(2048))
        assert welcome.kind is PacketKind.WELCOME
        host.sendto(encode(Packet(PacketKind.COMMAND, 7, 2, welcome.sequence, 0, (0.1, 0.0, 0.0))), place)
        for one in floods:
            one.start()
        for _ in range(200):
            state = decode(host.recv(2048))
            if state.flags == 1:
                break
        assert state.flags == 1
    finally:
        flooding.set()
        for one in floods:
            if one.ident is not None:
                one.join()
        host.close()
        stranger.close()
        started.kill()
        started.wait()
        started.stdout.close()


def test_what_opens_no_session_does_not_keep_a_board_awake(folder: Path) -> None:
    """A datagram each 20 ms, and half a second without a session in which it is to end."""
    program = compiled(folder, "board", "posix/link.c", "delta_board.c", flags=("-DIDLE_MS=500",))
    started = subprocess.Popen([program], stdout=subprocess.PIPE, text=True)
    assert started.stdout is not None
    place = ("127.0.0.1", int(started.stdout.readline().split()[-1]))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        for _ in range(500):
            stranger.sendto(b"junk", place)
            if started.poll() is not None:
                break
            time.sleep(0.02)
    assert started.poll() == 0
    started.stdout.close()


LATE = """
#include "delta_board.h"
#include "delta_hal.h"
#include "delta_joints.h"
#include <stdio.h>
static double now;
int hal_begin(void) { return 0; }
void hal_wait(void) {}
double hal_now(void) { return now; }
int hal_encoders(double angle[3], int fresh[3])
{
    for (int j = 0; j < 3; j++) { angle[j] = j; fresh[j] = 1; }
    return 0;
}
void hal_damping(int joint, double share) { (void)joint; (void)share; }
void hal_current(int joint, double ampere) { if (joint == 0) printf("%g ", ampere); }
void hal_enable(int on) { (void)on; }
int hal_healthy(void) { return 1; }
int hal_stop_pressed(void) { return 0; }
void hal_watchdog(void) {}
int main(void)
{
    static delta_board board;
    unsigned char state[DELTA_PACKET_MOST];
    now = 1000.0;
    delta_board_begin(&board, 1e-3, 1.0, 4096);
    delta_board_tick(&board, state);
    board.connected = board.answered = 1;
    board.torque[0] = 0.5;
    for (int k = 0; k < 6; k++) {
        now += k == 2 ? 0.1 : 1e-3; /* the third tick takes a hundred periods */
        delta_board_tick(&board, state);
    }
    return 0;
}
"""


def test_a_tick_that_comes_late_counts_for_all_its_time(folder: Path, tmp_path: Path) -> None:
    """The board's watchdog of 20 ms: after a tick of 100 ms without a command the torque is gone in the next."""
    (tmp_path / "late.c").write_text(LATE)
    sources = [str(tmp_path / "late.c"), *(str(folder / name) for name in ("delta_board.c", "delta_joints.c"))]
    command = [tool("gcc"), *FLAGS, f"-I{folder}", *sources, "-o", str(tmp_path / "late"), "-lm"]
    subprocess.run(command, check=True)
    reported = subprocess.run([tmp_path / "late"], capture_output=True, text=True, check=True).stdout.split()
    assert [float(word) > 0.0 for word in reported] == [False, True, True, True, False, False, False]


def test_what_is_wrong_is_dropped_or_refused(board: tuple[subprocess.Popen[str], int]) -> None:
    process, port = board
    first, second = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))

    def ask(one: socket.socket, data: bytes) -> Packet | None:
        one.sendto(data, ("127.0.0.1", port))
        return answer(one)

    def answer(one: socket.socket, seconds: float = 0.1) -> Packet | None:
        one.settimeout(seconds)
        try:
            return decode(one.recv(2048))
        except TimeoutError:
            return None

    def hello(session: int, watchdog: float = 1e-3) -> bytes:
        return encode(Packet(PacketKind.HELLO, session, 1, 0, 0, (watchdog,)))

    with first, second:
        good = hello(7)
        torn, noise = good[:-1], good[:-1] + bytes([good[-1] ^ 1])
        infinite = encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (np.inf,)))
        assert all(ask(first, wrong) is None for wrong in (b"", b"DHAP", torn, noise, infinite, bytes(2000)))
        refused = ask(first, encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (0.01,)), version=2))
        assert refused is not None
        assert (refused.kind, refused.values) == (PacketKind.REFUSED, (Reason.VERSION, 1))
        for watchdog in (0.5, 0.5 * DAMPED.period):
            refused = ask(first, hello(7, watchdog))
            assert refused is not None
            assert refused.values == (Reason.WATCHDOG, 1)
        welcome = ask(first, good)
        assert welcome is not None
        assert welcome.kind is PacketKind.WELCOME
        assert welcome.values[:2] == (DAMPED.period, 1e-3)
        state = answer(first)
        assert state is not None
        assert (state.kind, state.flags) == (PacketKind.STATE, 0)
        second.sendto(hello(9), ("127.0.0.1", port))
        busy = answer(second)
        assert busy is not None
        assert busy.values == (Reason.BUSY, 1)
        second.sendto(encode(Packet(PacketKind.BYE, 7, 2, 0, 0)), ("127.0.0.1", port))  # a stranger's
        for k in range(400):  # nobody answers: a STATE each patience, till the watchdog cuts
            state = answer(first, 2.0)
            assert state is not None, k
            if state.flags:
                break
        assert state.flags == 1
        command = Packet(PacketKind.COMMAND, 7, 5, state.sequence, 0, (9.0, 0.0, 0.0), 1)
        first.sendto(encode(command), ("127.0.0.1", port))
        back = answer(first, 2.0)
        while back is not None and back.answers != 5:
            back = answer(first, 2.0)
        assert back is not None
        assert back.flags == 0
        first.sendto(encode(command._replace(sequence=3)), ("127.0.0.1", port))  # older: dropped
        foreign = command._replace(sequence=8, answers=(state.sequence + 2**29) % 2**32)  # of another session
        first.sendto(encode(foreign), ("127.0.0.1", port))
        first.sendto(encode(Packet(PacketKind.BYE, 7, 6, 0, 0)), ("127.0.0.1", port))
        bye = answer(first, 2.0)
        while bye is not None and bye.kind is not PacketKind.BYE:
            bye = answer(first, 2.0)
        assert bye is not None
    reported = process.communicate(timeout=30)[0]
    sessions, served, _, dropped = (int(part.split()[0]) for part in reported.split(", "))
    assert (sessions, served) == (1, 1)
    assert dropped == 9  # an empty one does not count


def test_the_stop_is_pressed_and_released_as_often_as_one_likes(board: tuple[subprocess.Popen[str], int]) -> None:
    """By signals, before there is a host as well."""
    process, port = board
    for _ in range(2):
        for press in (signal.SIGUSR1, signal.SIGUSR2):
            process.send_signal(press)
            with pytest.raises(subprocess.TimeoutExpired):
                process.wait(0.1)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as host:
        host.settimeout(5.0)
        host.sendto(encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (0.1,))), ("127.0.0.1", port))
        assert decode(host.recv(2048)).kind is PacketKind.WELCOME
        for flag, press in ((2, signal.SIGUSR1), (0, signal.SIGUSR2), (2, signal.SIGUSR1)):
            process.send_signal(press)
            seen = [decode(host.recv(2048)).flags & 2 for _ in range(4)]
            assert seen[-1] == flag


def test_the_figures_of_the_drive_damp_the_joint_as_the_model_does(machine: MachineModel, folder: Path) -> None:
    """What a port makes of them, share k_t^2 / R through the ratio, is what the walls are computed with."""
    lines = [line.split()[1:3] for line in (folder / "delta_device.h").read_text().splitlines() if " DELTA_" in line]
    reported = {name: float(value) for name, value in (line for line in lines if len(line) == 2)}
    short = (reported["DELTA_RATIO"] * reported["DELTA_TORQUE_CONSTANT"]) ** 2 / reported["DELTA_RESISTANCE_OHM"]
    par = real_plant(machine, DAMPED)
    more = reported["DELTA_CONTACT_DAMPING"] - reported["DELTA_DAMPING"]
    assert more * short == pytest.approx(par.contact_damping, rel=1e-12)
    ampere = reported["DELTA_TORQUE_CONSTANT"] * reported["DELTA_RATIO"] * machine.drive.efficiency
    assert reported["DELTA_AMPERE_PER_N_M"] == pytest.approx(1.0 / ampere, rel=1e-12)
