"""What all commands share: progress where somebody watches and where nobody does, and Ctrl-C that is always heard."""

from __future__ import annotations

import _imp
import io
import json
import math
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from threading import Event
from types import ModuleType

import pytest

from delta_cad.common import console
from tests.committed import ROOT
from tests.terminal import interrupted


class Screen(io.StringIO):
    """A standard error that counts what it is told."""

    def __init__(self, terminal: bool, enough: int = 0) -> None:
        super().__init__()
        self.terminal, self.enough, self.wording = terminal, enough, Event()

    def isatty(self) -> bool:
        return self.terminal

    def write(self, text: str) -> int:
        count = super().write(text)
        if len(self.getvalue().splitlines()) >= self.enough:
            self.wording.set()
        return count


@pytest.fixture(autouse=True)
def _nothing_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    """No line of another test keeps these waiting."""
    monkeypatch.setattr(console.ProgressLine, "_printed_s", -math.inf)


def test_into_a_pipe_a_long_step_says_where_it_is_now_and_then(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(False, 3)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(console, "TELL_S", 0.01)
    with console.ProgressLine() as line:
        line.show("step 1 of\n3")
        assert screen.wording.wait(60.0)  # one call that takes long: nothing more is shown
    assert set(re.sub(r"(?m)^ *\d+ s  ", "", screen.getvalue()).splitlines()) == {"step 1 of 3"}


def test_into_a_pipe_a_short_step_says_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(False)
    monkeypatch.setattr(sys, "stderr", screen)
    with console.ProgressLine() as line:
        line.show("step 1")
    assert screen.getvalue() == ""


def test_into_a_pipe_the_first_sign_comes_before_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(False, 1)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(console, "FIRST_S", 0.01)
    with console.ProgressLine() as line:
        line.show("step 1")
        assert screen.wording.wait(60.0)  # the next would come after an hour
    assert screen.getvalue().count("\n") == 1


def test_what_bridges_ends_with_the_first_word_said(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(True, 1)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with console.ProgressLine(until_heard=True) as line:
        line.show("loading")
    assert screen.getvalue() == ""  # too short to say anything
    monkeypatch.setattr(console, "FIRST_S", 0.01)
    with console.ProgressLine(until_heard=True) as line:
        line.show("loading")
        assert screen.wording.wait(60.0)
        assert console.refuse("no", 2) == 2
        before = screen.getvalue()
        assert before.endswith("loading\r\x1b[Kno\n")
        with console.ProgressLine() as own:
            own.show("step 1")
    assert screen.getvalue() == f"{before}\r\x1b[K    0 s  step 1\r\x1b[K"


def test_what_is_refused_takes_the_place_of_the_line(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(True)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with console.ProgressLine() as line:
        line.show("step 1")
        console.refuse("no", 2)
    assert screen.getvalue() == "\r\x1b[K    0 s  step 1\r\x1b[Kno\n\r\x1b[K"


def test_on_a_terminal_the_line_lives(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(True)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with console.ProgressLine() as line:
        line.show("step 1")
        assert screen.getvalue() == "\r\x1b[K    0 s  step 1"
        line.show("step 2")
    assert screen.getvalue().endswith("step 2\r\x1b[K")


def test_a_terminal_that_can_erase_nothing_gets_plain_lines(monkeypatch: pytest.MonkeyPatch) -> None:
    screen = Screen(True, 1)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setattr(console, "TELL_S", 0.01)
    monkeypatch.setenv("TERM", "dumb")
    with console.ProgressLine() as line:
        line.show("step 1")
        assert screen.wording.wait(60.0)
    assert set(screen.getvalue().splitlines()) == {"    0 s  step 1"}


def test_a_terminal_that_goes_away_ends_no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(_: str) -> int:
        raise BrokenPipeError

    screen = Screen(True)
    monkeypatch.setattr(sys, "stderr", screen)
    with console.ProgressLine() as line:
        screen.write = gone  # type: ignore[method-assign]
        line.show("step 1")


def test_ctrl_c_that_a_library_loses_comes_again(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console, "GRACE_S", 0.01)
    before = signal.getsignal(signal.SIGINT)
    with console.Interrupt():
        with suppress(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(KeyboardInterrupt):
            Event().wait(60.0)
    assert signal.getsignal(signal.SIGINT) is before
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)


def test_what_fails_after_ctrl_c_fails_for_it(capsys: pytest.CaptureFixture[str]) -> None:
    """As a compiler whose callback was interrupted, and which then misses what the callback was to bring."""

    class Torn:
        def __del__(self) -> None:
            os.kill(os.getpid(), signal.SIGINT)

    def torn() -> None:
        with console.Interrupt():
            Torn()
            raise RuntimeError("no compiled object yet")

    with pytest.raises(KeyboardInterrupt):
        torn()
    assert capsys.readouterr().err == ""


def test_a_request_asks_first_and_then_interrupts_who_does_not_look(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console, "GRACE_S", 0.01)
    with console.Request() as required:
        assert not required()
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGALRM})
        os.kill(os.getpid(), signal.SIGINT)
        assert required()
        with pytest.raises(KeyboardInterrupt):
            _unblock_and_wait()


@pytest.mark.parametrize("kind", [console.Interrupt, console.Request])
def test_ctrl_c_waits_until_a_module_in_c_has_begun(
    monkeypatch: pytest.MonkeyPatch, kind: type[console.Interrupt]
) -> None:
    """What such a module calls meanwhile, such as Python's own code for an enumeration, must not be left half done."""
    begun = []

    def begin(_: object) -> None:
        for _ in range(3):
            os.kill(os.getpid(), signal.SIGINT)
        begun.append(True)

    def load() -> None:
        with kind():
            ExtensionFileLoader("a.module", "a.so").exec_module(ModuleType("a.module"))
            Event().wait(60.0)

    monkeypatch.setattr(_imp, "exec_dynamic", begin)
    with pytest.raises(KeyboardInterrupt):
        load()
    assert begun == [True]


def _unblock_and_wait() -> None:
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGALRM})
    Event().wait(60.0)


def test_a_second_request_interrupts_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(console, "GRACE_S", 60.0)
    with console.Request() as required:
        os.kill(os.getpid(), signal.SIGINT)
        assert required()
        with pytest.raises(KeyboardInterrupt):
            os.kill(os.getpid(), signal.SIGINT)


@pytest.mark.parametrize("number", ["SIGINT", "SIGTERM"])
def test_ctrl_c_while_the_commands_load_is_one_line(number: str, tmp_path: Path) -> None:
    (tmp_path / "slow.py").write_text(f"import os, signal\nos.kill(os.getpid(), signal.{number})\n")
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\nfrom delta_cad.common.command_line import run_program\n"
    run = subprocess.run([sys.executable, "-c", f"{code}run_program('slow')"], capture_output=True, text=True)
    assert (run.returncode, run.stderr) == (console.INTERRUPTED, "interrupted; nothing was written\n")


def test_an_interrupted_process_waits_for_nobody(tmp_path: Path) -> None:
    """A thread that is still busy, as those of a cluster, holds up no end."""
    (tmp_path / "busy.py").write_text(
        "from threading import Event, Thread\nfrom delta_cad.common.console import Interrupt\n"
        "def main():\n    Thread(target=Event().wait).start()\n    with Interrupt():\n        Event().wait()\n"
    )
    code = f"import sys; sys.path.insert(0, {str(tmp_path)!r})\nfrom delta_cad.common.command_line import run_program\n"
    ended = interrupted([sys.executable, "-c", f"{code}run_program('busy')"], 0.0)
    assert (ended.code, ended.said) == (console.INTERRUPTED, "interrupted; nothing was written\n")


def test_what_ctrl_c_ends_well_keeps_its_code(tmp_path: Path) -> None:
    """Also where it strikes in text that is executed, of which the interpreter remembers that it was interrupted."""
    (tmp_path / "served.py").write_text(
        "from delta_cad.common.console import Interrupt\n"
        "def main():\n    try:\n        with Interrupt():\n            exec('import os; os.kill(os.getpid(), 2)')\n"
        "    except KeyboardInterrupt:\n        print('ended')\n        return 0\n"
    )
    (tmp_path / "program.py").write_text(
        "from delta_cad.common.command_line import run_program\nrun_program('served')\n"
    )
    room = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    run = subprocess.run([sys.executable, "-m", "program"], env=room, capture_output=True, text=True)
    assert (run.returncode, run.stdout, run.stderr) == (0, "ended\n", "")


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where the moments of works are kept."""
    place = tmp_path / "cache" / "durations.json"
    monkeypatch.setattr(console, "_durations", lambda: place)
    return place


@pytest.mark.usefixtures("kept")
def test_time_left_is_that_of_the_last_run_at_the_pace_of_this_one() -> None:
    first = console.TimeLeft("build")
    assert first.left_s(0.0) is None  # nothing is measured yet
    for what, at in (("loading", 0.0), ("solids", 30.0), ("checks", 60.0)):
        first.begins(what, at)
        assert first.left_s(at) is None
    first.keep(100.0)
    second = console.TimeLeft("build")
    second.begins("loading", 0.0)
    assert (second.left_s(0.0), second.left_s(10.0)) == (100.0, 90.0)
    second.begins("solids", 60.0)  # twice as slow: 70 s of the last run are left
    assert second.left_s(60.0) == 140.0
    second.begins("unheard of", 61.0)
    second.begins("solids", 80.0)  # again: says nothing
    assert second.left_s(80.0) == 120.0
    assert second.left_s(201.0) is None  # beyond what the last run says
    assert console.TimeLeft("check").left_s(0.0) is None


def test_a_run_that_was_cut_short_is_not_kept_and_a_damaged_file_says_nothing(kept: Path) -> None:
    cut = console.TimeLeft("build")
    cut.begins("loading", 1.0)
    cut.forget()
    cut.keep(5.0)
    assert not kept.exists()
    kept.parent.mkdir()
    for text in ("", "[]", '{"build": 3}', '{"build": {"": null}}', '{"build": {"loading": 1}}', "\xff"):
        kept.write_text(text)
        found = console.TimeLeft("build")
        found.begins("loading", 0.0)
        assert found.left_s(0.0) is None
    found.keep(2.0)  # over a file of something else: left as it was
    assert kept.read_text() == "\xff"


def test_the_last_works_are_kept(kept: Path) -> None:
    for number in range(console._WORKS + 3):
        one = console.TimeLeft(f"design {number}")
        one.begins("loading", 0.0)
        one.begins("84.06 mm with a motor", 0.5)  # no other run has it
        one.keep(1.0)
    assert json.loads(kept.read_text())["design 3"] == {"loading": 0.0, "": 1.0}
    assert next(iter(json.loads(kept.read_text()))) == "design 3"


def test_time_left_of_a_step_follows_from_its_units() -> None:
    left = console.TimeLeft("")
    left.counts("estimates", 0, 8, 10.0)
    assert left.step_left_s(20.0) is None  # no unit is done
    left.counts("estimates", 2, 8, 20.0)
    assert left.step_left_s(20.0) == 30.0  # 5 s each, six are left
    left.counts("parts", 0, 6, 25.0)
    assert left.step_left_s(26.0) is None
    left.counts("parts", 1, 6, 28.0)
    assert left.step_left_s(28.0) == 15.0


@pytest.mark.usefixtures("kept")
def test_a_step_is_shown_with_its_bar_the_best_so_far_and_the_time_left(monkeypatch: pytest.MonkeyPatch) -> None:
    seconds = [0.0]
    screen = Screen(True)
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(console.ProgressLine, "_seconds", lambda _: seconds[0])
    with console.ProgressLine(work="design") as line:
        line.show(console.Step("motor 1", "estimates", 1, 4, 0, 4))
        seconds[0] = 20.0
        line.show(console.Step("motor 2", "estimates", 1, 4, 1, 4, "84 mm"))
        assert screen.getvalue().endswith(
            "   20 s  step 1 of 4, estimates [####------------] 1 of 4; about 60 s left of this step; "
            "best so far 84 mm; motor 2"
        )
        line.show("solid base_plate")  # belongs to the step
        assert "step 1 of 4" in screen.getvalue().rpartition("\r")[2]
        seconds[0] = 400.0
    with console.ProgressLine(work="design") as line:
        seconds[0] = 100.0
        line.show(console.Step("motor 1", "estimates", 1, 4))
        assert "estimates [###-------------]; about 7 min left; motor 1" in screen.getvalue()


@pytest.mark.parametrize(
    ("columns", "shown"),
    [(20, "a step ..."), (32, "a step with many words"), (31, "a step with many w..."), (0, "a step with many words")],
)
def test_a_line_is_no_wider_than_the_terminal(monkeypatch: pytest.MonkeyPatch, columns: int, shown: str) -> None:
    monkeypatch.setattr(sys, "stderr", screen := Screen(True))
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(screen, "fileno", lambda: 2)
    monkeypatch.setattr(os, "get_terminal_size", lambda _: os.terminal_size((columns, 24)))
    with console.ProgressLine() as line:
        line.show("a step with many words")
        assert screen.getvalue() == f"\r\x1b[K    0 s  {shown}"


def test_into_a_pipe_findings_wait_for_the_next_line_and_the_newest_is_printed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", screen := Screen(False))
    with console.ProgressLine() as line:
        line.show("step 1")
        for k in range(100):
            line.keep(f"finding {k}")
        assert screen.getvalue() == ""
        line._tell()
        line._tell()
    assert screen.getvalue() == "    0 s  finding 99\n    0 s  step 1\n"


def test_lines_of_works_that_follow_one_another_keep_their_distance(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", Screen(False))
    monkeypatch.setattr(console, "TELL_S", 10.0)
    monkeypatch.setattr(console, "FIRST_S", 0.8)
    first, second = console.ProgressLine(until_heard=True), console.ProgressLine()
    assert first._pause_s() == 0.8
    first.show("loading")
    first._tell()
    assert 9.0 < second._pause_s() <= 10.0


@pytest.mark.usefixtures("kept")
def test_events_are_json_objects_a_line_and_messages_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stderr", screen := Screen(False))
    monkeypatch.setattr(console.ProgressLine, "as_json", True)
    with console.ProgressLine(work="design") as line:
        line.show(console.Step("motor 1", "estimates", 1, 4, 0, 4, "84 mm"))
        line.keep("it passes")
        console.refuse("a note", 0)
    console.ProgressLine.event("end", code=0, folder="out/x")
    events = [json.loads(text) for text in screen.getvalue().splitlines()]
    assert [one["event"] for one in events] == ["progress", "found", "message", "end"]
    place = {"step": 1, "of": 4, "name": "estimates", "done": 0, "total": 4, "best": "84 mm"}
    assert {key: events[0][key] for key in place} == place
    assert (events[0]["doing"], events[1]["text"], events[2]["text"]) == ("motor 1", "it passes", "a note")
    assert "left_s" not in events[0]  # nothing measured
