"""The search with machines that exist on paper only: the order of builds, and what remains."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from types import SimpleNamespace
from typing import Any, cast

import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.common.console import Step
from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions.joint import force_most_N
from delta_cad.mechanism import UnreachableError
from delta_cad.solids.primitive import BuildError
from optimizer.codesign import candidate as candidates
from optimizer.codesign import search as module
from optimizer.codesign import updates
from optimizer.codesign.bound import impossible
from optimizer.codesign.candidate import Candidate, refused
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import SMALL, Selection, motor_of, neighbours, widths_of
from optimizer.codesign.lengths import Found
from optimizer.codesign.search import LEAST_SIDE_MM, Search
from optimizer.codesign.search_log import NEAREST, RELAXATIONS, SearchLog, Trial, Verdict, best_so_far, verdict
from optimizer.codesign.updates import NoProgressError
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.search.clock import HalfTimeError, OutOfTimeError
from tests.committed import changed

MOTORS = ["maxon-re30-310007", "faulhaber-3257g024cr"]
ESTIMATES = {MOTORS[0]: 86.0, MOTORS[1]: 85.0}
PASSED = CheckResult("all", True, 1.0, 1.0, "")


def brief(**requirements: float) -> DesignBrief:
    room = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}
    requested = {"name": "b", "requirements": room | requirements, "hardware": {"motor": MOTORS, "drive": "capstan"}}
    return brief_from_dict(requested)


@dataclass
class Paper:
    """Machines whose checks are told beforehand, by motor."""

    verdicts: dict[str, list[list[CheckResult]]]
    built: list[str] = field(default_factory=list)
    moved: list[str] = field(default_factory=list)

    def moving(self, design: Design) -> list[CheckResult]:
        self.moved.append(design.hardware.motor)
        return self.verdicts[design.hardware.motor].pop(0)

    def build(self, design: Design) -> Any:
        self.built.append(design.hardware.motor)
        return SimpleNamespace(results=[PASSED], design=design)


def searched(
    paper: Paper, scores: dict[str, list[float]], monkeypatch: pytest.MonkeyPatch, **requested: float
) -> Search:
    """A search whose estimates and candidates are given: the last score of a motor stays."""
    search = Search(brief(**requested), paper.build, paper.moving)

    def fixed_point(choice: Selection, *_: object, weighing: bool = True, **__: object) -> Candidate:
        left = scores[choice.motor] if weighing else [ESTIMATES[choice.motor]]
        score = left.pop(0) if len(left) > 1 else left[0]
        search.corrections.setdefault((choice.motor, choice.drive), Corrections(reference()))
        design = SimpleNamespace(hardware=SimpleNamespace(motor=choice.motor), cube=SimpleNamespace(half_side_mm=1.0))
        lengths = (90.0, 140.0, 30.0, 20.0, 70.0, score / 2.0)
        return Candidate(cast(Design, design), choice, lengths, Corrections(reference()), score)

    ranked = [(ESTIMATES[motor], Selection(motor, "capstan", 5.0, 50.0)) for motor in scores]
    monkeypatch.setattr(search, "_rough", lambda: ranked)
    monkeypatch.setattr(search, "fixed_point", fixed_point)
    monkeypatch.setattr(search, "refined", fixed_point)
    monkeypatch.setattr(search, "_polished", lambda candidate: candidate)
    return search


def test_what_fails_where_it_moves_is_not_built(monkeypatch: pytest.MonkeyPatch) -> None:
    close = CheckResult("clearance", False, 1.5, 2.0, "mm", worst_pair=("motor_0", "encoder_board_1"))
    paper = Paper({MOTORS[0]: [[close], [close], [PASSED]]})
    search = searched(paper, {MOTORS[0]: [84.0, 84.0, 83.0, 82.0]}, monkeypatch)
    found = search.best()
    assert found is not None
    assert (len(paper.moved), len(paper.built)) == (3, 1)
    assert [failed for _, failed in search.log.built] == [("clearance",), ("clearance",), ()]
    corrections = search.corrections[MOTORS[0], "capstan"]
    assert corrections.least("base_radius") == 31.0  # 0.5 mm more, the second time 1 mm


def test_a_machine_is_reported_by_the_ratio_that_small_steps_came_to(monkeypatch: pytest.MonkeyPatch) -> None:
    paper, reported = Paper({MOTORS[0]: [[PASSED]]}), list[str]()
    search = searched(paper, {MOTORS[0]: [83.0]}, monkeypatch)
    search.tell = search.report = reported.append
    monkeypatch.setattr(search, "_polished", lambda one: replace(one, choice=one.choice.with_(ratio=4.86)))
    assert search.best() is not None
    assert f"83.00 mm with {MOTORS[0]} at 4.86:1 passes every check" in reported
    assert not any("at 5:1" in line for line in reported)


def test_a_search_reports_its_step_what_of_it_is_done_and_the_best_so_far(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two motors: what the parts of both leave, the better refined and built, then the other."""
    paper, reported = Paper({motor: [[PASSED]] for motor in MOTORS[:2]}), list[Step]()
    search = searched(paper, {MOTORS[0]: [84.0], MOTORS[1]: [85.0]}, monkeypatch)
    search.report = lambda step: reported.append(cast(Step, step))
    assert search.best() is not None
    found = [(one.number, one.of, one.done, one.total, one.best) for one in reported]
    assert found == [
        (2, 4, 0, 2, ""),
        (2, 4, 1, 2, ""),
        (4, 4, 0, 0, ""),
        (4, 4, 0, 0, ""),
        (4, 4, 0, 0, "84.00 mm of cube, built"),
        (4, 4, 0, 0, "84.00 mm of cube, built"),
    ]


@pytest.mark.parametrize(
    ("objective", "scores", "ready", "words"),
    [
        ("cube_side", [], None, ""),
        ("cube_side", [(80.0, None), (84.0, None)], None, "about 84.00 mm of cube"),
        ("cube_side", [(90.0, None)], 84.0, "84.00 mm of cube by closed forms"),
        ("cube_side", [(90.0, None), (85.0, ("clearance",)), (83.0, ()), (82.0, ())], 84.0, "83.00 mm of cube, built"),
        ("cost", [(-900.0, ()), (-850.0, ())], None, "850 EUR, built"),
    ],
)
def test_the_best_so_far_is_a_machine_that_passed_before_it_is_an_estimate(
    objective: str, scores: list[tuple[float, tuple[str, ...] | None]], ready: float | None, words: str
) -> None:
    choice = Selection(MOTORS[0], "capstan", 5.0, 50.0)
    log = SearchLog(trials=[Trial(choice, score, failed) for score, failed in scores])
    assert best_so_far(log, objective, ready, estimating=True) == words
    assert best_so_far(log, objective, ready, estimating=False) == ("" if words.startswith("about") else words)


def test_a_nearest_machine_has_steps_of_its_own_and_no_best_of_an_eased_task() -> None:
    log = SearchLog(trials=[Trial(Selection(MOTORS[0], "capstan", 5.0, 50.0), 300.0, ())])
    step = RELAXATIONS._replace(done=1, total=5).step("what kappa costs", log, "cube_side", None)
    assert (str(step), step.number, step.of, step.done, step.total, step.best) == ("what kappa costs", 1, 2, 1, 5, "")
    assert (NEAREST.number, NEAREST.of) == (2, 2)


def test_what_only_has_to_pass_is_built_at_the_first_ratio_that_does(monkeypatch: pytest.MonkeyPatch) -> None:
    paper = Paper({MOTORS[0]: [[PASSED]]})
    search = searched(paper, {MOTORS[0]: [83.0, 83.0, 83.0]}, monkeypatch)
    search.finely, first = False, Selection(MOTORS[0], "capstan", 5.0, 50.0)
    monkeypatch.setattr(search, "refined", lambda choice: Search.refined(search, choice))
    monkeypatch.setattr(search, "_polished", lambda one: Search._polished(search, one))
    monkeypatch.setattr(search, "_climbed", lambda *_: pytest.fail("looked for better hardware"))
    found = search.best()
    assert found is not None
    assert found[0].choice == first


def test_the_next_motor_is_built_only_if_it_promises_more(monkeypatch: pytest.MonkeyPatch) -> None:
    for second, built in ((70.0, 1), (83.9, 1), (85.0, 2)):
        paper = Paper({motor: [[PASSED]] for motor in MOTORS})
        search = searched(paper, {MOTORS[0]: [84.0], MOTORS[1]: [second]}, monkeypatch)
        found = search.best()
        assert found is not None
        assert len(paper.built) == built
        assert found[0].score == max(84.0, second)


def test_a_machine_that_turns_out_smaller_does_not_replace_the_best(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its estimate was better; what its checks taught made it worse than what stands in the folder."""
    close = CheckResult("clearance", False, 1.5, 2.0, "mm", worst_pair=("motor_0", "encoder_board_1"))
    paper = Paper({MOTORS[0]: [[PASSED]], MOTORS[1]: [[close]]})
    search = searched(paper, {MOTORS[0]: [84.0], MOTORS[1]: [84.5, 84.5, 83.0]}, monkeypatch)
    found = search.best()
    assert found is not None
    assert paper.built == [MOTORS[0]]
    assert found[0].score == 84.0


def test_a_check_that_teaches_nothing_gives_the_motor_up(monkeypatch: pytest.MonkeyPatch) -> None:
    paper = Paper({MOTORS[0]: [[CheckResult("parts attached", False, 1.0, 0.0, "", detail="a bearing floats")]]})
    search = searched(paper, {MOTORS[0]: [84.0]}, monkeypatch)
    assert search.best() is None
    assert "a bearing floats" in search.log.no_progress[f"{MOTORS[0]} capstan"]


def test_a_solid_that_cannot_be_made_gives_the_motor_up_and_the_next_is_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    paper = Paper({MOTORS[1]: [[PASSED]]})
    search = searched(paper, {motor: [84.0] for motor in MOTORS}, monkeypatch)
    moving = paper.moving

    def fails(design: Design) -> list[CheckResult]:
        if design.hardware.motor == MOTORS[0]:
            raise BuildError("sector", "rim", "sector_radius_mm")
        return moving(design)

    search.moving = fails
    search.log.no_progress[f"{MOTORS[1]} capstan"] = "too soft at another width"
    assert search.best() is not None
    assert paper.built == [MOTORS[1]]
    assert list(search.log.no_progress) == [f"{MOTORS[0]} capstan"]  # the other is not given up: it passed
    assert "sector" in search.log.no_progress[f"{MOTORS[0]} capstan"]


def test_a_solid_that_the_kernel_does_not_make_is_tried_a_little_farther_out(monkeypatch: pytest.MonkeyPatch) -> None:
    search = Search(brief())
    weighed: list[Design] = []

    def fails(design: Design) -> Any:
        weighed.append(design)
        raise BuildError("encoder_cheek", "body", "the solid is not valid")

    monkeypatch.setattr(search, "_weighed", fails)
    monkeypatch.setattr(updates, "KERNEL_TRIES", 1)
    assert search.fixed_point(Selection(MOTORS[0], "capstan", 6.0, 50.0)) is None
    assert "the solid is not valid" in search.log.no_progress[f"{MOTORS[0]} capstan"]
    radii = [design.mechanism.base_radius_mm for design in weighed]
    assert len(radii) == 2
    assert all(0.05 < b - a < 0.5 for a, b in pairwise(radii))


def test_a_tiny_cube_is_no_answer_unless_it_is_requested(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lengths that leave less than is of use; the rough look keeps them: another ratio may leave more."""
    side = LEAST_SIDE_MM / 2.0
    lengths = Found((90.0, 140.0, 32.0, 22.0, 70.0, side / 2.0), side)
    one = Selection(MOTORS[0], "capstan", 5.0, 50.0)
    for requested, found in (({}, False), ({"cube_side_mm": side}, True)):
        search = Search(brief(**requested))
        monkeypatch.setattr(search, "_lengths", lambda *_: lengths)
        monkeypatch.setattr(module, "refused", lambda _: ())
        monkeypatch.setattr(module, "too_soft", lambda _: None)
        assert (search.fixed_point(one, weighing=False) is not None) == found
        assert ("5.0 mm" in search.log.no_progress.get(f"{MOTORS[0]} capstan", "")) != found
        assert search._estimate(one) is lengths


def test_only_what_stands_in_the_way_of_a_machine_gives_it_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """What goes wrong in a build is no reason why there is no machine."""
    paper = Paper({MOTORS[0]: [[PASSED]]})
    search = searched(paper, {MOTORS[0]: [84.0]}, monkeypatch)

    def wrong(_: Design) -> Any:
        raise UnreachableError("a page that is written wrong")

    search.build = wrong
    with pytest.raises(UnreachableError, match="written wrong"):
        search.best()


def test_a_design_that_comes_again_is_refused_once(monkeypatch: pytest.MonkeyPatch) -> None:
    requested: list[Design] = []

    def none(design: Design) -> tuple[()]:
        requested.append(design)
        return ()

    monkeypatch.setattr("optimizer.codesign.candidate.estimates", none)
    one, other = (design_from_dict(changed(mechanism__base_radius_mm=r)) for r in (31.1, 31.2))
    for design in (one, one, other, one):
        assert refused(design) == ()
    assert requested == [one, other, one]


def test_before_it_is_built_hardware_is_improved_by_small_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of machines that are best at 4.86:1 and a pinion 0.17 mm wider, from 5:1."""
    search = Search(brief())
    search.corrections[MOTORS[0], "capstan"] = Corrections(reference())
    weighed: list[Selection] = []

    def fixed_point(choice: Selection, *_: object, weighing: bool = True, **__: object) -> Candidate:
        off = abs(choice.ratio - 4.86) / 0.2 + abs(choice.wider_mm - 0.17) / 0.1
        weighed.extend([choice] if weighing else [])
        return Candidate(cast(Design, None), choice, (90.0,) * 6, Corrections(reference()), 84.0 - off)

    monkeypatch.setattr(search, "fixed_point", fixed_point)
    found = search._polished(fixed_point(Selection(MOTORS[0], "capstan", 5.0, 50.0)))
    assert found.choice.ratio == pytest.approx(4.86, abs=0.02)
    assert found.choice.width_mm == 50.0
    assert found.choice.wider_mm == pytest.approx(0.17, abs=0.02)
    assert weighed[-1] == found.choice

    def hurried(*_: object, **__: object) -> Candidate:
        raise HalfTimeError

    start = fixed_point(Selection(MOTORS[0], "capstan", 5.0, 50.0))
    monkeypatch.setattr(search, "fixed_point", hurried)
    assert search._polished(start) is start  # it is built as it is


def test_what_a_machine_that_came_to_nothing_was_corrected_is_not_the_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """By closed forms 4.9:1 is better; its solids ask for a longer base, and leave less."""
    search = Search(brief())
    key = MOTORS[0], "capstan"
    search.corrections[key] = known = Corrections(reference())

    def fixed_point(
        choice: Selection, *_: object, weighing: bool = True, beats: float | None = None, **__: object
    ) -> Candidate | None:
        if weighing:
            search.corrections[key] = known.raised("base_radius", 40.0, "keys")
        if weighing and beats is not None:
            return None  # 80 mm
        score = 84.0 - abs(choice.ratio - 4.9) - choice.wider_mm
        return Candidate(cast(Design, None), choice, (90.0,) * 6, Corrections(reference()), score)

    monkeypatch.setattr(search, "fixed_point", fixed_point)
    one = fixed_point(Selection(MOTORS[0], "capstan", 5.0, 50.0), weighing=False)
    assert one is not None
    assert search._polished(one) is one
    assert search.corrections[key] is known


def test_what_the_brief_fixes_no_neighbour_changes() -> None:
    one = Selection(MOTORS[0], "capstan", 5.0, 50.0)
    fixed = brief_from_dict({**brief().model_dump(exclude_none=True), "limits": {"parallelogram_width_mm": 50.0}})
    assert {near.width_mm for near in neighbours(brief(), one, 0)} == {44.0, 50.0, 56.0}
    assert {near.width_mm for near in neighbours(fixed, one, 0)} == {50.0}
    small = neighbours(brief(), one, SMALL)
    assert {near.wider_mm for near in small if near.ratio == one.ratio} == {0.1}
    assert {round(near.sector_mm(brief()), 1) for near in small if near.ratio < one.ratio} == {38.3, 39.0}
    assert {near.wider_mm for near in neighbours(brief(), one.with_entry("sector_radius_mm", 40.0), SMALL)} == {0.0}


def test_stopped_in_time_it_begins_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    paper = Paper({MOTORS[0]: [[PASSED]]})
    search = searched(paper, {MOTORS[0]: [84.0]}, monkeypatch)
    search.stop = lambda: True
    with pytest.raises(OutOfTimeError):
        search.best()
    assert paper.moved == []


class Estimates:
    """A search whose estimates fail for some motors; it counts whom it asks."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, fails: set[str], **hardware: Any) -> None:
        requested = {"name": "b", "requirements": {"cube_side_mm": 60.0}, "hardware": hardware, "feel": {}}
        self.search = Search(brief_from_dict(requested))
        self.requested: list[str] = []

        def estimate(choice: Selection, *_: object) -> Found | None:
            self.requested.append(choice.motor)
            return None if choice.motor in fails else Found((90.0, 140.0, 30.0, 20.0, 70.0, 30.0), -120.0)

        def fixed_point(choice: Selection, *_: object, **__: object) -> Candidate:
            return Candidate(
                cast(Design, None), choice, (), Corrections(reference()), -130.0 - len(choice.motor) / 100.0
            )

        monkeypatch.setattr(self.search, "_estimate", estimate)
        monkeypatch.setattr(self.search, "fixed_point", fixed_point)


def test_a_motor_weaker_than_one_that_does_not_do_is_not_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    run = Estimates(monkeypatch, set(MOTORS), motor=MOTORS, drive="capstan")
    assert list(run.search.ranked()) == []
    strongest = max(MOTORS, key=lambda name: motor_of(run.search.brief, name).nominal_torque_N_m)
    assert set(run.requested) == {strongest}
    assert set(run.search.log.no_progress) == {f"{motor} capstan" for motor in MOTORS}


def test_hardware_is_ranked_by_what_its_parts_leave(monkeypatch: pytest.MonkeyPatch) -> None:
    """Estimates are alike; closed forms are not."""
    run = Estimates(monkeypatch, set(), motor=MOTORS, drive="capstan")
    ranked = list(run.search.ranked())
    assert [choice.motor for _, choice in ranked] == sorted(MOTORS, key=len)
    assert [score for score, _ in ranked] == [-130.0 - len(motor) / 100.0 for motor in sorted(MOTORS, key=len)]


def test_a_strong_joint_is_left_a_thousandth_of_its_torque(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its weight follows lengths that change by a percent; of a weak one four ten-thousandths of a newton metre."""
    taken: list[float] = []

    def lengths(_brief: object, _choice: object, corrections: Corrections, *_: object) -> None:
        taken.append(corrections.torque_margin_N_m)

    monkeypatch.setattr(module, "best_lengths", lengths)
    search = Search(brief())
    for motor, ratio in (("maxon-re50-370354", 6.0), ("maxon-re30-310007", 3.0)):
        assert search.fixed_point(Selection(motor, "capstan", ratio, 50.0), weighing=False) is None
    assert taken == [pytest.approx(2.3328e-3), 4e-4]


def test_a_clearance_that_no_machine_has_is_reported_before_anything_is_estimated(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(module, "best_lengths", lambda *_: pytest.fail("was estimated"))
    search = Search(brief(clearance_min_mm=2.5))
    assert search.best() is None
    (why,) = search.log.impossible
    assert "requirements.clearance_min_mm = 2.5 must be at most 2.4 mm" in why
    assert verdict(search.log, "done", stands=False) == (Verdict.INFEASIBLE, why)


def test_a_force_that_no_spring_holds_is_refused_before_anything_is_estimated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "best_lengths", lambda *_: pytest.fail("was estimated"))
    most = force_most_N()
    for forces, name in (({"force_N": 1.01 * most}, "force_N"), ({"peak_force_N": 1.01 * most}, "peak_force_N")):
        search = Search(brief(**forces))
        assert search.best() is None
        (why,) = search.log.impossible
        assert why.startswith(f"requirements.{name} = ")
    assert not list(impossible(brief(force_N=most)))


def test_what_gravity_takes_is_posed_before_anything_is_weighed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of lengths that stay the same; with those of `best_lengths` it takes 0.015 to 0.06 N m, too."""
    first = replace(reference(), gravity_torque_N_m=0.001)
    monkeypatch.setattr(candidates, "reference", lambda: first)
    search = Search(brief())
    torques: list[float] = []

    def seen(_: Selection, corrections: Corrections, *__: Any) -> Found:
        torques.append(corrections.mass_estimate.gravity_torque_N_m)
        return Found((91.0, 143.196, 31.0, 24.0, 64.37, 43.165), 86.33)

    def weighed(_: Design) -> Any:
        raise NoProgressError("weighed")

    monkeypatch.setattr(search, "_lengths", seen)
    monkeypatch.setattr(search, "_weighed", weighed)
    assert search.fixed_point(Selection(MOTORS[0], "capstan", 4.8, 54.0)) is None
    assert search.log.no_progress[f"{MOTORS[0]} capstan"] == "weighed"
    assert torques[0] == 0.001
    assert 0.015 < torques[-1] < 0.06


def test_hardware_without_lengths_is_searched_anew_with_weightless_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of two motors one has no lengths with the masses of another machine, the other fails its checks."""
    search, posed = Search(brief()), list[tuple[str, float, tuple[float, float]]]()

    def lengths(choice: Selection, corrections: Corrections, *_: object) -> None:
        posed.append((choice.motor, corrections.mass_estimate.gravity_torque_N_m, corrections.ball_friction_N))
        if choice.motor == MOTORS[1]:
            raise NoProgressError("the motor's shaft")

    monkeypatch.setattr(search, "_lengths", lengths)
    monkeypatch.setattr("optimizer.codesign.search.drives", lambda _: [(one, "capstan") for one in MOTORS[:2]])

    def best() -> None:
        for motor, drive in search._offered(search.weightless):
            search.fixed_point(Selection(motor, drive, 4.8, 50.0))

    monkeypatch.setattr(search, "_best", best)
    assert search.best() is None
    assert [motor for motor, *_ in posed] == [*MOTORS[:2], MOTORS[0]]
    assert posed[0][1:] == (reference().gravity_torque_N_m, Corrections(reference()).ball_friction_N)
    assert posed[-1][1:] == (0.0, (0.0, 0.0))
    assert not search.weightless


def test_of_no_width_where_lengths_are_found_others_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    search, tried = Search(brief()), list[float]()

    def fixed_point(choice: Selection, *_: object, **__: object) -> None:
        tried.append(choice.width_mm)

    monkeypatch.setattr(search, "fixed_point", fixed_point)
    assert search._fixed_point_near(Selection(MOTORS[0], "capstan", 4.8, 44.0), True) is None
    assert list(dict.fromkeys(tried)) == [44.0, *widths_of(brief())]
