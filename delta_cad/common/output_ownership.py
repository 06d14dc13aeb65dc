"""What a run wrote into a folder, kept in it: a folder that holds anything else is not replaced, and nothing is lost.

A build says it in its manifest; every other folder has a record of its own, as has a folder that a second command
added to a build.
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
import shutil
from collections.abc import Iterator, Mapping
from pathlib import Path

from delta_cad.common.reading import ReadError, read_json

RECORD = ".written.json"
RECORDS = (RECORD, "manifest.json")  # that of a build; either has name -> SHA-256 under `files`
# What the desktops of macOS and Windows put into every folder that somebody looks at.
NOBODYS = {".DS_Store", "Thumbs.db", "desktop.ini"}


class ForeignFilesError(FileExistsError):
    """A folder holds what no run wrote; the message says what to do."""


def write_record(folder: Path) -> None:
    """Writes down what a folder holds, if its manifest does not say so."""
    if not any((folder / name).is_file() for name in RECORDS):
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
            for record in RECORDS:
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
            elif entry.name not in NOBODYS:
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
