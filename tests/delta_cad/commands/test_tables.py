"""What is shown to a person: equal checks in one line."""

from __future__ import annotations

import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.commands import tables
from delta_cad.commands.pipeline import Outcome
from delta_cad.design import Design


def test_equal_checks_of_the_three_chains_are_one_line() -> None:
    def result(name: str, value: float, passed: bool = True) -> CheckResult:
        return CheckResult(name, passed, value, 1.0, "mm", worst_pair=(name,))

    results = [
        *(result(f"gap sector_{i} / motor_cheek_{i}", 1.2 + i) for i in range(3)),
        *(result(f"contact joint_ball_{i}_{j}_elbow / rod_cup_{i}_{j}_elbow", 0.5) for i in range(3) for j in range(2)),
        *(result(f"solid part_{i}", 0.1) for i in range(4)),
        result("lean", 0.4),
    ]
    groups = tables.grouped(results)
    assert {name: len(found) for name, found in groups.items()} == {
        "gap sector / motor_cheek": 3,
        "contact joint_ball_elbow / rod_cup_elbow": 6,
        "solids": 4,
        "lean": 1,
    }


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
