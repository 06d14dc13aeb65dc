"""Parts on one link that run into each other, and contacts that are too deep, are refused; coincident faces are not."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact import fits, shared_volume
from delta_cad.checks.contact.fits import check_fits
from delta_cad.checks.contact.shared_volume import common_volume
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Fit
from tests.delta_cad.checks.machines import LIMITS, at, ball, box, changed, machine, placement, rod

MACHINE = machine()
MESHES = MeshLibrary(MACHINE.parts, 0.1, 0.5)


def check(a: Assembly) -> dict[str, CheckResult]:
    return {r.name: r for r in check_fits(a, LIMITS, MESHES)}


def test_the_machine_fits_together() -> None:
    found = check(MACHINE)
    assert all(r.passed for r in found.values()), found
    # the shafts in their arms' bores and the studs on their bars share faces, and were looked at
    assert "0 pairs" not in found["overlap on one link"].detail


def test_overlapping_parts_on_one_link_are_refused() -> None:
    found = check(changed(MACHINE, "screw_2", placement=at(50, -50.3, -72)))
    result = found["overlap on one link"]
    assert not result.passed
    assert result.worst_pair == ("base_plate", "screw_2")
    radius, moved = 1.25, 0.3  # the shank less what it shares with its 8 mm deep bore
    lens = 2 * radius**2 * np.arccos(moved / 2 / radius) - moved / 2 * np.sqrt(4 * radius**2 - moved**2)
    assert result.value == pytest.approx(8.0 * (np.pi * radius**2 - lens), rel=1e-6)


def test_a_part_inside_another_on_one_link_is_refused() -> None:
    found = check(changed(MACHINE, "screw_1", placement=at(40, 18, -69)))
    assert not found["overlap on one link"].passed


def test_equal_pairs_are_computed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    monkeypatch.setattr(fits, "common_volume", lambda *given: calls.append(given) or 0.0)
    check(MACHINE)
    assert 0 < len(calls) < 60  # about three times as many pairs touch


@pytest.mark.slow
def test_a_contact_that_is_too_deep_is_refused_and_an_allowance_is_kept() -> None:
    moved = changed(MACHINE, "shaft_1", placement=at(0.3, 0.0, 0.0))
    result = check(moved)["overlap of contacts"]
    assert not result.passed
    assert result.worst_pair == ("shaft_1", "bearing_1")
    allowed = tuple(replace(f, overlap_mm3=50.0) if f.a == "shaft_1" else f for f in MACHINE.fits)
    assert check(replace(moved, fits=allowed))["overlap of contacts"].passed


def test_contact_on_one_link_may_say_how_much_it_overlaps() -> None:
    pressed = changed(MACHINE, "screw_2", placement=at(50, -50.3, -72))
    fit = Fit("base_plate", "screw_2", "contact", overlap_mm3=6.0, reason="thread")
    assert check(replace(pressed, fits=(*MACHINE.fits, fit)))["overlap on one link"].passed


def test_fits_of_unknown_names_or_kinds_are_refused() -> None:
    for fit, reported in ((Fit("arm_0", "nothing", "contact"), "nothing"), (Fit("arm_0", "arm_1", "glued"), "glued")):
        (result,) = check(replace(MACHINE, fits=(fit,))).values()
        assert not result.passed
        assert reported in result.detail


def test_the_rotor_of_a_direct_drive_may_not_run_into_its_arm() -> None:
    direct = machine(1.0)
    found = {r.name: r for r in check_fits(direct, LIMITS, MESHES)}
    assert direct.placement == placement(1.0)
    # the pinion of this machine stands in the shaft: as one rigid body with the arm it is found
    assert not found["overlap on one link"].passed
    assert any("pinion" in name for name in found["overlap on one link"].worst_pair or ())


@pytest.mark.parametrize("angle", [0.0, 0.7, np.pi / 2])
def test_coincident_cylinders_share_nothing(angle: float) -> None:
    turn = np.eye(4)
    turn[1:3, 1:3] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    seat = box((-10, -10, -10), (10, 10, 10)).cut(rod(4, (-10, 0, 0), (10, 0, 0))).Solids()[0]
    assert common_volume(seat, rod(4, (-10, 0, 0), (10, 0, 0)), turn) == pytest.approx(0.0, abs=1e-6)
    assert common_volume(seat, rod(4.1, (-10, 0, 0), (10, 0, 0)), turn) == pytest.approx(
        20 * np.pi * (4.1**2 - 16), rel=1e-6
    )


def test_common_volumes_in_closed_form() -> None:
    assert common_volume(box((0, 0, 0), (2, 2, 2)), box((0, 0, 0), (2, 2, 2)), at(1, 1, 1)) == pytest.approx(1.0)
    assert common_volume(ball(3), ball(1), at(0.5)) == pytest.approx(4 / 3 * np.pi, rel=1e-6)
    assert common_volume(ball(3), ball(1), at(9)) == 0.0


def test_volumes_that_a_fixed_rule_gets_wrong_are_taken_again(monkeypatch: pytest.MonkeyPatch) -> None:
    def crude(shape: object) -> float:  # beside a helix it errs by what faces a boolean leaves
        return (1.0 + 1e-4 * len(cq.Shape.cast(shape).Faces())) * shared_volume.fine_volume(shape)

    monkeypatch.setattr(shared_volume, "volume", crude)
    assert common_volume(box((0, 0, 0), (2, 2, 2)), box((0, 0, 0), (2, 2, 2)), at(1, 1, 1)) == pytest.approx(1.0)


@pytest.mark.slow
def test_a_kernel_that_contradicts_itself_is_a_failure(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shared_volume, "_boolean", lambda *_: 1.0)  # common and rest cannot both be 1 mm^3
    assert common_volume(box((0, 0, 0), (2, 2, 2)), box((0, 0, 0), (2, 2, 2)), at(1, 1, 1)) is None
    result = check(MACHINE)["overlap on one link"]
    assert not result.passed
    assert result.value is None
    monkeypatch.setattr(shared_volume, "_boolean", lambda *_: None)
    assert common_volume(box((0, 0, 0), (2, 2, 2)), box((0, 0, 0), (2, 2, 2)), at(1, 1, 1)) is None


def test_an_assembly_without_neighbours_passes() -> None:
    lonely = replace(MACHINE, occurrences=MACHINE.occurrences[:1], fits=())
    assert all(r.passed for r in check(lonely).values())
