"""`view` as a person starts and ends it: the address, Ctrl-C, a port that is taken, what is not installed."""

from __future__ import annotations

import argparse
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Callable
from typing import Any
from urllib.request import urlopen

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.commands import pipeline, view
from delta_cad.commands.cli import main
from delta_cad.commands.pipeline import BuiltMachine
from delta_cad.common.refusal import not_installed
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.report.live import nearest
from delta_cad.report.live.earlier import Earlier
from tests.committed import BEST, Built
from tests.terminal import HANGS_S, said


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as found:
        return found.getsockname()[1]


def test_it_tells_its_address_and_ends_by_ctrl_c() -> None:
    port = free_port()
    command = [sys.executable, "-m", "delta_cad", "view", "--design", str(BEST), "--port", str(port)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as run:
        try:
            assert run.stdout is not None
            address = run.stdout.readline().split()[0]
            assert re.fullmatch(rf"http://127\.0\.0\.1:{port}/[\w-]{{22}}/", address)
            with urlopen(address, timeout=HANGS_S) as answer:
                assert b"<html" in answer.read(4000)
            run.send_signal(signal.SIGINT)
            out, err = run.communicate(timeout=HANGS_S)
        finally:
            run.kill()
    assert (run.returncode, out, said(err)) == (0, "", "")
    with socket.create_server(("127.0.0.1", port)):
        pass  # it is free again


def test_a_port_that_is_taken_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main(["view", "--design", str(BEST), "--port", str(port)]) == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    assert f"--port {port}" in reported.err
    assert "in use" in reported.err


@pytest.mark.parametrize(
    ("host", "allowed", "said_"),
    [
        ("0.0.0.0", True, "--host 0.0.0.0: must be the one address"),
        ("::", True, "--host ::: must be the one address"),
        ("192.0.2.1", False, "--allow-remote"),
        ("192.0.2.1", True, "must be an address of this machine"),
        ("no such host", True, "must be an address of this machine"),
        ("x" * 300, True, "must be an address of this machine"),
    ],
)
def test_other_machines_are_let_in_expressly_and_by_one_address(
    host: str, allowed: bool, said_: str, capsys: pytest.CaptureFixture[str]
) -> None:
    more = ["--allow-remote"] if allowed else []
    assert main(["view", "--design", str(BEST), "--port", str(free_port()), "--host", host, *more]) == 2
    reported = capsys.readouterr().err
    assert reported.count("\n") == 1
    assert said_ in reported


def test_without_viser_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "viser", None)
    monkeypatch.delitem(sys.modules, "delta_cad.report.live.guard", raising=False)
    assert main(["view", "--design", str(BEST)]) == 2
    assert capsys.readouterr().err == not_installed("viser", "view") + "\n"


def test_the_first_minute_says_what_is_done_and_shows_the_last_build(
    built: Built,
    best: Design,
    best_dimensions: Dimensions,
    best_assembly: Assembly,
    best_masses: dict[str, Any],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    said_, shown = list[str](), list[str]()

    class Watched:
        def say(self, words: str) -> None:
            said_.append(words)

        def show_earlier(self, machine: Earlier) -> None:
            shown.append("earlier" if machine.same else "other")

        def solids(self, *_: object) -> None:
            shown.append("own")

    def make(design: Design, progress: Callable[[str], None]) -> Any:
        assert design is best
        progress("solid sector")
        return BuiltMachine(best_dimensions, best_assembly, MeshLibrary(best_assembly.parts, 0.2, 0.5), best_masses)

    monkeypatch.setattr(pipeline, "make_machine", make)
    monkeypatch.setattr(nearest, "Neighbours", lambda *_: None)
    given = argparse.Namespace(out=built.folder.parent, catalogue=None)
    view._solids(Watched(), best, given)  # type: ignore[arg-type]
    assert shown == ["earlier", "own"]
    assert "until then the mechanism is shown as lines" in said_[0]
    assert any("solid sector" in words and "those of the last build are shown" in words for words in said_)
    assert said_[-1] == ""
