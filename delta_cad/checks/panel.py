"""Handle and panel: the bezel stops the stem where stated, before any other contact; the boot is long enough.

Aside the handle is stopped by the bezel at |x - x_c| or |y| = L + limit, at every height; up and down, and where a
design has no panel, the arms' stops end its way. The stem is a straight round bar and the bezel's edge a straight wall
over the cube's square, so that it is enough to look at the middles of the square's sides and at its corners, and at the
heights where what passes the bezel changes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.bodies import DistanceEngine, bodies_of
from delta_cad.checks.clearance.clearance import exact_distance
from delta_cad.checks.clearance.joint_ranges import FoldError, joint_ranges
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import clearance_frames
from delta_cad.checks.outline.envelope import shoulder_range
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.panel import CLOTH_MM, LIP_MM, PanelDimensions

_OFF_MM = 0.05  # of the limit that is met from the one that is stated: half of the general tolerance on a bezel
_ROOM_MM = 0.5  # that all else keeps from what hangs over it while the stem lies at the bezel
_BEFORE_RAD = np.radians(1.0)  # by which no arm has come to its stop then: stops are met within a degree
_STEM, BEZEL, _COLLAR = "handle_stem", "bezel", "boot_collar"
_SIDES = [(x, y) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0) if x or y]


def check_panel(assembly: Assembly, d: Dimensions, limits: CheckLimits, meshes: Meshes) -> list[CheckResult]:
    """Checks the handle's way through the panel; nothing of a design without one.

    Returns:
        `handle limit` (largest deviation of the stem's way to the bezel, mm), `handle limit room` (least distance of
        anything else that moves from what hangs over it, the stem at the bezel, mm), `handle limit before stops` (least
        angle that the arms have left there, deg), `handle limit lean` (largest lean of a rod there, deg), `boot length`
        (cloth beyond the longest way from bezel to collar, mm).
    """
    if (p := d.panel) is None:
        return []
    present = {o.name for o in assembly.occurrences}
    missing = [name for name in (_STEM, BEZEL, _COLLAR) if name not in present]
    if missing:
        detail = f"{' and '.join(missing)} is missing"
        return [CheckResult("handle limit", False, None, _OFF_MM, "mm", worst_pair=tuple(missing), detail=detail)]
    return [
        stem_limit(assembly, p, limits),
        room_at_limit(assembly, p, limits, meshes),
        *arms_at_limit(assembly, d, limits),
        boot_length(assembly, p, limits, meshes),
    ]


def _positions(limits: CheckLimits, beyond_mm: float) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Middles of the cube's upright sides and its upright edges, at three heights, moved outwards; with the way."""
    half = limits.half_side_mm
    for way in _SIDES:
        out = np.array([*way, 0.0]) / np.hypot(*way)
        for height in (-half, 0.0, half):
            yield limits.centre_mm + np.array([way[0] * half, way[1] * half, height]) + beyond_mm * out, out


def stem_limit(assembly: Assembly, p: PanelDimensions, limits: CheckLimits) -> CheckResult:
    """Measures the stem's way to the bezel on the exact solids."""
    placed = {o.name: o for o in assembly.occurrences}
    stem, bezel = placed[_STEM], placed[BEZEL]
    worst, at = 0.0, limits.centre_mm
    for position, _ in _positions(limits, 0.0):
        poses = assembly.poses(position)
        apart = exact_distance(stem.part.solid, bezel.part.solid, np.linalg.inv(poses[_STEM]) @ poses[BEZEL])
        off = apart - CLOTH_MM - p.limit_mm
        if abs(off) >= abs(worst):
            worst, at = off, position
    reach = limits.half_side_mm + p.limit_mm
    from_middle = f"x - {limits.centre_x_mm:g}" if limits.centre_x_mm else "x"
    detail = (
        f"the stem meets the bezel, through the boot's cloth, at |{from_middle}| or |y| = {reach:.2f} mm, "
        f"{p.limit_mm:g} mm outside the cube; {len(_SIDES)} ways, 3 heights, exact distances of the solids; up and "
        "down the arms' stops end the way"
    )
    x, y, z = at.tolist()
    return CheckResult("handle limit", abs(worst) <= _OFF_MM, worst, _OFF_MM, "mm", (x, y, z), (_STEM, BEZEL), detail)


def room_at_limit(assembly: Assembly, p: PanelDimensions, limits: CheckLimits, meshes: Meshes) -> CheckResult:
    """Measures distances at the limit, of meshes less their deviations; geared pinions, far below, stand still."""
    bodies = bodies_of(assembly.occurrences, meshes)
    over = [body for name, body in bodies.items() if name in assembly.dashboard]
    moving = [body for body in bodies.values() if body.link != "base"]
    engine, least = DistanceEngine(), (np.inf, ("", ""), limits.centre_mm)
    for position, _ in _positions(limits, p.limit_mm):
        frames = {link: frame[0] for link, frame in clearance_frames(assembly.placement, position[None]).items()}
        for body in moving:
            frame = frames[body.link] @ body.placement
            if (frame[:3, :3] @ body.mesh.vertices.T + frame[:3, 3:])[2].max() < p.under_mm - least[0] - p.bezel_mm:
                continue
            for fixed in over:
                if (body.name, fixed.name) in ((_STEM, BEZEL), (_COLLAR, "boot")):
                    continue
                apart = engine.distance(body, fixed, frame, fixed.placement)
                apart -= body.mesh.deviation_mm + fixed.mesh.deviation_mm
                if apart < least[0]:
                    least = (float(apart), (body.name, fixed.name), position)
    (x, y, z), names = least[2].tolist(), " and ".join(least[1])
    detail = f"{names} are nearest of all that moves and all that hangs over it, the stem at the bezel"
    return CheckResult("handle limit room", least[0] >= _ROOM_MM, least[0], _ROOM_MM, "mm", (x, y, z), least[1], detail)


def arms_at_limit(assembly: Assembly, d: Dimensions, limits: CheckLimits) -> Iterator[CheckResult]:
    """Encloses shoulder angles and lean over the cube that is larger by the limit on every side."""
    assert d.panel is not None
    beyond = d.panel.limit_mm
    low_mm, half_mm = limits.bottom_height_mm - beyond, limits.half_side_mm + beyond
    wider = replace(limits, bottom_height_mm=low_mm, half_side_mm=half_mm)
    geometry, required = assembly.placement.geometry, float(np.degrees(_BEFORE_RAD))
    low, high = d.stops_rad
    tilt = float(np.degrees(d.forearm.tilt_limit_rad))
    try:
        theta = shoulder_range(geometry, wider)
        lean = float(np.degrees(np.abs(joint_ranges(geometry, wider.centre_mm, wider.half_side_mm).lean).max()))
    except FoldError as error:
        for name, limit in (("before stops", required), ("lean", tilt)):
            yield CheckResult(f"handle limit {name}", False, None, limit, "deg", detail=str(error))
        return
    left = float(np.degrees(min(theta[:, 0].min() - low, high - theta[:, 1].max())))
    text = "that every arm has left to its stop wherever the bezel lets the handle go, enclosed"
    yield CheckResult(
        "handle limit before stops", left >= required, left, required, "deg", detail=f"least angle {text}"
    )
    text = "largest lean of a rod wherever the bezel lets the handle go, enclosed; held against its joints' tilt"
    yield CheckResult("handle limit lean", lean <= tilt, lean, tilt, "deg", detail=text)


def boot_length(assembly: Assembly, p: PanelDimensions, limits: CheckLimits, meshes: Meshes) -> CheckResult:
    """Computes the cloth beyond the longest way from the bezel's lower edge to the collar, both as they are placed."""
    bodies = bodies_of(assembly.occurrences, meshes)
    points, ring = bodies[BEZEL].vertices, bodies[_COLLAR].vertices
    inner = (
        np.hypot(*np.maximum(np.abs(points[:, :2] - limits.centre_mm[:2]) - p.half_mm, 0.0).T) < p.edge_mm + LIP_MM / 2
    )
    edge = points[inner & (points[:, 2] < points[:, 2].min() + 1e-3)]
    low = ring[:, 2].min()
    radius = float(np.hypot(*ring[:, :2].T).max())
    longest, at = 0.0, limits.centre_mm
    for position, _ in _positions(limits, p.limit_mm):
        apart = edge - (position + np.array([0.0, 0.0, low]))
        way = float(np.hypot(np.hypot(apart[:, 0], apart[:, 1]) - radius, apart[:, 2]).max())
        if way > longest:
            longest, at = way, position
    x, y, z = at.tolist()
    detail = (
        f"cloth of {p.cloth_mm:.1f} mm for a way of {longest:.1f} mm at most; cloth that is not stretched gives way "
        "without a force, and folds"
    )
    left = p.cloth_mm - longest
    return CheckResult("boot length", left >= 0.0, left, 0.0, "mm", (x, y, z), (BEZEL, _COLLAR), detail)
