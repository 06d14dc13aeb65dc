"""Largest walls: searches on known predicates, ranges over cases, and the simulated limit beside the linear one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from haptics.loop.assumptions import DELAY, default_estimator, joint_friction, nominal_plant
from haptics.loop.discrete import Timing, linear_model
from haptics.loop.linear import linearise
from haptics.loop.page import stiffness_facts, stiffness_text
from haptics.loop.passivity import PassivityClass
from haptics.loop.stiffness import (
    CEILING,
    FLOOR,
    NOMINAL_TOLERANCE,
    PLACES,
    RIVAL,
    TOLERANCE,
    Corner,
    End,
    Stiffness,
    WallLoop,
    edge,
    largest_walls,
    linear_limits,
    simulated_range,
)
from haptics.loop.wall_trial import WallBench
from haptics.loop.walls import START, STEP, Predicate
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand
from haptics.rendering.laws.virtual_wall import AXES

T = 1e-3
DELAYS = (0.0, 0.5e-3, 1e-3)
SOME = Corner("medium", "nominal", 0.5e-3)


@pytest.fixture(scope="module")
def simulated(machine: MachineModel) -> Stiffness:
    return largest_walls(machine)


def below(limit: float) -> Predicate:
    return lambda stiffness: stiffness <= limit


@pytest.mark.parametrize("limit", [60.0, 800.0, 7000.0, 49e3])
@pytest.mark.parametrize("guess", [1.0, 500.0, 8000.0, 1e6])
def test_an_edge_is_found_from_any_guess(limit: float, guess: float) -> None:
    required: list[float] = []

    def stands(stiffness: float) -> bool:
        required.append(stiffness)
        return stiffness <= limit

    found = edge(stands, End(guess, SOME))
    assert limit / (1.0 + TOLERANCE) <= found.stiffness <= limit
    assert not found.open
    assert found.corner == SOME
    assert FLOOR <= min(required) <= max(required) <= CEILING
    assert len(required) == len(set(required)) <= 24  # 17 strides of 1.5 from end to end, 4 halvings and the first


def test_edges_beyond_what_is_required() -> None:
    assert edge(below(0.9 * FLOOR), End(3000.0, SOME)).stiffness == 0.0
    beyond = edge(below(2.0 * CEILING), End(3000.0, SOME))
    assert (beyond.stiffness, beyond.open) == (CEILING, True)
    assert edge(below(CEILING), End(1e9, SOME)).open


LINEAR = [
    End(500.0, Corner("light", "least", T)),
    End(900.0, Corner("light", "largest", T)),
    End(1400.0, Corner("light", "largest", 0.0)),
    End(9000.0, Corner("medium", "largest", 0.0)),
    End(20e3, Corner("firm", "least", 0.0)),
    End(30e3, Corner("firm", "largest", 0.0)),
]


@pytest.mark.parametrize("lowest", [0, 1, 2])
@pytest.mark.parametrize("highest", [4, 5])
def test_a_range_ends_at_its_extreme_cases_whoever_they_are(lowest: int, highest: int) -> None:
    limits = {end.corner: 1000.0 for end in LINEAR} | {end.corner: 10e3 for end in LINEAR[3:]}
    limits[LINEAR[lowest].corner], limits[LINEAR[highest].corner] = 300.0, 45e3
    found = simulated_range(LINEAR, lambda corner: below(limits[corner]))
    assert found.lowest.corner == LINEAR[lowest].corner
    assert found.highest.corner == LINEAR[highest].corner
    assert found.lowest.stiffness == pytest.approx(300.0 / (1.0 + TOLERANCE / 2.0), rel=TOLERANCE / 2.0 + 1e-9)
    assert found.highest.stiffness == pytest.approx(45e3 / (1.0 + TOLERANCE / 2.0), rel=TOLERANCE / 2.0 + 1e-9)


def test_cases_far_from_an_end_are_not_simulated() -> None:
    required: set[Corner] = set()

    def case(corner: Corner) -> Predicate:
        required.add(corner)
        return below(2000.0)

    simulated_range(LINEAR, case)
    assert LINEAR[3].corner not in required  # 18 times the lowest, less than a third of the highest
    assert required == {end.corner for end in LINEAR if end.stiffness <= RIVAL * 500.0 or end.stiffness * RIVAL >= 30e3}


def test_the_protocol_and_the_bisection_find_a_known_limit(machine: MachineModel) -> None:
    found = largest_walls(machine, axes=("y",), ask=lambda _axis, _case, _seed: below(4300.0))
    (wall,) = found.axes
    assert wall.axis == "y"
    assert wall.nominal.protocol == 4300.0
    assert 4300.0 <= wall.nominal.bisection <= 4300.0 + NOMINAL_TOLERANCE
    assert wall.corner == Corner("medium", "nominal", DELAY[1] * T)
    assert wall.published == 5100.0
    assert wall.steady == dict.fromkeys(HANDS, True)
    assert found.unstable_cases == []
    assert wall.trials >= (4300.0 - START) / STEP


def test_a_hand_that_shakes_the_default_wall_is_named(machine: MachineModel) -> None:
    def ask(axis: str, case: Corner, _seed: int) -> Predicate:
        return below(1000.0 if (axis, case.hand) == ("z", "light") else 4300.0)

    found = largest_walls(machine, axes=("x", "z"), ask=ask)
    assert found.unstable_cases == [("z", "light")]
    assert stiffness_text("device", found).count("OSCILLATES") == 1


def test_one_place_of_the_counts_is_enough_to_shake_it(machine: MachineModel) -> None:
    def ask(_axis: str, case: Corner, seed: int) -> Predicate:
        return below(1000.0 if (case.hand, seed) == ("firm", PLACES - 1) else 4300.0)

    assert largest_walls(machine, axes=("y",), ask=ask).unstable_cases == [("y", "firm")]


def test_a_nominal_wall_that_never_stands(machine: MachineModel) -> None:
    found = largest_walls(machine, axes=("x",), ask=lambda _axis, _case, _seed: lambda _stiffness: False)
    (wall,) = found.axes
    assert wall.nominal.protocol is None
    assert wall.simulated.lowest.stiffness == wall.simulated.highest.stiffness == 0.0
    assert stiffness_facts("device", found)["axes"]["x"]["simulated_N_per_mm"]["protocol"] is None


def test_walls_that_always_stand_are_lower_bounds(machine: MachineModel) -> None:
    found = largest_walls(machine, axes=("x",), ask=lambda _axis, _case, _seed: lambda _stiffness: True)
    assert found.axes[0].simulated.highest.open
    assert "or more" in stiffness_text("device", found)
    assert stiffness_facts("device", found)["axes"]["x"]["simulated_N_per_mm"]["lowest"]["or_more"]


def test_linear_limits_are_those_of_each_case(machine: MachineModel) -> None:
    estimator = linear_model(default_estimator(T))
    ends = linear_limits(WallLoop(machine, 0.0, T, DELAYS, estimator, HANDS), "z")
    assert [end.stiffness for end in ends] == sorted(end.stiffness for end in ends)
    assert {end.corner for end in ends} == {Corner(*case) for case in product(HANDS, ("least", "largest"), (0.0, T))}
    viscous = dict(zip(("least", "nominal", "largest"), joint_friction(machine).viscous, strict=True))
    for end in ends[:2]:
        par = nominal_plant(machine)._replace(viscous=viscous[end.corner.friction])
        here = linearise(par, machine.centre)
        timing = Timing(T, end.corner.delay, par.current_lag)
        loop = here.joint_loop(AXES["z"], HANDS[end.corner.hand], timing, estimator)
        assert loop.radius(0.999 * end.stiffness, 0.0) < 1.0 < loop.radius(1.001 * end.stiffness, 0.0)
    medium = {"medium": HANDS["medium"]}
    (one,) = linear_limits(WallLoop(machine, 0.0, T, DELAYS, estimator, medium), "z", ("nominal",))
    assert one.corner == SOME


@pytest.mark.slow
def test_the_simulation_of_best(simulated: Stiffness) -> None:
    """No figure of the paper is in it: order must hold, and nearness to the linear model where friction is small."""
    for wall in simulated.axes:
        assert wall.nominal.protocol is not None
        assert wall.nominal.protocol <= wall.nominal.bisection <= wall.nominal.protocol + STEP
        low, high = wall.simulated.lowest, wall.simulated.highest
        assert low.stiffness < wall.nominal.bisection < high.stiffness
        assert low.corner.hand == "firm"  # whose grasp damps least; the upper end is friction's, whoever holds it
        assert (low.corner.delay, high.corner.delay) == (T, 0.0)
        # what counts and the criterion take off is below a third; friction that sticks can only help
        assert wall.nominal.bisection > 0.67 * wall.linear_nominal
        assert wall.linear.lowest.stiffness < wall.linear_nominal < wall.linear.highest.stiffness
        assert wall.default_verdict.kind is not PassivityClass.PASSIVE  # K T / 2 alone is 15 times the viscous friction
        assert wall.limit_verdict is not None
        assert wall.limit_verdict.demand.friction > wall.default_verdict.demand.friction


def test_later_torques_and_grasps_that_damp_less_bear_less(machine: MachineModel) -> None:
    """With the least friction, where the simulation comes near the linear model."""
    for hand, delay in (("medium", 2e-3), ("light", 0.5e-3), ("firm", 0.5e-3)):
        stands = WallBench(machine, "x", HANDS[hand], "least", delay, substeps=4).stands
        assert not stands(1500.0)
    usual = WallBench(machine, "x", HANDS["medium"], "least", 0.5e-3, substeps=4).stands
    assert usual(1500.0)
    assert not usual(4500.0)  # a third more than the linear limit of 3.43 N/mm


def test_what_is_requested_reaches_the_loop(machine: MachineModel) -> None:
    """Period, delay and damping: the linear limits move as the theory of a sampled spring has it."""

    def nominal(**given: Any) -> float:
        return largest_walls(machine, axes=("x",), ask=lambda *_: below(1.0), **given).axes[0].linear_nominal

    usual = nominal()
    assert nominal(period=0.5e-3) > 1.5 * usual  # T / 2 and the delay halve, the motors' lag does not
    assert nominal(delay=0.0) > usual > nominal(delay=1e-3)
    found = largest_walls(machine, axes=("x",), ask=lambda *_: below(1.0), damping=1e4)
    assert found.cap.applied(found.damping) == found.cap.cap < 1e4
    capped = stiffness_facts("device", found)
    assert capped["damping_asked_N_s_per_m"] == 1e4
    assert capped["damping_applied_N_s_per_m"] == found.cap.cap
    assert nominal(damping=10.0) > usual


@pytest.mark.slow
def test_facts_and_text_tell_the_same(simulated: Stiffness) -> None:
    facts, text = stiffness_facts("device", simulated), stiffness_text("device", simulated)
    for axis, paper in (("x", 4.9), ("y", 5.1), ("z", 4.5)):
        found = facts["axes"][axis]
        assert found["published_N_per_mm"] == pytest.approx(paper)
        row = next(line for line in text.splitlines() if line.startswith(f"{axis}  "))
        assert f"{paper:7.1f}{found['simulated_N_per_mm']['protocol']:11.1f}" in row
        assert f"{found['linear_N_per_mm']['nominal']:9.2f}" in row
        required = found["simulated_N_per_mm"]["asked"]
        assert required[0] == [pytest.approx(1.1), True]
        assert np.diff([stiffness for stiffness, _ in required[:5]]) == pytest.approx([0.2] * 4)
    lowest = [axis["simulated_N_per_mm"]["lowest"] for axis in facts["axes"].values()]
    assert {(end["hand"], end["friction"], end["delay_ms"]) for end in lowest} == {("firm", "least", 1.0)}
    assert max(map(len, text.splitlines())) <= 120
    assert facts["axes"]["x"]["passivity"]["default_wall"]["verdict"] in set(PassivityClass)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"damping": -1.0}, "damping is"),
        ({"damping": float("nan")}, "damping is"),
        ({"period": 0.0}, "period"),
        ({"delay": -1e-3}, "delay"),
        ({"hands": {}}, "hands"),
    ],
)
def test_what_cannot_be_is_refused(machine: MachineModel, given: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        largest_walls(machine, ask=lambda *_: below(1.0), **given)


def test_a_set_without_the_nominal_hand_takes_its_first(machine: MachineModel) -> None:
    hands = {"one": Hand(0.1, 5.0, 300.0)}
    ask: Callable[[str, Corner, int], Predicate] = lambda _axis, _case, _seed: below(2000.0)  # noqa: E731
    (wall,) = largest_walls(machine, axes=("x",), hands=hands, ask=ask).axes
    assert wall.corner.hand == "one"
    assert replace(wall.corner, hand="medium") == SOME
