"""The board's side of the protocol as a state machine without sockets and clocks: bytes in, bytes out, tick by tick.

What drives joints is a `Device`: the reference server puts the simulated plant behind it, a real board its motors.
"""

from __future__ import annotations

import secrets
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from haptics.devices.device import Device, Reading
from haptics.devices.protocol import (
    DAMPS_AT_WALLS,
    NOT_FRESH,
    RESET_WATCHDOG,
    STOP_PRESSED,
    VERSION,
    WALL_TOUCHED,
    WATCHDOG_TRIPPED,
    Packet,
    PacketError,
    PacketKind,
    Reason,
    Wrong,
    decode,
    encode,
    following,
    newer,
)

NS_PER_S = 1_000_000_000
_WRAP = 2**32
_FIRST_BITS = 30  # of a session's first number: newer than the 0 of a host that has taken nothing
LONGEST_WATCHDOG = 0.1  # A host may not ask for more, s: at 2 m/s a handle crosses the cube in less than that


class Board:
    """One session at a time; torques are held to its own limit and to its own watchdog.

    Args:
        device: What is driven. It is read once a tick.
        period: Period of the tick, s.
        torque_limit: Torque limit of a joint, N m; what is beyond is clipped.
        counts: Counts in a turn of an encoder, reported to the host.
        watchdog: Time without a good COMMAND after which torque goes to zero, s, until the host asks for another.
        first: Number before the first packet of a session, another in each, so that commands of an old session answer
            nothing of a new one; tests give theirs.

    Attributes:
        counts: How many packets were dropped, and why.
        sessions: How many were opened.
        served: How many COMMANDs were taken.
        peer: Address of the session's host; None without a session.
        answered: Whether the newest STATE has its COMMAND, so that a simulated clock need not wait any longer.
        tripped: Whether the watchdog has cut the torque; RESET_WATCHDOG on a COMMAND, or a new session, ends it.
        stop: Whether the emergency stop is pressed.
        held: Whether it was pressed since the last reset: torque is zero then. RESET_WATCHDOG on a COMMAND, or a new
            session, ends it once the stop is released.
    """

    def __init__(
        self, device: Device, period: float, torque_limit: float, counts: int, watchdog: float = 0.02,
        first: Callable[[], int] = lambda: secrets.randbits(_FIRST_BITS),
    ) -> None:  # fmt: skip
        self._device, self._period, self._limit, self._counts_per_turn = device, period, torque_limit, counts
        self._default_watchdog = self._watchdog = watchdog
        self.peer: Any = None
        self._first = first
        self._session = self._sequence = self._heard = self._issued = 0
        self._silent, self.tripped, self.answered, self._touched = 0.0, False, False, False
        self._torques, self._time = np.zeros(3), 0.0
        self.counts: Counter[str] = Counter()
        self.sessions = self.served = 0
        self.stop = self.held = False

    @property
    def connected(self) -> bool:
        """Whether there is a session."""
        return self.peer is not None

    def received(self, data: bytes, peer: Any) -> bytes | None:
        """Takes a datagram.

        Args:
            data: The datagram.
            peer: Where it came from.

        Returns:
            What to send back there at once, if anything.
        """
        try:
            packet = decode(data)
        except PacketError as error:
            self.counts[error.wrong.name] += 1
            return self._refusal(0, 0, Reason.VERSION) if error.wrong is Wrong.VERSION else None
        if packet.kind is PacketKind.HELLO:
            return self._hello(packet, peer)
        if peer != self.peer or packet.session != self._session:
            self.counts["STRANGER"] += 1
            return None
        if packet.kind is PacketKind.BYE:
            return self.farewell()
        if packet.kind is not PacketKind.COMMAND:
            self.counts["UNEXPECTED"] += 1
        elif not newer(packet.sequence, self._heard):
            self.counts["OLD"] += 1
        elif (self._sequence - packet.answers) % _WRAP >= self._issued:
            self.counts["FOREIGN"] += 1  # answers nothing of this session: one that was recorded in another
        else:
            self._command(packet)
        return None

    def tick(self) -> bytes | None:
        """One period: the watchdog, the torques, the reading. Returns the STATE to send, None without a session."""
        if self.connected:
            self._silent = 0.0 if self.answered else self._silent + self._period
            if self._silent > self._watchdog + 0.5 * self._period and not self.tripped:
                self.tripped = True
                self.counts["TRIPPED"] += 1
        self.held = self.stop or (self.held and self.connected)
        off = self.tripped or self.held or not self.connected
        self._drive(np.zeros(3) if off else self._torques, self._touched and not off)
        sample: Reading = self._device.read()
        self._time = sample.time
        if not self.connected:
            return None
        self.answered = False
        cut = self.tripped or (self.held and not self.stop)
        flags = WATCHDOG_TRIPPED * cut | STOP_PRESSED * self.stop | NOT_FRESH * (~sample.fresh & 7)
        return self._packet(PacketKind.STATE, tuple(float(a) for a in sample.angles), flags)

    def farewell(self) -> bytes | None:
        """Ends the session from this side; returns the BYE to send, None without a session."""
        if not self.connected:
            return None
        bye = self._packet(PacketKind.BYE)
        self.end()
        return bye

    def end(self) -> None:
        """Ends the session and lets all torque go."""
        self.peer, self._torques, self.tripped, self.held, self._touched = None, np.zeros(3), False, False, False
        self._drive(self._torques, touched=False)

    def _drive(self, torques: np.ndarray, touched: bool) -> None:
        if touch := getattr(self._device, "touch", None):
            touch(touched)
        self._device.write(torques)

    def _hello(self, packet: Packet, peer: Any) -> bytes:
        requested = packet.values[0]
        if self.connected and peer != self.peer and not self.tripped:
            self.counts["BUSY"] += 1
            return self._refusal(packet.session, packet.sequence, Reason.BUSY)
        if not self._period <= requested <= LONGEST_WATCHDOG:
            return self._refusal(packet.session, packet.sequence, Reason.WATCHDOG)
        again = self.connected and peer == self.peer and packet.session == self._session
        if not again:  # a HELLO is repeated when its WELCOME was lost; the session goes on then
            self.end()
            if recover := getattr(self._device, "recover", None):  # of a simulated one, which may have left its numbers
                recover()
            self.peer, self._session, self._watchdog = peer, packet.session, requested
            self._sequence, self._issued, self._silent, self.answered = self._first(), 0, 0.0, True
            self.sessions += 1
        self._heard = packet.sequence if not again or newer(packet.sequence, self._heard) else self._heard
        reported = (self._period, self._watchdog, self._limit, self._counts_per_turn)
        return self._packet(PacketKind.WELCOME, reported, DAMPS_AT_WALLS * hasattr(self._device, "touch"))

    def _command(self, packet: Packet) -> None:
        self._heard, self.answered = packet.sequence, True
        self.served += 1
        if packet.answers != self._sequence:
            self.counts["LATE"] += 1
        if packet.flags & RESET_WATCHDOG:
            self.tripped, self.held, self._silent = False, False, 0.0
        self._touched = bool(packet.flags & WALL_TOUCHED)
        self._torques = np.clip(packet.values, -self._limit, self._limit)

    def _packet(self, kind: PacketKind, values: tuple[float, ...] = (), flags: int = 0) -> bytes:
        self._sequence, self._issued = following(self._sequence), min(self._issued + 1, _WRAP // 2)
        time = round(self._time * NS_PER_S)
        return encode(Packet(kind, self._session, self._sequence, self._heard, time, values, flags))

    def _refusal(self, session: int, answers: int, reason: Reason) -> bytes:
        time = round(self._time * NS_PER_S)
        return encode(Packet(PacketKind.REFUSED, session, 1, answers, time, (reason, VERSION)))
