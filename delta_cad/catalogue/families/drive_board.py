"""Drive boards: power stages that commutate a brushless motor by its encoder."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity


@dataclass(frozen=True, kw_only=True, config=ROW)
class DriveBoard(CatalogueRow):
    """A drive board for one motor.

    Attributes:
        current_A: Amplitude of a phase's current that it bears without cooling, as long as wanted.
        peak_current_A: The same for seconds.
        voltage_max_V: Largest supply.
    """

    current_A: Quantity
    peak_current_A: Quantity
    voltage_max_V: Quantity

    def fault(self) -> str:
        """Says that its peak is smaller than what it bears as long as wanted."""
        return "" if self.current_A <= self.peak_current_A else "must have current_A <= peak_current_A"


drive_board = Family("drive_board", "driveboards.csv", DriveBoard)
