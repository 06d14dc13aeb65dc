"""Readings: noise by its statistics, the error's lines over a turn, counts, and the twist before the cable."""

from __future__ import annotations

import numpy as np
import pytest

from haptics.model.sensor import EXACT, PHASE, SensorErrors, reading

ANGLES = np.linspace(0.0, 2.0 * np.pi, 512, endpoint=False)


def read(errors: SensorErrors, angle: float, normal: float = 0.0, count: float = 0.0, twist: float = 0.0) -> float:
    return reading(errors, 1, angle, twist, normal, count, 0.25)


def test_an_exact_reading_is_the_angle() -> None:
    assert read(EXACT, 0.3, 1.7, twist=0.1) == 0.3
    assert abs(read(EXACT, 0.3, count=1e-3) - 0.3) <= 0.5e-3


def test_noise_has_the_deviation_that_is_given() -> None:
    normal = np.random.default_rng(0).standard_normal(20_000)
    seen = np.array([read(SensorErrors(noise=2e-3), 0.3, x) for x in normal])
    assert seen.std() == pytest.approx(2e-3 * normal.std(), rel=1e-9)
    coarse = np.array([read(SensorErrors(noise=2e-3), 0.3, x, 1e-3) for x in normal])
    # counts add their own variance, count^2 / 12 (Sheppard), where the noise is wider than they are
    assert coarse.std() == pytest.approx(np.hypot(seen.std(), 1e-3 / np.sqrt(12.0)), rel=0.01)


def test_the_error_has_one_and_two_waves_a_turn() -> None:
    errors = SensorErrors(once=1e-3, twice=4e-4)
    lines = np.fft.rfft([read(errors, a) - a for a in ANGLES]) / len(ANGLES) * 2.0
    assert np.abs(lines[1:3]) == pytest.approx([1e-3, 4e-4], rel=1e-9)
    assert np.angle(lines[1]) == pytest.approx(PHASE - np.pi / 2.0)
    assert np.abs(np.delete(lines, [1, 2])).max() < 1e-15


def test_a_sensor_on_the_motor_sees_the_twist() -> None:
    assert read(SensorErrors(at_motor=1.0), 0.3, twist=0.02) == pytest.approx(0.32)
    errors = SensorErrors(once=1e-3, turns=4.0)
    lines = np.fft.rfft([read(errors, a) - a for a in ANGLES]) / len(ANGLES) * 2.0
    assert np.abs(lines[4]) == pytest.approx(1e-3)
