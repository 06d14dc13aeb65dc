"""All reasons at once, and values that mend them together: what is told is typed, and nothing is left of it."""

from __future__ import annotations

import re
from math import isclose
from typing import Any

import pytest

from delta_cad.design import Design, design_from_dict, design_to_dict
from delta_cad.dimensions import Reason
from delta_cad.dimensions.rules import down, up
from delta_cad.structure.hardware import advice as room
from delta_cad.structure.hardware.advice import DESIGN, advice
from delta_cad.structure.hardware.refusals import refusals
from tests.committed import changed

Changes = dict[str, Any]
FAR: dict[str, Changes] = {
    "ratio 3": {"hardware__capstan_ratio": 3.0},
    "ratio 12": {"hardware__capstan_ratio": 12.0, "hardware__sector_radius_mm": 45.0},
    "cable of 0.8": {"hardware__cable": "steel-0.8-7x19"},
    "motor of 200 W": {"hardware__motor": "maxon-re50-370354"},
    "another motor of 60 W": {"hardware__motor": "faulhaber-3257g024cr"},
    "small base": {"mechanism__base_radius_mm": 20.0},
    "narrow": {"mechanism__parallelogram_width_mm": 30.0},
    "balls of 10": {"hardware__ball_diameter_mm": 10.0},
    "bearings of 22": {"hardware__bearing": "608"},
    "large sector": {"hardware__sector_radius_mm": 60.0},
    "twice the torque": {"requirements__joint_torque_N_m": 0.8, "requirements__peak_torque_N_m": 2.0},
    "10 N": {"requirements__force_N": 10.0, "requirements__peak_force_N": 10.0},
    "a torque that no motor gives": {"requirements__joint_torque_N_m": 9.0, "requirements__peak_torque_N_m": 20.0},
    "a motor with too short a shaft": {
        "hardware__drive": "direct",
        "hardware__motor": "maxon-ec60flat-408057",
        "hardware__leads": "bent",
        "requirements__joint_torque_N_m": 0.5,
    },
}
TOLD = re.compile(r"(?:\w+\.)?(\w+) = (\S+) must be (at least|at most) ([\d.]+)")


def typed(design: Design, values: Any) -> Design:
    """A design with fields as they are told."""
    data = design_to_dict(design)
    for field, value in values.items():
        where, _, name = field.partition(".")
        data[where][name] = value
    return design_from_dict(data)


@pytest.mark.parametrize("name", FAR)
def test_what_is_told_together_leaves_no_reason(name: str) -> None:
    design = design_from_dict(changed(**FAR[name]))
    found = advice(design)
    assert found.reasons == refusals(design) != ()
    assert found.together
    assert not refusals(typed(design, found.together))
    assert not {(one.part, one.feature) for one in found.then} & {(one.part, one.feature) for one in found.reasons}


@pytest.mark.parametrize("name", FAR)
def test_each_value_that_is_told_mends_its_own_reason(name: str) -> None:
    """As the message has it, digit for digit, with what is to change beside it; or to a hundredth, where the motor's
    place and the pinion's follow the field: what is told together is exact.
    """
    design = design_from_dict(changed(**FAR[name]))
    for reason in refusals(design):
        bound = reason.bound
        if not isinstance(bound, float) or not isinstance(reason.value, float):
            continue
        field, _, way, number = TOLD.findall(reason.message)[0]
        assert reason.field.endswith(field)
        assert (float(number) >= bound - 1e-9) if way == "at least" else (float(number) <= bound + 1e-9)
        values = {reason.field: float(number)}
        values |= {name: more if isinstance(more, str) else float(up(more)) for name, more in reason.beside}
        if values.get("requirements.peak_force_N", 10.0) < design.requirements.force_N:
            values["requirements.force_N"] = values["requirements.peak_force_N"]
        left = {(one.part, one.feature): one for one in refusals(typed(design, values))}
        again = left.get((reason.part, reason.feature))
        if again is not None and again.field == reason.field:
            assert again.bound == pytest.approx(bound, rel=0.01), (str(reason), str(again))


def test_numbers_that_cannot_go_together_are_mended_with_the_hardware() -> None:
    """A ratio at which the groove cuts into the shaft: what just clears it leaves no wall, which was told only then."""
    held = design_from_dict(changed())
    hardware = held.hardware.model_copy(update={"capstan_ratio": 14.0})
    found = advice(held.model_copy(update={"hardware": hardware}))
    assert {(DESIGN, "hardware.capstan_ratio"), ("pinion", "wall")} <= {
        (one.part, one.feature) for one in found.reasons
    }
    assert found.together
    assert not refusals(typed(held, found.together))


def test_a_word_that_would_do_is_taken() -> None:
    lead = Reason("encoder_cheek", "tie", "", "hardware.leads", "bent", "none", (("hardware.leads", "none"),))
    assert room._mending((lead,), {}, {}) == {"hardware.leads": "none"}


def test_a_field_that_two_reasons_move_apart_is_kept_and_another_moved(monkeypatch: pytest.MonkeyPatch) -> None:
    """A shaft asks for a larger sector, its screws for a smaller one or a higher ratio: the ratio it is."""

    def two(design: Design, _asked: object = None) -> tuple[Reason, ...]:
        h = design.hardware
        small, slow = h.sector_radius_mm < 50.0, h.sector_radius_mm / h.capstan_ratio > 8.0
        shaft = Reason("motor shaft", "load", "", "hardware.sector_radius_mm", h.sector_radius_mm, 50.0)
        ratio = ("hardware.capstan_ratio", h.sector_radius_mm / 8.0)
        most = 8.0 * h.capstan_ratio
        screws = Reason("pinion", "screws", "", shaft.field, h.sector_radius_mm, most, instead=ratio)
        return (*([shaft] if small else []), *([screws] if slow and not small else []))

    monkeypatch.setattr(room, "refusals", two)
    found = advice(design_from_dict(changed(hardware__sector_radius_mm=40.0, hardware__capstan_ratio=5.0)))
    assert [one.part for one in found.reasons + found.then] == ["motor shaft", "pinion"]
    assert found.together == {"hardware.sector_radius_mm": 50.0, "hardware.capstan_ratio": 6.25}


def test_the_first_reasons_are_told_before_they_are_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    calls, told = list[Design](), list[tuple[int, tuple[Reason, ...]]]()

    def counted(design: Design, *asked: Any) -> tuple[Reason, ...]:
        calls.append(design)
        return refusals(design, *asked)

    monkeypatch.setattr(room, "refusals", counted)
    found = advice(
        design_from_dict(changed(hardware__platform_thickness_mm=6.0)), lambda r: told.append((len(calls), r))
    )
    assert told == [(1, found.reasons)]
    assert len(calls) > 1


def test_what_goes_in_circles_ends_without_values(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []

    def never(design: Design, _asked: object = None) -> tuple[Reason, ...]:
        calls.append(design)
        held = design.hardware.sector_radius_mm
        return (Reason("a", "b", "", "hardware.sector_radius_mm", held, 50.0 if held < 45.0 else 40.0),)

    monkeypatch.setattr(room, "refusals", never)
    assert advice(design_from_dict(changed(hardware__sector_radius_mm=40.0))).together == {}
    assert len(calls) <= room.ROUNDS + 1


def test_values_out_of_a_fields_bounds_end_the_search(monkeypatch: pytest.MonkeyPatch) -> None:
    def far(design: Design, _asked: object = None) -> tuple[Reason, ...]:
        return (Reason("a", "b", "", "hardware.sector_radius_mm", design.hardware.sector_radius_mm, 1e4),)

    monkeypatch.setattr(room, "refusals", far)
    assert advice(design_from_dict(changed())).together == {}


@pytest.mark.parametrize("value", [5.02941, 0.0123456, 143.615, 31.6, 10.0, 1500.2, 6.16775])
def test_told_values_are_rounded_to_where_they_do(value: float) -> None:
    assert float(up(value)) >= value * (1.0 - 1e-12)
    assert float(down(value)) <= value * (1.0 + 1e-12)
    assert isclose(float(up(value)), float(down(value)), rel_tol=1.1e-3)
    assert len(up(value).replace(".", "").strip("0")) <= 4
