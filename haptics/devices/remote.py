"""A board at the other end of a link: the host's side of the protocol, as a device."""

from __future__ import annotations

import secrets
import time
from collections import Counter
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from haptics.control.supervisor.faults import FaultCode
from haptics.devices.board import NS_PER_S
from haptics.devices.device import DeviceError, DeviceLostError, Reading, three_torques
from haptics.devices.link import SerialLink, UdpLink
from haptics.devices.protocol import (
    DAMPS_AT_WALLS,
    FAULT_OF_FLAG,
    NOT_FRESH,
    RESET_WATCHDOG,
    WALL_TOUCHED,
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

TRIES = 5  # HELLOs and BYEs before it is given up: with one of two packets lost, 5 fail once in thousand


class DeviceRefusedError(DeviceError):
    """The board does not want this host, or speaks another version."""


class RemoteDevice:
    """A board as a device. Opening it says HELLO and waits for the WELCOME.

    Args:
        link: To the board.
        watchdog: Time without a command after which the board cuts the torque, s.
        timeout: Time without a STATE after which the board is lost, s.
        session: Any number of 32 bits that was not used before; drawn if not given.
        clock: Grows by the second; passed in by tests.

    Attributes:
        period: The board's, s.
        watchdog: As the board set it, s.
        torque_limit: The board's own, N m.
        counts_per_turn: Counts in a turn of an encoder.
        damps_at_walls: Whether its drives damp more while a wall is touched, as it says itself.
        counts: Packets dropped, and why; STATEs that never came (LOST) or were overtaken by a newer one (SKIPPED);
            STATEs that know an older command than the newest (UNANSWERED).

    Raises:
        DeviceLostError: Nobody answers.
        DeviceRefusedError: The board refuses.
    """

    def __init__(
        self,
        link: UdpLink | SerialLink,
        *,
        watchdog: float = 0.02,
        timeout: float = 0.1,
        session: int | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._link, self._timeout, self._clock = link, timeout, clock
        self._session = secrets.randbits(32) if session is None else session
        self._sequence = self._heard = self._time_ns = 0
        self._reset, self._touched, self._closed = False, False, False
        self._kept: Reading | None = None  # of `rouse`, for the next reading
        self.counts: Counter[str] = Counter()
        try:
            welcome = self._ask(PacketKind.HELLO, (watchdog,), PacketKind.WELCOME)
            if welcome is None:
                raise DeviceLostError(f"no board answers within {TRIES * timeout:g} s")
        except BaseException:
            link.close()
            raise
        self._heard, self._time_ns = welcome.sequence, welcome.time
        self.period, self.watchdog, self.torque_limit, counts = welcome.values
        self.counts_per_turn, self.damps_at_walls = int(counts), bool(welcome.flags & DAMPS_AT_WALLS)

    @property
    def time(self) -> float:
        """The board's clock at its last STATE, s."""
        return self._time_ns / NS_PER_S

    def reset_watchdog(self) -> None:
        """The next command ends what the board's watchdog began."""
        self._reset = True

    def touch(self, touched: bool) -> None:
        """Says whether a wall is touched: from the next command on the board's drives damp more, or no more."""
        self._touched = touched

    def rouse(self, wait: bool = True) -> bool:
        """Ends what the board's watchdog began while nobody was ready to command, by a command of zero.

        Args:
            wait: For a reading; else only one that is there already counts.

        Returns:
            Whether there was one; the next `read` gives it, or the one after that command.

        Raises:
            DeviceLostError: As `read`.
        """
        for k in range(TRIES):
            newest = self._newest(self._timeout if wait or k > 0 else 0.0)
            if newest is None and k == 0 and not wait:
                return False
            first = self._taken(newest)
            if not first.flags & FaultCode.WATCHDOG.bit:
                self._kept = first
                break
            self._reset = True
            self.write(np.zeros(3))
        return True

    def read(self) -> Reading:
        """Waits for a STATE newer than the last, and takes the newest of those that are there; see `Device`.

        Raises:
            DeviceLostError: None came in time, the board said BYE, or its address is dead.
        """
        self._require_open()
        kept, self._kept = self._kept, None
        return self._taken(self._newest(self._timeout)) if kept is None else kept

    def _newest(self, seconds: float) -> Packet | None:
        """The newest STATE of those that come within a time, or are there then; None if there is none."""
        end, newest = self._clock() + seconds, None
        while True:
            packet = self._next(0.0 if newest is not None else end - self._clock())
            if packet is not None and packet.kind is PacketKind.BYE:
                raise DeviceLostError("the board has ended the session")
            if packet is not None and packet.kind is PacketKind.STATE:
                if newest is not None:
                    self.counts["SKIPPED"] += 1
                self.counts["LOST"] += (packet.sequence - self._heard - 1) % 2**32
                self._heard, newest = packet.sequence, packet
            elif packet is not None:  # a WELCOME that came twice
                self._heard = packet.sequence
            elif newest is not None or self._clock() >= end:
                return newest

    def _taken(self, newest: Packet | None) -> Reading:
        if newest is None:
            raise DeviceLostError(f"the board has sent nothing for {self._timeout:g} s")
        self._time_ns = newest.time
        if newest.answers != self._sequence:
            self.counts["UNANSWERED"] += 1
        flags = sum(fault.bit for flag, fault in FAULT_OF_FLAG.items() if newest.flags & flag)
        return Reading(np.array(newest.values), self.time, flags, ~(newest.flags // NOT_FRESH) & 7)

    def write(self, torques: ArrayLike) -> None:
        """Sends a COMMAND; see `Device`. Whether it came is seen in the next STATE, not here."""
        self._require_open()
        values = tuple(float(v) for v in three_torques(torques))
        self._send(PacketKind.COMMAND, values, RESET_WATCHDOG * self._reset | WALL_TOUCHED * self._touched)
        self._reset = False

    def close(self) -> None:
        """Says BYE until it is answered, a few times at most, and closes the link; see `Device`."""
        if self._closed:
            return
        self._closed = True
        try:
            self._ask(PacketKind.BYE, (), PacketKind.BYE)
        except DeviceError:
            pass  # gone already: its watchdog has cut the torque
        finally:
            self._link.close()

    def _ask(self, kind: PacketKind, values: tuple[float, ...], reply: PacketKind) -> Packet | None:
        """Sends until the reply comes; None after the last try. A REFUSED, or only another version, raises."""
        for _ in range(TRIES):
            self._send(kind, values)
            end = self._clock() + self._timeout
            while True:
                packet = self._next(end - self._clock())
                if packet is not None and packet.kind is reply:
                    return packet
                if packet is not None and packet.kind is PacketKind.REFUSED:
                    raise DeviceRefusedError(_refusal(packet))
                if self.counts[Wrong.VERSION.name]:
                    raise DeviceRefusedError("the board speaks another version of the protocol")
                if self._clock() >= end:
                    break
        return None

    def _next(self, seconds: float) -> Packet | None:
        """The next packet of this session that is not old; None if time is up, or if what came was dropped."""
        try:
            data = self._link.receive(seconds)
        except OSError as error:
            raise DeviceLostError(f"the board is gone: {error.strerror or error}") from None
        if data is None:
            return None
        try:
            packet = decode(data)
        except PacketError as error:
            self.counts[error.wrong.name] += 1
            return None
        if packet.kind is PacketKind.REFUSED and not self._heard:
            return packet
        if packet.session != self._session:
            self.counts["STRANGER"] += 1
            return None
        if not newer(packet.sequence, self._heard):
            self.counts["OLD"] += 1
            return None
        return packet

    def _send(self, kind: PacketKind, values: tuple[float, ...], flags: int = 0) -> None:
        self._sequence = following(self._sequence)
        sent = round(self._clock() * NS_PER_S)
        packet = Packet(kind, self._session, self._sequence, self._heard, sent, values, flags)
        try:
            self._link.send(encode(packet))
        except OSError as error:
            raise DeviceLostError(f"the board is gone: {error.strerror or error}") from None

    def _require_open(self) -> None:
        if self._closed:
            raise DeviceError("the remote device is closed")


def _refusal(packet: Packet) -> str:
    """Message of a REFUSED."""
    reason, version = int(packet.values[0]), int(packet.values[1])
    known = {Reason.VERSION: "another version", Reason.BUSY: "it has a host already", Reason.WATCHDOG: "the watchdog"}
    why = known[Reason(reason)] if reason in list(Reason) else f"reason {reason}"
    return f"the board refuses: {why} (it speaks version {version})"
