"""Serviceability: a key reaches every screw to loosen, and exchangeable parts come off in a straight line.

A key is an L of two round legs as wide as its corners. One leg stands in the screw's socket, on its axis, the other is
the handle, which must be free to swing by what turns a hexagon on to its next corner. Both legs may be cut, the long
one of the long type. Sockets, heads and all obstacles are read off the solids; a position of the machine counts as
free where nothing of any body is met.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.bodies import tree_of
from delta_cad.checks.contact.features import features
from delta_cad.checks.contact.placing import Key, relative_key
from delta_cad.checks.contact.shared_volume import runs_into
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.common.vectors import cross_rows
from delta_cad.dimensions.layers import CORNERS, KEYS_MM, SWING_RAD, key_legs_mm, longest_run
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.solids.part import Part, Removal, ToolAccess

_DIRECTIONS, _FINE_DIRECTIONS = 36, 144  # of the handle: every 10 degrees; 2.5 where those leave it open
HEIGHTS = 321  # of the platform on the cube's middle axis, at least
_FINE_HEIGHTS = 2001  # of those at which the arms' angles are looked at
TURN_RAD = np.radians(0.6)  # of a pinion from one of them to the next at most: a slot leaves a key 1 deg either way
_SAME_MM = 0.05  # of a socket as it is drawn and of its key
MOST_MM, TOLERANCE_MM = 16.0, 0.25  # of a base radius that keys lack: how far is looked, and how closely
MARGIN_MM = 2.0  # that keys leave of it: how far is looked
_SPREAD_STEP = 64  # of the handle's heights one in so many, then
_CHAIN = re.compile(r"^(?!bezel_|mount_).*?_(\d)(?:_|$)")  # in an occurrence's name, but of screws of panel and floor
_OFF_MM = 0.1  # a tool begins so far before the face that it stands on
_STEP_MM = 4.0  # of a part that is drawn out: a tenth of what it is drawn through
_SHOWN = 8  # faults that a report names; their number is told


@dataclass(frozen=True)
class _Socket:
    """Hexagon socket of a screw and its largest radius, mm; the mouth and depth along z of the screw's frame."""

    flats_mm: float
    mouth_mm: float
    depth_mm: float
    head_mm: float


@dataclass(frozen=True)
class _Around:
    """The obstacles around a screw, valid until its scene moves to another position.

    Attributes:
        place: (index) -> an object of the collision library, where it is at that position.
        centres_mm: (n, 3) of balls that hold them.
        radii_mm: (n) of these balls.
        deviation_mm: (n) by which a mesh may lie within its solid.
    """

    place: Callable[[int], Any]
    centres_mm: np.ndarray
    radii_mm: np.ndarray
    deviation_mm: np.ndarray

    def free(self, radius_mm: float, start_mm: np.ndarray, ends_mm: np.ndarray) -> np.ndarray:
        """Whether round tools of one length from a point (3) to others (n, 3) meet nothing, (n)."""
        import fcl

        along = ends_mm - start_mm
        length = float(np.linalg.norm(along[0]))
        along = along / length
        on_line = np.clip((self.centres_mm - start_mm) @ along.T, 0.0, length)  # (objects, tools)
        apart = np.linalg.norm(start_mm + on_line[..., None] * along - self.centres_mm[:, None], axis=-1)
        near = apart <= (self.radii_mm + radius_mm + self.deviation_mm)[:, None]
        found = np.ones(len(ends_mm), dtype=bool)
        placed: dict[int, Any] = {}
        required = np.flatnonzero(near.any(axis=0))
        aside = cross_rows(along[required], np.eye(3)[np.abs(along[required]).argmin(axis=1)])
        aside /= np.linalg.norm(aside, axis=1, keepdims=True)
        turns = np.stack([aside, cross_rows(along[required], aside), along[required]], axis=2)
        for n, turn in zip(required.tolist(), turns, strict=True):
            frame = fcl.Transform(turn, (start_mm + ends_mm[n]) / 2.0)
            for k in np.flatnonzero(near[:, n]):
                tool = fcl.CollisionObject(fcl.Cylinder(radius_mm + self.deviation_mm[k], length), frame)
                if int(k) not in placed:
                    placed[int(k)] = self.place(int(k))
                if fcl.collide(tool, placed[int(k)]):
                    found[n] = False
                    break
        return found


class Scene:
    """The machine at positions of its handle, for queries of collisions with a tool or a moved part.

    Attributes:
        count: Number of positions.
    """

    def __init__(self, assembly: Assembly, meshes: Meshes, poses_mm: np.ndarray) -> None:
        import fcl

        self.occurrences, self.meshes, self.count = assembly.occurrences, meshes, len(poses_mm)
        self.index = {o.name: k for k, o in enumerate(self.occurrences)}
        placed = assembly.poses(poses_mm)
        self.frames = np.stack([placed[o.name] for o in self.occurrences], axis=1)  # (poses, occurrences, 4, 4)
        balls = []
        for o in self.occurrences:
            mesh = meshes[o.part.number]
            low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
            balls.append((*(low + high) / 2.0, np.linalg.norm(high - low) / 2.0 + mesh.deviation_mm))
        self.stands = np.array([o.link == "base" for o in self.occurrences])
        self._objects = [fcl.CollisionObject(tree_of(meshes[o.part.number])) for o in self.occurrences]
        self._deviation = np.array([meshes[o.part.number].deviation_mm for o in self.occurrences])
        self._balls = np.array(balls)

    def around(self, pose: int, centre_mm: np.ndarray, reach_mm: float, adjacent: int, static: bool) -> _Around:
        """Possible obstacles of a tool within a reach of a point: all occurrences except one, or all static ones."""
        centres = self._centres(pose)
        near = np.linalg.norm(centres - centre_mm, axis=1) <= self._balls[:, 3] + reach_mm
        near[adjacent] = False
        if static:
            near &= self.stands
        found = np.flatnonzero(near)
        return _Around(
            lambda n: self._placed(pose, int(found[n])), centres[found], self._balls[found, 3], self._deviation[found]
        )

    def _centres(self, pose: int) -> np.ndarray:
        frame = self.frames[pose]
        return (frame[:, :3, :3] @ self._balls[:, :3, None])[..., 0] + frame[:, :3, 3]

    def met_by(self, pose: int, k: int, frame: np.ndarray, adjacent: Collection[str]) -> list[int]:
        """Indices of the occurrences whose meshes one mesh meets in another frame (4, 4), without its neighbours."""
        import fcl

        moved = self._objects[k]
        moved.setTransform(_transform(frame))
        centre = frame[:3, :3] @ self._balls[k, :3] + frame[:3, 3]
        near = np.linalg.norm(self._centres(pose) - centre, axis=1) <= self._balls[:, 3] + self._balls[k, 3]
        found = (int(j) for j in np.flatnonzero(near) if j != k and self.occurrences[j].name not in adjacent)
        return [j for j in found if fcl.collide(moved, self._placed(pose, j))]

    def _placed(self, pose: int, k: int) -> Any:
        self._objects[k].setTransform(_transform(self.frames[pose, k]))
        return self._objects[k]


def _transform(frame: np.ndarray) -> Any:
    import fcl

    return fcl.Transform(frame[:3, :3], frame[:3, 3])


def check_access(assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> list[CheckResult]:
    """Reaches every screw that is stated to be reached, and draws off every part that is stated to come off.

    The handle stands on the cube's middle axis, at the height that suits most.

    Returns:
        `tool access`: least angle over the screws by which the handle of its key is free to swing, deg, 60 asked; none
        where the screw's head cannot move out as far as it must. `parts come off`: how many cannot be drawn off.
    """
    if not assembly.reached and not assembly.removals:
        return []
    scene = Scene(assembly, meshes, up_and_down(assembly.placement, limits))
    swings = [(key_swing(reach, scene), reach) for reach in assembly.reached]
    known: dict[Key, bool] = {}
    stuck = [(what, removal) for removal in assembly.removals if (what := _stuck(removal, scene, known))]
    return [_reported_swings(swings), _reported_stuck(stuck, len(assembly.removals))]


def missing_spread_mm(assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> float:
    """Computes the shortfall of the base radius for keys to reach all static screws.

    Each chain goes outwards as it is, the platform stays: a longer base radius, as far as keys see it.

    Args:
        assembly: The machine.
        limits: Its cube.
        meshes: Of its parts.

    Returns:
        Millimetres: `MOST_MM` where that much more or something else is needed; where nothing is in the way 0 or less,
        down to `-SPARE_MM`: by so much it may be shorter.
    """
    scene = Scene(assembly, meshes, up_and_down(assembly.placement, limits)[::_SPREAD_STEP])
    still = [one for one in assembly.reached if one.screw in scene.index and scene.stands[scene.index[one.screw]]]
    held = [one for one in still if key_swing(one, scene) < SWING_RAD]
    out = np.zeros((len(scene.occurrences), 3))
    for k, occurrence in enumerate(scene.occurrences):
        if (chain := _CHAIN.search(occurrence.name)) is not None:
            out[k] = assembly.placement.geometry.radial[int(chain[1])]
    home = scene.frames.copy()

    def free(more_mm: float) -> bool:
        scene.frames[..., :3, 3] = home[..., :3, 3] + more_mm * out
        return all(key_swing(one, scene) >= SWING_RAD for one in held or still)

    low, high = (0.0, MOST_MM) if held else (-MARGIN_MM, 0.0)
    if not still or (held and not free(high)):
        return high
    if not held and free(low):
        return low
    while high - low > TOLERANCE_MM:
        middle = (low + high) / 2.0
        low, high = (low, middle) if free(middle) else (middle, high)
    return high


def up_and_down(placement: LinkPlacement, limits: CheckLimits) -> np.ndarray:
    """Positions of the handle on the cube's middle axis, its middle and then those nearest to it first, (n, 3) mm.

    From one to the next the arm that turns most, and its pinion, turn by the same.
    """
    up = np.linspace(-limits.half_side_mm, limits.half_side_mm, _FINE_HEIGHTS)
    along = np.array([0.0, 0.0, 1.0])
    angles = inverse_kinematics(placement.geometry, (limits.centre_mm + up[:, None] * along) / MM_PER_M)
    turned = np.append(0.0, np.cumsum(np.abs(np.diff(angles, axis=0)).max(axis=1)))
    count = max(HEIGHTS, ceil(placement.drive_ratio * turned[-1] / TURN_RAD) + 1)
    heights = np.append(0.0, np.interp(np.linspace(0.0, turned[-1], count), turned, up))
    return limits.centre_mm + heights[np.argsort(np.abs(heights), kind="stable"), None] * along


def _reported_swings(swings: list[tuple[float, ToolAccess]]) -> CheckResult:
    if not swings:
        limit = float(np.degrees(SWING_RAD))
        return CheckResult("tool access", True, None, limit, "deg", detail="no screw is stated to be reached")
    detail = f"free swing of a hexagon key in its socket at the best position, least of {len(swings)} screws"
    return swing_result("tool access", [(s, reach.screw, f": {reach.reason}") for s, reach in swings], detail)


def swing_result(name: str, swings: list[tuple[float, str, str]], detail: str) -> CheckResult:
    """Holds the least of some swings, each with its screw and a reason, against what a hexagon key needs."""
    swing, worst, _ = min(swings, key=lambda found: found[0], default=(2.0 * np.pi, "", ""))
    bad = [f"{screw} {np.degrees(s):.0f} deg{reason}" for s, screw, reason in swings if s < SWING_RAD]
    if bad:
        detail = f"{len(bad)} fail: {'; '.join(bad[:_SHOWN])}; {detail}"
    pair = (worst,) if worst else None
    return CheckResult(
        name, not bad, np.degrees(swing), float(np.degrees(SWING_RAD)), "deg", worst_pair=pair, detail=detail
    )


def _reported_stuck(stuck: list[tuple[str, Removal]], count: int) -> CheckResult:
    detail = f"{count} parts drawn off along their axes, {_STEP_MM:g} mm a step"
    if stuck:
        reported = "; ".join(f"{removal.name} {removal.reason}, {what}" for what, removal in stuck[:_SHOWN])
        detail = f"{len(stuck)} fail: {reported}; {detail}"
    names = tuple(removal.name for _, removal in stuck[:_SHOWN]) or None
    return CheckResult("parts come off", not stuck, len(stuck), 0, "", worst_pair=names, detail=detail)


def key_swing(reach: ToolAccess, scene: Scene) -> float:
    """Largest swing of a key's handle at any position, rad, up to the first that suffices; 0 where none is reached."""
    if reach.screw not in scene.index:
        return 0.0
    k = scene.index[reach.screw]
    socket = _socket(scene.occurrences[k].part)
    flats = next((one for one in KEYS_MM if socket and abs(socket.flats_mm - one) < _SAME_MM), None)
    if socket is None or flats is None:
        return 0.0
    keys = key_legs_mm(flats)
    if scene.stands[k]:  # what a part that stands still leaves no room for has none at any position
        keys = tuple(key for key in keys if _swing_at(0, k, socket, reach.way_mm, *key, scene, True) >= SWING_RAD)
    best = 0.0
    for pose in range(scene.count):
        for inside, handle in keys:
            best = max(best, _swing_at(pose, k, socket, reach.way_mm, inside, handle, scene))
            if best >= SWING_RAD:
                return best
    return best


def _swing_at(
    pose: int,
    k: int,
    socket: _Socket,
    way_mm: float,
    inside_mm: float,
    handle_mm: float,
    scene: Scene,
    static: bool = False,
) -> float:
    """Swing of a handle at a position, rad: of a key that stands in its socket and of one just drawn off it.

    With `static` only what stands still is in its way.
    """
    frame, radius = scene.frames[pose, k], CORNERS * socket.flats_mm / 2.0
    x, y, z = frame[:3, :3].T
    mouth = frame[:3, 3] + socket.mouth_mm * z
    around = scene.around(pose, mouth, float(np.hypot(max(inside_mm, way_mm), handle_mm)) + socket.head_mm, k, static)
    for width, end in (radius, inside_mm), (socket.head_mm, way_mm):
        if not around.free(width, mouth + _OFF_MM * z, (mouth + end * z)[None]).all():
            return 0.0
    bends = mouth + (inside_mm - socket.depth_mm) * z, mouth + inside_mm * z
    swing = 0.0
    for count in (_DIRECTIONS, _FINE_DIRECTIONS):
        angles = np.arange(count) * 2.0 * np.pi / count
        out = handle_mm * (np.cos(angles)[:, None] * x + np.sin(angles)[:, None] * y)
        free = np.ones(count, dtype=bool)
        for bend in bends:
            free[free] = around.free(radius, bend, bend + out[free]) if free.any() else True
        steps = count if free.all() else max(longest_run(free) - 1, 0)
        swing = steps * 2.0 * np.pi / count
        if not SWING_RAD - 4.0 * np.pi / _DIRECTIONS < swing < SWING_RAD:  # a free run is up to two steps longer
            break
    return swing


def _socket(part: Part) -> _Socket | None:
    """The hexagon socket of a screw, z being its axis: planes along it that face it; None where it has none."""
    sides = [
        plane
        for plane in features(part.solid).planes
        if abs(plane.direction[2]) < 1e-9 and plane.point @ plane.direction < 0.0  # the material is outside
    ]
    if not sides:
        return None
    boxes = [plane.face.BoundingBox() for plane in sides]  # type: ignore[attr-defined]
    mouth, floor = max(box.zmax for box in boxes), min(box.zmin for box in boxes)
    head = max(c.radius_mm for c in features(part.solid).cylinders if not c.is_hollow)
    flats = 2.0 * min(-float(plane.point @ plane.direction) for plane in sides)
    return _Socket(flats, mouth, mouth - floor, head)


def _stuck(removal: Removal, scene: Scene, known: dict[Key, bool]) -> str:
    """What a part meets that is drawn off, as text; empty where its way is free at the first position.

    It goes until the whole machine lies behind it, in steps. What the meshes meet, the exact solids decide.
    """
    if removal.name not in scene.index:
        return "is missing"
    k = scene.index[removal.name]
    start = scene.frames[0, k]
    along = start[:3, :3] @ np.array(removal.along)
    points = scene.meshes[scene.occurrences[k].part.number].vertices @ start[:3, :3].T + start[:3, 3]
    ahead = max(
        float(((scene.meshes[o.part.number].vertices @ f[:3, :3].T + f[:3, 3]) @ along).max())
        for o, f in zip(scene.occurrences, scene.frames[0], strict=True)
    )
    way = ahead - float((points @ along).min())
    for step in np.linspace(0.0, way, int(np.ceil(way / _STEP_MM)) + 1)[1:]:
        moved = start.copy()
        moved[:3, 3] += step * along
        for j in scene.met_by(0, k, moved, removal.loose):
            a, b = scene.occurrences[k], scene.occurrences[j]
            seen = np.linalg.inv(scene.frames[0, j]) @ moved
            key = (id(a.part), id(b.part), *relative_key("", "", seen))
            if key not in known:
                known[key] = runs_into(b.part.solid, a.part.solid, seen)
            if known[key]:
                return f"meets {b.name} after {step:.0f} mm"
    return ""
