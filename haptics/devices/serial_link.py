"""Datagrams between two ends by a serial line, framed by SLIP (RFC 1055): a board behind its USB socket."""

from __future__ import annotations

import os
import select
import time

END, ESCAPE, ESCAPED_END, ESCAPED_ESCAPE = 0xC0, 0xDB, 0xDC, 0xDD
CHUNK = 4096  # Bytes that are read at once
LONGEST = 64  # Of a datagram, bytes; ours have at most 60


class SerialLink:
    """A serial line, or any two descriptors, to one board.

    Args:
        reading: Path of a terminal device, such as /dev/ttyACM0; or a descriptor that is read.
        writing: A descriptor that is written, where `reading` is one.

    Raises:
        OSError: The device cannot be opened.
        ValueError: It is no terminal.
    """

    def __init__(self, reading: str | int, writing: int | None = None) -> None:
        self._in = _opened(reading) if isinstance(reading, str) else reading
        self._out = self._in if writing is None else writing
        self._frame, self._escaped = bytearray(), False
        self._coming: list[bytes] = []

    def send(self, data: bytes) -> None:
        """Sends a datagram. Raises OSError if the line is gone."""
        plain = data.replace(bytes([ESCAPE]), bytes([ESCAPE, ESCAPED_ESCAPE]))
        os.write(self._out, bytes([END, *plain.replace(bytes([END]), bytes([ESCAPE, ESCAPED_END])), END]))

    def receive(self, seconds: float) -> bytes | None:
        """The next datagram, or None if none came in that time. Raises OSError if the line is gone."""
        until = time.monotonic() + max(seconds, 0.0)
        while not self._coming:
            left = until - time.monotonic()
            if not select.select([self._in], [], [], max(left, 0.0))[0]:
                return None
            data = os.read(self._in, CHUNK)
            if not data:
                raise ConnectionResetError("the serial line has ended")
            self._take(data)
        return self._coming.pop(0)

    def _take(self, data: bytes) -> None:
        for byte in data:
            if byte == END:
                if 0 < len(self._frame) <= LONGEST and not self._escaped:
                    self._coming.append(bytes(self._frame))
                self._frame, self._escaped = bytearray(), False
            elif byte == ESCAPE:
                self._escaped = True
            elif len(self._frame) <= LONGEST:  # one more than a datagram has: it is dropped at its end
                meant = {ESCAPED_END: END, ESCAPED_ESCAPE: ESCAPE}.get(byte, byte)
                self._frame.append(meant if self._escaped else byte)
                self._escaped = False

    def close(self) -> None:
        """Closes the line."""
        for one in {self._in, self._out}:
            os.close(one)


def _opened(path: str) -> int:
    """A terminal device, raw, at 2 Mbaud."""
    import termios

    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    if not os.isatty(line):
        os.close(line)
        raise ValueError(f"{path} is no serial line, such as /dev/ttyACM0")
    local = termios.CLOCAL | termios.CREAD | termios.CS8
    speed = termios.B2000000
    termios.tcsetattr(line, termios.TCSANOW, [0, 0, local, 0, speed, speed, termios.tcgetattr(line)[6]])
    return line
