"""Parts of another material, mass or order are refused by their number."""

from collections.abc import Callable
from dataclasses import replace

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.dfm.makes import check_makes
from delta_cad.solids.part import Part


def spoiled(a: Assembly, number: str, spoil: Callable[[Part], Part]) -> Assembly:
    (sound,) = [p for p in a.parts if p.number == number]
    wrong = spoil(sound)
    return replace(a, occurrences=tuple(replace(o, part=wrong) if o.part is sound else o for o in a.occurrences))


def steel(a: Assembly) -> Callable[[Part], Part]:
    (screw,) = [p for p in a.parts if p.number == "screw_M3x12"]
    return lambda part: replace(part, material=screw.material)


def test_all_parts_are_made_as_stated(best_assembly: Assembly) -> None:
    result = check_makes(best_assembly)
    assert result.passed, result.detail
    assert len({m.number for m in best_assembly.makes}) == len(best_assembly.makes)


@pytest.mark.parametrize("number", ["upper_arm", "rod_tube", "joint_ball", "motor"])
def test_another_material_is_refused(best_assembly: Assembly, number: str) -> None:
    result = check_makes(spoiled(best_assembly, number, steel(best_assembly)))
    assert not result.passed
    assert result.worst_pair == (number,)
    assert "of Stainless steel 1.4305, stated is" in result.detail


SPOILED: dict[str, tuple[str, Callable[[Part], Part], str]] = {
    "mass of a bought part": ("motor", lambda p: replace(p, mass_g=2600.0), "its mass is 2600 g, stated is 260"),
    "mass of a made part": ("platform", lambda p: replace(p, mass_g=1.0), "its mass is 1 g, stated is"),
    "mass of a cable": ("capstan_cable_turns", lambda p: replace(p, mass_g=2.4), "its mass is 2.4 g, stated is"),
    "no mass of its maker": ("knob", lambda p: replace(p, mass_g=None), "g, stated is 10"),
    "another row": ("motor", lambda p: replace(p, order_code="maxon 0"), "ordered as maxon 0, stated is maxon 310007"),
    "another length": ("screw_M3x12", lambda p: replace(p, order_code="ISO 4762 M3 A2-70 x 10"), "A2-70 x 12"),
    "ordered, and is made": ("pinion", lambda p: replace(p, order_code="a pinion"), "stated is nothing"),
    "bought, and is made": ("sector", lambda p: replace(p, make=False), "it is bought, stated is made"),
    "a lighter material of the name": (
        "upper_arm",
        lambda p: replace(p, material=replace(p.material, density_kg_m3=1000.0)),
        "its density is 1000 kg/m^3, that of its material 2810",
    ),
    "another standard": (
        "screw_M3x12",
        lambda p: replace(p, standard="ISO 10642"),
        "it follows ISO 10642, stated is ISO",
    ),
    "a piece that is a part": (
        "knob",
        lambda p: replace(p, piece_of="platform"),
        "drawn as a piece of platform, stated",
    ),
    "a number of nothing": ("knob", lambda p: replace(p, number="ball"), "ball: nothing is stated of its number"),
}


@pytest.mark.parametrize("spoil", SPOILED)
def test_what_is_not_made_as_stated_is_named(best_assembly: Assembly, spoil: str) -> None:
    number, make, told = SPOILED[spoil]
    result = check_makes(spoiled(best_assembly, number, make))
    assert result.value == 1
    assert told in result.detail


def test_of_two_parts_of_one_number_both_are_looked_at(best_assembly: Assembly) -> None:
    every = tuple(
        replace(o, part=replace(o.part, mass_g=1.0)) if o.name == "bearing_2_m" else o
        for o in best_assembly.occurrences
    )
    assert check_makes(replace(best_assembly, occurrences=every)).value == 1
