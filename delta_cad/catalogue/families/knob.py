"""Ball knobs, the handle."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Knob(CatalogueRow):
    """A ball knob with a threaded hole.

    Attributes:
        diameter_mm: Ball diameter.
        height_mm: From the flat foot to the top.
        foot_diameter_mm: Diameter of the flat foot.
        thread: Thread of the hole ("M6").
        thread_depth_mm: Usable depth of the thread.
    """

    partners: ClassVar = {"thread": "screw"}

    diameter_mm: float
    height_mm: float
    foot_diameter_mm: float
    thread: str
    thread_depth_mm: float
    mass_g: float


knob = Family("knob", "knobs.csv", Knob)
