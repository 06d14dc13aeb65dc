"""The studio's server: its page, its scripts, the machine's files, and the WebSocket of its viewers, behind the door.

All that a page loads comes from here: its policy allows no other script and no request to another host.
"""

from __future__ import annotations

import asyncio
import http
import json
import mimetypes
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import Event, Thread
from typing import Any
from urllib.parse import unquote

from websockets.asyncio.server import Server, ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response
from websockets.typing import Subprotocol

from delta_cad.report.live.door import HEADERS, MOST_REFUSED, ConnectionLog, Door
from delta_cad.report.page import ASSETS as REPORT
from delta_cad.report.page import VENDOR

PROTOCOL = "delta-studio"
MOST_BYTES = 8192  # of a message; the longest that the page sends, all sliders, has a tenth of it
ASSETS = Path(__file__).parent / "assets"
_FILES = {
    "": ASSETS / "page.html",
    "studio.css": ASSETS / "studio.css",
    "studio.js": ASSETS / "studio.js",
    "charts.js": ASSETS / "charts.js",
    "scene.js": ASSETS / "scene.js",
    "kinematics.js": REPORT / "kinematics.js",
    "picture.js": REPORT / "picture.js",
    "three.js": VENDOR / "three.js",
}
"""Path behind the token -> file."""
MACHINE = "machine/"  # path of the files of the machine that was built
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://{at}; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# Of a built machine's own pages, whose scripts stand in them: nothing from elsewhere, and nothing is sent anywhere.
_OWN = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src 'self' data: blob:; "
    "connect-src blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
_SHOWN = (".html", ".pdf", ".svg", ".png")  # files that a browser shows; others it stores
_START_S, _CLOSED_S = 10.0, 0.05


class StudioServer:
    """A server in a thread of its own.

    Args:
        door: Who may come in.
        folder: Gives the folder of the machine that was built.
        joined: Called with a viewer's name; gives what it is sent first.
        received: Called with a message and the viewer's name; ValueError for what is no message of this page.
    """

    def __init__(
        self,
        door: Door,
        folder: Callable[[], Path],
        joined: Callable[[], list[dict[str, Any]]],
        received: Callable[[Mapping[str, Any], str], None],
    ) -> None:
        self._door, self._folder, self._joined, self._received = door, folder, joined, received
        self._loop = asyncio.new_event_loop()
        self._server: Server | None = None
        self._ready, self._fault = Event(), None
        self._thread = Thread(target=self._run, daemon=True)

    def begin(self) -> None:
        """Begins to serve.

        Raises:
            OSError: The address cannot be listened on.
        """
        self._thread.start()
        self._ready.wait(_START_S)
        if self._fault is not None:
            raise self._fault

    def send(self, message: Mapping[str, Any]) -> None:
        """Sends a message to every viewer; one that reads too slowly misses some."""
        if self._server is None or self._loop.is_closed():
            return
        text = json.dumps(message, separators=(",", ":"), allow_nan=False, default=_plain)
        self._loop.call_soon_threadsafe(self._broadcast, text)

    def close(self) -> None:
        """Ends all connections, and the thread."""
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._loop.stop)
            self._thread.join(_START_S)

    def _broadcast(self, text: str) -> None:
        if self._server is not None:
            broadcast(self._server.connections, text)

    def _run(self) -> None:
        asyncio.set_event_loop(self._loop)
        try:
            self._server = self._loop.run_until_complete(self._serve())
        except OSError as error:
            self._fault = error
        self._ready.set()
        if self._server is not None:
            self._loop.run_forever()
            self._loop.run_until_complete(self._end(self._server))
        self._loop.close()

    @staticmethod
    async def _end(server: Server) -> None:
        """Closes every connection, and waits until their sockets are closed."""
        server.close()
        await server.wait_closed()
        if left := asyncio.all_tasks() - {asyncio.current_task()}:
            await asyncio.wait(left, timeout=_START_S)
        await asyncio.sleep(_CLOSED_S)  # transports close their sockets in the loop's next rounds

    async def _serve(self) -> Server:
        return await serve(
            self._viewer,
            self._door.host,
            self._door.port,
            process_request=self._answer,
            subprotocols=[Subprotocol(PROTOCOL)],
            max_size=MOST_BYTES,
            compression=None,
            logger=ConnectionLog(self._door.refusals),
            server_header=None,
        )

    async def _viewer(self, connection: ServerConnection) -> None:
        """Serves one viewer until it goes, or sent too much that is refused."""
        name, refused = str(connection.id), 0
        await connection.send(json.dumps({"type": "you", "viewer": name}))
        for message in self._joined():
            await connection.send(json.dumps(message, separators=(",", ":"), default=_plain))
        try:
            async for raw in connection:
                try:
                    message = json.loads(raw) if isinstance(raw, str) else None
                    if not isinstance(message, dict):
                        raise ValueError("no message")
                    self._received(message, name)
                except (ValueError, RecursionError):
                    self._door.refusals.add("a message that no viewer of this page sends")
                    refused += 1
                    if refused >= MOST_REFUSED:
                        return
        except ConnectionClosed:
            return

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answers a request for a file, lets a viewer in, or refuses both."""
        if fault := self._door.fault(request, len(connection.server.connections)):
            self._door.refusals.add(fault)
            return connection.respond(http.HTTPStatus.FORBIDDEN, "refused\n")
        if "Upgrade" in request.headers:
            return None
        path = unquote(request.path.partition("?")[0].removeprefix("/").partition("/")[2])
        policy = _POLICY.format(at=self._door.authority)
        if (file := _FILES.get(path)) is None and path.startswith(MACHINE):
            file, policy = self._of_machine(path.removeprefix(MACHINE)), _OWN
        if file is None:
            return connection.respond(http.HTTPStatus.NOT_FOUND, "not found\n")
        try:
            content = file.read_bytes()
        except OSError:
            return connection.respond(http.HTTPStatus.NOT_FOUND, "not found\n")
        kind = "text/javascript" if file.suffix == ".js" else mimetypes.guess_type(file.name)[0]
        text = "; charset=utf-8" if file.suffix in (".js", ".css", ".html", ".csv", ".json", ".toml") else ""
        headers = HEADERS | {
            "Content-Type": f"{kind or 'application/octet-stream'}{text}",
            "Content-Length": str(len(content)),
            "Content-Security-Policy": policy,
            "Connection": "close",
        }
        if policy is _OWN and file.suffix not in _SHOWN:
            headers["Content-Disposition"] = f'attachment; filename="{file.name}"'
        return Response(http.HTTPStatus.OK, "OK", Headers(headers), content)

    def _of_machine(self, path: str) -> Path | None:
        """A file of the machine's folder; None for anything that is not in it."""
        folder = self._folder().resolve()
        file = (folder / path).resolve()
        return file if file.is_relative_to(folder) and file.is_file() else None


def _plain(value: Any) -> Any:
    """A number or array of NumPy as JSON has it."""
    return value.tolist()
