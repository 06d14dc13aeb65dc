"""Bought parts and materials: CSV rows with their source, read into frozen records and validated on load.

`catalogue.motor("maxon-re30-310007")` is a row, `catalogue.Motor` its record; likewise for every family.
`catalogue.motor.chosen(design.hardware)` is the row that a design names, of ours or of the user's own parts
(`own_parts`). A new family is a module in `families` and its CSV file; its import here makes it `catalogue.NAME`.
"""
# ruff: noqa: F401  records and families are for those who import the catalogue

from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages

from delta_cad.catalogue import families
from delta_cad.catalogue.families.ball import Ball, ball
from delta_cad.catalogue.families.bearing import Bearing, bearing
from delta_cad.catalogue.families.cable import Cable, cable
from delta_cad.catalogue.families.drive_board import DriveBoard, drive_board
from delta_cad.catalogue.families.encoder import Encoder, encoder
from delta_cad.catalogue.families.fasteners.adhesive import Adhesive, adhesive
from delta_cad.catalogue.families.fasteners.dowel import Dowel, dowel
from delta_cad.catalogue.families.fasteners.insert import Insert, insert
from delta_cad.catalogue.families.fasteners.screws import Screw, SetScrew, low_screw, screw, set_screw
from delta_cad.catalogue.families.fasteners.spacer import Spacer, spacer, stock_spacer
from delta_cad.catalogue.families.foot import Foot, foot
from delta_cad.catalogue.families.knob import Knob, knob
from delta_cad.catalogue.families.magnet import Magnet, magnet
from delta_cad.catalogue.families.material import MaterialData, material
from delta_cad.catalogue.families.motor import Motor, motor
from delta_cad.catalogue.families.spring import TensionSpring, WaveSpring, tension_spring, wave_spring
from delta_cad.catalogue.families.tube import Tube, tube
from delta_cad.catalogue.reader import CatalogueError, Family, OwnParts, read_family
from delta_cad.catalogue.row import CatalogueRow

# Families of which a design names a row, by the entry of its hardware; a user's own folder may hold rows of these.
CHOSEN: Mapping[str, Family] = {one.name: one for one in (motor, cable, encoder, bearing, tube, knob, foot, magnet)}


def _families() -> Iterator[Family]:
    """Finds the families of all modules in `families`."""
    for module in walk_packages(families.__path__, f"{families.__name__}."):
        yield from (one for one in vars(import_module(module.name)).values() if isinstance(one, Family))


# Name of a family -> the family.
FAMILIES: Mapping[str, Family] = {**CHOSEN, **{one.name: one for one in _families()}}


def family(name: str, own: OwnParts | None = None) -> Mapping[str, CatalogueRow]:
    """Gives all rows of one family, such as "motor", by their ids, in the order of the file.

    Args:
        name: Name of the family.
        own: The user's own parts, which come after ours.

    Raises:
        CatalogueError: There is no such family, or its file breaks a rule (the message says where).
    """
    if name not in FAMILIES:
        raise CatalogueError(f"no family {name!r} in the catalogue; legal: {', '.join(FAMILIES)}")
    rows = FAMILIES[name].rows
    return rows if own is None else {**rows, **own.rows.get(name, {})}


def own_parts(folder: Path) -> OwnParts:
    """Reads a user's own parts: a folder of CSV files `motor.csv`, `cable.csv`, ..., one a family in `CHOSEN`.

    Each file has a header and one row a part. A column may be left out, and a cell be empty, where the family declares
    a default or the record may have None there.

    Args:
        folder: The folder; what is no CSV file in it is left alone.

    Returns:
        Its rows.

    Raises:
        CatalogueError: It is no folder, has no CSV file, or one that is called as no family; a row breaks a rule of
            `read_family`, has the id of a row of ours, or names a partner (a thread, a magnet, a material) that is not
            in the catalogue. The message is one line that names file, line, column, value and what is allowed.
    """
    legal = ", ".join(f"{name}.csv" for name in CHOSEN)
    try:
        files = sorted(path for path in folder.iterdir() if path.suffix.lower() == ".csv")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise CatalogueError(
            f"{folder.name}: cannot be read: {reason}; must be a folder with some of {legal}"
        ) from None
    if not files:
        raise CatalogueError(f"{folder.name}: holds no CSV file; must hold one or more of {legal}")
    rows: dict[str, dict[str, CatalogueRow]] = {}
    for path in files:
        name = path.name.removesuffix(".csv")
        if name not in CHOSEN:
            raise CatalogueError(f"{path.name}: is called as no family; must be one of {legal}")
        rows[name] = dict(read_family(path, CHOSEN[name].record, own=True, taken=CHOSEN[name].rows))
    parts = OwnParts(folder, rows)
    for name, row in ((name, row) for name, own in rows.items() for row in own.values()):
        for column, partner in row.partners.items():
            if (key := getattr(row, column)) not in (known := family(partner, parts)):
                allowed = f"must be one of {', '.join(known)}"
                raise CatalogueError(f"{name}.csv: {row.id}: {column} = {key!r}: {allowed}")
    return parts
