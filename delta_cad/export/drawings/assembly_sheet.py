"""The assembly drawing: two views of the machine, a drive and a pair of rods exploded, balloons, item list.

Each item of the bill of materials that has a place in the machine gets one balloon, in the first view that shows
enough of one of its parts.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from math import hypot

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.common.memoize import cached
from delta_cad.export.bom import BomRow
from delta_cad.export.drawings.items import item_lists
from delta_cad.export.drawings.layout import ratio
from delta_cad.export.drawings.sheet_io.lettering import width_of
from delta_cad.export.drawings.sheet_io.sheet import (
    Arc,
    Area,
    Box,
    Drawing,
    Item,
    Point,
    Stroke,
    Text,
    box_of,
    moved,
    scaled,
)
from delta_cad.export.drawings.title import TITLE_MM, Titles, framed, inner
from delta_cad.export.drawings.views.marks import LETTER_MM, arrow, number, spread_within
from delta_cad.export.drawings.views.projection import Frame, Seen, seen_of
from delta_cad.export.views.explode import exploded_chain
from delta_cad.solids.part import Occurrence, location_of, solid_digest

_SIZE = "A3"
_SCALES = (2.0, 1.0, 0.5, 0.2, 0.1)
_BALLOON_MM, _BALLOON_PITCH_MM = 4.0, 10.0  # radius, and from one to the next
_DOT_MM = 0.8
_SHOWN_MM = 1.2  # of visible edge on paper at least, for a balloon to point at it
_AWAY_MM = 14.0  # from a view to its balloons
_DIMENSION_MM = 9.0
_SHELL_MM, _ROD_MM, _END_MM = 10.0, 24.0, 26.0  # by which a rod's parts are pulled off its balls and apart
_MESHED = 0.2, 0.6  # deviation, mm, and angle, rad, of the meshes whose boxes tell how far parts have to move
_SMALL = ("capstan_cable", "pinion", "wave_spring", "set_screw", "crimp_sleeve", "tension_", "encoder_magnet", "dowel_")
"""Numbers, by their beginnings, of what an overall view leaves out: within others, or thinner than a pen."""
ALONE, _APART_MM = 6, 8.0  # parts on a sheet where they stand by themselves, and from one to the next
_OBLIQUE = Frame.seen_from(np.array([0.80, -0.55, 0.38]), np.array([0.0, 0.0, 1.0]))
_CHAIN = re.compile(r"[A-Za-z_]+_0(_.*)?")


_Placed = tuple[Occurrence, np.ndarray]


@dataclass
class _Shown:
    """One view of placed parts.

    Attributes:
        title: Written over it.
        frame: From where.
        placed: Occurrences with their places, (4, 4), mm.
        overall: Whether it is dimensioned over all.
        seen: What is seen of it.
        scale: Of the sheet to the machine.
        balloons: Item -> the point on the view that its balloon points at, mm of the machine.
    """

    title: str
    frame: Frame
    placed: list[_Placed]
    overall: bool = False
    scale: float = 1.0
    balloons: dict[int, Point] = field(default_factory=dict)
    seen: Seen | None = None

    def look(self) -> None:
        """Finds what is seen."""
        of = [(solid_digest(o.part.solid), pose) for o, pose in self.placed], self.frame
        shapes = (o.part.solid.wrapped.Moved(location_of(pose)) for o, pose in self.placed)
        self.seen = cached("seen", of, lambda: seen_of(list(shapes), self.frame))


_Page = tuple[str, list[Item], dict[str, Box]]


def assembly_drawing(
    assembly: Assembly,
    rows: Sequence[BomRow],
    titles: Titles,
    progress: Callable[[str], None] = lambda _: None,
    sections: Sequence[_Page] = (),
) -> Drawing:
    """Draws the assembly; `sections` are sheets that come after the views: scale, items and frames of each."""
    poses = assembly.poses(assembly.home_mm)
    views = _views(assembly, poses)
    for view in views:
        progress(f"drawing of the assembly, {view.title}")
        view.look()
    groups = [views[:2], *([view] for view in views[2:])]
    for group in groups:
        _scale(group)
    if hidden := placed_items(assembly, rows) - _share(views, rows):
        progress("drawing of the assembly, parts by themselves")
        left = [row for row in rows if row.item in hidden]
        for some in (left[n : n + ALONE] for n in range(0, len(left), ALONE)):
            alone = _alone(assembly, [row.part_number for row in some])
            alone.look()
            _scale([alone])
            _share([alone], some)
            groups.append([alone])
    pages = [*(_page(group) for group in groups), *sections, *item_lists(rows)]
    sheets = []
    for n, (scale, items, frames) in enumerate(pages, 1):
        sheet = framed(_SIZE, scale, f"{n} / {len(pages)}", titles)
        sheet.add(items)
        sheet.frames |= frames
        sheets.append(sheet)
    return Drawing("assembly", f"{titles.number}: {titles.description}", tuple(sheets))


def placed_items(assembly: Assembly, rows: Iterable[BomRow]) -> set[int]:
    """Gives the items of a bill of materials that have a place in the machine, and so a balloon."""
    numbers = {occurrence.part.number for occurrence in assembly.occurrences}
    return {row.item for row in rows if row.part_number in numbers}


def _views(assembly: Assembly, poses: Mapping[str, np.ndarray]) -> list[_Shown]:
    overall = [(o, poses[o.name]) for o in assembly.occurrences if not o.part.number.startswith(_SMALL)]
    return [
        _Shown("from the front, arms at equal angles", Frame((1, 0, 0), (0, 0, 1)), overall, overall=True),
        _Shown("from above", Frame((1, 0, 0), (0, 1, 0)), overall, overall=True),
        _Shown("drive of one chain, each part pulled off along its axis", _OBLIQUE, _drive(assembly, poses)),
        _Shown("pair of rods of one chain, pulled off its balls", _OBLIQUE, _rods(assembly, poses)),
    ]


def _alone(assembly: Assembly, numbers: Iterable[str]) -> _Shown:
    """Parts one over the other: what in a machine is hidden by others from every side that is drawn."""
    parts = {one.part.number: one for one in assembly.occurrences}
    frame, placed, level = _OBLIQUE, [], 0.0
    for number_ in numbers:
        box = parts[number_].part.solid.BoundingBox()
        middle, half = np.array(box.center.toTuple()), box.DiagonalLength / 2.0
        pose = np.eye(4)
        pose[:3, 3] = (level - half) * np.array(frame.up) - middle
        placed.append((parts[number_], pose))
        level -= 2.0 * half + _APART_MM
    return _Shown("parts that the other views hide", frame, placed)


def _of_rods(occurrence: Occurrence) -> bool:
    return occurrence.part.number.startswith(("rod_", "cup_shell", "joint_ball", "cross_bar"))


def _drive(assembly: Assembly, poses: Mapping[str, np.ndarray]) -> list[_Placed]:
    """The parts of chain 0 without its rods, taken apart as in the picture: none stands in another."""
    group = [
        o for o in assembly.occurrences if _CHAIN.fullmatch(o.name) and not _of_rods(o) and o.part.number != "foot"
    ]
    moves = exploded_chain(assembly, MeshLibrary(assembly.parts, *_MESHED), group)
    return [(one, _shifted(poses[one.name], moves[one.name])) for one in group]


def _rods(assembly: Assembly, poses: Mapping[str, np.ndarray]) -> list[_Placed]:
    """The rods of chain 0 and the bars they hang on, shells and cups pulled off the balls, tubes off the cups."""
    group = [o for o in assembly.occurrences if _CHAIN.fullmatch(o.name) and _of_rods(o)]
    centres = {o.name: poses[o.name][:3, 3] for o in group}
    middle = np.mean([centres[o.name] for o in group if o.part.number == "joint_ball"], axis=0)
    found = []
    for one in group:
        pose, away = poses[one.name], np.zeros(3)
        side = float(np.sign(centres[one.name][1] - middle[1]))
        if one.part.number == "cup_shell":
            away[1] = side * _SHELL_MM
        elif one.link.startswith("rod_"):
            along = poses[f"rod_tube_{one.link[4:]}"][:3, 0]
            away[1] = side * _ROD_MM
            if one.part.number == "rod_cup":
                away += along * (_END_MM if one.name.endswith("wrist") else -_END_MM)
        elif one.part.number == "joint_ball":
            away[1] = side * _SHELL_MM * 0.4
        found.append((one, _shifted(pose, away)))
    return found


def _shifted(pose: np.ndarray, away: np.ndarray) -> np.ndarray:
    found = pose.copy()
    found[:3, 3] += away
    return found


def _share(views: Sequence[_Shown], rows: Sequence[BomRow]) -> set[int]:
    """Gives each item its balloon: in a view that pulls its parts apart if there is one, else where most is seen.

    Returns:
        The items that got one.
    """
    by_number = {row.part_number: row.item for row in rows}
    for number_, item in by_number.items():
        best: tuple[float, _Shown, Point] | None = None
        for view in (*views[2:], *views[:2]):
            assert view.seen is not None
            shown = [
                (length * view.scale, at)
                for (one, _), (length, at) in zip(view.placed, view.seen.marks, strict=True)
                if one.part.number == number_
            ]
            length, at = max(shown, default=(0.0, (0.0, 0.0)))
            if length >= _SHOWN_MM and (best is None or (best[0] < _SHOWN_MM)):
                best = (length, view, at)
        if best is not None:
            best[1].balloons[item] = best[2]
    return {item for view in views for item in view.balloons}


def _scale(group: Sequence[_Shown]) -> None:
    """Gives views that share a sheet the largest scale at which they stand side by side, off the title block."""
    area = inner(_SIZE)
    boxes = [box_of(view.seen.items) for view in group if view.seen is not None]
    around = 2.0 * (_AWAY_MM + _DIMENSION_MM + 2.0 * _BALLOON_MM) + 4.0
    wide, tall = area[2] - area[0] - len(group) * around, area[3] - area[1] - 30.0
    rooms = [(wide, tall - TITLE_MM[1])]
    if len(group) == 1:  # or beside it
        rooms.append((wide - TITLE_MM[0], tall))
    size = sum(b[2] - b[0] for b in boxes), max(b[3] - b[1] for b in boxes)
    fits = [s for s in _SCALES if any(s * size[0] <= room[0] and s * size[1] <= room[1] for room in rooms)]
    for view in group:
        view.scale = fits[0] if fits else _SCALES[-1]


def _page(group: Sequence[_Shown]) -> tuple[str, list[Item], dict[str, Box]]:
    """Lays views out side by side on a separate sheet, with their annotations."""
    area, page, frames = inner(_SIZE), [], {}
    left = area[0] + 8.0
    for n, view in enumerate(group):
        assert view.seen is not None
        items = [scaled(item, view.scale) for item in view.seen.items]
        drawn = box_of(items)
        if view.overall:
            items += _over_all(drawn, view.scale)
        reported = {k: (x * view.scale, y * view.scale) for k, (x, y) in view.balloons.items()}
        items += balloons(reported, drawn)
        box = box_of(items)
        items = [moved(item, (left - box[0], area[3] - 16.0 - box[3])) for item in items]
        items.append(Text((left, area[3] - 8.0), 3.5, view.title))
        frames[f"view {n}"] = box_of(items)
        page += items
        left = frames[f"view {n}"][2] + 10.0
    return ratio(group[0].scale), page, frames


def _over_all(drawn: Box, scale: float) -> list[Item]:
    """Width below a view and height on its right, as dimensions between arrows."""
    x0, y0, x1, y1 = drawn
    low, far = y0 - _DIMENSION_MM, x1 + _DIMENSION_MM
    wide, tall = number(round((x1 - x0) / scale, 1)), number(round((y1 - y0) / scale, 1))
    items: list[Item] = [
        Stroke("dimension", ((x0, y0 - 1.0), (x0, low - 2.0))),
        Stroke("dimension", ((x1, y0 - 1.0), (x1, low - 2.0))),
        Stroke("dimension", ((x0, low), (x1, low))),
        arrow((x0, low), (x1, low)),
        arrow((x1, low), (x0, low)),
        Text(((x0 + x1 - width_of(wide, LETTER_MM)) / 2, low + 0.8), LETTER_MM, wide),
        Stroke("dimension", ((x1 + 1.0, y0), (far + 2.0, y0))),
        Stroke("dimension", ((x1 + 1.0, y1), (far + 2.0, y1))),
        Stroke("dimension", ((far, y0), (far, y1))),
        arrow((far, y0), (far, y1)),
        arrow((far, y1), (far, y0)),
        Text((far - 0.8, (y0 + y1 - width_of(tall, LETTER_MM)) / 2), LETTER_MM, tall, upright=True),
    ]
    return items


def balloons(points: Mapping[int, Point], drawn: Box) -> list[Item]:
    """Sets balloons on both sides of a view, each about level with what it points at.

    Leaders that are as short as can be, all together, do not cross: two that did could change their ends.

    Args:
        points: Item -> the point that its balloon points at, mm on the sheet.
        drawn: Box of the view.
    """
    from scipy.optimize import linear_sum_assignment  # loads for a while, and only this needs it

    items: list[Item] = []
    ordered = sorted(points.items(), key=lambda one: one[1][0])
    half = (len(ordered) + 1) // 2
    for side, group in ((-1.0, ordered[:half]), (1.0, ordered[half:])):
        heights = spread_within(sorted(point[1] for _, point in group), _BALLOON_PITCH_MM, drawn[1], drawn[3])
        x = drawn[0] - _AWAY_MM if side < 0.0 else drawn[2] + _AWAY_MM + _DIMENSION_MM
        edges = [(x - side * _BALLOON_MM, y) for y in heights]
        away = [[hypot(edge[0] - point[0], edge[1] - point[1]) for edge in edges] for _, point in group]
        for one, other in zip(*linear_sum_assignment(np.reshape(away, (len(group), len(edges)))), strict=True):
            (item, point), edge, y = group[one], edges[other], heights[other]
            text = str(item)
            items += [
                Arc("dimension", (x, y), _BALLOON_MM),
                Text((x - width_of(text, LETTER_MM) / 2, y - LETTER_MM / 2), LETTER_MM, text, states=(f"item {item}",)),
                Stroke("dimension", (edge, point)),
                _dot(point),
            ]
    return items


def _dot(at: Point) -> Area:
    x, y = at
    return Area("dimension", ((x - _DOT_MM, y), (x, y + _DOT_MM), (x + _DOT_MM, y), (x, y - _DOT_MM)))


def balloon_faults(drawing: Drawing, items: set[int], rows: Sequence[BomRow]) -> list[str]:
    """Finds items without a balloon, or with more than one, and rows that are not in the list once."""
    reported = [key for sheet in drawing.sheets for text in sheet.texts for key in text.states]
    counts = [(f"item {n}", "balloons") for n in sorted(items)] + [(f"row {row.item}", "rows") for row in rows]
    return [f"{key} has {reported.count(key)} {what}" for key, what in counts if reported.count(key) != 1]
