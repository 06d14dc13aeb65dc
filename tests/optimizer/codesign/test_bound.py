"""The bound on all machines of a family, against machines of the family that are drawn at random."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from threading import current_thread
from typing import ClassVar, cast

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism.limits import Outline
from optimizer.codesign import bound
from optimizer.codesign.bound import GAP, Bound, Family, Interval, Kind, bounded
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection, motor_of
from optimizer.codesign.lengths import best_lengths, continuous_torque_N_m, to_requirements
from optimizer.codesign.run import Builder, Run
from optimizer.codesign.search_log import unmemoized
from optimizer.problem.brief import brief_from_dict
from optimizer.problem.evaluator import half_surface
from optimizer.problem.step import SIDE, step_problem
from optimizer.problem.variables import PER_SI, VARIABLES
from tests.optimizer.problem.figures_numpy import figures_numpy

MOTOR = "maxon-re30-310007"
BRIEF = brief_from_dict(
    {
        "name": "b",
        "requirements": {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0, "force_N": 3.0},
        "feel": {"kappa_max": 2.27, "effective_mass_max_kg": 0.4},
        "hardware": {"motor": MOTOR, "drive": "capstan"},
    }
)
KNOWN = Corrections(replace(reference(), own=True), least_mm={"base_radius": 31.0, "platform_radius": 24.0})
DESIGNS, GROUPS = 100_000, 50
INTERVALS = 16  # in which a bound comes to some 5 % above the machine


@cache
def machine(ratio: float) -> Candidate:
    """The best machine of one ratio, of parts as heavy as the reference's."""
    choice = Selection(MOTOR, "capstan", ratio, 50.0)
    found = best_lengths(BRIEF, choice, KNOWN)
    assert found is not None
    return Candidate(cast(Design, None), choice, found.lengths_mm, KNOWN, found.score)


def bound_of(one: Candidate) -> Bound:
    reported: list[str] = []
    family = Family(BRIEF, one, {(MOTOR, "capstan"): KNOWN})
    return bounded(family, one.side_mm, lambda: len(reported) >= INTERVALS, reported.append)


def as_large(bound_mm: float, share: float, near: Candidate) -> int:
    """How many of machines drawn at random, as heavy as the reference, have a cube of a share of a bound."""
    rng, able = np.random.default_rng(3), 0
    for group in range(GROUPS):
        close = group % 2 == 0
        ratio = float(
            np.clip(near.choice.ratio * rng.normal(1.0, 0.05), 3.0, 12.0) if close else rng.uniform(3.0, 12.0)
        )
        arm = float(near.lengths_mm[0] * rng.normal(1.0, 0.01) if close else rng.uniform(60.0, 110.0))
        choice = Selection(MOTOR, "capstan", ratio, 50.0)
        rotor = motor_of(BRIEF, MOTOR).rotor_inertia_kg_m2 * ratio**2
        weighed = replace(reference(), masses=replace(reference().masses, rotor_inertia=rotor), ratio=ratio)
        corrections = replace(KNOWN, mass_estimate=weighed)
        problem = step_problem(
            to_requirements(BRIEF, choice, corrections, weighed.inertia(arm, near.lengths_mm[1], ratio)), 2
        )
        assert problem.symmetric  # the family that the bound is of
        lower, upper = np.array(problem.lower), np.array(problem.upper)
        upper[:6] = np.minimum(upper[:6], [arm, 220.0, 80.0, 60.0, 200.0, 300.0])
        designs = rng.uniform(lower, upper, (DESIGNS // GROUPS, len(VARIABLES)))
        if close:
            width = 10.0 ** rng.uniform(-4.0, -1.0, (len(designs), 1))
            designs = np.clip(near.lengths_mm * (1.0 + width * rng.normal(size=designs.shape)), lower, upper)
        designs[:, 0] = arm
        designs[:, SIDE] = share * bound_mm / 2.0
        designs /= PER_SI
        designs = designs[np.min(list(problem.design_margins(designs).values()), axis=0) >= 0.0]
        for grid in (2, 5, 9):
            if len(designs):
                margins = problem.point_margins(figures_numpy(designs, half_surface(grid)))
                designs = designs[np.min(list(margins.values()), axis=0).min(axis=1) >= 0.0]
        able += len(designs)
    return able


@pytest.mark.slow
def test_none_of_a_hundred_thousand_machines_beats_the_bound() -> None:
    """A cube that is feasible contains every smaller one on its bottom: that of the bound is enough."""
    best = max((machine(ratio) for ratio in (4.2, 4.6, 5.0, 5.5)), key=lambda one: one.side_mm)
    found = bound_of(best)
    assert GAP <= found.gap < 0.1
    assert found.side_mm == pytest.approx(best.side_mm * (1.0 + found.gap))
    assert as_large(found.side_mm, 1.0, best) == 0
    assert as_large(best.side_mm, 0.99, best) > 10  # those that are drawn would show a bound that is too low


@pytest.mark.slow
def test_halves_of_an_interval_have_no_larger_bounds() -> None:
    one = machine(4.8)
    family = Family(BRIEF, one, {(MOTOR, "capstan"): KNOWN})
    whole = Interval(MOTOR, "capstan", (4.0, 6.0), (80.0, 100.0))
    values = [family.best_of(part, 60.0, 600.0, bool) for part in (whole, *whole.halves())]
    assert max(values[1:]) <= values[0]
    assert values[0] > one.side_mm
    assert family.best_of(whole, 400.0, 600.0, bool) == 400.0  # nothing is larger than what is given
    assert family.best_of(replace(whole, ratios=(4.0, 6.1)), 60.0, 85.0, bool) <= 85.0


def test_an_interval_is_halved_across_what_is_wider() -> None:
    wide = Interval("m", "capstan", (3.0, 12.0), (80.0, 100.0))
    low, high = wide.halves()
    assert (low.ratios, high.ratios) == ((3.0, 6.0), (6.0, 12.0))
    assert low.arms_mm == high.arms_mm == (80.0, 100.0)
    direct = Interval("m", "direct", (1.0, 1.0), (50.0, 200.0))
    assert [part.arms_mm for part in direct.halves()] == [(50.0, 100.0), (100.0, 200.0)]
    assert not direct.narrow
    assert replace(direct, arms_mm=(100.0, 100.15)).narrow


def test_an_interval_has_the_torque_of_the_widest_pinion_that_its_outline_leaves_room_for() -> None:
    """A sector takes half its radius of the base radius; with its arm that is within the outline, or it is none."""
    required = brief_from_dict({**BRIEF.model_dump(exclude_none=True), "name": "p"})
    task = required.requirements.model_copy(update={"peak_force_N": 8.0})
    required = required.model_copy(update={"requirements": task})
    pulled = replace(KNOWN, pull_N=20.0)
    family = Family(required, machine(4.8), {(MOTOR, "capstan"): pulled})
    part, rng, wide = Interval(MOTOR, "capstan", (4.5, 5.5), (88.0, 94.0)), np.random.default_rng(1), 0
    far = family._strongest(part)
    reach = Outline(270.0, 220.0, 50.0, family._overhead).reach_max_mm
    for _ in range(2000):
        ratio, arm, wider = rng.uniform(4.5, 5.5), rng.uniform(88.0, 94.0), rng.uniform(0.0, 3.0)
        one = Selection(MOTOR, "capstan", ratio, 50.0, wider_mm=wider)
        if one.base_radius_mm + arm > reach:
            continue
        wide += wider > 0.3
        assert continuous_torque_N_m(required, one, pulled) <= continuous_torque_N_m(required, far, pulled)
    assert wide > 50


def test_what_is_stopped_tells_what_is_proved() -> None:
    one = machine(4.8)
    family = Family(BRIEF, one, {(MOTOR, "capstan"): KNOWN})
    found = bounded(family, one.side_mm, lambda: True)
    assert math.isfinite(found.side_mm)
    assert found.side_mm > 2.0 * one.side_mm  # nothing was
    for words in (
        "three equal chains at 120 degrees, the cube on their axis",
        "parallelograms 50 mm wide",
        "a base radius of at least 31.00 mm",  # what was learnt
        "at least 9.8 and 13.3 mm of outline",  # of 10 and 13.5, less `SPARE_MM`
        "kappa of at most 2.27",
        f"driven by {MOTOR} with a capstan of 3:1 to 12:1",
        f"more than {found.side_mm:.2f} mm",
    ):
        assert words in found.statement


class Once(Family):
    """Bounds each interval once, whatever asks for it again."""

    bounds: ClassVar[dict[tuple[Interval, float, float], float]] = {}

    def best_of(self, one: Interval, least_mm: float, most_mm: float, stop: Callable[[], bool]) -> float:
        key = one, least_mm, most_mm
        if key not in self.bounds:
            self.bounds[key] = super().best_of(one, least_mm, most_mm, stop)
        return self.bounds[key]


@pytest.mark.parametrize("close", [0.12, 1e-3])
def test_time_that_is_enough_ends_a_bound_that_is_close_alone(close: float, monkeypatch: pytest.MonkeyPatch) -> None:
    one, reported = machine(4.8), list[str]()
    monkeypatch.setattr("optimizer.codesign.bound.CLOSE", close)
    family = Once(BRIEF, one, {(MOTOR, "capstan"): KNOWN})
    found = bounded(family, one.side_mm, lambda: len(reported) >= 4, reported.append, lambda: True)
    assert (len(reported) < 4) is (close > 0.1)
    assert (found.gap <= close) is (close > 0.1)


def test_the_thread_whose_waiting_for_a_processor_does_not_count_does_half_of_the_work() -> None:
    by: dict[Interval, str] = {}

    class Noted(Family):
        def best_of(self, one: Interval, least_mm: float, most_mm: float, stop: Callable[[], bool]) -> float:
            del least_mm, stop
            by[one] = current_thread().name
            return min(most_mm, 86.0 + one.arms_mm[0] / 100.0)

    one = machine(4.8)
    family = Noted(BRIEF, one, {(MOTOR, "capstan"): KNOWN})
    bounded(family, 80.0, lambda: len(by) >= INTERVALS)
    assert {name == current_thread().name for name in by.values()} == {True, False}
    own = sum(name == current_thread().name for name in by.values())
    assert own >= len(by) / 2


def test_a_machine_is_one_of_its_family_whatever_others_were_corrected() -> None:
    one = machine(4.8)
    radius = one.lengths_mm[2]
    updated = KNOWN.raised("base_radius", radius + 1.0, "").with_chains_apart(
        50.0, radius, 2.0, "another machine's keys"
    )
    family = Family(BRIEF, one, {(MOTOR, "capstan"): updated})
    *_, relaxed = family._relaxed(Interval(MOTOR, "capstan", (4.8, 4.8), (90.0, 90.0)))
    assert relaxed.least_radius_mm(50.0) == pytest.approx(radius)
    assert relaxed.least("platform_radius") <= one.lengths_mm[3]


def test_what_lies_between_a_machine_and_its_bound_is_reported_in_parts() -> None:
    one = machine(4.8)
    family = Family(BRIEF, one, {(MOTOR, "capstan"): KNOWN})
    losses = dict(family.losses(one.side_mm, 1.05 * one.side_mm))
    assert sum(losses.values()) == pytest.approx(0.05 * one.side_mm)
    kept, parts, rest = losses.values()
    assert 0.0 < kept < 0.003 * one.side_mm
    assert 0.0 < parts < 0.02 * one.side_mm  # the mass felt binds here, and of rods only the ends count
    assert rest > 0.0


@pytest.mark.parametrize(("placed", "most_s"), [(False, 300.0), (True, 30.0)])
def test_for_a_placed_machine_the_bound_of_symmetric_ones_takes_a_share_of_the_time(
    placed: bool, most_s: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    now = [0.0]

    def as_long_as_it_may(
        _family: Family, side_mm: float, stop: Callable[[], bool], *_: Callable[..., object]
    ) -> Bound:
        while not stop():
            now[0] += 1.0
        return Bound(1.1 * side_mm, 0.1, 1, cast(Kind, None), ())

    monkeypatch.setattr(bound, "bounded", as_long_as_it_may)
    monkeypatch.setattr("optimizer.codesign.run.with_least_radius", lambda _, known: known)  # which takes a design
    one = machine(5.0)
    one = replace(one, choice=one.choice.with_(placed=placed))
    run = Run(Path(), 0, "", 600.0, lambda: now[0], unmemoized, lambda _: None, lambda _: None)
    found = Builder(run, BRIEF)._bound(one, KNOWN)
    assert now[0] == pytest.approx(most_s + 1.0)
    assert found is not None
    assert (found.placed_mm is None) is not placed
    assert found.side_mm == pytest.approx(1.1 * one.side_mm / (1.0 + GAP if placed else 1.0))
