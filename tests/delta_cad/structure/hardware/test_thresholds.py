"""Thresholds are the borders of refusals themselves, and suggestions are refused nothing.

33 s of processor: every threshold is searched on the refusal itself.
"""

from __future__ import annotations

from collections.abc import Callable
from math import floor, log10

import pytest

from delta_cad.design import Design, design_from_dict, design_to_dict, load_design
from delta_cad.dimensions import Reason
from delta_cad.dimensions.rules import BASE, PLATFORM, Way, larger
from delta_cad.structure.hardware.refusals import Judged, refusals
from delta_cad.structure.hardware.suggestion import LIMITS, _Search, suggestion
from delta_cad.structure.hardware.thresholds import (
    Threshold,
    Variants,
    _needed,
    _threshold,
    along,
    by_chain,
    changed,
    least,
    refused,
)
from tests.committed import COMMITTED
from tests.committed import changed as spoiled
from tests.delta_cad.structure.hardware.broken import broken, ended, enough, of_family


@pytest.mark.parametrize("own", [-60.0, 0.0, 60.0])
def test_a_field_of_either_sign_is_changed_across_zero(own: float) -> None:
    found = least(lambda x: -10.0 <= x <= -5.0, own, own < -5.0, scale=20.0)
    assert found == pytest.approx(-10.0 if own < -5.0 else -5.0, abs=0.02)


@pytest.mark.parametrize("border", [30.748, 30.0, 27.19, 60.0, 81.0])
def test_the_least_value_is_found_to_a_unit_of_its_fourth_digit(border: float) -> None:
    found = least(lambda value: value >= border, 27.182, True)
    assert found is not None
    assert border <= found < border + 0.01


@pytest.mark.parametrize("border", [26.9, 20.004, 14.0])
def test_the_largest_value_is_found_on_the_other_side(border: float) -> None:
    found = least(lambda value: value <= border, 27.182, False)
    assert found is not None
    assert border - 0.01 < found <= border


def test_a_value_beyond_the_steps_or_behind_what_cannot_be_judged_is_not_stated() -> None:
    assert least(lambda value: value >= 100.0, 27.182, True) is None
    assert least(lambda value: True if value >= 30.0 else None, 27.182, True) is None


def test_a_value_is_judged_as_it_is_written() -> None:
    """No value is judged that has more digits than are printed."""
    judged = list[float]()
    least(lambda value: judged.append(value) or value >= 30.748, 27.182, True)
    assert judged
    assert all(float(f"{value:.4g}") == value for value in judged)


def test_radii_move_by_the_same_length_and_sector_and_ratio_by_the_same_share() -> None:
    design = of_family("tests/references/symmetric-83.json")
    m, h = design.mechanism, design.hardware
    both = along(design, larger("mechanism.base_radius_mm", "mechanism.platform_radius_mm"), m.base_radius_mm + 1.5)
    assert both["mechanism.platform_radius_mm"] == pytest.approx(m.platform_radius_mm + 1.5)
    wheels = along(design, larger("hardware.sector_radius_mm", "hardware.capstan_ratio"), 1.1 * h.sector_radius_mm)
    assert wheels["hardware.capstan_ratio"] == pytest.approx(1.1 * h.capstan_ratio, rel=1e-4)


def test_chains_that_stand_unevenly_go_out_by_the_same_length() -> None:
    """What is judged is what a file of it would be read as."""
    radii = [31.182, 36.0, 36.0]
    places = {"mechanism__base_radius_mm": radii[0], "mechanism__base_radii_mm": radii}
    design = design_from_dict(spoiled(**places, mechanism__azimuths_deg=[0.0, 118.0, -118.0]))
    made = changed(design, {"mechanism.base_radius_mm": 33.0, "mechanism.platform_radius_mm": 25.0})
    assert made is not None
    assert made.geometry.base_radii * 1000.0 == pytest.approx([33.0, 37.818, 37.818], abs=1e-9)
    assert design_from_dict(design_to_dict(made)).geometry == made.geometry
    alone = changed(design, {"mechanism.platform_radius_mm": 25.0})
    assert alone is not None
    assert alone.mechanism.base_radii_mm == tuple(radii)


def test_a_change_that_includes_another_which_does_alone_is_not_stated() -> None:
    sector, ratio, width = "hardware.sector_radius_mm", "hardware.capstan_ratio", "mechanism.parallelogram_width_mm"
    own: dict[str, float | str] = {sector: 37.8, ratio: 4.85, width: 41.0, "hardware.leads": "bent"}

    def ends(**enough: float | tuple[float | str, ...]) -> Threshold:
        named = {"sector": sector, "ratio": ratio, "width": width, "leads": "hardware.leads"}
        changes = {named[name]: value for name, value in enough.items()}
        return Threshold({field: own[field] for field in changes}, changes)

    alone, both = ends(sector=38.14), ends(sector=38.14, ratio=4.89)
    assert list(_needed([alone, both])) == list(_needed([both, alone])) == [alone]
    assert list(_needed([alone, alone])) == [alone]
    apart = [
        alone,
        ends(sector=38.0, ratio=4.89),
        ends(sector=36.0, width=40.0),
        ends(width=39.0),
        ends(leads=("none",)),
    ]
    assert list(_needed(apart)) == apart  # less of it, another way, another field
    assert list(_needed([ends(width=40.0), ends(width=39.0, ratio=4.0)])) == [ends(width=40.0)]


def test_the_base_radii_of_all_chains_are_stated_as_one_change(monkeypatch: pytest.MonkeyPatch) -> None:
    design = load_design(COMMITTED)
    monkeypatch.setattr(Variants, "gone", lambda _, values, *__: values[BASE] >= 32.0)
    (one,) = _threshold(Variants(design), "", Reason("foot_block", "place", ""), larger(BASE, PLATFORM))
    m = design.mechanism
    assert m.base_radii_mm is not None
    by = 32.0 - m.base_radius_mm
    was, must = (", ".join(f"{radius + more:.5g}" for radius in m.base_radii_mm) for more in (0.0, by))
    radii = f"mechanism.base_radii_mm = [{was}] must be at least [{must}], each {by:.4g} mm longer"
    platform = f"{PLATFORM} = {m.platform_radius_mm:g} at least {m.platform_radius_mm + by:.5g}"
    assert str(one) == f"{radii} with {platform}"
    found = changed(design, {BASE: 32.0})
    assert found is not None
    assert list(by_chain(design, {BASE: m.base_radius_mm}).values()) == list(m.base_radii_mm)
    assert found.mechanism.base_radii_mm == pytest.approx(
        [one.enough[f"mechanism.base_radii_mm[{i}]"] for i in range(3)]
    )


def test_a_suggestion_names_the_base_radii_that_its_file_states(monkeypatch: pytest.MonkeyPatch) -> None:
    design = load_design(COMMITTED)
    radii = design.mechanism.base_radii_mm
    assert radii is not None
    monkeypatch.setattr(_Search, "found", lambda _: {BASE: 32.0})
    found = suggestion(design)
    assert found is not None
    more = 32.0 - radii[0]
    each = (f"mechanism.base_radii_mm[{i}] = {one + more:.6g} (was {one:.6g})" for i, one in enumerate(radii))
    assert str(found) == ", ".join(each)
    assert design_from_dict(design_to_dict(found.design)).geometry == found.design.geometry


def keys(design: Design | None, form: str) -> set[tuple[str, str]]:
    """What one form says of a design, judged anew."""
    assert design is not None
    found = Judged(design).of(form)
    assert found is not None
    return {one.key for one in found}


def nearer(design: Design, one: Threshold) -> dict[str, float | str]:
    """The values of a change one unit of the fourth digit nearer to the design's own, or these."""
    field, value = next(iter(one.enough.items()))
    own, found = float(one.own[field]), value
    assert isinstance(found, float)
    unit = 10.0 ** (floor(log10(abs(own))) - 3)
    just = found - unit if found > own else found + unit
    return along(design, Way(tuple(one.enough)), just if (just - own) * (found - own) > 0.0 else own)


@pytest.mark.quick(7)  # one of each family
@pytest.mark.parametrize("number", range(200))
def test_just_below_each_threshold_the_reason_is_there_and_at_it_it_is_gone(number: int) -> None:
    design = broken(number)
    forms = {one.key: form for form, found in Judged(design).forms() for one in found}
    found = list(refused(design))
    assert {one.reason.key for one in found} == set(forms)
    for one in found:
        key, form = one.reason.key, forms[one.reason.key]
        for change in one.thresholds:
            gone = dict[str, float | str]()
            for field, value in change.enough.items():
                if isinstance(value, tuple):
                    assert all(key not in keys(changed(design, {field: row}), form) for row in value)
                else:
                    gone[field] = value
            if gone:
                assert key not in keys(changed(design, gone), form), str(one)
                assert key in keys(changed(design, nearer(design, change)), form), str(one)


@pytest.mark.slow
@pytest.mark.parametrize("number", range(60))
def test_a_suggestion_is_refused_nothing_and_asks_for_nothing_less(number: int) -> None:
    design = broken(number)
    found = suggestion(design)
    if found is None:
        return  # that is said, and nothing is written
    assert refusals(found.design) == ()
    assert found.values
    again = design_from_dict(design_to_dict(found.design))
    assert (again.requirements, again.panel) == (design.requirements, design.panel)
    assert again.cube.half_side_mm == design.cube.half_side_mm


RADII = ("mechanism.base_radius_mm", "mechanism.platform_radius_mm")


def border(does: Callable[[float], bool]) -> float:
    """The least length up to 4 mm that does, to 0.01 mm, if all longer ones do."""
    low, high = 0.0, 4.0
    assert does(high)
    while high - low > 0.01:
        middle = (low + high) / 2.0
        low, high = (low, middle) if does(middle) else (middle, high)
    return high


def test_both_radii_4_mm_too_short_are_suggested_as_much_longer_as_both_need() -> None:
    """Against a bisection on the refusals, of the base alone and of both; a suggestion holds the solids' margin."""
    best = of_family("tests/references/symmetric-83.json")
    # no refusal is about friction; with 8 N its ball joints keep less than `LEAST_MARGIN`
    unbounded = best.requirements.model_copy(update={"friction_max_N": None, "peak_force_N": 7.6})
    best = best.model_copy(update={"requirements": unbounded})
    m = best.mechanism
    short = changed(
        best,
        {
            "mechanism.base_radius_mm": m.base_radius_mm - 4.0,
            "mechanism.platform_radius_mm": m.platform_radius_mm - 4.0,
        },
    )
    assert short is not None
    bases = [enough(one, "mechanism.base_radius_mm") for one in refused(short) if one.reason.feature != "wrists"]
    others = {one.reason.key for one in refused(short) if one.reason.feature != "wrists"}

    def longer(base_mm: float, platform_mm: float) -> set[tuple[str, str]]:
        lengths = short.mechanism.base_radius_mm + base_mm, short.mechanism.platform_radius_mm + platform_mm
        one = changed(short, dict(zip(RADII, lengths, strict=True)))
        assert one is not None
        return {reason.key for reason in refusals(one)}

    base = short.mechanism.base_radius_mm
    assert max(bases) == pytest.approx(base + border(lambda by: not others & longer(by, 0.0)), abs=0.06)
    found = suggestion(short)
    assert found is not None
    assert set(found.values) == set(RADII)
    both = border(lambda by: not longer(by, by))
    assert found.design.mechanism.base_radius_mm == pytest.approx(m.base_radius_mm - 4.0 + both, abs=0.2)
    assert found.design.mechanism.platform_radius_mm == pytest.approx(m.platform_radius_mm - 4.0 + both, abs=0.2)
    assert refusals(found.design) == ()


def test_a_suggestion_is_the_smallest_in_each_of_its_fields() -> None:
    """One unit of the last digit nearer to the refused design something refuses it."""
    design = design_from_dict(spoiled(hardware__platform_thickness_mm=9.0))
    search = _Search(design, margin=True)
    values = search.found()
    assert values
    for field, value in values.items():
        own = float(search.own(field))
        unit = 10.0 ** (floor(log10(abs(float(value)))) - 3)
        closer = float(value) - unit if float(value) > own else float(value) + unit
        assert search.reasons({**values, field: round(closer, 6)})[1]


def test_a_bound_on_friction_is_looked_at_where_there_is_one() -> None:
    design = design_from_dict(spoiled(requirements__friction_max_N=0.01))
    form, there = _Search(design, margin=False).reasons({})
    assert (form, [one.feature for one in there]) == (LIMITS, ["friction"])


def test_a_requirement_that_would_have_to_change_is_said_to_be_one() -> None:
    design = design_from_dict(spoiled(requirements__joint_torque_N_m=0.9, requirements__peak_torque_N_m=0.9))
    lines = [f"{one}" for one in ended(design).values()]
    assert any("where the requirement may change, requirements." in line for line in lines)
