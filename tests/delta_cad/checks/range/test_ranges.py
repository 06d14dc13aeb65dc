"""Ranges of the mechanism against their limits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.mechanism import (
    DeltaGeometry,
    Extreme,
    conditioning,
    direct_margin,
    inverse_kinematics,
    worst_joint_torque,
)
from delta_cad.mechanism.limits import EffectiveMass, HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.proof import extremes
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS
from tests.delta_cad.mechanism.stated_limits import limits as requested

REQUIRED: dict[str, Any] = {
    "force": 3.0,
    "torque_max": 0.8,
    "lean_max": np.radians(28.0),
    "shoulder": (np.radians(-45.0), np.radians(80.0)),
    "kappa_max": 2.3,
}
MASSES = HandleInertia(0.1, 0.02, 0.005, 500e-6)
GIVEN = replace(LIMITS, pose=requested(**REQUIRED).with_(EffectiveMass(0.6, MASSES)))


def by_name(limits) -> dict[str, CheckResult]:
    return {r.name: r for r in check_ranges(GEOMETRY, limits)}


def test_the_design_keeps_its_ranges() -> None:
    found = by_name(GIVEN)
    assert list(found) == [
        *("reach", "assembly mode", "torque", "kappa", "lean", "shoulder min", "shoulder max", "effective mass"),
    ]
    assert all_passed(found.values())
    # figures of the feasibility study: -39.2..65.5 deg, lean 27.2 deg, 0.316 N m, kappa 2.268
    angles = [found["shoulder min"].value, found["shoulder max"].value]
    assert angles == pytest.approx([-39.2, 65.5], abs=0.1)
    assert found["lean"].value == pytest.approx(27.2, abs=0.05)
    assert found["torque"].value == pytest.approx(0.316, abs=0.001)
    assert found["kappa"].value == pytest.approx(2.268, abs=0.001)
    assert [found[name].unit for name in ("reach", "lean", "torque", "effective mass")] == ["mm", "deg", "N m", "kg"]


def test_the_effective_mass_is_that_of_its_worst_position() -> None:
    found = by_name(GIVEN)["effective mass"]
    at = effective_mass(GEOMETRY, GIVEN.poses_mm() / 1000.0, MASSES).max()
    assert at < found.value < at * (1.0 + 3e-3)  # between two positions of a grid of 11 along an edge
    assert effective_mass(GEOMETRY, np.array(found.worst_pose_mm) / 1000.0, MASSES) == pytest.approx(found.value)


def test_only_what_is_given_is_checked() -> None:
    assert set(by_name(LIMITS)) == {"reach"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("lean", {"lean_max": np.radians(27.0)}),
        ("shoulder min", {"shoulder": (np.radians(-39.0), 1.4)}),
        ("shoulder max", {"shoulder": (-0.8, np.radians(65.0))}),
        ("torque", {"torque_max": 0.315}),
        ("kappa", {"kappa_max": 2.26}),
    ],
)
def test_what_exceeds_its_limit_is_refused(name: str, changes: dict[str, Any]) -> None:
    failed = [r for r in by_name(replace(GIVEN, pose=requested(**REQUIRED | changes))).values() if not r.passed]
    assert [r.name for r in failed] == [name]
    pose = np.array(failed[0].worst_pose_mm)
    assert (np.abs(pose - LIMITS.centre_mm) <= LIMITS.half_side_mm + 1e-9).all()
    assert np.isfinite(inverse_kinematics(GEOMETRY, pose / 1000.0)).all()


def test_a_platform_below_the_elbows_is_a_singular_machine() -> None:
    # the mirror image below the base plane's elbows: det S has the other sign there
    below = DeltaGeometry(0.082, 0.030, 0.060, 0.0605)
    limits = replace(LIMITS, bottom_height_mm=20.0, half_side_mm=1.0, pose=requested())
    found = {r.name: r for r in check_ranges(below, limits)}
    assert found["reach"].passed
    assert found["assembly mode"].passed == (direct_margin(below, limits.poses_mm() / 1000.0).min() > 0.0)


def test_an_unreachable_cube_ends_the_ranges() -> None:
    found = by_name(replace(GIVEN, half_side_mm=80.0))
    assert set(found) == {"reach"}
    assert not found["reach"].passed
    assert (found["reach"].value or 0.0) < 0.0  # how far it is out of reach


def test_a_limit_that_is_the_figure_itself_is_undecided_and_fails() -> None:
    """Nothing proves an inequality that is an equality: here as in `certify`."""
    kappa = by_name(GIVEN)["kappa"]
    same: dict[str, Any] = {"kappa_max": kappa.value}
    at = by_name(replace(GIVEN, pose=requested(**REQUIRED | same)))["kappa"]
    assert not at.passed
    assert at.value == at.limit == kappa.value
    assert "undecided" in at.detail
    x, y, z = kappa.worst_pose_mm or (0.0, 0.0, 0.0)
    worst = f"({x:.4f}, {abs(y):.4f}, {z:.4f}) mm"
    assert worst in at.detail  # the box lies there; a half of the cube is proved, the other is its mirror image
    for share, passed in ((1.0 + 1e-9, True), (1.0 - 1e-9, False)):
        changes: dict[str, Any] = {"kappa_max": (kappa.value or 0.0) * share}
        assert by_name(replace(GIVEN, pose=requested(**REQUIRED | changes)))["kappa"].passed is passed


def test_what_the_search_misses_the_proof_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that knows the centre alone: what breaks is told where the proof saw it, what holds is not doubted."""
    changes: dict[str, Any] = {"kappa_max": 2.0, "torque_max": 0.3}
    tight = replace(GIVEN, pose=requested(**REQUIRED | changes))

    def centre(*given: Any) -> Extreme:
        _, g, limit, figure = given
        x, y, z = tight.centre_mm / 1000.0
        return Extreme(float(figure.worst(limit, g, np.array([x, y, z]))), (x, y, z))

    monkeypatch.setattr(extremes, "worst_of", centre)
    found = by_name(tight)
    assert [name for name, result in found.items() if not result.passed] == ["torque", "kappa"]
    for name, function in (("kappa", conditioning), ("torque", lambda g, p: worst_joint_torque(g, p, 3.0).max())):
        value, limit = found[name].value, found[name].limit
        assert value is not None
        assert limit is not None
        assert value > limit
        assert function(GEOMETRY, np.array(found[name].worst_pose_mm) / 1000.0) == pytest.approx(value, rel=1e-12)


def test_a_value_is_never_beyond_a_limit_that_is_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that is off by roundings of its own: what is proved is known better."""
    monkeypatch.setattr(extremes, "worst_of", lambda *_: Extreme(1e3, (0.0, 0.0, 0.09)))
    found = by_name(GIVEN)
    assert found["kappa"].passed
    assert found["kappa"].value == found["kappa"].limit == 2.3
