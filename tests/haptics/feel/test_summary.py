"""Best and worst of a figure with their places, the points of a cube, and other devices' figures with their sources."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.feel.page import LABELS, reference_devices
from haptics.feel.sheet import cube_points
from haptics.feel.summary import QUANTITIES, summarise
from tests.haptics.scene_machine import scene_machine


def test_best_and_worst_with_their_places() -> None:
    values = np.array([[3.0, 1.0], [2.0, 5.0]])
    positions = np.arange(12.0).reshape(2, 2, 3)
    small, large = QUANTITIES[0], replace(QUANTITIES[0], small=False)
    one = summarise(small, 2.5, values, positions)
    assert (one.best[0], one.worst[0], one.centre) == (1.0, 5.0, 2.5)
    assert one.best[1].tolist() == [3.0, 4.0, 5.0]
    assert summarise(large, 2.5, values, positions).best[1].tolist() == [9.0, 10.0, 11.0]


def test_points_fill_the_cube(best: Design) -> None:
    machine = scene_machine(best)
    p = cube_points(machine, 3, 4, 2)
    assert p.shape == (2, 4, 3, 3)
    half, low = machine.design.cube.half_side_mm, machine.design.cube.bottom_height_mm
    assert p.reshape(-1, 3).min(axis=0) * 1e3 == pytest.approx([-half, -half, low])
    assert p.reshape(-1, 3).max(axis=0) * 1e3 == pytest.approx([half, half, low + 2.0 * half])
    assert (np.ptp(p[0, 0], axis=0) > 0.0).tolist() == [True, False, False]  # the last index runs along x


def test_figures_of_other_devices_have_sources_that_were_opened() -> None:
    rows = reference_devices()
    assert {row.device.split()[-1] for row in rows} == {"omega.3", "Falcon", "Touch", "Inverse3"}
    for row in rows:
        assert row.device
        assert row.quantity in LABELS
        assert row.bound in ("", "<", ">", "~")
        assert (row.value is None) == bool(row.text)
        assert row.test.startswith("unknown")
        assert "memory" not in row.source
        assert row.source.startswith(("github.com/", "no figure was found: "))
        assert row.shown
