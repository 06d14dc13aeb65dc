"""Who may reach a page that this machine serves: the address, its random token, and what is refused and counted.

A request is accepted with the printed address as its Host, and as the Origin of what a browser's page opens, and with
the random token of the printed address. `guard` and the studio put their own rules for messages behind it.
"""

from __future__ import annotations

import hmac
import logging
import math
import secrets
import socket
from collections.abc import Callable
from ipaddress import ip_address
from threading import Lock
from time import monotonic
from typing import TYPE_CHECKING

from delta_cad.common.options import MOST_PORT, Option, whole

if TYPE_CHECKING:
    from websockets.http11 import Request

_TOKEN_BYTES = 16
MOST_CLIENTS = 40
MOST_REFUSED = 100  # messages of one connection, after which it is cut
EVERY_S = 10.0  # between two lines about one kind of refusal
_HTTP_PORT = 80  # which an address leaves out
_LOOPBACK = "127.0.0.1"
HEADERS = {
    "Referrer-Policy": "no-referrer",  # the token is part of the address
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
}


def address_options(port: int) -> tuple[Option, ...]:
    """Gives `--port`, `--host` and `--allow-remote` of a command that serves a page; `port` is its default."""
    return (
        Option(
            "--port", type=whole(1, MOST_PORT), default=port, metavar="N", help=f"port of the page; default: {port}"
        ),
        Option(
            "--host",
            default=_LOOPBACK,
            metavar="ADDRESS",
            help="address to listen on, as the browser will have it; default: 127.0.0.1, this machine only",
        ),
        Option("--allow-remote", action="store_true", help="let other machines connect that know the printed address"),
    )


def address_fault(host: str, port: int, allow_remote: bool) -> str:
    """Says why a page is not to be served at an address and port, naming the options; "" where it may."""
    if fault := _host_fault(host, allow_remote):
        return f"--host {host}: {fault}"
    try:  # a server may take the next port that is free
        with socket.create_server((host, port), family=socket.AF_INET6 if ":" in host else socket.AF_INET):
            return ""
    except OSError as error:
        reported = f"--host {host} --port {port}: {error.strerror or error}"
        return f"{reported}; must be an address of this machine and a free port"


def _host_fault(host: str, allow_remote: bool) -> str:
    try:
        found = {ip_address(where[0]) for *_, where in socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)}
    except (OSError, ValueError):  # no such name, or no name
        return "must be an address of this machine"
    if any(address.is_unspecified for address in found):
        return "must be the one address by which browsers reach this machine: the page answers to no other"
    if not (allow_remote or all(address.is_loopback for address in found)):
        return "is not a loopback address; other machines must be allowed expressly (--allow-remote)"
    return ""


class Refusals:
    """Counts what is refused, and says so: the first of a kind at once, then a line each `EVERY_S`; `now` is in s."""

    def __init__(self, say: Callable[[str], object], now: Callable[[], float] = monotonic) -> None:
        self._say, self._now, self._lock = say, now, Lock()
        self._waiting: dict[str, tuple[int, float]] = {}  # kind -> number not logged, time of its last log line
        self.count = 0

    def add(self, kind: str) -> None:
        """Counts one of a kind; kinds are texts of this program, never of who is refused."""
        with self._lock:
            self.count += 1
            (waiting, last), now = self._waiting.get(kind, (0, -math.inf)), self._now()
            reported = now - last >= EVERY_S
            self._waiting[kind] = (0, now) if reported else (waiting + 1, last)
        if reported:
            self._say(f"refused: {kind}" + (f" ({waiting + 1} since the last line)" if waiting else ""))


class ConnectionLog(logging.Logger):
    """Takes what websockets says of a connection that failed, whatever filters viser adds: no traceback."""

    def __init__(self, refusals: Refusals) -> None:
        super().__init__("delta_cad.live", logging.ERROR)
        self._refusals = refusals

    def handle(self, record: logging.LogRecord) -> None:
        """Counts a failed connection."""
        self._refusals.add(f"a connection ({record.getMessage()})")


class Door:
    """Decides whether a request may reach a server.

    Args:
        host: Address that the server listens on, in its printed form.
        port: Its port.
        say: Takes a line about what was refused.
        protocol: Subprotocol that a WebSocket of this page names.

    Attributes:
        url: The address to print; it holds the token.
        authority: Host and port of it.
        refusals: What was refused.
    """

    def __init__(self, host: str, port: int, say: Callable[[str], object], protocol: str) -> None:
        self.host, self.port, self._protocol = host, port, protocol
        name = f"[{host}]" if ":" in host else host.lower()
        self.authority = name if port == _HTTP_PORT else f"{name}:{port}"
        self._origin, self._token = f"http://{self.authority}", secrets.token_urlsafe(_TOKEN_BYTES)
        self.url = f"{self._origin}/{self._token}/"
        self.refusals = Refusals(say)

    def fault(self, request: Request, clients: int) -> str:
        """Says why a request is not accepted, without a word of its own; "" where it is."""
        headers = request.headers
        if [host.lower() for host in headers.get_all("Host")] != [self.authority]:
            return "a request to another host than the printed address"
        upgrade, origins = headers.get_all("Upgrade"), headers.get_all("Origin")
        if upgrade not in ([], ["websocket"]):
            return "a request to upgrade to something else than a WebSocket"
        if origins != [self._origin] and (upgrade or origins):
            return "a request from a page of another origin"
        token = request.path.partition("?")[0].removeprefix("/").partition("/")[0]
        if not hmac.compare_digest(token.encode("utf-8", "replace"), self._token.encode()):
            return "a request without the token of the printed address"
        if upgrade and headers.get_all("Sec-WebSocket-Protocol") != [self._protocol]:
            return "a viewer of another version"
        if upgrade and clients >= MOST_CLIENTS:
            return f"more than {MOST_CLIENTS} viewers"
        return ""
