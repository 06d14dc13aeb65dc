"""Magnetic angle sensors on a board."""

from __future__ import annotations

from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Count, Quantity, Text, outside

# What no board is: beyond, a number is in another unit than its column. Ours have 3.0 g/cm^3 with their parts.
_DENSITY_g_cm3 = 0.5, 12.0
_THICKNESS_mm = 0.2, 5.0
_CHIP_mm = 0.2, 10.0
_AIR_GAP_mm = 0.05, 20.0
_COUNTS = 100, 2**32


@dataclass(frozen=True, kw_only=True, config=ROW)
class Encoder(CatalogueRow):
    """A magnetic angle sensor on a small board; the chip sits in the board's centre, over the shaft's magnet.

    Attributes:
        board_length_mm: Longer side of the board.
        board_width_mm: Shorter side.
        board_thickness_mm: Thickness of the bare board.
        chip_height_mm: Height of the chip over the board.
        hole_diameter_mm: Mounting hole.
        hole_spacing_length_mm: Hole pattern along the longer side.
        hole_spacing_width_mm: Hole pattern along the shorter side.
        magnet: Id of the magnet it is meant for.
        air_gap_min_mm: Smallest distance from chip to magnet.
        air_gap_max_mm: Largest distance.
        centring_mm: Largest offset of the magnet's axis from the chip's centre; None when it is not known.
        counts_per_turn: Resolution.
        noise_rms_deg: Noise of one reading, rms; None when no source was opened.
        nonlinearity_deg: Largest error of the angle over a turn with the magnet placed at its best, before any
            correction; None when no source was opened.
        latency_us: Age of a reading when it can be read; None when no source was opened.
        settling_us: Time that a step takes through the chip's own filter, set as `noise_rms_deg` is stated; None when
            no source was opened, or the filter cannot be set.
    """

    partners: ClassVar = {"magnet": "magnet"}

    board_length_mm: Quantity
    board_width_mm: Quantity
    board_thickness_mm: Quantity
    chip_height_mm: Quantity
    hole_diameter_mm: Quantity
    hole_spacing_length_mm: Quantity
    hole_spacing_width_mm: Quantity
    hole_count: Count = 4
    magnet: Text = "ndfeb-6x2.5-diametric"
    air_gap_min_mm: Quantity
    air_gap_max_mm: Quantity
    centring_mm: Quantity | None = None
    counts_per_turn: Count
    mass_g: Quantity
    noise_rms_deg: Quantity | None = None
    nonlinearity_deg: Quantity | None = None
    latency_us: Quantity | None = None
    settling_us: Quantity | None = None

    def fault(self) -> str:
        """Says that the air gap has no width, the board is turned, or a size, mass or count is not a board's."""
        if not self.air_gap_min_mm < self.air_gap_max_mm:
            return "must have air_gap_min_mm < air_gap_max_mm"
        if not self.board_width_mm <= self.board_length_mm:
            return "must have board_width_mm <= board_length_mm"
        for side in ("length", "width"):
            spaced, wide = getattr(self, f"hole_spacing_{side}_mm"), getattr(self, f"board_{side}_mm")
            if not self.hole_diameter_mm < spaced < wide - self.hole_diameter_mm:
                return f"must have hole_diameter_mm < hole_spacing_{side}_mm < board_{side}_mm - hole_diameter_mm"
        volume_cm3 = self.board_length_mm * self.board_width_mm * self.board_thickness_mm / 1e3
        return (
            outside("board_thickness_mm", self.board_thickness_mm, _THICKNESS_mm, "mm")
            or outside("chip_height_mm", self.chip_height_mm, _CHIP_mm, "mm")
            or outside("air_gap_max_mm", self.air_gap_max_mm, _AIR_GAP_mm, "mm")
            or outside("counts_per_turn", self.counts_per_turn, _COUNTS, "counts")
            or outside("mass_g over the board's volume", self.mass_g / volume_cm3, _DENSITY_g_cm3, "g/cm^3")
        )


encoder = Family("encoder", "encoders.csv", Encoder)
