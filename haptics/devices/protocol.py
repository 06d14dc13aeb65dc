"""The packets between host and board, version 1; `PROTOCOL.md` in this folder explains them."""

from __future__ import annotations

import math
import struct
import zlib
from enum import IntEnum
from typing import NamedTuple

from haptics.control.supervisor.faults import FaultCode

VERSION = 1
MAGIC = b"DHAP"
_HEADER = struct.Struct("<4sBBHIIIQ")  # magic, version, kind, flags, session, sequence, answers, time in ns
_CHECK = struct.Struct("<I")
SHORTEST = _HEADER.size + _CHECK.size
_WRAP = 2**32


class PacketKind(IntEnum):
    """Kind of a packet."""

    HELLO = 1
    WELCOME = 2
    STATE = 3
    COMMAND = 4
    BYE = 5
    REFUSED = 6


class Reason(IntEnum):
    """Why a HELLO is refused."""

    VERSION = 1
    BUSY = 2
    WATCHDOG = 3


class Wrong(IntEnum):
    """What is wrong with bytes that are no packet."""

    SHORT = 1
    MAGIC = 2
    CHECK = 3
    VERSION = 4
    KIND = 5
    LENGTH = 6
    VALUE = 7


PAYLOAD: dict[PacketKind, struct.Struct] = {
    PacketKind.HELLO: struct.Struct("<d"),  # watchdog that the host asks for, s
    PacketKind.WELCOME: struct.Struct("<dddI"),  # period s, watchdog s, torque limit N m, counts per turn
    PacketKind.STATE: struct.Struct("<ddd"),  # shoulder angles, rad; NaN for an encoder that knows of its fault
    PacketKind.COMMAND: struct.Struct("<ddd"),  # torques, N m
    PacketKind.BYE: struct.Struct("<"),
    PacketKind.REFUSED: struct.Struct("<HH"),  # reason, version that is spoken
}

WATCHDOG_TRIPPED, STOP_PRESSED = 1, 2  # Flags of a STATE
NOT_FRESH = 4  # Flag of a STATE for joint 0; twice and four times it for joints 1 and 2
RESET_WATCHDOG, WALL_TOUCHED = 1, 2  # Flags of a COMMAND
DAMPS_AT_WALLS = 1  # Flag of a WELCOME; a board that does not say so is taken to ignore WALL_TOUCHED
FAULT_OF_FLAG = {WATCHDOG_TRIPPED: FaultCode.WATCHDOG, STOP_PRESSED: FaultCode.EMERGENCY_STOP}


class PacketError(ValueError):
    """Bytes that are no packet of this version.

    Attributes:
        wrong: What is wrong.
    """

    def __init__(self, wrong: Wrong, text: str) -> None:
        super().__init__(text)
        self.wrong = wrong


class Packet(NamedTuple):
    """One datagram.

    Attributes:
        kind: What it is.
        session: Number of the session, chosen by the host at HELLO.
        sequence: Number in the sender's sequence, one more for each packet, modulo 2^32.
        answers: Sequence of the other side's newest packet; 0 for none.
        time: Time by the sender's clock, ns.
        values: As `PAYLOAD` says.
        flags: Bits of a WELCOME, a STATE or a COMMAND.
    """

    kind: PacketKind
    session: int
    sequence: int
    answers: int
    time: int
    values: tuple[float, ...] = ()
    flags: int = 0


def encode(packet: Packet, version: int = VERSION) -> bytes:
    """A packet as it goes over the wire.

    Args:
        packet: The packet.
        version: Another one only to test the other side.
    """
    header = _HEADER.pack(
        MAGIC, version, packet.kind, packet.flags, packet.session, packet.sequence, packet.answers, packet.time
    )
    body = header + PAYLOAD[packet.kind].pack(*packet.values)
    return body + _CHECK.pack(zlib.crc32(body))


def decode(data: bytes) -> Packet:
    """Bytes from the wire as a packet.

    Magic, version and check are in the same places in every version, so that another version is not taken for noise.

    Raises:
        PacketError: They are none; `wrong` says why. Angles may be NaN, all other numbers must be finite.
    """
    if len(data) < SHORTEST:
        raise PacketError(Wrong.SHORT, f"{len(data)} bytes; a packet has at least {SHORTEST}")
    magic, version, kind, flags, session, sequence, answers, time = _HEADER.unpack_from(data)
    if magic != MAGIC:
        raise PacketError(Wrong.MAGIC, f"begins with {magic!r}; a packet begins with {MAGIC!r}")
    if _CHECK.unpack_from(data, len(data) - _CHECK.size)[0] != zlib.crc32(data[: -_CHECK.size]):
        raise PacketError(Wrong.CHECK, "its check sum is wrong")
    if version != VERSION:
        raise PacketError(Wrong.VERSION, f"version {version}; this is version {VERSION}")
    if kind not in PAYLOAD:
        raise PacketError(Wrong.KIND, f"kind {kind} is unknown")
    payload = PAYLOAD[PacketKind(kind)]
    if len(data) != SHORTEST + payload.size:
        raise PacketError(Wrong.LENGTH, f"{len(data)} bytes; a {PacketKind(kind).name} has {SHORTEST + payload.size}")
    values = payload.unpack_from(data, _HEADER.size)
    for value in values:
        if not math.isfinite(value) and not (kind == PacketKind.STATE and math.isnan(value)):
            raise PacketError(Wrong.VALUE, f"a {PacketKind(kind).name} holds {value}")
    return Packet(PacketKind(kind), session, sequence, answers, time, values, flags)


def newer(sequence: int, than: int) -> bool:
    """Whether a sequence number is newer, across the wrap at 2^32 (within half of it)."""
    return 0 < (sequence - than) % _WRAP < _WRAP // 2


def following(sequence: int) -> int:
    """The next sequence number; never 0, which means none."""
    return (sequence + 1) % _WRAP or 1
