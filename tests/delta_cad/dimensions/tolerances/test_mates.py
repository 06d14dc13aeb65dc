"""Patterns of pins and screws against random machines whose parts are pushed together as well as they go.

The oracle knows no formula of the chain: holes are put anywhere in their zones, and a linear programme looks for the
shift and the turn of one part with which every pin goes in, and for the play that is then left.
"""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi

import numpy as np
import pytest
from scipy.optimize import linprog

from delta_cad.dimensions.tolerances.mates import Locators, Place, clearances_mm, pair, screw_zone_mm

MACHINES = 300
WAYS = 2.0 * pi * np.arange(64) / 64
SCREWS = ((45.0, 3.0), (15.0, -2.0), (20.0, 30.0))


def left_mm(off: dict[str, np.ndarray], located: Locators | None, places: list[Place]) -> float:
    """Largest play that any shift and turn of a part leaves at the worst of its places, mm; -inf: it does not go on.

    Args:
        off: By place, (2,) by how much its two holes are apart.
        located: Its locators, of which the first has no play and the slot none across it.
        places: The other places, and the slot.
    """
    goal = [0.0, 0.0, 0.0, -1.0]  # shift x, shift y, turn, play
    rows, most, equal, to = list[list[float]](), list[float](), list[list[float]](), list[float]()

    def moved(place: Place, way: np.ndarray) -> list[float]:
        (x, y), (u, v) = place.at_mm, way
        return [float(u), float(v), float(-u * y + v * x)]

    if located is not None:
        for way in np.eye(2):
            equal.append([*moved(located.first, way), 0.0])
            to.append(float(way @ off[located.first.name]))
        if (slot := located.slot) is not None and slot.along is not None:
            way = np.array([-slot.along[1], slot.along[0]])
            equal.append([*moved(slot, way), 0.0])
            to.append(float(way @ off[slot.name]))
    for place in places:
        ways = np.column_stack([np.cos(WAYS), np.sin(WAYS)])
        play = place.play_mm * np.cos(pi / len(WAYS))  # a polygon in the circle
        if place.along is not None:
            ways, play = np.array([place.along, np.negative(place.along)]), place.slack_mm
        for way in ways:
            rows.append([*np.negative(moved(place, way)), 1.0])
            most.append(float(play - way @ off[place.name]))
    free = [(None, None)] * 4
    found = linprog(goal, rows, most, equal or None, to or None, bounds=free)
    return float(found.x[3]) if found.success else -np.inf


def drawn(random: np.random.Generator, places: list[Place]) -> dict[str, np.ndarray]:
    """Both holes of every place anywhere on the rim of their zones, where the worst machines are."""
    angles = random.uniform(0.0, 2.0 * pi, len(places))
    return {
        place.name: place.off_mm * np.array([np.cos(angle), np.sin(angle)])
        for place, angle in zip(places, angles, strict=True)
    }


def pattern(screw_off: float, pins_off: float) -> tuple[Locators, list[Place]]:
    """Two pins 30 mm apart along a slanting line, the second in a slot, and three screws M4 in holes of 4.5."""
    located = pair((10.0, 5.0), (10.0 + 24.0, 5.0 + 18.0), pins_off)
    assert located.slot is not None
    located = replace(located, slot=replace(located.slot, slack_mm=0.196))
    screws = [Place(f"screw {k}", at, screw_off, play_mm=0.25) for k, at in enumerate(SCREWS)]
    return located, [located.slot, *screws]  # type: ignore[list-item]


@pytest.mark.parametrize("pins_off", [0.0, 0.025, 0.05])
def test_no_machine_is_worse_than_the_worst_case_and_some_come_near(pins_off: float) -> None:
    located, places = pattern(0.06, pins_off)
    worst = min(clearances_mm(place, located)[0] for place in places)
    random = np.random.default_rng(3)
    every = [located.first, *places]
    left = [left_mm(drawn(random, every), located, places) for _ in range(MACHINES)]
    assert min(left) >= worst - 1e-3  # of the polygon
    assert min(left) <= worst + 0.35 * (0.19 - worst)


def worst_offsets(located: Locators, place: Place) -> dict[str, np.ndarray]:
    """Holes of a machine that is at the limits for one screw: found by trying every direction."""
    most, found = -1.0, dict[str, np.ndarray]()
    for way in np.column_stack([np.cos(WAYS), np.sin(WAYS)]):
        first, slot = (rows[0] for rows in located.coefficients(place.at_mm, way[None]))
        reached = located.first.off_mm * hypot(*first) + located.slot.off_mm * hypot(*slot)  # type: ignore[union-attr]
        if reached > most:
            most = reached
            found = {
                place.name: place.off_mm * way,
                located.first.name: -located.first.off_mm * first / hypot(*first),
                located.slot.name: -located.slot.off_mm * slot / max(hypot(*slot), 1e-12),  # type: ignore[union-attr]
            }
    return found


@pytest.mark.parametrize(("screw_off", "goes_in"), [(0.06, True), (0.16, False)])
def test_a_machine_at_its_limits_goes_together_where_the_worst_case_says_so(screw_off: float, goes_in: bool) -> None:
    located, places = pattern(screw_off, 0.05)
    screw = min(places[1:], key=lambda place: clearances_mm(place, located)[0])
    assert (clearances_mm(screw, located)[0] > 0.0) is goes_in
    alone = [screw]
    left = left_mm(worst_offsets(located, screw), located, alone)
    assert left == pytest.approx(clearances_mm(screw, located)[0], abs=2e-3)
    assert (left > 0.0) is goes_in


def test_two_pins_in_round_holes_go_in_by_chance_alone() -> None:
    located, places = pattern(0.0, 0.05)
    assert located.slot is not None
    second = replace(located.slot, along=None, slack_mm=0.0)
    alone = Locators(located.first)
    assert clearances_mm(second, alone)[0] == pytest.approx(-0.1)
    random = np.random.default_rng(4)
    left = [left_mm(drawn(random, [located.first, second]), alone, [second]) for _ in range(MACHINES)]
    assert np.mean(np.array(left) < -0.005) > 0.8
    slotted = [left_mm(drawn(random, [located.first, *places]), located, places[:1]) for _ in range(MACHINES)]
    assert min(slotted) > 0.0


def test_a_slot_across_the_line_of_its_pins_holds_no_turn() -> None:
    located, places = pattern(0.0, 0.05)
    assert located.slot is not None
    across = replace(located, slot=replace(located.slot, along=(-0.6, 0.8)))
    with pytest.raises(ValueError, match="does not hold the turn"):
        clearances_mm(places[1], across)


@pytest.mark.parametrize("count", [2, 4])
def test_screws_alone_bear_the_zones_of_the_formula_of_fixed_fasteners(count: int) -> None:
    """ASME Y14.5 B.4: H = F + T1 + T2. Screws shifted outwards by both zones just go in."""
    places = [Place(f"{k}", (20.0 * k, 0.0), 0.2, play_mm=0.2) for k in range(count)]
    assert clearances_mm(places[0], None) == pytest.approx((0.0, 0.0))
    outwards = {place.name: np.array([0.2 if k else -0.2, 0.0]) for k, place in enumerate(places)}
    assert left_mm(outwards, None, places) == pytest.approx(0.0, abs=1e-3)
    wider = {name: 1.1 * off for name, off in outwards.items()}
    assert left_mm(wider, None, places) < -0.01


def test_zones_of_screws_leave_some_play() -> None:
    assert screw_zone_mm(4.5, 4.0, 0.05) == 0.15  # 0.2 would leave none
    assert screw_zone_mm(3.4, 3.0, 0.025, 0.2) == 0.1
    assert screw_zone_mm(2.6, 2.5, 0.0, 0.1) == 0.05  # no zone at all: the check tells
    assert screw_zone_mm(3.4, 3.0) == 0.15
    with_play = Place("", (0.0, 0.0), (0.15 + 0.15) / 2.0, play_mm=0.2)
    assert clearances_mm(with_play, None)[0] > 0.0
