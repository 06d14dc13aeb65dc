"""Bores that no other part would miss lie on their link where the design states, whatever way a part was put on."""

from __future__ import annotations

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.features import FeatureLibrary
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Anchor, Occurrence

DIAMETER_MM = 1e-3  # declared diameters are written to 0.01 mm at best
SHOWN = 8  # faults that a report names; their number is told


def check_anchors(assembly: Assembly) -> CheckResult:
    """Holds the bores that the design states a place of against where they are on their link.

    Returns:
        `anchors in place`: the distance of an end of a bore from its place that is the largest share of what its anchor
        allows, mm; a bore that is not there has no value.
    """
    name, library = "anchors in place", FeatureLibrary()
    occurrences = {o.name: o for o in assembly.occurrences}
    found: list[tuple[float, float, Anchor]] = []
    for anchor in assembly.anchors:
        o = occurrences.get(anchor.name)
        off = np.inf if o is None else _off_mm(library, o, anchor)
        found.append((off / anchor.off_mm, off, anchor))
    if not found:
        return CheckResult(name, False, None, None, "mm", detail="the assembly states the place of no bore")
    found.sort(key=lambda one: -one[0])
    bad = [
        f"{a.name}: " + (f"its bore of {a.diameter_mm:g} mm is {off:.3f} mm off" if np.isfinite(off) else "has no bore")
        for share, off, a in found
        if share > 1.0
    ]
    _, off, worst = found[0]
    told = f"{len(found)} bores on their links: {worst.reason}"
    detail = f"{len(bad)} fail: {'; '.join(bad[:SHOWN])}; {told}" if bad else told
    value = float(off) if np.isfinite(off) else None
    return CheckResult(name, not bad, value, worst.off_mm, "mm", worst_pair=(worst.name,), detail=detail)


def _off_mm(library: FeatureLibrary, o: Occurrence, anchor: Anchor) -> float:
    """Distance of the farther end of the nearest bore of an anchor's diameter from its place, mm; inf without one."""
    point, along = np.array(anchor.point_mm), np.array(anchor.along)
    best = np.inf
    for c in (c.moved(o.placement) for c in library[o.part].cylinders if c.is_bore):
        if abs(2.0 * c.radius_mm - anchor.diameter_mm) <= DIAMETER_MM:
            half, middle = (c.end_mm - c.start_mm) / 2.0, c.point + (c.start_mm + c.end_mm) / 2.0 * c.direction
            sense = 1.0 if c.direction @ along >= 0.0 else -1.0
            ends = (middle + s * half * c.direction - point - s * sense * half * along for s in (-1.0, 1.0))
            best = min(best, max(float(np.linalg.norm(end)) for end in ends))
    return best
