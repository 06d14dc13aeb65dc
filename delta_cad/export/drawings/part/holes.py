"""The holes of a part for its drawing: the declared ones, located in its solid with positions and depths.

This is the only module that reads `Part.holes`.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from delta_cad.common.vectors import cross_length
from delta_cad.export.drawings.part.controlled import signed
from delta_cad.export.drawings.part.faces import Face, is_along
from delta_cad.export.drawings.sheet_io.lettering import SURFACE
from delta_cad.solids.part import Bore as Declared
from delta_cad.solids.part import Hole, Part

_SAME_MM = 1e-3  # of declared and found diameters, and of axes that are one
_HALF_TURN = pi - 1e-6  # least turn of a bore's faces: inner corners have less
_NUMBER = re.compile(r"^\d+(\.\d+)?")
_THREAD = re.compile(r"^M\d")
SHARE = re.compile(r"^(\d+)x (.*)$")


@dataclass(eq=False)
class Bore:
    """One axis with the holes on it.

    Attributes:
        point: (3,) where its axis leaves the part, mm.
        axis: (3,) unit vector along it, out of the part there.
        diameters: Of its declared holes, largest first, mm.
        spans: Where each has its wall along the axis, from `point`, mm; several where it is bored from both sides.
        faces: Its walls.
        through: Whether it is open at both ends.
    """

    point: np.ndarray
    axis: np.ndarray
    diameters: tuple[float, ...]
    spans: dict[float, list[tuple[float, float]]]
    faces: list[Face]
    through: bool

    @property
    def widest(self) -> float:
        """Largest diameter, mm."""
        return max(self.diameters)


@dataclass(eq=False)
class HoleGroup:
    """Equal holes of a part: where they are, and the callout of each diameter, smallest first, in lines."""

    bores: list[Bore]
    callout: tuple[str, ...]

    @property
    def diameters(self) -> tuple[float, ...]:
        """Diameters on each axis, mm."""
        return self.bores[0].diameters


@dataclass(frozen=True)
class Slots:
    """Equal slots of a part: width, mm, how many, and the callout."""

    width_mm: float
    count: int
    callout: str


class HoleError(ValueError):
    """What a part declares of its holes is not what its solid has."""


def hole_groups(part: Part, faces: Sequence[Face]) -> list[HoleGroup]:
    """Finds the declared bores of a part, grouped by what is on their axes, largest first.

    Raises:
        HoleError: A declared bore is not there as often as declared.
    """
    declared = [hole for hole in part.holes if not hole.is_slot]
    bores = [_bore(walls, declared) for walls in _axes(faces, declared)]
    groups: dict[tuple[object, ...], list[Bore]] = {}
    for bore in bores:
        both = tuple(len(bore.spans[d]) for d in bore.diameters)
        groups.setdefault((bore.diameters, both, _depths(bore)), []).append(bore)
    for hole in declared:
        seen = sum(any(abs(d - hole.diameter_mm) < _SAME_MM for d in bore.diameters) for bore in bores)
        if seen != sum(one.count for one in declared if one.diameter_mm == hole.diameter_mm):
            raise HoleError(f"{part.number}: {seen} bores of {hole.diameter_mm:g} mm, {hole.count} are declared")
    found = []
    for same in groups.values():
        said = ([recorded(text, hole) for text in _callouts(hole, same, groups)] for hole in _on(same[0], declared))
        found.append(HoleGroup(same, tuple(lettered("\n".join(texts)) for texts in said)))
    return sorted(found, key=lambda group: (-group.bores[0].widest, group.callout))


def recorded(callout: str, hole: Hole) -> str:
    """Adds to a callout what the records of its bores say and it does not: deviations, drill, surface.

    Bores of one diameter that differ in these add nothing: their own callouts tell it.
    """
    records = {(b.fit, b.deviations_um, b.surface_um, b.thread, b.through, b.depth_mm) for b in hole.bores}
    if len({record[:3] for record in records}) != 1:
        return callout
    fit, deviations, surface, thread, through, depth = min(records, key=str)
    if deviations is not None:
        lower, upper = (signed(um / 1000.0) for um in deviations)
        if fit:
            callout = callout.replace(f" {fit}", f" {fit} ({upper}/{lower})", 1)
        elif "+" not in callout and (number := _NUMBER.match(SHARE.sub(r"\2", callout).removeprefix("Ø"))):
            both = f"±{deviations[1] / 1000.0:g}" if deviations[0] == -deviations[1] else f"{upper}/{lower}"
            callout = callout.replace(number[0], f"{number[0]} {both}", 1)
    if thread and not through and len(records) == 1 and "drilled" not in callout:
        callout += f", drilled {depth:g} deep"
    return callout if surface is None else f"{callout} {SURFACE}Ra {surface:g}"


def slots(part: Part) -> list[Slots]:
    """Gives the slots that a part declares."""
    return [Slots(h.diameter_mm, h.count, lettered(_prefixed(h.count, h.callout))) for h in part.holes if h.is_slot]


def lettered(text: str) -> str:
    """Gives a text with the signs that a drawing has for plus-minus and degrees."""
    return re.sub(r" deg\b", "°", text.replace("+-", "±"))


def _axes(faces: Sequence[Face], declared: Sequence[Hole]) -> list[list[Face]]:
    """Walls of bores of declared diameters, together where they share their axis."""
    axes: list[list[Face]] = []
    for face in faces:
        if face.kind != "cylinder" or not face.hollow:
            continue
        if not any(abs(2 * face.radius - hole.diameter_mm) < _SAME_MM for hole in declared):
            continue
        for walls in axes:
            one = walls[0]
            apart = face.point - one.point
            if is_along(face.axis, one.axis) and cross_length(apart, one.axis) < _SAME_MM:
                walls.append(face)
                break
        else:
            axes.append([face])
    return [stack for walls in axes if (kept := _turned_enough(walls)) for stack in _stacks(kept)]


def _stacks(walls: list[Face]) -> list[list[Face]]:
    """Walls on one axis by the holes they belong to: those that border along it, and equal ones from either side."""
    axis = walls[0].axis
    stacks: list[tuple[list[float], list[Face]]] = []
    for face in sorted(walls, key=lambda face: face.reach(axis)):
        start, end = face.reach(axis)
        if stacks and start < stacks[-1][0][0] + _SAME_MM:
            stacks[-1][1].append(face)
            stacks[-1][0][0] = max(stacks[-1][0][0], end)
        else:
            stacks.append(([end], [face]))
    by_sizes: dict[tuple[float, ...], list[Face]] = {}
    for _, faces in stacks:
        by_sizes.setdefault(tuple(sorted({round(face.radius, 3) for face in faces})), []).extend(faces)
    return list(by_sizes.values())


def _turned_enough(walls: list[Face]) -> list[Face]:
    by_radius: dict[float, list[Face]] = {}
    for face in walls:
        by_radius.setdefault(round(face.radius, 3), []).append(face)
    return [f for same in by_radius.values() if sum(g.turn for g in same) >= _HALF_TURN for f in same]


def _bore(walls: list[Face], declared: Sequence[Hole]) -> Bore:
    """The bore of walls on one axis; it points out where its widest hole is open, or the way of the part's axes."""
    axis = walls[0].axis / np.linalg.norm(walls[0].axis)
    first = next(float(c) for c in axis if abs(c) > 1e-6)
    axis = axis if first > 0.0 else -axis
    ends = [face.reach(axis) for face in walls]
    low, high = min(a for a, _ in ends), max(b for _, b in ends)
    wide = max(walls, key=lambda face: face.radius).reach(axis)
    through = not _closed(walls, axis, high) and not _closed(walls, axis, low)
    if _closed(walls, axis, high) or (wide[0] - low < high - wide[1] and not _closed(walls, axis, low)):
        axis, low, high = -axis, -high, -low
    centre = walls[0].point - (walls[0].point @ axis) * axis
    spans: dict[float, list[tuple[float, float]]] = {}
    for hole in declared:
        pieces = [f.reach(axis) for f in walls if abs(2 * f.radius - hole.diameter_mm) < _SAME_MM]
        if pieces:
            spans[hole.diameter_mm] = _joined([(a - high, b - high) for a, b in pieces])
    diameters = tuple(sorted(spans, reverse=True))
    through = through and all(len(pieces) == 1 for pieces in spans.values())
    return Bore(centre + high * axis, axis, diameters, spans, walls, through)


def _closed(walls: list[Face], axis: np.ndarray, end: float) -> bool:
    """Whether a bore has a floor at an end: a plane or a cone within it, that faces along its axis."""
    return any(
        other.kind in ("plane", "cone")
        and is_along(other.axis, axis)
        and max(abs(value - end) for value in points @ axis) < _SAME_MM
        and wall.off_axis(other.corners) < wall.radius + _SAME_MM
        and float((other.middle - wall.middle) @ axis) * (end - float(wall.middle @ axis)) > 0.0
        and (other.kind == "cone" or float(other.axis @ axis) * (end - float(wall.middle @ axis)) < 0.0)
        for wall in walls
        for other, points in wall.borders
    )


def _joined(pieces: list[tuple[float, float]]) -> list[tuple[float, float]]:
    joined: list[tuple[float, float]] = []
    for start, end in sorted(pieces):
        if joined and start < joined[-1][1] + _SAME_MM:
            joined[-1] = joined[-1][0], max(joined[-1][1], end)
        else:
            joined.append((start, end))
    return joined


def _depths(bore: Bore) -> tuple[float, ...]:
    return tuple(round(end - start, 2) for d in bore.diameters for start, end in bore.spans[d])


def _on(bore: Bore, declared: Sequence[Hole]) -> list[Hole]:
    """The declared holes on an axis, narrowest first: the drill before the counterbore."""
    holes = [hole for hole in declared if any(abs(hole.diameter_mm - d) < _SAME_MM for d in bore.diameters)]
    return sorted(holes, key=lambda hole: hole.diameter_mm)


def _callouts(hole: Hole, same: list[Bore], groups: dict[tuple[object, ...], list[Bore]]) -> list[str]:
    """What is told of a declared hole on the axes of one group: of bores from either side that differ, each."""
    stated = _stated(hole, same)
    if len(stated) > 1 and _shared_by(hole, groups) > 1:
        return [_prefixed(len(same), _named(text, hole.diameter_mm)) for text in stated]
    return [_callout(hole, same, groups)]


def _stated(hole: Hole, same: list[Bore]) -> list[str]:
    """What is declared of the bores of a hole that lie on the axes of one group."""
    return sorted({one.callout for one in hole.bores if any(_is_on(one, bore) for bore in same)})


def _shared_by(hole: Hole, groups: dict[tuple[object, ...], list[Bore]]) -> int:
    """Number of groups of axes that a declared hole's diameter is on."""
    return sum(any(abs(hole.diameter_mm - d) < _SAME_MM for d in group[0].diameters) for group in groups.values())


def _callout(hole: Hole, same: list[Bore], groups: dict[tuple[object, ...], list[Bore]]) -> str:
    """What is told of a declared hole on the axes of one group, in one."""
    sharing = [g for g in groups.values() if any(abs(hole.diameter_mm - d) < _SAME_MM for d in g[0].diameters)]
    shares = [match for text in hole.callout.split("; ") if (match := SHARE.match(text))]
    if len(sharing) == 1:
        return _prefixed(hole.count, _named(_shared(shares) or hole.callout, hole.diameter_mm))
    stated = _stated(hole, same)
    if len(stated) == 1 and len({one.callout for one in hole.bores}) > 1:
        return _prefixed(len(same), _named(stated[0], hole.diameter_mm))
    own = [match[2] for match in shares if int(match[1]) == len(same)]
    if len(own) == 1 and len(shares) == len(sharing):
        return _prefixed(len(same), _named(own[0], hole.diameter_mm))
    spans = same[0].spans[min(same[0].spans, key=lambda d: abs(d - hole.diameter_mm))]
    designation = re.split(r":| through| x |,", SHARE.sub(r"\2", hole.callout))[0]
    depth = max(end - start for start, end in spans)
    sides = " from both sides" if len(spans) == 2 else ""
    way = "long" if "slot" in designation else "deep"  # the bore at a slot's bottom goes along it
    return _prefixed(len(same), _named(f"{designation} x {depth:g} {way}{sides}", hole.diameter_mm))


def _is_on(declared: Declared, bore: Bore) -> bool:
    """Whether a declared bore lies on an axis, and within what is bored there."""
    start, along = np.array(declared.start_mm), np.array(declared.direction)
    if not is_along(bore.axis, along) or cross_length(start - bore.point, along) >= _SAME_MM:
        return False
    middle = float((start + declared.depth_mm / 2.0 * along - bore.point) @ bore.axis)
    return any(low - _SAME_MM < middle < high + _SAME_MM for spans in bore.spans.values() for low, high in spans)


def _shared(shares: list[re.Match[str]]) -> str:
    """Equal bores of several uses in one: what they are, then how many are for what; "" where they are not equal."""
    parts = [share[2].partition(", ") for share in shares]
    if len(parts) < 2 or len({what for what, _, _ in parts}) > 1:
        return ""
    return ", ".join([parts[0][0], *(f"{share[1]}x {use}" for share, (_, _, use) in zip(shares, parts, strict=True))])


def _named(callout: str, diameter: float) -> str:
    """The callout, with the diameter in front where it does not begin with it, or with a thread."""
    if _THREAD.match(callout) or "slot" in callout:
        return callout
    if number := _NUMBER.match(callout):
        return f"Ø{round(float(number[0]), 3):g}{callout[number.end() :]}"
    return f"Ø{round(diameter, 3):g} {callout}"


def _prefixed(count: int, text: str) -> str:
    return f"{count}x {text}" if count > 1 else text
