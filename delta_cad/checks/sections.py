"""Load-bearing parts have the cross-sections that the structural model uses, as read from the exact solids.

A solid is cut across a bar wherever something of it begins or ends, and halfway between: at every corner of its edges
and at both sides of its round faces. Between two such places a section changes steadily, so nothing sawn or notched
can lie between two stations, however thin; a grid is added for slow tapers.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.assembly.faces import SolidFace
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.features import features
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions.tolerances import tip_mm
from delta_cad.solids.part import Bore, Part, location_of
from delta_cad.structure.spans import Span

if TYPE_CHECKING:
    import cadquery as cq

_STEP_MM = 8.0  # of the grid: a taper of 1:10 changes by 4 % of a section 20 mm high
_APART_MM = 0.02  # places that are closer are one: roundings of a turned frame, and what no saw cuts
_ALIKE = 0.99  # least share of the area of its like: drawings repeat to roundings
_DIAMETER_MM = 1e-3  # declared diameters are written to 0.01 mm at best
_ALONG = 1e-6  # sine of an angle to an axis that counts as along or across it
_SHOWN = 8  # faults that a report names; their number is told


@dataclass(frozen=True)
class _Cut:
    """What a solid leaves in planes across a span: (n,) each, of sections about their own centroids.

    Attributes:
        area: mm^2.
        filled: Area with declared bores filled where the span says so, mm^2.
        about_y: Second moment about the section's y of what is filled, mm^4.
        about_z: The same about z.
    """

    area: np.ndarray
    filled: np.ndarray
    about_y: np.ndarray
    about_z: np.ndarray


@dataclass(frozen=True)
class _Share:
    """Ratio of a result to its requirement, at least 1 if it holds, and its name."""

    value: float
    part: str
    text: str


def check_sections(assembly: Assembly, spans: Sequence[Span]) -> list[CheckResult]:
    """Holds the sections of what carries against those that the structure's table assumes.

    Args:
        assembly: The machine.
        spans: What of which part has which section.

    Returns:
        `sections carry`, the smallest share of an asked area or second moment that any section has, or of the area of
        those that are alike; and `sections no heavier`, the largest share of the largest area allowed. 1 is the limit
        of both.
    """
    parts = {part.number: part for part in assembly.parts}
    groups: dict[tuple[str, str], list[Span]] = {}
    for span in spans:
        groups.setdefault((span.part, span.name), []).append(span)
    carry: list[_Share] = []
    heavy: list[_Share] = []
    count = 0
    for (number, _), alike in groups.items():
        if number not in parts:
            carry.append(_Share(0.0, number, f"{number} is missing"))
            continue
        moved = [parts[number].solid.moved(_location(np.linalg.inv(span.frame))) for span in alike]
        stations = _stations(moved, alike[0].reach_mm)
        if not len(stations):  # a leg whose pad begins at its foot
            continue
        cuts = [_cut(parts[number], solid, span, stations) for solid, span in zip(moved, alike, strict=True)]
        for span, cut in zip(alike, cuts, strict=True):
            carry += _carried(span, stations, cut)
            heavy += _weighed(span, stations, cut)
        carry += _compared(alike[0], stations, cuts)
        count += len(stations) * len(alike)
    wording = f"{count} sections of {len({span.part for span in spans})} parts"
    return [
        _result("sections carry", min, carry, wording),
        _result("sections no heavier", max, heavy, wording),
    ]


def _result(name: str, worst: Callable[..., _Share], shares: list[_Share], wording: str) -> CheckResult:
    """The share that decides, smallest or largest, against 1."""
    if not shares:
        return CheckResult(name, False, None, 1.0, "", detail="the structure's table has no bar in any part")
    one = worst(shares, key=lambda share: share.value)
    bad = [share for share in shares if worst(share.value, 1.0) != 1.0]
    texts = list(dict.fromkeys(share.text for share in sorted(bad, key=lambda s: s.value, reverse=worst is max)))
    detail = f"{len(bad)} fail: {'; '.join(texts[:_SHOWN])}; {wording}" if bad else f"closest: {one.text}; {wording}"
    return CheckResult(name, not bad, one.value, 1.0, "", worst_pair=(one.part,), detail=detail)


def _carried(span: Span, stations: np.ndarray, cut: _Cut) -> Iterator[_Share]:
    """The smallest share of each of area and second moments along a span."""
    assumed = [span.assumed(x) for x in stations]
    for what, found, required in (
        ("area", cut.filled, [s.area_mm2 for s in assumed]),
        ("second moment about y", cut.about_y, [s.about_y_mm4 for s in assumed]),
        ("second moment about z", cut.about_z, [s.about_z_mm4 for s in assumed]),
    ):
        shares = found / np.array(required)
        k = int(shares.argmin())
        text = (
            f"{span.part}, {span.name} at {_place(span, stations[k])}: {shares[k]:.3f} of the {what} that the "
            f"structure assumes, {span.least:.3f} required"
        )
        yield _Share(float(shares[k]) / span.least, span.part, text)


def _weighed(span: Span, stations: np.ndarray, cut: _Cut) -> Iterator[_Share]:
    """The largest share of the area along a span, where it is bounded."""
    if not np.isfinite(span.most):
        return
    shares = cut.area / np.array([span.assumed(x).area_mm2 for x in stations])
    k = int(shares.argmax())
    text = (
        f"{span.part}, {span.name} at {_place(span, stations[k])}: {shares[k]:.3f} of the area that the structure "
        f"assumes, at most {span.most:.3f} allowed"
    )
    yield _Share(float(shares[k]) / span.most, span.part, text)


def _compared(span: Span, stations: np.ndarray, cuts: list[_Cut]) -> Iterator[_Share]:
    """The smallest share of an area in the largest of those that are alike."""
    areas = np.stack([cut.area for cut in cuts])
    shares = areas.min(axis=0) / np.maximum(areas.max(axis=0), np.finfo(float).tiny)
    k = int(shares.argmin())
    if len(cuts) > 1:
        text = f"{span.part}, {span.name} at {_place(span, stations[k])}: {shares[k]:.3f} of the area of its like"
        yield _Share(float(shares[k]) / _ALIKE, span.part, text)


def _place(span: Span, x: float) -> str:
    point = span.frame[:3, 3] + x * span.frame[:3, 0]
    return "(" + ", ".join(f"{v:.1f}" for v in point) + ") mm"


def _location(frame: np.ndarray) -> cq.Location:
    import cadquery as cq

    return cq.Location(location_of(frame))


def _stations(solids: Iterable[cq.Shape], reach_mm: tuple[float, float]) -> np.ndarray:
    """(n,) places along x at which solids are cut: halfway between those where something of one begins or ends, mm."""
    low, high = reach_mm
    events = [low, high, *np.arange(low, high, _STEP_MM)]
    for solid in solids:
        events += [vertex.X for vertex in solid.Vertices()]
        for face in (face for face in solid.Faces() if face.geomType() != "PLANE"):
            box = face.BoundingBox()
            events += [box.xmin, box.xmax]
    inside = np.unique([x for x in events if low <= x <= high])
    gaps = np.diff(inside)
    return ((inside[:-1] + inside[1:]) / 2.0)[gaps > _APART_MM]


def _cut(part: Part, solid: cq.Shape, span: Span, stations: np.ndarray) -> _Cut:
    """Cuts a solid in a span's frame.

    Where no face is its own, it is one with its neighbours: of that counts what lies in the span's sector.
    """
    moments = np.zeros((len(stations), 5))
    for k, face in _faces(solid, stations):
        if span.own is None or _is_own(face.Center(), span.own):
            moments[k] += _moments(face)
    shared = np.flatnonzero(moments[:, 0] == 0.0)
    if span.own is not None and len(shared):
        for k, face in _faces(solid, stations[shared], span.own):
            moments[shared[k]] += _moments(face)
    bare = moments[:, 0].copy()
    if span.filled:
        inward = np.linalg.inv(span.frame)
        declared = [hole.diameter_mm for hole in part.holes]
        for bore in (c.moved(inward) for c in features(part.solid).cylinders if c.is_hollow):
            if any(abs(2.0 * bore.radius_mm - diameter) <= _DIAMETER_MM for diameter in declared):
                moments += _plug(bore, stations)
        for drilled in (b for hole in part.holes for b in hole.bores if b.tip_deg):
            moments += _tip(drilled, inward, stations)
    area = np.maximum(moments[:, 0], np.finfo(float).tiny)
    about_z = moments[:, 3] - moments[:, 1] ** 2 / area
    about_y = moments[:, 4] - moments[:, 2] ** 2 / area
    return _Cut(bare, moments[:, 0], about_y, about_z)


def _is_own(middle: cq.Vector, own: tuple[float, float]) -> bool:
    """Whether a face's middle lies in the sector from a place on x that is a span's own."""
    place, half = own
    return abs(np.arctan2(middle.y, middle.x - place)) <= half


def _faces(solid: cq.Shape, stations: np.ndarray, own: tuple[float, float] | None = None) -> Iterator[tuple[int, Any]]:
    """Yields the faces that a solid leaves in planes across x, each with the number of its plane; within a sector."""
    import cadquery as cq
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common
    from OCP.TopTools import TopTools_ListOfShape

    box = solid.BoundingBox()
    size = 4.0 * max(abs(v) for v in (box.ymin, box.ymax, box.zmin, box.zmax))
    planes = []
    for x in stations.tolist():
        wide = size if own is None else 2.0 * (x - own[0]) * np.tan(own[1])
        planes.append(cq.Face.makePlane(wide, size, cq.Vector(x, 0.0, 0.0), cq.Vector(1.0, 0.0, 0.0)))
    common, arguments, tools = BRepAlgoAPI_Common(), TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(cq.Compound.makeCompound(planes).wrapped)
    tools.Append(solid.wrapped)
    common.SetArguments(arguments)
    common.SetTools(tools)
    common.Build()
    if not common.IsDone():
        return
    for face in cq.Shape.cast(common.Shape()).Faces():
        yield int(np.abs(stations - face.Center().x).argmin()), face


def _moments(face: Any) -> np.ndarray:
    """(5,) area, first moments of y and z, and their second moments about the frame's axes, mm^2 to mm^4."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    props = GProp_GProps()
    BRepGProp.SurfaceProperties_s(face.wrapped, props)
    area, centre, inertia = props.Mass(), props.CentreOfMass(), props.MatrixOfInertia()
    y, z = centre.Y(), centre.Z()
    return np.array([area, area * y, area * z, inertia.Value(3, 3) + area * y**2, inertia.Value(2, 2) + area * z**2])


def _tip(bore: Bore, inward: np.ndarray, stations: np.ndarray) -> np.ndarray:
    """(n, 5) the same of the tip of a drill along x, seen from a span's frame."""
    start, along = inward[:3, :3] @ bore.start_mm + inward[:3, 3], inward[:3, :3] @ bore.direction
    if np.linalg.norm(along[1:]) > _ALONG:
        return np.zeros((len(stations), 5))
    height, (y, z) = tip_mm(bore.diameter_mm, bore.tip_deg), start[1:]
    into = (stations - start[0]) * along[0] - bore.depth_mm
    radius = np.where(into > 0.0, np.clip(1.0 - into / height, 0.0, 1.0), 0.0) * bore.diameter_mm / 2.0
    areas = np.pi * radius**2
    return np.stack([areas, areas * y, areas * z, areas * (radius**2 / 4 + y**2), areas * (radius**2 / 4 + z**2)], 1)


def _plug(bore: SolidFace, stations: np.ndarray) -> np.ndarray:
    """(n, 5) the same of what a bore has taken from planes across x: a circle along x, a rectangle across it."""
    n, r = len(stations), bore.radius_mm
    share = bore.turn_rad / (2.0 * np.pi)
    if np.linalg.norm(bore.direction[1:]) < _ALONG:
        ends = bore.point[0] + bore.direction[0] * np.array([bore.start_mm, bore.end_mm])
        inside = (stations >= ends.min()) & (stations <= ends.max())
        y, z = bore.point[1:]
        areas, own = np.where(inside, np.pi * r**2, 0.0), (r**2 / 4.0, r**2 / 4.0)
    elif abs(bore.direction[0]) < _ALONG:
        chord = 2.0 * np.sqrt(np.maximum(r**2 - (stations - bore.point[0]) ** 2, 0.0))
        length = bore.end_mm - bore.start_mm
        y, z = (bore.point + (bore.start_mm + bore.end_mm) / 2.0 * bore.direction)[1:]
        along, across = bore.direction[1:] ** 2, bore.direction[2:0:-1] ** 2
        areas = chord * length
        own = tuple(a * length**2 / 12.0 + b * chord**2 / 12.0 for a, b in zip(along, across, strict=True))
    else:
        return np.zeros((n, 5))
    areas = areas * share
    return np.stack([areas, areas * y, areas * z, areas * (own[0] + y**2), areas * (own[1] + z**2)], axis=1)
