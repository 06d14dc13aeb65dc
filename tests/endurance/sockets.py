"""`python -m tests.endurance.sockets [MINUTES]`: hosts that are killed at random, on a link that slows, tears, repeats.

A paced board with the simulated machine; a host, forked from a process that has compiled everything, drives it through
a relay that drops, delays, reorders and repeats packets, cuts them, flips their bits, sends them again minutes later,
and makes up others: of unknown sessions, of the next number in a wrong session, with a torque that nobody sent. Now
and then the host is killed. What must hold, whatever comes: each torque that reaches the motors is one that the host
has sent in this session, or none, and so is that a wall is touched; it is gone within the watchdog's time of the last
good command; a host that comes after gets force again. Counts are printed, exit code 1 if anything is found.
"""

from __future__ import annotations

import os
import random
import select
import signal
import socket
import subprocess
import sys
import threading
import time
from collections import Counter, deque
from typing import Any

import numpy as np

from haptics.devices.board import Board
from haptics.devices.protocol import WALL_TOUCHED, Packet, PacketKind, decode, encode
from haptics.devices.server import listen, serve
from haptics.devices.simulated import SimulatedDevice
from haptics.model.plant import Hand
from tests.committed import ROOT
from tests.haptics.control.supervisor.rig import HOME, LIMITS, PLANT

PERIOD, WATCHDOG = 2e-3, 0.02  # s
MOST = round(WATCHDOG / PERIOD) + 1  # Ticks of force after a command: its own, and those of the watchdog
LISTENED = 6  # Sockets of the last hosts that the relay reads
SLOWEST = 0.04  # s that a packet may take
WAIT = 5.0  # s in which a host on a clean link must have force, on a busy machine
MADE_UP = 0.4321  # N m; a torque that no host sends
HOST = """
import os, sys
import numpy as np
from haptics.control.controller import Controller
from haptics.control.filters import low_pass
from haptics.control.supervisor.memory import LATCHED
from haptics.devices.device import DeviceError
from haptics.devices.host import Host
from haptics.devices.link import UdpLink
from haptics.devices.remote import RemoteDevice
from haptics.rendering import law_table
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.control.pose import model
from tests.haptics.control.supervisor.rig import DESIGN, GEOMETRY, HOME, LIMITS, MASSES
PERIOD, WATCHDOG = %r, %r
limits = LIMITS._replace(period=PERIOD, late=2.5 * PERIOD, missed=0.2)
spring = SpringDamper(stiffness=150.0, damping=1.0, point=np.array(HOME) + [0.01, 0.0, 0.0])
laws = law_table(spring, axis_wall("+x", HOME[0] + 0.001, stiffness=300.0, damping=1.0))
known = model(GEOMETRY, MASSES, DESIGN.requirements.gravity_m_s2)
controller = Controller(known, low_pass(PERIOD, 100.0), limits, 3.0)
Host(controller, laws)
print("ready", flush=True)
for line in sys.stdin:
    child = os.fork()
    if child == 0:
        def until(_):
            host.heard()
            return host.supervisor.memory[LATCHED] != 0.0
        for _ in range(50):  # as whoever sits there would: a board may be busy, a tick late on a busy machine
            host = Host(controller, laws)
            try:
                device = RemoteDevice(UdpLink("127.0.0.1", int(line)), watchdog=WATCHDOG, timeout=0.2)
                device.rouse()
                host.enable()
                host.drive(device, until=until)
            except DeviceError as error:
                print("left", error, file=sys.stderr, flush=True)
        os._exit(0)
    print(child, flush=True)
    os.waitpid(child, 0)
"""


class Motors(SimulatedDevice):
    """The machine; what is written is held against what a host has sent, and against the time of the last command."""

    def __init__(self, found: list[str]) -> None:
        super().__init__(PLANT, HOME, count=LIMITS.encoder_count, hand=Hand(0.1, 6.0, 400.0), period=PERIOD)
        self.found, self.session = found, 0
        self.sent: dict[int, set[bytes]] = {}  # by session
        self.silent = self.longest = self.forced = self.touches = 0

    def write(self, torques: Any) -> None:
        wanted = np.asarray(torques, dtype=float)
        self.silent += 1
        if wanted.any() or self._touched:
            self.forced += bool(wanted.any())
            self.touches += self._touched
            self.longest = max(self.longest, self.silent)
            if as_sent(wanted, self._touched) not in self.sent.get(self.session, ()):
                wall = "at a wall" if self._touched else "without a wall"
                self.found.append(f"{wanted} N m {wall} reached the motors, and no host of this session has sent it")
            if self.silent > MOST:
                self.found.append(f"force {self.silent} ticks after the last good command")
        super().write(wanted)


def as_sent(torques: Any, touched: int) -> bytes:
    """Of a command, what reaches the motors."""
    return np.asarray(torques, dtype=float).tobytes() + bytes([bool(touched)])


class Watched(Board):
    """A board that says when a command was taken."""

    def __init__(self, motors: Motors) -> None:
        super().__init__(motors, PERIOD, LIMITS.torque, 16384)
        self.motors = motors

    def _command(self, packet: Packet) -> None:
        self.motors.silent, self.motors.session = 0, packet.session
        super()._command(packet)


class Relay(threading.Thread):
    """What lies between hosts and board; `calm` keeps it from meddling."""

    def __init__(self, board: int, motors: Motors, seed: int) -> None:
        super().__init__(daemon=True)
        self.board, self.motors, self.rng = ("127.0.0.1", board), motors, random.Random(seed)
        self.front = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.front.bind(("127.0.0.1", 0))
        self.stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.host: Any = None
        self.backs: list[socket.socket] = []  # the last is that of the host; the others of dead ones
        self.past: deque[bytes] = deque(maxlen=4000)
        self.waiting: list[tuple[float, socket.socket, bytes, Any]] = []
        self.counts: Counter[str] = Counter()
        self.session, self.calm, self.done = 0, False, False
        self.own: list[bytes] = []  # of the host's session
        self.before: list[bytes] = []  # of the one before
        self.ghost: list[bytes] = []  # of a dead host's, to be sent again

    def run(self) -> None:
        while not self.done:
            ready, _, _ = select.select([self.front, *self.backs[-LISTENED:]], [], [], 0.5 * PERIOD)
            for one in ready:
                data, sender = one.recvfrom(2048)
                if one is self.front:
                    self._from_host(data, sender)
                elif one is self.backs[-1]:
                    self._pass(self.front, data, self.host, "state")
            now = time.monotonic()
            due = [late for late in self.waiting if late[0] <= now]
            self.waiting = [late for late in self.waiting if late[0] > now]
            for _, through, data, to in due:
                through.sendto(data, to)
            for data in self.ghost[:8]:
                self.counts["session again"] += 1
                self.backs[-2].sendto(data, self.board)
            del self.ghost[:8]
            if not self.calm and self.backs:
                self._meddle()

    def _from_host(self, data: bytes, sender: Any) -> None:
        if sender != self.host:
            self.host = sender
            self.backs.append(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
        packet = decode(data)
        if packet.session != self.session:
            self.before, self.own, self.ghost = self.own, [], []
            self.session, self.motors.sent[packet.session] = packet.session, set()
        if packet.kind is PacketKind.COMMAND:
            self.motors.sent[packet.session].add(as_sent(packet.values, packet.flags & WALL_TOUCHED))
        self.past.append(data)
        self.own.append(data)
        self._pass(self.backs[-1], data, self.board, "command")

    def _pass(self, through: socket.socket, data: bytes, to: Any, what: str) -> None:
        chance = 1.0 if self.calm else self.rng.random()
        if chance < 0.02:
            self.counts[f"{what} lost"] += 1
            return
        if chance < 0.05:
            self.counts[f"{what} slow"] += 1
            self.waiting.append((time.monotonic() + self.rng.uniform(0.0, SLOWEST), through, data, to))
            return
        through.sendto(data, to)
        if chance < 0.07:
            self.counts[f"{what} twice"] += 1
            through.sendto(data, to)

    def _meddle(self) -> None:
        """Sends now and then what nobody wants."""
        if self.rng.random() > 0.2:
            return
        through = self.rng.choice([*self.backs[-LISTENED:], self.stranger])
        old, kind = self.rng.choice(self.past), self.rng.choice(("torn", "flipped", "again", "made up", "noise"))
        data = old
        if kind == "torn":
            data = (self.rng.choice(self.past) + old)[self.rng.randrange(len(old)) :][: self.rng.randrange(1, 90)]
        elif kind == "flipped":
            at = self.rng.randrange(len(old))
            data = old[:at] + bytes([old[at] ^ (1 << self.rng.randrange(8))]) + old[at + 1 :]
        elif kind == "made up":
            one, mine = decode(old), through is self.backs[-1]
            session = self.rng.getrandbits(32) if mine else self.session
            values = tuple(self.rng.choice((-MADE_UP, 0.0, MADE_UP)) for _ in range(3))
            number, flags = (one.sequence + 100) % 2**32, self.rng.choice((0, WALL_TOUCHED))
            data = encode(Packet(PacketKind.COMMAND, session, number, 0, one.time, values, flags))
        elif kind == "noise":
            data = self.rng.randbytes(self.rng.randrange(200))
        self.counts[kind] += 1
        through.sendto(data, self.board)


def strained(seconds: float, seed: int = 1) -> tuple[list[str], dict[str, Any]]:
    """Lets hosts come and die for a time.

    Args:
        seconds: How long.
        seed: Of all that happens.

    Returns:
        What was found, and what happened.
    """
    rng, found = random.Random(seed), list[str]()
    motors = Motors(found)
    board, done = Watched(motors), threading.Event()
    kills = left = 0
    slowest = 0.0
    forge = subprocess.Popen(
        [sys.executable, "-c", HOST % (PERIOD, WATCHDOG)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL, text=True, cwd=ROOT,
    )  # fmt: skip
    assert forge.stdin is not None
    assert forge.stdout is not None
    forge.stdout.readline()
    with listen() as listening:
        serving = threading.Thread(
            target=lambda: serve(board, listening, patience=PERIOD, paced=True, idle=1e9, stop=done.is_set)
        )
        relay = Relay(listening.getsockname()[1], motors, seed)
        serving.start()
        relay.start()
        end = time.monotonic() + seconds
        while time.monotonic() < end and not found:
            relay.calm = kills % 4 == 3  # one in four sees a clean link, and has to get force there
            before, born = motors.forced, time.monotonic()
            forge.stdin.write(f"{relay.front.getsockname()[1]}\n")
            forge.stdin.flush()
            child = int(forge.stdout.readline())
            while relay.calm and motors.forced < before + 100 and time.monotonic() < born + WAIT:
                time.sleep(PERIOD)
            if relay.calm:
                slowest = max(slowest, time.monotonic() - born)
                if motors.forced < before + 100:
                    found.append(f"host {kills} got no force within {WAIT:g} s of its start on a clean link")
            time.sleep(rng.uniform(0.1, 3.0))
            try:
                os.kill(child, signal.SIGKILL)
                kills += 1
            except ProcessLookupError:
                left += 1  # it had lost its board before
            relay.calm = False
            time.sleep(SLOWEST + 2.0 * WATCHDOG)  # the board has let go, and would take another host
            if relay.before:  # the host before that one: none of its torques may come back
                motors.sent.pop(decode(relay.before[0]).session, None)
                relay.ghost = relay.before[:2000]
            time.sleep(rng.uniform(2.0 * WATCHDOG, 0.5))
            if not serving.is_alive() or not relay.is_alive():
                found.append("the board's server or the relay has ended")
        relay.done = True
        relay.join()
        done.set()
        relay.stranger.sendto(b"", relay.board)  # a board without a session waits for a word
        serving.join()
        for one in (relay.front, relay.stranger, *relay.backs):
            one.close()
    forge.stdin.close()
    forge.stdout.close()
    forge.wait()
    reported = {
        "hosts killed": kills, "left before": left, "sessions": board.sessions, "commands taken": board.served,
        "ticks with force": motors.forced, "ticks at a wall": motors.touches,
        "most ticks of force after a command": motors.longest,
        "slowest to force on a clean link, s": round(slowest, 2), "meddled": dict(relay.counts),
        "dropped": dict(board.counts),
    }  # fmt: skip
    return found, reported


def main(words: list[str]) -> int:
    """Runs it for some minutes, ten if none are given; returns the exit code."""
    found, reported = strained(60.0 * (float(words[0]) if words else 10.0))
    for name, value in reported.items():
        print(f"{name}: {value}")
    for one in found[:10]:
        print(f"FOUND {one}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
