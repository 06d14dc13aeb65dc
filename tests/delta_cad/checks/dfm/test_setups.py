"""Clampings of every part of the published machines against a count from the faces of its finished solid.

90 s of processor: the solids of best.json and the gallery are made.

The count reads no declared bore: it takes hollow cylinders and straight inner corners off the faces, casts rays on the
tessellated solid where the product asks the kernel, and tries every set of directions where the product takes one after
another.
"""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.assemble import assemble
from delta_cad.checks.dfm.setups import setups
from delta_cad.design import load_design
from delta_cad.dimensions import dimensions
from delta_cad.solids.part import Part
from tests.committed import ROOT

MACHINES = (ROOT / "best.json", *sorted((ROOT / "docs" / "gallery").glob("*-*.json")))
SAME = 1e-3
SHORT_MM = 0.1  # an edge within what ISO 2768-m allows a size up to 3 mm is on no part that is made
FAR_MM = 0.02  # off a face, from where rays go: beyond the chords of the tessellation
WHOLE_RAD = 4.5


Triangles = np.ndarray  # (m, 3, 3): corners


def triangles_of(solid: cq.Solid) -> Triangles:
    points, corners = solid.tessellate(0.005, 0.05)
    return np.array([p.toTuple() for p in points])[np.array(corners)]


def crossings(mesh: Triangles, start: np.ndarray, way: np.ndarray) -> int:
    """How many triangles a ray crosses (Moeller and Trumbore)."""
    first, second, off = mesh[:, 1] - mesh[:, 0], mesh[:, 2] - mesh[:, 0], start - mesh[:, 0]
    across = np.cross(way, second)
    det = (first * across).sum(axis=1)
    first, second, off, across, det = (one[np.abs(det) > 1e-12] for one in (first, second, off, across, det))
    u, turned = (off * across).sum(axis=1) / det, np.cross(off, first)
    v, far = (turned @ way) / det, (second * turned).sum(axis=1) / det
    return int(((u >= 0.0) & (v >= 0.0) & (u + v <= 1.0) & (far > 0.0)).sum())


def is_free(mesh: Triangles, starts: np.ndarray, way: np.ndarray) -> bool:
    return not any(crossings(mesh, start, way) for start in starts)


def is_inside(mesh: Triangles, point: np.ndarray) -> bool:
    way = np.array([0.5377, 0.2913, 0.7912])  # along no edge of a part
    return crossings(mesh, point, way) % 2 == 1


def around(way: np.ndarray, radius: float) -> np.ndarray:
    first = np.cross(way, np.eye(3)[int(np.abs(way).argmin())])
    first /= np.linalg.norm(first)
    turn = np.linspace(0.0, 2 * np.pi, 8, endpoint=False)[:, None]
    return radius * (np.cos(turn) * first + np.sin(turn) * np.cross(way, first))


def bored(face: Any, mesh: Triangles) -> list[np.ndarray] | None:
    """Directions from which a hollow cylinder that goes most of the way round is bored; None: it is none."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface

    surface = BRepAdaptor_Surface(face.wrapped)
    if surface.LastUParameter() - surface.FirstUParameter() < WHOLE_RAD:
        return None
    cylinder = surface.Cylinder()
    position, direction = cylinder.Axis().Location(), cylinder.Axis().Direction()
    origin, along = (np.array([v.X(), v.Y(), v.Z()]) for v in (position, direction))
    at = surface.Value((surface.FirstUParameter() + surface.LastUParameter()) / 2, surface.FirstVParameter())
    out = np.array([at.X(), at.Y(), at.Z()]) - origin
    out -= (out @ along) * along
    normal = np.array(face.normalAt(cq.Vector(at)).toTuple())
    if normal @ out > 0.0:
        return None
    middle = origin + (surface.FirstVParameter() + surface.LastVParameter()) / 2 * along
    starts = middle + around(along, 0.9 * cylinder.Radius())
    return [way for way in (along, -along) if is_free(mesh, starts, way)]


def milled(edge: Any, faces: list[Any], mesh: Triangles) -> list[np.ndarray] | None:
    """Directions from which a flat end mill that stands on a plane makes an inner corner; None: it is none."""
    middle = edge.positionAt(0.5)
    p = np.array(middle.toTuple())
    one, other = (np.array(face.normalAt(middle).toTuple()) for face in faces)
    if abs(one @ other) > 0.9 or not is_inside(mesh, p + FAR_MM * (one - other)):
        return None
    ways = []
    for floor, up, wall in ((faces[0], one, other), (faces[1], other, one)):
        if floor.geomType() != "PLANE":
            continue
        off = wall - (wall @ up) * up
        start = p + FAR_MM * up + 0.2 * off / np.linalg.norm(off)
        if wall @ up > -SAME and is_free(mesh, start[None], up):
            ways.append(up)
    return ways


def wanted(solid: cq.Solid) -> list[list[np.ndarray]]:
    """For each bore and each inner corner, the directions that a tool comes from."""
    mesh, found = triangles_of(solid), []
    found += [bored(face, mesh) for face in solid.Faces() if face.geomType() == "CYLINDER"]
    owners: dict[int, tuple[Any, list[Any]]] = {}
    for face in solid.Faces():
        for edge in face.Edges():
            owners.setdefault(edge.hashCode(), (edge, []))[1].append(face)
    pairs = ((edge, faces) for edge, faces in owners.values() if len(faces) == 2 and edge.geomType() == "LINE")
    found += [milled(edge, faces, mesh) for edge, faces in pairs if edge.Length() > SHORT_MM]
    return [ways for ways in found if ways]


def least(features: list[list[np.ndarray]]) -> int:
    """The fewest clampings of all sets of directions; those square to one axis may be one, on a rotary table."""
    ways = np.unique(np.round([way for one in features for way in one] or np.zeros((0, 3)), 3) + 0.0, axis=0)

    def directions(left: list[list[np.ndarray]]) -> int:
        has = [{k for k, way in enumerate(ways) if any(way @ one > 1.0 - SAME for one in feature)} for feature in left]
        for count in range(len(ways) + 1):
            for chosen in combinations(range(len(ways)), count):
                if all(one & set(chosen) for one in has):
                    return count
        raise AssertionError(left)

    best = directions(features)
    for axis in (*np.eye(3), *ways):
        left = [one for one in features if all(abs(way @ axis) > 10 * SAME for way in one)]
        if len(left) < len(features):
            best = min(best, 1 + directions(left))
    return max(best, 1)


@pytest.mark.quick(1)
@pytest.mark.parametrize("file", MACHINES, ids=lambda file: file.stem)
def test_setups_are_those_that_the_faces_of_the_solids_take(file: Path) -> None:
    assembly = assemble(dimensions(load_design(file)))
    made = [part for part in assembly.parts if part.make]
    counted = {part.number: (round(next(setups(part)).value), least(wanted(part.solid))) for part in made}
    assert len(counted) > 8
    assert {number: both for number, both in counted.items() if both[0] != both[1]} == {}


def test_both_rules_see_a_bore_from_a_third_side() -> None:
    from delta_cad.solids.boring import Boring, along_y, along_z, between, blind
    from delta_cad.solids.making import material
    from delta_cad.solids.primitive import box, cut, one_solid

    def block(*bores: Any) -> Part:
        boring = Boring()
        for k, bore in enumerate(bores):
            boring.add(str(k), [bore])
        solid = one_solid(cut(box((0, 0, 0), (40, 30, 20)), boring.tools), "block")
        return Part("block", "block", solid, material("aluminium-6082"), True, tuple(boring.holes))

    two = blind(along_z(4.0, (10.0, 10.0), (20.0, 10.0))), blind(along_z(4.5, (30.0, 10.0), (0.0, 9.0)))
    third = blind(between(5.0, (40.0, 20.0, 5.0), (28.0, 20.0, 5.0))), blind(along_y(5.5, (20.0, 15.0), (30.0, 22.0)))
    for bores, count in ((two[:1], 1), (two, 1), ((*two, third[0]), 1), ((*two, *third), 2)):
        part = block(*bores)
        assert (round(next(setups(part)).value), least(wanted(part.solid))) == (count, count)
