"""Datagrams between two ends by UDP, which stays on this machine unless other machines are allowed."""

from __future__ import annotations

import ipaddress
import select
import socket

LARGEST = 2048  # Longest datagram that is read, bytes; ours have at most 60


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
