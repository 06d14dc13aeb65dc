"""Files and folders that appear whole or not at all, and files of lines that outlive a killed run.

One scheme serves all three. What is written stands beside its place as `.NAME.TOKEN.part`, locked as long as its run
lives, and is renamed when it is whole and on the disk. Where the system can exchange two folders in one step there is
no moment without a whole one at the name; elsewhere the old one is `.NAME.previous` for the moment between two renames,
and the next run puts it back if a kill fell into that moment. The next run also removes parts that nobody holds.

What a run wrote into a folder stands in a record in it: a folder that holds anything else is not replaced, and nothing
is lost. A build says it in its manifest; every other folder has a record of its own, as has a folder that a second
command added to a build.
"""

from __future__ import annotations

import contextlib
import ctypes
import errno
import hashlib
import json
import os
import re
import secrets
import shutil
import stat
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Self

from delta_cad.common.reading import BINARY, ReadError, read_json

# Absent on Windows: locks, and a descriptor of a folder.
fcntl: Any = import_module("fcntl") if find_spec("fcntl") else None
_OPENS_FOLDERS = hasattr(os, "O_DIRECTORY")
_NO_LOCKS = "note: this system has no file locks: run one command at a time on a folder of results"
_AT_FDCWD, _RENAME_EXCHANGE = -100, 2  # <fcntl.h> and <linux/fs.h>
_NO_PLAIN_FILE = "is no plain file"
# What a system answers when it, or this file system, cannot exchange two names.
_NO_EXCHANGE = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)

RECORD = ".written.json"
_RECORDS = (RECORD, "manifest.json")  # that of a build; either has name -> SHA-256 under `files`
# What the desktops of macOS and Windows put into every folder that somebody looks at.
_NOBODYS = {".DS_Store", "Thumbs.db", "desktop.ini"}


class FileInUseError(OSError):
    """Another run holds the lock on the file."""


def write_whole(path: Path, content: str | bytes) -> None:
    """Writes one file whole or not at all; see `write_all`."""
    write_all({path: content})


def write_all(contents: Mapping[Path, str | bytes]) -> None:
    """Writes files, all of them whole or none: each beside its place and to the disk, then all renamed.

    Args:
        contents: Where to, replaced if it is there, its folder made if it is not -> the content; text in UTF-8.

    Raises:
        OSError: One cannot be written; nothing is left beside its place.
        UnicodeEncodeError: A text is no Unicode; nothing is touched.
    """
    encoded = {path: text.encode() if isinstance(text, str) else text for path, text in contents.items()}
    parts: dict[Path, tuple[Path, int]] = {}
    made = _missing(encoded)
    try:
        for path, content in encoded.items():
            with _naming(path):
                _require_kind(path, folder=False)
                recover(path)
                parts[path] = _, lock = _own_part(path, os.O_CREAT | os.O_EXCL | os.O_RDWR)
                _write(lock, content, 0)
                os.fsync(lock)
        for path, (part, _) in parts.items():
            with _naming(path):
                part.replace(path)
        for folder in {path.parent for path in parts}:
            with _naming(folder):
                _sync(folder)
    finally:
        for part, lock in parts.values():
            part.unlink(missing_ok=True)
            os.close(lock)
        _take_away(made)


@contextmanager
def whole_folder(path: Path, to: Callable[[], Path] | None = None) -> Iterator[Path]:
    """Gives a folder to fill; at the end it takes the place of the one at `path`, if the filling did not fail.

    One that holds what no run wrote is not replaced. Two runs at once each fill a folder of their own, and the last to
    end has its whole one at `path`.

    Args:
        path: The folder that is wanted.
        to: Asked at the end for another place in the same parent; None: `path`.

    Yields:
        An empty folder beside it.

    Raises:
        OSError: It cannot be written, a file has its name, or what is there is not ours.
    """
    made = _missing([path])
    try:
        yield from _filled(path, to)
    finally:
        _take_away(made)


def _filled(path: Path, to: Callable[[], Path] | None) -> Iterator[Path]:
    """See `whole_folder`; the folders above it stay."""
    with _naming(path):
        _require_kind(path, folder=True)
        recover(path)
        part, lock = _own_part(path, os.O_RDONLY)
    try:
        with _naming(path, part):
            yield part
            write_record(part)
            for file in sorted(part.rglob("*")):
                if file.is_file():
                    _sync(file)
            target = to() if to else path
            with _locked_parent(path):
                _restore(target)
                refuse_foreign_files(target)
                _put_in_place(part, target)
    finally:
        if part.is_symlink():  # which the name was: what it leads to is somebody else's
            part.unlink()
        remove(part)  # what failed, or the replaced folder after an exchange
        os.close(lock)


def require_room(path: Path, *, folder: bool = False) -> None:
    """Makes sure, before the work for it, that a path can be written: makes a file beside it and removes it.

    Args:
        path: Where to; parents that are not there are made, and taken away again.
        folder: Whether it will be a folder, else a file.

    Raises:
        OSError: It cannot be written, a file has the folder's name, or a folder the file's, or the folder holds what
            no run wrote; the path is named.
    """
    made = _missing([path])
    try:
        with _naming(path):
            _require_kind(path, folder)
            recover(path)
            part, lock = _own_part(path, os.O_CREAT | os.O_EXCL | os.O_RDWR)
            try:
                _write(lock, b"room", 0)  # a full disk lets files be made, but not written
            finally:
                part.unlink(missing_ok=True)
                os.close(lock)
    finally:
        _take_away(made)


def _missing(paths: Iterable[Path]) -> list[Path]:
    """The folders above some paths that are not there yet, the lowest first."""
    above = {parent for path in paths for parent in path.parents if not parent.exists()}
    return sorted(above, key=lambda parent: len(parent.parts), reverse=True)


def _take_away(folders: Iterable[Path]) -> None:
    """Removes those of the folders that hold nothing, as where nothing was written into them after all."""
    for folder in folders:
        with contextlib.suppress(OSError):  # it holds what was written, or somebody else put something there
            folder.rmdir()


def recover(path: Path) -> None:
    """Puts back a folder that a killed run had moved aside, and removes the parts that killed runs left beside it.

    Args:
        path: The folder or file that the runs wrote; its parent is made if it is not there.
    """
    with _locked_parent(path):
        _restore(path)
    _clear_stale(path)


class AppendLog:
    """A file of lines, appended as they come by one run at a time.

    The file is locked as long as it is open; the system releases the lock of a process that was killed. A kill at any
    moment leaves every line appended before, and at most the beginning of one more, without its end. That is not
    read, and is cut away only when the next line is appended: opening changes nothing.

    Attributes:
        path: The file, made if it is not there.
        found: The whole lines that it held when it was opened, without their ends.
    """

    def __init__(self, path: Path) -> None:
        """Opens and locks the file, and reads its whole lines.

        Args:
            path: The file; its folder is made if it is not there.

        Raises:
            FileInUseError: Another run has it open.
            OSError: It cannot be read or written.
        """
        with _naming(path):
            recover(path)
            self.path = path
            self._descriptor: int | None = _opened_alone(path)
            try:
                content = path.read_bytes()
            except BaseException:
                self.close()
                raise
        self._end = content.rfind(b"\n") + 1
        self.found = content[: self._end].decode("utf-8", "replace").split("\n")[:-1]

    def begin(self, lines: Iterable[str]) -> None:
        """Puts lines in place of all the file holds, in one step: a kill leaves the old ones or these.

        Args:
            lines: The lines without their ends; none holds a line feed.

        Raises:
            OSError: They cannot be written; the file is as it was.
        """
        content = b"".join(_encoded(line) for line in lines)
        with _naming(self.path):
            part, descriptor = _own_part(self.path, os.O_CREAT | os.O_EXCL | os.O_RDWR)
            try:
                _write(descriptor, content, 0)
                os.fsync(descriptor)
                part.replace(self.path)
            except BaseException:
                part.unlink(missing_ok=True)
                os.close(descriptor)
                raise
        self.close()
        self._descriptor, self._end, self.found = descriptor, len(content), []

    def append(self, line: str) -> None:
        """Appends one line; when this returns, a kill of the process cannot lose it.

        Args:
            line: The line without its end; it holds no line feed.

        Raises:
            OSError: It cannot be written; what was appended before stands, and the next line may be tried.
            ValueError: The file is closed, or the line holds a line feed.
        """
        content = _encoded(line)
        if self._descriptor is None:
            raise ValueError(f"{self.path.name}: is closed")
        with _naming(self.path):
            if os.fstat(self._descriptor).st_size > self._end:  # what a kill or a full disk left of a line
                os.ftruncate(self._descriptor, self._end)
            _write(self._descriptor, content, self._end)
        self._end += len(content)

    def close(self) -> None:
        """Closes the file, which stays, and gives up its lock."""
        if self._descriptor is not None:
            os.close(self._descriptor)
            self._descriptor = None

    def remove(self) -> None:
        """Takes the file away and closes it; nothing, if it is closed: it may be another run's by now."""
        if self._descriptor is not None:
            self.path.unlink(missing_ok=True)
            self.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


@contextmanager
def _naming(path: Path, part: Path | None = None) -> Iterator[None]:
    """Names the path in what the system refuses: writing names none, and of a part nobody has heard."""
    try:
        yield
    except OSError as error:
        where = path if error.filename is None else Path(os.fsdecode(error.filename))
        if part is not None and where.is_relative_to(part):
            where = path / where.relative_to(part)
        elif where.parent == path.parent or path.is_relative_to(where):  # a part beside it, or a folder above it
            where = path
        if error.strerror is None:  # without a name it has words only, which a name would take away
            error.errno, error.strerror = errno.EIO, str(error)
        error.filename = str(where)
        raise


def _require_kind(path: Path, folder: bool) -> None:
    """Refuses a place that has what cannot be replaced."""
    if folder and path.exists() and not path.is_dir():
        raise FileExistsError(errno.EEXIST, "a file has the folder's name", str(path))
    if not folder and path.is_dir():
        raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR), str(path))
    if not folder and path.exists() and not path.is_file():  # a pipe, or a device: renaming would take it away
        raise OSError(errno.EINVAL, _NO_PLAIN_FILE, str(path))
    if folder and path.is_dir():
        with _locked_parent(path):  # else another run may put its own there between the record and the files
            refuse_foreign_files(path)


def _encoded(line: str) -> bytes:
    if "\n" in line:
        raise ValueError("a line holds a line feed")
    return line.encode() + b"\n"


def _write(descriptor: int, content: bytes, start: int) -> None:
    """Writes all bytes from a position of the file on, in as many steps as the system takes."""
    rest = memoryview(content)
    while rest:
        if hasattr(os, "pwrite"):
            done = os.pwrite(descriptor, rest, start)
        else:  # on Windows
            os.lseek(descriptor, start, os.SEEK_SET)
            done = os.write(descriptor, rest)
        start, rest = start + done, rest[done:]


def _sync(path: Path) -> None:
    """Brings a file, or the names in a folder, to the disk."""
    if (folder := path.is_dir()) and not _OPENS_FOLDERS:
        return
    how = os.O_RDONLY if folder or _OPENS_FOLDERS else os.O_RDWR  # Windows syncs what it may write
    descriptor = os.open(path, how)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)


def _opened(path: Path, flags: int) -> int:
    """Descriptor of a file or folder; of the null device in place of a folder where the system opens none."""
    if path.is_dir() and not _OPENS_FOLDERS:
        return os.open(os.devnull, os.O_RDWR)
    return os.open(path, flags | BINARY, 0o666)


def _opened_alone(path: Path) -> int:
    """Descriptor of the file at a path, which holds the lock on it."""
    while True:
        descriptor = _opened(path, os.O_CREAT | os.O_RDWR)
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):  # reading a pipe would wait for who writes: for us
            os.close(descriptor)
            raise OSError(errno.EINVAL, _NO_PLAIN_FILE, str(path))
        if lock(descriptor) is False:
            os.close(descriptor)
            raise FileInUseError(errno.EWOULDBLOCK, "another run is writing it", str(path))
        if _is_at(descriptor, path):
            return descriptor
        os.close(descriptor)  # the run that had it removed or replaced it between opening and locking


def _own_part(path: Path, flags: int) -> tuple[Path, int]:
    """A new part beside a path under a name of this run alone, and its descriptor, which holds the lock on it.

    With `O_CREAT` in the flags it is a file, else a folder.
    """
    while True:
        part = path.with_name(f".{path.name}.{secrets.token_hex(8)}.part")
        try:
            if not flags & os.O_CREAT:
                part.mkdir()
            descriptor = _opened(part, flags)
        except FileNotFoundError:
            if flags & os.O_CREAT and path.parent.exists():  # one like /proc that takes no files
                raise
            path.parent.mkdir(parents=True, exist_ok=True)  # a run that only looked for room took it away
            continue  # or another took the part for stale before it was locked
        if lock(descriptor) is not False and _is_at(descriptor, part):
            return part, descriptor
        os.close(descriptor)  # likewise: it is just being cleared away, or is gone


def lock(descriptor: int, wait: bool = False) -> bool | None:
    """Locks an open file or folder until it is closed.

    Args:
        descriptor: Of the file.
        wait: Whether to wait until another process gives its lock up.

    Returns:
        Whether it is locked now; None where the file system, or the system, knows no locks: nobody can claim it then.
    """
    if fcntl is None:
        if not _reported:
            from delta_cad.common.console import refuse  # no source of compiled code

            _reported.append(_NO_LOCKS)
            refuse(_NO_LOCKS, 0)
        return None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        return False
    except OSError:
        return None
    return True


_reported: list[str] = []
"""That there are no locks, once it was said: one line a process."""


def _is_at(descriptor: int, path: Path) -> bool:
    """Whether the open file is still the one at the path."""
    try:
        return not (_OPENS_FOLDERS or path.is_file()) or os.path.samestat(os.fstat(descriptor), path.stat())
    except FileNotFoundError:
        return False


def _clear_stale(path: Path) -> None:
    """Removes what killed runs left beside a path: parts on which nobody holds a lock."""
    own = re.compile(rf"\.{re.escape(path.name)}\.[0-9a-f]{{16}}\.part")
    for part in _listed(path.parent):
        if own.fullmatch(part.name):
            with contextlib.suppress(OSError):  # locked by a run that lives, or gone meanwhile, or no locks here
                descriptor = _opened(part, os.O_RDONLY)
                try:
                    if lock(descriptor):
                        shutil.rmtree(part) if part.is_dir() else part.unlink()
                finally:
                    os.close(descriptor)


def _listed(folder: Path) -> list[Path]:
    """What is in a folder; nothing where a run that only looked for room took it away in between."""
    with contextlib.suppress(FileNotFoundError):
        return list(folder.iterdir())
    return []


@contextmanager
def _locked_parent(path: Path) -> Iterator[None]:
    """Makes the parent and holds off other runs that would put their folders to the same place at the same moment."""
    while True:
        path.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileNotFoundError):  # a run that only looked for room took it away in between
            descriptor = _opened(path.parent, os.O_RDONLY)
            break
    try:
        lock(descriptor, wait=True)
        yield
    finally:
        os.close(descriptor)


def _previous(path: Path) -> Path:
    return path.with_name(f".{path.name}.previous")


def _restore(path: Path) -> None:
    """Mends a kill between the two renames: with the parent locked, the old folder gets its name back, or goes."""
    if (previous := _previous(path)).exists():
        if path.exists():
            shutil.rmtree(previous, ignore_errors=True)
        else:
            previous.rename(path)


def _put_in_place(part: Path, target: Path) -> None:
    """Renames a whole folder onto its name, with the parent locked; the old one lives until that has happened."""
    if not target.exists():
        part.rename(target)
    elif not _exchange(part, target):
        target.rename(_previous(target))
        try:
            part.rename(target)
        except OSError:
            _previous(target).rename(target)
            raise
        shutil.rmtree(_previous(target), ignore_errors=True)
    _sync(target.parent)


def _exchange(a: Path, b: Path) -> bool:
    """Exchanges two names in one step; False where the system cannot."""
    library = None if os.name == "nt" else ctypes.CDLL(None, use_errno=True)
    if (renameat2 := getattr(library, "renameat2", None)) is None:
        return False
    if renameat2(_AT_FDCWD, os.fsencode(a), _AT_FDCWD, os.fsencode(b), _RENAME_EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in _NO_EXCHANGE:
        return False
    raise OSError(code, os.strerror(code), str(b))


class ForeignFilesError(FileExistsError):
    """A folder holds what no run wrote; the message says what to do."""


def write_record(folder: Path) -> None:
    """Writes down what a folder holds, if its manifest does not say so."""
    if not any((folder / name).is_file() for name in _RECORDS):
        files = {name: path.read_bytes() for name, path in sorted(_files(folder, ""))}
        (folder / RECORD).write_text(record_with(folder, files), encoding="utf-8")


def record_with(folder: Path, contents: Mapping[str, bytes]) -> str:
    """Gives the record of a folder with some of its files written anew, to be written together with them.

    Args:
        folder: The folder, with or without a record.
        contents: Name in the folder -> what will stand there.
    """
    try:
        files = dict(read_json(folder / RECORD)["files"])
    except (ReadError, LookupError, TypeError, ValueError):
        files = {}
    files |= {name: {"sha256": hashlib.sha256(content).hexdigest()} for name, content in contents.items()}
    return json.dumps({"files": files}, indent=1) + "\n"


def refuse_foreign_files(folder: Path) -> None:
    """Refuses to replace a folder with a file in it that no run wrote, or that was changed since.

    Args:
        folder: The folder; one that is not there or is empty is nobody's.

    Raises:
        ForeignFilesError: The message names the first such file.
    """
    if not folder.is_dir():
        return
    known: dict[str, str] = {}
    records: dict[str, bool] = {}  # place of a record that may be there -> whether it is one
    names = []
    for name, path in _files(folder, ""):  # names first: of a whole disk nothing is read but its records
        for place in reversed(Path(name).parents):  # what was added later, farther below, says more
            for record in _RECORDS:
                if (at := (place / record).as_posix()) not in records:
                    records[at] = _take_up(known, folder, place / record)
        if not (name in known or records.get(name, False)):
            raise _other(folder, name, "which no run wrote here")
        names.append((name, path))
    for name, path in names:
        if name in known and (path.is_symlink() or _sha256(path) != known[name]):
            raise _other(folder, name, "which was changed since it was written")


def _other(folder: Path, name: str, why: str) -> ForeignFilesError:
    return ForeignFilesError(
        errno.EEXIST, f"holds {name}, {why}; move it away, or give another place, to lose nothing", str(folder)
    )


def _take_up(known: dict[str, str], folder: Path, record: Path) -> bool:
    """Adds what a record says of the files beside and below it; whether it is there and can be read as one."""
    try:
        files = read_json(folder / record)["files"]
        known.update({(record.parent / name).as_posix(): str(one["sha256"]) for name, one in files.items()})
    except (ReadError, AttributeError, LookupError, TypeError):
        return False
    return True


def _files(folder: Path, above: str) -> Iterator[tuple[str, Path]]:
    """Relative names and places of all that is no folder, but of what nobody put there."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir(follow_symlinks=False):
                yield from _files(Path(entry.path), f"{above}{entry.name}/")
            elif entry.name not in _NOBODYS:
                yield above + entry.name, Path(entry.path)


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def remove(folder: Path) -> None:
    """Removes a folder, whole even if Ctrl-C comes meanwhile, which then takes effect."""
    try:
        shutil.rmtree(folder, ignore_errors=True)
    except KeyboardInterrupt:
        remove(folder)
        raise
