"""A picture for each step: what it brings in, drawn out along its way and coloured, what is there already in grey."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly, Insertion, Step
from delta_cad.assembly.tessellation import Meshes
from delta_cad.export.views.scene import (
    Colour,
    PartScene,
    Placed,
    aim,
    flat_actor,
    flat_shapes,
    joined,
    photograph,
    placed,
    render_window,
)

SIZE = (560, 420)
_THERE: Colour = (0.80, 0.82, 0.84)
ACCENTS: tuple[Colour, ...] = (
    (0.93, 0.42, 0.10),
    (0.10, 0.45, 0.80),
    (0.15, 0.62, 0.35),
    (0.62, 0.30, 0.70),
    (0.85, 0.68, 0.05),
    (0.75, 0.15, 0.25),
    (0.20, 0.62, 0.66),
)
"""Colours of the parts that come in, one a part number, in turn."""
ARROW: Colour = (0.80, 0.05, 0.05)
_ARROW_WIDTH, _HEAD_PIXELS, _HEAD_SLOPE = 2.2, 13.0, 0.34
_OWN, _GAP_MM = (
    0.8,
    4.0,
)  # of its own length, and between what is drawn out and what it leaves, and between two that go the same way
_MOST_MM = 90.0  # how far anything is drawn out
_ASIDE = 0.45  # cosine between the line of sight and a way at which both arrow and seat are seen best
_MARGIN = 1.06
_AROUND, SHARE = 1.5, 0.7  # of what matters, and of all, a picture shows at least
VIEWS = tuple(
    np.array([x, y, z]) / np.linalg.norm([x, y, z])
    for x, y in ((0.62, -0.66), (0.66, 0.62), (-0.62, 0.66), (-0.66, -0.62))
    for z in (0.45, -0.45)
)
"""Directions towards the viewer to choose from; the earlier, and those from above, where they show as much."""
_FROM_ABOVE, _FIRST = 0.25, 0.02  # what a view from above is worth, and an earlier one


@dataclass(frozen=True)
class Drawn:
    """What a step brings in, as it is drawn.

    Attributes:
        names: Occurrences.
        away: (3,) how far they are drawn out, mm.
        bend: (3,) where the way turns, from the seat, mm; None: it is straight.
        unit: Kind of the first unit that comes in whole; "" for parts.
        is_flexible: Whether it is flexible.
    """

    names: tuple[str, ...]
    away: np.ndarray
    bend: np.ndarray | None
    unit: str
    is_flexible: bool = False


class Studio:
    """A window, and the machine's parts where they sit at home."""

    def __init__(self, assembly: Assembly, meshes: Meshes) -> None:
        self.window = render_window(SIZE)
        self._frames = assembly.poses(assembly.home_mm)
        self._meshes = meshes
        self._number = {o.name: o.part.number for o in assembly.occurrences}
        self._ordered = {o.name: o.part.piece_of or o.part.number for o in assembly.occurrences}

    def close(self) -> None:
        """Lets go of the window."""
        self.window.Finalize()

    def draw(
        self, step: Step, coming: Sequence[tuple[Insertion, tuple[str, ...]]], there: Sequence[str], path: Path
    ) -> Mapping[str, Colour]:
        """Draws a step.

        Args:
            step: The step.
            coming: What it brings in, with the names of all occurrences of each, in its order.
            there: What is there before.
            path: File to write.

        Returns:
            Part number, or kind of a unit that comes in whole -> the colour in which it is drawn.
        """
        drawn = self._drawn(coming, bool(there))
        colours: dict[str, Colour] = {}
        through: list[Placed] = []  # what is drawn over all that hides it
        parts = [self._placed(name, _THERE) for name in there if name not in (*step.unseen, *step.shown)]
        coloured = [(one, name) for one in drawn for name in one.names]
        coloured += [(Drawn(step.shown, np.zeros(3), None, ""), name) for name in step.shown]
        for one, name in coloured:
            key = one.unit or self._ordered[name]
            colour = colours.setdefault(key, ACCENTS[len(colours) % len(ACCENTS)])
            parts.append(self._placed(name, colour, one.away))
            if one.is_flexible:
                through.append(parts[-1])
        towards = _towards(drawn)
        scene = PartScene(parts)
        shown = [self._points(one.names) + away for one in drawn for away in (one.away, np.zeros(3))]
        shown += [self._points(step.shown)] if step.shown else []
        matter = np.concatenate(shown) if shown else scene.points_mm
        overlay, pixel = _aimed(scene.renderer, towards, scene.points_mm, matter)
        self._add_arrows(drawn, overlay, towards, pixel)
        for part in through:
            overlay.AddActor(flat_actor(joined([part]), part.colour))
        photograph(self.window, (scene.renderer, overlay), path)
        return colours

    def _placed(self, name: str, colour: Colour, away: np.ndarray | None = None) -> Placed:
        frame = np.array(self._frames[name])
        if away is not None:
            frame[:3, 3] += away
        return placed(self._meshes[self._number[name]], frame, colour)

    def _points(self, names: Sequence[str]) -> np.ndarray:
        return np.concatenate(
            [
                self._meshes[self._number[name]].hull_points @ self._frames[name][:3, :3].T + self._frames[name][:3, 3]
                for name in names
            ]
        )

    def _drawn(self, coming: Sequence[tuple[Insertion, tuple[str, ...]]], into: bool) -> list[Drawn]:
        """Draws each out along its first leg by most of its length, those that go the same way one before the other.

        Args:
            coming: What comes in.
            into: Whether something is there; else the first stays.
        """
        found: list[Drawn] = []
        gone: list[tuple[np.ndarray, np.ndarray, float]] = []  # direction, (2, 3) box, distance
        for insertion, names in coming:
            if not names:
                continue
            unit = re.sub(r" \d+$", "", insertion.units[0]) if insertion.units else ""
            if not insertion.path or not (into or found):
                found.append(Drawn(names, np.zeros(3), None, unit, insertion.is_flexible))
                continue
            turn = np.array(self._frames[insertion.frame or names[0]])[:3, :3]
            points = self._points(names)
            legs = [(-(turn @ np.array(leg.along)), leg.length_mm) for leg in insertion.path]
            bend = None if len(legs) == 1 else legs[1][0] * legs[1][1]
            out = legs[0][0]
            along = points @ out
            box = np.array([points.min(axis=0), points.max(axis=0)])
            size = float(along.max() - along.min())
            before = [d for way, other, d in gone if way @ out > 0.99 and _adjacent(box, other, out)]
            length = min(_OWN * size, _MOST_MM / 2) + _GAP_MM + max(before, default=0.0)
            gone.append((out, box, length))
            away = out * min(length, _MOST_MM)
            found.append(Drawn(names, away if bend is None else away + bend, bend, unit))
        return found

    def _add_arrows(self, drawn: Sequence[Drawn], overlay: Any, towards: np.ndarray, pixel: float) -> None:
        """Adds to the layer over the picture an arrow for each way, from what is drawn out to its seat."""
        lines, heads = [], []
        for one in drawn:
            if not one.away.any():
                continue
            points = self._points(one.names)
            way = (np.zeros(3) if one.bend is None else one.bend) - one.away
            ahead = points @ way
            middle = (points.min(axis=0) + points.max(axis=0)) / 2.0
            middle = middle + way * (ahead.max() - middle @ way) / (way @ way)  # where it ends before its seat
            corners = [one.away, *([one.bend] if one.bend is not None else []), np.zeros(3)]
            ends = np.array([middle + corner for corner in corners])
            lines += [ends[k : k + 2] for k in range(len(ends) - 1)]
            heads.append(_head(ends[-2], ends[-1], towards, pixel))
        for shapes, width in ((lines, _ARROW_WIDTH), (heads, 1.0)):
            if shapes:
                overlay.AddActor(flat_shapes(shapes, ARROW, width))


def _adjacent(box: np.ndarray, other: np.ndarray, out: np.ndarray) -> bool:
    """Whether two boxes overlap when they are seen along a direction: in the two axes that it is least along."""
    across = np.argsort(np.abs(out))[:2]
    return bool((box[0, across] < other[1, across]).all() and (box[1, across] > other[0, across]).all())


def _head(tail: np.ndarray, tip: np.ndarray, towards: np.ndarray, pixel: float) -> np.ndarray:
    """(3, 3) corners of an arrow's head in the plane of the picture."""
    way = tip - tail
    flat = way - (way @ towards) * towards
    flat /= np.linalg.norm(flat) + 1e-12
    side = np.cross(towards, flat)
    back = tip - _HEAD_PIXELS * pixel * flat
    return np.array(
        [tip, back + _HEAD_SLOPE * _HEAD_PIXELS * pixel * side, back - _HEAD_SLOPE * _HEAD_PIXELS * pixel * side]
    )


def _towards(drawn: Sequence[Drawn]) -> np.ndarray:
    """Chooses the view: each way comes half towards the viewer, so that neither arrow nor seat is hidden."""
    ways = [one.away - (0.0 if one.bend is None else one.bend) for one in drawn]
    units = [way / np.linalg.norm(way) for way in ways if np.linalg.norm(way) > 0.0]

    def worth(view: np.ndarray, place: int) -> float:
        seen = [-abs(float(unit @ view) - _ASIDE) for unit in units]
        return (np.mean(seen) if seen else 0.0) + _FROM_ABOVE * (view[2] > 0.0) - _FIRST * place

    return VIEWS[max(range(len(VIEWS)), key=lambda k: worth(VIEWS[k], k))]


def _aimed(renderer: Any, towards: np.ndarray, points: np.ndarray, matter: np.ndarray) -> tuple[Any, float]:
    """Sets a parallel camera on what matters, with enough around it to see where that is.

    Args:
        renderer: The scene.
        towards: (3,) direction towards the viewer.
        points: (n, 3) all that is there, mm.
        matter: (m, 3) what has to be seen, mm.

    Returns:
        The layer over the picture, and the size of a pixel of the finished picture, mm.
    """
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    up = np.cross(towards, right)
    (low, high), (least, most) = (
        (flat.min(axis=0), flat.max(axis=0)) for flat in (seen @ np.stack([right, up]).T for seen in (points, matter))
    )
    half = np.maximum(_AROUND * (most - least), SHARE * (high - low)) / 2.0
    middle = np.clip((least + most) / 2.0, np.minimum(low + half, high - half), np.maximum(low + half, high - half))
    low, high = np.maximum(middle - half, low), np.minimum(middle + half, high)
    pixel = float((_MARGIN * (high - low) / np.array(SIZE)).max())
    target = ((low + high) / 2.0) @ np.stack([right, up])
    return aim(renderer, target, towards, up, SIZE[1] * pixel), pixel
