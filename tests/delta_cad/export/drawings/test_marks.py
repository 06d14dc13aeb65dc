"""Texts that are spread, and texts that are put where there is room."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from delta_cad.export.drawings.sheet_io.lettering import width_of, wrapped
from delta_cad.export.drawings.sheet_io.sheet import Item, Point, Stroke, crosses, overlap
from delta_cad.export.drawings.views.leaders import Leader, crossings, in_turn, lines_cross, runs_along, untangled
from delta_cad.export.drawings.views.marks import RoomError, free_text, number, spread, spread_within
from tests.designs import UNTIMED


@UNTIMED
@given(st.lists(st.floats(-100, 100), min_size=1, max_size=12), st.floats(0.5, 20), st.floats(-50, 0))
def test_spread_between_two_ends_keeps_order_and_room_and_the_ends_where_all_have_room(
    wanted: list[float], pitch: float, low: float
) -> None:
    wanted.sort()
    high = low + pitch * (len(wanted) - 1) + 5.0
    within = np.array(spread_within(wanted, pitch, low, high))
    assert within.min() >= low - 1e-9
    assert within.max() <= high + 1e-9
    assert (np.diff(within) > pitch - 1e-9).all()
    assert spread_within(wanted, pitch, low, high - 6.0) == spread(wanted, [pitch] * len(wanted))
    free = spread(wanted, [pitch] * len(wanted))
    assert spread_within(wanted, pitch, min(free) - 1.0, max(free) + 1.0) == pytest.approx(free)


@UNTIMED
@given(st.lists(st.tuples(st.floats(-100, 100), st.floats(0.5, 20)), min_size=1, max_size=12))
def test_spread_keeps_order_and_room_and_moves_least(wishes: list[tuple[float, float]]) -> None:
    """The oracle: the same least squares, solved by projecting neighbour upon neighbour many times."""
    wishes.sort()
    wanted, sizes = (np.array(column) for column in zip(*wishes, strict=True))
    found = np.array(spread(wanted.tolist(), sizes.tolist()))
    gaps = np.diff(found) - (sizes[1:] + sizes[:-1]) / 2
    assert (gaps > -1e-9).all()
    offsets = np.concatenate([[0.0], np.cumsum((sizes[1:] + sizes[:-1]) / 2)])
    target, fitted = wanted - offsets, found - offsets
    # isotonic regression by its minimax form
    n = len(target)
    best = [max(min(target[i : j + 1].mean() for j in range(k, n)) for i in range(k + 1)) for k in range(n)]
    assert fitted == pytest.approx(np.array(best), abs=1e-6)


def test_widths_are_the_face_s_own() -> None:
    from PIL import ImageFont

    from delta_cad.export.drawings.sheet_io.lettering import NARROW, _file, em_mm

    text = "Ø8 H7 ±0.02 × 45° through"
    face = ImageFont.truetype(str(_file()), 1000)
    assert width_of(text, 2.5) == pytest.approx(face.getlength(text) / 1000 * em_mm(2.5) * NARROW, rel=0.01)
    assert em_mm(2.5) == pytest.approx(2.5 / 0.729, rel=1e-3)  # capitals of DejaVu Sans: 1493 of 2048


def test_lines_are_broken_between_words() -> None:
    text = "seat of the bearing from the side of the arm"
    lines = wrapped(text, 2.5, 30.0)
    assert " ".join(lines) == text
    assert all(width_of(line, 2.5) <= 30.0 for line in lines)
    assert all(width_of(f"{a} {b.split()[0]}", 2.5) > 30.0 for a, b in pairwise(lines))  # none is broken too early
    assert wrapped("unbreakableword", 2.5, 1.0) == ["unbreakableword"]


def test_numbers_are_short() -> None:
    assert [number(x) for x in (5.0, -0.00001, 48.5690001, 1e-3, 0.02)] == ["5", "0", "48.569", "0.001", "0.02"]


def test_a_tag_finds_room_next_to_lines_and_says_when_there_is_none() -> None:
    around: list[Item] = [Stroke("visible", ((-50, y), (50, y))) for y in (-3.0, 3.0)]
    tag = free_text("A1", (0.0, 0.0), 2.0, around)
    lines = np.array([list(stroke.points) for stroke in around if isinstance(stroke, Stroke)])
    assert not crosses(tag.box, lines)
    assert not overlap(tag.box, (-1.4, -1.4, 1.4, 1.4))  # the square inside its circle
    dense: list[Item] = [Stroke("visible", ((-50, y / 2), (50, y / 2))) for y in range(-90, 90)]
    with pytest.raises(RoomError, match="A1"):
        free_text("A1", (0.0, 0.0), 2.0, dense)


def test_leaders_are_put_in_an_order_in_which_they_do_not_cross() -> None:
    tips = [(0.0, 5.0), (0.0, 3.0)]  # the upper text would point at the lower place

    def leaders(order: Sequence[int], places: Sequence[float]) -> list[tuple[Point, ...]]:
        return [((10.0, y), tips[k]) for k, y in zip(order, spread(places, [4.0, 4.0]), strict=True)]

    order, places = untangled([3.0, 4.0], leaders, np.zeros((0, 2, 2)))
    assert order == [1, 0]
    one, other = (np.array(line) for line in leaders(order, places))
    assert not lines_cross(one, other)
    assert lines_cross(np.array([[10.0, 3.0], tips[0]]), np.array([[10.0, 4.0], tips[1]]))


def test_a_leader_gives_way_to_those_of_other_bands() -> None:
    above = [((4.0, 20.0), (4.0, 2.2))]

    def leaders(order: Sequence[int], places: Sequence[float]) -> list[tuple[Point, ...]]:
        return [((12.0, y), (10.0, y), (0.0, 0.0)) for _, y in zip(order, places, strict=True)]

    assert lines_cross(np.array(leaders([0], [8.0])[0][-2:]), np.array(above[0]))
    _, (place,) = untangled([8.0], leaders, np.zeros((0, 2, 2)), above)
    assert not lines_cross(np.array(leaders([0], [place])[0][-2:]), np.array(above[0]))


def test_leaders_are_disentangled_where_the_first_exchanges_do_not_do_it() -> None:
    tips = [(-26.0, 25.0), (-18.0, 23.0), (-29.0, 15.0)]
    above = [((-10.0, 60.0), (-10.0, 36.0)), ((-6.0, 60.0), (-6.0, 16.0))]

    def leaders(order: Sequence[int], places: Sequence[float]) -> list[tuple[Point, ...]]:
        levels = spread(places, [5.0] * len(tips))
        return [((0.0, y), (-3.0, y), tips[k]) for k, y in zip(order, levels, strict=True)]

    wanted = [y for _, y in tips]
    assert crossings([*leaders([2, 1, 0], sorted(wanted)), *above]) > 0
    assert crossings([*leaders(*untangled(wanted, leaders, np.zeros((0, 2, 2)), above)), *above]) == 0


def test_a_band_that_cannot_give_way_goes_first() -> None:
    level: Leader = ((10.0, 5.0), (0.0, 5.0))

    def adjacent(leaders: list[Leader]) -> str:
        leaders.append(level)
        return "beside"

    def over(leaders: list[Leader]) -> str:
        leaders.append(((-2.0, 9.0), (-2.0, 1.0)) if level in leaders else ((5.0, 9.0), (5.0, 1.0)))
        return "over"

    tried: list[int] = []

    def counted(leaders: list[Leader]) -> str:
        tried.append(len(leaders))
        return adjacent(leaders)

    assert in_turn([counted, over], [(1, 0), (0, 1)]) == ["beside", "over"]
    assert tried == [1, 0]  # after the other band, then before it
    assert in_turn([counted, over], [(0, 1), (1, 0)]) == ["beside", "over"]
    assert tried == [1, 0, 0]  # no second turn where the first will do
    assert crossings([level, ((5.0, 9.0), (5.0, 1.0))]) == 1


def test_a_leader_that_would_run_along_an_edge_comes_aslant() -> None:
    edges = np.array([[[-20.0, 2.0], [5.0, 2.0]]])

    def leaders(order: Sequence[int], places: Sequence[float]) -> list[tuple[Point, ...]]:
        return [((12.0, y), (10.0, y), (0.0, 2.0)) for _, y in zip(order, places, strict=True)]

    assert runs_along(np.array([[10.0, 2.0], [0.0, 2.0]]), edges)
    assert not runs_along(np.array([[10.0, 2.0], [3.0, 2.0]]), edges)  # no longer than its arrow's head
    _, (place,) = untangled([2.0], leaders, edges)
    assert place != 2.0
    assert not runs_along(np.array(leaders([0], [place])[0][-2:]), edges)
