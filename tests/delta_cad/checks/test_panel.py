"""Handle and panel: the example holds; what is made or placed wrong, or is missing, is refused, and by how much."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.attachment import check_attachment
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.checks.panel import arms_at_limit, boot_length, check_panel, room_at_limit, stem_limit
from delta_cad.checks.report import CheckResult
from delta_cad.commands.pipeline import check, check_limits
from delta_cad.dimensions import Dimensions
from delta_cad.solids import panel as solids
from delta_cad.solids.bought_parts import make_cap_screw
from delta_cad.solids.part import Part
from delta_cad.solids.platform import make_handle_stem
from tests.delta_cad.assembly.expected.comparing import make_faults, part_faults
from tests.delta_cad.dimensions.paneled import machine, with_panel


def found(assembly: Assembly | None = None, d: Dimensions | None = None) -> dict[str, CheckResult]:
    made = machine()
    limits = check_limits(made.dimensions, made.masses)
    results = check_panel(assembly or made.assembly, d or made.dimensions, limits, made.meshes)
    return {result.name: result for result in results}


def limit(assembly: Assembly) -> CheckResult:
    made = machine()
    assert made.dimensions.panel is not None
    return stem_limit(assembly, made.dimensions.panel, check_limits(made.dimensions, made.masses))


def arms(d: Dimensions) -> dict[str, CheckResult]:
    made = machine()
    return {one.name: one for one in arms_at_limit(made.assembly, d, check_limits(made.dimensions, made.masses))}


def boot(d: Dimensions) -> CheckResult:
    made = machine()
    assert d.panel is not None
    return boot_length(made.assembly, d.panel, check_limits(made.dimensions, made.masses), made.meshes)


def moved(name: str, x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Assembly:
    by = np.eye(4)
    by[:3, 3] = x, y, z
    every = machine().assembly.occurrences
    return replace(
        machine().assembly,
        occurrences=tuple(replace(o, placement=by @ o.placement) if o.name == name else o for o in every),
    )


def without(name: str) -> Assembly:
    every = machine().assembly.occurrences
    return replace(machine().assembly, occurrences=tuple(o for o in every if o.name != name))


def with_part(name: str, part: Part) -> Assembly:
    every = machine().assembly.occurrences
    return replace(machine().assembly, occurrences=tuple(replace(o, part=part) if o.name == name else o for o in every))


def panel_changed(**values: Any) -> Dimensions:
    d = machine().dimensions
    assert d.panel is not None
    return replace(d, panel=replace(d.panel, **values))


def test_the_example_holds() -> None:
    results = found()
    assert list(results) == [
        "handle limit",
        "handle limit room",
        "handle limit before stops",
        "handle limit lean",
        "boot length",
    ]
    assert all(result.passed for result in results.values())
    assert results["handle limit"].value == pytest.approx(0.0, abs=1e-6)
    # the stem, a limit beyond the cube, is the bezel's lip and the boot's cloth off the panel's edge
    room = results["handle limit room"]
    assert room.worst_pair == ("handle_stem", "panel")
    assert room.value == pytest.approx(1.0 + 0.6, abs=0.15)  # less both meshes' deviation


def test_there_is_nothing_to_check_without_a_panel() -> None:
    assert found(d=replace(machine().dimensions, panel=None)) == {}


@pytest.mark.parametrize("name", ["bezel", "handle_stem", "boot_collar"])
def test_what_is_missing_is_named(name: str) -> None:
    (result,) = found(without(name)).values()
    assert (result.passed, result.worst_pair) == (False, (name,))


def test_a_bezel_that_stands_aside_stops_the_handle_sooner() -> None:
    result = limit(moved("bezel", y=-0.1))
    assert not result.passed
    assert abs(result.value or 0.0) == pytest.approx(0.1, abs=1e-6)


@pytest.mark.parametrize("wider", [-0.2, 0.2])
def test_a_bezel_of_another_edge_is_refused_either_way(wider: float) -> None:
    made = solids.make_bezel(panel_changed(limit_mm=3.0 + wider))
    result = limit(with_part("bezel", made))
    assert not result.passed
    assert result.value == pytest.approx(wider, abs=1e-6)


def test_a_thinner_stem_goes_farther() -> None:
    d = machine().dimensions
    thin = replace(d, platform=replace(d.platform, stem_diameter_mm=9.0))
    result = limit(with_part("handle_stem", make_handle_stem(thin)))
    assert result.value == pytest.approx(0.5, abs=1e-6)


def test_a_panel_that_is_met_before_the_bezel_is_refused() -> None:
    made = machine()
    assert made.dimensions.panel is not None
    limits = check_limits(made.dimensions, made.masses)
    result = room_at_limit(moved("panel", x=1.5), made.dimensions.panel, limits, made.meshes)
    assert (result.passed, result.worst_pair) == (False, ("handle_stem", "panel"))


def test_arms_that_meet_their_stops_first_are_refused() -> None:
    d = machine().dimensions
    assert not arms(replace(d, travel=d.extremes))["handle limit before stops"].passed


def test_rods_that_lean_beyond_their_joints_are_refused() -> None:
    d = machine().dimensions
    tight = replace(d, forearm=replace(d.forearm, tilt_limit_rad=0.2))
    assert not arms(tight)["handle limit lean"].passed


def test_a_boot_that_is_too_short_is_refused_by_how_much() -> None:
    right, short = boot(machine().dimensions), boot(panel_changed(cloth_mm=90.0))
    assert right.value is not None
    assert short.value is not None
    assert not short.passed
    p = machine().dimensions.panel
    assert p is not None
    assert right.value - short.value == pytest.approx(p.cloth_mm - 90.0)
    assert right.value == pytest.approx(p.cloth_mm * 0.03 / 1.03, abs=1.5)  # what was given to it


def test_parts_over_the_machine_are_there_lie_upon_one_another_and_hang_together() -> None:
    whole, meshes, d = machine().assembly, machine().meshes, machine().dimensions
    assert part_faults(whole, d) == make_faults(whole, d) == []
    assert check_attachment(whole, meshes).passed
    for name in ("panel", "bezel", "boot", "boot_collar", "bezel_screw_2", "mount_sleeve_4"):
        assert len(part_faults(without(name), d)) == 1, name
    # what hangs on the dashboard does not hang on the base, and not the one part off the other
    assert not check_attachment(replace(whole, dashboard=()), meshes).passed
    lifted = check_attachment(moved("bezel", z=20.0), meshes)
    assert not lifted.passed


@pytest.mark.parametrize(
    ("name", "by"),
    [
        ("bezel", {"z": 0.1}),
        ("panel", {"z": -0.1}),
        ("boot", {"z": 0.1}),
        ("mount_sleeve_0", {"z": -0.1}),
        ("boot_collar", {"x": 0.5}),
        ("bezel_screw_1", {"x": 0.5}),
    ],
)
def test_what_is_off_its_seat_is_refused(name: str, by: dict[str, float]) -> None:
    result = check_contacts(moved(name, **by))
    assert not result.passed
    assert name in (result.worst_pair or ())


def test_a_screw_of_the_bezel_that_is_too_short_is_refused() -> None:
    result = check_contacts(with_part("bezel_screw_0", make_cap_screw(catalogue.screw("M3"), 5.0)))
    assert (result.passed, result.worst_pair) == (False, ("bezel_screw_0", "bezel"))


def test_solids_have_the_volumes_of_their_outlines() -> None:
    d = machine().dimensions
    p, parts = d.panel, {part.number: part for part in machine().assembly.parts}
    assert p is not None
    bores = len(p.screw_places()) * np.pi / 4 * 3.4**2
    flat = p.area_mm2(p.piece_mm) - p.area_mm2(p.opening_mm) - bores
    assert parts["panel"].solid.Volume() == pytest.approx(flat * p.thickness_mm, rel=1e-9)
    cloth = p.area_mm2(p.rim_mm) - p.area_mm2(p.opening_mm) - bores
    assert parts["boot"].solid.Volume() == pytest.approx(cloth * 0.6, rel=1e-9)
    assert (parts["boot"].mass_g or 0.0) + (parts["boot_collar"].mass_g or 0.0) == pytest.approx(p.boot_g)
    box = parts["bezel"].solid.BoundingBox()
    assert (box.xlen, box.ylen) == pytest.approx((2 * (p.half_mm + p.rim_mm),) * 2, abs=1e-6)


@pytest.mark.slow
def test_the_whole_example_passes_every_check() -> None:
    outcome = check(with_panel())
    assert outcome.passed, [result.name for result in outcome.results if not result.passed]
    names = {result.name for result in outcome.results}
    assert {"handle limit", "boot length", "assembly order", "parts attached"} <= names
