"""Files and folders that appear whole or not at all, and files of lines that outlive a kill."""

import errno
import fcntl
import os
import subprocess
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from delta_cad.common import files
from delta_cad.common.files import RECORD, AppendLog, FileInUseError, require_room, whole_folder, write_all, write_whole


def held(folder: Path) -> list[str]:
    """Names in a folder but of the record of what was written."""
    return sorted(path.name for path in folder.iterdir() if path.name != RECORD)


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
    with whole_folder(target) as folder:
        (folder / "a").write_text("old")

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
from delta_cad.common.files import whole_folder
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
    assert held(tmp_path / "front") == ["b"]
    process.communicate(timeout=30)
    assert process.returncode == 0
    assert held(tmp_path / "front") == ["a"]  # the last to end, and all of it
    assert [path.name for path in tmp_path.iterdir()] == ["front"]


def test_many_at_once_leave_one_whole_folder(tmp_path: Path) -> None:
    def fill(number: int) -> None:
        with whole_folder(tmp_path / "front") as folder:
            for name in "ab":
                (folder / name).write_text(f"{number}")

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(fill, range(100)))
    assert [path.name for path in tmp_path.iterdir()] == ["front"]
    assert held(tmp_path / "front") == ["a", "b"]
    assert len({(tmp_path / "front" / name).read_text() for name in "ab"}) == 1


def test_folders_of_others_are_no_rests(tmp_path: Path) -> None:
    token = "0123456789abcdef"
    names = ["front.part", f".front.x.{token}.part", f".frontier.{token}.part", f".front.{token}"]
    for name in names:
        (tmp_path / name).mkdir()
    (tmp_path / f".front.{token}.part").mkdir()
    with whole_folder(tmp_path / "front"):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*names, "front"])


def test_a_part_that_another_run_clears_before_it_is_locked_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At each of the three moments in which it may happen."""
    made: list[Path] = []
    real_open, real_flock = os.open, fcntl.flock

    def opened(path: str | Path, flags: int, mode: int = 0o777) -> int:
        if str(path).endswith(".part") and len(made) < 4:
            made.append(Path(path))
            if len(made) == 1:
                made[0].rmdir()
        return real_open(path, flags, mode)

    def locked(number: int, how: int) -> None:
        if len(made) == 2:
            raise BlockingIOError
        if len(made) == 3 and made[2].exists():
            made[2].rmdir()
        real_flock(number, how)

    monkeypatch.setattr("delta_cad.common.files.os.open", opened)
    monkeypatch.setattr("delta_cad.common.files.fcntl.flock", locked)
    with whole_folder(tmp_path / "front") as folder:
        assert folder == made[3]
        (folder / "a").write_text("")
    assert held(tmp_path / "front") == ["a"]


def test_a_file_system_without_locks_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr("delta_cad.common.files.fcntl.flock", none)
    stale = tmp_path / ".front.0123456789abcdef.part"
    stale.mkdir()
    with whole_folder(tmp_path / "front") as folder:
        (folder / "a").write_text("")
    assert sorted(path.name for path in tmp_path.iterdir()) == [stale.name, "front"]  # nobody knows who fills it


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


def test_a_part_of_a_file_that_a_kill_left_is_cleared_by_the_next_write(tmp_path: Path) -> None:
    (tmp_path / ".a.0123456789abcdef.part").write_text("half")
    write_whole(tmp_path / "a", b"\x00whole")
    assert {f.name: f.read_bytes() for f in tmp_path.iterdir()} == {"a": b"\x00whole"}


def test_what_is_written_is_on_the_disk_before_it_gets_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[tuple[str, int]] = []
    monkeypatch.setattr(
        "delta_cad.common.files.os.fsync",
        lambda n: synced.append((Path(os.readlink(f"/proc/self/fd/{n}")).name, os.fstat(n).st_size)),
    )
    write_whole(tmp_path / "a", "1234")
    assert synced[0][0].startswith(".a.")
    assert synced[0][1] == 4
    assert synced[1][0] == tmp_path.name


@pytest.mark.parametrize("write", [lambda path: write_whole(path, "a"), require_room])
def test_a_pipe_or_a_device_is_not_replaced(tmp_path: Path, write: Callable[[Path], None]) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "device").symlink_to(os.devnull)
    for name in ("pipe", "device"):
        with pytest.raises(OSError, match="is no plain file") as caught:
            write(tmp_path / name)
        assert caught.value.filename == str(tmp_path / name)
    assert (tmp_path / "pipe").is_fifo()
    assert (tmp_path / "device").is_symlink()


def test_lines_are_read_whole_and_appended_after_the_last_whole_one(tmp_path: Path) -> None:
    path = tmp_path / "run" / "lines"
    with AppendLog(path) as lines:
        assert lines.found == []
        lines.begin(["key"])
        lines.append("a\u2028b\x85c")  # line ends to str.splitlines, not to us
    with path.open("ab") as file:
        file.write(b'{"half')
    with AppendLog(path) as lines:
        assert lines.found == ["key", "a\u2028b\x85c"]
        assert path.read_bytes().endswith(b"half")  # opening changes nothing
        lines.append("d")
    assert path.read_text(encoding="utf-8").split("\n") == ["key", "a\u2028b\x85c", "d", ""]
    with AppendLog(path) as lines:
        with pytest.raises(ValueError, match="line feed"):
            lines.append("e\nf")
        lines.remove()
        assert list(path.parent.iterdir()) == []
        path.write_text("another run's")
        lines.remove()  # closed by now
        assert path.exists()
        with pytest.raises(ValueError, match="closed"):
            lines.append("g")


def test_lines_stay_as_they_were_when_a_new_beginning_fails(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    with AppendLog(tmp_path / "lines") as lines:
        lines.begin(["a"])
        with monkeypatch.context() as patch:
            patch.setattr("delta_cad.common.files.os.pwrite", full)
            with pytest.raises(OSError, match="No space"):
                lines.begin(["b"])
        lines.append("c")
    assert (tmp_path / "lines").read_text() == "a\nc\n"
    assert [path.name for path in tmp_path.iterdir()] == ["lines"]


def test_a_line_that_a_full_disk_cut_off_is_gone_before_the_next(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = os.pwrite

    def half(number: int, content: bytes, start: int) -> int:
        if len(content) < 5 and start < 10:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(number, content[:5], start)

    with AppendLog(tmp_path / "lines") as lines:
        lines.begin(["a"])
        with monkeypatch.context() as patch:
            patch.setattr("delta_cad.common.files.os.pwrite", half)
            with pytest.raises(OSError, match="No space"):
                lines.append("12345678")
            lines.append("1234567890123")  # five bytes at a time: whole nevertheless
        lines.append("b")
    assert (tmp_path / "lines").read_text() == "a\n1234567890123\nb\n"


def test_lines_belong_to_one_run_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "lines"
    with AppendLog(path) as lines:
        for _ in range(2):
            with pytest.raises(FileInUseError):
                AppendLog(path)
            lines.begin(["a"])  # the lock goes over to the new file
    with AppendLog(path) as lines:
        assert lines.found == ["a"]


def test_lines_of_a_pipe_are_refused(tmp_path: Path) -> None:
    """Who opens it holds it open for writing himself, and would wait for his own end."""
    os.mkfifo(tmp_path / "lines")
    with pytest.raises(OSError, match="is no plain file") as caught:
        AppendLog(tmp_path / "lines")
    assert caught.value.filename == str(tmp_path / "lines")


def test_lines_replaced_between_opening_and_locking_are_opened_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "lines"
    path.write_text("old\n")
    flock, calls = fcntl.flock, []

    def replaced_first(descriptor: int, mode: int) -> None:
        if not calls and os.path.samestat(os.fstat(descriptor), path.stat()):
            calls.append(descriptor)
            (tmp_path / "other").write_text("new\n")
            (tmp_path / "other").replace(path)
        flock(descriptor, mode)

    monkeypatch.setattr("delta_cad.common.files.fcntl.flock", replaced_first)
    with AppendLog(path) as lines:
        assert lines.found == ["new"]
        assert len(calls) == 1
        lines.append("more")
    assert path.read_text() == "new\nmore\n"


WRITER = """
import sys
from pathlib import Path
from delta_cad.common.files import AppendLog
with AppendLog(Path(sys.argv[1])) as lines:
    lines.begin(held := lines.found)
    for k in range(len(held), 10**9):
        lines.append(str(k) * 50)
        print(flush=True)
        if k % 7 == 0:
            lines.begin(str(n) * 50 for n in range(k + 1))
"""


def test_lines_survive_kills_at_any_moment(tmp_path: Path) -> None:
    path, held = tmp_path / "lines", 0
    for number in range(8):
        with subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout
            for _ in range(1 + 3 * number):
                process.stdout.readline()
            process.kill()
        with AppendLog(path) as lines:
            assert lines.found == [str(k) * 50 for k in range(len(lines.found))]
            assert len(lines.found) >= held + 1 + 3 * number
            held = len(lines.found)
    assert [file.name for file in tmp_path.iterdir()] == ["lines"]


def test_a_run_that_only_looked_for_room_takes_the_folder_away_from_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "out" / "folder"
    monkeypatch.setattr(files, "_restore", lambda _: path.parent.rmdir())  # between lock and list of another run
    require_room(path, folder=True)
    assert not path.parent.exists()


def test_room_is_made_sure_of_before_the_work_and_nothing_is_left(tmp_path: Path) -> None:
    require_room(tmp_path / "a" / "file")
    require_room(tmp_path / "a" / "b" / "folder", folder=True)
    assert list(tmp_path.iterdir()) == []
    write_whole(tmp_path / "a" / "file", "old")
    require_room(tmp_path / "a" / "file")
    with pytest.raises(FileExistsError, match="file, which no run wrote"):
        require_room(tmp_path / "a", folder=True)
    with pytest.raises(FileExistsError) as caught:
        require_room(tmp_path / "a" / "file", folder=True)
    assert caught.value.filename == str(tmp_path / "a" / "file")
    with pytest.raises(IsADirectoryError) as caught_too:
        require_room(tmp_path / "a")
    assert caught_too.value.filename == str(tmp_path / "a")
    with pytest.raises(NotADirectoryError) as below:
        require_room(tmp_path / "a" / "file" / "below" / "name")
    assert below.value.filename == str(tmp_path / "a" / "file" / "below" / "name")
    assert {path.name: path.read_text() for path in (tmp_path / "a").iterdir()} == {"file": "old"}


@pytest.mark.parametrize("call", ["room", "file", "folder"])
def test_folders_made_for_what_was_not_written_are_taken_away(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    """As where the machine's build is interrupted: nothing was written, and nothing is there."""

    def stopped(*_: object) -> int:
        raise KeyboardInterrupt

    def run() -> None:
        with whole_folder(tmp_path / "out" / "a" / "folder"):
            stopped()

    monkeypatch.setattr("delta_cad.common.files.os.pwrite", stopped)
    path = tmp_path / "out" / "a" / "file"
    with pytest.raises(KeyboardInterrupt):
        run() if call == "folder" else require_room(path) if call == "room" else write_whole(path, "x")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_takes_no_files_is_refused() -> None:
    """The system says that there is no such file, as where another run has just cleared a part away."""
    for call in (require_room, AppendLog, lambda path: write_whole(path, "")):
        with pytest.raises(FileNotFoundError) as caught:
            call(Path("/proc/none"))
        assert caught.value.filename == "/proc/none"


@pytest.mark.parametrize("call", ["room", "file", "folder", "begin", "append"])
def test_a_full_disk_is_named_by_the_path_that_was_requested(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, call: str
) -> None:
    """Writing names no path, and a part has a name that nobody knows."""

    def full(*_: object) -> int:
        raise OSError(errno.ENOSPC, "No space left on device")

    path, lines = tmp_path / "a", AppendLog(tmp_path / "lines") if call in ("begin", "append") else None
    monkeypatch.setattr("delta_cad.common.files.os.pwrite", full)

    def run() -> None:
        if lines is not None:
            lines.begin([""]) if call == "begin" else lines.append("")
        elif call == "folder":
            with whole_folder(path):
                full()
        else:
            require_room(path) if call == "room" else write_whole(path, "x")

    with pytest.raises(OSError, match="No space") as caught:
        run()
    assert caught.value.filename == str(path if lines is None else lines.path)
    if lines is not None:
        lines.close()
    assert not any(file.name.endswith(".part") for file in tmp_path.iterdir())


def test_a_file_of_a_folder_is_named_by_where_it_was_to_be(tmp_path: Path) -> None:
    def fill() -> None:
        with whole_folder(tmp_path / "front") as folder:
            (folder / "none" / "a").write_text("")

    with pytest.raises(FileNotFoundError) as caught:
        fill()
    assert caught.value.filename == str(tmp_path / "front" / "none" / "a")
    with pytest.raises(OSError, match="elsewhere") as other, whole_folder(tmp_path / "front"):
        raise OSError(errno.EIO, "no luck", "/elsewhere/b")
    assert other.value.filename == "/elsewhere/b"
