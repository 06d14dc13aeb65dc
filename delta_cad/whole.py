"""Files and folders that appear whole or not at all: written beside their place, then renamed."""

from __future__ import annotations

import contextlib
import errno
import os
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

    Args:
        path: The folder that is wanted.

    Yields:
        An empty folder beside it.

    Raises:
        OSError: It cannot be written, or a file has its name.
    """
    part, old = path.with_name(path.name + ".part"), path.with_name(path.name + ".old")
    if path.is_file():
        raise FileExistsError(errno.EEXIST, "a file has the folder's name", str(path))
    shutil.rmtree(part, ignore_errors=True)  # of a run that was killed
    part.mkdir(parents=True)
    try:
        yield part
    except BaseException:
        shutil.rmtree(part)
        raise
    if not path.exists() and old.exists():  # killed between the two renames below
        old.replace(path)
    shutil.rmtree(old, ignore_errors=True)
    if path.exists():
        path.replace(old)
    part.replace(path)
    shutil.rmtree(old, ignore_errors=True)
