"""Results as a person reads them: equal checks in one line, what is closest to its limit first."""

from __future__ import annotations

from delta_cad.checks.report import CheckResult, closeness, grouped


def test_equal_checks_of_the_three_chains_are_one_line() -> None:
    def result(name: str, value: float, passed: bool = True) -> CheckResult:
        return CheckResult(name, passed, value, 1.0, "mm", worst_pair=(name,))

    results = [
        *(result(f"gap sector_{i} / motor_cheek_{i}", 1.2 + i) for i in range(3)),
        *(result(f"contact joint_ball_{i}_{j}_elbow / rod_cup_{i}_{j}_elbow", 0.5) for i in range(3) for j in range(2)),
        *(result(f"solid part_{i}", 0.1) for i in range(4)),
        result("lean", 0.4),
    ]
    groups = grouped(results)
    assert {name: len(found) for name, found in groups.items()} == {
        "gap sector / motor_cheek": 3,
        "contact joint_ball_elbow / rod_cup_elbow": 6,
        "solids": 4,
        "lean": 1,
    }


def test_failures_come_first_then_what_is_closest() -> None:
    results = [
        CheckResult("far", True, 1.0, 9.0, "mm"),
        CheckResult("near", True, 8.0, 9.0, "mm"),
        CheckResult("counted", False, None, None, ""),
        CheckResult("over", False, 9.5, 9.0, "mm"),
    ]
    assert [r.name for r in sorted(results, key=closeness)] == ["counted", "over", "near", "far"]
