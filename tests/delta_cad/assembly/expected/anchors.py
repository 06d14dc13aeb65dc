"""Bores that no other part would miss lie on their link where the design has them, whatever way a part was put on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.features import features
from delta_cad.dimensions import Dimensions
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.part import Occurrence

DIAMETER_MM = 1e-3  # declared diameters are written to 0.01 mm at best
EYE_MM = 0.1  # rings are bonded in a jig
AXIS_MM, MOUNT_MM = 0.1, 0.2  # of the handle's thread; of a mounting hole, a quarter of what its screw leaves
UPRIGHT = (0.0, 0.0, 1.0)


class Anchor(NamedTuple):
    """Where the middle of a bore of a placed part lies on its link, along which axis, and by how much it may be off."""

    name: str
    diameter_mm: float
    point_mm: tuple[float, float, float]
    along: tuple[float, float, float]
    off_mm: float


def expected_anchors(d: Dimensions) -> tuple[Anchor, ...]:
    """Places the eyes of the springs, the base plate's mounting holes and the handle's thread.

    The eyes lie across the rods, level with their like, one pair on either side.
    """
    f, p = d.forearm, d.platform
    thread = catalogue.screw(p.stem_thread).tap_drill_mm
    found = [Anchor("platform", thread, (0.0, 0.0, 0.0), UPRIGHT, AXIS_MM)]
    middle = d.base.top_mm - d.base.thickness_mm / 2
    mount = catalogue.screw("M5").tap_drill_mm
    found += [Anchor("base_plate", mount, (x, y, middle), UPRIGHT, MOUNT_MM) for x, y in d.base.mounts_mm]
    for i in CHAINS:
        for j, inwards in zip(SIDES, (1.0, -1.0), strict=True):
            for k, (x, up) in enumerate(zip(f.eyes_x_mm, (-1.0, 1.0), strict=True)):
                point = x, inwards * f.eye_hole_y_mm, up * f.eye_z_mm
                found.append(Anchor(f"rod_eye_{i}_{j}_{k}", f.eye_diameter_mm, point, (1.0, 0.0, 0.0), EYE_MM))
    return tuple(found)


def anchor_faults(assembly: Assembly, d: Dimensions) -> list[str]:
    """Names the bores whose farther end is too far off its place, and those that are not there."""
    occurrences = {o.name: o for o in assembly.occurrences}
    faults = []
    for anchor in expected_anchors(d):
        o = occurrences.get(anchor.name)
        off = np.inf if o is None else _off_mm(o, anchor)
        if off > anchor.off_mm:
            faults.append(f"{anchor.name}: its bore of {anchor.diameter_mm:g} mm is {off:.3f} mm off")
    return faults


def _off_mm(o: Occurrence, anchor: Anchor) -> float:
    """Distance of the farther end of the nearest bore of an anchor's diameter from its place, mm; inf without one."""
    point, along = np.array(anchor.point_mm), np.array(anchor.along)
    best = np.inf
    for c in (c.moved(o.placement) for c in features(o.part.solid).cylinders if c.is_hollow):
        if abs(2.0 * c.radius_mm - anchor.diameter_mm) <= DIAMETER_MM:
            half, middle = (c.end_mm - c.start_mm) / 2.0, c.point + (c.start_mm + c.end_mm) / 2.0 * c.direction
            sense = 1.0 if c.direction @ along >= 0.0 else -1.0
            ends = (middle + s * half * c.direction - point - s * sense * half * along for s in (-1.0, 1.0))
            best = min(best, max(float(np.linalg.norm(end)) for end in ends))
    return best
