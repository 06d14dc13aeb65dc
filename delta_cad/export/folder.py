"""A build appears whole or not at all.

Files are written into a hidden folder beside the target, on the same file system, and the whole folder is then put in
place in one step. Where the system can exchange two folders atomically that is used, so there is no moment without a
complete build under the name; elsewhere the old build is moved aside first, and put back on failure or, after a
kill, at the next run.

Hidden names beside `out/<name>`:
    .<name>.<token>.building  being written, or left by a killed run
    .<name>.<token>.previous  a replaced build on its way out
    .<name>.<token>.lock      locked as long as the run that owns the token lives
"""

from __future__ import annotations

import ctypes
import errno
import fcntl
import os
import re
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
REJECTED_SUFFIX = ".rejected"
AT_FDCWD = -100
RENAME_EXCHANGE = 2
NO_EXCHANGE = (errno.ENOSYS, errno.EINVAL, errno.ENOTSUP)
"""What the system answers when it, or this file system, cannot exchange two names."""


class FolderError(ValueError):
    """The name of a build is not safe as a folder name."""


@dataclass
class BuildFolder:
    """The folder being written.

    Attributes:
        path: Where the files go for now.
        rejected: Set it to True when a check fails: the folder then lands under `<name>.rejected`.
    """

    path: Path
    rejected: bool = False


@contextmanager
def output_folder(out: Path, name: str, *, rejected: bool = False) -> Iterator[BuildFolder]:
    """Folder that becomes `out/<name>` when the block ends without an exception, and vanishes otherwise.

    Args:
        out: Parent folder, made if missing.
        name: Name of the build: letters, digits, dot, dash, underscore.
        rejected: True: it lands in `out/<name>.rejected`; can still be set on the folder inside the block.

    Yields:
        The folder to write into.

    Raises:
        FolderError: The name is empty, hidden, not a plain file name, or ends in ".rejected".
    """
    if not NAME.fullmatch(name) or name.endswith(REJECTED_SUFFIX):
        raise FolderError(f"{name!r} is not the name of a build: letters, digits, dot, dash and underscore only")
    out.mkdir(parents=True, exist_ok=True)
    recover(out, name)
    token, lock = _own_token(out, name)
    folder = BuildFolder(_hidden(out, name, token, "building"), rejected)
    try:
        folder.path.mkdir()
        yield folder
        _sync(folder.path)
        _put_in_place(folder.path, out, name + REJECTED_SUFFIX if folder.rejected else name, token)
    finally:
        shutil.rmtree(folder.path, ignore_errors=True)
        _hidden(out, name, token, "lock").unlink(missing_ok=True)
        os.close(lock)


def recover(out: Path, name: str) -> None:
    """Puts back a build that a killed run had moved aside, and removes what killed runs left behind.

    Args:
        out: Parent folder.
        name: Name of the build; its ".rejected" twin is seen to as well.
    """
    for target in (name, name + REJECTED_SUFFIX):
        for token in _tokens(out, target, "previous"):
            aside = _hidden(out, target, token, "previous")
            with _claimed(out, name, token) as mine:
                if mine and (out / target).exists():
                    shutil.rmtree(aside, ignore_errors=True)
                elif mine:
                    aside.rename(out / target)
    for kind in ("building", "lock"):
        for token in _tokens(out, name, kind):
            with _claimed(out, name, token) as mine:
                if mine:
                    shutil.rmtree(_hidden(out, name, token, "building"), ignore_errors=True)
                    _hidden(out, name, token, "lock").unlink(missing_ok=True)


def _tokens(out: Path, name: str, kind: str) -> list[str]:
    """Tokens of the hidden entries of one kind, the latest first."""
    pattern = re.compile(rf"\.{re.escape(name)}\.([0-9a-f]{{16}})\.{kind}")
    found = [(path.lstat().st_mtime_ns, match[1]) for path in out.iterdir() if (match := pattern.fullmatch(path.name))]
    return [token for _, token in sorted(found, reverse=True)]


def _hidden(out: Path, name: str, token: str, kind: str) -> Path:
    return out / f".{name}.{token}.{kind}"


def _own_token(out: Path, name: str) -> tuple[str, int]:
    """A fresh token and the descriptor of its lock, which the system drops when the process ends, however it ends."""
    while True:
        token = secrets.token_hex(8)
        path = _hidden(out, name, token, "lock")
        descriptor = os.open(path, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o644)
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        if path.exists():
            return token, descriptor
        os.close(descriptor)  # another run took it for abandoned between the two lines above


@contextmanager
def _claimed(out: Path, name: str, token: str) -> Iterator[bool]:
    """Whether the run that owns a token has ended; if so its lock is held as long as the block lasts."""
    try:
        descriptor = os.open(_hidden(out, name, token, "lock"), os.O_RDWR)
    except FileNotFoundError:
        yield True
        return
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        yield False
    else:
        yield True
    finally:
        os.close(descriptor)


def _sync(folder: Path) -> None:
    """Brings the files to the disk before the name points to them."""
    for path in sorted(folder.rglob("*")):
        if path.is_file():
            descriptor = os.open(path, os.O_RDONLY)
            os.fsync(descriptor)
            os.close(descriptor)


def _put_in_place(built: Path, out: Path, name: str, token: str) -> None:
    """Renames the built folder onto its name; the old one survives until that has happened."""
    target = out / name
    aside = _hidden(out, name, token, "previous")
    if not target.exists():
        built.rename(target)
    elif _exchange(built, target):
        built.rename(aside)
    else:
        target.rename(aside)
        try:
            built.rename(target)
        except OSError:
            aside.rename(target)
            raise
    shutil.rmtree(aside, ignore_errors=True)


def _exchange(a: Path, b: Path) -> bool:
    """Exchanges two names in one step; False where the system cannot."""
    renameat2 = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
    if renameat2 is None:
        return False
    if renameat2(AT_FDCWD, os.fsencode(a), AT_FDCWD, os.fsencode(b), RENAME_EXCHANGE) == 0:
        return True
    code = ctypes.get_errno()
    if code in NO_EXCHANGE:
        return False
    raise OSError(code, os.strerror(code), str(b))
