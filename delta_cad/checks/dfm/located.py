"""Bores lie where a part declares them, as deep, with the end that is declared: read off the solid's faces.

What is said of a bore agrees with itself: the core of its thread, the zone of its fit, the words of its callout.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.faces import SolidFace
from delta_cad.checks.contact.features import Features, features
from delta_cad.common.vectors import cross_length
from delta_cad.dimensions.tolerances import deviations_um, tip_mm
from delta_cad.solids.part import Bore, Part

AXIS_MM = 1e-4  # off a declared axis: roundings of turned frames; machinists' positions differ by 0.01 mm
ALONG = 1e-6  # sine of the angle between axes that count as one
_ENDS_MM = 0.005  # of a bore that begins and ends in planes
DIAMETER_MM = 1e-3  # declared diameters are written to 0.01 mm at best
_BEYOND_MM = 0.02  # past a bore's end, where there is air or metal
_TIP_DEG = 1e-3  # of a drill's tip


def location_faults(part: Part) -> list[str]:
    """Says which declared bores of a part are not found where they are declared.

    Args:
        part: With a valid solid.

    Returns:
        One text a fault; nothing where bores declare no place.
    """
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier

    bores = [bore for hole in part.holes for bore in hole.bores]
    if not bores:
        return []
    seen = features(part.solid)
    inside = BRepClass3d_SolidClassifier(part.solid.wrapped)
    faults = []
    for bore in bores:
        fault = _said_wrong(bore) or _fault(bore, bores, seen, inside)
        if fault:
            x, y, z = bore.start_mm
            faults.append(f"the bore of {bore.diameter_mm:g} mm at ({x:.2f}, {y:.2f}, {z:.2f}) {fault}")
    return faults


def _said_wrong(bore: Bore) -> str:
    """What of a bore's declaration contradicts the rest of it, or ""."""
    if bore.thread and abs((core := catalogue.screw(bore.thread).tap_drill_mm) - bore.diameter_mm) > DIAMETER_MM:
        return f"is specified as {bore.thread}, whose core is {core:g} mm"
    if bore.fit and bore.deviations_um != deviations_um(bore.fit, bore.diameter_mm):
        return f"is specified as {bore.fit} with deviations {bore.deviations_um} um"
    missing = next((word for word in (bore.thread, bore.fit) if word and word not in bore.callout), "")
    return f"is {missing}, which its callout {bore.callout!r} does not say" if missing else ""


def _fault(bore: Bore, every: list[Bore], seen: Features, inside: Any) -> str:
    """What of a bore is not as declared, or ""."""
    start, along, radius = np.array(bore.start_mm), np.array(bore.direction), bore.diameter_mm / 2
    end = bore.depth_mm + tip_mm(bore.diameter_mm, bore.tip_deg)
    coaxial = [c for c in seen.cylinders if c.is_hollow and _on_axis(c.point, c.direction, start, along)]
    own = [c for c in coaxial if abs(c.radius_mm - radius) <= DIAMETER_MM / 2 and _overlaps(c, bore)]
    if not own:
        return "is not there"
    spans = sorted(_span(c, start, along) for c in coaxial if c.radius_mm >= radius - DIAMETER_MM / 2)
    low, high = (ends(_span(c, start, along)[k] for c in own) for k, ends in enumerate((min, max)))
    reached = low
    for first, last in spans:
        reached = max(reached, last) if first <= reached + _ENDS_MM else reached
    slack = radius if bore.through else 0.0  # where it comes out, a wall may be hollow
    off = abs(low) - _slack_mm(seen, start, along, radius), abs(high - bore.depth_mm) - slack
    if max(off) > _ENDS_MM or reached < high - _ENDS_MM:
        return f"goes from {low:.3f} to {min(high, reached):.3f} mm along its axis, declared 0 to {bore.depth_mm:.3f}"
    tips = [c for c in seen.cones if c.is_hollow and _on_axis(c.apex, c.direction, start, along)]
    tips = [c for c in tips if (c.apex - c.centre) @ along > 0.0 and abs((c.apex - start) @ along - end) <= _ENDS_MM]
    tips_deg = [2.0 * abs(float(np.degrees(c.half_angle_rad))) for c in tips]
    if bool(bore.tip_deg) != bool(tips) or any(abs(tip - bore.tip_deg) > _TIP_DEG for tip in tips_deg):
        return f"does not end as declared, with a tip of {bore.tip_deg:g} deg (0: flat)"
    beyond = start + (end + _BEYOND_MM + slack) * along
    if not bore.through and any(_covers(other, beyond) for other in every):
        return ""
    is_open = not _is_inside(inside, beyond)
    return "" if is_open == bore.through else f"is {'open' if is_open else 'closed'} at its end"


def _on_axis(point: np.ndarray, direction: np.ndarray, start: np.ndarray, along: np.ndarray) -> bool:
    off = cross_length(point - start, along)
    return bool(cross_length(direction, along) < ALONG and off < AXIS_MM)


def _span(c: SolidFace, start: np.ndarray, along: np.ndarray) -> tuple[float, float]:
    """From where to where a face goes along a bore's axis, from its start."""
    at, sense = float((c.point - start) @ along), float(np.sign(c.direction @ along))
    low, high = sorted((at + sense * c.start_mm, at + sense * c.end_mm))
    return low, high


def _slack_mm(seen: Features, point: np.ndarray, along: np.ndarray, radius_mm: float) -> float:
    """How far the rim of a bore may lie from where its axis enters: nothing in a plane face across it."""
    flat = (p for p in seen.planes if cross_length(p.direction, along) < ALONG)
    return 0.0 if any(abs(float((p.point - point) @ along)) <= _ENDS_MM for p in flat) else radius_mm


def _overlaps(c: SolidFace, bore: Bore) -> bool:
    low, high = _span(c, np.array(bore.start_mm), np.array(bore.direction))
    return high > _ENDS_MM and low < bore.depth_mm - _ENDS_MM


def _covers(bore: Bore, point: np.ndarray) -> bool:
    """Whether a point lies on the axis of a bore, within it."""
    apart, along = point - np.array(bore.start_mm), np.array(bore.direction)
    at = float(apart @ along)
    return -_ENDS_MM <= at <= bore.depth_mm and float(np.linalg.norm(apart - at * along)) < bore.diameter_mm / 2


def _is_inside(classifier: Any, point: np.ndarray) -> bool:
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_IN

    classifier.Perform(gp_Pnt(*point.tolist()), 1e-7)
    return classifier.State() == TopAbs_IN
