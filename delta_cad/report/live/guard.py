"""The guard in front of the live page's server: who may connect, and which messages go through.

A request is accepted with the printed address as its Host (and as the Origin of what a browser's page opens) and with
the random token of the printed address, and of a WebSocket only messages that a viewer of this page sends: each typed,
its numbers finite and within the range of what they move. Anything else is refused before viser sees it, and counted.
"""

from __future__ import annotations

import http
import io
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from time import monotonic
from typing import Any

import msgspec
import viser
import websockets.asyncio.server
from viser import _messages as viser_messages
from websockets.asyncio.server import ServerConnection
from websockets.exceptions import ConnectionClosed, ConnectionClosedError
from websockets.frames import CloseCode
from websockets.http11 import Request, Response

from delta_cad.report.live.door import HEADERS, MOST_CLIENTS, MOST_REFUSED, ConnectionLog, Door

MOST_BYTES = 4096  # of a message; a camera, the longest one that the page sends, has a tenth of it
SILENT_S = 60.0  # after which a viewer that sent nothing gives way to another, where there are so many
_LONGEST_PATH = 255  # letters behind the token: no file has a longer name, and none of the page's a longer path
_MOST_m = 100.0  # of a camera's position; machines have tenths of a metre
_MOST_px = 32768  # of a screen
_Vector = tuple[float, float, float]
_Turn = tuple[float, float, float, float]


class _Message(msgspec.Struct, tag_field="type", forbid_unknown_fields=True):
    """What a viewer may send; its fields are those of viser's message of that name."""


class _Camera(_Message, tag="ViewerCameraMessage"):
    """Where a viewer looks from, m and rad."""

    wxyz: _Turn
    position: _Vector
    fov: float
    near: float
    far: float
    image_height: int
    image_width: int
    look_at: _Vector
    up_direction: _Vector


class _Drag(_Message, tag="TransformControlsUpdateMessage"):
    """Where the handle is dragged to, m."""

    name: str
    wxyz: _Turn
    position: _Vector
    owner: str = ""


class _DragStart(_Message, tag="TransformControlsDragStartMessage"):
    """The handle is taken hold of."""

    name: str
    owner: str = ""


class _DragEnd(_Message, tag="TransformControlsDragEndMessage"):
    """The handle is let go."""

    name: str
    owner: str = ""


class _Value(msgspec.Struct, forbid_unknown_fields=True):
    """The new value of a control."""

    value: bool | float | str


class _Change(_Message, tag="GuiUpdateMessage"):
    """A control is moved."""

    uuid: str
    updates: _Value


_DECODER = msgspec.msgpack.Decoder(_Camera | _Drag | _DragStart | _DragEnd | _Change)


class Guard(Door):
    """Decides what reaches the server.

    Args:
        host: Address that the server listens on, as it is printed.
        port: Its port.
        say: Takes a line about what was refused.
    """

    def __init__(self, host: str, port: int, say: Callable[[str], object]) -> None:
        super().__init__(host, port, say, f"viser-v{viser.__version__}")
        self._controls: dict[str, Callable[[Any], Any]] = {}
        self._handle: tuple[str, Callable[[_Vector], _Vector]] | None = None

    def begin(
        self, controls: dict[str, Callable[[Any], Any]], handle: str, nearest_m: Callable[[_Vector], _Vector]
    ) -> None:
        """Lets messages through from now on.

        Args:
            controls: Id of a control -> what makes of a value one within its range, or raises ValueError.
            handle: Name of the handle.
            nearest_m: Makes of a position of the handle, m, one within its range.
        """
        self._controls, self._handle = controls, (handle, nearest_m)

    def end(self) -> None:
        """Lets no message through any more, as the server is about to stop."""
        self._handle = None

    def passed(self, raw: str | bytes) -> bytes | None:
        """Gives a message as viser may have it, its values within their ranges; None, and counted, where it may not."""
        if (handle := self._handle) is None:
            return None
        try:
            if isinstance(raw, str):
                raise ValueError("text")
            message = _DECODER.decode(raw)
            self._limit(message, *handle)
        except (ValueError, OverflowError, RecursionError):  # msgspec's errors are ValueErrors
            self.refusals.add("a message that no viewer of this page sends, or with values that no control has")
            return None
        return msgspec.msgpack.encode(message)

    def _limit(self, message: _Message, handle: str, nearest_m: Callable[[_Vector], _Vector]) -> None:
        """Brings the values of a message into their ranges; ValueError where they have none."""
        if isinstance(message, _Change):
            if (limited := self._controls.get(message.uuid)) is None:
                raise ValueError("control")
            message.updates.value = limited(message.updates.value)
        elif isinstance(message, _Camera):
            _require_camera(message)
        elif isinstance(message, _Drag | _DragStart | _DragEnd):
            if message.name != handle or message.owner:
                raise ValueError("name")
            if isinstance(message, _Drag):
                message.position, message.wxyz = nearest_m(finite(message.position)), (1.0, 0.0, 0.0, 0.0)

    @contextmanager
    def in_front(self) -> Iterator[None]:
        """Stands before each server of websockets that begins to serve within the block."""
        guard, serve, begun = self, websockets.asyncio.server.serve, []

        class Guarded(ServerConnection):
            """A connection of which only what passes is received."""

            refused, heard = 0, 0.0

            def connection_made(self, transport: Any) -> None:
                self.heard = monotonic()
                super().connection_made(transport)

            async def recv(self, decode: bool | None = None) -> Any:
                while True:
                    try:
                        message = guard.passed(await super().recv(decode))
                    except ConnectionClosed as closed:
                        if closed.sent is not None and closed.sent.code == CloseCode.MESSAGE_TOO_BIG:
                            guard.refusals.add(f"a message of more than {MOST_BYTES} bytes")
                        raise
                    if message is not None:
                        self.heard = monotonic()
                        return message
                    self.refused += 1
                    if self.refused >= MOST_REFUSED:
                        self.transport.abort()  # a close in good form would wait for what is still to be read
                        raise ConnectionClosedError(None, None)

        def guarded(*arguments: Any, process_request: Any, **options: Any) -> Any:
            def answer(connection: ServerConnection, request: Request) -> Response | None:
                others = [one for one in connection.server.connections if isinstance(one, Guarded)]
                others.sort(key=lambda one: one.heard)
                idle = others[:1] if len(others) >= MOST_CLIENTS and monotonic() - others[0].heard > SILENT_S else []
                if fault := guard.fault(request, len(others) - len(idle)):
                    guard.refusals.add(fault)
                    return connection.respond(http.HTTPStatus.FORBIDDEN, "refused\n")
                request.path = "/" + request.path.removeprefix("/").partition("/")[2]
                if len(request.path.partition("?")[0]) > _LONGEST_PATH:
                    return connection.respond(http.HTTPStatus.NOT_FOUND, "not found\n")
                for one in idle if "Upgrade" in request.headers else ():
                    one.transport.abort()
                response: Response | None = process_request(connection, request)
                if response is not None:
                    response.headers.update(HEADERS)
                return response

            begun.append(True)
            options |= {"max_size": MOST_BYTES, "logger": ConnectionLog(guard.refusals), "create_connection": Guarded}
            return serve(*arguments, process_request=answer, **options)

        websockets.asyncio.server.serve = guarded  # pyright: ignore[reportAttributeAccessIssue]
        try:
            yield
        finally:
            websockets.asyncio.server.serve = serve
        if not begun:
            raise RuntimeError(f"viser {viser.__version__} does not serve by websockets.asyncio.server.serve")


def guarded_server(guard: Guard, label: str) -> viser.ViserServer:
    """Starts a viser server behind a guard: it says nothing, and nobody can ask it to be shared by another's server."""
    with redirect_stdout(io.StringIO()), guard.in_front():  # which would print the address in a frame
        server = viser.ViserServer(host=guard.host, port=guard.port, label=label, verbose=False)
    for share in (viser_messages.ShareUrlRequest, viser_messages.ShareUrlDisconnect):
        server._websock_server.unregister_handler(share)
    return server


def finite(numbers: tuple[float, ...]) -> Any:
    """Gives numbers back; ValueError where one is not finite."""
    if not all(map(math.isfinite, numbers)):
        raise ValueError("not finite")
    return numbers


def within(low: float, high: float) -> Callable[[Any], float]:
    """Makes the range of a slider: gives the nearest value in it, or ValueError where none is a number."""

    def nearest(value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, float | int):
            raise ValueError("not a number")
        return min(max(finite((float(value),))[0], low), high)

    return nearest


def one_of(*legal: Any) -> Callable[[Any], Any]:
    """Makes the range of a control with few values: gives the value back, or ValueError where it is none of them."""

    def same(value: Any) -> Any:
        if not any(type(value) is type(one) and value == one for one in legal):
            raise ValueError("none of the values")
        return value

    return same


def _require_camera(camera: _Camera) -> None:
    """Raises ValueError for a camera that looks from nowhere, or at nothing."""
    far = (*camera.position, *camera.look_at)
    finite((*camera.wxyz, *far, *camera.up_direction, camera.near, camera.far))
    if not all(abs(value) <= _MOST_m for value in far) or camera.position == camera.look_at:
        raise ValueError("position")
    if not (0.0 < camera.fov < math.pi and 0.0 < camera.near < camera.far):
        raise ValueError("lens")
    if not all(0 < size <= _MOST_px for size in (camera.image_width, camera.image_height)):
        raise ValueError("image")
    if not all(0.0 < math.hypot(*turn) < math.inf for turn in (camera.wxyz, camera.up_direction)):
        raise ValueError("direction")
