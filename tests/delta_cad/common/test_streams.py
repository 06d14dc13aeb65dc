"""What all commands share: text of anybody on one line, what the system refuses, streams that fail."""

from __future__ import annotations

import os
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import pytest

from delta_cad.common.command_line import Program
from delta_cad.common.console import refuse
from tests.terminal import said


def test_a_refusal_is_one_printable_line_on_stderr(capsys: pytest.CaptureFixture[str]) -> None:
    assert refuse("a\x1b[2J\nb", 7) == 7
    assert capsys.readouterr() == ("", "a\\x1b[2J b\n")


def program(does: Callable[[], int]) -> int:
    """The exit code of a program whose one command does something."""
    command = ModuleType("a command")
    command.__dict__.update(NAME="do", TEXT="", OPTIONS=(), run=lambda _: does())
    return Program("program", "", [command], {}, "extra").main(["do"])


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (OSError(28, "No space left on device", "/a/b"), "/a/b: No space left on device"),
        (OSError(30, "Read-only file system", b"/a/\xff"), r"/a/\udcff: Read-only file system"),
        (OSError(122, "Disk quota exceeded"), "Disk quota exceeded"),
        (OSError("only words"), "only words"),
        (TimeoutError(), "TimeoutError"),
        (MemoryError(), "the memory that this process may have is not enough"),
        (
            ImportError("libGL.so.1: cannot open shared object file"),
            "a library cannot be loaded: libGL.so.1: cannot open shared object file",
        ),
    ],
    ids=str,
)
def test_what_the_system_refuses_is_one_line_and_exit_2(
    error: Exception, line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails() -> int:
        raise error

    assert program(fails) == 2
    assert capsys.readouterr() == ("", line + "\n")


def test_usage_is_refused_on_one_printable_line(capsys: pytest.CaptureFixture[str]) -> None:
    parser = Program("program", "", [], {}, "extra").parser()
    with pytest.raises(SystemExit) as ended:
        parser.parse_args(["\x1b[2J\n"])
    assert ended.value.code == 2
    reported = capsys.readouterr().err
    assert reported.endswith("see python -m program --help\n")
    assert reported[:-1].isprintable()


PRINTS = """
import sys, types
from delta_cad.common.command_line import Program
from delta_cad.common.console import refuse
from delta_cad.common.options import Option

def run(given):
    print("a" * int(given.count) + "\\udcff")
    return refuse("told", 1) if given.count == "1" else 0

command = types.SimpleNamespace(NAME="do", TEXT="", OPTIONS=[Option("count")], run=run)
sys.exit(Program("program", "", [command], {}, "extra").main())
"""


@pytest.mark.parametrize("arguments", [["do", "3"], ["do", "100000"], ["--help"]], ids=str)
def test_output_that_cannot_be_written_is_one_line_and_exit_2(arguments: list[str]) -> None:
    with open("/dev/full", "w") as full:
        run = subprocess.run([sys.executable, "-c", PRINTS, *arguments], stdout=full, stderr=subprocess.PIPE, text=True)
    assert (run.returncode, said(run.stderr)) == (2, "standard output: No space left on device\n")


def test_names_that_are_no_text_are_printed_escaped_and_a_full_stderr_changes_no_code() -> None:
    command = [sys.executable, "-c", PRINTS, "do"]
    for encoding in ("utf-8", "ascii"):
        run = subprocess.run([*command, "2"], capture_output=True, env=os.environ | {"PYTHONIOENCODING": encoding})
        assert (run.returncode, run.stdout, run.stderr) == (0, b"aa\\udcff\n", b"")
    with open("/dev/full", "w") as full:
        assert subprocess.run([*command, "1"], stdout=subprocess.DEVNULL, stderr=full).returncode == 1


ENDS = """
import os, sys, types
from delta_cad.common.command_line import Program
from delta_cad.common.console import ProgressLine, refuse

def run(given):
    with ProgressLine() as line, open(sys.argv[0], "w") as file:
        line.show("a step")
        os.write(1, b"of a library")
        os.write(2, b"of a library")
        print("told")
    return refuse("told", 1)

command = types.SimpleNamespace(NAME="do", TEXT="", OPTIONS=(), run=run)
sys.exit(Program("program", "", [command], {}, "extra").main(sys.argv[1:]))
"""


@pytest.mark.parametrize("closed", ["<&- >&-", ">&-", "2>&-", "<&- >&- 2>&-"])
@pytest.mark.parametrize(("argument", "code"), [("do", 1), ("--help", 0), ("wrong", 2)])
def test_streams_that_are_closed_change_no_exit_code_and_no_file(
    tmp_path: Path, closed: str, argument: str, code: int
) -> None:
    """Each in a process of its own, in which the file opened next would have the number of the stream."""
    (tmp_path / "a").write_text("")
    program = f"import sys; sys.argv = [{str(tmp_path / 'a')!r}, {argument!r}]\n{ENDS}"
    line = f"exec {shlex.quote(sys.executable)} -c {shlex.quote(program)} {closed}"
    run = subprocess.run(["sh", "-c", line], capture_output=True, text=True)
    assert run.returncode == code
    assert "Traceback" not in run.stderr
    assert (tmp_path / "a").read_text() == ""
