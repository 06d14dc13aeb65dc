"""Ways to a seat: where they are free, and where closed form says that something is met."""

from __future__ import annotations

from math import inf

import numpy as np
import pytest

from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.order.paths import LEAST_MM, SLIDE_MM, Met, Ways
from delta_cad.solids.part import Part
from tests.delta_cad.checks.contact.order.blocks import case, hooked, lid, on_base, pin, plate
from tests.delta_cad.checks.machines import box, part, rod

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def met(moving: Part, *others: Part, legs: list[tuple[np.ndarray, float]]) -> Met | None:
    a = on_base(moving, *others)
    ways = Ways(a, MeshLibrary(a.parts))
    return ways.met([moving.number], [other.number for other in others], legs)


@pytest.mark.parametrize("along", [Z, -Z])
def test_a_pin_goes_into_its_bore_along_its_axis(along: np.ndarray) -> None:
    assert met(pin(), plate(), legs=[(along, inf)]) is None


@pytest.mark.parametrize("along", [X, -X, (X + Z) / np.sqrt(2.0)])
def test_it_does_not_go_in_across_it(along: np.ndarray) -> None:
    found = met(pin(), plate(), legs=[(along, inf)])
    assert found is not None
    assert (found.moving, found.other) == ("pin", "plate")
    assert found.out_mm <= LEAST_MM + SLIDE_MM


@pytest.mark.parametrize("gap", [0.5, 3.0, 40.0, 400.0])
def test_a_thin_lid_on_its_way_is_met_where_it_is(gap: float) -> None:
    """The pin comes from above; its lower end meets the lid's upper face when it is `gap` + 20 mm over its seat."""
    found = met(pin(20.0), plate(), lid(20.0 + gap), legs=[(-Z, inf)])
    assert found is not None
    assert found.other == "lid"
    assert gap <= found.out_mm <= gap + 2 * LEAST_MM


def test_what_is_behind_it_is_no_obstacle() -> None:
    assert met(pin(20.0), plate(), lid(30.0), legs=[(Z, inf)]) is None


def test_a_part_in_a_closed_case_has_no_way() -> None:
    """Neither surface meets the other at the seat."""
    inside = part("inside", box((-3, -3, -3), (3, 3, 3)))
    for along in (X, -X, Z, -Z):
        found = met(inside, case(), legs=[(along, inf)])
        assert found is not None
        assert found.out_mm == pytest.approx(2.0, abs=2 * LEAST_MM)


def test_a_slot_with_a_bend_needs_two_legs() -> None:
    """The block sits at the end of the slot, 9 mm aside and 20 mm below its mouth."""
    block = part("block", box((6.5, -2.5, 10.5), (11.5, 2.5, 15.5)))
    assert met(block, hooked(), legs=[(-Z, inf), (X, 9.0)]) is None
    for legs in ([(-Z, inf)], [(X, inf)], [(-Z, inf), (X, 4.0)], [(X, inf), (-Z, 20.0)]):
        assert met(block, hooked(), legs=legs) is not None, legs


def test_pieces_of_one_part_do_not_meet() -> None:
    from dataclasses import replace

    from delta_cad.solids.part import Fit

    a = on_base(pin(), plate())
    whole = replace(a, fits=(Fit("pin", "plate", "piece"),))
    for machine, free in ((a, False), (whole, True)):
        ways = Ways(machine, MeshLibrary(machine.parts))
        assert (ways.met(["pin"], ["plate"], [(X, inf)]) is None) is free


@pytest.mark.parametrize("height", [5.0, 17.0, 60.0])
def test_a_thin_disc_does_not_pass_a_thin_roof(height: float) -> None:
    """The roof's posts stand beside the disc from the start: only the distance says how far it may go unseen."""
    disc = part("disc", rod(5, (0, 0, 0), (0, 0, 1.5)))
    posts = box((-15, -15, -5), (-12, 15, height)).fuse(box((12, -15, -5), (15, 15, height)))
    portal = part("portal", posts.fuse(box((-15, -15, height), (15, 15, height + 1.5))))
    found = met(disc, portal, legs=[(-Z, inf)])
    assert found is not None
    assert height - 1.5 <= found.out_mm <= height - 1.5 + 2 * LEAST_MM
    assert met(disc, portal, legs=[(Z, inf)]) is None
