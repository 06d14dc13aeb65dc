"""Contacts are tested over the whole range of their joints: a clash between handle samples is found."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.joint_ranges import FoldError
from delta_cad.checks.contact import poses as contacts
from delta_cad.checks.contact.features import is_turned
from delta_cad.checks.contact.fits import check_fits
from delta_cad.checks.contact.poses import TURNS, contact_positions
from delta_cad.mechanism.placement import chain_turn
from delta_cad.solids.part import Fit, Joint
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS, at, box, changed, machine, part, parts, rod, solid


def geared(bump: bool = False, post_rad: float | None = None) -> Assembly:
    """The machine with chain 0's pinion bonded on a shaft of its motor, a bump on the one, a post on the other."""
    whole = machine()
    motor = rod(15, (0, 14, 0), (0, 60, 0)).fuse(rod(3, (0, 11, 0), (0, 14, 0)))
    pinion = parts()["pinion"].solid
    if bump:
        pinion = pinion.fuse(box((5, 9, -0.5), (12, 11, 0.5)))
    if post_rad is not None:
        x, z = 10 * np.cos(post_rad), 10 * np.sin(post_rad)
        motor = motor.fuse(rod(0.5, (x, 9.5, z), (x, 15, z)))
    whole = changed(whole, "pinion_0", part=part("bumped", solid(pinion)))
    whole = changed(whole, "motor_0", part=part("posted", solid(motor)))
    frame = chain_turn(GEOMETRY, 0) @ at(40.0, 0.0, -43.5)
    joint = Joint("pinion_0", "revolute", "base", "pinion_0", frame, np.eye(4))
    fit = Fit("pinion_0", "motor_0", "contact", overlap_mm3=0.01, reason="pinion on the motor's shaft")
    return replace(whole, joints=(*whole.joints, joint), fits=(*whole.fits, fit))


def overlap(a: Assembly):
    return next(r for r in check_fits(a, LIMITS, MeshLibrary(a.parts, 0.1, 0.5)) if r.name == "overlap of contacts")


@pytest.mark.quick(1)
@pytest.mark.parametrize("post_rad", np.radians([0.0, 77.0, 200.0, 311.0]))
def test_a_bump_on_the_pinion_against_a_post_on_the_motor_is_refused(post_rad: float) -> None:
    result = overlap(geared(True, post_rad))
    assert not result.passed
    assert result.worst_pair == ("pinion_0", "motor_0")


@pytest.mark.slow
def test_a_bump_alone_and_a_post_alone_are_no_clash() -> None:
    assert overlap(geared(True)).passed
    assert overlap(geared(False, 1.0)).passed


def test_a_whole_turn_is_tested_only_where_a_turn_changes_something() -> None:
    def count(a: Assembly) -> int:
        return sum(c.fit.a == "pinion_0" for c in contact_positions(a, LIMITS))

    assert count(geared(True, 1.0)) == TURNS >= 24
    assert count(geared(True)) == count(geared(False, 1.0)) == 1


def test_positions_of_a_shoulder_are_those_of_the_placement_and_reach_past_its_extremes() -> None:
    whole = machine()
    names = ("arm_0", "bracket_0")
    for pair in (names, names[::-1]):
        contact = replace(whole, fits=(Fit(pair[0], pair[1], "contact"),))
        found = np.stack([c.b_in_a for c in contact_positions(contact, LIMITS)])
        assert len(found) == TURNS
        placed = whole.poses(LIMITS.poses_mm())
        exact = np.linalg.inv(placed[pair[0]]) @ placed[pair[1]]
        required, got = (np.arctan2(f[:, 2, 0], f[:, 0, 0]) for f in (exact, found))
        assert got.min() <= required.min()
        assert got.max() >= required.max()
        # the positions lie on the same circle as those of the placement
        order = np.argsort(got)
        for k in range(3):
            chord = np.interp(required, got[order], found[order, k, 3])
            assert np.allclose(chord, exact[:, k, 3], atol=0.02)  # sagitta of 3 degrees on a radius of 40 mm


def test_balls_are_tested_where_they_tilt_most() -> None:
    whole = machine()
    found = [c for c in contact_positions(whole, LIMITS) if c.fit.a == "socket_0_0_wrist"]
    placed = whole.poses(LIMITS.poses_mm())
    tilts = []
    for i in range(3):
        relative = np.linalg.inv(placed[f"socket_{i}_0_wrist"]) @ placed[f"stud_{i}_0_wrist"]
        tilts.append(np.abs(relative[:, 0, 1]).max())
    everywhere = [c for c in contact_positions(whole, LIMITS) if c.fit.a.endswith("_0_wrist")]
    assert found
    assert max(abs(c.b_in_a[0, 1]) for c in everywhere) == pytest.approx(max(tilts), abs=1e-9)


def test_a_cube_that_may_fold_a_chain_is_tested_at_any_angle(monkeypatch: pytest.MonkeyPatch) -> None:
    def folds(*_: object) -> None:
        raise FoldError("a chain may fold")

    monkeypatch.setattr(contacts, "joint_ranges", folds)
    contact = replace(machine(), fits=(Fit("arm_0", "bracket_0", "contact"),))
    angles = [np.arctan2(c.b_in_a[2, 0], c.b_in_a[0, 0]) for c in contact_positions(contact, LIMITS)]
    assert np.ptp(angles) > 6.0


def test_bodies_of_revolution_are_known() -> None:
    p = parts()
    assert is_turned(p["shaft"], np.eye(4))
    assert is_turned(p["bearing"], np.eye(4))
    assert not is_turned(p["shaft"], at(0.001))
    assert not is_turned(p["arm"], np.eye(4))
    assert not is_turned(p["screw"], np.eye(4))  # about z
    assert not is_turned(p["stud"], at(1.0))
    half = part("half", rod(4, (0, 0, 0), (0, 5, 0)).cut(box((0, -1, -9), (9, 6, 9))))
    assert not is_turned(half, np.eye(4))
    flat = part("flat", rod(4, (0, 0, 0), (0, 5, 0)).cut(box((3, -1, -9), (9, 6, 9))))
    assert not is_turned(flat, np.eye(4))
