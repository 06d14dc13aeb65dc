"""Metric screws and nuts: cap screws, hexagon screws, thin hexagon nuts."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Screw(CatalogueRow):
    """A hexagon socket head cap screw, with the holes that go with it.

    Attributes:
        diameter_mm: Thread diameter.
        pitch_mm: Coarse pitch.
        head_diameter_mm: Plain head, nominal (largest of a plain head).
        socket_mm: Key size across flats.
        socket_depth_mm: Least depth of the socket.
        clearance_hole_mm: ISO 273 medium.
        counterbore_diameter_mm: Counterbore for the head.
        counterbore_depth_mm: Depth that buries the head.
        tap_drill_mm: Drill for the thread.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: float
    pitch_mm: float
    head_diameter_mm: float
    head_height_mm: float
    socket_mm: float
    socket_depth_mm: float
    clearance_hole_mm: float
    counterbore_diameter_mm: float
    counterbore_depth_mm: float
    tap_drill_mm: float
    lengths_mm: tuple[float, ...]


@dataclass(frozen=True)
class HexScrew(CatalogueRow):
    """A hexagon head screw threaded to the head; fields as for `Screw`, `across_flats_mm` is the head's."""

    diameter_mm: float
    pitch_mm: float
    across_flats_mm: float
    head_height_mm: float
    tap_drill_mm: float
    lengths_mm: tuple[float, ...]


@dataclass(frozen=True)
class HexNut(CatalogueRow):
    """A hexagon nut; `diameter_mm` is its thread's, `tap_drill_mm` the core of it."""

    diameter_mm: float
    across_flats_mm: float
    height_mm: float
    tap_drill_mm: float


screw = Family("screw", "fasteners/screws.csv", Screw)
hex_screw = Family("hex_screw", "fasteners/hexscrews.csv", HexScrew)
hex_nut = Family("hex_nut", "fasteners/hexnuts.csv", HexNut)
