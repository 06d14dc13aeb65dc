"""Every part is one sound solid that reaches as far as it declares, with the bores it declares."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from delta_cad.assembly.faces import SolidFace
from delta_cad.assembly.tessellation import Mesh, MeshLibrary
from delta_cad.checks.contact.features import features
from delta_cad.checks.dfm.located import location_faults
from delta_cad.checks.report import CheckResult
from delta_cad.common.vectors import cross_length
from delta_cad.solids.part import Part

_AXIS_MM = 1e-4  # two half cylinders of one bore share their axis to roundings; machinists' positions differ by 0.01 mm
ON_SURFACE_MM = 1e-4  # nodes lie on their surfaces to the tolerance of the edges there, 1e-5 mm at worst
_EXTENT_MM = 0.005  # exact boxes of free surfaces are wider by a thousandth; a machinist sees no less than 0.01 mm
_DIAMETER_MM = 1e-3  # declared diameters are written to 0.01 mm at best
_WHOLE_RAD = 4.5  # round the axis of a bore's faces: a split bore has 6.0, the end of a pocket 3.3, a sector's rim 2.6


def check_solidity(parts: Iterable[Part], meshes: MeshLibrary) -> list[CheckResult]:
    """Checks that each part is a single valid closed solid, with a mesh of its volume and the bores it declares.

    Returns:
        Results named `solid <part number>`; the value is the difference between mesh and exact volume, the limit the
        volume of a layer of each face's own deviation. A bore too small for that is missed by its vertices: they lie
        on the exact surfaces.
    """
    return [_checked(part, meshes) for part in parts]


def _checked(part: Part, meshes: MeshLibrary) -> CheckResult:
    faults = solid_faults(part.solid)
    value = limit = None
    if not faults:
        mesh = meshes[part.number]
        volume = float(part.solid.Volume())
        value, limit = abs(mesh.volume_mm3 - volume), _layer_volume(mesh)
        bare = _bare_cylinders(part, mesh)
        if not mesh.is_watertight:
            faults.append("its mesh is not watertight")
        elif value > limit:
            faults.append(f"its mesh holds {mesh.volume_mm3:.3f} mm^3, the solid {volume:.3f}")
        elif bare:
            faults.append(f"its mesh has no points on {len(bare)} cylinders, the first of {bare[0]:g} mm diameter")
        faults += compared_bores(part, bore_counts(part.solid))[0] + _extent_faults(part)
        faults += location_faults(part)
        if undeclared := compared_bores(part, bore_counts(part.solid, _WHOLE_RAD))[1]:
            faults.append(f"bores that are not declared: {undeclared}")
    sound = f"one valid closed solid, {len(part.holes)} kinds of declared bores present, as long and wide as declared"
    detail = "; ".join(faults) or sound
    return CheckResult(
        f"solid {part.number}", not faults, value, limit, "mm^3", worst_pair=(part.number,), detail=detail
    )


def _layer_volume(mesh: Mesh) -> float:
    """Bounds the difference of volume between a mesh and the exact solid, mm^3.

    The symmetric difference of the two lies within the deviation d of the mesh's surface: inside balls along its faces
    (2 d area), edges (pi d^2 length) and corners (4/3 pi d^3); the last two are covered by counting every edge fully.
    """
    if mesh.layer_mm3 is not None:
        return mesh.layer_mm3
    d = mesh.deviation_mm
    a, b, c = np.moveaxis(mesh.triangles, 1, 0)
    edges = sum(float(np.linalg.norm(q - p, axis=1).sum()) for p, q in ((a, b), (b, c), (c, a))) / 2.0
    return 2.0 * d * mesh.area_mm2 + np.pi * d**2 * edges + 4.0 / 3.0 * np.pi * d**3 * len(mesh.vertices)


def _bare_cylinders(part: Part, mesh: Mesh) -> list[float]:
    """Lists the diameters of the cylindrical faces of a part on which its mesh has fewer than three vertices, mm."""
    bare = []
    for c in features(part.solid).cylinders:
        apart = mesh.vertices - c.point
        along = apart @ c.direction
        off = np.abs(np.linalg.norm(apart - along[:, None] * c.direction, axis=1) - c.radius_mm)
        between = (along >= c.start_mm - ON_SURFACE_MM) & (along <= c.end_mm + ON_SURFACE_MM)
        if ((off <= ON_SURFACE_MM) & between).sum() < 3:
            bare.append(2.0 * c.radius_mm)
    return bare


def solid_faults(shape: Any) -> list[str]:
    """Says what keeps a `cadquery.Shape` from being one valid closed solid of positive volume, if anything does."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.TopAbs import TopAbs_SOLID

    if shape.wrapped is None or shape.wrapped.ShapeType() != TopAbs_SOLID:
        return [f"it is a {shape.ShapeType()} of {len(shape.Solids())} solids, not one Solid"]
    faults = []
    if len(shells := shape.Shells()) > 1:
        faults.append(f"it has {len(shells) - 1} closed voids")
    if not all(BRep_Tool.IsClosed_s(shell.wrapped) for shell in shells):
        faults.append("its shell is open")
    if not BRepCheck_Analyzer(shape.wrapped).IsValid():
        faults.append("the kernel finds it invalid")
    if not faults and not shape.Volume() > 0.0:
        faults.append(f"its volume is {shape.Volume():.3f} mm^3")
    return faults


def _extent_faults(part: Part) -> list[str]:
    """Says along which axes a part does not reach as far as it declares, from where to where, mm."""
    if part.extent_mm is None:
        return []
    box = part.solid.BoundingBox(_EXTENT_MM / 100.0)
    seen = (box.xmin, box.xmax), (box.ymin, box.ymax), (box.zmin, box.zmax)
    return [
        f"it reaches along {axis} from {low:.3f} to {high:.3f} mm, declared {declared[0]:.3f} to {declared[1]:.3f}"
        for axis, (low, high), declared in zip("xyz", seen, part.extent_mm, strict=True)
        if declared is not None and max(abs(low - declared[0]), abs(high - declared[1])) > _EXTENT_MM
    ]


def bore_counts(shape: Any, least_rad: float | None = None) -> dict[float, int]:
    """Counts the distinct axes of the concave cylinders of a `cadquery.Shape` by their diameter, mm (to 1 um).

    A face is concave where the outward normal points to the axis: the outside of the solid is around it. Faces of one
    split bore share their axis. Fillets inside corners are concave too, but less than half a turn: at least a half is
    asked of all faces on the axis together; with `least_rad`, that they go so far round it, one beside another or not.
    """
    axes: dict[float, list[tuple[np.ndarray, np.ndarray, list[SolidFace]]]] = {}
    for bore in (cylinder for cylinder in features(shape).cylinders if cylinder.is_hollow):
        point = bore.point - (bore.point @ bore.direction) * bore.direction
        same = axes.setdefault(round(2.0 * bore.radius_mm, 3), [])
        for direction, other_point, faces in same:
            parallel = cross_length(bore.direction, direction) < 1e-6
            if parallel and np.linalg.norm(point - other_point) < _AXIS_MM:
                faces.append(bore)
                break
        else:
            same.append((bore.direction, point, [bore]))
    counts = {}
    for diameter, same in sorted(axes.items()):
        if least_rad is None:
            count = sum(sum(face.turn_rad for face in faces) >= np.pi - 1e-6 for *_, faces in same)
        else:
            count = sum(_round_rad(faces) >= least_rad for *_, faces in same)
        if count:
            counts[diameter] = count
    return counts


def _round_rad(faces: list[SolidFace]) -> float:
    """How far faces on one axis go round it together, rad, to a degree: what two cover counts once."""
    around, first = faces[0].direction, faces[0].first
    second, angles = np.cross(around, first), np.radians(np.arange(360) + 0.5)
    covered = np.zeros(360, dtype=bool)
    for face in faces:
        start = np.arctan2(face.first @ second, face.first @ first)
        sense = np.sign(face.direction @ around)
        covered |= np.mod(sense * (angles - start), 2.0 * np.pi) <= face.turn_rad
    return float(np.radians(covered.sum()))


def slot_count(shape: Any, width_mm: float) -> int:
    """Counts the slots of a width in a `cadquery.Shape`: pairs of planes that face one another at that distance.

    Faces of two planes face one another where they come as close as the planes are.
    """
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    planes = features(shape).planes
    count = 0
    for k, one in enumerate(planes):
        for other in planes[k + 1 :]:
            between = float((other.point - one.point) @ one.direction)
            if one.direction @ other.direction > -1.0 + 1e-9 or abs(between - width_mm) > _DIAMETER_MM:
                continue
            apart = BRepExtrema_DistShapeShape(one.face.wrapped, other.face.wrapped).Value()  # type: ignore[attr-defined]
            count += abs(float(apart) - width_mm) <= _DIAMETER_MM
    return count


def compared_bores(part: Part, bores: dict[float, int]) -> tuple[list[str], str]:
    """Holds the bores that a part declares against those found, number of axes by diameter.

    Returns:
        Faults, and the diameters that were found and not declared, as text.
    """
    faults = []
    declared: dict[float, int] = {}
    for hole in part.holes:
        if hole.is_slot:
            if (seen := slot_count(part.solid, hole.diameter_mm)) != hole.count:
                faults.append(f"it has {seen} slots {hole.diameter_mm:g} mm wide, {hole.count} are declared")
            continue
        declared[hole.diameter_mm] = declared.get(hole.diameter_mm, 0) + hole.count
    for diameter, count in declared.items():
        seen = sum(n for d, n in bores.items() if abs(d - diameter) <= _DIAMETER_MM)
        if seen != count:
            faults.append(f"it has {seen} bores of {diameter:g} mm, {count} are declared")
    extra = {d: n for d, n in bores.items() if all(abs(d - x) > _DIAMETER_MM for x in declared)}
    return faults, ", ".join(f"{n} of {d:g} mm" for d, n in extra.items())
