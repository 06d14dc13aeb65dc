"""A folder that appears whole or not at all: filled beside its place, then renamed."""

from __future__ import annotations

import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


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
        raise FileExistsError(17, "a file has the folder's name", str(path))
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
