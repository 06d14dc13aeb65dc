"""What the records of bores add to a drawing's callouts: deviations, drill, surface, each once."""

from __future__ import annotations

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.holes import hole_groups, recorded
from delta_cad.export.drawings.sheet_io.lettering import SURFACE
from delta_cad.solids.boring import along_z, blind, fitted, group, tapped, within
from delta_cad.solids.part import Bore

PLAIN = along_z(8.0, (0.0, 0.0), (0.0, 10.0))


@pytest.mark.parametrize(
    ("callout", "bore", "wording"),
    [
        ("Ø8 through", PLAIN, "Ø8 through"),
        ("2x Ø8 H7 through", fitted(PLAIN, "H7"), f"2x Ø8 H7 (+0.015/0) through {SURFACE}Ra 1.6"),
        ("Ø8 G7 x 4", fitted(blind(PLAIN), "G7"), f"Ø8 G7 (+0.02/+0.005) x 4 {SURFACE}Ra 1.6"),
        ("Ø8 through, bonded", within(PLAIN, 0.0, 20.0), "Ø8 +0.02/0 through, bonded"),
        ("Ø8 x 4, eroded", within(blind(PLAIN), -20.0, 20.0), "Ø8 ±0.02 x 4, eroded"),
        ("Ø8 +0.02 through", within(PLAIN, 0.0, 20.0), "Ø8 +0.02 through"),
        ("M4 x 6", tapped(PLAIN, "M4", 6.0), "M4 x 6, drilled 8.5 deep"),
        ("M4 x 6, drilled 8.5 deep", tapped(PLAIN, "M4", 6.0), "M4 x 6, drilled 8.5 deep"),
        ("M4 through", tapped(PLAIN, "M4"), "M4 through"),
    ],
)
def test_a_callout_gets_what_is_missing(callout: str, bore: Bore, wording: str) -> None:
    assert recorded(callout, group("", [bore])) == wording


def test_bores_of_one_diameter_that_differ_add_nothing() -> None:
    assert recorded("Ø8 through", group("", [PLAIN, fitted(PLAIN, "H7")])) == "Ø8 through"


def test_every_fit_of_the_joystick_is_reported_with_its_deviations_and_surface(best_assembly: Assembly) -> None:
    for part in best_assembly.parts:
        if not part.make:
            continue
        lines = [
            line
            for one in hole_groups(part, faces_of(part.solid))
            for callout in one.callout
            for line in callout.split("\n")
        ]
        for fit in {(b.fit, b.surface_um) for hole in part.holes for b in hole.bores if b.fit}:
            own = [line for line in lines if f" {fit[0]} (" in line]
            assert own, part.number
            assert all(line.endswith(f"Ra {fit[1]:g}") and line.count("Ra") == 1 for line in own), part.number
