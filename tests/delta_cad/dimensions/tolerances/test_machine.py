"""Chains against the machine's own geometry with every dimension off, and machines that break each of them."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from math import hypot, pi, sqrt, tau

import numpy as np
import pytest

from delta_cad.design import Design, design_from_dict, load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.tolerances import PLACE_MM, machine, preload_range_N, seat_tilt_rad, spring_height_mm
from delta_cad.dimensions.tolerances.chain import Chain
from delta_cad.dimensions.tolerances.general import flat_mm
from delta_cad.dimensions.tolerances.machine import (
    cable_chains,
    general_class,
    length_chains,
    loosest_class,
    machine_chains,
)
from delta_cad.dimensions.tolerances.record import tolerance_record
from delta_cad.mechanism import joint_angles
from tests.committed import ROOT, changed
from tests.delta_cad.catalogue.offered import offered

MACHINES = 100_000


def chain_of(d: Dimensions, name: str) -> Chain:
    (found,) = (chain for chain in machine_chains(d) if chain.name == name)
    return found


def drawn_at_random(chain: Chain, seed: int) -> dict[tuple[str, str], np.ndarray]:
    """Deviations of every link, even over its zone, (n,) mm."""
    random = np.random.default_rng(seed)
    return {(x.part, x.what): random.uniform(x.lower_mm, x.upper_mm, MACHINES) for x in chain.links}


def assert_reached(chain: Chain, figures: np.ndarray, near: float) -> None:
    """All figures lie in the worst case, to second order, and their spread is that of even deviations."""
    low, high = chain.worst
    assert low - 1e-3 <= figures.min()
    assert figures.max() <= high + 1e-3
    assert figures.mean() == pytest.approx((low + high) / 2, abs=near)
    sigma = sqrt(sum(link.half**2 for link in chain.links) / 3)
    assert figures.std() == pytest.approx(sigma, rel=0.02)


def test_spring_and_tilt_are_those_that_the_shoulder_is_made_for(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    assert d.preload is not None
    height = chain_of(d, "wave spring's height")
    assert height.worst == pytest.approx(spring_height_mm(d.preload))
    rate = d.preload.rate_N_mm
    assert rate is not None
    least = d.preload.force_N - rate * (height.worst[1] - d.preload.work_height_mm)
    assert least == pytest.approx(preload_range_N(d.preload)[0])
    assert chain_of(d, "shaft's tilt").worst[1] == pytest.approx(seat_tilt_rad(d.bracket) * 60 * 180 / pi)


def test_the_air_gap_of_shoulders_put_together_anew(best_dimensions: Dimensions) -> None:
    """Parts stacked from the motor's cheek, either way round to chip and magnet."""
    d, chain = best_dimensions, chain_of(best_dimensions, "encoder's air gap")
    off = drawn_at_random(chain, 3)
    seat, collar = d.layers.bearings_mm[1][1], d.layers.bearings_mm[1][0]
    y = seat + off["motor_cheek", "depth of the seat"] - d.bearing.width_mm - off["bearing", "width, motor's side"]
    y = y - (collar - d.layers.arm_mm[1]) - off["sector", "from the arm to its collar"]
    y = y - (d.layers.arm_mm[1] - d.layers.bearings_mm[0][1]) - off["upper_arm", "from its collar to the sector"]
    y = y - d.bearing.width_mm - off["bearing", "width, encoder's side"]
    end = y - (d.shaft.head_to_y_mm - d.shaft.y_mm[0]) - off["shoulder_shaft", "length of its head"]
    magnet = end + off["shoulder_shaft", "depth of the magnet's seat"] - off["encoder_magnet", "thickness"]
    cheek = d.layers.motor_cheek_mm[0] - (d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1])
    head = cheek - off["foot_block", "width"] - (d.layers.encoder_cheek_mm[1] - d.layers.encoder_head_mm[0])
    board = head - off["encoder_cheek", "thickness of its head"] - 5.0 - off["board_spacer", "length"]
    chip = board + d.encoder.chip_height_mm + off["encoder_board", "height of its chip"]
    assert_reached(chain, magnet - chip, 0.005)


def test_the_carriage_of_capstans_put_together_anew(best_dimensions: Dimensions) -> None:
    """The cable's way by its own geometry: arcs and crossed tangents of two circles that are off."""
    d, c = best_dimensions, best_dimensions.capstan
    assert c is not None
    chain, run = chain_of(d, "carriage's travel"), c.run
    off = drawn_at_random(chain, 4)
    moved = [
        v for (_, what), v in off.items() if "from" in what or what.startswith(("pilot", "in its", "on ", "groove"))
    ]
    apart = run.centre_distance_mm + np.sum(moved, axis=0)
    rim = run.sector_mm + off["sector", "radius of its rim"]
    pin = run.pinion_mm + off["pinion", "diameter of its groove"] / 2

    def way(rim: np.ndarray, pin: np.ndarray, apart: np.ndarray, nose: np.ndarray) -> np.ndarray:
        off_line = np.arccos((rim + pin) / apart)
        flat = 2 * np.sqrt(apart**2 - (rim + pin) ** 2)
        turned = run.stroke_rad + 2 * (run.beyond_rad + run.tangent_rad - off_line)  # between ends that stay on it
        flat = flat + rim * turned + pin * (tau * run.turns - 2 * off_line)
        return flat * hypot(1.0, run.climb) + nose * c.turns_rad[0]

    one = np.ones(1)
    drawn = way(run.sector_mm * one, run.pinion_mm * one, run.centre_distance_mm * one, c.nose_radius_mm * one)
    made = way(rim, pin, apart, c.nose_radius_mm + off["sector", "radius of its nose"])
    length = c.bench_mm[0] + off["capstan_cable", "length between its sleeves"]
    assert_reached(chain, length - c.cable_length_mm - (made - drawn), 0.01)


def test_an_upper_arm_with_its_bores_anywhere_in_their_zones(best_dimensions: Dimensions) -> None:
    """Round zones in two dimensions keep within a chain that counts along the arm alone."""
    (chain,) = (one for one in length_chains(best_dimensions, "m") if one.name == "upper arm")
    random = np.random.default_rng(5)
    ends = np.zeros((MACHINES, 2))
    for link in chain.links:
        radius, angle = link.upper_mm * np.sqrt(random.random(MACHINES)), tau * random.random(MACHINES)
        ends += radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    lengths = np.hypot(best_dimensions.arm.length_mm + ends[:, 0], ends[:, 1])
    assert chain.worst[0] <= lengths.min()
    assert lengths.max() <= chain.worst[1] + 1e-4
    assert lengths.max() > chain.rss[1]
    assert chain.links[0].half == PLACE_MM / 2


def test_a_calibrated_zero_is_that_of_positions_off_by_what_is_kept(best_dimensions: Dimensions) -> None:
    """Handles 0.1 mm off, any way, anywhere in the cube: the angles that they are taken for, by inverse kinematics."""
    d, random = best_dimensions, np.random.default_rng(11)
    cube, g = d.design.workspace, d.design.geometry
    at = random.uniform(cube.lower, cube.upper, (20_000, 3))
    at[:8] = [[x, y, z] for x in (cube.lower[0], cube.upper[0]) for y in (cube.lower[1], cube.upper[1])
              for z in (cube.lower[2], cube.upper[2])]  # fmt: skip
    off = random.normal(size=(20, 1, 3))
    off *= 1e-4 / np.linalg.norm(off, axis=-1, keepdims=True)
    turned = np.degrees(joint_angles(g, at + off) - joint_angles(g, at))
    most = chain_of(d, "encoder's zero").worst[1]
    assert 0.85 * most < np.abs(turned).max() <= 1.001 * most


def _capstan(d: Dimensions, **run: float) -> Dimensions:
    assert d.capstan is not None
    return replace(d, capstan=replace(d.capstan, run=replace(d.capstan.run, **run)))


def _of_small_arms(design: Design) -> Design:
    """A design of a third of the size: a tenth of a millimetre is a larger angle."""
    m, cube = design.mechanism, design.cube
    lengths = ("base_radius", "platform_radius", "upper_arm_length", "forearm_length", "parallelogram_width")
    small = m.model_copy(update={f"{name}_mm": getattr(m, f"{name}_mm") / 3.0 for name in lengths})
    sides = {name: getattr(cube, name) / 3.0 for name in ("bottom_height_mm", "half_side_mm")}
    return design.model_copy(update={"mechanism": small, "cube": cube.model_copy(update=sides)})


BREAKING: dict[str, Callable[[Dimensions], Dimensions]] = {
    "wave spring's height": lambda d: replace(d, preload=replace(d.preload, free_height_mm=1.5)),  # pyright: ignore
    "shaft's tilt": lambda d: replace(d, bracket=replace(d.bracket, cheek_dowel_u_mm=(46.0, 52.0))),
    "bearing's tilt, motor's side": lambda d: replace(d, bracket=replace(d.bracket, cheek_dowel_u_mm=(46.0, 52.0))),
    "bearing's tilt, encoder's side": lambda d: replace(d, bracket=replace(d.bracket, cheek_dowel_u_mm=(46.0, 52.0))),
    "encoder's air gap": lambda d: replace(d, encoder=replace(d.encoder, air_gap_max_mm=1.6)),
    "encoder's centring": lambda d: replace(d, encoder=replace(d.encoder, centring_mm=0.2)),
    "cable's plane": lambda d: _capstan(d, beyond_rad=-0.12),
    "gap of sector and pinion": lambda d: replace(
        d,
        capstan=replace(d.capstan, rim_radius_mm=d.capstan.rim_radius_mm + 0.8),  # pyright: ignore
    ),
    "carriage's travel": lambda d: _capstan(d, turns=20),
    "cheek off the plate": lambda d: replace(d, bracket=replace(d.bracket, cheek_dowel_u_mm=(48.0, 52.0))),
    "platform's twist": lambda d: replace(d, forearm=replace(d.forearm, width_mm=0.5)),
    "cup's turn in the jig": lambda d: replace(d, forearm=replace(d.forearm, cup_radius_mm=3.0)),
    "encoder's zero on its stop": lambda d: replace(d, arm=replace(d.arm, dowel_circle_mm=10.0)),
    "encoder's zero": lambda d: replace(d, design=_of_small_arms(d.design)),
}


def test_every_chain_holds_of_the_joystick_and_breaks_of_a_machine_that_is_off(best_dimensions: Dimensions) -> None:
    chains = machine_chains(best_dimensions)
    assert [chain.name for chain in chains if not chain.holds] == []
    assert {chain.name for chain in chains} == BREAKING.keys()
    for name, broken in BREAKING.items():
        assert not chain_of(broken(best_dimensions), name).holds, name


def test_a_pinion_turned_to_the_general_class_leaves_the_cable_loose(
    best_dimensions: Dimensions, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(machine, "PINION_TURNED_MM", 0.2)
    assert not {chain.name: chain for chain in cable_chains(best_dimensions, "m")}["carriage's travel"].holds


def test_the_loosest_class_is_what_drawings_ask_for(best_dimensions: Dimensions) -> None:
    assert (loosest_class(best_dimensions), general_class(best_dimensions)) == ("m", "m")
    near = replace(best_dimensions, encoder=replace(best_dimensions.encoder, air_gap_max_mm=1.75))
    assert (loosest_class(near), general_class(near)) == ("f", "f")
    roomy = replace(best_dimensions.encoder, centring_mm=2.0, air_gap_max_mm=4.0)
    roomy = _capstan(replace(best_dimensions, encoder=roomy), beyond_rad=0.2)
    assert general_class(roomy) == "m"  # no coarser than a shop is used to
    never = replace(best_dimensions, encoder=replace(best_dimensions.encoder, centring_mm=0.1))
    assert loosest_class(never) is None


def test_the_record_tells_every_link_and_is_json(best_dimensions: Dimensions) -> None:
    record = json.loads(json.dumps(tolerance_record(best_dimensions), allow_nan=False))
    assert record["general_class"] == "ISO 2768-mK"
    assert [one["name"] for one in record["chains"]] == list(BREAKING)
    for one in record["chains"] + record["lengths"]:
        low, high = one["worst"]
        assert high - low == pytest.approx(sum(b - a for a, b in (link["adds"] for link in one["links"])), abs=1e-3)
    (block,) = (x for x in record["chains"][0]["links"] if x["part"] == "foot_block")
    assert block["loosest_grade"] == "IT12"
    assert record["largest_length_deviation_mm"] > 0.0


def test_a_direct_drive_has_no_cable(best_dimensions: Dimensions) -> None:
    direct = replace(best_dimensions, capstan=None, preload=None)
    assert [c.name for c in machine_chains(direct)] == [
        "encoder's air gap", "encoder's centring", "cheek off the plate", "platform's twist", "cup's turn in the jig",
        "encoder's zero on its stop", "encoder's zero",
    ]  # fmt: skip
    assert all(chain.links for chain in length_chains(direct, "m"))


@pytest.mark.parametrize("row", ["motor maxon-re50-370354", "cable steel-0.8-7x19", "bearing 608", "ball 10"])
def test_larger_machines_hold_their_chains(row: str) -> None:
    d = dimensions(design_from_dict(changed(**offered()[row]), row))
    assert [chain.name for chain in machine_chains(d, general_class(d)) if not chain.holds] == []


def test_placed_chains_have_a_base_radius_each_and_a_plate_as_long_as_it_is() -> None:
    d = dimensions(load_design(ROOT / "best.json"))
    chains = {chain.name: chain for chain in length_chains(d, "m")}
    nominal = {name: chain.nominal for name, chain in chains.items() if "base radius" in name}
    radii = d.design.mechanism.base_radii_mm
    assert radii is not None
    out, side, _ = radii
    assert nominal == {"base radius of chain 0": out, "base radius of chains 1, 2": side}
    flat = next(link for link in chains["shoulder's height"].links if "flat" in link.what)
    assert flat.upper_mm == flat_mm(max(b - a for a, b in d.base.reach_mm), "m") / 2.0
