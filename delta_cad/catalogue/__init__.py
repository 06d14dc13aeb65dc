"""Bought parts and materials: CSV rows with their source, read into frozen records and validated on load."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import cast

from delta_cad.catalogue.errors import CatalogueError
from delta_cad.catalogue.reader import read_family
from delta_cad.catalogue.records import (
    Bearing,
    Cable,
    Dowel,
    Encoder,
    Foot,
    HexNut,
    HexScrew,
    Knob,
    Magnet,
    MaterialData,
    Motor,
    Row,
    Screw,
    Tube,
)

__all__ = [
    "FAMILIES",
    "Bearing",
    "Cable",
    "CatalogueError",
    "Dowel",
    "Encoder",
    "Foot",
    "HexNut",
    "HexScrew",
    "Knob",
    "Magnet",
    "MaterialData",
    "Motor",
    "Row",
    "Screw",
    "Tube",
    "bearing",
    "cable",
    "dowel",
    "encoder",
    "family",
    "foot",
    "hex_nut",
    "hex_screw",
    "knob",
    "magnet",
    "material",
    "motor",
    "screw",
    "tube",
]

FAMILIES: Mapping[str, type[Row]] = {
    "motor": Motor,
    "bearing": Bearing,
    "encoder": Encoder,
    "screw": Screw,
    "hex_screw": HexScrew,
    "hex_nut": HexNut,
    "dowel": Dowel,
    "tube": Tube,
    "knob": Knob,
    "foot": Foot,
    "magnet": Magnet,
    "cable": Cable,
    "material": MaterialData,
}
FILES: Mapping[str, str] = {
    "motor": "motors.csv",
    "bearing": "bearings.csv",
    "encoder": "encoders.csv",
    "screw": "screws.csv",
    "hex_screw": "hexscrews.csv",
    "hex_nut": "hexnuts.csv",
    "dowel": "dowels.csv",
    "tube": "tubes.csv",
    "knob": "knobs.csv",
    "foot": "feet.csv",
    "magnet": "magnets.csv",
    "cable": "cables.csv",
    "material": "materials.csv",
}


@cache
def family(name: str) -> Mapping[str, Row]:
    """All rows of one family.

    Args:
        name: A key of `FAMILIES`, such as "motor".

    Returns:
        Id -> record, in the order of the file.

    Raises:
        CatalogueError: There is no such family, or its file breaks a rule (the message says where).
    """
    if name not in FAMILIES:
        raise CatalogueError(f"no family {name!r} in the catalogue; legal: {', '.join(FAMILIES)}")
    return read_family(Path(__file__).parent / "data" / FILES[name], FAMILIES[name])


def _row(name: str, key: str) -> Row:
    rows = family(name)
    if key not in rows:
        raise CatalogueError(f"no {name.replace('_', ' ')} {key!r} in the catalogue; legal: {', '.join(rows)}")
    return rows[key]


def motor(key: str) -> Motor:
    """The motor with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Motor, _row("motor", key))


def bearing(key: str) -> Bearing:
    """The bearing with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Bearing, _row("bearing", key))


def encoder(key: str) -> Encoder:
    """The encoder with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Encoder, _row("encoder", key))


def screw(key: str) -> Screw:
    """The cap screw of this size ("M3"). Raises CatalogueError that lists the legal ids."""
    return cast(Screw, _row("screw", key))


def hex_screw(key: str) -> HexScrew:
    """The hexagon head screw of this size ("M2.5"). Raises CatalogueError that lists the legal ids."""
    return cast(HexScrew, _row("hex_screw", key))


def hex_nut(key: str) -> HexNut:
    """The thin hexagon nut of this size ("M2.5"). Raises CatalogueError that lists the legal ids."""
    return cast(HexNut, _row("hex_nut", key))


def dowel(key: str) -> Dowel:
    """The dowel with this id ("3"). Raises CatalogueError that lists the legal ids."""
    return cast(Dowel, _row("dowel", key))


def tube(key: str) -> Tube:
    """The tube with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Tube, _row("tube", key))


def knob(key: str) -> Knob:
    """The ball knob with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Knob, _row("knob", key))


def foot(key: str) -> Foot:
    """The foot with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Foot, _row("foot", key))


def magnet(key: str) -> Magnet:
    """The magnet with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Magnet, _row("magnet", key))


def cable(key: str) -> Cable:
    """The cable with this id. Raises CatalogueError that lists the legal ids."""
    return cast(Cable, _row("cable", key))


def material(key: str) -> MaterialData:
    """The material with this id. Raises CatalogueError that lists the legal ids."""
    return cast(MaterialData, _row("material", key))
