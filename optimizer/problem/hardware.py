"""The hardware of a requirements file: table `[hardware]`, the entries of a design file's hardware.

An entry is one value, or a list of what may be used. Who chooses no hardware takes the first of each list.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from delta_cad.design import DesignError, hardware_from_dict


def first_hardware(entries: Mapping[str, Any]) -> dict[str, Any]:
    """Takes the first of what may be used of each entry."""
    return {entry: value[0] if isinstance(value, list) and value else value for entry, value in entries.items()}


def check_hardware(entries: Mapping[str, Any], file: str, folder: Path, own_parts: Path | None) -> None:
    """Refuses hardware that no design can name.

    Args:
        entries: Entry of a design's hardware -> value, or list of what may be used.
        file: Name that error messages start with.
        folder: Folder that the entry `catalogue` starts from.
        own_parts: Folder of the user's own parts, in place of that one.

    Raises:
        DesignError: An entry is none of a design's hardware or out of its bounds, a part is in no catalogue, a list is
            empty, the own parts are refused, or the first motor is not for the first drive.
    """
    first = first_hardware(entries)
    for entry, value in first.items():
        if value == []:
            raise DesignError(file, f"hardware.{entry}", "[]", "must name at least one")
    hardware_from_dict(first, file, folder, own_parts)
    for entry, values in entries.items():
        for value in values[1:] if isinstance(values, list) else ():
            hardware_from_dict(first | {entry: value}, file, folder, own_parts, drive_fits=False)


def placed_hardware(entries: Mapping[str, Any], own_parts: Path | None, folder: Path) -> dict[str, Any]:
    """Makes the hardware of a design file that names the same folder of own parts from where the file stands.

    Args:
        entries: As of `check_hardware`.
        own_parts: Folder of the user's own parts; None where there are none.
        folder: Folder of the design file.

    Returns:
        The first of each entry, `catalogue` relative to the folder.
    """
    first = {entry: value for entry, value in first_hardware(entries).items() if entry != "catalogue"}
    if own_parts is None:
        return first
    return {"catalogue": Path(os.path.relpath(own_parts, folder)).as_posix()} | first
