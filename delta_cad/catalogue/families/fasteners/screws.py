"""Metric screws: cap screws, cap screws with low heads, set screws."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Lengths, Quantity


@dataclass(frozen=True, kw_only=True, config=ROW)
class Screw(CatalogueRow):
    """A hexagon socket head cap screw, with the holes that go with it.

    Attributes:
        diameter_mm: Thread diameter.
        pitch_mm: Coarse pitch.
        head_diameter_mm: Plain head, nominal (largest of a plain head).
        socket_mm: Key size across flats.
        socket_depth_mm: Depth of the socket: the least of ISO 4762, the nominal one of DIN 7984.
        clearance_hole_mm: ISO 273 medium.
        counterbore_diameter_mm: Counterbore for the head.
        counterbore_depth_mm: Depth that buries the head.
        tap_drill_mm: Drill for the thread.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: Quantity
    pitch_mm: Quantity
    head_diameter_mm: Quantity
    head_height_mm: Quantity
    socket_mm: Quantity
    socket_depth_mm: Quantity
    clearance_hole_mm: Quantity
    counterbore_diameter_mm: Quantity
    counterbore_depth_mm: Quantity
    tap_drill_mm: Quantity
    lengths_mm: Lengths


@dataclass(frozen=True, kw_only=True, config=ROW)
class SetScrew(CatalogueRow):
    """A hexagon socket set screw with cup point; fields as for `Screw`."""

    diameter_mm: Quantity
    pitch_mm: Quantity
    socket_mm: Quantity
    tap_drill_mm: Quantity
    lengths_mm: Lengths


screw = Family("screw", "fasteners/screws.csv", Screw)
low_screw = Family("low_screw", "fasteners/lowscrews.csv", Screw)
set_screw = Family("set_screw", "fasteners/setscrews.csv", SetScrew)
