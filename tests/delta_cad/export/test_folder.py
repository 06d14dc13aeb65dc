"""Whole or nothing: failures, rejections and kills at every moment leave the previous build intact."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from delta_cad.common import files
from delta_cad.common.files import RECORD, recover
from delta_cad.export.folder import FolderError, output_folder

PROGRAM = """
import os, signal, sys
from pathlib import Path
from delta_cad.common import files
from delta_cad.export.folder import output_folder

def die(*_, **__):
    os.kill(os.getpid(), signal.SIGKILL)

moment, out = sys.argv[1], Path(sys.argv[2])
if "no-exchange" in moment:
    files._exchange = lambda a, b: False
if moment == "sync":
    files._sync = die
if moment == "after-exchange":
    exchange = files._exchange
    files._exchange = lambda a, b: (exchange(a, b), die())
if moment == "before-exchange":
    files._exchange = die
if moment == "cleaning":
    files.shutil.rmtree = die
if moment == "no-exchange-between":
    rename = Path.rename
    def once(self, target):
        rename(self, target)
        die()
    Path.rename = once
with output_folder(out, "joy") as build:
    (build.path / "a").write_text("new")
    if moment == "writing":
        die()
    (build.path / "b").write_text("new")
print("done")
"""
MOMENTS = ("writing", "sync", "before-exchange", "after-exchange", "cleaning", "no-exchange-between")


def make(out: Path, content: str, name: str = "joy", *, rejected: bool = False) -> None:
    with output_folder(out, name) as build:
        build.rejected = rejected
        (build.path / "a").write_text(content)
        (build.path / "parts").mkdir()
        (build.path / "parts" / "b").write_text(content)


def content(out: Path, name: str = "joy") -> set[str]:
    files = [path for path in (out / name).rglob("*") if path.is_file() and path.name != RECORD]
    assert files
    return {path.read_text() for path in files}


def entries(out: Path) -> list[str]:
    return sorted(path.name for path in out.iterdir())


def test_a_build_appears_whole_under_its_name_and_replaces_the_old_one(tmp_path: Path) -> None:
    out = tmp_path / "deep" / "out"
    with output_folder(out, "joy") as build:
        (build.path / "a").write_text("1")
        assert not (out / "joy").exists()
        assert build.path.parent == out
    with output_folder(out, "joy") as build:
        (build.path / "c").write_text("new")
        assert content(out) == {"1"}
    assert entries(out / "joy") == [RECORD, "c"]
    assert entries(out) == ["joy"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
@pytest.mark.parametrize("before", [[], ["joy"]])
def test_a_failing_writer_leaves_the_old_build_and_nothing_else(
    tmp_path: Path, error: type[BaseException], before: list[str]
) -> None:
    def write_half() -> None:
        with output_folder(tmp_path, "joy") as build:
            (build.path / "a").write_text("half")
            raise error

    for name in before:
        make(tmp_path, "old", name)
    with pytest.raises(error):
        write_half()
    assert entries(tmp_path) == before
    assert not before or content(tmp_path) == {"old"}


def test_a_rejected_build_never_touches_a_good_one(tmp_path: Path) -> None:
    make(tmp_path, "good")
    make(tmp_path, "bad", rejected=True)
    with output_folder(tmp_path, "joy") as build:
        (build.path / "a").write_text("worse")
        build.rejected = True
    assert content(tmp_path) == {"good"}
    assert content(tmp_path, "joy.rejected") == {"worse"}
    assert entries(tmp_path) == ["joy", "joy.rejected"]


@pytest.mark.parametrize("name", ["", ".", "..", ".hidden", "a/b", "a b", "joy.rejected"])
def test_unsafe_names_are_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(FolderError), output_folder(tmp_path, name):
        pass
    assert entries(tmp_path) == []


@pytest.mark.parametrize("moment", MOMENTS)
def test_a_kill_at_any_moment_leaves_a_whole_build(tmp_path: Path, moment: str) -> None:
    make(tmp_path, "old")
    job = subprocess.run([sys.executable, "-c", PROGRAM, moment, str(tmp_path)], capture_output=True, timeout=60)
    assert job.returncode == -signal.SIGKILL
    if moment != "no-exchange-between":  # without an atomic exchange there is one moment that the next run mends
        assert content(tmp_path) in ({"old"}, {"new"})
    recover(tmp_path / "joy")
    assert content(tmp_path) == ({"new"} if moment in ("after-exchange", "cleaning") else {"old"})
    assert entries(tmp_path) == ["joy"]


def test_the_program_of_the_kill_test_works_when_it_is_left_alone(tmp_path: Path) -> None:
    for moment in ("never", "no-exchange"):
        make(tmp_path, "old")
        subprocess.run([sys.executable, "-c", PROGRAM, moment, str(tmp_path)], check=True, timeout=60)
        assert content(tmp_path) == {"new"}
        assert entries(tmp_path) == ["joy"]


def test_a_running_build_is_not_cleaned_away(tmp_path: Path) -> None:
    with output_folder(tmp_path, "joy") as slow:
        (slow.path / "a").write_text("slow")
        make(tmp_path, "fast")
        assert (slow.path / "a").read_text() == "slow"
    assert content(tmp_path) == {"slow"}
    assert entries(tmp_path) == ["joy"]


def test_other_names_are_left_alone(tmp_path: Path) -> None:
    others = [".joy.notes.part", ".joy.v2.0123456789abcdef.part", ".joystick.previous"]
    for other in others:
        (tmp_path / other).mkdir()
    make(tmp_path, "1")
    assert entries(tmp_path) == [*others, "joy"]


def test_a_rejected_build_on_its_way_out_does_not_become_a_good_one(tmp_path: Path) -> None:
    (tmp_path / ".joy.rejected.previous").mkdir()
    make(tmp_path, "good")
    assert entries(tmp_path) == ["joy", "joy.rejected"]


def test_the_old_build_comes_back_when_the_rename_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make(tmp_path, "old")
    monkeypatch.setattr(files, "_exchange", lambda *_: False)
    rename = Path.rename

    def failing(self: Path, target: Path) -> Path:
        if self.name.endswith(".part"):
            raise OSError("no space")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", failing)
    with pytest.raises(OSError, match="no space"):
        make(tmp_path, "new")
    assert content(tmp_path) == {"old"}
    assert entries(tmp_path) == ["joy"]


def test_an_exchange_that_fails_for_a_real_reason_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError):
        files._exchange(tmp_path / "a", tmp_path / "b")


def test_a_system_without_exchange_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Old:
        pass

    monkeypatch.setattr(files.ctypes, "CDLL", lambda *_, **__: Old())
    assert files._exchange(tmp_path / "a", tmp_path / "b") is False
    monkeypatch.undo()
    monkeypatch.setattr(files.ctypes, "get_errno", lambda: files.errno.ENOSYS)
    assert files._exchange(tmp_path / "a", tmp_path / "b") is False
