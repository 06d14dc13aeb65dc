"""Results beside set limits, and the page that `design` leaves: candidates, bound, what binds, what limits cost."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.holding import holding_torque, moving_bodies
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.mechanism.statics import worst_joint_torque
from optimizer.codesign.bound import Bound, Kind
from optimizer.codesign.hardware import Selection
from optimizer.codesign.page import round_values
from optimizer.codesign.relaxation import Cost
from optimizer.codesign.report import FIGURES, DesignReport, binding, force_N, results_of, set_limits
from optimizer.codesign.search_log import SearchLog, Trial
from optimizer.problem.brief import DesignBrief, brief_from_dict
from tests.delta_cad.report.reading import Page


def brief(**tables: dict[str, Any]) -> DesignBrief:
    required = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0} | tables.pop("requirements", {})
    return brief_from_dict({"name": "b", "requirements": required, **tables})


def test_a_force_takes_all_of_the_torque_next_to_the_weight_somewhere_and_no_more_anywhere(
    best: Design, best_assembly: Assembly, best_masses: dict[str, Any]
) -> None:
    """Against torques on a grid over the cube, by the weight of all bodies and the worst direction of a force."""
    masses, torque = best_masses, best.requirements.joint_torque_N_m
    force = force_N(best, masses, torque)
    axis = np.linspace(-1.0, 1.0, 21) * best.cube.half_side_mm
    middle = best.cube.bottom_height_mm + best.cube.half_side_mm
    p = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3) + np.array([0.0, 0.0, middle])
    weight = np.abs(holding_torque(best_assembly, moving_bodies(masses), p, np.array(best.requirements.gravity_m_s2)))
    per_N = worst_joint_torque(best.geometry, p / MM_PER_M, 1.0)
    on_grid = float(np.min((torque - weight) / per_N))
    assert force <= on_grid
    assert force == pytest.approx(on_grid, rel=2e-3)
    assert force_N(best, masses, 1e-6) == 0.0


def test_all_that_is_always_reported_is_known_of_a_machine_without_limits(
    best: Design, best_masses: dict[str, Any]
) -> None:
    bare = best.requirements.model_copy(
        update=dict.fromkeys(("effective_mass_max_kg", "friction_max_N", "stiffness_min_N_mm", "peak_force_N"))
    )
    outcome = SimpleNamespace(
        design=best.model_copy(update={"requirements": bare}),
        masses=best_masses,
        results=[CheckResult("kappa", True, 2.5, None, "")],
    )
    values = results_of(cast(Any, outcome))
    limits = best.requirements.model_dump()
    assert {one.key for one in FIGURES if one.head} <= set(values)
    assert values["kappa_max"] == 2.5  # a check's figure is that of the check
    assert limits["force_N"] <= values["force_N"] < values["peak_force_N"]
    for key in ("effective_mass_max_kg", "friction_max_N"):
        assert 0.0 < values[key] <= (limits[key] or 2.0)


def test_what_binds_are_limits_that_the_file_sets() -> None:
    """0.69 N of friction bind where 0.695 are set; not where nothing is; 2 mm of clearance are a default."""
    values = {"friction_max_N": 0.69, "force_N": 3.0, "clearance_mm": 2.0, "kappa_max": 2.27}
    task = brief(feel={"friction_max_N": 0.695, "kappa_max": 3.0})
    assert [one.figure.field for one in binding(task, values)] == ["feel.friction_max_N"]
    assert [one.figure.field for one in set_limits(task, values)] == ["feel.kappa_max", "feel.friction_max_N"][::-1]
    assert binding(brief(), values) == []
    task = brief(requirements={"force_N": 3.0, "clearance_min_mm": 1.0})
    assert [one.figure.field for one in binding(task, values)] == ["requirements.force_N"]


def test_a_limit_of_the_first_edition_is_set_where_a_brief_has_it() -> None:
    task = brief(limits={"kappa_max": 2.28})
    assert [one.figure.field for one in binding(task, {"kappa_max": 2.27})] == ["feel.kappa_max"]


def test_every_limit_of_a_figure_is_a_field_of_the_requirements_and_of_one_figure() -> None:
    fields = [one.field for one in FIGURES if one.field]
    assert len(set(fields)) == len(fields)
    for name in fields:
        brief().value(name)  # a field of the requirements


BAD = "<b>&'\""
REPORTED: dict[str, Any] = dict.fromkeys(one.key for one in FIGURES) | {
    "name": BAD,
    "outline_mm": [248.3, 219.9],
    "cube_side_mm": 82.52,
    "ratio": 5.03,
    "motor": "small",
    "bound_mm": 83.61,
    "gap": 0.0132,
    "cost_EUR": None,
    "placement": None,
    "tried": 31,
    "built": 2,
    "poor": [],
    "force_N": 3.004,
    "kappa_max": 2.268,
    "friction_max_N": 0.1,
    "height_mm": 271.3,
}
BOUND = Bound(83.61, 0.0132, 12, Kind(50.0, "small motors", "kept limits", False, 30.74, (9.8, 12.9)), ("alike",))
BRIEF = brief_from_dict(
    {
        "name": "b",
        "requirements": {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0},
        "feel": {"kappa_max": 2.27, "friction_max_N": 0.8},
    }
)
POSED = [
    Trial(Selection("large", "capstan", 4.0, 50.0), 70.0),
    Trial(Selection("small", "capstan", 5.0, 50.0), 82.0),
    Trial(Selection("small", "capstan", 5.1, 50.0), 82.9, ("clearance", BAD)),
    Trial(Selection("small", "capstan", 5.03, 50.0), 82.52, ()),
]


def page(
    posed: list[Trial],
    bound: Bound | None,
    objective: str = "cube_side",
    why: tuple[str, ...] = ("it was tight",),
    **wording: Any,
) -> Page:
    log = SearchLog(31, posed, [], {f"weak {BAD}": "too weak"})
    cost = [Cost("feel.kappa_max", 2.27, 2.38, 1.5)]
    facts = REPORTED | wording | {"objective": objective}
    return Page(DesignReport(BRIEF, facts, log, why, [], cost, bound).html())


def test_every_candidate_is_a_dot_where_its_figure_and_its_motor_are() -> None:
    found = page(POSED, BOUND)
    dots = [e for e in found.all("circle") if "cx" in e.attributes][: len(POSED)]
    assert [e.attributes["class"] for e in dots] == ["posed", "posed", "failed", "passed"]
    assert "small capstan at 5.1:1, 50 mm wide: 82.9 mm of cube; fails clearance, <b>&'\"" in dots[2].text
    across = [float(e.attributes["cx"]) for e in dots]
    (proved,) = found.all("line", **{"class": "proved"})
    low, high, ends = across[0], float(proved.attributes["x1"]), (70.0, 83.61)
    for x, value in zip(across, (70.0, 82.0, 82.9, 82.52), strict=True):
        assert x == pytest.approx(low + (high - low) * (value - ends[0]) / (ends[1] - ends[0]), abs=0.2)
    down = [float(e.attributes["cy"]) for e in dots]
    assert down[1] == down[2] == down[3] < down[0]  # what comes farthest first
    names = [e.text for e in found.all("text") if e.attributes["x"] == "8"]
    assert names == ["small capstan", "large capstan"]


def test_it_says_what_binds_what_limits_cost_and_what_is_proved_and_runs_nothing() -> None:
    found = page(POSED, BOUND)
    assert [row[:3] for row in found.rows("binds")[1:]] == [["feel.kappa_max", "2.268", "≤ 2.27"]]
    assert found.rows("costs")[1][:4] == ["feel.kappa_max", "2.27", "2.38", "1.5"]
    assert "83.61 mm, 1.3 % more" in found.one("tried").text
    assert "it was tight" in found.one("learnt").text
    assert found.all("script") == found.all("b") == []
    assert next(e.attributes["href"] for e in found.all("a")) == "report.html"
    family = ("120 degrees, the cube on their axis", "50 mm wide", "30.74 mm", "9.8 and 12.9 mm", "small motors")
    assert all(words in found.one("tried").text for words in (*family, "kept limits", "alike"))
    assert all(words not in page(POSED, None).one("tried").text for words in (family[0], "no machine"))


def test_where_nothing_failed_no_lesson_is_announced() -> None:
    found = page(POSED, None, why=())
    assert "Corrections" not in "".join(e.text for e in [*found.all("h2"), *found.all("a")])


@pytest.mark.parametrize("posed", [[], POSED[:1], [Trial(POSED[0].choice, -0.34)]])
def test_few_candidates_and_those_of_which_less_is_better_are_drawn(posed: list[Trial]) -> None:
    dots = page(posed, None, "effective_mass").all("circle")
    for one, dot in zip(posed, dots, strict=False):  # those of the key come after them
        assert f"{abs(one.score):.4g} kg effective mass" in dot.text


@pytest.mark.parametrize(("low", "high", "first", "step"), [(69.3, 84.3, 70.0, 2.0), (0.31, 0.36, 0.31, 0.01)])
def test_ticks_are_round(low: float, high: float, first: float, step: float) -> None:
    ticks = round_values(low, high)
    assert 3 <= len(ticks) <= 9
    assert ticks[0] == pytest.approx(first)
    assert ticks[1] - ticks[0] == pytest.approx(step)
    assert low <= ticks[0] <= ticks[-1] <= high


def test_a_machine_that_is_poor_has_an_amber_badge_that_says_in_what() -> None:
    good, poor = page(POSED, None), page(POSED, None, poor=["friction 0.9 N, at most 0.6"])
    assert [len(one.all("p", **{"class": "badge holds"})) for one in (good, poor)] == [1, 0]
    (badge,) = poor.all("p", **{"class": "badge poor"})
    assert "friction 0.9 N, at most 0.6" in badge.text


def test_force_friction_and_height_stand_in_the_headline_whether_a_limit_is_set_or_not() -> None:
    cards = " ".join(e.text for e in page(POSED, None).all("div", **{"class": "card"}))
    for words in ("Continuous force3 N", "Friction0.1 N", "Height271 mm"):
        assert words in "".join(cards.split("\n"))
