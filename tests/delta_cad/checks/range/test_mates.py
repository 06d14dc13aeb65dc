"""Mating patterns of machines as they are drawn, and of machines with one thing drawn otherwise that break each."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range import mates
from delta_cad.checks.range.mates import check_mates
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Bore, Hole, Part, Slot

Change = Callable[[Bore], Bore]


MOTOR = "motor and motor cheek"


def results(assembly: Assembly) -> dict[str, CheckResult]:
    return {one.name: one for one in check_mates(assembly)}


def with_part(assembly: Assembly, number: str, change: Callable[[Part], Part]) -> Assembly:
    """The machine with one part's record otherwise; its solid stays."""
    changed = {o.part.number: change(o.part) for o in assembly.occurrences if o.part.number == number}
    assert changed
    every = (replace(o, part=changed.get(o.part.number, o.part)) for o in assembly.occurrences)
    return replace(assembly, occurrences=tuple(every))


def with_bores(change: Change) -> Callable[[Part], Part]:
    def changed(part: Part) -> Part:
        holes = (replace(hole, bores=tuple(change(bore) for bore in hole.bores)) for hole in part.holes)
        return replace(part, holes=tuple(holes))

    return changed


def only(diameter: float, **values: object) -> Callable[[Part], Part]:
    """Bores of a diameter drawn otherwise."""
    return with_bores(lambda bore: replace(bore, **values) if abs(bore.diameter_mm - diameter) < 1e-9 else bore)  # type: ignore[arg-type]


def without_slots(part: Part) -> Part:
    """Round holes where the foot block has slots."""

    def bored(hole: Hole) -> Hole:
        rounds = (
            Bore(
                s.start_mm, s.direction, s.width_mm, s.depth_mm, fit=s.fit, deviations_um=s.deviations_um, zone_mm=0.05
            )
            for s in hole.slots
        )
        return replace(hole, is_slot=False, slots=(), bores=tuple(rounds)) if hole.slots else hole

    return replace(part, holes=tuple(map(bored, part.holes)))


def short_slots(part: Part) -> Part:
    holes = (
        replace(hole, slots=tuple(replace(slot, long_mm=slot.width_mm + 0.1) for slot in hole.slots))
        for hole in part.holes
    )
    return replace(part, holes=tuple(holes))


def crossed_slots(part: Part) -> Part:
    """Slots across the line of their dowels, which hold nothing."""

    def turned(slot: Slot) -> Slot:
        x, y, z = (abs(v) for v in slot.direction)
        return replace(slot, along=(0.0, z, y + x))

    holes = (replace(hole, slots=tuple(map(turned, hole.slots))) for hole in part.holes)
    return replace(part, holes=tuple(holes))


BASE, MOTOR_SIDE, ENCODER_SIDE = (
    "base plate and foot block",
    "foot block and motor cheek",
    "encoder cheek and foot block",
)
NAMES = {
    f"mates dowels of {BASE}", f"mates screws of {BASE}",
    f"mates dowels of {MOTOR_SIDE}", f"mates screws of {MOTOR_SIDE}",
    f"mates dowels of {ENCODER_SIDE}", f"mates screws of {ENCODER_SIDE}",
    f"mates screws of {MOTOR}", "mates screws of encoder board and encoder cheek",
    "mates dowels of sector and upper arm",
}  # fmt: skip

BROKEN: list[tuple[str, Callable[[Part], Part], set[str]]] = [
    ("foot_block", without_slots, {f"mates dowels of {BASE}", f"mates dowels of {MOTOR_SIDE}"}),
    ("foot_block", short_slots, {f"mates dowels of {BASE}", f"mates dowels of {MOTOR_SIDE}"}),
    ("foot_block", crossed_slots, {f"mates dowels of {BASE}", f"mates dowels of {MOTOR_SIDE}"}),
    ("base_plate", only(4.5, zone_mm=0.4), {f"mates screws of {BASE}"}),
    ("base_plate", only(4.5, zone_mm=None), {f"mates screws of {BASE}"}),  # ISO 2768-m, as it was
    ("base_plate", only(3.0, zone_mm=0.3), {f"mates dowels of {BASE}", f"mates screws of {BASE}"}),
    ("motor_cheek", only(3.4, zone_mm=0.35), {f"mates screws of {MOTOR_SIDE}", f"mates screws of {MOTOR}"}),
    ("encoder_cheek", only(3.4, zone_mm=0.35), {f"mates screws of {ENCODER_SIDE}"}),
    ("encoder_cheek", only(2.05, zone_mm=0.5), {"mates screws of encoder board and encoder cheek"}),
    ("sector", only(3.0, zone_mm=0.5), {"mates dowels of sector and upper arm"}),
    ("upper_arm", only(3.0, reamed_with=""), {f"mates {one} of sector and upper arm" for one in ("dowels", "pilots")}),
    ("sector", only(3.0, predrilled_mm=2.9), {"mates dowels of sector and upper arm"}),
    ("encoder_cheek", only(3.0, predrilled_mm=2.95), {f"mates dowels of {ENCODER_SIDE}"}),
]  # fmt: skip


def test_every_pattern_of_the_joystick_goes_together_at_its_limits(best_assembly: Assembly) -> None:
    found = results(best_assembly)
    assert found.keys() == NAMES
    for one in found.values():
        assert one.passed, one.detail
        assert one.value is not None
        assert one.value > 0.0
        assert (one.limit, one.unit) == (0.0, "mm")


@pytest.mark.parametrize(("number", "change", "failing"), BROKEN)
def test_a_pattern_drawn_otherwise_fails(
    number: str, change: Callable[[Part], Part], failing: set[str], best_assembly: Assembly
) -> None:
    found = results(with_part(best_assembly, number, change))
    assert {one.name for one in found.values() if not one.passed} == failing
    for name in failing:
        assert "do not go in at the limits" in found[name].detail
        assert (found[name].value is None) is (change is crossed_slots)


def test_a_board_with_holes_as_narrow_as_its_screws_does_not_go_on(best_assembly: Assembly) -> None:
    """Holes of 2.6 mm and screws M2.5, as some boards are sold: the record is that of the solid."""

    def narrow(part: Part) -> Part:
        (holes,) = part.holes
        return replace(part, holes=(replace(holes, bores=tuple(replace(b, diameter_mm=2.6) for b in holes.bores)),))

    found = results(with_part(best_assembly, "encoder_board", narrow))
    assert not found["mates screws of encoder board and encoder cheek"].passed


def test_a_direct_drive_has_both_cheeks_on_a_hole_and_a_slot(direct_assembly: Assembly) -> None:
    found = results(direct_assembly)
    assert found.keys() == NAMES - {"mates dowels of sector and upper arm"}
    assert all(one.passed for one in found.values())
    sides = (found[f"mates dowels of {side}"].value for side in (MOTOR_SIDE, ENCODER_SIDE))
    assert len({round(value or 0.0, 9) for value in sides}) == 1


def test_a_board_to_drawing_is_held_against_the_zone_that_its_drawing_has(best_assembly: Assembly) -> None:
    name = "mates screws of encoder board and encoder cheek"
    drawn = results(best_assembly)[name]
    assert "is assumed" not in drawn.detail

    def tighter(part: Part) -> Part:
        (holes,) = part.holes
        return replace(part, holes=(replace(holes, bores=tuple(replace(b, zone_mm=0.04) for b in holes.bores)),))

    found = results(with_part(best_assembly, "encoder_board", tighter))[name]
    assert (found.value or 0.0) - (drawn.value or 0.0) == pytest.approx((0.1 - 0.04) / 2.0)


@pytest.mark.parametrize("part", ["motor", "encoder_board"])
def test_the_zone_that_a_bought_part_may_have_is_the_largest_that_goes_in(
    best_assembly: Assembly, monkeypatch: pytest.MonkeyPatch, part: str
) -> None:
    """A board from stock, as the adapter boards of chips' makers, states no zone."""

    def from_stock(one: Part) -> Part:
        return replace(one, holes=tuple(replace(hole, bores=()) for hole in one.holes))

    best_assembly = with_part(best_assembly, part, from_stock)
    zones = dict(mates._BOUGHT_ZONES_MM)

    def with_zone(zone_mm: float) -> CheckResult:
        monkeypatch.setattr(mates, "_BOUGHT_ZONES_MM", zones | {part: zone_mm})
        name = f"mates screws of {' and '.join(sorted((part.replace('_', ' '), f'{cheek} cheek')))}"
        return next(result for result in check_mates(best_assembly) if result.name == name)

    cheek = "motor" if part == "motor" else "encoder"
    stated = re.search(r"may lie in zones of ([\d.]+), ([\d.]+) is assumed", with_zone(zones[part]).detail)
    assert stated is not None
    largest = float(stated[1])
    assert largest >= float(stated[2]) == zones[part]
    assert with_zone(largest - 1e-3).passed
    assert not with_zone(largest + 1e-3).passed
