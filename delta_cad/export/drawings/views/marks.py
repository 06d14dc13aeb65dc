"""The small things that a view is annotated with: arrows, numbers, texts spread along a line or put in free places."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, hypot, pi, sin

import numpy as np

from delta_cad.export.drawings.sheet_io.lettering import width_of
from delta_cad.export.drawings.sheet_io.sheet import Area, Item, Point, Stroke, Text, crosses, lines_of, overlap

LETTER_MM = 2.5  # ISO 3098
ARROW_MM = (2.5, 0.8)
_TIED_MM = 3.0  # from a hole to its tag, from which on a line ties them


class RoomError(ValueError):
    """A tag finds no free place near its hole."""


def number(value: float) -> str:
    """Writes a length to a micrometre, without zeros at its end."""
    return f"{round(value, 3) + 0.0:g}"


def spread(wanted: Sequence[float], sizes: Sequence[float]) -> list[float]:
    """Moves centres on a line as little as needed that they keep their order and do not overlap.

    Args:
        wanted: Where each should be, rising.
        sizes: How long each is.

    Returns:
        Where each comes: by joining neighbours that would overlap to one run about the mean of what they want.
    """
    runs: list[list[float]] = []  # sum of wanted starts, count, length
    for want, size in zip(wanted, sizes, strict=True):
        runs.append([want - size / 2, 1.0, size])
        while len(runs) > 1 and runs[-2][0] / runs[-2][1] + runs[-2][2] > runs[-1][0] / runs[-1][1]:
            start, count, length = runs.pop()
            runs[-1][0] += start - count * runs[-1][2]
            runs[-1][1] += count
            runs[-1][2] += length
    starts = [run[0] / run[1] for run in runs for _ in range(int(run[1]))]
    places, at, k = [], 0.0, 0
    for run in runs:
        at = run[0] / run[1]
        for _ in range(int(run[1])):
            places.append(at + sizes[k] / 2)
            at += sizes[k]
            k += 1
    assert len(places) == len(starts)
    return places


def spread_within(wanted: Sequence[float], pitch: float, low: float, high: float) -> list[float]:
    """Moves points on a line apart, and between two ends where all have room there.

    Args:
        wanted: Where each should be, rising.
        pitch: From one to the next, at least.
        low: The lower end.
        high: The upper end.

    Returns:
        Where each comes, in their order.
    """
    places = spread(wanted, [pitch] * len(wanted))
    if pitch * (len(places) - 1) > high - low:
        return places
    raised = [max(at, low + pitch * k) for k, at in enumerate(places)]
    return [min(at, high - pitch * k) for k, at in enumerate(reversed(raised))][::-1]


def arrow(tip: Point, towards: Point) -> Area:
    """Gives the head of an arrow at its tip, coming from a point."""
    length, half = ARROW_MM[0], ARROW_MM[1] / 2
    away = hypot(towards[0] - tip[0], towards[1] - tip[1]) or 1.0
    x, y = (towards[0] - tip[0]) / away, (towards[1] - tip[1]) / away
    back = tip[0] + length * x, tip[1] + length * y
    return Area("dimension", (tip, (back[0] - half * y, back[1] + half * x), (back[0] + half * y, back[1] - half * x)))


def towards(centre: Point, point: Point, radius: float) -> Point:
    """Gives the point of a circle that is nearest to another point."""
    away = hypot(point[0] - centre[0], point[1] - centre[1]) or 1.0
    return centre[0] + radius * (point[0] - centre[0]) / away, centre[1] + radius * (point[1] - centre[1]) / away


def higher(middle: Point, aside: Point) -> tuple[Point, Callable[[Point], Point]]:
    """The side of an outline that is nearer to where the leader comes from."""
    ends = [(middle[0] + s * aside[0], middle[1] + s * aside[1]) for s in (-1.0, 1.0)]
    return max(ends, key=lambda p: p[1]), lambda point: min(ends, key=lambda p: hypot(p[0] - point[0], p[1] - point[1]))


def free_text(text: str, centre: Point, radius: float, items: Sequence[Item], height: float = LETTER_MM) -> Text:
    """A text near a circle that lies over no line and no other text.

    Raises:
        RoomError: There is no such place within 25 mm of it.
    """
    width = width_of(text, height)
    boxes = [item.box for item in items if isinstance(item, Text)]
    lines, reach = lines_of(items), radius + 40.0
    far = (lines.min(axis=1) > np.array(centre) + reach) | (lines.max(axis=1) < np.array(centre) - reach)
    lines = lines[~far.any(axis=1)]
    for step in range(18):
        away = radius + 0.8 + 1.4 * step
        for turn in range(16):
            angle = pi / 4 + turn * pi / 8
            x, y = centre[0] + away * cos(angle), centre[1] + away * sin(angle)
            left = x - width / 2 + (width / 2) * cos(angle)
            base = y - height / 2 + (height / 2) * sin(angle)
            found = Text((left, base), height, text)
            b = found.box
            room = (b[0] - 0.4, b[1] - 0.1, b[2] + 0.4, b[3] + 0.4)
            if any(overlap(room, other) for other in boxes) or crosses(room, lines):
                continue
            return found
    raise RoomError(f"tag {text} finds no room beside its hole")


def tied(tag: Text, centre: Point, radius: float) -> list[Item]:
    """A line from a tag to its circle, where it stands so far off that one could take it for another's."""
    x0, y0, x1, y1 = tag.box
    near = min(max(centre[0], x0), x1), min(max(centre[1], y0), y1)
    if hypot(near[0] - centre[0], near[1] - centre[1]) < radius + _TIED_MM:
        return []
    return [Stroke("dimension", (near, towards(centre, near, radius)))]
