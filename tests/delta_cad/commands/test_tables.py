"""What is shown to a person."""

from __future__ import annotations

import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.commands import tables
from delta_cad.commands.pipeline import Outcome
from delta_cad.design import Design


@pytest.mark.parametrize("unverified", [(), ("motor", "nut_M2.5")])
def test_what_is_not_verified_is_named_in_one_line(
    unverified: tuple[str, ...], best: Design, capsys: pytest.CaptureFixture[str]
) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    tables.print_outcome(Outcome(best, [CheckResult("lean", True, 0.4, 1.0, "rad")], masses, None, unverified))
    lines = [line for line in capsys.readouterr().out.splitlines() if "verified" in line]
    assert lines == (["check before ordering, not all data verified: motor, nut_M2.5"] if unverified else [])


@pytest.mark.parametrize("passed", [True, False])
def test_how_the_drive_holds_and_which_way_the_outline_lies_are_told(
    passed: bool, best: Design, capsys: pytest.CaptureFixture[str]
) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    found = [
        CheckResult(name, passed, 1.0, 1.0, "", detail=f"detail of {name}")
        for name in ("drive torque", "envelope width", "lean")
    ]
    tables.print_outcome(Outcome(best, found, masses, None, ()))
    told = [line for line in capsys.readouterr().out.splitlines() if "detail of" in line]
    if passed:
        assert told == ["drive torque: detail of drive torque", "envelope width: detail of envelope width"]
    else:  # what fails is told once, by its failure
        assert told == [f"FAILS {result.name}: {result.detail}" for result in found]


def test_a_figure_that_nothing_is_asked_of_has_no_verdict(best: Design, capsys: pytest.CaptureFixture[str]) -> None:
    masses = {"total_mass_kg": 1.0, "moving_mass_kg": 0.25}
    found = [
        CheckResult("told", True, 1.0, None, "Hz"),
        CheckResult("asked", True, 1.0, 2.0, "Hz"),
        CheckResult("plain", True, None, None, ""),
    ]
    tables.print_outcome(Outcome(best, found, masses, None, ()))
    lines = {
        name: line
        for line in capsys.readouterr().out.splitlines()
        for name in ("told", "asked", "plain")
        if name in line
    }
    assert {name: "holds" in line for name, line in lines.items()} == {"told": False, "asked": True, "plain": True}
