"""Deep groove ball bearings."""

from __future__ import annotations

from itertools import pairwise
from math import pi

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Count, MaybeText, Quantity, outside

# What no ball bearing is: beyond, a number is in another unit than its column. Ours have 4.8 to 5.3 g/cm^3 and bear 4
# to 9 N/mm^2 at rest, 13 to 22 turning.
_DENSITY_g_cm3 = 0.8, 9.0
_BEARS_N_mm2 = 0.4, 200.0

INSIDE_MM = 0.2  # radius that drawings leave in inner edges; the least fillet_max_mm of the rows whose sheet was opened


@dataclass(frozen=True, kw_only=True, config=ROW)
class Bearing(CatalogueRow):
    """A deep groove ball bearing.

    Attributes:
        bore_mm: Bore of the inner ring.
        outer_mm: Outside diameter.
        inner_ring_outer_mm: Outside diameter of the inner ring's shoulder: a washer that touches only the inner ring
            stays below it.
        outer_ring_inner_mm: Inside diameter of the outer ring's shoulder.
        shaft_shoulder_min_mm: Smallest diameter of the shaft's abutment.
        housing_shoulder_max_mm: Largest bore of the housing's abutment.
        fillet_max_mm: Largest fillet of shaft and housing at the seat; None when it is not known.
        static_load_N: Basic static load rating C0.
        dynamic_load_N: Basic dynamic load rating C.
        ball_count: Number of balls; None when no source was opened.
        ball_diameter_mm: Their diameter; None when no source was opened.
        clearance: Class of the radial internal clearance, such as "CN"; "" when the order code leaves it open.
    """

    bore_mm: Quantity
    outer_mm: Quantity
    width_mm: Quantity
    inner_ring_outer_mm: Quantity
    outer_ring_inner_mm: Quantity
    shaft_shoulder_min_mm: Quantity
    housing_shoulder_max_mm: Quantity
    fillet_max_mm: Quantity | None = None
    mass_g: Quantity
    static_load_N: Quantity
    dynamic_load_N: Quantity
    ball_count: Count | None = None
    ball_diameter_mm: Quantity | None = None
    clearance: MaybeText = ""

    def fault(self) -> str:
        """Says that the rings do not lie within each other, or that mass or loads are not a bearing's."""
        rings = (self.bore_mm, self.inner_ring_outer_mm, self.outer_ring_inner_mm, self.outer_mm)
        if not all(a < b for a, b in pairwise(rings)):
            return "must have bore_mm < inner_ring_outer_mm < outer_ring_inner_mm < outer_mm"
        if self.ball_diameter_mm is not None and not 2.0 * self.ball_diameter_mm < self.outer_mm - self.bore_mm:
            return "must have 2 ball_diameter_mm < outer_mm - bore_mm"
        if not self.bore_mm < self.shaft_shoulder_min_mm < self.housing_shoulder_max_mm < self.outer_mm:
            return "must have bore_mm < shaft_shoulder_min_mm < housing_shoulder_max_mm < outer_mm"
        if self.fillet_max_mm is not None and self.fillet_max_mm < INSIDE_MM:
            return f"must have fillet_max_mm >= {INSIDE_MM:g}: drawings leave inner edges so round"
        volume_cm3 = pi / 4.0 * (self.outer_mm**2 - self.bore_mm**2) * self.width_mm / 1e3
        side_mm2 = self.outer_mm * self.width_mm
        return (
            outside("mass_g over the volume of its ring", self.mass_g / volume_cm3, _DENSITY_g_cm3, "g/cm^3")
            or outside("static_load_N over outer_mm width_mm", self.static_load_N / side_mm2, _BEARS_N_mm2, "N/mm^2")
            or outside("dynamic_load_N over outer_mm width_mm", self.dynamic_load_N / side_mm2, _BEARS_N_mm2, "N/mm^2")
        )


bearing = Family("bearing", "bearings.csv", Bearing)
