"""A view with its annotations, arranged without overlap as one block for the sheet."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.holes import HoleGroup
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.lettering import width_of
from delta_cad.export.drawings.sheet_io.sheet import Box, Item, Point, Stroke, Text, box_of, scaled
from delta_cad.export.drawings.views.annotate import Annotator, Tagged
from delta_cad.export.drawings.views.choice import View
from delta_cad.export.drawings.views.lines import boxed
from delta_cad.export.drawings.views.marks import arrow, free_text
from delta_cad.export.drawings.views.projection import hatched

_TITLE_MM = 3.5
_MANY = 8  # bores of a view from which on they get tags and a table
_CUT_MM = 6.0  # by which the line of a cut goes beyond the view


@dataclass
class Block:
    """A view as it comes on a sheet, around the point (0, 0) of its frame; `drawn` is the part's box in it."""

    view: View
    items: list[Item]
    drawn: Box
    tables: list[tuple[HoleGroup, list[Tagged]]] = field(default_factory=list)

    @property
    def box(self) -> Box:
        """What it covers, mm."""
        return box_of(self.items)


@dataclass(frozen=True)
class _Cut:
    """Where another view cuts a view open: across its axis 0 or 1, at what, mm, looking which way, by what name."""

    axis: int
    at: float
    sense: float
    letter: str


def cuts_in(view: View, others: Sequence[View]) -> list[_Cut]:
    """Finds where other views are cut through what a view shows."""
    found = []
    for other in others:
        if other is view or other.cut is None:
            continue
        for k, axis in enumerate(view.frame.axes):
            along = float(other.towards @ axis)
            if abs(along) > 1.0 - 1e-6:
                found.append(_Cut(k, along * other.cut, -along, other.title[:1]))
    return found


def block_of(view: View, scale: float, features: Features, controlled: Controlled, cuts: Sequence[_Cut] = ()) -> Block:
    """Sets out a view at a scale.

    Raises:
        RoomError: A tag has no place.
    """
    items = [scaled(item, scale) for item in view.items]
    drawn = box_of(items)
    rings = [[(x * scale, y * scale) for x, y in ring] for ring in view.rings]
    items = [*hatched(rings), *items]
    block = Block(view, items, drawn)
    if view.slot == "picture":
        return block
    setting = Annotator(view, scale, features, drawn, _with_room(drawn, cuts), controlled)
    block.items += setting.centre_lines()
    tagged = [g for g in view.groups if all(view.end_on(b) for b in g.bores)]
    count = sum(len(g.bores) for g in tagged)
    tagged = tagged if count > _MANY else []
    reported = {key for g in tagged for key in setting.keys(g)}
    block.items += setting.ordinates([p for p in view.places if not any(p.key.startswith(f"{k} ") for k in reported)])
    block.items += setting.callouts([g for g in view.groups if g not in tagged])
    if view.title:
        at = (drawn[0] + drawn[2]) / 2 - width_of(view.title, _TITLE_MM) / 2
        block.items += _title(view, features, (at, box_of(block.items)[3] + 2.5))
    for cut in cuts:
        block.items += _cut_line(cut, scale, drawn, block.items)
    for letter, group in zip("ABCDEFGHJKLMNPQRSTUVWXYZ", tagged, strict=False):
        block.tables.append((group, setting.tag(letter, group, block.items)))
    return block


def _title(view: View, features: Features, at: Point) -> list[Item]:
    """The title of a view; where something exact is told in it that is turned, its angle is exact, too."""
    if view.slot != "turned" or not any(place.key in features.exact for place in view.places):
        return [Text(at, _TITLE_MM, view.title)]
    before, angle, after = re.split(r" (\S+°) ", view.title)
    texts = [Text(at, _TITLE_MM, before)]
    for part in (angle, after):
        texts.append(Text((texts[-1].end[0] + _TITLE_MM, at[1]), _TITLE_MM, part))
    return [*texts, boxed(texts[1])]


def _with_room(drawn: Box, cuts: Sequence[_Cut]) -> Box:
    """The box of a view with room for the ends of the lines along which it is cut."""
    aside, over = (_CUT_MM * any(cut.axis == k for cut in cuts) for k in (1, 0))
    return drawn[0] - aside, drawn[1] - over, drawn[2] + aside, drawn[3] + over


def _cut_line(cut: _Cut, scale: float, drawn: Box, items: Sequence[Item]) -> list[Item]:
    """The line along which a view is cut, with arrows the way that is looked and its letter at both ends."""
    k, at = cut.axis, cut.at * scale
    low, high = drawn[1 - k] - _CUT_MM, drawn[3 - k] + _CUT_MM

    def point(along: float, across: float) -> Point:
        return (across, along) if k == 0 else (along, across)

    found: list[Item] = [Stroke("centre", (point(low, at), point(high, at)))]
    for end, inner in ((low, low + 3.0), (high, high - 3.0)):
        tip = point(end, at + cut.sense * 5.0)
        found += [
            Stroke("cut", (point(end, at), point(inner, at))),
            arrow(tip, point(end, at)),  # before its line: behind it, it would be the head of a leader
            Stroke("dimension", (point(end, at), tip)),
        ]
    for end in (low, high):
        adjacent = point(end, at + cut.sense * 2.5)
        found.append(free_text(cut.letter, adjacent, 0.0, [*items, *found], _TITLE_MM))
    return found
