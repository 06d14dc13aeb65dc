"""The capstan's cable over the whole stroke: its strands follow the groove's helix, its turns stay in the groove.

And what hands do to set its tension: keys reach what they turn or hold, the balance that pulls the arm has room.

All of it is read off the solids as they are placed: rim, nose and lugs of the sector, the pinion's groove and where its
axis is, the turns upon it. The cable is developed into a plane: on the rim and between the drums it is one straight
line from its lug to where it leaves the turns.

Source: developed geometry of crossed internal tangents, as in `dimensions.cable_run`, which places what is read here.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from math import acos, atan, atan2, cos, degrees, hypot, inf, pi, sin, sqrt, tau

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.faces import SolidFace
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.contact.access import Scene, key_swing
from delta_cad.checks.contact.features import features
from delta_cad.checks.contact.order.check import brought, members
from delta_cad.checks.links import swept_links
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.cable_run import FLEET_LIMIT_RAD
from delta_cad.dimensions.capstan import SET_SCREW
from delta_cad.dimensions.layers import SWING_RAD
from delta_cad.dimensions.tolerances.cable_setting import HOOK_MM, CableSetting, bench_pull_N, cable_setting
from delta_cad.drive.laid_cable import FRICTION
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.part import ToolAccess

_ANGLES = 201  # of the arm between its stops
_ALONG = 1e-6  # sine of the angle between directions that count as one
_OFF_MM = 0.05  # by which turns may lie off their groove's bottom or axis
_LINE_MM = 200.0  # length that a balance takes with its loop of cord, from the cross-bar on
_DRAWN_MM = 1.0  # by which a key goes in and out of its screw
_TURNS = 25  # angles of the arm, one of which must let the tension screw's key swing
_KEY_N_m = 0.82  # torque that a key of 1.5 mm bears, ISO 2936, and bending by as much; from memory: check


class _NotFoundError(ValueError):
    """A solid has no face of a kind that a capstan's has."""


@dataclass(frozen=True)
class _Sector:
    """The cable's way on a sector, about its bore: radius of the rim, its sides, polar angles and y of both ends."""

    rim_mm: float
    sides_mm: tuple[float, float]
    ends_rad: tuple[float, float]
    lugs_mm: tuple[float, float]
    lug_off_mm: float


@dataclass(frozen=True)
class _Pinion:
    """A pinion and its turns in the shoulder's frame: axis, groove, helix; ends of the turns, inner strand's first."""

    axis_mm: tuple[float, float]
    pitch_mm: float
    bottom_mm: float
    groove_mm: tuple[float, float]
    climb_rad: float
    wrap_rad: float
    ends_mm: tuple[float, float]
    off_mm: float


@dataclass(frozen=True)
class _Seen:
    """What a chain's cable does over its stroke: largest angle, least spare groove or rim, and both in words."""

    fleet_rad: float
    margin_mm: float
    wording: str


def check_cable(assembly: Assembly) -> list[CheckResult]:
    """Checks the fleet angle against the cable's limit, and both take-off points against the ends of the groove.

    Returns:
        `cable fleet angle`, the largest of all strands against the plane across the axes over the stroke, deg;
        `cable on its groove`, the least length of groove beyond a take-off and of rim beyond a lug, mm, or below 0 how
        far turns or lugs are off their drums. None for a direct drive.
    """
    if not swept_links(assembly.placement):
        return []
    limit = degrees(FLEET_LIMIT_RAD)
    seen: list[tuple[int, _Seen]] = []
    for i in CHAINS:
        try:
            seen.append((i, _seen(assembly, i)))
        except _NotFoundError as error:
            wording = f"chain {i}: {error}"
            return [
                CheckResult("cable fleet angle", False, None, limit, "deg", detail=wording),
                CheckResult("cable on its groove", False, None, 0.0, "mm", detail=wording),
            ]
    i, steep = max(seen, key=lambda one: one[1].fleet_rad)
    j, short = min(seen, key=lambda one: one[1].margin_mm)
    angle, margin = steep.fleet_rad, short.margin_mm
    return [
        CheckResult(
            "cable fleet angle",
            angle <= FLEET_LIMIT_RAD,
            degrees(angle),
            limit,
            "deg",
            None,
            (f"sector_{i}",),
            steep.wording,
        ),
        CheckResult("cable on its groove", margin >= 0.0, margin, 0.0, "mm", None, (f"pinion_{j}",), short.wording),
    ]


def check_cable_setting(assembly: Assembly, d: Dimensions, meshes: Meshes) -> list[CheckResult]:
    """Checks that hands can set the cable as the manual says, in each drive as far as it is made by then.

    Returns:
        `cable setting`: number of faults: a step that is missing; a screw that its key does not reach where the arm
        stands, a tension screw whose key does not swing; a balance's line that meets something; a key that bends, a
        cable that is pulled by more than on the bench. None for a direct drive.
    """
    setting = cable_setting(d)
    if setting is None:
        return []
    faults = [fault for i in CHAINS for fault in _unset(assembly, d, setting, meshes, i)]
    held, flats = setting.slips_N * setting.capstan.run.pinion_mm / MM_PER_M, catalogue.set_screw(SET_SCREW).socket_mm
    if held > _KEY_N_m:
        faults.append(f"{held:.2f} N m bend the key of {flats:g} mm that holds the pinion, which bears {_KEY_N_m:g}")
    if setting.tight_N > bench_pull_N(d):
        faults.append(f"the pull may tension the cable by {setting.tight_N:.1f} N, the bench by {bench_pull_N(d)} N")
    along = [setting.capstan.laid(np.zeros(1)).pulled(1.0, friction) for friction in FRICTION]
    spread = ", ".join(
        f"{name} {along[1][name]:.2f} to {along[0][name]:.2f}" for name in along[0] if name != "carriage"
    )
    low, high = setting.pull_N
    reported = (
        f"stands at {low:g} N, creeps before {high:g} N at {setting.lever_mm:.1f} mm, read to {setting.off_N:.2g} N: "
        f"{setting.proven_N:.1f} N between the strands are held there, {setting.needed_N:.1f} N anywhere, at most "
        f"{setting.tension_N:.1f} N in either at rest; of 1 N at the carriage come, by friction of {FRICTION[1]:g} to "
        f"{FRICTION[0]:g}: {spread}"
    )
    detail = f"{'; '.join(faults)}; {reported}" if faults else reported
    return [CheckResult("cable setting", not faults, len(faults), 0, "", detail=detail)]


def _unset(assembly: Assembly, d: Dimensions, setting: CableSetting, meshes: Meshes, i: int) -> list[str]:
    """What keeps a chain's cable from being set, as texts."""
    arm, pinion, tension = f"upper_arm_{i}", f"pinion_{i}", f"tension_screw_{i}"
    screws = [f"set_screw_{i}_{k}" for k in range(len(d.set_screws_rad))]
    made, present = members(assembly.order), set[str]()
    steps = next((unit.steps for unit in assembly.order if unit.name == f"drive {i}"), ())
    for step in steps:
        present |= {name for insertion in step.insertions for name in brought(insertion, made)}
        if set(screws) <= set(step.tightened):
            break
    else:
        return [f"drive {i}: no step tightens its set screws"]
    if missing := {arm, tension, *screws} - present:
        return [f"drive {i}: {' and '.join(sorted(missing))} not there by then"]
    base = {one.name: np.asarray(one.frame_a) for one in assembly.joints}
    if missing := {f"shoulder_{i}", pinion} - set(base):
        return [f"drive {i}: {' and '.join(sorted(missing))} is no joint"]
    there = replace(assembly, occurrences=tuple(o for o in assembly.occurrences if o.name in present))
    scene, middle = Scene(there, meshes, assembly.home_mm[None, :]), sum(d.stops_rad) / 2.0

    def turn(at_rad: float) -> np.ndarray:
        """Turns arm and pinion to an angle of the arm from the middle of its stroke; gives the arm's frame."""
        angle, ratio = middle + at_rad, setting.capstan.ratio
        placed = {
            arm: base[f"shoulder_{i}"] @ _turned(angle),
            f"pinion_{i}": base[f"pinion_{i}"] @ _turned(-ratio * angle),
        }
        for k, o in enumerate(there.occurrences):
            if o.link in placed:
                scene.frames[0, k] = placed[o.link] @ o.placement
        return placed[arm]

    def swing(screw: str, at_rad: float) -> float:
        turn(at_rad)
        return key_swing(ToolAccess(screw, _DRAWN_MM, ""), scene)

    faults = list[str]()
    angles = np.linspace(-0.9, 0.9, _TURNS) * setting.capstan.run.stroke_rad / 2.0
    if all(swing(tension, angle) < SWING_RAD for angle in angles.tolist()):
        faults.append(f"drive {i}: the key of {tension} swings nowhere")
    if swing(screws[setting.screw], setting.arm_rad) <= 0.0:
        faults.append(f"drive {i}: no key stands in {screws[setting.screw]} where the arm is pulled")
    out, _, up, shoulder = turn(setting.arm_rad)[:3].T
    way = up if setting.rises else -up
    start = shoulder + setting.lever_mm * out + HOOK_MM * way
    end = start + _LINE_MM * way
    around = scene.around(0, start, _LINE_MM + HOOK_MM, scene.index[arm], True)
    if not around.free(HOOK_MM, start, end[None]).all():
        faults.append(f"drive {i}: something is before the balance that pulls the arm")
    return faults


def _turned(angle_rad: float) -> np.ndarray:
    """(4, 4) turn about y from x towards z."""
    c, s = cos(angle_rad), sin(angle_rad)
    return np.array([[c, 0.0, -s, 0.0], [0.0, 1.0, 0.0, 0.0], [s, 0.0, c, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _seen(assembly: Assembly, i: int) -> _Seen:
    """Follows the cable of a chain from stop to stop."""
    placed = assembly.poses(assembly.home_mm)
    occurrences = {o.name: o for o in assembly.occurrences}
    (joint,) = [j for j in assembly.joints if j.name == f"shoulder_{i}"] or [None]
    angles = [stop.angle_rad for stop in assembly.stops if stop.joint == f"shoulder_{i}"]
    names = f"sector_{i}", f"pinion_{i}", f"capstan_cable_{i}_turns"
    missing = [name for name in names if name not in occurrences]
    if missing or joint is None or not angles:
        raise _NotFoundError(f"{' and '.join(missing) or 'a shoulder with its stops'} is missing")
    shoulder = np.linalg.inv(joint.frame_a)
    sector, pinion, turns = (occurrences[name] for name in names)
    own = np.linalg.inv(joint.frame_b) @ sector.placement
    s = _sector([c.moved(own) for c in features(sector.part.solid).cylinders])
    arm = shoulder @ np.asarray(assembly.placement(assembly.home_mm)[sector.link]) @ joint.frame_b
    home = atan2(arm[2, 0], arm[0, 0])
    p = _pinion(
        [c.moved(shoulder @ placed[pinion.name]) for c in features(pinion.part.solid).cylinders],
        [arc.moved(shoulder @ placed[turns.name]) for arc in features(turns.part.solid).tori],
    )
    half, small = p.pitch_mm - p.bottom_mm, p.pitch_mm
    wound = s.rim_mm + half
    distance, direction = hypot(*p.axis_mm), atan2(p.axis_mm[1], p.axis_mm[0])
    if distance <= wound + small:
        raise _NotFoundError(f"axes {distance:.2f} mm apart leave no gap between the drums of the cable")
    tangent = acos((wound + small) / distance)
    free = sqrt(distance**2 - (wound + small) ** 2)
    fleet, margin = 0.0, inf
    for theta in np.linspace(min(angles), max(angles), _ANGLES).tolist():
        walked = p.climb_rad * wound / small * (theta - home)  # the pinion turns against the arm
        for end, sense in enumerate((-1.0, 1.0)):
            arc = sense * (s.ends_rad[end] + theta - direction - sense * tangent) % tau
            arc -= tau if arc > 1.5 * pi else 0.0  # beyond the rim's end
            take_off = p.ends_mm[end] + walked
            fleet = max(fleet, atan2(abs(take_off - s.lugs_mm[end]), max(arc * wound + free, 0.0)))
            margin = min(margin, take_off - p.groove_mm[0], p.groove_mm[1] - take_off)
    margin = min(margin, *(min(y - half - s.sides_mm[0], s.sides_mm[1] - y - half) for y in s.lugs_mm))
    off = max(p.off_mm, s.lug_off_mm)
    wording = (
        f"of the solids: rim {s.rim_mm:.2f} mm, axes {distance:.2f} mm apart, lugs at {s.lugs_mm[0]:.2f} and "
        f"{s.lugs_mm[1]:.2f} mm, groove from {p.groove_mm[0]:.2f} to {p.groove_mm[1]:.2f} mm, "
        f"{p.wrap_rad / tau:.2f} turns, lead {degrees(atan(abs(p.climb_rad) / small)):.2f} deg"
    )
    return _Seen(fleet, min(margin, -off) if off else margin, wording)


def _is_along_y(c: SolidFace) -> bool:
    return bool(np.hypot(c.direction[0], c.direction[2]) < _ALONG)


def _sector(cylinders: list[SolidFace]) -> _Sector:
    """Reads a sector: its rim is the largest round face about the axis, the cable's slots are its narrowest across."""
    round_y = [c for c in cylinders if _is_along_y(c) and not c.is_hollow]
    on_axis = [c for c in round_y if np.hypot(c.point[0], c.point[2]) < _OFF_MM]
    if not on_axis:
        raise _NotFoundError("the sector has no rim about the shoulder's axis")
    rim = max(c.radius_mm for c in on_axis)
    sides = [y for c in on_axis if c.radius_mm > rim - _OFF_MM for y in _ends_y(c)]
    across = [c for c in cylinders if c.is_hollow and abs(c.direction[1]) < _ALONG]
    narrow = min((c.radius_mm for c in across), default=0.0)
    slots: list[SolidFace] = []
    for c in across:
        if c.radius_mm < narrow + _OFF_MM and not any(np.linalg.norm(_foot(c) - _foot(o)) < _OFF_MM for o in slots):
            slots.append(c)
    noses = [c for c in round_y if abs(np.hypot(c.point[0], c.point[2]) + c.radius_mm - rim) < _OFF_MM]
    noses = [c for c in noses if c.radius_mm < rim - _OFF_MM]
    if len(slots) != 2 or not noses:
        raise _NotFoundError(f"the sector has {len(slots)} slots for its cable, 2 are asked, and {len(noses)} noses")
    nose = noses[0]
    # the outer slot is a tangent of the rim, the inner one of the nose
    outer = min(slots, key=lambda c: abs(float(np.hypot(_foot(c)[0], _foot(c)[2])) - rim))
    inner = next(c for c in slots if c is not outer)
    at = _foot(outer)
    return _Sector(
        rim,
        (min(sides), max(sides)),
        (atan2(nose.point[2], nose.point[0]), atan2(at[2], at[0])),
        (float(inner.point[1]), float(outer.point[1])),
        max(float(np.hypot(at[0], at[2])) - rim - narrow, 0.0),
    )


def _foot(c: SolidFace) -> np.ndarray:
    """(3,) point of an axis across y that is nearest to the y axis, mm."""
    return c.point - (c.point @ c.direction) * c.direction + (c.point[1] * c.direction[1]) * c.direction


def _ends_y(c: SolidFace) -> list[float]:
    """Both ends of a cylinder along y, mm."""
    return [float(c.point[1] + v * c.direction[1]) for v in (c.start_mm, c.end_mm)]


def _pinion(cylinders: list[SolidFace], arcs: list[SolidFace]) -> _Pinion:
    """Reads a pinion: its groove's bottom is the round face nearest under its turns, which lie on it in arcs."""
    drums = [c for c in cylinders if _is_along_y(c) and not c.is_hollow]
    if not drums or not arcs:
        raise _NotFoundError("the pinion has no drum along the shoulder's axis, or no turns lie on it")
    axis = drums[0].point[[0, 2]]
    paths = sorted((_along(arc, axis) for arc in arcs), key=lambda path: float(path[:, 1].mean()))
    for before, path in pairwise(paths):
        path[:, 0] += tau * round((before[-1, 0] - path[0, 0]) / tau)
    angle, height, ring = np.concatenate(paths).T
    climb = float(np.polyfit(angle, height, 1)[0])
    middle, drawn = float(np.median(ring)), max(arc.radius_mm for arc in arcs)
    thin = min((c.radius_mm for c in drums), key=lambda radius: abs(middle - drawn - radius))
    groove = [y for c in drums if abs(c.radius_mm - thin) < _ALONG for y in _ends_y(c)]
    off = max(float(np.abs(ring - thin - drawn).max()) - _OFF_MM, 0.0)
    # the turns begin, lowest in y, where the strand from the outer end arrives when they climb with the angle
    low, high = float(height[0]), float(height[-1])
    ends = (high, low) if climb > 0.0 else (low, high)
    wrap = abs(float(angle[-1] - angle[0]))
    return _Pinion((float(axis[0]), float(axis[1])), middle, thin, (min(groove), max(groove)), climb, wrap, ends, off)


def _along(arc: SolidFace, axis: np.ndarray) -> np.ndarray:
    """(n, 3) polar angle about an axis along y through (x, z), y and distance from it of points along an arc.

    They are in the order in which y grows.
    """
    steps = np.linspace(0.0, arc.turn_rad, 9)
    second = np.cross(arc.direction, arc.first)
    points = arc.point + arc.ring_mm * (np.cos(steps)[:, None] * arc.first + np.sin(steps)[:, None] * second)
    x, z = points[:, 0] - axis[0], points[:, 2] - axis[1]
    path = np.column_stack([np.unwrap(np.arctan2(z, x)), points[:, 1], np.hypot(x, z)])
    return path if path[-1, 1] > path[0, 1] else path[::-1]
