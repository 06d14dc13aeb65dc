"""Layout of views, tables and notes: the smallest sheet and the largest scale at which all fit and are legible."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.sheet import Box, Item, Point, Sheet, box_of, moved, overlap
from delta_cad.export.drawings.title import Titles, framed, hole_table, inner, notes_items, title_box
from delta_cad.export.drawings.views.block import Block, block_of, cuts_in
from delta_cad.export.drawings.views.choice import View
from delta_cad.export.drawings.views.marks import RoomError

_SCALES = (10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1)  # ISO 5455
_APART_MM = 7.0  # between blocks
_STEP_MM = 4.0  # of the places that are tried
_CROWDED, _CROWDED_MM = 40, 140.0  # coordinates from which on a part needs more than that, mm
_READABLE_MM = 75.0  # on the sheet a part's longest side should have at least, where its scale need not exceed 5:1
_NOTES_MM = 78.0


class LayoutError(ValueError):
    """A part does not fit on a sheet at any scale."""


@dataclass
class _Placed:
    """Items at a place on a sheet."""

    items: list[Item]
    at: Point

    @property
    def box(self) -> Box:
        x0, y0, x1, y1 = box_of(self.items)
        return x0 + self.at[0], y0 + self.at[1], x1 + self.at[0], y1 + self.at[1]


def laid_out(
    views: Sequence[View],
    features: Features,
    controlled: Controlled,
    titles: Titles,
    notes: Sequence[tuple[str, str]],
) -> list[Sheet]:
    """Lays a part's drawing out: its views, the main one first, and notes, of each the key that it states and its text.

    Returns:
        One sheet, or more where tables and turned views need one of their own.

    Raises:
        LayoutError: It fits on no sheet.
        RoomError: A tag has no place at any scale.
    """
    longest = float(np.ptp(np.concatenate([face.box for face in features.faces]), axis=0).max())
    least = _CROWDED_MM if len(features.places) > _CROWDED else _READABLE_MM
    wanted = next((s for s in reversed(_SCALES) if s * longest >= least and s <= 5.0), 5.0)
    tries = [(size, s, False) for size in ("A4", "A3") for s in _SCALES if s >= wanted]
    tries += [("A3", s, more) for s in _SCALES if s <= wanted for more in (True, False)]
    failed: RoomError | None = None
    set_out: dict[float, list[Block]] = {}
    for size, scale, more in tries:
        try:
            if scale not in set_out:
                set_out[scale] = [block_of(v, _own(v, scale), features, controlled, cuts_in(v, views)) for v in views]
        except RoomError as error:
            failed = error
            continue
        sheets = _sheets(set_out[scale], features, size, scale, titles, notes, more)
        if sheets is not None:
            return sheets
    raise failed or LayoutError(f"{titles.number} fits on no sheet")


def _own(view: View, scale: float) -> float:
    """The scale of a view: a picture is drawn smaller, a view once more, turned, by one step."""
    if view.slot == "turned" and scale > _SCALES[-1]:
        return _SCALES[_SCALES.index(scale) + 1]
    return scale * 0.6 if view.slot == "picture" else scale


def _sheets(
    blocks: Sequence[Block],
    features: Features,
    size: str,
    scale: float,
    titles: Titles,
    notes: Sequence[tuple[str, str]],
    more: bool,
) -> list[Sheet] | None:
    """The sheets at a size and a scale; None if they cannot be filled so."""
    area, taken = inner(size), [title_box(size)]
    room = (area[0] + 3.0, area[1] + 3.0, area[2] - 3.0, area[3] - 3.0)
    main = _adjacent(blocks)
    boxes = [(block.box, at) for block, at in main]
    start = _find(lambda at: [_shifted(box, (at[0] + x, at[1] + y)) for box, (x, y) in boxes], taken, room)
    if start is None:
        return None
    placed = [_Placed(block.items, (x + start[0], y + start[1])) for block, (x, y) in main]
    rest: list[list[Item]] = [b.items for b in blocks if b.view.slot == "turned"]
    if any(block.tables for block in blocks):
        rest.append(hole_table(blocks, features))
    if notes:
        rest.append(notes_items(notes, _NOTES_MM))
    pages: list[list[_Placed]] = [placed]
    later: list[list[Item]] = []
    for items in rest:
        if not _add(items, pages[0], taken, room):
            later.append(items)
    if later and not more:
        return None
    while later:
        pages.append([])
        left = [items for items in later if not _add(items, pages[-1], taken, room)]
        if len(left) == len(later):
            return None
        later = left
    for block in blocks:
        if block.view.slot == "picture":
            any(_add(block.items, page, taken, room) for page in pages)
    count = len(pages)
    shown = ratio(scale)
    turned = {ratio(_own(block.view, scale)) for block in blocks if block.view.slot == "turned"} - {shown}
    shown += "".join(f" ({own})" for own in turned)
    sheets = []
    for n, page in enumerate(pages, 1):
        sheet = framed(size, shown, f"{n} / {count}", titles)
        for k, one in enumerate(page):
            sheet.add(moved(item, one.at) for item in one.items)
            sheet.frames[f"block {k}"] = one.box
        sheets.append(sheet)
    return sheets


def ratio(scale: float) -> str:
    """Writes a scale."""
    return f"{scale:g}:1" if scale >= 1.0 else f"1:{1.0 / scale:g}"


def _adjacent(blocks: Sequence[Block]) -> list[tuple[Block, Point]]:
    """The main view at (0, 0) and the views beside it, each in line with it."""
    front = blocks[0]
    found = [(front, (0.0, 0.0))]
    for block in blocks[1:]:
        (x0, y0, x1, y1), (a0, b0, a1, b1) = front.box, block.box
        at = {
            "right": (x1 + _APART_MM - a0, 0.0),
            "left": (x0 - _APART_MM - a1, 0.0),
            "below": (0.0, y0 - _APART_MM - b1),
            "above": (0.0, y1 + _APART_MM - b0),
        }.get(block.view.slot)
        if at is not None:
            found.append((block, at))
    return found


def _shifted(box: Box, by: Point) -> Box:
    return box[0] + by[0], box[1] + by[1], box[2] + by[0], box[3] + by[1]


def _add(items: list[Item], page: list[_Placed], taken: Sequence[Box], room: Box) -> bool:
    """Puts items on a page where they are free; tells whether there was such a place."""
    box = box_of(items)
    others = [*taken, *(one.box for one in page)]
    at = _find(lambda at: [_shifted(box, at)], others, room)
    if at is not None:
        page.append(_Placed(items, at))
    return at is not None


def _find(boxes: Callable[[Point], list[Box]], taken: Sequence[Box], room: Box) -> Point | None:
    """The first place, from the top down and from the left, at which boxes lie in a room and off what is taken."""
    own = boxes((0.0, 0.0))
    low = [min(box[k] for box in own) for k in (0, 1)]
    high = [max(box[k] for box in own) for k in (2, 3)]
    wide, tall = high[0] - low[0], high[1] - low[1]
    across, down = int((room[2] - room[0] - wide) // _STEP_MM), int((room[3] - room[1] - tall) // _STEP_MM)
    if room[2] - room[0] < wide or room[3] - room[1] < tall:
        return None
    for j in range(down + 1):
        for i in range(across + 1):
            at = room[0] - low[0] + i * _STEP_MM, room[3] - high[1] - j * _STEP_MM
            if not any(overlap(a, b, _APART_MM / 2) for a in boxes(at) for b in taken):
                return at
    return None
