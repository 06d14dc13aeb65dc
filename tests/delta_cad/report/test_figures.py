"""Checks as lines: the sense of a limit, the margin, what binds, what is asked first."""

from __future__ import annotations

import pytest

from delta_cad.checks.report import CheckResult
from delta_cad.report.figures import binding, failures, kinds, line, plain, requirements, with_unit


@pytest.mark.parametrize(
    ("value", "limit", "passed", "expected"),
    [
        (2.25, 2.5, True, ("≤ 2.5", "+0.25 (10 %)")),
        (2.75, 2.5, False, ("≤ 2.5", "−0.25 (10 %)")),
        (26.0, 20.0, True, ("≥ 20", "+6 (30 %)")),
        (14.0, 20.0, False, ("≥ 20", "−6 (30 %)")),
        (3.0, 0.0, True, ("≥ 0", "+3")),
        (0.0, 0.0, True, ("= 0", "")),
        (5.0, None, True, ("", "")),
    ],
)
def test_sense_and_margin_follow_from_value_and_verdict(
    value: float, limit: float | None, passed: bool, expected: tuple[str, str]
) -> None:
    found = line(CheckResult("x", passed, value, limit, ""))
    assert (found.limit, found.margin) == expected
    assert found.passed is (None if limit is None else passed)


def test_a_check_without_figures_has_its_verdict() -> None:
    assert line(CheckResult("x", True, None, None, "")).passed is True
    assert line(CheckResult("x", False, None, 2.0, "mm")) == line(CheckResult("x", False, None, 2.0, "mm"), "x")
    assert line(CheckResult("x", False, None, 2.0, "mm")).margin == ""


def test_numbers_are_reported_with_their_units() -> None:
    assert with_unit(0.38921, "N m") == "0.3892 N m"
    assert with_unit(4.376522e-05) == "0.00004377"
    assert with_unit(-0.0000048, "N m", 3) == "-0.0000048 N m"
    assert with_unit(1234567.0, "N/mm") == "1235000 N/mm"
    assert with_unit(4.4e-12) == "4.4e-12"
    assert with_unit(125.0, "N/mm^2") == "125 N/mm²"
    assert with_unit(None, "mm") == ""


def test_what_binds_is_closest_as_a_share_of_its_limit() -> None:
    results = [
        CheckResult("far", True, 1.0, 10.0, "mm"),
        CheckResult("gap a_0 / b_0", True, 1.1, 1.0, "mm"),
        CheckResult("gap a_1 / b_1", True, 1.05, 1.0, "mm"),
        CheckResult("tight", True, 0.99, 1.0, ""),
        CheckResult("counted", True, 0.0, 0.0, ""),
        CheckResult("fails", False, 1.01, 1.0, ""),
    ]
    assert [one.words for one in binding(results)] == ["Tight", "Gap a / b"]
    assert binding(results)[1].value == "1.05 mm"
    (kind,) = kinds(results)
    assert [one.words for one in kind.lines][:2] == ["fails", "far"]
    assert "gap a / b (2×)" in [one.words for one in kind.lines]


def test_checks_are_summed_by_kind_and_a_kind_that_fails_comes_first() -> None:
    results = [
        CheckResult("a", True, 1.0, 10.0, "mm", kind="First"),
        CheckResult("b", True, 9.0, 10.0, "mm", kind="First"),
        CheckResult("c", True, 0.0, 0.0, "", kind="Second"),
        CheckResult("d", False, 11.0, 10.0, "mm", kind="Third"),
        CheckResult("e", False, 15.0, 10.0, "mm", kind="Third"),
        CheckResult("f", True, 9.99, 10.0, "mm", kind="Third"),
    ]
    found = kinds(results)
    assert [(one.words, one.passed, one.count) for one in found] == [("Third", 1, 3), ("First", 2, 2), ("Second", 1, 1)]
    assert [one.closest and one.closest.words for one in found] == ["e", "b", None]
    assert [one.words for one in failures(results)] == ["d", "e"]


def test_what_is_required_comes_in_its_order() -> None:
    results = [CheckResult(name, True, 1.0, 2.0, "") for name in ("kappa", "odd", "envelope width", "reach")]
    assert [one.words.split(",")[0].split(":")[0] for one in requirements(results)] == [
        "Reach",
        "Swept outline",
        "Conditioning",
    ]


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("kappa", "Conditioning, worst in the cube"),
        ("structure motor shaft, peak", "Strength: motor shaft, peak"),
        ("dfm walls", "For the shop: walls"),
        ("cable bend ratio", "Drum to cable diameter"),
        ("ball tilt", "Ball tilt"),
    ],
)
def test_a_check_is_named_as_a_customer_reads_it(name: str, words: str) -> None:
    assert plain(name) == words
