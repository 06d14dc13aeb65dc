"""Datagrams on a serial line: framed so that any bytes come through, and what is spoilt is dropped."""

from __future__ import annotations

import os
import pty
import termios
from collections.abc import Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st

from haptics.devices.link import LONGEST, SerialLink

END, ESCAPE = b"\xc0", b"\xdb"  # RFC 1055
ESCAPED_END, ESCAPED_ESCAPE = b"\xdb\xdc", b"\xdb\xdd"


def framed(data: bytes) -> bytes:
    """The frame of RFC 1055, byte by byte."""
    return END + b"".join({END: ESCAPED_END, ESCAPE: ESCAPED_ESCAPE}.get(bytes([b]), bytes([b])) for b in data) + END


class Line:
    """A link whose other end is two pipes."""

    def __init__(self) -> None:
        self.far_in, near_out = os.pipe()
        near_in, self.far_out = os.pipe()
        self.link = SerialLink(near_in, near_out)

    def close(self) -> None:
        self.link.close()
        for one in (self.far_in, self.far_out):
            os.close(one)


@pytest.fixture
def line() -> Iterator[Line]:
    made = Line()
    yield made
    made.close()


@given(st.lists(st.binary(min_size=1, max_size=LONGEST), min_size=1, max_size=5), st.integers(1, 9))
def test_whatever_is_sent_comes_whole_in_pieces_of_any_size(datagrams: list[bytes], piece: int) -> None:
    line = Line()
    try:
        for one in datagrams:
            line.link.send(one)
        sent = os.read(line.far_in, 4096)
        assert sent == b"".join(map(framed, datagrams))
        for at in range(0, len(sent), piece):
            os.write(line.far_out, sent[at : at + piece])
        assert [line.link.receive(1.0) for _ in datagrams] == datagrams
        assert line.link.receive(0.0) is None
    finally:
        line.close()


@pytest.mark.parametrize("spoilt", [b"\x01" * (LONGEST + 1), b"\x01" * 5000, b"ab" + ESCAPE, b""])
def test_what_is_too_long_or_broken_off_is_dropped_and_the_next_comes(line: Line, spoilt: bytes) -> None:
    os.write(line.far_out, END + spoilt + END + framed(b"good"))
    assert line.link.receive(1.0) == b"good"


def test_a_line_that_ends_says_so(line: Line) -> None:
    os.close(line.far_out)
    line.far_out = os.dup(line.far_in)
    with pytest.raises(ConnectionResetError):
        line.link.receive(1.0)


def test_a_terminal_is_opened_raw_at_the_board_s_speed() -> None:
    far, near = pty.openpty()
    try:
        link = SerialLink(os.ttyname(near))
        settings = termios.tcgetattr(near)
        assert settings[4] == settings[5] == termios.B2000000
        assert settings[3] == 0  # no echo, no lines
        link.send(b"\r\n\x03\x11")
        assert os.read(far, 64) == framed(b"\r\n\x03\x11")
        os.write(far, framed(b"\r\n\x00\x7f"))
        assert link.receive(1.0) == b"\r\n\x00\x7f"
        link.close()
    finally:
        os.close(far)
        os.close(near)


def test_a_file_is_no_serial_line(tmp_path) -> None:
    path = tmp_path / "file"
    path.write_text("")
    with pytest.raises(ValueError, match="no serial line"):
        SerialLink(str(path))
