"""The folder of a build, `out/<name>` or `out/<name>.rejected`: it appears complete or not at all."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from delta_cad.common.files import recover, refuse_foreign_files, whole_folder

ARCHIVE = "everything.zip"
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]*")
_REJECTED_SUFFIX = ".rejected"


class FolderError(ValueError):
    """The name of a build is not safe as a folder name."""


@dataclass
class _BuildFolder:
    """The folder being written.

    Attributes:
        path: Where the files go for now.
        rejected: Set it to True when a check fails: the folder then lands under `<name>.rejected`.
    """

    path: Path
    rejected: bool = False


@contextmanager
def output_folder(out: Path, name: str) -> Iterator[_BuildFolder]:
    """Folder that becomes `out/<name>` when the block ends without an exception, and vanishes otherwise.

    Args:
        out: Parent folder, made if missing.
        name: Name of the build: letters, digits, dot, dash, underscore.

    Yields:
        The folder to write into.

    Raises:
        FolderError: The name is empty, hidden, not a plain file name, or ends in ".rejected".
        OSError: It cannot be written.
    """
    if not NAME.fullmatch(name) or name.endswith(_REJECTED_SUFFIX):
        raise FolderError(f"{name!r} is not the name of a build: letters, digits, dot, dash and underscore only")
    good, bad = out / name, out / (name + _REJECTED_SUFFIX)
    folder = _BuildFolder(good)
    refuse_foreign_files(bad)
    with whole_folder(good, to=lambda: bad if folder.rejected else good) as folder.path:
        recover(bad)
        yield folder


def write_archive(folder: Path, name: str) -> None:
    """Packs all files of a finished folder but its manifest into `everything.zip`, to send or download in one piece.

    Args:
        folder: The folder; the archive is written into it and does not hold itself.
        name: Name of the build: the folder within the archive.
    """
    from delta_cad.export.meshes import write_package

    files = sorted(path for path in folder.rglob("*") if path.is_file() and path != folder / ARCHIVE)
    write_package(
        folder / ARCHIVE, {f"{name}/{path.relative_to(folder).as_posix()}": path.read_bytes() for path in files}
    )
