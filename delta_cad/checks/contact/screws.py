"""Screws: length of thread and clamped stack under the head of each; no tapped or reamed hole is empty."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.attachment import SEAT_MM
from delta_cad.checks.contact.clamped_stack import largest_gaps
from delta_cad.checks.contact.features import features
from delta_cad.checks.links import carried_by_link
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import FOR_WHAT_IT_STANDS_ON, Occurrence, Part

_ENGAGED_LEAST = 1.0  # thread lengths in diameters: what steel screws need in aluminium under hand torque
_THREAD_PLAY_MM = 0.05  # radius by which a tap drill may exceed the drawn core of its screw (0.02), and axes may differ
_FILLED = r"M\d|[\d.]+ [HG]7"  # callouts of holes that hold something: threads and fits
_ROUNDING_MM = 1e-4  # of meshes' vertices
_CLAMPING = "screw_"  # part numbers of screws that clamp with their heads
_ADJUSTING = "tension_screw"  # part number of screws that are turned to set something: nothing lies under their heads


@dataclass(frozen=True, eq=False)
class _Cylinders:
    """All cylindrical faces of one kind, of a link or of the machine, in its frame, mm."""

    owner: np.ndarray  # (n,) index of the occurrence
    point: np.ndarray  # (n, 3) on the axes
    direction: np.ndarray  # (n, 3) unit vectors
    radius: np.ndarray  # (n,)
    span: np.ndarray  # (n, 2) where the faces begin and end along their directions

    def along(self, point: np.ndarray, direction: np.ndarray, inside: bool, radius_mm: float) -> np.ndarray:
        """Begin and end (n, 2) of the faces along a line, mm; NaN where a face is not on it or does not fit a radius.

        The radius is that of a shank, which the faces hold (`inside`), or of a bore, which holds them.
        """
        across = np.linalg.norm(np.cross(self.direction, direction), axis=1)
        apart = self.point - point
        aside = np.linalg.norm(apart - (apart @ direction)[:, None] * direction, axis=1)
        play = self.radius - radius_mm if inside else radius_mm - self.radius
        # both ends of a screw of 20 mm are within the play when the directions agree to 1e-3
        fits = (across < 1e-3) & (aside <= _THREAD_PLAY_MM) & (play > -1e-6) & (play <= _THREAD_PLAY_MM)
        sense = np.sign(self.direction @ direction)
        ends = np.sort((apart @ direction)[:, None] + sense[:, None] * self.span, axis=1)
        return np.where(fits[:, None], ends, np.nan)


@dataclass(frozen=True, eq=False)
class _Screw:
    """A screw on its link, mm: z of its frame runs from the shank to the head, the origin is under the head."""

    index: int  # of its occurrence on the link
    radius: float  # shank's
    length: float  # shank's
    head: float  # radius
    nominal: float  # diameter of the thread


def check_screws(assembly: Assembly, meshes: MeshLibrary) -> list[CheckResult]:
    """Checks every screw of a link, and every tapped or reamed hole.

    Returns:
        `screws engaged` (least length of thread in diameters), `screws seated` (largest gap between the parts that a
        screw clamps, from under its head to the thread, mm) and `holes filled` (number of empty ones).
    """
    engaged: list[tuple[float, str]] = []
    seated: list[tuple[float, str]] = []
    for carried in carried_by_link(assembly).values():
        bearing_out = _bearing_out(assembly, {o.name for o in carried})
        bores = _cylinders(carried, [o.placement for o in carried], True)
        for screw in _screws(carried):
            o = carried[screw.index]
            length, start = _engagement(screw, o, bores)
            engaged.append((-length / screw.nominal if length > 0.0 else 0.0, o.name))
            if o.part.number.startswith(_CLAMPING):
                seated.append((_unseated(screw, carried, start, meshes, bearing_out), o.name))
    return [
        _worst("screws engaged", engaged, -_ENGAGED_LEAST, "", "diameters of thread"),
        _worst("screws seated", seated, SEAT_MM, "mm", "gap between the parts from the head to the thread"),
        _filled(assembly),
    ]


def _filled(assembly: Assembly) -> CheckResult:
    """Whether every tapped or reamed hole holds something, on whatever link, at the exported position."""
    every, placed = assembly.occurrences, assembly.poses(assembly.home_mm)
    frames = [placed[o.name] for o in every]
    bores, shafts = (_cylinders(every, frames, is_bore) for is_bore in (True, False))
    empty: list[tuple[str, str]] = []
    holes = 0
    for k, o in enumerate(every):
        needed, missing = _empty_holes(k, o, bores, shafts)
        holes += needed
        empty += [(o.name, f"{o.name} {hole}") for hole in missing]
    names = tuple(dict.fromkeys(name for name, _ in empty[:8])) or None
    reported = "; ".join(text for _, text in empty[:8]) + " with nothing in it; " if empty else ""
    detail = f"{reported}{holes} kinds of tapped or reamed holes"
    return CheckResult("holes filled", not empty, len(empty), 0, "", worst_pair=names, detail=detail)


def _worst(name: str, values: Sequence[tuple[float, str]], limit: float, unit: str, what: str) -> CheckResult:
    """The screw with the largest value; values and limit below 0 are least values with their sign changed."""
    sign = -1.0 if limit < 0.0 else 1.0
    if not values:
        return CheckResult(name, True, None, abs(limit), unit, detail="no screws")
    value, worst = max(values)
    bad = [f"{n} {sign * v:.2f}" for v, n in sorted(values, reverse=True) if v > limit + 1e-9]  # sums of lengths in mm
    detail = f"{what}, worst of {len(values)} screws" + (f"; {len(bad)} fail: {'; '.join(bad[:8])}" if bad else "")
    shown = sign * value if np.isfinite(value) else None
    return CheckResult(name, not bad, shown, abs(limit), unit, worst_pair=(worst,), detail=detail)


def _cylinders(carried: Sequence[Occurrence], frames: Sequence[np.ndarray], is_bore: bool) -> _Cylinders:
    """All bores, or all outer cylinders, of occurrences in their (4, 4) frames."""
    rows = [
        (k, c.moved(frame))
        for k, (o, frame) in enumerate(zip(carried, frames, strict=True))
        for c in features(o.part.solid).cylinders
        if c.is_hollow == is_bore
    ]
    return _Cylinders(
        np.array([k for k, _ in rows], dtype=int),
        np.array([c.point for _, c in rows]).reshape(-1, 3),
        np.array([c.direction for _, c in rows]).reshape(-1, 3),
        np.array([c.radius_mm for _, c in rows]),
        np.array([(c.start_mm, c.end_mm) for _, c in rows]).reshape(-1, 2),
    )


def _screws(carried: Sequence[Occurrence]) -> list[_Screw]:
    """The screws of a link, measured on their solids: the shank is the outer cylinder below the origin."""
    screws = []
    for k, o in enumerate(carried):
        if not o.part.number.startswith((_CLAMPING, _ADJUSTING)):
            continue
        on_axis = [
            c
            for c in features(o.part.solid).cylinders
            if not c.is_hollow and abs(c.direction[2]) > 1.0 - 1e-9 and np.hypot(*c.point[:2]) < 1e-6
        ]
        ends = [sorted(c.point[2] + c.direction[2] * v for v in (c.start_mm, c.end_mm)) for c in on_axis]
        shank = [(low, c.radius_mm) for c, (low, high) in zip(on_axis, ends, strict=True) if high <= 1e-6]
        head = [c.radius_mm for c, (low, _) in zip(on_axis, ends, strict=True) if low >= -1e-6]
        low, radius = min(shank, default=(0.0, 0.0))  # one without a shank engages nothing
        screws.append(_Screw(k, radius, -low, max(head, default=2.0 * radius), _nominal(o.part, radius)))
    return screws


def _nominal(part: Part, radius_mm: float) -> float:
    """Thread diameter from the part number; where it says none, the core that is drawn, mm."""
    size = re.search(r"M(\d+(?:\.\d+)?)x", part.number)
    return float(size[1]) if size else 2.0 * radius_mm


def _engagement(screw: _Screw, o: Occurrence, bores: _Cylinders) -> tuple[float, float]:
    """Length of thread around a shank in the part that holds it best, and where it begins (z of the screw), mm."""
    spans = bores.along(o.placement[:3, 3], o.placement[:3, 2], True, screw.radius)
    best, start = 0.0, -screw.length
    for owner in np.unique(bores.owner[~np.isnan(spans[:, 0])]):
        if owner == screw.index:
            continue
        held = np.clip(spans[(bores.owner == owner) & ~np.isnan(spans[:, 0])], -screw.length, 0.0)
        length, reached = 0.0, -np.inf
        for low, high in sorted(map(tuple, held.tolist())):
            length += max(high - max(low, reached), 0.0)
            reached = max(reached, high)
        if length > best:
            best, start = length, float(held[:, 1].max())
    return best, start


def _bearing_out(assembly: Assembly, link: set[str]) -> set[str]:
    """Parts of a link that lie flat on a part of another one, as a washer on a bearing's inner ring."""
    flat = [{c.a, c.b} for c in assembly.contacts if c.kind == "plane"]
    return {name for pair in flat if len(pair & link) == 1 for name in pair & link}


def _unseated(
    screw: _Screw, carried: Sequence[Occurrence], start: float, meshes: MeshLibrary, bearing_out: set[str]
) -> float:
    """Gap between the parts that a screw clamps, mm: the median over lines around its axis, of the largest each.

    Where the part under the head bears on another link, beside the screw's own, the stack ends there.
    """
    frame = np.linalg.inv(carried[screw.index].placement)
    along = np.array([0.0, 0.0, screw.length / 2.0])  # from the middle of the shank to the seat of the head
    size = np.array([screw.head, screw.head, screw.length / 2.0]) + SEAT_MM
    parts = []
    for k, o in enumerate(carried):
        if k == screw.index:
            continue
        mesh, seen = meshes[o.part.number], frame @ o.placement
        low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
        middle = seen[:3, :3] @ ((low + high) / 2.0) + seen[:3, 3]
        half = np.abs(seen[:3, :3]) @ ((high - low) / 2.0)
        if (np.abs(middle + along) <= half + size).all():
            parts.append((mesh, seen))
        if o.name in bearing_out and abs(middle[2] + half[2]) <= SEAT_MM and np.hypot(*middle[:2]) <= SEAT_MM:
            start = max(start, float(middle[2] - half[2]) + _ROUNDING_MM)
    return float(np.median(largest_gaps(parts, screw.head, start)))


def _empty_holes(k: int, o: Occurrence, bores: _Cylinders, shafts: _Cylinders) -> tuple[int, list[str]]:
    """Number of kinds of holes of an occurrence that hold something, and those of which too many hold nothing."""
    missing, needed = [], 0
    for hole in o.part.holes:
        groups = [re.fullmatch(r"(?:(\d+)x )?(.*)", text.strip()) for text in hole.callout.split(";")]
        counts = [(int(g[1]) if g[1] else hole.count, g[2]) for g in groups if g]
        inside = (one for one in counts if FOR_WHAT_IT_STANDS_ON not in one[1])
        filled = sum(count for count, text in inside if re.match(_FILLED, text))
        if not filled:
            continue
        needed += 1
        mine = np.flatnonzero((bores.owner == k) & (np.abs(2.0 * bores.radius - hole.diameter_mm) < 1e-3))
        bare: list[np.ndarray] = []
        for b in mine:
            low, high = np.sort(bores.span[b])
            spans = shafts.along(bores.point[b], bores.direction[b], False, float(bores.radius[b]))
            held = (np.minimum(spans[:, 1], high) - np.maximum(spans[:, 0], low) > SEAT_MM) & (shafts.owner != k)
            at = bores.point[b] - (bores.point[b] @ bores.direction[b]) * bores.direction[b]
            if not held.any() and not any(np.linalg.norm(at - seen) < 1e-3 for seen in bare):
                bare.append(at)
        allowed = max(hole.count - filled, 0)  # axes of the same diameter that hold nothing
        if len(bare) > allowed:
            missing.append(f"{hole.callout} ({len(bare) - allowed})")
    return needed, missing
