"""Estimated prices of candidates against those of built machines, and the search for the cheapest."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.report import CheckResult
from delta_cad.commands.pipeline import Outcome
from delta_cad.design import Design, design_from_dict, load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.export.shop.cost.cost import machine_cost
from delta_cad.structure.hardware.refusals import refusals
from delta_cad.structure.hardware.suggestion import suggestion
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection, cheapest, direct_alternative, price_EUR, with_direct_drive
from optimizer.codesign.lengths import Found, best_lengths
from optimizer.codesign.relaxation import RESOLUTION, costs
from optimizer.codesign.search import Search
from optimizer.problem.brief import DesignBrief, Goal, brief_from_dict
from tests.committed import COMMITTED, changed
from tests.delta_cad.catalogue.offered import offered

NEAR = 0.04  # share by which an estimate may be off; parts as made differ in clampings and in what grows


def brief(**hardware: Any) -> DesignBrief:
    required = {"cube_side_mm": 80.0, "force_N": 3.0, "clearance_min_mm": 2.0}
    goal = {"minimize": "cost"}
    felt = {"kappa_max": 2.27, "effective_mass_max_kg": 0.4}
    return brief_from_dict(
        {"name": "b", "requirements": required, "feel": felt, "goal": goal, "hardware": hardware}, "b"
    )


def estimate(d: Dimensions) -> float:
    m, c, h = d.design.mechanism, d.design.cube, d.design.hardware
    lengths = (
        m.upper_arm_length_mm, m.forearm_length_mm, m.base_radius_mm, m.platform_radius_mm, c.bottom_height_mm,
        c.half_side_mm,
    )  # fmt: skip
    entries = {name: getattr(h, name) for name in ("encoder", "magnet", "bearing", "knob", "foot", "cable", "tube")}
    choice = Selection(h.motor, h.drive, h.capstan_ratio, m.parallelogram_width_mm, entries)
    return price_EUR(brief(), choice, lengths)


def test_the_joystick_costs_about_what_its_solids_say(best_dimensions: Dimensions, best_assembly: Assembly) -> None:
    made = machine_cost(best_dimensions, best_assembly, {"sector": 3}).total_EUR()
    assert estimate(best_dimensions) == pytest.approx(made, rel=NEAR)


@pytest.mark.slow
def test_a_machine_twice_as_large_too() -> None:
    from delta_cad.assembly.assemble import assemble

    d = dimensions(design_from_dict(changed(**offered()["motor maxon-re50-370354"]), "desk"))
    assert estimate(d) == pytest.approx(machine_cost(d, assemble(d), {"sector": 3}).total_EUR(), rel=NEAR)


def test_a_price_grows_with_motor_and_lengths_and_falls_without_encoders() -> None:
    lengths, task = (91.0, 143.0, 31.0, 24.0, 64.0, 40.0), brief()
    choice = Selection("maxon-re30-310007", "capstan", 4.8, 54.0)
    price = price_EUR(task, choice, lengths)
    assert price_EUR(task, choice.with_(motor="maxon-re25-118752"), lengths) == pytest.approx(price - 3 * 70.0)
    assert price_EUR(task, choice, (101.0, *lengths[1:])) > price
    reported = choice.with_entry("encoder_at", "motor")
    assert price - price_EUR(task, reported, lengths) == pytest.approx(3 * row_EUR(task, choice))


def row_EUR(task: DesignBrief, choice: Selection) -> float:
    """An encoder and its magnet."""
    prices = {"as5048a-board": 18.0, "as5047p-board": 16.0, "mt6835-board": 12.0, "mt6825-board": 10.0}
    return prices[choice.stated(task, "encoder")] + 2.0


def test_the_cheapest_of_what_may_be_used_is_taken() -> None:
    assert cheapest(brief(encoder=["as5048a-board", "mt6825-board", "mt6835-board"], tube="cfrp-5x3")) == {
        "encoder": "mt6825-board"
    }
    assert cheapest(brief()) == {}


def test_the_least_machine_of_a_choice_is_scored_by_its_price() -> None:
    choice, corrections = (
        Selection("maxon-re30-310007", "capstan", 4.8, 50.0),
        Corrections(replace(reference(), own=True)),
    )
    found = best_lengths(brief(), choice, corrections, (88.0, 140.0, 31.0, 24.0, 62.0, 40.0), rounds=1)
    assert found is not None
    assert found.side_mm == 80.0
    assert -found.score == pytest.approx(price_EUR(brief(), choice, found.lengths_mm))


class Cheap(Search):
    """A search whose machines are not made: every candidate of closed forms passes, at 1.1 times its estimate."""

    def fixed_point(self, choice: Selection, *_: object, **__: object) -> Candidate | None:
        self.log.candidates += 1
        lengths = (91.0, 143.0, 31.0, 24.0, 64.0, 40.0)
        score = -price_EUR(self.brief, choice, lengths) - 10.0 * abs(choice.ratio - 4.8)
        return Candidate(None, choice, lengths, Corrections(reference()), score)  # type: ignore[arg-type]

    def _estimate(self, choice: Selection, start_mm: Any = None) -> Any:
        del start_mm
        return self.fixed_point(choice)


def test_a_cost_goal_finds_a_cheaper_machine_than_the_default(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two motors and two encoders: the cheaper of each is found, and its price is that of the build."""
    monkeypatch.setattr("optimizer.codesign.lengths.effective_mass_kg", lambda _: 1.0)
    required = brief(
        motor=["maxon-re30-310007", "faulhaber-3257g024cr"], drive="capstan", encoder=["as5048a-board", "mt6825-board"]
    )
    passed = [CheckResult("a", True, 1.0, 2.0, "")]
    search: Cheap

    def build(design: Design) -> Outcome:
        assert search.built_candidate is not None
        return Outcome(design, passed, {}, None, (), -1.1 * search.built_candidate.score)

    search = Cheap(required, build, lambda _: passed)
    best = search.best()
    assert best is not None
    candidate, outcome = best
    assert candidate.choice.motor == "faulhaber-3257g024cr"
    assert candidate.choice.entries["encoder"] == "mt6825-board"
    assert -candidate.score == outcome.cost_EUR
    assert search.dearer == pytest.approx(1.1)
    default = Selection("maxon-re30-310007", "capstan", 4.8, 50.0)
    assert -candidate.score / 1.1 < price_EUR(required, default, candidate.lengths_mm)


@pytest.mark.parametrize(
    ("objective", "names", "unit"),
    [("outline", ("envelope width", "envelope depth"), "mm"), ("effective_mass", ("effective mass",), "kg")],
)
def test_what_is_reported_of_a_build_ranks_it(
    objective: str, names: tuple[str, ...], unit: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The likelier motor turns out worse as a machine than by its lengths: the other one is the answer."""
    monkeypatch.setattr("optimizer.codesign.lengths.effective_mass_kg", lambda _: 1.0)
    motors = ["maxon-re30-310007", "faulhaber-3257g024cr"]
    required = brief(motor=motors, drive="capstan").model_copy(update={"goal": Goal(minimize=objective)})  # type: ignore[arg-type]
    at = {motors[0]: (1.0, 1.2), motors[1]: (1.05, 1.0)}  # estimate, and what its build reports for each

    class Known(Search):
        def fixed_point(self, choice: Selection, *_: object, **__: object) -> Candidate | None:
            lengths = (91.0, 143.0, 31.0, 24.0, 64.0, 40.0)
            named = SimpleNamespace(
                hardware=SimpleNamespace(motor=choice.motor), cube=SimpleNamespace(half_side_mm=1.0)
            )
            score = -len(names) * at[choice.motor][0] * (1.0 + 0.01 * abs(choice.ratio - 4.8))
            return Candidate(cast(Design, named), choice, lengths, Corrections(reference()), score)

        def _estimate(self, choice: Selection, start_mm: Any = None) -> Any:
            del start_mm
            return self.fixed_point(choice)

    def build(design: Design) -> Outcome:
        value = at[design.hardware.motor][1]
        return Outcome(design, [CheckResult(name, True, value, 9.0, unit) for name in names], {}, None, ())

    search = Known(required, build, lambda _: [])
    best = search.best()
    assert best is not None
    assert best[0].choice.motor == motors[1]
    assert -best[0].score == pytest.approx(len(names) * 1.0)


def test_a_limit_costs_what_the_search_resolves_or_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    required = brief().model_copy(update={"goal": Goal(minimize="outline")})
    lengths = (91.0, 143.0, 31.0, 24.0, 64.0, 40.0)
    candidate = Candidate(
        cast(Design, None),
        Selection("maxon-re30-310007", "capstan", 4.8, 50.0),
        lengths,
        Corrections(reference()),
        -400.0,
    )
    gains = {"feel.kappa_max": 1.9 * RESOLUTION * 400.0, "requirements.force_N": 0.9 * RESOLUTION * 400.0}

    def searched(task: DesignBrief, *_: object) -> Found:
        more = (
            required.feel.kappa_max != task.feel.kappa_max,
            required.requirements.force_N != task.requirements.force_N,
        )
        return Found(lengths, -400.0 + sum(gain for gain, eased in zip(gains.values(), more, strict=True) if eased))

    monkeypatch.setattr("optimizer.codesign.relaxation.best_lengths", searched)
    (one,) = costs(required, candidate, Corrections(reference()))
    assert (one.field, one.gain) == ("feel.kappa_max", pytest.approx(gains["feel.kappa_max"]))


def test_the_direct_drive_that_is_reported_passes_the_closed_forms(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of one motor: the lengths of the sentence make a machine that nothing refuses; without it none serves."""
    key, rows = "maxon-ec60flat-625858", dict(catalogue.motor.rows)
    design = load_design(COMMITTED)
    found: list[Any] = []

    def suggested(one: Design) -> Any:
        result = suggestion(one)
        found.extend([result] if result is not None else [])
        return result

    monkeypatch.setattr("optimizer.codesign.hardware.suggestion", suggested)
    capstans = {name: row for name, row in rows.items() if "direct" not in row.drives}
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", capstans | {key: rows[key]})
    text = direct_alternative(brief(), design)
    (one,) = found
    assert refusals(one.design) == ()
    assert (one.design.hardware.drive, one.design.hardware.motor) == ("direct", key)
    assert text.startswith(f"A direct drive is simpler and serves, too: with {key} about ")
    assert all(f"{field} {value:.4g}" in text for field, value in one.values.items() if isinstance(value, float))
    assert direct_alternative(brief(), with_direct_drive(design, rows[key])) == ""
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", capstans)
    assert direct_alternative(brief(), design).startswith("A direct drive does not serve")
