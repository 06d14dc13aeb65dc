"""Inner corners for a round cutter: none sharp along a milling axis, none too deep for its cutter."""

from __future__ import annotations

from collections.abc import Iterator

from delta_cad.checks.contact.features import features
from delta_cad.checks.dfm.bores import Finding
from delta_cad.solids.part import Part

DEPTH_CUTTERS = 5.0  # of a corner, in diameters of the cutter that goes round it: a long end mill still cuts aluminium
LEAST_CUTTER_MM = 1.0  # in a corner: thinner ones are an engraver's
WHOLE_RAD = 3.0  # a wall that turns further is a bore's, or the end or the bottom of a slot


def sharp_corners(part: Part) -> Iterator[Finding]:
    """Straight inner edges without a radius that no flat end mill makes."""
    from delta_cad.solids.primitive import closed_corners  # loads the CAD kernel

    for corner in closed_corners(part.solid):
        if corner.is_straight:
            x, y, z = corner.point
            length = float(corner.edge.Length())  # type: ignore[attr-defined]
            yield Finding(part.number, length, 0.0, f"{part.number}: {length:.1f} mm at ({x:.1f}, {y:.1f}, {z:.1f})")


def corner_radii(part: Part) -> Iterator[Finding]:
    """Depth of each rounded inner corner in diameters of the largest cutter that goes round it."""
    for face in features(part.solid).cylinders:
        if not face.is_hollow or face.turn_rad >= WHOLE_RAD:
            continue
        deep, cutter = abs(face.end_mm - face.start_mm), 2.0 * face.radius_mm
        x, y, z = face.point + (face.start_mm + face.end_mm) / 2 * face.direction + face.radius_mm * face.first
        where = f"{part.number}: R{face.radius_mm:g}, {deep:.1f} deep, at ({x:.1f}, {y:.1f}, {z:.1f})"
        limit = DEPTH_CUTTERS if cutter >= LEAST_CUTTER_MM else 0.0
        yield Finding(part.number, deep / cutter, limit, where)
