"""What the faces of a part are to one another: floors and sides of its holes, chamfers, tangents, equal arms."""

from __future__ import annotations

from collections.abc import Sequence
from math import atan2, degrees, pi

import numpy as np

from delta_cad.export.drawings.part.faces import Face, is_across, is_along, is_straight
from delta_cad.export.drawings.part.holes import HoleGroup
from delta_cad.export.drawings.part.record import SAME_MM, Features

_CHAMFER_MM = 2.0  # largest leg of a face at 45 degrees that is an edge broken on purpose
_ROUND_SHARE = 0.7  # of the surface, without its ends, that turns about one axis: a turned part
_GROOVE_MM = 0.5  # from the axis of a turned part to the middle of the box around a helical face


def unit(k: int) -> np.ndarray:
    """Gives the (3,) unit vector along an axis of the part."""
    return np.eye(3)[k]


def turning_axis(faces: Sequence[Face], groups: Sequence[HoleGroup]) -> np.ndarray | None:
    """The axis that a part turns about through its origin, if it is a turned part without bores beside it."""
    about = [sum(face.kind != "sphere" and is_along(face.axis, unit(k)) for face in faces) for k in range(3)]
    for k in sorted(range(3), key=lambda k: -about[k]):  # a ball turns about all: about the axis of its bore
        axis = unit(k)
        if any(
            is_along(bore.axis, axis) and np.linalg.norm(np.delete(bore.point, k)) > SAME_MM
            for g in groups
            for bore in g.bores
        ):
            continue
        share = total = 0.0
        for face in faces:
            if face.kind == "plane" and is_along(face.axis, axis):
                continue  # an end, whatever is round
            total += face.area
            if face.kind == "other":  # a groove's: about the axis where its middle is
                share += face.area if np.linalg.norm(np.delete(face.box.mean(axis=0), k)) < _GROOVE_MM else 0.0
            elif face.kind != "plane" and np.linalg.norm(np.delete(face.point, k)) < SAME_MM:
                share += face.area if face.kind == "sphere" or is_along(face.axis, axis) else 0.0
        if share > _ROUND_SHARE * total and any(f.kind in ("cylinder", "sphere") and not f.hollow for f in faces):
            round_about = [f for f in faces if f.kind in ("cylinder", "sphere") and not f.hollow and f.turn > pi + 0.1]
            centred = [f for f in round_about if np.linalg.norm(np.delete(f.point, k)) < SAME_MM]
            if centred and all(f.kind == "sphere" or is_along(f.axis, axis) for f in centred):
                return axis
    return None


def main_direction(faces: Sequence[Face], groups: Sequence[HoleGroup]) -> np.ndarray:
    """The part's axis along which most bores, arcs and slanted planes are seen in their true shape."""

    def score(k: int) -> tuple[float, float]:
        axis, reported = unit(k), 0.0
        reported += sum(4.0 for group in groups for bore in group.bores if is_along(bore.axis, axis))
        for face in faces:
            if face.kind == "cylinder" and is_along(face.axis, axis):
                reported += 2.0
            elif face.kind == "plane" and is_across(face.axis, axis) and not is_straight(face.axis):
                reported += 3.0
        reach = np.delete(np.ptp(np.concatenate([face.box for face in faces]), axis=0), k)
        return reported, float(np.prod(reach))

    return unit(max(range(3), key=score))


def is_floor(face: Face, walls: set[int]) -> bool:
    """Decides whether a face is a bore's floor or tip: all its edges are on walls of bores."""
    if not face.borders or face.kind not in ("plane", "cone"):
        return False
    if not all(id(other) in walls or other.kind == "cone" for other, _ in face.borders):
        return False
    inner = [other for other, _ in face.borders if id(other) in walls]
    widest = max((other.radius for other in inner), default=0.0)
    if not inner:
        return False
    return inner[0].off_axis(face.corners) < widest + SAME_MM and not _opens(face, inner[0])


def _opens(face: Face, wall: Face) -> bool:
    """Decides whether a bore comes out in a face instead of ending on it: it looks away from the bore's middle."""
    return face.kind == "plane" and float((face.middle - wall.middle) @ face.axis) > SAME_MM


def is_slot_wall(face: Face, found: Features) -> bool:
    """Decides whether a plane is a wall of a declared slot: another faces it at the slot's width."""
    if face.kind != "plane":
        return False
    return any(
        other.kind == "plane"
        and float(face.axis @ other.axis) < -1.0 + 1e-9
        and abs(float((other.point - face.point) @ face.axis) - slot.width_mm) < SAME_MM
        for slot in found.slots
        for other in found.faces
    )


def is_slot_side(face: Face, walls: set[int]) -> bool:
    """Decides whether it goes on where a bore's wall ends, as its tangent: a side of a slot that the bore ends."""
    for other, points in face.borders:
        if id(other) not in walls or not is_along(way(points), other.axis):
            continue
        if face.kind == "plane" and is_tangent(face, other):
            return True
        if face.kind == "cylinder" and is_along(face.axis, other.axis):
            away = face.off_axis(other.point[None])
            if min(abs(away + other.radius - face.radius), abs(away - other.radius - face.radius)) < SAME_MM:
                return True
    return False


def is_slot_floor(face: Face, found: Features) -> bool:
    """Decides whether a plane lies between both walls of a declared slot."""
    if face.kind != "plane":
        return False
    walls = [other for other, _ in face.borders if is_slot_wall(other, found)]
    above = [wall for wall in walls if float((wall.centre - face.point) @ face.axis) > SAME_MM]
    return any(float(a.axis @ b.axis) < 0.0 for a in above for b in above)


def chamfer_leg(face: Face) -> float | None:
    """Leg of a chamfer, mm; None for any other face."""
    if face.kind == "cone" and not face.hollow:
        if abs(abs(face.half_angle) - pi / 4) > 1e-6:
            return None
        low, high = face.reach(face.axis)
        leg = high - low
    elif face.kind == "plane":
        tilts = [k for k in range(3) if abs(abs(face.axis[k]) - np.sqrt(0.5)) < 1e-6]
        if not tilts:
            return None
        leg = min(float(np.ptp(face.corners[:, k])) for k in tilts)
        if leg < float(face.box[1].max() - face.box[0].min()) * 1e-9:
            return None
    else:
        return None
    return leg if leg < _CHAMFER_MM else None


def is_threefold(faces: Sequence[Face], axis: np.ndarray) -> bool:
    """Decides whether a part is the same after a third of a turn about an axis through its origin, and not round."""
    k = int(np.argmax(np.abs(axis)))
    c, s = -0.5, np.sqrt(0.75)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = c
    turn[i, j], turn[j, i] = -s, s
    middles = np.array([np.append(face.centre, face.radius) for face in faces])
    turned = np.column_stack([middles[:, :3] @ turn.T, middles[:, 3]])
    adjacent = np.linalg.norm(np.delete(middles[:, :3], k, axis=1), axis=1) > 1.0
    if not adjacent.any():
        return False
    return all(np.abs(middles - one).max(axis=1).min() < 0.01 for one in turned[adjacent])


def is_of_first_arm(face: Face, axis: np.ndarray) -> bool:
    """Decides whether a face belongs to the arm at angle 0, within 60 degrees either way, or to none."""
    k = int(np.argmax(np.abs(axis)))
    middle = face.point if face.kind == "cylinder" and is_along(face.axis, axis) else face.centre
    x, y = middle[(k + 1) % 3], middle[(k + 2) % 3]
    return bool(np.hypot(x, y) < 1.0 or -60.0 - 1e-6 < degrees(atan2(y, x)) <= 60.0 - 1e-6)


def goes_round(same: Sequence[Face]) -> bool:
    """Decides whether faces of one cylinder reach as far as it does, to all sides."""
    face = same[0]
    sides = [axis for axis in np.eye(3) if not is_along(axis, face.axis)]
    sides = [s - (s @ face.axis) * face.axis for s in sides]
    sides = [s / np.linalg.norm(s) for s in sides]
    points = np.concatenate([f.corners for f in same])
    return all(float(np.ptp(points @ side)) > 2.0 * face.radius * 0.98 for side in sides)


def is_coaxial(a: Face, b: Face) -> bool:
    """Decides whether two faces are of one kind, on one axis and of one radius."""
    alike = a.kind == b.kind and is_along(a.axis, b.axis) and abs(a.radius - b.radius) < SAME_MM
    return alike and b.off_axis(a.point[None]) < SAME_MM


def _tangent_axes(face: Face, found: Features) -> set[tuple[float, ...]]:
    """Axes, but those of fillets, of the arcs that a slanted plane touches, there or where it would go on."""
    if is_straight(face.axis):
        return set()
    arcs = [other for other in found.faces if is_tangent(face, other) and not other.hollow and not is_fillet(other)]
    return {tuple(np.round(arc.point - (arc.point @ arc.axis) * arc.axis, 2)) for arc in arcs}


def both_tangent(face: Face, main: np.ndarray, found: Features | None = None) -> bool:
    """Decides whether a plane along the main direction runs from arc to arc as their tangent."""
    ends = ends_of(face, main)
    if found is not None and len(_tangent_axes(face, found)) >= 2:
        return True
    return len(ends) >= 2 and all(is_tangent(face, other) and not is_fillet(other) for other, _ in ends)


def is_hull_line(face: Face, found: Features) -> bool:
    """Decides whether a face is seen as a line that is drawn as the tangent of two arcs."""
    return face.kind == "plane" and not found.turned and len(_tangent_axes(face, found)) >= 2


def is_slant(face: Face, found: Features) -> bool:
    """Decides whether a face is seen as a slanting line from an arc, which it touches, to a corner."""
    return face.kind == "plane" and not found.turned and len(_tangent_axes(face, found)) == 1


def ends_of(face: Face, main: np.ndarray) -> list[tuple[Face, np.ndarray]]:
    """What a plane borders on along edges in the main direction, with the edges' points."""
    return [
        (other, points)
        for other, points in face.borders
        if np.linalg.norm(points[-1] - points[0]) > SAME_MM and is_along(way(points), main)
    ]


def way(points: np.ndarray) -> np.ndarray:
    """Gives the direction from the first of some points to the last, about a unit vector; 0 where they are one."""
    way = points[-1] - points[0]
    return way / max(float(np.linalg.norm(way)), SAME_MM)


def is_tangent(plane: Face, other: Face) -> bool:
    """Decides whether a plane touches a cylinder, or would where it goes on."""
    if other.kind != "cylinder" or not is_across(plane.axis, other.axis):
        return False
    return abs(abs(float((other.point - plane.point) @ plane.axis)) - other.radius) < SAME_MM


def is_fillet(face: Face) -> bool:
    """Decides whether an arc is placed by the planes that it rounds: two, square to one another, that it touches."""
    tangent = [other.axis for other, _ in face.borders if other.kind == "plane" and is_tangent(other, face)]
    return any(is_across(a, b) for a in tangent for b in tangent)
