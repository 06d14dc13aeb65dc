"""Views of solids whose edges are known in closed form."""

from __future__ import annotations

from itertools import pairwise
from math import hypot, inf, pi

import cadquery as cq
import pytest

from delta_cad.export.drawings.sheet_io.sheet import Arc, Item, Stroke, box_of
from delta_cad.export.drawings.views.projection import (
    HATCH_MM,
    Frame,
    cut_open,
    hatched,
    merged,
    projected,
    seen_of,
)

ABOVE, FRONT = Frame((1, 0, 0), (0, 1, 0)), Frame((1, 0, 0), (0, 0, 1))
NEAR_MM = 1e-3


def bored() -> cq.Solid:
    """A block 30 x 20 x 10 with a blind bore of 6, 7 deep, in the middle of its upper face."""
    block = cq.Workplane().box(30, 20, 10).faces(">Z").workplane().hole(6.0, 7.0)
    (solid,) = block.val().Solids()  # type: ignore[union-attr]
    return solid


def length(items: list[Item], layer: str) -> float:
    total = 0.0
    for item in items:
        if isinstance(item, Arc) and item.layer == layer:
            total += item.radius * (item.end - item.start) * pi / 180.0
        elif isinstance(item, Stroke) and item.layer == layer:
            points = item.points
            total += sum(hypot(b[0] - a[0], b[1] - a[1]) for a, b in pairwise(points))
    return total


def test_a_bore_is_a_circle_from_above_and_hidden_from_the_front() -> None:
    above, front = projected([bored().wrapped], ABOVE), projected([bored().wrapped], FRONT)
    assert box_of(above) == pytest.approx((-15, -10, 15, 10), abs=NEAR_MM)
    (circle,) = [item for item in above if isinstance(item, Arc)]
    assert (circle.layer, circle.radius, circle.whole) == ("visible", pytest.approx(3.0), True)
    assert length(above, "visible") == pytest.approx(2 * (30 + 20) + 6 * pi, abs=0.01)
    assert length(above, "hidden") == pytest.approx(0.0, abs=0.01)  # the floor lies on the rim
    assert length(front, "visible") == pytest.approx(2 * (30 + 10), abs=0.01)
    assert length(front, "hidden") == pytest.approx(7 + 7 + 6, abs=0.01)  # both walls and the floor


def test_a_cut_shows_the_bore_and_hatches_what_is_cut() -> None:
    rest, rings = cut_open(bored(), FRONT, [(inf, 0.0)])
    items = projected([rest.wrapped], FRONT, hidden=False)
    assert length(items, "hidden") == 0.0
    # the outline, open over the bore, walls and floor; the bore's rim behind the cut is seen edge on
    assert length(items, "visible") == pytest.approx(2 * (30 + 10) + 7 + 7 + 6, abs=0.01)
    area = 30 * 10 - 6 * 7
    assert HATCH_MM * length(list(hatched(rings)), "hatch") == pytest.approx(area, rel=0.03)
    assert 0.2 * length(list(hatched(rings, 0.2)), "hatch") == pytest.approx(area, rel=0.003)


def test_hatching_leaves_holes_out() -> None:
    square = [(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    hole = [(2.0, 2.0), (8.0, 2.0), (8.0, 8.0), (2.0, 8.0)]
    for stroke in hatched([square, hole], 0.7):
        for x, y in stroke.points:
            assert not (2.01 < x < 7.99 and 2.01 < y < 7.99)
    assert 0.05 * length(list(hatched([square, hole], 0.05)), "hatch") == pytest.approx(64.0, rel=0.01)
    assert list(hatched([])) == []


def test_what_lies_on_one_another_is_drawn_once_and_what_is_seen_is_not_hidden() -> None:
    seen: list[Item] = [Stroke("visible", ((0, 0), (4, 0))), Stroke("visible", ((6, 0), (3, 0)))]
    behind: list[Item] = [Stroke("visible", ((-1, 0), (9, 0))), Arc("visible", (0, 0), 2, 300, 420)]
    behind.append(Arc("visible", (0, 0), 2, 30, 90))
    found = merged(seen, behind)
    spans = sorted((i.layer, *sorted(p[0] for p in i.points)) for i in found if isinstance(i, Stroke))
    assert spans == [("hidden", -1, 0), ("hidden", 6, 9), ("visible", 0, 6)]
    (arc,) = [item for item in found if isinstance(item, Arc)]
    assert (arc.layer, arc.start, arc.end) == ("hidden", 300, 450)


def test_a_shape_behind_another_is_not_seen() -> None:
    low = cq.Solid.makeBox(10, 10, 10)
    high = cq.Solid.makeBox(20, 20, 5, pnt=cq.Vector(-5, -5, 20))
    seen = seen_of([low.wrapped, high.wrapped], ABOVE)
    assert [mark[0] for mark in seen.marks] == [0.0, pytest.approx(20.0)]
    assert seen_of([low.wrapped, high.wrapped], FRONT).marks[0][0] == pytest.approx(10.0)
