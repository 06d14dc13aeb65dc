"""Which limits are in one another's way, of tasks whose machines are told beforehand."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import pytest

from delta_cad.design import Design
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.relaxation import FINE, MOST, Relaxation, minimal_relaxations, strongest
from optimizer.codesign.search import Search
from optimizer.problem.brief import DesignBrief, brief_from_dict

MOTORS = ["maxon-re30-310007", "maxon-ec60flat-625858"]


def brief(felt: dict[str, float] | None = None, **requirements: float) -> DesignBrief:
    room = {"envelope_width_mm": 120.0, "envelope_depth_mm": 110.0, "force_N": 3.0}
    data = {"name": "b", "requirements": room | requirements, "feel": felt or {}, "hardware": {"motor": MOTORS}}
    return brief_from_dict(data)


def wording(
    monkeypatch: pytest.MonkeyPatch, task: DesignBrief, able: Callable[[DesignBrief], bool]
) -> list[Relaxation]:
    """What is found where a task has a machine exactly if `able` says so."""

    def fixed_point(search: Search, choice: Selection, *_: object, **__: object) -> Candidate | None:
        if choice.motor != MOTORS[0] or not able(search.brief):
            return None
        lengths = (90.0, 140.0, 30.0, 20.0, 70.0, 25.0)
        return Candidate(cast(Design, None), choice, lengths, Corrections(reference()), 50.0)

    monkeypatch.setattr(Search, "fixed_point", fixed_point)
    return minimal_relaxations(Search(task))


def test_each_limit_that_would_be_enough_is_reported_with_how_much_the_least_change_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def able(task: DesignBrief) -> bool:
        required = task.requirements
        return (required.envelope_width_mm or 0.0) >= 151.0 or required.force_N <= 1.2

    found = wording(monkeypatch, brief({"kappa_max": 2.27}), able)
    assert [one.fields[0] for one in found] == ["requirements.envelope_width_mm", "requirements.force_N"]
    outline, force = found
    width, depth = outline.enough
    assert 151.0 <= width < 151.0 * FINE
    assert width / depth == pytest.approx(120.0 / 110.0)
    assert 1.2 / FINE < force.enough[0] <= 1.2
    assert str(force) == f"requirements.force_N = {force.enough[0]:.4g} instead of 3"
    assert able(outline.brief)
    assert able(force.brief)
    assert outline.brief.feel.kappa_max == 2.27  # all else is as asked
    assert outline.start.choice.motor == MOTORS[0]


def test_the_hardware_that_asks_for_the_least_change_decides(monkeypatch: pytest.MonkeyPatch) -> None:
    """A direct drive, which is tried first, would do with a far smaller force; the capstan with a little less."""
    enough = {MOTORS[0]: 2.5, MOTORS[1]: 1.1}

    def fixed_point(search: Search, choice: Selection, *_: object, **__: object) -> Candidate | None:
        if search.brief.requirements.force_N > enough[choice.motor]:
            return None
        return Candidate(
            cast(Design, None), choice, (90.0, 140.0, 30.0, 20.0, 70.0, 25.0), Corrections(reference()), 50.0
        )

    monkeypatch.setattr(Search, "fixed_point", fixed_point)
    (one,) = minimal_relaxations(Search(brief()))
    assert one.start.choice.motor == MOTORS[0]
    assert 2.5 / FINE < one.enough[0] <= 2.5


def test_a_limit_that_is_in_nobodys_way_is_not_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    found = wording(
        monkeypatch, brief({"effective_mass_max_kg": 0.1}), lambda task: task.feel.effective_mass_max_kg > 0.25
    )
    assert [one.fields for one in found] == [("feel.effective_mass_max_kg",)]
    assert wording(monkeypatch, brief(), lambda task: task.requirements.force_N < 3.0 / MOST / 2.0) == []


@pytest.mark.parametrize("motor_does_mm", [190.0, 390.0])
def test_a_motor_that_a_huge_outline_asks_too_much_of_does_for_a_smaller_one(
    monkeypatch: pytest.MonkeyPatch, motor_does_mm: float
) -> None:
    """The largest cube of an outline of 1.2 m is no motor's here."""

    def able(task: DesignBrief) -> bool:
        return motor_does_mm <= (task.requirements.envelope_width_mm or 0.0) <= 1.5 * motor_does_mm

    found = {one.fields: one for one in wording(monkeypatch, brief(), able)}
    width, _ = found["requirements.envelope_width_mm", "requirements.envelope_depth_mm"].enough
    assert motor_does_mm <= width < motor_does_mm * FINE


def test_a_lean_that_would_be_enough_is_found_though_ten_times_as_much_is_no_angle(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    task = brief()
    task = task.model_copy(update={"limits": task.limits.model_copy(update={"lean_max_deg": 28.0})})
    (one,) = wording(monkeypatch, task, lambda eased: 45.0 <= (eased.limits.lean_max_deg or 0.0) < 90.0)
    assert one.fields == ("limits.lean_max_deg",)
    assert 45.0 <= one.enough[0] < 45.0 * FINE


def test_limits_of_which_none_alone_is_enough_give_together_and_no_more_of_them_than_must(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A cube too large for any force and a force too large for any cube; what it may weigh is in nobody's way."""

    def able(task: DesignBrief) -> bool:
        required = task.requirements
        return (required.cube_side_mm or 0.0) <= 120.0 / MOST and required.force_N <= 22.0 / MOST

    task = brief({"effective_mass_max_kg": 0.5}, cube_side_mm=110.0, force_N=20.0)
    (one,) = wording(monkeypatch, task, able)
    assert one.fields == ("requirements.force_N", "requirements.cube_side_mm")
    force, side = one.enough
    assert 110.0 / side == pytest.approx(20.0 / force)  # by one factor
    assert able(one.brief)
    assert not able(one.further(1.0 / FINE / 1.001).brief)
    assert one.brief.feel.effective_mass_max_kg == 0.5
    assert "requirements.force_N" in str(one)
    assert "requirements.cube_side_mm" in str(one)
    assert wording(monkeypatch, task, lambda _: False) == []


def test_a_clearance_gives_where_more_is_required_than_is_usual(monkeypatch: pytest.MonkeyPatch) -> None:
    """Screws keep 2.4 mm in any machine: 3 mm are too much, and what is usual is nobody's to give."""
    (one,) = wording(monkeypatch, brief(clearance_min_mm=3.0), lambda task: task.requirements.clearance_min_mm <= 2.4)
    assert one.fields == ("requirements.clearance_min_mm",)
    assert 2.4 / FINE < one.enough[0] <= 2.4
    assert wording(monkeypatch, brief(), lambda task: task.requirements.clearance_min_mm <= 1.9) == []
    assert (
        wording(monkeypatch, brief(clearance_min_mm=2.2), lambda task: task.requirements.clearance_min_mm <= 1.9) == []
    )
    (one,) = wording(monkeypatch, brief(clearance_min_mm=2.2), lambda task: task.requirements.force_N <= 2.0)
    assert one.fields == ("requirements.force_N",)
    (both,) = wording(monkeypatch, brief(clearance_min_mm=2.5), lambda task: task.requirements.force_N <= 2.0)
    assert both.fields == ("requirements.force_N", "requirements.clearance_min_mm")


def test_hardware_is_tried_that_is_the_strongest_or_the_lightest_of_what_is_allowed() -> None:
    found = [(choice.motor, choice.drive) for choice in strongest(brief())]
    assert found == [(MOTORS[1], "direct"), (MOTORS[0], "capstan")]
    wide = list(strongest(brief_from_dict({"name": "b", "requirements": {"cube_side_mm": 50.0}})))
    assert {choice.drive for choice in wide} == {"direct", "capstan"}
    assert 3 <= len(wide) <= 4


def test_of_all_hardware_that_counts_which_needs_least(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first does from 200 mm on, the second from 140: of the first no more is said."""
    task = brief()
    choices = list(strongest(task))
    least = {choices[0].motor: 200.0, choices[-1].motor: 140.0}
    assert len(least) == len(choices) == 2

    def fixed_point(search: Search, choice: Selection, *_: object, **__: object) -> Candidate | None:
        if (search.brief.requirements.envelope_width_mm or 0.0) < least[choice.motor]:
            return None
        lengths = (90.0, 140.0, 30.0, 20.0, 70.0, 25.0)
        return Candidate(cast(Design, None), choice, lengths, Corrections(reference()), 50.0)

    monkeypatch.setattr(Search, "fixed_point", fixed_point)
    (outline,) = minimal_relaxations(Search(task))
    assert outline.start.choice.motor == choices[-1].motor
    assert 140.0 <= outline.enough[0] < 140.0 * FINE


def test_what_did_with_less_is_where_more_is_tried_from(monkeypatch: pytest.MonkeyPatch) -> None:
    """Closed forms teach again what they taught of the easier task, and lengths begin from its."""
    begun: list[tuple[float, tuple[float, ...] | None, float]] = []

    def fixed_point(
        search: Search, choice: Selection, start: tuple[float, ...] | None = None, **_: object
    ) -> Candidate | None:
        force, known = search.brief.requirements.force_N, search.corrections.get((choice.motor, choice.drive))
        begun.append((force, start, known.elbow_angle_deg if known else 0.0))
        if choice.motor != MOTORS[0] or force > 1.2:
            return None
        lengths = (90.0, 140.0, 30.0, 20.0, 70.0, 1.0 / force)
        return Candidate(cast(Design, None), choice, lengths, Corrections(reference(), elbow_angle_deg=force), 50.0)

    monkeypatch.setattr(Search, "fixed_point", fixed_point)
    (one,) = minimal_relaxations(Search(brief()))
    assert one.enough[0] <= 1.2
    assert one.start.lengths_mm[-1] == 1.0 / one.enough[0]
    assert one.start.corrections.elbow_angle_deg == one.enough[0]
    warm = [(force, start, known) for force, start, known in begun if start is not None]
    assert len(warm) >= 5
    for force, start, known in warm:
        assert start is not None
        assert known == pytest.approx(1.0 / start[-1])  # both of one machine,
        assert known < force  # of an easier task
