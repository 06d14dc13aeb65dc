"""Every row offered for a drive, in a machine: its dimensions and loads in closed form. `make offered` builds them."""

from __future__ import annotations

from functools import cache

import pytest

import delta_cad.dimensions as room
from delta_cad import catalogue
from delta_cad.structure.hardware.refusals import refusals
from tests.delta_cad.catalogue.offered import machine, offered

ROWS = offered()


def test_no_row_that_a_design_may_choose_is_left_out() -> None:
    """Motors for the capstan, and of every other family each row."""
    for family in ("cable", "bearing", "tube", "encoder", "magnet", "knob", "foot"):
        assert {f"{family} {key}" for key in catalogue.family(family)} <= set(ROWS)
    assert {f"motor {key}" for key, row in catalogue.motor.rows.items() if "capstan" in row.drives} <= set(ROWS)
    assert {f"ball {row.diameter_mm:g}" for row in catalogue.ball.rows.values()} <= set(ROWS)


def test_every_row_offered_is_in_a_machine_that_nothing_refuses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "cube_extremes", cache(room.cube_extremes))  # most are of one mechanism
    closed = {name: changes for name, changes in ROWS.items() if not name.startswith("foot ")}  # no load, no dimension
    refused = {name: list(map(str, found)) for name, changes in closed.items() if (found := refusals(machine(changes)))}
    assert not refused
