"""What is shown to a person."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import cast

import numpy as np
import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.commands import pipeline, tables
from delta_cad.commands.inspection import inspection
from delta_cad.commands.machine import in_steps
from delta_cad.commands.pipeline import Outcome
from delta_cad.commands.tables import print_outcome
from delta_cad.common.console import Step
from delta_cad.design import Design
from delta_cad.mechanism.statics import singular_values


@pytest.fixture(autouse=True)
def good(monkeypatch: pytest.MonkeyPatch) -> None:
    """Machines without masses, none of whose figures of feel is poor."""
    monkeypatch.setattr(pipeline, "poor_figures", lambda *_: [])


@pytest.mark.parametrize("passed", [True, False])
def test_a_poor_device_is_named_so_only_if_it_passes(
    passed: bool, best: Design, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(pipeline, "poor_figures", lambda *_: ["friction 1.1 N, at most 0.6"])
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    outcome = Outcome(best, [CheckResult("lean", passed, 0.4, 1.0, "rad")], masses, None, ())
    tables.print_outcome(outcome)
    first = capsys.readouterr().out.splitlines()[0]
    assert ("poor as a haptic device" in first and "friction 1.1 N, at most 0.6" in first) is passed
    assert outcome.record()["poor"] == ["friction 1.1 N, at most 0.6"] * passed


@pytest.mark.parametrize("unverified", [(), ("motor", "nut_M2.5")])
def test_what_is_not_verified_is_named_in_one_line(
    unverified: tuple[str, ...], best: Design, capsys: pytest.CaptureFixture[str]
) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    tables.print_outcome(Outcome(best, [CheckResult("lean", True, 0.4, 1.0, "rad")], masses, None, unverified))
    lines = [line for line in capsys.readouterr().out.splitlines() if "verified" in line]
    assert lines == (["verify before ordering, data not fully verified: motor, nut_M2.5"] if unverified else [])


@pytest.mark.parametrize("passed", [True, False])
def test_how_the_drive_holds_and_which_way_the_outline_lies_are_reported(
    passed: bool, best: Design, capsys: pytest.CaptureFixture[str]
) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    found = [
        CheckResult(name, passed, 1.0, 1.0, "", detail=f"detail of {name}")
        for name in ("drive torque", "envelope width", "lean")
    ]
    tables.print_outcome(Outcome(best, found, masses, None, ()), whole=True)
    reported = [line for line in capsys.readouterr().out.splitlines() if "detail of" in line]
    if passed:
        assert reported == ["drive torque: detail of drive torque", "envelope width: detail of envelope width"]
    else:  # what fails is told once, by its failure
        assert reported == [f"FAILS {result.name}: {result.detail}" for result in found]


def test_a_figure_that_nothing_is_required_of_has_no_verdict(best: Design, capsys: pytest.CaptureFixture[str]) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    found = [
        CheckResult("told", True, 1.0, None, "Hz"),
        CheckResult("asked", True, 1.0, 2.0, "Hz"),
        CheckResult("plain", True, None, None, ""),
    ]
    tables.print_outcome(Outcome(best, found, masses, None, ()), whole=True)
    lines = {
        name: line
        for line in capsys.readouterr().out.splitlines()
        for name in ("told", "asked", "plain")
        if name in line
    }
    assert {name: "holds" in line for name, line in lines.items()} == {"told": False, "asked": True, "plain": True}


def test_what_fails_comes_first_then_ten_figures_and_the_table_on_demand(
    best: Design, capsys: pytest.CaptureFixture[str]
) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    found = [CheckResult(f"check {k}", True, 1.0, 2.0, "mm") for k in range(40)]
    found += [CheckResult(name, True, 1.0, 2.0, "mm") for name in tables.FIRST_CHECKED]
    found += [CheckResult("broken", False, 3.0, 2.0, "mm", worst_pose_mm=(1.0, 2.0, 3.0), detail="why it is")]
    tables.print_outcome(Outcome(best, found, masses, None, ()))
    lines = capsys.readouterr().out.splitlines()
    assert lines[:2] == [f"{best.name}: 1 of {len(found)} checks FAIL", "FAILS broken at (1.0, 2.0, 3.0) mm: why it is"]
    figures = lines[2 : lines.index("mass 1000 g, moving mass 250 g")]
    assert [line.split()[0] for line in figures][:3] == ["cube", "envelope", "envelope"]
    assert "height" in [line.split()[0] for line in figures]
    assert len(figures) == tables.MOST_FIGURES == 10
    assert figures[1].split()[2:] == ["1", "mm", "<=", "2"]
    tables.print_outcome(Outcome(best, found, masses, None, ()), whole=True)
    reported = capsys.readouterr().out
    assert all(result.name in reported for result in found)
    assert reported.startswith(f"{best.name}: 1 of {len(found)} checks FAIL\nFAILS broken")


def test_units_are_reported_as_people_write_them(monkeypatch: pytest.MonkeyPatch) -> None:
    class Narrow:
        encoding = "ascii"

    assert tables._unit("kg mm^2") == "kg mm²"
    assert tables._unit("N m") == "N m"
    monkeypatch.setattr("sys.stdout", Narrow())
    assert tables._unit("kg mm^2") == "kg mm^2"


def test_no_figure_of_an_inspection_is_in_radians(best: Design) -> None:
    rows = inspection(best)
    assert [row.quantity for row in rows if re.search(r"\brad\b", f"{row.unit} {row.limit}")] == []
    travel = next(row for row in rows if row.quantity == "largest singular value of J")
    assert travel.unit == "mm/deg"
    at = np.array(travel.at_mm) / 1000.0
    expected = 1000.0 * math.radians(1.0) * singular_values(best.geometry, at).max()
    assert travel.value == pytest.approx(expected, rel=1e-3)


def test_phases_of_a_build_are_shown_as_steps_that_never_go_back() -> None:
    shown = list[Step]()
    names = ("loading, checks", "solids", "files")
    show = in_steps(lambda text: shown.append(cast(Step, text)), names)
    for phase in ("loading the CAD kernel", "solid knob", "Fits", "mesh knob", "drawings", "Clearance"):
        show(phase)
    assert [(str(one), one.number, one.of) for one in shown] == [
        ("loading the CAD kernel", 1, 3),
        ("solid knob", 2, 3),
        ("Fits", 3, 3),
        ("mesh knob", 3, 3),
        ("drawings", 3, 3),
        ("Clearance", 3, 3),
    ]
    assert shown[0].name == "loading, checks"
    assert in_steps(print, ()) is print  # a command without steps


def test_the_last_line_is_the_page_to_open(best: Design, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    outcome = Outcome(
        best,
        [CheckResult("lean", True, 0.4, 0.5, "deg")],
        {"total_mass_kg": 1.0, "moving_mass_kg": 0.1},
        tmp_path,
        (),
        None,
    )
    print_outcome(outcome)
    assert "open " not in capsys.readouterr().out  # it was left out
    (tmp_path / "report.html").touch()
    print_outcome(outcome)
    assert capsys.readouterr().out.splitlines()[-1] == f"open {tmp_path / 'report.html'}"
