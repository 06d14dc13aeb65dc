"""Answers are those of a search from nothing, and prices the differences of two searches.

21 s of processor: each price is compared with a search of its own.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from optimizer.codesign.candidate import first_corrections
from optimizer.codesign.lengths import CONVERGED, ENOUGH, best_lengths
from optimizer.problem.variables import SIDE, mechanism_of
from optimizer.studio import background, knobs, model, outlook
from optimizer.studio.body import USUAL, body, sizes
from optimizer.studio.model import Solver, certify, figures_of, hardware_of
from optimizer.studio.sensitivity import sensitivity
from tests.optimizer.studio.tasks import joystick, pocket

STEPS = {knobs.WIDTH: 1.0, knobs.DEPTH: 1.0, knobs.KAPPA: 0.02, knobs.FRICTION: 0.004, knobs.COUPLE: 0.004}


@pytest.mark.parametrize("placed", [False, True])
def test_a_slider_that_moved_far_comes_to_what_a_search_from_nothing_finds(placed: bool) -> None:
    solver = Solver()
    assert solver.settle(joystick(placed)) is not None
    for width in (268.0, 262.0, 255.0, 250.0, 247.0):
        moved = solver.move(joystick(placed, requirements__envelope_width_mm=width))
        assert moved is not None
    task = joystick(placed, requirements__envelope_width_mm=247.0)
    settled = solver.settle(task)
    known = first_corrections(task.brief, task.choice)
    cold = best_lengths(task.brief, task.choice, known)
    assert settled is not None
    assert cold is not None
    assert settled.side_mm == pytest.approx(cold.side_mm, rel=2.0 * CONVERGED)
    assert moved.side_mm == pytest.approx(cold.side_mm, rel=0.01)  # its masses are those of the lengths before


@pytest.mark.parametrize("width", [286.0, 277.0, 256.0])
def test_what_rounding_takes_of_an_outline_leaves_no_limit_open(width: float) -> None:
    """Of these lengths in whole micrometres a corner of the platform is up to 2.3e-5 of the outline beyond it."""
    task = joystick(requirements__envelope_width_mm=width)
    task = replace(task, choice=hardware_of(task.brief)[0])
    solver = Solver()
    settled = solver.settle(task)
    assert settled is not None
    assert certify(settled).open == ()
    longer = (settled.lengths_mm[0] + 0.02, *settled.lengths_mm[1:])
    assert certify(replace(settled, lengths_mm=longer)).open


def test_a_least_machine_has_the_size_that_a_search_from_nothing_finds() -> None:
    solver = Solver()
    assert solver.settle(pocket()) is not None
    for side in (41.0, 43.0, 44.0):
        assert solver.move(pocket(requirements__cube_side_mm=side)) is not None
    task = pocket(requirements__cube_side_mm=44.0)
    settled = solver.settle(task)
    cold = best_lengths(task.brief, task.choice, first_corrections(task.brief, task.choice))
    assert settled is not None
    assert cold is not None
    assert cold.reach_mm is not None
    assert settled.size == pytest.approx(cold.reach_mm, rel=4.0 * ENOUGH)
    assert settled.lengths_mm[SIDE] == 22.0


def test_a_limit_that_does_not_bind_leaves_the_lengths_as_they_are() -> None:
    solver = Solver()
    found = solver.settle(joystick())
    assert found is not None
    assert solver.move(joystick(feel__effective_mass_max_kg=0.41)) == replace(
        found, task=joystick(feel__effective_mass_max_kg=0.41)
    )


def test_what_has_no_lengths_has_none_and_the_last_are_kept() -> None:
    solver = Solver()
    found = solver.settle(joystick())
    task = joystick(feel__effective_mass_max_kg=0.02)
    assert solver.move(task) is None
    assert solver.settle(task) is None
    assert solver.last == found


@pytest.mark.parametrize("placed", [False, True])
def test_prices_are_the_differences_of_two_searches(placed: bool) -> None:
    solver, task = Solver(), joystick(placed)
    found = solver.settle(task)
    assert found is not None
    felt = sensitivity(found)
    assert felt.explained
    assert felt.is_optimum
    compared = 0
    for field, step in STEPS.items():
        own = task.brief.value(field)
        price = felt.price(field)
        assert own is not None
        assert price is not None
        sides = []
        for value in (own + step, own - step):
            other = best_lengths(
                task.brief.with_values({field: value}), task.choice, found.corrections, found.lengths_mm
            )
            assert other is not None
            sides.append(other.side_mm)
        difference = (sides[0] - sides[1]) / (2.0 * step)
        # a search resolves a side to 2e-4 of the limits' room; masses follow the lengths there, and are held here
        assert price == pytest.approx(difference, rel=0.15, abs=0.04 / step), field
        compared += abs(difference) * step > 0.1
    assert compared >= 2  # not all of them are next to nothing


def test_what_binds_are_limits_that_are_used_up() -> None:
    found = Solver().settle(joystick())
    assert found is not None
    names = [one.name for one in sensitivity(found).binding]
    assert "outline" in names
    assert "kappa" in names
    figures = figures_of(found)
    assert figures["kappa"][0] == pytest.approx(2.27, rel=1e-3)
    assert figures["effective_mass"][0] < 0.4
    assert "effective_mass" not in names


def test_lengths_are_proved_and_larger_cubes_of_them_are_not() -> None:
    found = Solver().settle(joystick())
    assert found is not None
    proved = certify(found)
    assert (proved.holds, proved.open) == (True, ())
    larger = tuple(1.004 * v if k == SIDE else v for k, v in enumerate(found.lengths_mm))
    refuted = certify(replace(found, lengths_mm=larger))
    assert not refuted.holds
    assert "kappa" in refuted.open


def test_a_body_has_every_link_and_its_sizes() -> None:
    found = Solver().settle(joystick(placed=True))
    assert found is not None
    own = sizes(found)
    assert own is not None
    links = {
        "base",
        "platform",
        *(f"upper_arm_{i}" for i in range(3)),
        *(f"rod_{i}_{j}" for i in range(3) for j in (0, 1)),
    }
    for of in (USUAL, own):
        made = body(found, of)
        assert {one["link"] for one in made} == links
    rods = [one for one in made if one["link"].startswith("rod") and "ends" in one]
    assert all(one["ends"] == [0.0, found.lengths_mm[1]] for one in rods)
    assert own.motor[0] == 15.0  # RE 30
    assert own.motor[1][1] - own.motor[1][0] == pytest.approx(68.0)
    for one in made:
        if "outline" in one:  # the middle sees every corner: the fan of triangles folds nowhere
            corners = np.array(one["outline"]) - np.mean(one["outline"], axis=0)
            following = np.roll(corners, -1, axis=0)
            areas = corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]
            assert (areas > -1e-6).all() or (areas < 1e-6).all()


def test_the_geometry_sent_is_the_mechanisms() -> None:
    found = Solver().settle(joystick(placed=True))
    assert found is not None
    g, cube = mechanism_of(found.lengths_mm)
    sent = model.geometry_of(found)
    assert np.array(sent["radial"]) == pytest.approx(g.radial)
    assert sent["upper_arm_mm"] == pytest.approx(1e3 * g.upper_arm_length)
    assert model.lengths_of(found)["half_side_mm"] == pytest.approx(1e3 * cube.half_side)


def test_rows_of_other_motors_are_estimates_and_the_present_one_keeps_what_its_parts_need() -> None:
    found = Solver().settle(joystick())
    assert found is not None
    found = replace(found, corrections=replace(found.corrections, elbow_angle_deg=21.0))
    sent: list[dict[str, Any]] = []
    other = replace(found.task.choice, motor="maxon-re30-310009")

    def compute(piece, task, known):
        assert piece is background.cold
        begun = first_corrections(task.brief, task.choice)
        assert known == (found.corrections if task.key == found.task.key else begun)
        return replace(found, task=task, side_mm=found.side_mm + (5.0 if task.choice == other else -5.0))

    view: Any = SimpleNamespace(
        hardware=[found.task.choice, other], compute=compute, doing=lambda _: None, tell=sent.append
    )
    outlook._hardware(view, found)
    rows = {row["motor"]: (row["side_mm"], row.get("estimated", False)) for row in sent[-1]["rows"]}
    side_mm = round(found.side_mm, 2)
    assert rows[found.task.choice.motor] == (side_mm, False)
    assert rows[other.motor] == (pytest.approx(side_mm + 5.0), True)
