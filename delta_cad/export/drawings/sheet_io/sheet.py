"""A drawing as lines, arcs, areas and texts on sheets, in mm from the lower left corner, for checking and writing."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from math import cos, radians, sin
from typing import Any, Protocol

import numpy as np

from delta_cad.export.drawings.sheet_io.lettering import width_of

Point = tuple[float, float]
Box = tuple[float, float, float, float]
"""Least x, least y, largest x, largest y, mm."""

_WIDE_MM, _NARROW_MM = 0.5, 0.25  # ISO 128-20, line group 0.5


@dataclass(frozen=True)
class _Pen:
    """How a layer is drawn: width, mm, and lengths of dashes and gaps in turn, mm; none: drawn through."""

    width_mm: float
    dashes: tuple[float, ...] = ()


LAYERS: dict[str, _Pen] = {
    "visible": _Pen(_WIDE_MM),
    "hidden": _Pen(_NARROW_MM, (2.0, 1.0)),
    "centre": _Pen(_NARROW_MM, (6.0, 1.0, 0.7, 1.0)),
    "hatch": _Pen(0.18),
    "dimension": _Pen(_NARROW_MM),
    "cut": _Pen(0.7),
    "frame": _Pen(0.7),
    "table": _Pen(_NARROW_MM),
    "text": _Pen(_NARROW_MM),
}
"""Layers of a drawing, in all its files alike."""
EDGES = ("visible",)
"""Layers that no text may lie over."""


@dataclass(frozen=True)
class Stroke:
    """A line through points, mm."""

    layer: str
    points: tuple[Point, ...]
    closed: bool = False


@dataclass(frozen=True)
class Arc:
    """An arc anticlockwise from a start angle to an end angle, degrees; 360 apart: a circle."""

    layer: str
    centre: Point
    radius: float
    start: float = 0.0
    end: float = 360.0

    @property
    def whole(self) -> bool:
        """Decides whether it is a circle."""
        return self.end - self.start >= 360.0 - 1e-6

    def points(self, step_deg: float = 3.0) -> tuple[Point, ...]:
        """Gives points of it, at most `step_deg` apart."""
        count = max(2, int((self.end - self.start) / step_deg) + 2)
        angles = (radians(self.start + (self.end - self.start) * k / (count - 1)) for k in range(count))
        return tuple((self.centre[0] + self.radius * cos(a), self.centre[1] + self.radius * sin(a)) for a in angles)


@dataclass(frozen=True)
class Area:
    """A filled polygon: an arrow's head."""

    layer: str
    points: tuple[Point, ...]


@dataclass(frozen=True)
class Text:
    """One line of text.

    Attributes:
        at: Left end of its base line, mm.
        height: Height of its capitals, mm.
        text: What it says.
        upright: Whether it reads upwards, from the right.
        states: Keys of what it states: bores, dimensions; see `checker`.
    """

    at: Point
    height: float
    text: str
    upright: bool = False
    states: tuple[str, ...] = ()

    @property
    def length(self) -> float:
        """Length along its base line, mm."""
        return width_of(self.text, self.height)

    @property
    def end(self) -> Point:
        """Right end of its base line, mm."""
        x, y = self.at
        return (x, y + self.length) if self.upright else (x + self.length, y)

    @property
    def box(self) -> Box:
        """What it covers, with the part of a letter below the base line."""
        (x, y), below = self.at, 0.25 * self.height
        if self.upright:
            return x - self.height, y, x + below, y + self.length
        return x, y - below, x + self.length, y + self.height


Primitive = Stroke | Arc | Area | Text


@dataclass(frozen=True)
class Measure:
    """What a dimension measures, for files that know dimensions.

    Attributes:
        kind: "right" or "up" of an ordinate, "diameter", "radius" or "length".
        points: Of an ordinate the origin, the feature and the end of its line; of a diameter two opposite points, of a
            radius centre and arc, of a length its two ends; mm on the sheet.
        value_mm: What it is of the part.
        text: What is printed.
    """

    kind: str
    points: tuple[Point, ...]
    value_mm: float
    text: str


@dataclass(frozen=True)
class Annotation:
    """What belongs together: a dimension with its lines, or a symbol, into whose box nothing else may come.

    Attributes:
        name: "dimension", or of a symbol its kind and what it says, such as "position Ø0.05 A B" or "datum A".
        items: What it is drawn with.
        measure: Of a dimension what it measures.
    """

    name: str
    items: tuple[Primitive, ...]
    measure: Measure | None = None

    @property
    def box(self) -> Box:
        """What it covers."""
        return box_of(self.items)


Item = Primitive | Annotation


def primitives(items: Iterable[Item]) -> Iterator[Primitive]:
    """Gives what items are drawn with, marks taken apart."""
    for item in items:
        if isinstance(item, Annotation):
            yield from item.items
        else:
            yield item


@dataclass
class Sheet:
    """One sheet: its size, what is drawn on it, and boxes that nothing else may enter.

    Attributes:
        width: Width, mm.
        height: Height, mm.
        items: What is drawn, in order.
        frames: Boxes of tables, views' titles and tags by name.
    """

    width: float
    height: float
    items: list[Item] = field(default_factory=list)
    frames: dict[str, Box] = field(default_factory=dict)

    def add(self, items: Iterable[Item]) -> None:
        """Draws more."""
        self.items.extend(items)

    @property
    def texts(self) -> Iterator[Text]:
        """All texts."""
        return (item for item in primitives(self.items) if isinstance(item, Text))

    @property
    def symbols(self) -> Iterator[Annotation]:
        """All symbols."""
        return (item for item in self.items if isinstance(item, Annotation) and item.measure is None)


class Sectioned(Protocol):
    """Where a view is cut open, as far as a drawing's checker asks."""

    def meets(self, bore: Any) -> bool:
        """Decides whether a bore is cut along its axis."""
        ...

    def holds(self, point: np.ndarray) -> bool:
        """Decides whether a (3,) point is in its planes."""
        ...


@dataclass(frozen=True)
class Drawing:
    """A drawing of one or more sheets, with what its files say of themselves, and the sections among its views."""

    name: str
    title: str
    sheets: tuple[Sheet, ...]
    sections: tuple[Sectioned, ...] = ()


def _mapped(item: Item, at: Callable[[Point], Point], scale: float = 1.0) -> Item:
    """Gives an item with its points elsewhere and, where it is scaled, other radii; letters keep their height.

    Args:
        item: The item.
        at: Where a point comes.
        scale: Of radii, and of no more.
    """
    if isinstance(item, Annotation):
        measure = item.measure and replace(item.measure, points=tuple(map(at, item.measure.points)))
        return Annotation(item.name, tuple(mapped_primitive(one, at, scale) for one in item.items), measure)
    return mapped_primitive(item, at, scale)


def mapped_primitive(item: Primitive, at: Callable[[Point], Point], scale: float = 1.0) -> Primitive:
    """Gives a primitive elsewhere; as `_mapped`."""
    if isinstance(item, Text):
        return replace(item, at=at(item.at))
    if isinstance(item, Arc):
        return replace(item, centre=at(item.centre), radius=item.radius * scale)
    return replace(item, points=tuple(map(at, item.points)))


def moved(item: Item, by: Point) -> Item:
    """Gives an item shifted."""
    return _mapped(item, lambda point: (point[0] + by[0], point[1] + by[1]))


def scaled(item: Item, scale: float) -> Item:
    """Gives an item at a scale about the origin."""
    return _mapped(item, lambda point: (point[0] * scale, point[1] * scale), scale)


def in_a_row(drawing: Drawing) -> Sheet:
    """Gives a drawing's sheets side by side as one, for files that hold one."""
    first = drawing.sheets[0]
    if len(drawing.sheets) == 1:
        return first
    row, left = Sheet(0.0, max(sheet.height for sheet in drawing.sheets)), 0.0
    for sheet in drawing.sheets:
        row.add(moved(item, (left, 0.0)) for item in sheet.items)
        left += sheet.width
    row.width = left
    return row


def box_of(items: Iterable[Item]) -> Box:
    """Computes the box around items; of nothing an empty box at the origin."""
    corners: list[Point] = []
    for item in primitives(items):
        if isinstance(item, Text):
            corners += [(item.box[0], item.box[1]), (item.box[2], item.box[3])]
        else:
            corners += item.points() if isinstance(item, Arc) else item.points
    if not corners:
        return 0.0, 0.0, 0.0, 0.0
    xs, ys = zip(*corners, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def overlap(a: Box, b: Box, apart: float = 0.0) -> bool:
    """Decides whether two boxes come closer than a distance, mm."""
    return a[0] < b[2] + apart and b[0] < a[2] + apart and a[1] < b[3] + apart and b[1] < a[3] + apart


def lines_of(items: Iterable[Item]) -> np.ndarray:
    """Gives the lines that items are drawn with, arcs by chords of 3 degrees, as (n, 2, 2) ends; texts have none."""
    found: list[np.ndarray] = []
    for item in primitives(items):
        if isinstance(item, Text):
            continue
        points = np.array(item.points() if isinstance(item, Arc) else item.points, dtype=float)
        if isinstance(item, Area) or (isinstance(item, Stroke) and item.closed):
            points = np.concatenate([points, points[:1]])
        found.append(np.stack([points[:-1], points[1:]], axis=1))
    return np.concatenate(found) if found else np.zeros((0, 2, 2))


def crosses(box: Box, lines: np.ndarray) -> bool:
    """Decides whether one of (n, 2, 2) lines passes through the inside of a box: each is clipped against its sides."""
    start, way = lines[:, 0], lines[:, 1] - lines[:, 0]
    low, high = np.zeros(len(lines)), np.ones(len(lines))
    for k in range(2):
        along = np.where(np.abs(way[:, k]) < 1e-12, 1e-12, way[:, k])
        first, last = (box[k] - start[:, k]) / along, (box[k + 2] - start[:, k]) / along
        low, high = np.maximum(low, np.minimum(first, last)), np.minimum(high, np.maximum(first, last))
    return bool((low < high).any())
