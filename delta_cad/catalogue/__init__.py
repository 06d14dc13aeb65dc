"""Bought parts and materials: CSV rows with their source, read into frozen records and validated on load.

`catalogue.motor("maxon-re30-310007")` is a row, `catalogue.Motor` its record; likewise for every family.
A new family is a module in `families`, its import and its place in `FAMILIES` here, and its CSV file.
"""
# ruff: noqa: F401  records and families are for those who import the catalogue

from collections.abc import Mapping

from delta_cad.catalogue.families.bearing import Bearing, bearing
from delta_cad.catalogue.families.cable import Cable, cable
from delta_cad.catalogue.families.dowel import Dowel, dowel
from delta_cad.catalogue.families.encoder import Encoder, encoder
from delta_cad.catalogue.families.foot import Foot, foot
from delta_cad.catalogue.families.knob import Knob, knob
from delta_cad.catalogue.families.magnet import Magnet, magnet
from delta_cad.catalogue.families.material import MaterialData, material
from delta_cad.catalogue.families.motor import Motor, motor
from delta_cad.catalogue.families.screws import HexNut, HexScrew, Screw, hex_nut, hex_screw, screw
from delta_cad.catalogue.families.tube import Tube, tube
from delta_cad.catalogue.reader import CatalogueError, Family
from delta_cad.catalogue.row import CatalogueRow

# Name of a family -> the family.
FAMILIES: Mapping[str, Family] = {
    one.name: one
    for one in (motor, bearing, encoder, screw, hex_screw, hex_nut, dowel, tube, knob, foot, magnet, cable, material)
}


def family(name: str) -> Mapping[str, CatalogueRow]:
    """Gives all rows of one family, such as "motor", by their ids, in the order of the file.

    Raises:
        CatalogueError: There is no such family, or its file breaks a rule (the message says where).
    """
    if name not in FAMILIES:
        raise CatalogueError(f"no family {name!r} in the catalogue; legal: {', '.join(FAMILIES)}")
    return FAMILIES[name].rows
