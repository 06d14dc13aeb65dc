"""Calibration of machines whose chains do not stand alike: planted errors are found, and the file is read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism.chains import chain_positions
from haptics.calibration.accuracy import accuracy
from haptics.calibration.fit import Noise, fit
from haptics.calibration.record import calibration_of, load_calibration, save_calibration
from haptics.calibration.unknowns import ZERO, nominal, sigmas
from tests.haptics.calibration.devices import cube_points, made, measured, readings
from tests.haptics.calibration.test_fit import NOISE, error
from tests.haptics.model.textbook import textbook
from tests.haptics.scene_machine import PLACED

placed = pytest.mark.parametrize("design", PLACED.values(), ids=list(PLACED))


@placed
def test_the_drawn_machine_is_the_textbook_s(design: Design) -> None:
    book, p = textbook(design), cube_points(design, np.random.default_rng(2), 20)
    theta = np.array([book.angles(one) for one in p])
    drawn = nominal(design.geometry)
    np.testing.assert_allclose(chain_positions(drawn.mechanism, theta), p, atol=1e-12)
    np.testing.assert_allclose(readings(drawn, p), theta, atol=1e-12)


@placed
def test_planted_errors_are_found_and_read_back(design: Design, tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    device = made(design, rng)
    poses = measured(device, cube_points(design, rng, 60), rng)
    found = fit(design.geometry, poses, noise=NOISE)
    assert 0.7 < found.misfit < 1.3
    score = (found.unknowns.table - device.table) / found.sigma
    assert np.abs(score).max() < 4.5
    assert found.unknowns.table[:, ZERO] == pytest.approx(device.table[:, ZERO], abs=2e-3)
    fresh = cube_points(design, rng, 60)
    read = readings(device, fresh)
    assert error(nominal(design.geometry), read, fresh) > 10.0 * error(found.unknowns, read, fresh)
    known = accuracy(found, design)
    assert np.abs(known.worst_at - design.workspace.centre).max() == pytest.approx(design.workspace.half_side, rel=1e-9)
    save_calibration(calibration_of(design, found, 60, known), tmp_path / "calibration.json")
    again = load_calibration(tmp_path / "calibration.json", design).unknowns
    assert error(again, read, fresh) == pytest.approx(error(found.unknowns, read, fresh), rel=1e-6)


@placed
def test_exact_poses_give_the_device_back(design: Design) -> None:
    rng = np.random.default_rng(3)
    device, p = made(design, rng), cube_points(design, rng, 80)
    poses = measured(device, p, rng, position=0.0, angle=0.0)
    found = fit(design.geometry, poses, noise=Noise(1e-9, 1e-10))
    off = (found.unknowns.table - device.table) / sigmas()
    together = found.unknowns.mechanism.radius_difference - device.mechanism.radius_difference
    assert np.abs(off[:, 2:]).max() < 1e-3
    assert np.abs(together).max() < 1e-7
