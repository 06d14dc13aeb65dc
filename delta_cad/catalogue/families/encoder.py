"""Magnetic angle sensors on a board."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
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
    """

    defaults: ClassVar = {**CatalogueRow.defaults, "hole_count": 4, "magnet": "ndfeb-6x2.5-diametric"}
    partners: ClassVar = {"magnet": "magnet"}

    board_length_mm: float
    board_width_mm: float
    board_thickness_mm: float
    chip_height_mm: float
    hole_diameter_mm: float
    hole_spacing_length_mm: float
    hole_spacing_width_mm: float
    hole_count: int
    magnet: str
    air_gap_min_mm: float
    air_gap_max_mm: float
    centring_mm: float | None
    counts_per_turn: int
    mass_g: float
    noise_rms_deg: float | None
    nonlinearity_deg: float | None
    latency_us: float | None

    def fault(self) -> str:
        """Says that the air gap has no width or the board is turned."""
        if not self.air_gap_min_mm < self.air_gap_max_mm:
            return "must have air_gap_min_mm < air_gap_max_mm"
        return "" if self.board_width_mm <= self.board_length_mm else "must have board_width_mm <= board_length_mm"


encoder = Family("encoder", "encoders.csv", Encoder)
