"""Packets: bytes as the page says, written out by hand; whatever is not one is refused, and why."""

import struct
import zlib

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptics.devices.protocol import (
    PAYLOAD,
    SHORTEST,
    Packet,
    PacketError,
    PacketKind,
    Wrong,
    decode,
    encode,
    following,
    newer,
)

STATE = Packet(PacketKind.STATE, 0x01020304, 7, 6, 5_000_000, (0.5, -0.25, 2.0), 2)
WORDS = st.integers(0, 2**32 - 1)


def crc32(data: bytes) -> int:
    """Bit by bit, as the page says; not zlib's."""
    value = 0xFFFFFFFF
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xEDB88320 if value & 1 else 0)
    return value ^ 0xFFFFFFFF


def signed(body: bytes) -> bytes:
    return body + struct.pack("<I", zlib.crc32(body))


def test_the_bytes_of_a_state_written_out() -> None:
    by_hand = bytes.fromhex(
        "44484150" "01" "03" "0200" "04030201" "07000000" "06000000" "404b4c0000000000"
        "000000000000e03f" "000000000000d0bf" "0000000000000040"
    )  # fmt: skip
    assert encode(STATE) == by_hand + struct.pack("<I", crc32(by_hand))
    assert len(encode(STATE)) == 56
    assert decode(encode(STATE)) == STATE


def test_the_lengths_are_those_of_the_page() -> None:
    sizes = {kind.name: SHORTEST + payload.size for kind, payload in PAYLOAD.items()}
    assert sizes == {"HELLO": 40, "WELCOME": 60, "STATE": 56, "COMMAND": 56, "BYE": 32, "REFUSED": 36}


@given(
    st.sampled_from([PacketKind.STATE, PacketKind.COMMAND]), WORDS, WORDS, WORDS, st.integers(0, 2**64 - 1),
    st.tuples(*[st.floats(allow_nan=False, allow_infinity=False)] * 3), st.integers(0, 2**16 - 1),
)  # fmt: skip
@settings(deadline=None)
def test_every_packet_comes_back(
    kind: PacketKind, session: int, sequence: int, answers: int, time: int, values: tuple[float, ...], flags: int
) -> None:
    packet = Packet(kind, session, sequence, answers, time, values, flags)
    assert decode(encode(packet)) == packet


def test_an_angle_may_be_no_number_and_a_torque_may_not() -> None:
    assert np.isnan(decode(encode(STATE._replace(values=(0.0, np.nan, 0.0)))).values[1])
    for values in ((np.nan, 0.0, 0.0), (0.0, np.inf, 0.0)):
        with pytest.raises(PacketError, match="COMMAND"):
            decode(encode(STATE._replace(kind=PacketKind.COMMAND, values=values)))
    with pytest.raises(PacketError, match=r"STATE.* inf"):
        decode(encode(STATE._replace(values=(np.inf, 0.0, 0.0))))


good = encode(STATE)


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        (b"", Wrong.SHORT),
        (good[:31], Wrong.SHORT),
        (b"XHAP" + good[4:], Wrong.MAGIC),
        (good[:-1], Wrong.CHECK),
        (good + b"\0", Wrong.CHECK),
        (encode(STATE, version=2), Wrong.VERSION),
        (signed(good[:5] + b"\x09" + good[6:-4]), Wrong.KIND),
        (signed(good[:5] + b"\x00" + good[6:-4]), Wrong.KIND),
        (signed(good[:-4] + b"\0" * 8), Wrong.LENGTH),
        (signed(good[:-12]), Wrong.LENGTH),
        (encode(STATE._replace(values=(np.inf, 0.0, 0.0))), Wrong.VALUE),
    ],
)
def test_what_is_no_packet_is_refused(data: bytes, wrong: Wrong) -> None:
    with pytest.raises(PacketError) as caught:
        decode(data)
    assert caught.value.wrong is wrong


def test_every_single_flipped_bit_is_found() -> None:
    for bit in range(8 * len(good)):
        flipped = bytearray(good)
        flipped[bit // 8] ^= 1 << bit % 8
        with pytest.raises(PacketError):
            decode(bytes(flipped))


@given(st.binary(max_size=80))
@settings(deadline=None, max_examples=300)
def test_noise_is_refused_and_nothing_else_happens(data: bytes) -> None:
    with pytest.raises(PacketError):
        decode(data)


@given(WORDS, st.integers(1, 2**31 - 1))
def test_newer_across_the_wrap(sequence: int, ahead: int) -> None:
    assert newer((sequence + ahead) % 2**32, sequence)
    assert not newer(sequence, (sequence + ahead) % 2**32)
    assert not newer(sequence, sequence)


def test_a_sequence_is_never_zero() -> None:
    assert following(2**32 - 1) == 1
    assert following(1) == 2
    assert newer(1, 2**32 - 1)
