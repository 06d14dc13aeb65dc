"""Requirements that a proof excludes: never what a machine can do, and with a bound that is one."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.common.units import MM_PER_M
from delta_cad.design import load_design
from optimizer.codesign.bound import excluded, relaxed
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import best_lengths
from optimizer.codesign.search import Search
from optimizer.problem.brief import DesignBrief, brief_from_dict, load_brief
from optimizer.problem.extremes import design_worst
from optimizer.problem.variables import PER_SI, completed, variables_mm
from optimizer.search.active_set import ROUNDING
from tests.committed import ROOT

GALLERY, SIZES = ROOT / "docs/gallery", ROOT / "tests/references/sizes"


def brief(width: float, depth: float, **requested: Any) -> DesignBrief:
    """Of three-fold symmetric machines, which a proof excludes; what it says of placed ones is in test_placement."""
    outline = {"envelope_width_mm": width, "envelope_depth_mm": depth}
    feel = {"feel": requested.pop("feel")} if "feel" in requested else {}
    return brief_from_dict({"name": "b", "placement": "symmetric", "requirements": outline | requested} | feel)


def least_margin(given: DesignBrief, lengths_mm: tuple[float, ...]) -> float:
    """The least of all margins of a machine in the problem that is to exclude no machine."""
    problem, lengths = relaxed(given), completed(lengths_mm)
    design = lengths / PER_SI
    closed = [float(margin[0]) for margin in problem.design_margins(design[None]).values()]
    worst = [float(one.values[0]) for one in design_worst(problem, design, 9).values()]
    inside = np.minimum(lengths - np.array(problem.lower), np.array(problem.upper) - lengths)
    return min(*closed, *worst, float(inside.min()) / MM_PER_M)


@pytest.mark.parametrize(
    ("task", "design"),
    [
        (ROOT / "joystick.toml", ROOT / "tests/references/symmetric-83.json"),
        (SIZES / "pocket-40.toml", GALLERY / "pocket-40.json"),
        (SIZES / "desk-150.toml", GALLERY / "desk-150.json"),
    ],
)
def test_no_machine_that_was_built_is_excluded(task: Path, design: Path) -> None:
    made = load_design(design)
    m, cube = made.mechanism, made.cube
    lengths = variables_mm(m.model_dump(), cube.model_dump())
    given = load_brief(task)
    requested = given.requirements.model_copy(update={"cube_side_mm": 2.0 * cube.half_side_mm})
    for placement in (None, "symmetric"):
        one = given.model_copy(update={"requirements": requested, "placement": placement})
        assert least_margin(one, lengths) >= -ROUNDING


@pytest.mark.parametrize(
    ("motor", "drive", "ratio", "width"),
    [
        ("maxon-re30-310007", "capstan", 4.0, 50.0),
        ("faulhaber-3257g024cr", "capstan", 9.0, 36.0),
        ("maxon-ec60flat-625858", "direct", 1.0, 50.0),
    ],
)
def test_no_lengths_that_a_search_finds_are_excluded(motor: str, drive: str, ratio: float, width: float) -> None:
    given = brief(300, 250, force_N=2.0, feel={"effective_mass_max_kg": 0.6, "friction_max_N": 1.0})
    found = best_lengths(given, Selection(motor, drive, ratio, width), Corrections(reference()), rounds=1)
    assert found is not None
    assert least_margin(given, found.lengths_mm) >= -ROUNDING
    at_most = found.side_mm / 2.0
    assert at_most > 20.0  # a machine, and not the next to nothing that any outline holds


@pytest.mark.parametrize(
    ("given", "field", "requested"),
    [
        (brief(80, 70), "requirements.envelope_width_mm", 80.0),
        (brief(80, 70, cube_side_mm=60), "requirements.envelope_width_mm", 80.0),
        (brief(240, 200, cube_side_mm=150), "requirements.cube_side_mm", 150.0),
    ],
)
def test_what_is_excluded_is_reported_with_field_bound_and_family(
    given: DesignBrief, field: str, requested: float
) -> None:
    reported = excluded(given)
    assert reported.startswith(f"{field} ")
    bound = float(re.findall(r"must be [<>] ([0-9.]+)", reported)[0])
    assert bound > requested if "> " in reported else bound < requested
    for words in ("three equal chains at 120 degrees", "any motor of the catalogue", "at least 21 mm wide"):
        assert words in reported
    if field.endswith("cube_side_mm"):  # a little more than the bound is excluded, too, and a good deal less is not
        task = given.requirements
        for side, none in ((bound * 1.001, True), (0.75 * bound, False)):
            changed = given.model_copy(update={"requirements": task.model_copy(update={"cube_side_mm": side})})
            assert bool(excluded(changed)) == none


def test_nothing_is_excluded_where_the_outline_is_free_or_a_machine_stands() -> None:
    assert excluded(brief_from_dict({"name": "b", "requirements": {"cube_side_mm": 290.0}})) == ""
    assert excluded(load_brief(ROOT / "joystick.toml")) == ""


def test_a_search_ends_at_once_with_what_is_excluded() -> None:
    search = Search(brief(80, 70))
    assert search.best() is None
    assert search.log.candidates == 0
    (reason,) = search.log.impossible
    assert "envelope_width_mm and envelope_depth_mm = 80 and 70" in reason
