"""The coordinates that place the faces of a part."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, degrees

import numpy as np

from delta_cad.export.drawings.part.faces import Face, is_across, is_along, is_straight
from delta_cad.export.drawings.part.holes import Bore
from delta_cad.export.drawings.part.record import SAME_MM, Features, Place, Size
from delta_cad.export.drawings.part.shape import (
    both_tangent,
    chamfer_leg,
    ends_of,
    is_fillet,
    is_slot_wall,
    is_tangent,
    unit,
)

_AUXILIARY = 3  # planes of one slanted pair of directions from which on they get a view of their own


def _place(
    found: Features,
    key: str,
    along: np.ndarray,
    at: np.ndarray,
    end_on: np.ndarray | None = None,
    points: np.ndarray | None = None,
) -> None:
    first = next(float(c) for c in along if abs(c) > 1e-6)
    along = along if first > 0.0 else -along
    at = np.array(at, dtype=float)
    found.places.append(Place(key, along, float(at @ along), at, end_on, at[None] if points is None else points))


def place_bores(found: Features, third: bool) -> None:
    """Two coordinates for each bore; those on the axis of a turned part have none, radial ones that along it."""
    for g, group in enumerate(found.groups):
        turns = []
        for b, bore in enumerate(group.bores):
            key = f"bore {g}.{b}"
            if found.turned:
                if not is_along(bore.axis, found.main):
                    _place(found, f"{key} along", found.main, bore.point)
                    turns.append(bore)
                continue
            if third and not is_along(bore.axis, found.main) and not is_straight(bore.axis):
                continue
            for across in _across(bore.axis, found.main):
                _place(found, f"{key} {_name(across)}", across, bore.point, bore.axis)
        if len(turns) > 1:
            group.callout = (*group.callout[:-1], f"{group.callout[-1]}, at {_angles(turns, found.main)}")


def _angles(bores: Sequence[Bore], axis: np.ndarray) -> str:
    first = bores[0].axis
    aside = np.cross(axis, first)
    found = sorted(round(degrees(atan2(float(b.axis @ aside), float(b.axis @ first))) % 360.0, 1) for b in bores)
    return " and ".join(f"{angle:g}°" for angle in found) + " about the axis"


def _across(axis: np.ndarray, main: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two directions across an axis: of the part's own where there are, else the main one and what is across both."""
    own = [unit(k) for k in range(3) if is_across(unit(k), axis)]
    if len(own) == 2:
        return own[0], own[1]
    second = np.cross(main, axis)
    return main, second / np.linalg.norm(second)


def _name(along: np.ndarray) -> str:
    k = int(np.argmax(np.abs(along)))
    return "xyz"[k] if is_straight(along) else f"at {degrees(np.arccos(abs(along[k]))):.1f} to {'xyz'[k]}"


def place_steps(found: Features, own: Sequence[Face]) -> None:
    """The ends of every step along the axis of a turned part; planes along the axis, its flats, across it."""
    axis, known = found.main, []
    for n, face in enumerate(own):
        if face.kind == "plane" and is_across(face.axis, axis):
            over = [f for f in own if f.kind == "plane" and float(f.axis @ face.axis) < -1.0 + 1e-9]
            if len(over) == 1 and abs(float((over[0].point + face.point) @ face.axis)) < SAME_MM:
                across = 2.0 * float(face.point @ face.axis)
                key = f"flats {across:.3f}"
                if not any(size.key == key for size in found.sizes):
                    found.sizes.append(Size(key, f"{round(across, 3):g} across flats", [face], "flat"))
                continue
            _place(found, f"flat {n}", face.axis, face.middle + _onto(face), np.cross(axis, face.axis), face.corners)
            continue
        ends = face.reach(axis) if face.kind in ("cylinder", "cone", "plane", "torus") else ()
        for end in ends:
            if _at_chamfer(face, axis, end) or any(abs(end - other) < SAME_MM for other in known):
                continue
            if face.kind == "cylinder" and not is_along(face.axis, axis):
                continue
            known.append(end)
            rim = face.corners[np.abs(face.corners @ axis - end) < SAME_MM]
            _place(found, f"step {n} {end:.3f}", axis, rim[0], None, rim)
    for n, face in enumerate(own):
        if face.kind != "sphere":
            continue
        rims = [points[0] for _, points in face.borders if np.ptp(points @ axis) < SAME_MM]
        for at in (face.point, *rims):
            if not any(abs(float(at @ axis) - other) < SAME_MM for other in known):
                known.append(float(at @ axis))
                _place(found, f"ball {n} {at @ axis:.3f}", axis, at)


def _onto(face: Face) -> np.ndarray:
    """From the middle of a plane face's box to the plane."""
    return ((face.point - face.middle) @ face.axis) * face.axis


def _at_chamfer(face: Face, axis: np.ndarray, end: float) -> bool:
    """Whether a face ends at a chamfer, so that the edge that counts is the one beyond it."""
    chamfers = [points for other, points in face.borders if chamfer_leg(other) is not None]
    return face.kind == "cylinder" and any(float(np.abs(points @ axis - end).max()) < SAME_MM for points in chamfers)


def place_faces(found: Features, own: Sequence[Face]) -> None:
    """Coordinates of planes, arcs and balls of a part that is not turned."""
    main = found.main
    slanted = [f for f in own if f.kind == "plane" and is_across(f.axis, main) and not is_straight(f.axis)]
    pairs = _pairs(slanted, main)
    for n, face in enumerate(own):
        if face.kind == "plane":
            at = face.middle + _onto(face)
            if is_straight(face.axis):
                if is_along(face.axis, main) or not both_tangent(face, main):
                    _place(found, f"plane {n}", face.axis, at, None, face.corners)
            elif is_across(face.axis, main):
                if any(is_along(face.axis, a) or is_across(face.axis, a) for a in pairs):
                    if not both_tangent(face, main):
                        _place(found, f"plane {n}", face.axis, at, None, face.corners)
                else:
                    _place_corners(found, n, face)
            else:
                _place_corners(found, n, face)
        elif face.kind == "cylinder" and not is_fillet(face):
            along = [k for k in range(3) if is_across(unit(k), face.axis)]
            if len(along) == 2:
                for k in along:
                    at = face.point + ((face.middle - face.point) @ face.axis) * face.axis
                    _place(found, f"centre {n} {'xyz'[k]}", unit(k), at, face.axis)
        elif face.kind == "sphere":
            for k in range(3):
                _place(found, f"ball {n} {'xyz'[k]}", unit(k), face.point)


def _pairs(slanted: Sequence[Face], main: np.ndarray) -> list[np.ndarray]:
    """Directions of slanted planes that are enough, with those across them, for a view of their own."""
    pairs: list[tuple[np.ndarray, int]] = []
    for face in slanted:
        if both_tangent(face, main):
            continue
        for k, (axis, count) in enumerate(pairs):
            if is_along(axis, face.axis) or is_across(axis, face.axis):
                pairs[k] = axis, count + 1
                break
        else:
            pairs.append((face.axis, 1))
    return [axis for axis, count in pairs if count >= _AUXILIARY]


def _place_corners(found: Features, n: int, face: Face) -> None:
    """Both coordinates of each end of a slanted plane that is no tangent there."""
    main = found.main
    seen = [unit(k) for k in range(3) if not is_along(unit(k), main)]
    for m, (other, points) in enumerate(ends_of(face, main)):
        if is_tangent(face, other) or is_slot_wall(other, found):
            continue
        if both_tangent(face, main, found) and (other.kind != "plane" or both_tangent(other, main, found)):
            continue
        for along in seen:
            _place(found, f"corner {n}.{m} {_name(along)}", along, points.mean(axis=0), main)


def auxiliary_directions(found: Features) -> list[np.ndarray]:
    """Slanted directions, in the plane of the main view, along which something is placed; one of each pair."""
    slanted: list[np.ndarray] = []
    for place in found.places:
        if is_straight(place.along):
            continue
        if not any(is_along(place.along, a) or is_across(place.along, a) for a in slanted):
            slanted.append(place.along)
    return slanted
