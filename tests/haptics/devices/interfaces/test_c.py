"""The C library against the simulated board: compiled strictly, run under sanitizers, held to NumPy's mechanism."""

from __future__ import annotations

import os
import shutil
import subprocess
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.mechanism import forward_kinematics, jacobian
from haptics.devices.protocol import decode, encode
from haptics.devices.simulated import SimulatedDevice
from haptics.gravity import gravity_torque
from haptics.interfaces.sources import FILES, MACHINE, POSE, TIMEOUT_S, machine_header, sources, write_sources
from haptics.loop.choice import BOARD, at_rate
from haptics.loop.walls import WallStability
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from tests.haptics.devices.fake import Disturbance, DisturbedDevice, invalid
from tests.haptics.devices.served import Served, served
from tests.haptics.model.textbook import STEP, textbook
from tests.haptics.scene_machine import placed_machine

HERE = Path(__file__).parent
STRICT = ("-Wall", "-Wextra", "-Wpedantic", "-Wshadow", "-Werror")
CHECKED = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")
LOST, NO_BOARD, REFUSED, UNFIT, NO_ADDRESS, UNKNOWN = 6, 3, 4, 5, 2, 7


def written(machine: MachineModel, folder: Path) -> Path:
    assert write_sources(machine, folder) == sorted([*FILES, MACHINE, POSE])
    header = (folder / MACHINE).read_text()
    assert f"    {TIMEOUT_S}, \\\n" in header
    (folder / MACHINE).write_text(header.replace(f"    {TIMEOUT_S}, \\\n", "    20.0, \\\n"))  # on a busy machine
    return folder


@pytest.fixture(scope="module")
def folder(machine: MachineModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(machine, tmp_path_factory.mktemp("c") / "interfaces")


@pytest.fixture(scope="module")
def client(folder: Path) -> Path:
    return client_of(folder)


def client_of(folder: Path) -> Path:
    out = folder.parent / "client"
    files = [str(HERE / "client.c"), str(folder / "c" / "delta_device.c")]
    compiled(
        "gcc", "-std=c99", "-g", "-O1", "-Wconversion", *CHECKED, f"-I{folder / 'c'}", *files, "-lm", "-o", str(out)
    )
    return out


def compiled(compiler: str, *arguments: str) -> None:
    done = subprocess.run([compiler, *STRICT, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def ran(client: Path, *arguments: object, **environment: str) -> list[str]:
    done = subprocess.run(
        [client, *map(str, arguments)], capture_output=True, text=True, timeout=60, env=os.environ | environment
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout.splitlines()


def ticks(lines: list[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times, states and flags (n, 4), and (n, 3) angles, positions, velocities and torques by their letter."""
    rows = [line.split() for line in lines if line.startswith("tick")]
    found = {
        row[k]: np.array([[float(v) for v in one[k + 1 : k + 4]] for one in rows])
        for row in rows[:1]
        for k in (5, 9, 13, 17)
    }
    return np.array([[float(v) for v in row[1:5]] for row in rows]), found


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_it_compiles_without_a_word(folder: Path, compiler: str) -> None:
    if shutil.which(compiler) is None:
        pytest.fail(f"{compiler} is missing")
    source = str(folder / "c" / "delta_device.c")
    for level in ("-O0", "-O3"):
        compiled(compiler, "-std=c99", level, "-Wconversion", "-c", source, "-o", os.devnull)
    compiled("c++" if compiler == "gcc" else "clang++", "-x", "c++", "-fsyntax-only", "-std=c++17",
             str(folder / "c" / "delta_device.h"))  # fmt: skip
    for flag in ("-ffast-math", "-ffinite-math-only"):  # which drop the checks of angles and forces
        refused = subprocess.run([compiler, flag, "-fsyntax-only", source], capture_output=True, text=True)
        assert "fast-math" in refused.stderr


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
def test_the_program_of_the_readme_compiles_and_drives_a_board(
    machine: MachineModel, folder: Path, tmp_path: Path, compiler: str
) -> None:
    """Until the board ends the session, by which the loop ends."""
    text = (folder / "README.md").read_text().split("```c\n")[1].split("```")[0]
    with served(machine) as up:
        (tmp_path / "program.c").write_text(text.replace("5005", str(up.port)))
        files = [str(tmp_path / "program.c"), str(folder / "c" / "delta_device.c"), "-lm", "-o", str(tmp_path / "it")]
        compiled(compiler, "-std=c99", "-Wconversion", *CHECKED, f"-I{folder / 'c'}", *files)
        up.device.read = farewell(up, 100)  # type: ignore[method-assign]
        assert ran(tmp_path / "it") == ["the board is lost"]
        assert up.board.served > 90
        assert not up.device.torques.any()


def test_position_velocity_and_torques_are_those_of_the_mechanism(machine: MachineModel, client: Path) -> None:
    with served(machine) as up:
        lines = ran(client, up.port, 600, 0.0)
        assert not up.device.torques.any()
    head, found = ticks(lines)
    assert lines[0] == "open 0 done"
    assert (len(head), set(head[:, 1]), set(head[:, 2]), set(head[:, 3])) == (600, {0.0}, {0.0}, {0.0})
    g, a, p = machine.geometry, found["a"], found["p"]
    np.testing.assert_allclose(p, forward_kinematics(g, a), atol=1e-14)
    force = 300.0 * (np.array([0.004, -0.003, machine.centre[2] + 0.002]) - p)
    holding = gravity_torque(g, machine.masses, p, machine.design.requirements.gravity_m_s2)
    meant = np.einsum("nki,nk->ni", jacobian(g, p), force) + holding
    np.testing.assert_allclose(found["t"], meant, atol=1e-12)
    assert np.ptp(p, axis=0).max() > 1e-3  # the spring pulls it over there
    # the low-pass on the joints' differences, by a recursion of its own
    share, rates = 1.0 - np.exp(-2 * np.pi * BOARD.corner * 1e-3), np.zeros(3)
    for n in range(1, len(a)):
        rates = rates + share * ((a[n] - a[n - 1]) / 1e-3 - rates)
        np.testing.assert_allclose(found["v"][n], jacobian(g, p[n]) @ rates, atol=1e-9)


def test_it_knows_where_the_chains_stand(placed: MachineModel, tmp_path: Path) -> None:
    """Positions and holding torques of a machine that is not three-fold symmetric, by vectors of a textbook."""
    machine, book, masses = placed, textbook(placed.design), placed.masses
    folder = written(machine, tmp_path / "interfaces")
    assert f"#define DELTA_CENTRE_X {float(machine.centre[0])!r} " in (folder / MACHINE).read_text()
    with served(machine) as up:
        lines = ran(client_of(folder), up.port, 200, 0.0)
    _, found = ticks(lines)
    gravity = np.array(machine.design.requirements.gravity_m_s2)
    for angles, p, torques in zip(found["a"][::20], found["p"][::20], found["t"][::20], strict=True):
        np.testing.assert_allclose(p, book.position(angles, machine.centre), atol=1e-12)
        force = 300.0 * (np.array([0.004, -0.003, machine.centre[2] + 0.002]) - p)
        moved = [(book.position(angles + e, p), book.position(angles - e, p)) for e in STEP * np.eye(3)]
        held = [book.potential(masses, a, gravity) - book.potential(masses, b, gravity) for a, b in moved]
        meant = np.array(held) + [force @ (a - b) for a, b in moved]
        np.testing.assert_allclose(torques, meant / (2.0 * STEP), atol=1e-7)


def test_force_comes_in_over_the_ramp_and_is_bounded(machine: MachineModel, client: Path) -> None:
    with served(machine) as up:
        lines = ran(client, up.port, 100, 0.5)
    _, found = ticks(lines)
    holding = gravity_torque(machine.geometry, machine.masses, found["p"], machine.design.requirements.gravity_m_s2)
    adjacent = np.linalg.norm(found["t"] - holding, axis=1)
    assert adjacent[0] < 1e-3 * adjacent[-1] * 10
    np.testing.assert_allclose(adjacent[40] / adjacent[80], 0.5, rtol=0.15)
    assert "null 1 1 8" in lines
    assert "nan 1 period 0.001" in lines


@pytest.mark.parametrize("fault", [invalid(0), lambda sample: sample._replace(fresh=5)], ids=["invalid", "not fresh"])
def test_an_encoder_that_fails_takes_the_force_until_the_reset(
    machine: MachineModel, client: Path, fault: Disturbance
) -> None:
    with served(machine) as up:
        bad = dict.fromkeys(range(40, 60), fault)
        up.device.read = DisturbedDevice(Bare(up.device), bad).read  # type: ignore[method-assign]
        lines = ran(client, up.port, 200, 0.0, RESET_AT="120")
    head, found = ticks(lines)
    bad = np.flatnonzero(head[:, 1] == UNKNOWN)
    assert 15 <= len(bad) <= 20
    quiet = slice(bad[0], 120)
    assert not found["t"][quiet].any()
    assert set(head[bad[-1] + 1 : 120, 2]) == {8.0}  # latched
    assert np.abs(found["t"][121:]).max() > 0.01
    assert set(head[121:, 2]) == {0.0}


def test_what_cannot_be_opened_says_why(machine: MachineModel, client: Path) -> None:
    def status(*arguments: object) -> int:
        return int(ran(client, *arguments)[0].split()[1])

    with served(machine) as up:
        port = up.port
        assert status(port, 0, 0.5, "localhost") == NO_ADDRESS
        assert status(port, 0, 0.5, "192.0.2.1") == NO_ADDRESS
        assert status(port, 0, -1.0) == 1
        with occupied(up):
            assert status(port, 0) == REFUSED
        assert status(port, 3) == 0
    assert status(port, 0) == NO_BOARD
    with served(machine, torque=0.1) as up:
        assert status(up.port, 0) == UNFIT
        assert not up.board.connected


class Bare:
    """A device's own methods, kept while others take their place."""

    def __init__(self, device: SimulatedDevice) -> None:
        self.read, self.write, self.close, self.time = device.read, device.write, device.close, 0.0


class occupied:  # noqa: N801
    """Another host has the board."""

    def __init__(self, up: Served) -> None:
        from haptics.devices.link import UdpLink
        from haptics.devices.remote import RemoteDevice

        self._device = RemoteDevice(UdpLink("127.0.0.1", up.port), timeout=2.0)

    def __enter__(self) -> None:
        """It is there already."""

    def __exit__(self, *_: object) -> None:
        self._device.close()


def test_a_board_that_goes_away_is_lost(machine: MachineModel, client: Path) -> None:
    with served(machine) as up:
        up.device.read = counted(up.device.read, 50, up)  # type: ignore[method-assign]
        lines = ran(client, up.port, 1000, 0.0, TIMEOUT="1.0")
    head, _ = ticks(lines)
    assert head[-1, 3] == LOST
    assert 40 < len(head) < 60


def farewell(up: Served, most: int):
    """A reading of the device, at which its board says BYE after some."""
    read, count = up.device.read, 0

    def one():
        nonlocal count
        count += 1
        if count == most:
            peer = up.board.peer
            up.listening.sendto(up.board.farewell() or b"", peer)
        return read()

    return one


def counted(read, most: int, up: Served):
    """A reading that ends the session after some."""
    count = 0

    def one():
        nonlocal count
        count += 1
        if count == most:
            up.board.end()
        return read()

    return one


def test_signals_to_the_program_lose_no_board(machine: MachineModel, client: Path) -> None:
    with served(machine) as up:
        read = up.device.read

        def slow():
            until = time.monotonic() + 1e-3  # longer than between two signals: each wait for a reading is interrupted
            while time.monotonic() < until:
                pass
            return read()

        up.device.read = slow  # type: ignore[method-assign]
        head, _ = ticks(ran(client, up.port, 200, 0.0, ALARM="1"))
    assert (len(head), set(head[:, 2]), set(head[:, 3])) == (200, {0.0}, {0.0})


def test_a_program_may_take_its_time_before_its_first_force(machine: MachineModel, client: Path) -> None:
    """The watchdog trips while nobody commands; the first command ends that, and a reading from before says nothing."""
    with served(machine) as up:
        tick, count = up.board.tick, 0

        def waited():
            nonlocal count
            count += 1
            if count == 1:
                for _ in range(40):
                    state = tick()
                assert up.board.tripped
                return state
            if count == 2:  # one that left before the command came
                late = decode(tick() or b"")._replace(flags=1, answers=1)
                up.listening.sendto(encode(late), up.board.peer)
            return tick()

        up.board.tick = waited  # type: ignore[method-assign]
        head, found = ticks(ran(client, up.port, 100, 0.0))
    assert head[0, 2] == 1.0  # told of it, but not latched
    assert set(head[1:, 2]) == {0.0}
    assert np.abs(found["t"][1:]).max(axis=1).min() > 0.01


def test_the_chai3d_device_opens_a_lost_board_again(placed: MachineModel, chai: Path) -> None:
    with served(placed) as up:
        up.device.read = farewell(up, 50)  # type: ignore[method-assign]
        (line,) = ran(chai, up.port)
        assert up.board.sessions == 2
    assert line.split()[1:3] == ["1", "1"]


@pytest.fixture(scope="module")
def placed() -> MachineModel:
    """A machine whose cube does not stand over the base's middle."""
    return placed_machine("study")


@pytest.fixture(scope="module")
def chai(placed: MachineModel, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = written(placed, tmp_path_factory.mktemp("chai") / "interfaces")
    out, c = folder.parent / "chai", folder / "c" / "delta_device.c"
    include = [f"-I{path}" for path in (folder / "c", folder / "chai3d", HERE / "stubs")]
    library = folder.parent / "delta_device.o"
    compiled("gcc", "-std=c99", "-g", *CHECKED, "-c", str(c), "-o", str(library))
    sources_of = [str(HERE / "chai.cpp"), str(folder / "chai3d" / "CDeltaHapticDevice.cpp")]
    compiled("c++", "-std=c++14", "-g", *CHECKED, *include, *sources_of, str(library), "-o", str(out))
    return out


def test_the_chai3d_device_compiles_and_drives_a_board(placed: MachineModel, chai: Path) -> None:
    with served(placed) as up:
        (line,) = ran(chai, up.port)
        at = up.device.state[:3] - placed.centre
    before, opened, kept, switches, *p, force = (float(v) for v in line.split())
    assert (before, opened, kept, switches, force) == (0, 1, 1, 0, placed.design.requirements.force_N)
    np.testing.assert_allclose(p, at, atol=1e-4)


@pytest.fixture(scope="module")
def node(folder: Path) -> Path:
    out, library = folder.parent / "node", folder.parent / "ros_device.o"
    compiled("gcc", "-std=c99", "-c", str(folder / "c" / "delta_device.c"), "-o", str(library))
    include = [f"-I{path}" for path in (folder / "c", HERE / "stubs")]
    source = str(folder / "ros2" / "delta_haptic_node.cpp")
    compiled("c++", "-std=c++17", "-g", *include, source, str(library), "-pthread", "-o", str(out))
    return out


def test_the_ros_node_compiles_and_drives_a_board(machine: MachineModel, node: Path) -> None:
    with served(machine) as up:
        done = subprocess.run(
            [node], env=os.environ | {"DELTA_port": str(up.port)}, timeout=60, capture_output=True, text=True
        )
        assert (done.returncode, done.stderr, done.stdout) == (0, "", "service 1\n")
        assert up.board.served > 20
        assert not up.board.connected
    done = subprocess.run([node], env=os.environ | {"DELTA_port": "70000"}, timeout=60, capture_output=True, text=True)
    assert done.returncode == 1
    assert "port" in done.stderr


def test_the_ros_nodes_service_lets_force_in_again(machine: MachineModel, node: Path) -> None:
    """An emergency stop early on latches; the service, called 0.15 s later, ends that."""
    with served(machine) as up:
        held, read = [], up.device.read

        def pressed():
            held.append(bool(up.device.torques.any()))
            up.board.stop = 20 <= len(held) < 30
            return read()

        up.device.read = pressed  # type: ignore[method-assign]
        environment = os.environ | {"DELTA_port": str(up.port)}
        done = subprocess.run([node], env=environment, timeout=60, capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (0, "service 1\n")
    assert any(held[:20])
    off = held.index(False, 20)
    again = held.index(True, off)
    assert off < 25
    assert again > 60  # not by itself
    assert any(held[again:])


def test_the_ros_nodes_force_is_switched_off_at_once_and_on_over_the_ramp(machine: MachineModel, node: Path) -> None:
    """Torques beyond those that hold the weight, of a force of 0.5 N along z; joint names carry the prefix."""
    with served(machine) as up:
        beyond, read = [], up.device.read
        gravity = machine.design.requirements.gravity_m_s2

        def watched():
            weight = gravity_torque(machine.geometry, machine.masses, up.device.state[:3], gravity)
            beyond.append(float((up.device.torques - weight).max()) if up.device.torques.any() else 0.0)
            return read()

        up.device.read = watched  # type: ignore[method-assign]
        switches = {"DELTA_port": str(up.port), "DELTA_switched": "1", "DELTA_prefix": "left_", "DELTA_stale": "9"}
        done = subprocess.run([node], env=os.environ | switches, timeout=60, capture_output=True, text=True)
    assert done.stdout.splitlines() == ["service 1", "service 1", "left_shoulder_0 left_shoulder_1 left_shoulder_2 "]
    on = np.array(beyond) > 2e-5  # N m; what the weight's torque changes by within a tick is less
    first = int(on.argmax())
    off = first + int((~on[first:]).argmax())
    again = off + int(on[off:].argmax())
    assert off - first > 3
    assert again - off > 0.2 * off  # as long as before, where the machine is idle
    assert beyond[off - 1] == max(beyond[:off])  # not over a ramp
    assert beyond[again] < 0.5 * beyond[off - 1]  # over a ramp: the opening's own has come further by now


def test_the_ros_node_ends_when_its_board_is_lost(machine: MachineModel, node: Path) -> None:
    with served(machine) as up:
        environment = os.environ | {"DELTA_port": str(up.port), "DELTA_stays": "1"}
        process = subprocess.Popen(
            [node], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
        )
        until = time.monotonic() + 60.0
        while up.board.served < 20 and time.monotonic() < until:
            process.poll()
    assert "lost" in process.communicate(timeout=60)[1]  # the server has said BYE
    assert process.returncode == 1


def test_a_hosts_wall_stands_without_the_damping_that_it_tells_no_drive_of(machine: MachineModel) -> None:
    """By the eigenvalues of a loop of 1 kHz that is a period late, its drives as they damp where no wall is touched."""
    line = next(line for line in machine_header(machine).splitlines() if "DELTA_STIFFNESS" in line)
    loop = replace(at_rate(1000.0), contact_damping=BOARD.drive_damping)
    walls = [
        WallStability(machine, loop, machine.centre, axis, place=0, delay=1.0e-3).stable(FREE) for axis in np.eye(3)
    ]
    assert 50.0 < float(line.split()[2]) < 0.7 * min(walls)


def test_the_machines_numbers_are_read_back_to_the_last_bit(machine: MachineModel) -> None:
    header = sources(machine)[MACHINE]
    assert repr(machine.geometry.forearm_length) in header
    assert repr(machine.masses.at_wrists) in header
