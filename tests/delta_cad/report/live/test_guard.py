"""The guard of the live page: who gets in, what of the messages gets through, and that nothing else leaves a trace."""

from __future__ import annotations

import logging
import math
import random
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, redirect_stdout, suppress
from io import StringIO
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import pytest
import viser
import zstandard
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from delta_cad.design import Design
from delta_cad.report.live import guard as guard_module
from delta_cad.report.live.door import EVERY_S, MOST_CLIENTS, MOST_REFUSED, Refusals
from delta_cad.report.live.guard import MOST_BYTES, Guard, guarded_server
from delta_cad.report.live.page import HANDLE, SCENES, SLIDERS, LivePage
from tests.delta_cad.report.live.test_page import free_port
from tests.terminal import HANGS_S

VERSION = f"viser-v{viser.__version__}"
CLIENTS = 25
MOST_GROWN = 30e6  # bytes: 20,000 messages of 4 kB, if they were kept, are 80e6
CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": [1.0, 0.0, 0.0, 0.0],
    "position": [0.1, -0.4, 0.3],
    "fov": 1.3,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 700,
    "image_width": 1000,
    "look_at": [0, 0, 0],
    "up_direction": [0.0, 0.0, 1.0],
}


class Served(NamedTuple):
    """A page behind its guard, and what the guard said."""

    guard: Guard
    server: viser.ViserServer
    page: LivePage
    lines: list[str]
    port: int

    @property
    def origin(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def path(self) -> str:
        return self.guard.url.removeprefix(self.origin)

    def viewer(self) -> ClientConnection:
        """A viewer as a browser has it, that has told its camera."""
        url, known = f"ws://127.0.0.1:{self.port}{self.path}"[:-1], [Subprotocol(VERSION)]
        found = connect(url, origin=Origin(self.origin), subprotocols=known, max_size=None, max_queue=None)
        found.send(packed(CAMERA))
        return found

    def control(self, name: str) -> str:
        """Id of a control."""
        known = self.page._sliders | {"solids": self.page._solids, "scene": self.page._scene}
        return known[name]._impl.uuid


@pytest.fixture
def served(best: Design, capfd: pytest.CaptureFixture[str], caplog: pytest.LogCaptureFixture) -> Iterator[Served]:
    port, lines = free_port(), list[str]()
    guard = Guard("127.0.0.1", port, lines.append)
    server = guarded_server(guard, "test")
    page = LivePage(server, best)
    guard.begin(page.ranges(), HANDLE, page.nearest_m)
    with caplog.at_level(logging.WARNING):
        yield Served(guard, server, page, lines, port)
        guard.end()
        page.close()
        with redirect_stdout(StringIO()):
            server.stop()
    assert [record.getMessage() for record in caplog.records] == []
    assert capfd.readouterr() == ("", "")


def packed(message: Any) -> bytes:
    return msgspec.msgpack.encode(message)


def drag(position: Any, **more: Any) -> dict[str, Any]:
    reported = {"name": HANDLE, "wxyz": [1, 0, 0, 0], "position": position, "owner": ""}
    return {"type": "TransformControlsUpdateMessage", **reported, **more}


def change(uuid: str, value: Any, **more: Any) -> dict[str, Any]:
    return {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value, **more}}


def wait_until(true: Callable[[], bool]) -> None:
    end = time.monotonic() + HANGS_S
    while not true():
        assert time.monotonic() < end
        time.sleep(0.005)


def answered(port: int, head: str) -> bytes:
    """All that the server answers to the head of a request, until it closes or 0.5 s of silence."""
    with socket.create_connection(("127.0.0.1", port), timeout=HANGS_S) as asking:
        asking.sendall(head.replace("\n", "\r\n").encode() + b"\r\n\r\n")
        answer = asking.recv(65536)
        asking.settimeout(0.5)
        with suppress(TimeoutError):
            while piece := asking.recv(65536):
                answer += piece
    return answer


def head_of(s: Served, socket_: bool, **other: str | None) -> str:
    """Head of a good request, for the page or a WebSocket, with other values of some fields; None leaves one out."""
    path = other.pop("path", s.path)
    fields: dict[str, str | None] = {"Host": f"127.0.0.1:{s.port}"}
    if socket_:
        fields |= {"Origin": s.origin, "Upgrade": "websocket", "Connection": "Upgrade", "Sec-WebSocket-Version": "13"}
        fields |= {"Sec-WebSocket-Key": "dGhlIHNhbXBsZSBub25jZQ==", "Sec-WebSocket-Protocol": VERSION}
    fields |= other
    return "\n".join([f"GET {path} HTTP/1.1", *(f"{k}: {v}" for k, v in fields.items() if v is not None)])


def test_the_printed_address_gets_the_page_and_a_socket(served: Served) -> None:
    page, upgraded = answered(served.port, head_of(served, False)), answered(served.port, head_of(served, True))
    assert page.startswith(b"HTTP/1.1 200")
    assert b"<html" in page
    assert b"Referrer-Policy: no-referrer" in page
    assert upgraded.startswith(b"HTTP/1.1 101")
    reloaded = head_of(served, False, path=f"{served.path}?websocket=ws://127.0.0.1:{served.port}{served.path}")
    assert answered(served.port, reloaded).startswith(b"HTTP/1.1 200")
    for length in (255, 256, 5000):  # no file has such a name
        missing = answered(served.port, head_of(served, False, path=f"{served.path}{'a' * length}"))
        assert missing.startswith(b"HTTP/1.1 404")
    assert served.lines == []


@pytest.mark.parametrize("socket_", [False, True])
@pytest.mark.parametrize(
    "other",
    [
        {"Host": "evil.example"},
        {"Host": "localhost:{port}"},
        {"Host": "127.0.0.1"},
        {"Host": None},
        {"Host": "127.0.0.1:{port}\nHost: 127.0.0.1:{port}"},
        {"Origin": "http://evil.example"},
        {"Origin": "https://127.0.0.1:{port}"},
        {"Origin": "null"},
        {"path": "/"},
        {"path": "/index.html"},
        {"path": "/{short}/"},
        {"path": "/{token}x/"},
        {"path": "//{token}/"},
        {"path": "/é/"},
        {"path": "/../{token}/"},
        {"Upgrade": "h2c"},
        {"Upgrade": "websocket\nUpgrade: websocket"},
    ],
)
def test_any_other_request_gets_nothing(served: Served, other: dict[str, str | None], socket_: bool) -> None:
    token = served.path.strip("/")
    filled = {k: v and v.format(port=served.port, token=token, short=token[:-1]) for k, v in other.items()}
    answer = answered(served.port, head_of(served, socket_, **filled))
    if answer:  # what is no HTTP gets no word
        assert answer.split()[1][:1] == b"4"
    assert b"<html" not in answer
    assert b"ccess-Control" not in answer
    assert token.encode() not in answer
    assert served.server.get_clients() == {}
    assert len(served.lines) == 1
    assert "evil" not in served.lines[0]


@pytest.mark.parametrize(
    "other", [{"Origin": None}, {"Sec-WebSocket-Protocol": None}, {"Sec-WebSocket-Protocol": "viser-v[red]"}]
)
def test_a_socket_needs_origin_and_version(served: Served, other: dict[str, str | None]) -> None:
    assert answered(served.port, head_of(served, True, **other)).startswith(b"HTTP/1.1 403")
    assert len(served.lines) == 1


def test_the_token_is_another_each_time_and_says_nothing(served: Served) -> None:
    tokens = {Guard("127.0.0.1", served.port, print).url.rstrip("/").rpartition("/")[2] for _ in range(100)}
    assert len(tokens) == 100
    assert min(map(len, tokens)) >= 22  # 128 bits
    assert Guard("::1", 8080, print).url.startswith("http://[::1]:8080/")
    assert Guard("127.0.0.1", 80, print).url.startswith("http://127.0.0.1/")


def test_nobody_can_ask_for_sharing(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    required: list[str] = []
    monkeypatch.setattr(served.server, "request_share_url", lambda *_: required.append("share"))
    handled = {kind.__name__ for kind in served.server._websock_server._incoming_handlers}
    assert not {name for name in handled if "Share" in name}
    with served.viewer() as viewer:
        for name in ("ShareUrlRequest", "ShareUrlDisconnect"):
            viewer.send(packed({"type": name}))
        wait_until(lambda: served.guard.refusals.count == 2)
    assert required == []
    assert len(served.lines) == 1


def garbage(s: Served) -> list[Any]:
    """Messages that are not to get through, each of its own kind."""
    slider, scene, solids = s.control("half_side_mm"), s.control("scene"), s.control("solids")
    upload = {"source_component_uuid": slider, "transfer_uuid": "x", "filename": "a", "mime_type": "", "part_count": 9}
    bad: list[Any] = [change(slider, value) for value in (math.nan, math.inf, -math.inf, "35", None, True, [35.0], {})]
    bad += [change(scene, value) for value in ("", "another", 1, True)]
    bad += [change(solids, value) for value in (1, "True", 0.0)]
    bad += [change("no such control", 1.0), change(slider, 35.0, min=-1e9), {**change(slider, 1.0), "updates": {}}]
    bad += [change(slider, 35.0, visible=False), {**change(slider, 35.0), "excluded_self_client": 0}]
    bad += [drag([0.0, 0.0, bad_]) for bad_ in (math.nan, math.inf, "0", None)]
    bad += [drag([0.0] * count) for count in (0, 2, 4, 400)]
    bad += [drag([0.0, 0.0, 0.1], name="/other"), drag([0.0, 0.0, 0.1], owner="1"), drag([0, 0, 0.1], wxyz=[1, 0])]
    for name, value in (
        ("fov", 0.0),
        ("fov", math.nan),
        ("near", -1.0),
        ("far", math.inf),
        ("image_width", 0),
        ("image_height", 10**9),
        ("image_width", 1.5),
        ("position", [math.nan, 0, 0]),
        ("position", [1e308, 0, 0]),
        ("position", [0, 0, 0]),
        ("wxyz", [0, 0, 0, 0]),
        ("up_direction", [0, 0]),
    ):
        bad.append(CAMERA | {name: value})
    bad += [
        {"type": "FileTransferStartUpload", "size_bytes": 9 * 4000, **upload},
        {
            "type": "FileTransferPart",
            "source_component_uuid": slider,
            "transfer_uuid": "x",
            "part_index": 0,
            "content": b"x",
        },
        {"type": "SceneNodeUpdateMessage", "name": HANDLE, "updates": {"visible": False}},
        {"type": "RunJavascriptMessage", "source": "alert(1)"},
        {"type": "RemoveSceneNodeMessage", "name": HANDLE},
        {"type": "GuiFormDirtyMessage", "uuid": slider},
        {"type": ["GuiUpdateMessage"]},
        {"type": "no such message"},
        {},
        [],
        None,
        7,
    ]
    return [*map(packed, bad), "text", b"", b"\xc1", b"\xdf\xff\xff\xff\xff", b"\x91" * 2000]


def ended_with(viewer: ClientConnection) -> int | None:
    """Reads until the server ends the connection; its code."""
    with suppress(ConnectionClosed):
        while True:
            viewer.recv(timeout=HANGS_S)
    return viewer.close_code


def test_garbage_is_refused_and_changes_nothing(served: Served) -> None:
    before = served.page.lengths, tuple(served.page.handle_mm), len(state(served))
    with ExitStack() as open_:
        for k, message in enumerate(garbage(served), start=1):
            if k % (MOST_REFUSED // 2) == 1:
                viewer = open_.enter_context(served.viewer())
            viewer.send(message)
            wait_until(lambda k=k: served.guard.refusals.count == k)
    assert (served.page.lengths, tuple(served.page.handle_mm), len(state(served))) == before
    assert len(served.lines) == 1


def test_a_long_message_ends_its_connection(served: Served) -> None:
    with served.viewer() as viewer:
        viewer.send(b"x" * (MOST_BYTES + 1))
        assert ended_with(viewer) == 1009
    wait_until(lambda: len(served.lines) == 1)
    assert str(MOST_BYTES) in served.lines[0]


def test_who_sends_nothing_but_garbage_is_sent_away(served: Served) -> None:
    with served.viewer() as viewer:
        with suppress(ConnectionClosed):
            for _ in range(10 * MOST_REFUSED):
                viewer.send(b"\xc1")
        assert ended_with(viewer) == 1006  # without a word
    assert served.guard.refusals.count == MOST_REFUSED


@pytest.mark.parametrize(
    "noise", [b"\r\n\r\n", b"\x16\x03\x01\x02\x00\x01", b"POST / HTTP/1.1\r\n\r\n", b"A" * 100_000]
)
def test_what_is_no_request_is_one_line(served: Served, noise: bytes) -> None:
    with socket.create_connection(("127.0.0.1", served.port)) as asking, suppress(ConnectionError):
        asking.sendall(noise)
        asking.shutdown(socket.SHUT_WR)
        asking.recv(100)
    wait_until(lambda: served.guard.refusals.count > 0)
    assert len(served.lines) == 1


def state(s: Served) -> list[Any]:
    """The messages that the server keeps for later viewers."""
    return list(s.server._websock_server._broadcast_buffer.message_from_id.values())


def received(viewer: ClientConnection, last: str) -> list[dict[str, Any]]:
    """Messages up to one of a type, as the page's own script unpacks them."""
    found: list[dict[str, Any]] = []
    while True:
        window = viewer.recv(timeout=HANGS_S)
        assert isinstance(window, bytes)
        size = int.from_bytes(window[8:16], "little")
        found += msgspec.msgpack.decode(zstandard.decompress(window[16 : 16 + size]))["messages"]
        if any(message["type"] == last for message in found):
            return found


def test_twenty_five_viewers_see_one_machine_within_its_ranges(served: Served) -> None:
    sliders, ids = served.page._sliders, {name: served.control(name) for name in SLIDERS}
    with ExitStack() as open_:
        viewers = [open_.enter_context(served.viewer()) for _ in range(CLIENTS)]
        wait_until(lambda: len(served.server.get_clients()) == CLIENTS)
        for k, viewer in enumerate(viewers):
            received(viewer, "ReplayDoneMessage")
            for n, uuid in enumerate(ids.values()):
                viewer.send(packed(change(uuid, (0.0, 1e308, -1e308, k)[(k + n) % 4])))
            viewer.send(packed(drag([1e300, -1e300, 0.1])))
    wait_until(lambda: served.server.get_clients() == {})
    assert all(slider.min <= slider.value <= slider.max for slider in sliders.values())
    ends = {name: slider.max if k % 2 else slider.min for k, (name, slider) in enumerate(sliders.items())}
    with served.viewer() as one, served.viewer() as late:
        for name, end in ends.items():
            one.send(packed(change(ids[name], 1e308 if end == sliders[name].max else 0)))
        wait_until(lambda: ends.items() <= vars(served.page.lengths).items())
        received(late, "ReplayDoneMessage")
    with served.viewer() as last:
        reported = received(last, "ReplayDoneMessage")
    updates = [m for m in reported if m["type"] == "GuiUpdateMessage" and "value" in m["updates"]]
    values = {m["uuid"]: m["updates"]["value"] for m in updates}
    assert {name: values[uuid] for name, uuid in ids.items()} == ends
    places = [m["position"] for m in reported if m["type"] == "SetPositionMessage" and m["name"] == HANDLE]
    assert all(len(place) == 3 and max(map(abs, place)) < 1.0 for place in places)
    assert served.lines == []


def test_so_many_viewers_and_no_more_but_for_one_that_is_idle(served: Served, monkeypatch: pytest.MonkeyPatch) -> None:
    with ExitStack() as open_:
        for _ in range(MOST_CLIENTS):
            open_.enter_context(served.viewer())
        with pytest.raises(InvalidStatus):
            served.viewer()
        assert len(served.lines) == 1
        wait_until(lambda: len(served.server.get_clients()) == MOST_CLIENTS)
        before = set(served.server.get_clients())
        monkeypatch.setattr(guard_module, "SILENT_S", 0.0)
        open_.enter_context(served.viewer())  # in place of the one that has been silent for longest
        wait_until(lambda: len(before - set(served.server.get_clients())) == 1)
        assert len(served.lines) == 1


def test_each_kind_of_refusal_is_reported_at_once_and_then_seldom() -> None:
    now, lines = [0.0], list[str]()
    refusals = Refusals(lines.append, lambda: now[0])
    for tenth in range(10 * int(EVERY_S) + 1):
        now[0] = tenth / 10.0
        refusals.add("a")
        if tenth == 5:
            refusals.add("b")
    assert refusals.count == 102
    assert len(lines) == 3
    assert lines[:2] == ["refused: a", "refused: b"]
    assert "100" in lines[2]


def resident() -> int:
    """Memory of this process, bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def mutated(rng: random.Random, good: list[dict[str, Any]]) -> bytes | str:
    """A message: good, or with some of its fields, of its values or of its bytes exchanged."""
    values = [0, -1, 1e308, math.nan, math.inf, 2**63, True, None, "", "x" * 300, [], [0.0] * 300, {}, b"\x00" * 300]
    message = dict(rng.choice(good))
    for _ in range(rng.choice((0, 0, 1, 2))):
        message[rng.choice([*message, "another"])] = rng.choice(values)
    if rng.random() < 0.2 and isinstance(message.get("updates"), dict):
        message["updates"] = {"value": rng.choice([*values, rng.gauss(0.0, 100.0)])}
    raw = bytearray(packed(message))
    if rng.random() < 0.2:
        for _ in range(rng.randrange(1, 6)):
            raw[rng.randrange(len(raw))] = rng.randrange(256)
    if rng.random() < 0.05:
        del raw[rng.randrange(len(raw)) :]
    return raw.decode("latin-1") if rng.random() < 0.01 else bytes(raw)


@pytest.mark.parametrize("count", [1_000, pytest.param(20_000, marks=pytest.mark.slow)])
def test_a_fuzzer_leaves_no_trace(served: Served, count: int) -> None:
    rng, lengths = random.Random(count), served.page.lengths
    good = [CAMERA, *(drag([rng.gauss(0.0, 0.1) for _ in range(3)]) for _ in range(9))]
    good += [change(served.control(name), rng.gauss(80.0, 40.0)) for name in SLIDERS]
    good += [change(served.control("scene"), scene) for scene in SCENES]
    kept, before, sent, began = len(state(served)), resident(), 0, time.monotonic()
    while sent < count:
        with suppress(ConnectionClosed), served.viewer() as viewer:
            while sent < count:
                viewer.send(mutated(rng, good))
                sent += 1
    with served.viewer() as viewer:
        for name in SLIDERS:
            viewer.send(packed(change(served.control(name), getattr(lengths, name))))
        wait_until(lambda: served.page.lengths == lengths)
        viewer.send(packed(drag([0.0, 0.0, float(lengths.centre_mm[2]) / 1000.0])))
        wait_until(lambda: float(abs(served.page.handle_mm - lengths.centre_mm).max()) < 1e-6)
    assert served.guard.refusals.count >= MOST_REFUSED  # what follows in a connection that is cut off is not counted
    assert resident() - before < MOST_GROWN
    assert len(state(served)) < kept + 100
    assert len(served.lines) <= 2 * ((time.monotonic() - began) / EVERY_S + 1)  # all are of two kinds
