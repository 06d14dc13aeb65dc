"""Bores of a part: one statement gives the tool that cuts each and the record that a machinist reads."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import hypot

import cadquery as cq
import numpy as np

from delta_cad import catalogue
from delta_cad.common.vectors import cross_length
from delta_cad.dimensions.tolerances import (
    FITTED_RA_UM,
    PLACE_MM,
    SLOT_CUTTER_MM,
    SLOT_MM,
    TIP_DEG,
    deviations_um,
    drilled_mm,
    tip_mm,
)
from delta_cad.solids.part import Bore, Hole, Slot, Triple
from delta_cad.solids.primitive import THROUGH_MM, Point, cylinder, turned

UP, DOWN = 1.0, -1.0
_THREAD_DIAMETERS = 3.0  # a screw holds no more by a longer thread, and taps break
_AXIS_MM, _DIAMETER_MM = 1e-4, 1e-3  # of a face from the axis and the diameter that a bore declares
_SAME_MM = 1e-6  # bores made from both sides share their axis to roundings


def along_y(diameter: float, at: Point, y: Point) -> Bore:
    """Through bore along y at (first, third) coordinates, from the first value of y to the second.

    Turn it into another with `blind`, `tapped`, `fitted`, `sunk`.
    """
    sense = UP if y[1] > y[0] else DOWN
    return Bore((at[0], y[0], at[1]), (0.0, sense, 0.0), diameter, abs(y[1] - y[0]), through=True)


def along_z(diameter: float, at: Point, z: Point) -> Bore:
    """Through bore along z at (first, second) coordinates, from the first height to the second."""
    sense = UP if z[1] > z[0] else DOWN
    return Bore((at[0], at[1], z[0]), (0.0, 0.0, sense), diameter, abs(z[1] - z[0]), through=True)


def between(diameter: float, start: Triple, end: Triple) -> Bore:
    """Through bore from one point to another."""
    way = np.subtract(end, start)
    depth = float(np.linalg.norm(way))
    x, y, z = (float(v) for v in way / depth)
    return Bore(start, (x, y, z), diameter, depth, through=True)


def blind(bore: Bore, tip_deg: float = 0.0) -> Bore:
    """The same with an end: flat, or a drill's tip beyond its depth."""
    return replace(bore, through=False, tip_deg=tip_deg)


def sunk(bore: Bore) -> Bore:
    """The same as a flat counterbore for a head."""
    return replace(blind(bore), is_counterbore=True)


def tapped(bore: Bore, size: str, thread_mm: float | None = None) -> Bore:
    """The same with a thread.

    Args:
        bore: A through bore, of which only the place counts; it gets the tap drill's diameter.
        size: Such as "M4".
        thread_mm: Usable depth of a blind thread, which is drilled deeper, with a tip; None: drilled through, and
            tapped as deep as a screw gains by it.
    """
    row = catalogue.screw(size)
    drill = row.tap_drill_mm
    if thread_mm is None:
        usable = min(bore.depth_mm, _THREAD_DIAMETERS * row.diameter_mm)
        return replace(bore, diameter_mm=drill, thread=size, thread_mm=usable)
    deep = drilled_mm(size, thread_mm)
    return replace(blind(bore, TIP_DEG), diameter_mm=drill, depth_mm=deep, thread=size, thread_mm=thread_mm)


def fitted(bore: Bore, fit: str, zone_mm: float | None = PLACE_MM) -> Bore:
    """The same reamed or bored to a fit, its axis in a zone; see `Bore.zone_mm`."""
    lower, upper = deviations_um(fit, bore.diameter_mm)
    surface = FITTED_RA_UM[int(fit[1:])]
    return replace(bore, fit=fit, deviations_um=(lower, upper), surface_um=surface, zone_mm=zone_mm)


def within(bore: Bore, lower_um: float, upper_um: float) -> Bore:
    """The same with deviations of its own."""
    return replace(bore, deviations_um=(lower_um, upper_um))


def placed(bore: Bore, zone_mm: float) -> Bore:
    """The same with its axis in a zone of this diameter."""
    return replace(bore, zone_mm=zone_mm)


def squared(bore: Bore, zone_mm: float) -> Bore:
    """The same with its axis square to what the part is put on, in a zone of this diameter."""
    return replace(bore, square_mm=zone_mm)


def reamed_with(bore: Bore, part: str, predrilled_mm: float = 0.0, zone_mm: float | None = None) -> Bore:
    """The same reamed at assembly together with another part's, before which its drilled axis is in a zone."""
    return replace(bore, reamed_with=part, predrilled_mm=predrilled_mm, zone_mm=zone_mm)


def slot(bore: Bore, along: Triple) -> Slot:
    """The slot that lets a pin move along a direction where a blind fitted bore would hold it."""
    if bore.deviations_um is None or bore.zone_mm is None or bore.through:
        raise ValueError(
            f"the bore of {bore.diameter_mm:g} mm has no fit, no zone, or no floor: no slot takes its place"
        )
    return Slot(
        start_mm=bore.start_mm,
        direction=bore.direction,
        along=along,
        width_mm=bore.diameter_mm,
        long_mm=bore.diameter_mm + SLOT_MM,
        depth_mm=bore.depth_mm,
        fit=bore.fit,
        deviations_um=bore.deviations_um,
        zone_mm=bore.zone_mm,
    )


def slot_tool(one: Slot) -> cq.Shape:
    """What a slot takes away, its corners as round as its cutter; it stands out where the slot enters."""
    way = cq.Vector(*one.direction)
    plane = cq.Plane(cq.Vector(*one.start_mm) - way * THROUGH_MM, cq.Vector(*one.along), way)
    prism = cq.Workplane(plane).rect(one.long_mm, one.width_mm).extrude(one.depth_mm + THROUGH_MM)
    return prism.edges(cq.selectors.ParallelDirSelector(way)).fillet(SLOT_CUTTER_MM / 2).val()  # type: ignore[return-value]


def tool(bore: Bore) -> cq.Solid:
    """What a bore takes away: it stands out where the bore enters and, of a through bore, where it comes out."""
    start, along = np.array(bore.start_mm), np.array(bore.direction)
    begin = start - THROUGH_MM * along
    length = bore.depth_mm + THROUGH_MM + (THROUGH_MM if bore.through else 0.0)
    if not bore.tip_deg:
        return cylinder(bore.diameter_mm, begin.tolist(), (begin + length * along).tolist())
    radius, tip = bore.diameter_mm / 2, tip_mm(bore.diameter_mm, bore.tip_deg)
    drill = turned([(0.0, 0.0), (radius, 0.0), (radius, length), (0.0, length + tip)])
    across = np.eye(3)[int(np.argmin(np.abs(along)))]
    plane = cq.Plane(cq.Vector(*begin), cq.Vector(*np.cross(across, along)), cq.Vector(*along))
    upright = drill.rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 90.0)
    return cq.Solid(upright.moved(plane.location).wrapped)


def group(callout: str, bores: Iterable[Bore]) -> Hole:
    """The record of equal bores.

    Args:
        callout: What the drawing says of them.
        bores: At least one, all of one diameter.
    """
    every = tuple(replace(bore, callout=callout) for bore in bores)
    return Hole(every[0].diameter_mm, axes(every), callout, bores=every)


def axes(bores: Iterable[Bore]) -> int:
    """Counts the distinct axes of bores."""
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for bore in bores:
        point, along = np.array(bore.start_mm), np.array(bore.direction)
        apart = (np.cross(point - other, way) for other, way in found if hypot(*np.cross(along, way)) < _SAME_MM)
        if all(hypot(*off) > _SAME_MM for off in apart):
            found.append((point, along))
    return len(found)


def faces_of(solid: cq.Shape, bore: Bore) -> list[cq.Face]:
    """Finds the faces of a bore's wall in a solid: of its diameter, on its axis, between its ends."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    found, start, along = list[cq.Face](), np.array(bore.start_mm), np.array(bore.direction)
    for face in solid.Faces():
        if face.geomType() != "CYLINDER":
            continue
        cylinder = BRepAdaptor_Surface(face.wrapped).Cylinder()
        point, way = cylinder.Location(), cylinder.Axis().Direction()
        if abs(2 * cylinder.Radius() - bore.diameter_mm) >= _DIAMETER_MM:
            continue
        off = cross_length(np.array([point.X(), point.Y(), point.Z()]) - start, along)
        askew = cross_length(np.array([way.X(), way.Y(), way.Z()]), along)
        if (
            max(off, askew) < _AXIS_MM
            and 0.0 < float((np.array(face.Center().toTuple()) - start) @ along) < bore.depth_mm
        ):
            found.append(face)
    return found


class Boring:
    """Bores of a part as they are stated, group by group.

    Attributes:
        tools: What cuts them.
        holes: Their records.
    """

    def __init__(self) -> None:
        self.tools: list[cq.Shape] = []
        self.holes: list[Hole] = []

    def add(self, callout: str, bores: Iterable[Bore], again: Iterable[Bore] = ()) -> None:
        """Adds a group of equal bores, tools and record; none of none.

        Args:
            callout: What the drawing says of them.
            bores: All of one diameter.
            again: The same bores as they are made from their other ends, which take nothing more away.
        """
        every = tuple(bores)
        if every:
            self.tools += map(tool, every)
            self.holes.append(group(callout, (*every, *again)))

    def add_slots(self, callout: str, slots: Iterable[Slot]) -> None:
        """Adds a group of slots of one width, tools and record."""
        every = tuple(slots)
        self.tools += map(slot_tool, every)
        self.holes.append(Hole(every[0].width_mm, len(every), callout, is_slot=True, slots=every))
