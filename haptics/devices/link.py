"""Datagrams between two ends: by UDP, on this machine only unless others are permitted, or by a serial line."""

from __future__ import annotations

import ipaddress
import os
import select
import socket
import time

LARGEST = 2048  # Longest datagram that is read, bytes; ours have at most 60
LONGEST = 64  # Longest of a serial line, bytes
END, _ESCAPE, _ESCAPED_END, _ESCAPED_ESCAPE = 0xC0, 0xDB, 0xDC, 0xDD  # Of SLIP


class UdpLink:
    """UDP to one address.

    Args:
        host: Numeric address of the other end.
        port: Port of the other end.
        allow_remote: Whether it may be on another machine.

    Raises:
        ValueError: See `udp_socket`.
    """

    def __init__(self, host: str, port: int, *, allow_remote: bool = False) -> None:
        self._socket = udp_socket(host, allow_remote)
        self._socket.connect((host, port))

    def send(self, data: bytes) -> None:
        """Sends a datagram; it may be lost. Raises OSError if the other end is known to be gone."""
        self._socket.send(data)

    def receive(self, seconds: float) -> bytes | None:
        """The next datagram, or None if none came in that time. Raises OSError if the other end is known to be gone."""
        return self._socket.recv(LARGEST) if readable(self._socket, max(seconds, 0.0)) else None

    def close(self) -> None:
        """Closes the socket."""
        self._socket.close()


class SerialLink:
    """A serial line to one board, framed by SLIP (RFC 1055); or any two descriptors.

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
        plain = data.replace(bytes([_ESCAPE]), bytes([_ESCAPE, _ESCAPED_ESCAPE]))
        os.write(self._out, bytes([END, *plain.replace(bytes([END]), bytes([_ESCAPE, _ESCAPED_END])), END]))

    def receive(self, seconds: float) -> bytes | None:
        """The next datagram, or None if none came in that time. Raises OSError if the line is gone."""
        until = time.monotonic() + max(seconds, 0.0)
        while not self._coming:
            left = until - time.monotonic()
            if not select.select([self._in], [], [], max(left, 0.0))[0]:
                return None
            data = os.read(self._in, LARGEST)
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
            elif byte == _ESCAPE:
                self._escaped = True
            elif len(self._frame) <= LONGEST:  # one more than a datagram has: it is dropped at its end
                meant = {_ESCAPED_END: END, _ESCAPED_ESCAPE: _ESCAPE}.get(byte, byte)
                self._frame.append(meant if self._escaped else byte)
                self._escaped = False

    def close(self) -> None:
        """Closes the line."""
        for one in {self._in, self._out}:
            os.close(one)


def readable(waiting: socket.socket, seconds: float) -> bool:
    """Waits for a datagram, not longer than that; says whether there is one."""
    return bool(select.select([waiting], [], [], seconds)[0])


def udp_socket(host: str, allow_remote: bool) -> socket.socket:
    """A UDP socket of the address's family.

    Args:
        host: Numeric address, IPv4 or IPv6.
        allow_remote: Whether it may be other than loopback.

    Raises:
        ValueError: The address is not numeric, or is not of this machine and that was not allowed.
    """
    try:
        address = ipaddress.ip_address(host)
    except ValueError:
        raise ValueError(f"{host!r} is not a numeric address, such as 127.0.0.1") from None
    if not (address.is_loopback or allow_remote):
        raise ValueError(
            f"{host} is not a loopback address; other machines must be allowed expressly (--allow-remote, allow_remote)"
        )
    return socket.socket(socket.AF_INET6 if address.version == 6 else socket.AF_INET, socket.SOCK_DGRAM)


def _opened(path: str) -> int:
    """A terminal device, raw, at 2 Mbaud."""
    try:
        import termios
    except ModuleNotFoundError:
        raise ValueError(f"{path}: this system has no POSIX serial lines; on Windows run in WSL") from None
    line = os.open(path, os.O_RDWR | os.O_NOCTTY)
    if not os.isatty(line):
        os.close(line)
        raise ValueError(f"{path} is no serial line, such as /dev/ttyACM0")
    local = termios.CLOCAL | termios.CREAD | termios.CS8
    speed = getattr(termios, "B2000000", 2_000_000)  # a system without the constant takes the number
    termios.tcsetattr(line, termios.TCSANOW, [0, 0, local, 0, speed, speed, termios.tcgetattr(line)[6]])
    return line
