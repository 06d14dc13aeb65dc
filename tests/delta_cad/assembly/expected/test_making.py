"""Parts of another material, mass or order than expected are named by their number."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.solids.part import Part
from tests.delta_cad.assembly.expected.comparing import make_faults


def spoiled(a: Assembly, number: str, spoil: Callable[[Part], Part]) -> Assembly:
    (sound,) = [p for p in a.parts if p.number == number]
    wrong = spoil(sound)
    return replace(a, occurrences=tuple(replace(o, part=wrong) if o.part is sound else o for o in a.occurrences))


def steel(a: Assembly) -> Callable[[Part], Part]:
    (screw,) = [p for p in a.parts if p.number == "screw_M3x12"]
    return lambda part: replace(part, material=screw.material)


@pytest.mark.parametrize("number", ["upper_arm", "rod_tube", "joint_ball", "motor"])
def test_another_material_is_named(best_assembly: Assembly, best_dimensions: Dimensions, number: str) -> None:
    found = make_faults(spoiled(best_assembly, number, steel(best_assembly)), best_dimensions)
    assert found[0].startswith(f"{number}: material is 'Stainless steel 1.4305")


SPOILED: dict[str, tuple[str, Callable[[Part], Part], str]] = {
    "mass of a bought part": ("motor", lambda p: replace(p, mass_g=2600.0), "mass is 2600"),
    "mass of a made part": ("platform", lambda p: replace(p, mass_g=1.0), "mass is 1"),
    "mass of a cable": ("capstan_cable_turns", lambda p: replace(p, mass_g=2.4), "mass is 2.4"),
    "no mass of its maker": ("knob", lambda p: replace(p, mass_g=None), "mass is"),
    "another row": ("motor", lambda p: replace(p, order_code="maxon 0"), "order code is 'maxon 0'"),
    "another length": ("screw_M3x12", lambda p: replace(p, order_code="ISO 4762 M3 A2-70 x 10"), "order code"),
    "ordered, and is made": ("pinion", lambda p: replace(p, order_code="a pinion"), "order code is 'a pinion'"),
    "bought, and is made": ("sector", lambda p: replace(p, make=False), "make is False"),
    "a lighter material of the name": (
        "upper_arm",
        lambda p: replace(p, material=replace(p.material, density_kg_m3=1000.0)),
        "density is 1000.0, expected is 2810",
    ),
    "another standard": ("screw_M3x12", lambda p: replace(p, standard="ISO 10642"), "standard is 'ISO 10642'"),
    "a piece that is a part": ("knob", lambda p: replace(p, piece_of="platform"), "piece of is 'platform'"),
    "a number of nothing": ("knob", lambda p: replace(p, number="ball"), "no number of this design"),
}


@pytest.mark.parametrize("spoil", SPOILED)
def test_what_is_not_made_as_expected_is_named(
    best_assembly: Assembly, best_dimensions: Dimensions, spoil: str
) -> None:
    number, make, fault = SPOILED[spoil]
    (found,) = make_faults(spoiled(best_assembly, number, make), best_dimensions)
    assert fault in found


def test_of_two_parts_of_one_number_both_are_looked_at(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    every = tuple(
        replace(o, part=replace(o.part, mass_g=1.0)) if o.name == "bearing_2_m" else o
        for o in best_assembly.occurrences
    )
    assert len(make_faults(replace(best_assembly, occurrences=every), best_dimensions)) == 1
