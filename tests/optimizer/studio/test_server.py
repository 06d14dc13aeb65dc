"""The studio's server: its page and a machine's files behind the door, messages both ways, and a clean end."""

from __future__ import annotations

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import pytest
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import ClientConnection, connect
from websockets.typing import Origin, Subprotocol

from delta_cad.report.live.door import MOST_REFUSED, Door
from optimizer.commands.cli import main
from optimizer.studio.server import MOST_BYTES, PROTOCOL, StudioServer
from tests.delta_cad.report.live.test_page import free_port
from tests.optimizer.studio.tasks import JOYSTICK, until
from tests.terminal import HANGS_S, said


class Served(NamedTuple):
    door: Door
    server: StudioServer
    received: list[tuple[Mapping[str, Any], str]]
    folder: Path

    def viewer(self, **changes: Any) -> ClientConnection:
        url = self.door.url.replace("http", "ws", 1)
        own = {"origin": Origin(f"http://{self.door.authority}"), "subprotocols": [Subprotocol(PROTOCOL)]}
        return connect(changes.pop("url", url), **{**own, **changes}, open_timeout=HANGS_S)


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    received: list[tuple[Mapping[str, Any], str]] = []

    def receive(message: Mapping[str, Any], viewer: str) -> None:
        if message.get("type") != "set":
            raise ValueError("none")
        received.append((message, viewer))

    (tmp_path / "machine").mkdir()
    (tmp_path / "machine" / "report.html").write_text("<script>1</script>", encoding="utf-8")
    (tmp_path / "machine" / "assembly.step").write_text("ISO-10303-21;", encoding="utf-8")
    (tmp_path / "secret.txt").write_text("secret", encoding="utf-8")
    door = Door("127.0.0.1", free_port(), lambda _: None, PROTOCOL)
    server = StudioServer(door, lambda: tmp_path / "machine", lambda: [{"type": "hello"}], receive)
    server.begin()
    try:
        yield Served(door, server, received, tmp_path)
    finally:
        server.close()


def test_the_page_and_its_scripts_come_from_here_and_may_ask_nobody_else(served: Served) -> None:
    with urlopen(served.door.url, timeout=HANGS_S) as answer:
        page, policy = answer.read().decode(), answer.headers["Content-Security-Policy"]
    assert "default-src 'none'; script-src 'self'" in policy
    assert "unsafe" not in policy
    assert "http" not in page.replace("http-equiv", "")  # no address of another place
    names = ("studio.css", "studio.js", "scene.js", "charts.js", "kinematics.js", "three.js")
    for name in names:
        assert f'"{name}"' in page
        with urlopen(served.door.url + name, timeout=HANGS_S) as answer:
            assert len(answer.read()) > 500
            assert answer.headers["Content-Type"].startswith(("text/javascript", "text/css"))


def test_files_of_the_machine_are_given_and_no_others(served: Served) -> None:
    with urlopen(served.door.url + "machine/report.html", timeout=HANGS_S) as answer:
        assert answer.headers["Content-Security-Policy"].startswith("default-src 'none'; script-src 'unsafe-inline'")
    with urlopen(served.door.url + "machine/assembly.step", timeout=HANGS_S) as answer:
        assert answer.headers["Content-Disposition"] == 'attachment; filename="assembly.step"'
        assert answer.read() == b"ISO-10303-21;"
    for path in ("machine/../secret.txt", "machine/%2e%2e/secret.txt", "machine/", "machine/none", "secret.txt", "x"):
        with pytest.raises(HTTPError) as refused:
            urlopen(served.door.url + path, timeout=HANGS_S)
        assert refused.value.code == 404
        refused.value.close()


@pytest.mark.parametrize("headers", [{"Host": "evil.example"}, {"Origin": "http://evil.example"}])
def test_who_comes_from_elsewhere_or_without_the_token_is_refused(served: Served, headers: dict[str, str]) -> None:
    for url, more in ((served.door.url, headers), (f"http://{served.door.authority}/", {})):
        with pytest.raises(HTTPError) as refused:
            urlopen(Request(url, headers=more), timeout=HANGS_S)
        assert refused.value.code == 403
        refused.value.close()
    with pytest.raises(InvalidStatus):
        served.viewer(origin=Origin("http://evil.example"))
    with pytest.raises(InvalidStatus):
        served.viewer(subprotocols=[Subprotocol("other")])


def test_messages_go_both_ways(served: Served) -> None:
    with served.viewer() as one, served.viewer() as other:
        you = json.loads(one.recv(HANGS_S))
        assert (you["type"], json.loads(one.recv(HANGS_S))) == ("you", {"type": "hello"})
        one.send(json.dumps({"type": "set", "seq": 1}))
        until(lambda: served.received)
        assert served.received == [({"type": "set", "seq": 1}, you["viewer"])]
        served.server.send({"type": "answer", "side_mm": 88.25})
        for viewer in (one, other):
            until(lambda viewer=viewer: json.loads(viewer.recv(HANGS_S)) == {"type": "answer", "side_mm": 88.25})


@pytest.mark.parametrize("message", [b"bytes", "no JSON", "[1]", '{"type": "quit"}', "[" * 4000])
def test_what_no_page_sends_is_counted_and_ends_a_connection_that_goes_on(served: Served, message: str | bytes) -> None:
    with served.viewer() as one, pytest.raises(ConnectionClosed):  # noqa: PT012
        for _ in range(MOST_REFUSED + 1):
            one.send(message)
        while True:
            one.recv(HANGS_S)
    assert served.door.refusals.count == MOST_REFUSED
    assert served.received == []
    with served.viewer() as another:
        assert json.loads(another.recv(HANGS_S))["type"] == "you"


def test_a_message_that_is_too_long_ends_its_connection(served: Served) -> None:
    with served.viewer() as one, pytest.raises(ConnectionClosed):  # noqa: PT012
        one.send("x" * (MOST_BYTES + 1))
        while True:
            one.recv(HANGS_S)


def test_the_command_tells_its_address_and_ends_by_ctrl_c(tmp_path: Path) -> None:
    port, out = free_port(), tmp_path / "out"
    words = ["studio", str(JOYSTICK), "--port", str(port), "--out", str(out)]
    with subprocess.Popen(
        [sys.executable, "-m", "optimizer", *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as run:
        try:
            assert run.stdout is not None
            address = run.stdout.readline().split()[0]
            with urlopen(address, timeout=HANGS_S) as answer:
                assert b"<canvas" in answer.read()
            run.send_signal(signal.SIGINT)
            rest, err = run.communicate(timeout=HANGS_S)
        finally:
            run.kill()
    assert (run.returncode, rest, said(err)) == (0, "", "")
    assert not out.exists()
    with socket.create_server(("127.0.0.1", port)):
        pass  # it is free again


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["none.toml"], "none.toml"),
        ([str(JOYSTICK), "--host", "192.0.2.1"], "--allow-remote"),
        ([str(JOYSTICK), "--host", "0.0.0.0", "--allow-remote"], "must be the one address"),
    ],
)
def test_wrong_input_is_one_line(words: list[str], expected: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["studio", *words, "--port", str(free_port())]) == 2
    reported = capsys.readouterr().err
    assert said(reported).count("\n") == 1
    assert expected in reported
