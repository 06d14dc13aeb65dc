"""Every tolerance of `best.json`'s drawings tighter than ISO 2768-m has the chain, pattern or fit that needs it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.design import load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.tolerances.chain import Chain, Link
from delta_cad.dimensions.tolerances.general import general_mm
from delta_cad.dimensions.tolerances.machine import deviation_mm, length_chains, machine_chains, square_zones
from delta_cad.dimensions.tolerances.square import ARM, ENCODER_SEAT, MOTOR_SEAT, SECTOR, SHOULDER, STEPS_MM
from delta_cad.export.drawings.part.controlled import Controlled, Length, controlled
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.solids.part import Part
from tests.committed import COMMITTED, ROOT

Drawn = tuple[str, str, float]
"""Part, what is toleranced, and half of its zone or its deviation either way, mm."""
MACHINES = (ROOT / "best.json", *sorted((ROOT / "docs" / "gallery").glob("*-*.json")))
MATES = "mates"  # the check of mating patterns has its zone, or its slot's
CHAIN: dict[tuple[str, str], tuple[str, ...]] = {  # part, kind of tolerance -> links that have it, or MATES
    ("base_plate", "position 3"): ("place of a dowel",),
    ("base_plate", "position 4.5"): (MATES,),
    ("motor_cheek", "perpendicularity 16"): ("seat out of square",),
    ("motor_cheek", "position 15"): ("pilot from the bearing's seat",),
    ("motor_cheek", "position 4"): ("stop pin from the shoulder's axis",),
    ("motor_cheek", "position 3"): ("seat from its dowels",),
    ("motor_cheek", "position 3.4"): (MATES,),
    ("motor_cheek", "depth"): ("depth of the seat",),
    ("encoder_cheek", "perpendicularity 16"): ("seat out of square",),
    ("encoder_cheek", "position 3.4"): (MATES,),
    ("encoder_cheek", "position 2.05"): ("place of the board's threads",),
    ("encoder_cheek", "depth"): ("depth of the seat",),
    ("encoder_board", "position 2.9"): (MATES,),
    ("encoder_board", "length"): ("height of its chip",),
    ("foot_block", "perpendicularity 3"): (MATES,),
    ("foot_block", "position plane"): (MATES,),
    ("foot_block", "position 3.3"): (MATES,),
    ("foot_block", "position 3"): ("cross dowels from the upright ones", "dowels from its middle"),
    ("foot_block", "position 2.5"): (MATES,),
    ("foot_block", "length"): ("width",),
    ("upper_arm", "perpendicularity 8"): ("bore out of square",),
    ("upper_arm", "position 3"): ("holes drilled for the dowels",),
    ("upper_arm", "position 8.04"): ("bar's bore from the shaft's",),
    ("upper_arm", "length"): ("from its collar to the sector",),
    ("shoulder_shaft", "perpendicularity plane"): ("shoulder out of square",),
    ("shoulder_shaft", "coaxiality 6.1"): ("magnet's seat off its journal",),
    ("cross_bar", "coaxiality 2.5"): ("studs off its middle",),
    ("cross_bar", "length"): ("distance of its shoulders",),
    ("sector", "perpendicularity 8"): ("bore out of square",),
    ("sector", "position 3"): ("holes drilled for the dowels",),
    ("sector", "position 5"): ("place of its slot's end",),
    ("sector", "length"): ("from the arm to its collar",),
    ("sector", "size 77.86"): ("radius of its rim",),
    ("pinion", "coaxiality 15.046"): ("groove off its bore",),
    ("pinion", "size 15.316"): ("diameter of its crest",),
    ("pinion", "size 15.046"): ("diameter of its groove",),
    ("platform", "position 8.04"): ("place of a bar's bore",),
}
BOND = "of a ball's shell and its cup: half of the bond between them"
OTHER: dict[tuple[str, str], str] = {
    ("rod_cup", "size 7.255"): BOND,
    ("rod_cup", "size 2.8"): "of a rod end's spigot: a quarter of the bond in its tube on either side",
    ("rod_tube", "length"): "shorter only: the rod jig sets the rod's length, beyond the tube's ends is bond",
    ("cup_shell", "size 7.215"): BOND,
    (
        "cup_shell",
        "size 6.015",
    ): "clearance of a ball joint: the reach of its contact and its stiffness are limits of it",
}
"""Sizes that no chain asks for, and what does."""
TIGHT_MM = 0.02  # zones up to this need a chain by name


@pytest.fixture(scope="module")
def best() -> tuple[Dimensions, Assembly]:
    d = dimensions(load_design(COMMITTED))
    return d, assemble(d)


def drawn(part: Part, held: Controlled) -> list[Drawn]:
    """Tolerances of a part's drawing but those of fits, which are standard ones."""
    features, name = features_of(part, faces_of(part.solid), held), part.number
    found: list[Drawn] = []
    for zone in features.zones:
        face = zone.faces[0]
        what = f"{round(2 * face.radius, 3):g}" if face.kind == "cylinder" else face.kind
        found.append((name, f"{zone.kind} {what}", zone.value_mm / 2.0))
    found += [(name, "length", length.tolerance_mm) for length in held.lengths]
    found += [(name, "depth", length.tolerance_mm) for length in held.depths]
    rounds = [one for one in held.rounds if one.either_mm]
    return found + [(name, f"size {round(one.diameter_mm, 3):g}", one.either_mm) for one in rounds]


def unexplained(d: Dimensions, assembly: Assembly, held: dict[str, Controlled]) -> list[Drawn]:
    """Tolerances that neither a chain's link of the same size, nor anything else that is named here, asks for."""
    links: list[Link] = [x for chain in (*machine_chains(d), *length_chains(d, "m")) for x in chain.links]

    def has(part: str, what: str, mm: float) -> bool:
        sizes = {(link.upper_mm - link.lower_mm) / 2.0 for link in links if (link.part, link.what) == (part, what)}
        factors = (1.0, 0.5)  # a radius, of a diameter's deviation
        return any(abs(size - factor * mm) < 1e-9 for size in sizes for factor in factors)

    found = []
    for part in (part for part in assembly.parts if part.is_drawn):
        for name, what, mm in drawn(part, held.get(part.number, Controlled())):
            if mm >= general_mm(400.0) or (name, what) in OTHER:
                continue
            links_of = CHAIN.get((name, what), ())
            if not any(one == MATES or has(name, one, mm) for one in links_of):
                found.append((name, what, mm))
    return found


def test_every_tight_tolerance_has_its_reason(best: tuple[Dimensions, Assembly]) -> None:
    d, assembly = best
    held = controlled(d)
    assert unexplained(d, assembly, held) == []
    every = {
        one[:2] for part in assembly.parts if part.is_drawn for one in drawn(part, held.get(part.number, Controlled()))
    }
    assert CHAIN.keys() | OTHER.keys() == every  # nothing is explained that is not drawn


@pytest.mark.quick(1)
@pytest.mark.parametrize("file", MACHINES, ids=lambda file: file.stem)
def test_no_tight_zone_stands_without_a_chain_by_name(file: Path) -> None:
    """Of every published machine: a zone of 0.02 or less, and any of squareness, is a link's of the same size."""
    d = dimensions(load_design(file))
    links = [x for chain in (*machine_chains(d), *length_chains(d, "m")) for x in chain.links]
    assembly, held, alone = assemble(d), controlled(d), list[str]()
    for part in (part for part in assembly.parts if part.is_drawn):
        for name, what, mm in drawn(part, held.get(part.number, Controlled())):
            if what.split()[0] in ("size", "length", "depth") or (mm > TIGHT_MM / 2.0 and "perp" not in what):
                continue
            own = [x for x in links if x.part == name and "out of square" in x.what and abs(x.upper_mm - mm) < 1e-9]
            if not own and CHAIN.get((name, what), (MATES,)) != (MATES,):
                alone.append(f"{name}: {what} of {2.0 * mm:g}")
    assert alone == []


def test_a_zone_of_squareness_is_the_loosest_that_its_chains_bear(best: tuple[Dimensions, Assembly]) -> None:
    d, _ = best
    zones = square_zones(d)
    assert set(zones) == {ARM, MOTOR_SEAT, ENCODER_SEAT, SHOULDER, SECTOR}
    most = max(deviation_mm(chain) for chain in length_chains(d, "m"))
    for feature in zones:
        step = STEPS_MM[STEPS_MM.index(zones[feature]) + 1]
        chains = [*machine_chains(d), *(replace(x, low=-most, high=most) for x in length_chains(d, "m"))]
        own = [chain for chain in chains if any((x.part, x.what) == feature for x in chain.links)]
        assert own
        assert all(chain.holds for chain in own), feature
        assert not all(widened(chain, feature, step).holds for chain in own), feature


def widened(chain: Chain, feature: tuple[str, str], zone_mm: float) -> Chain:
    """The chain with one zone otherwise."""
    wide = (
        replace(x, lower_mm=-zone_mm / 2.0, upper_mm=zone_mm / 2.0) if (x.part, x.what) == feature else x
        for x in chain.links
    )
    return replace(chain, links=tuple(wide))


def test_a_tolerance_without_a_chain_and_one_tighter_than_its_chain_are_found(
    best: tuple[Dimensions, Assembly],
) -> None:
    d, assembly = best
    held = controlled(d)
    planted = held | {"platform": Controlled((Length(2, -5.25, 5.25, 0.02),))}
    assert unexplained(d, assembly, planted) == [("platform", "length", 0.02)]
    block = held["foot_block"]
    tighter = replace(block, lengths=(replace(block.lengths[0], tolerance_mm=0.005),))
    assert unexplained(d, assembly, held | {"foot_block": tighter}) == [("foot_block", "length", 0.005)]
