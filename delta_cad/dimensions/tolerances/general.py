"""General tolerances and grades: what a shop keeps where a drawing states nothing, and how fine a stated one is."""

from __future__ import annotations

from bisect import bisect_left

from delta_cad.catalogue.families.bearing import INSIDE_MM
from delta_cad.dimensions.tolerances import GRADES_UM, NOMINAL_MM

CLASSES = ("f", "m", "c")
"""Of ISO 2768-1, the finest first; "v" has no values for small sizes."""
REQUIRED = "m"  # what drawings state
NOTES = {"f": "ISO 2768-fH", "m": "ISO 2768-mK", "c": "ISO 2768-cL"}
"""Class -> how drawings state it, with the class of forms and places that goes with it."""
EDGES = f"ISO 13715: -0.1 to -0.3 outside, up to +{INSIDE_MM:g} inside"
"""Of every part where nothing else is drawn: a bearing's ring stands on a shoulder, not on a wider fillet before it."""
PRINTED_MM = "±0.2, above 100 mm ±0.2 %"  # of what is printed, where nothing is stated; see `PRINTED_PLACE_MM`
_LINEAR_MM = (3.0, 6.0, 30.0, 120.0, 400.0, 1000.0, 2000.0)
"""Upper ends of the ranges of length of `_GENERAL_MM`."""
_GENERAL_MM = {
    "f": (0.05, 0.05, 0.1, 0.15, 0.2, 0.3, 0.5),
    "m": (0.1, 0.1, 0.2, 0.3, 0.5, 0.8, 1.2),
    "c": (0.2, 0.3, 0.5, 0.8, 1.2, 2.0, 3.0),
}
"""Either way, of lengths. Source: ISO 2768-1:1989, table 1."""
_FLAT_MM = {
    "f": (0.02, 0.05, 0.1, 0.2, 0.3, 0.4),
    "m": (0.05, 0.1, 0.2, 0.4, 0.6, 0.8),
    "c": (0.1, 0.2, 0.4, 0.8, 1.2, 1.6),
}
"""Flatness, classes H, K and L as in `NOTES`. Source: ISO 2768-2:1989, table 1."""
_FLAT_TO_MM = (10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0)
_COARSE_UM = {
    8: (14, 18, 22, 27, 33, 39, 46, 54),
    9: (25, 30, 36, 43, 52, 62, 74, 87),
    10: (40, 48, 58, 70, 84, 100, 120, 140),
    11: (60, 75, 90, 110, 130, 160, 190, 220),
    12: (100, 120, 150, 180, 210, 250, 300, 350),
}
"""Standard tolerances beyond those of fits, by the ranges of `NOMINAL_MM`. Source: ISO 286-1, table 1."""


def general_mm(length_mm: float, name: str = REQUIRED) -> float:
    """Looks up the general tolerance of a length, either way, mm.

    Args:
        length_mm: Of the feature, up to 2000 mm.
        name: Class of ISO 2768-1.

    Raises:
        ValueError: No such class, or the length is beyond the table.
    """
    return _looked_up(_GENERAL_MM, _LINEAR_MM, length_mm, name)


def flat_mm(length_mm: float, name: str = REQUIRED) -> float:
    """Looks up the flatness of a face of a length up to 3000 mm, the width of its zone, mm; see `general_mm`."""
    return _looked_up(_FLAT_MM, _FLAT_TO_MM, length_mm, name)


def _looked_up(table: dict[str, tuple[float, ...]], ends: tuple[float, ...], length_mm: float, name: str) -> float:
    row = bisect_left(ends, length_mm - 1e-9)
    if name not in table or not length_mm > 0.0 or row >= len(ends):
        raise ValueError(f"class {name} of {length_mm:g} mm: known are {', '.join(table)} up to {ends[-1]:g} mm")
    return table[name][row]


def coarsest_grade(width_mm: float, nominal_mm: float) -> int | None:
    """Finds the coarsest standard grade whose tolerance is no wider than a zone, mm; None: finer than all known.

    Args:
        width_mm: Of the whole zone, twice a tolerance either way.
        nominal_mm: Of the feature; beyond the table's end its last range counts.
    """
    row = min(bisect_left(NOMINAL_MM, nominal_mm), len(NOMINAL_MM) - 1)
    grades = GRADES_UM | _COARSE_UM
    return max((grade for grade, um in grades.items() if um[row] <= 1000.0 * width_mm + 1e-9), default=None)
