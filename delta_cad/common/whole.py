"""Files and folders that appear whole or not at all: written beside their place, then renamed."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import re
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path


def write_whole(path: Path, text: str) -> None:
    """Writes a text file whole or not at all; see `write_all`."""
    write_all({path: text})


def write_all(texts: Mapping[Path, str]) -> None:
    """Writes text files, all of them whole or none: each beside its place, then all renamed.

    Args:
        texts: Where to, replaced if it is there, its directory made if it is not -> the content.

    Raises:
        OSError: One cannot be written; nothing is left beside its place.
    """
    beside = {path: path.with_name(f".{path.name}.{os.getpid()}") for path in texts}
    try:
        for path, text in texts.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            beside[path].write_text(text, encoding="utf-8")
        for path in texts:
            if path.is_dir():
                raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        for path in texts:
            beside[path].replace(path)
    finally:
        for part in beside.values():
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


@contextmanager
def whole_folder(path: Path) -> Iterator[Path]:
    """Gives a folder to fill; at the end it takes the place of the one at `path`, if the filling did not fail.

    Two runs at once each fill a folder of their own, and the last to end has its whole one at `path`. A folder that a
    killed run left is cleared away by the next; one that is being filled is locked and left alone.

    Args:
        path: The folder that is wanted.

    Yields:
        An empty folder beside it.

    Raises:
        OSError: It cannot be written, or a file has its name.
    """
    old = path.with_name(path.name + ".old")
    if path.is_file():
        raise FileExistsError(errno.EEXIST, "a file has the folder's name", str(path))
    part, lock = _own_part(path)
    try:
        try:
            _clear_stale(path)
            yield part
            with _locked_parent(path):
                if not path.exists() and old.exists():  # killed between the two renames below
                    old.replace(path)
                shutil.rmtree(old, ignore_errors=True)
                if path.exists():
                    path.replace(old)
                part.replace(path)
                shutil.rmtree(old, ignore_errors=True)
        except BaseException:
            shutil.rmtree(part, ignore_errors=True)
            raise
    finally:
        os.close(lock)


def _own_part(path: Path) -> tuple[Path, int]:
    """A new folder beside a path under a name of this run alone, and its descriptor, which holds the lock on it."""
    while True:
        part = path.with_name(f"{path.name}.{os.getpid()}-{secrets.token_hex(4)}.part")
        part.mkdir(parents=True)
        try:
            lock = os.open(part, os.O_RDONLY)
        except FileNotFoundError:  # another run took it for stale before it was locked
            continue
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:  # likewise, it is just being cleared away
            os.close(lock)
            continue
        except OSError:
            pass  # a file system without locks: then nobody can lock it to clear it away either
        if part.exists():
            return part, lock
        os.close(lock)  # likewise, and it is gone


def _clear_stale(path: Path) -> None:
    """Removes what killed runs left beside a path: parts on which nobody holds a lock."""
    own = re.compile(re.escape(path.name) + r"\.\d+-[0-9a-f]{8}\.part")
    for part in path.parent.iterdir():
        if own.fullmatch(part.name):
            with contextlib.suppress(OSError):  # locked by a run that lives, or gone meanwhile
                lock = os.open(part, os.O_RDONLY)
                try:
                    fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    shutil.rmtree(part)
                finally:
                    os.close(lock)


@contextmanager
def _locked_parent(path: Path) -> Iterator[None]:
    """Holds off other runs that would put their folders to the same place at the same moment."""
    lock = os.open(path.parent, os.O_RDONLY)
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)
