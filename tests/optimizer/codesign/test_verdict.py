"""The verdict on a search, and its time: one without a machine of any hardware says that it is no proof."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.mechanism.limits.effective_mass import effective_mass
from optimizer.codesign import search as module
from optimizer.codesign.candidate import Candidate, effective_mass_kg
from optimizer.codesign.corrections import Corrections, MassEstimate, reference
from optimizer.codesign.hardware import Selection, drives
from optimizer.codesign.search import Search
from optimizer.codesign.search_log import End, SearchLog, Verdict, verdict
from optimizer.codesign.updates import InconclusiveError, NoProgressError
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.search.clock import OutOfTimeError
from tests.optimizer.codesign.test_search import MOTORS, PASSED, Paper, brief

ENDS: tuple[End, ...] = ("done", "time", "stopped")
HARDWARE = "a capstan", "b direct"


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("stands", [True, False])
def test_a_search_is_infeasible_where_closed_forms_exclude_all_or_it_ended_with_all_refused(
    end: End, stands: bool
) -> None:
    """Over all states of two motors: refused, given up, not looked at to the end, and of closed forms."""
    states = "refused", "gave up", "left"
    for first, second, impossible in product(states, states, ([], ["force_N must be at most 20 N"])):
        log = SearchLog(impossible=impossible)
        for name, state in zip(HARDWARE, (first, second), strict=True):
            if state == "left":
                log.left.append(name)
            else:
                log.no_progress[name] = "no lengths"
            if state == "gave up":
                log.inconclusive.add(name)
        ends, why = verdict(log, end, stands)
        if end == "stopped":
            assert ends is Verdict.STOPPED
        elif stands:
            assert ends is Verdict.BUILT
        else:
            shown = bool(impossible) or first == second == "refused"
            assert ends is (Verdict.INFEASIBLE if shown else Verdict.NOT_FOUND)
            assert why
            assert ("no proof" in why) is (shown and not impossible)
            assert all(name in why for name in log.left if not shown)


def test_each_has_its_exit_code() -> None:
    assert {str(one): one.code for one in Verdict} == {
        "built": 0,
        "infeasible": 1,
        "not found in time": 4,
        "stopped": 4,
    }


def test_hardware_that_ended_is_no_longer_left() -> None:
    log = SearchLog(left=list(HARDWARE))
    log.ended(HARDWARE[0])
    assert log.left == [HARDWARE[1]]


class Timed:
    """A search whose candidates are given, on a clock that each step moves by a second."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, minutes_s: float, half_s: float, steps: int = 4) -> None:
        self.now, self.paper, self.weighed = 0.0, Paper({motor: [[PASSED]] for motor in MOTORS}), list[float]()
        self.search = search = Search(brief(), self.paper.build, self.paper.moving)
        search.stop = lambda: self.now > minutes_s
        search.hurried = lambda: self.now > half_s and not self.paper.built
        search.report = self.step

        def fixed_point(choice: Selection, *_: object, weighing: bool = True, **__: object) -> Candidate:
            for k in range(steps):
                search.begin(f"part {k} of {choice.motor}")
            if weighing:
                self.weighed.append(self.now)
                search.corrections.setdefault((choice.motor, choice.drive), Corrections(reference()))
            return found(choice, 84.0 - abs(choice.ratio - 4.0), weighing)

        ranked = [(90.0, Selection(motor, "capstan", 5.0, 50.0)) for motor in MOTORS]
        monkeypatch.setattr(search, "_rough", lambda: ranked)
        monkeypatch.setattr(search, "fixed_point", fixed_point)

    def step(self, _: str) -> None:
        self.now += 1.0


def found(choice: Selection, score: float, weighed: bool = True) -> Candidate:
    design = SimpleNamespace(hardware=SimpleNamespace(motor=choice.motor), cube=SimpleNamespace(half_side_mm=1.0))
    return Candidate(cast(Design, design), choice, (90.0,) * 6, Corrections(reference()), score, weighed)


@pytest.mark.parametrize("half_s", [14.0, 20.0, 40.0, 70.0])
def test_at_half_of_the_time_what_was_weighed_is_built_at_once(monkeypatch: pytest.MonkeyPatch, half_s: float) -> None:
    """Two steps after half of the time a machine is being built, wherever the search was; it was weighed before."""
    run = Timed(monkeypatch, 2.0 * half_s, half_s)
    moving = run.paper.moving

    def begun(design: Design) -> list[CheckResult]:
        assert run.weighed[0] <= half_s
        assert run.now <= half_s + 3.0
        return moving(design)

    run.search.moving = begun
    with pytest.raises(OutOfTimeError):
        run.search.best()
    assert run.paper.built[0] == MOTORS[0]
    assert run.now <= 2.0 * half_s + 1.0  # inside a candidate, too


def test_hardware_that_the_time_did_not_reach_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Timed(monkeypatch, 12.0, 100.0)
    with pytest.raises(OutOfTimeError):
        run.search.best()
    assert run.search.log.left == [f"{motor} capstan" for motor in MOTORS]
    assert verdict(run.search.log, "time", stands=False)[0] is Verdict.NOT_FOUND


def test_an_estimate_that_was_cut_off_is_no_refusal(monkeypatch: pytest.MonkeyPatch) -> None:
    """The time ends within the first motor: nothing is known of it, nor of the other."""
    left, search = [2], Search(brief())
    monkeypatch.setattr(module, "best_lengths", lambda *_: None)

    def stop() -> bool:
        left[0] -= 1
        return left[0] < 0

    search.stop = stop
    with pytest.raises(OutOfTimeError):
        search.best()
    assert search.log.no_progress == {}
    assert len(search.log.left) == len(MOTORS)


def test_a_step_ends_between_the_starts_of_its_lengths() -> None:
    """The time is over while lengths are sought: after one more start of SQP it ends."""
    search, required = Search(brief()), [0]

    def stop() -> bool:
        required[0] += 1
        return required[0] > 1

    search.stop = stop
    with pytest.raises(OutOfTimeError):
        search._estimate(Selection(MOTORS[0], "capstan", 5.0, 50.0))
    assert required == [2]


@pytest.mark.parametrize("error", [NoProgressError("too soft"), InconclusiveError("no agreement")])
def test_only_refusals_of_all_hardware_are_infeasible(monkeypatch: pytest.MonkeyPatch, error: NoProgressError) -> None:
    search = Search(brief())

    def fails(*_: object) -> Candidate:
        raise error

    monkeypatch.setattr(search, "_rough", lambda: [(80.0, Selection(motor, "capstan", 5.0, 50.0)) for motor in MOTORS])
    monkeypatch.setattr(search, "_fixed_point", fails)
    assert search.best() is None
    assert set(search.log.no_progress) == {f"{motor} capstan" for motor in MOTORS}
    ends = Verdict.NOT_FOUND if isinstance(error, InconclusiveError) else Verdict.INFEASIBLE
    assert verdict(search.log, "done", stands=False)[0] is ends


def test_hardware_beyond_the_likeliest_is_gone_through_before_there_is_no_machine(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of more motors than are ranked by their parts the last one has a machine."""
    motors = [motor for motor, drive in drives(brief_of_all()) if drive == "capstan"]
    monkeypatch.setattr(module, "RANKED", 2)
    monkeypatch.setattr(module, "MOTORS", 1)
    monkeypatch.setattr("optimizer.codesign.lengths.effective_mass_kg", lambda _: 1.0)
    search = Search(brief_of_all(), moving=lambda _: [PASSED])
    search.build = lambda design: cast(Any, SimpleNamespace(results=[PASSED], design=design))

    def fixed_point(choice: Selection, *_: object, **__: object) -> Candidate:
        if choice.motor != motors[-1]:
            raise NoProgressError("too weak")
        search.corrections[choice.motor, choice.drive] = Corrections(reference())
        return found(choice, 80.0)

    monkeypatch.setattr(search, "_rough", lambda: [(80.0, Selection(motor, "capstan", 5.0, 50.0)) for motor in motors])
    monkeypatch.setattr(search, "_fixed_point", fixed_point)
    best = search.best()
    assert best is not None
    assert best[0].choice.motor == motors[-1]
    assert len(search.log.no_progress) == len(motors) - 1


def brief_of_all() -> DesignBrief:
    return brief_from_dict({"name": "b", "requirements": {"cube_side_mm": 60.0}, "hardware": {"drive": "capstan"}})


@pytest.mark.parametrize("varies", ["ratio", "width_mm"])
def test_of_machines_as_small_the_lightest_is_taken(monkeypatch: pytest.MonkeyPatch, varies: str) -> None:
    """A cube that is set, and R + L_A of 120 mm however wide and geared, off by less than lengths are found to.

    The mass grows with what varies, down to 4:1 or 40 mm, below which the machine is larger.
    """
    search, least = Search(brief_of_all()), (4.0, 40.0)
    k = ("ratio", "width_mm").index(varies)

    def share(choice: Selection) -> float:
        return float(getattr(choice, varies)) / least[k]

    def fixed_point(choice: Selection, *_: object, **__: object) -> Candidate:
        return found(choice, -120.0 - 0.1 * np.sin(200.0 * share(choice)) - 8.0 * max(1.0 - share(choice), 0.0))

    monkeypatch.setattr(search, "fixed_point", fixed_point)
    monkeypatch.setattr("optimizer.codesign.lengths.effective_mass_kg", lambda one: share(one.choice))
    best = search._climbed(fixed_point(Selection(MOTORS[0], "capstan", 6.23, 54.0)), range(3))
    assert 0.97 < share(best.choice) < 1.05


def test_the_effective_mass_of_a_candidate_is_that_of_its_masses_at_its_ratio(best: Design) -> None:
    """A rotor at twice the ratio takes four times its share; without it nothing changes with the ratio."""
    known, m, cube = reference(), best.mechanism, best.cube
    lengths = (m.upper_arm_length_mm, m.forearm_length_mm, m.base_radius_mm, m.platform_radius_mm)
    lengths += (cube.bottom_height_mm, cube.half_side_mm)

    def mass(weighed: MassEstimate, ratio: float) -> float:
        choice = Selection(MOTORS[0], "capstan", ratio, m.parallelogram_width_mm)
        return effective_mass_kg(Candidate(best, choice, lengths, Corrections(weighed), 0.0))

    bare = replace(known, masses=replace(known.masses, rotor_inertia=0.0))
    assert mass(bare, 4.0) == mass(bare, 8.0)
    corner = np.array([1.0, 1.0, 0.0]) * cube.half_side_mm / MM_PER_M + [0.0, 0.0, cube.bottom_height_mm / MM_PER_M]
    for ratio in (4.0, 8.0):
        inertia = known.inertia(lengths[0], lengths[1], ratio)
        assert mass(known, ratio) >= float(effective_mass(best.geometry, corner, inertia))
    assert 0.0 < mass(known, 4.0) - mass(bare, 4.0) < mass(known, 8.0) - mass(bare, 8.0)


def test_a_larger_cube_is_not_given_for_a_lower_ratio(monkeypatch: pytest.MonkeyPatch) -> None:
    search = Search(brief())
    monkeypatch.setattr(search, "fixed_point", lambda choice, *_, **__: found(choice, 80.0 + 0.01 * choice.ratio))
    best = search._climbed(found(Selection(MOTORS[0], "capstan", 6.23, 50.0), 80.0623), range(3))
    assert best.choice.ratio == 6.23
