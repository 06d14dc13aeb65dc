"""The hardware of a requirements file: table `[hardware]`, the entries of a design file's hardware.

An entry is one value, or a list of what may be used. Who chooses no hardware takes the first of each list.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from itertools import product
from pathlib import Path
from typing import Any, get_args

from delta_cad import catalogue
from delta_cad.common.refusal import short, unknown_key
from delta_cad.design import DesignError, Hardware, hardware_from_dict
from delta_cad.design.cross_field_rules import pinion_contradiction
from optimizer.problem.validation import RequirementsError

DRIVES: tuple[str, ...] = get_args(Hardware.model_fields["drive"].annotation)
MOST = 100  # values of one entry; our largest family has a tenth of it


def own_folder(entries: Mapping[str, Any], folder: Path, own_parts: Path | None) -> Path | None:
    """Finds the folder of the user's own parts: the one given, or the one that the hardware names in a folder."""
    named = entries.get("catalogue")
    return own_parts if own_parts is not None or named is None else folder / str(named)


def first_hardware(entries: Mapping[str, Any]) -> dict[str, Any]:
    """Takes the first of what may be used of each entry."""
    return {entry: value[0] if isinstance(value, list) and value else value for entry, value in entries.items()}


def check_hardware(
    entries: Mapping[str, Any], file: str, folder: Path, own_parts: Path | None
) -> list[RequirementsError]:
    """Finds the hardware that no design can name, where the first of each list is taken.

    Args:
        entries: Entry of a design's hardware -> value, or list of what may be used.
        file: Name that error messages start with.
        folder: Folder that the entry `catalogue` starts from.
        own_parts: Folder of the user's own parts, in place of that one.

    Returns:
        A fault for each entry that is none of a design's hardware or out of its bounds, part that is in no catalogue,
        list that is empty; for own parts that are refused; for a first motor that is not for the first drive; for a
        first ratio whose pinion cannot be made.
    """
    faults = list(_each(entries, file, folder, own_parts))
    if not faults:
        try:
            fault = pinion_contradiction(hardware_from_dict(first_hardware(entries), file, folder, own_parts))
        except DesignError as error:
            faults.append(RequirementsError(error.file, error.field, error.value, error.allowed))
        else:
            faults += [] if fault is None else [RequirementsError(file, fault.field, short(fault.value), fault.allowed)]
    return faults


def check_choices(
    entries: Mapping[str, Any], file: str, folder: Path, own_parts: Path | None
) -> list[RequirementsError]:
    """Finds the hardware that no design can name, where any of each list may be taken, and all where none is stated.

    It takes the arguments of `check_hardware`.

    Returns:
        A fault for each value as of `check_hardware`, motor that is for none of the drives, drive that none of the
        motors is for, and for encoders on the motors where no motor has one.
    """
    faults = list(_each(entries, file, folder, own_parts))
    if any(fault.field == "hardware.catalogue" for fault in faults):
        return faults
    own = {"catalogue": entries["catalogue"]} if "catalogue" in entries else {}
    try:
        rows = catalogue.family("motor", hardware_from_dict(own, file, folder, own_parts).own_parts)
    except DesignError as error:  # the folder that a command names
        return [*faults, RequirementsError(error.file, error.field, error.value, error.allowed)]
    motors = {key: row for key, row in rows.items() if isinstance(row, catalogue.Motor)}
    drives = [drive for drive in DRIVES if drive in _listed(entries, "drive")] or list(DRIVES)
    fit = [key for key, row in motors.items() if set(row.drives) & set(drives)]
    chosen = [key for key in motors if key in _listed(entries, "motor")] or fit
    for key in chosen:
        if key not in fit:
            allowed = f"is not for the {' or '.join(drives)} drive; must be one of {', '.join(fit)}"
            faults.append(RequirementsError(file, "hardware.motor", short(key), allowed))
    for drive in [] if faults else _listed(entries, "drive"):
        if not any(drive in motors[key].drives for key in chosen):
            allowed = f"is not a drive of {', '.join(chosen)}: add a motor for it, or leave it out"
            faults.append(RequirementsError(file, "hardware.drive", short(drive), allowed))
    places = _listed(entries, "encoder_at")
    if "motor" in places and not any(motors[key].encoder_counts_per_turn for key in chosen):
        sensed = ", ".join(key for key, row in motors.items() if row.encoder_counts_per_turn)
        allowed = f"needs hardware.motor to name one with an encoder of its own: {sensed}"
        faults.append(RequirementsError(file, "hardware.encoder_at", short("motor"), allowed))
    return faults


def choices(entries: Mapping[str, Any], own_parts: catalogue.OwnParts | None) -> dict[str, tuple[Any, ...]]:
    """Lists what may be used: of bought parts and drives all where none is stated, else what is stated.

    Args:
        entries: As of `check_choices`, which found no fault in them.
        own_parts: The user's own parts, among all.

    Returns:
        Entry of a design's hardware -> values; motors and drives that are for none of the others left out. Entries
        with a number, and `catalogue`, are there only where they are stated.
    """
    found = {entry: tuple(catalogue.family(entry, own_parts)) for entry in catalogue.CHOSEN} | {"drive": DRIVES}
    found |= {entry: tuple(_listed(entries, entry)) for entry in entries if entry != "catalogue"}
    rows = catalogue.family("motor", own_parts)
    fit = [pair for pair in product(found["motor"], found["drive"]) if pair[1] in getattr(rows[pair[0]], "drives", ())]
    found["motor"] = tuple(dict.fromkeys(motor for motor, _ in fit))
    found["drive"] = tuple(drive for drive in found["drive"] if any(drive == other for _, other in fit))
    return found


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


def _listed(entries: Mapping[str, Any], entry: str) -> list[Any]:
    """Lists what is stated of an entry; nothing where it is not."""
    value = entries.get(entry, [])
    return value if isinstance(value, list) else [value]


def _each(entries: Mapping[str, Any], file: str, folder: Path, own_parts: Path | None) -> Iterator[RequirementsError]:
    """Finds the values that no design can name, each by itself."""
    own = {"catalogue": entries["catalogue"]} if "catalogue" in entries else {}
    for entry, value in entries.items():
        if entry not in Hardware.model_fields:
            allowed = unknown_key(entry, Hardware.model_fields)
            yield RequirementsError(file, f"hardware.{entry}", short(value), allowed)
            continue
        listed = _listed(entries, entry)
        if not 1 <= len(listed) <= MOST:
            allowed = "must name at least one" if not listed else f"must name at most {MOST}"
            yield RequirementsError(file, f"hardware.{entry}", short(value), allowed)
            continue
        for one in listed:
            try:
                hardware_from_dict(own | {entry: one}, file, folder, own_parts, drive_fits=False)
            except DesignError as error:
                yield RequirementsError(error.file, error.field, error.value, error.allowed)
