"""What the base stands on: feet and their threads, sleeves, neither; the order and the counts say the same."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from delta_cad.assembly.order.panel import mounting_steps, panel_steps
from delta_cad.assembly.panel import panel_contacts, panel_supplies
from delta_cad.solids.base_plate import make_base_plate, mount_places
from delta_cad.solids.panel import make_mount_sleeve
from tests.delta_cad.assembly.expected.parts import expected_parts
from tests.delta_cad.dimensions.paneled import of_panel

MOUNTINGS = [(None, 3, 0), ("feet", 3, 0), ("screws", 0, 0), ("both", 3, 6)]


@pytest.mark.parametrize(("mounting", "feet", "sleeves"), MOUNTINGS)
def test_what_stands_under_the_base_is_stated_and_has_its_holes(mounting: str | None, feet: int, sleeves: int) -> None:
    d = of_panel(hardware__mounting=mounting)
    counts = {row.names: row.count for row in expected_parts(d)}
    assert counts.get("foot_?", 0) == feet
    assert counts.get("mount_sleeve_?", 0) == sleeves
    assert len([c for c in panel_contacts(d) if c.a.startswith("mount_sleeve")]) == sleeves
    callouts = " ".join(hole.callout for hole in make_base_plate(d).holes)
    assert ("M4" in callouts) == (feet > 0)  # a thread that holds nothing is a fault
    screwed = mounting in ("screws", "both")
    supplied = {supply.number: supply.quantity for supply in panel_supplies(d)}
    assert supplied.get("mount_screw", 0) == (6 if screwed else 0)
    names = tuple(f"mount_sleeve_{k}" for k in range(sleeves))
    steps = mounting_steps(d, names)
    assert len(steps) == int(screwed)
    assert [name for step in steps for bring in step.brings for name in bring.names] == list(names)


def test_a_sleeve_goes_over_its_hole_and_beside_every_foot() -> None:
    d = of_panel()
    part = make_mount_sleeve(d)
    ring = pi / 4 * (10.0**2 - 5.5**2)
    assert part.solid.Volume() == pytest.approx(ring * 7.5, rel=1e-9)
    feet = d.base.foot_circle_mm / 2 * np.array([[np.cos(a), np.sin(a)] for a in (pi / 3, pi, 5 * pi / 3)])
    apart = np.linalg.norm(np.array(mount_places(d))[:, None] - feet, axis=-1).min()
    assert apart > (d.foot.diameter_mm + 10.0) / 2


def test_without_a_panel_nothing_comes_over_the_handle() -> None:
    d = of_panel(panel=None, hardware__mounting=None)
    assert panel_steps(d, ()) == []
    assert panel_contacts(d) == ()
    assert panel_supplies(d) == ()
