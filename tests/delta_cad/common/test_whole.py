"""Files and folders that appear whole or not at all."""

import errno
import fcntl
import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from delta_cad.common.whole import whole_folder, write_all, write_whole


def test_folder_takes_its_place_when_it_is_full(tmp_path: Path) -> None:
    target = tmp_path / "new" / "front"
    for text in ("first", "second"):
        with whole_folder(target) as folder:
            assert list(folder.iterdir()) == []
            (folder / "a").write_text(text)
            assert folder != target
        assert (target / "a").read_text() == text
    assert [path.name for path in target.parent.iterdir()] == ["front"]


def test_folder_that_fails_leaves_what_was(tmp_path: Path) -> None:
    target = tmp_path / "front"
    target.mkdir()
    (target / "a").write_text("old")

    def fill() -> None:
        with whole_folder(target) as folder:
            (folder / "a").write_text("new")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill()
    assert (target / "a").read_text() == "old"
    assert [path.name for path in tmp_path.iterdir()] == ["front"]


FILLER = """
import sys, time
from pathlib import Path
from delta_cad.common.whole import whole_folder
with whole_folder(Path(sys.argv[1])) as folder:
    (folder / "a").write_text("the other's")
    print(folder.name, flush=True)
    sys.stdin.read()
"""


@pytest.fixture
def other(tmp_path: Path) -> Iterator[tuple[subprocess.Popen[str], Path]]:
    """Another process that fills the same folder until its standard input ends, and its part."""
    command = [sys.executable, "-c", FILLER, str(tmp_path / "front")]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout
        yield process, tmp_path / process.stdout.readline().strip()
        process.kill()


def test_folder_of_a_killed_run_is_put_right(tmp_path: Path, other: tuple[subprocess.Popen[str], Path]) -> None:
    process, part = other
    (tmp_path / "front.old").mkdir()
    (tmp_path / "front.old" / "rest").write_text("")
    process.kill()
    process.wait()
    assert (part / "a").exists()
    with whole_folder(tmp_path / "front") as folder:
        assert list(folder.iterdir()) == []
        assert not part.exists()
    assert [path.name for path in tmp_path.iterdir()] == ["front"]


def test_two_processes_fill_the_same_folder_at_once(tmp_path: Path, other: tuple[subprocess.Popen[str], Path]) -> None:
    process, part = other
    with whole_folder(tmp_path / "front") as folder:
        (folder / "b").write_text("ours")
        assert (part / "a").read_text() == "the other's"  # one that lives is left alone
    assert [path.name for path in (tmp_path / "front").iterdir()] == ["b"]
    process.communicate(timeout=30)
    assert process.returncode == 0
    assert [path.name for path in (tmp_path / "front").iterdir()] == ["a"]  # the last to end, and all of it
    assert [path.name for path in tmp_path.iterdir()] == ["front"]


def test_many_at_once_leave_one_whole_folder(tmp_path: Path) -> None:
    def fill(number: int) -> None:
        with whole_folder(tmp_path / "front") as folder:
            for name in "ab":
                (folder / name).write_text(f"{number}")

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(fill, range(100)))
    assert [path.name for path in tmp_path.iterdir()] == ["front"]
    assert len({path.read_text() for path in (tmp_path / "front").iterdir()}) == 1
    assert sorted(path.name for path in (tmp_path / "front").iterdir()) == ["a", "b"]


def test_folders_of_others_are_no_rests(tmp_path: Path) -> None:
    names = ["front.part", "front.x.1-00000000.part", "frontier.1-00000000.part", "front.1-00000000"]
    for name in names:
        (tmp_path / name).mkdir()
    (tmp_path / "front.1-11111111.part").mkdir()
    with whole_folder(tmp_path / "front"):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*names, "front"])


def test_a_part_that_another_run_clears_before_it_is_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At each of the three moments in which it may happen."""
    made: list[Path] = []
    real_open, real_flock = os.open, fcntl.flock

    def opened(path: str | Path, flags: int, **more: int) -> int:
        if str(path).endswith(".part") and len(made) < 4:
            made.append(Path(path))
            if len(made) == 1:
                made[0].rmdir()
        return real_open(path, flags, **more)

    def locked(number: int, how: int) -> None:
        if len(made) == 2:
            raise BlockingIOError
        if len(made) == 3 and made[2].exists():
            made[2].rmdir()
        real_flock(number, how)

    monkeypatch.setattr("delta_cad.common.whole.os.open", opened)
    monkeypatch.setattr("delta_cad.common.whole.fcntl.flock", locked)
    with whole_folder(tmp_path / "front") as folder:
        assert folder == made[3]
        (folder / "a").write_text("")
    assert [path.name for path in (tmp_path / "front").iterdir()] == ["a"]


def test_a_file_system_without_locks_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("delta_cad.common.whole.fcntl.flock", none)
    stale = tmp_path / "front.1-11111111.part"
    stale.mkdir()
    with whole_folder(tmp_path / "front") as folder:
        (folder / "a").write_text("")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["front", stale.name]  # nobody knows who fills it


def test_file_in_the_folders_place_is_not_replaced(tmp_path: Path) -> None:
    (tmp_path / "front").write_text("a file")
    with pytest.raises(FileExistsError, match="a file has the folder's name"), whole_folder(tmp_path / "front"):
        pass
    assert (tmp_path / "front").read_text() == "a file"


def test_a_file_is_whole_or_not_at_all(tmp_path: Path) -> None:
    write_whole(tmp_path / "a" / "b.json", "one")
    with pytest.raises(UnicodeEncodeError):
        write_whole(tmp_path / "a" / "b.json", "\ud800")  # no UTF-8: fails while it is written
    assert (tmp_path / "a" / "b.json").read_text() == "one"
    assert [file.name for file in (tmp_path / "a").iterdir()] == ["b.json"]


def test_two_files_are_written_both_or_none(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "b").mkdir()
    with pytest.raises(IsADirectoryError):
        write_all({tmp_path / "a": "new", tmp_path / "b": "new"})
    assert (tmp_path / "a").read_text() == "old"
    assert sorted(f.name for f in tmp_path.iterdir()) == ["a", "b"]


def test_a_folder_that_a_kill_left_between_the_two_renames_is_put_back(tmp_path: Path) -> None:
    (tmp_path / "front.old").mkdir()
    (tmp_path / "front.old" / "a").write_text("old")

    def fill() -> None:
        with whole_folder(tmp_path / "front"):
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        fill()
    assert (tmp_path / "front.old" / "a").read_text() == "old"  # nothing is lost before the new one is whole
