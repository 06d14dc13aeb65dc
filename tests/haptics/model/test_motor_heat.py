"""Motor temperatures: the matrix exponential, the steady state by hand, I2t at its peak time, the whole catalogue."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from delta_cad import catalogue
from delta_cad.catalogue import Motor
from haptics.model.motor_heat import COPPER, DERATE_K, Heat, allowed, hold_time, motor_heat, warmed

MOTORS = [m for m in catalogue.family("motor").values() if isinstance(m, Motor)]
KNOWN = [m for m in MOTORS if m.thermal_resistance_winding_housing_K_W is not None]
UNKNOWN = [m for m in MOTORS if m.thermal_resistance_winding_housing_K_W is None]
DRIVE = 9.456


def after(heat: Heat, torque: float, seconds: float, dt: float = 1e-3) -> tuple[float, float]:
    winding = housing = heat.ambient
    for _ in range(round(seconds / dt)):
        winding, housing = warmed(heat, winding, housing, torque, dt)
    return winding, housing


def test_there_are_motors_of_both_kinds() -> None:
    assert len(KNOWN) >= 3
    assert len(UNKNOWN) >= 2


@pytest.mark.parametrize("motor", KNOWN, ids=lambda m: m.id)
def test_two_bodies_follow_the_matrix_exponential(motor: Motor) -> None:
    heat = motor_heat(motor, DRIVE)._replace(slope=0.0)
    inner, outer = motor.thermal_resistance_winding_housing_K_W, motor.thermal_resistance_housing_ambient_K_W
    time = motor.thermal_time_constant_winding_s
    assert inner is not None
    assert outer is not None
    assert time is not None
    torque = 0.7 * heat.continuous
    watts = motor.resistance_ohm * (torque / DRIVE / motor.torque_constant_N_m_A) ** 2
    capacity, body = time / inner, motor.mass_g * 0.45
    rates = np.array(
        [
            [-1.0 / (inner * capacity), 1.0 / (inner * capacity)],
            [1.0 / (inner * body), -1.0 / (inner * body) - 1.0 / (outer * body)],
        ]
    )
    steady = -np.linalg.solve(rates, [watts / capacity, 0.0])
    np.testing.assert_allclose(steady, [watts * (inner + outer), watts * outer])
    rise = steady - expm(rates * 30.0) @ steady
    # Euler's steps of 1 ms over time constants of 12 s and more: 1 ms / 12 s = 8e-5
    np.testing.assert_allclose(np.array(after(heat, torque, 30.0)) - 25.0, rise, rtol=1e-4)


def test_the_warm_winding_has_the_resistance_of_warm_copper() -> None:
    heat = motor_heat(catalogue.motor("maxon-re30-310007"), DRIVE)
    cold, _ = warmed(heat, 25.0, 25.0, 0.5, 1e-3)
    warm, _ = warmed(heat, 100.0, 100.0, 0.5, 1e-3)
    assert (warm - 100.0) / (cold - 25.0) == pytest.approx(1.0 + 75.0 * COPPER)
    cool, _ = warmed(heat, 0.0, 0.0, 0.5, 1e-3)
    assert cool == pytest.approx(cold - 25.0)


@pytest.mark.parametrize("motor", MOTORS, ids=lambda m: m.id)
def test_continuous_torque_is_never_too_hot_and_the_peak_lasts_its_time(motor: Motor) -> None:
    heat = motor_heat(motor, DRIVE)
    winding = housing = heat.ambient
    for _ in range(20_000):  # 1 s steps are far below the winding's time constant
        winding, housing = warmed(heat, winding, housing, heat.continuous, 1.0)
    assert winding < heat.hottest
    winding, _ = after(heat, DRIVE * motor.peak_torque_N_m, motor.peak_time_s)
    assert winding <= heat.hottest * (1.0 + 1e-4)  # of the unknown ones it is the largest, up to Euler's steps


@pytest.mark.parametrize("motor", UNKNOWN, ids=lambda m: m.id)
def test_without_thermal_data_the_peak_time_decides(motor: Motor) -> None:
    heat = motor_heat(motor, DRIVE, ambient_C=60.0)
    assert (heat.ambient, heat.hottest, heat.coupling, heat.slope) == (0.0, 1.0, 0.0, 0.0)
    winding, housing = after(heat, DRIVE * motor.peak_torque_N_m, motor.peak_time_s)
    assert winding == pytest.approx(1.0, rel=1e-4)  # Euler: 1 ms over 17 s
    assert housing == 0.0
    longer, _ = after(heat, DRIVE * motor.peak_torque_N_m, 1.01 * motor.peak_time_s)
    assert longer > 1.0


def test_a_motor_without_a_peak_may_give_its_continuous_torque_always() -> None:
    """The rise approaches the largest as 1 - exp(-t / T), and never takes any torque back."""
    motor = replace(UNKNOWN[0], peak_torque_N_m=UNKNOWN[0].nominal_torque_N_m, peak_time_s=1.0)
    heat = motor_heat(motor, DRIVE)
    winding, _ = after(heat, heat.continuous, 2.0)
    assert winding == pytest.approx(1.0 - np.exp(-2.0), rel=1e-3)
    winding, _ = after(heat, heat.continuous, 30.0)
    assert heat.derate < winding <= heat.hottest
    assert allowed(heat, DRIVE * motor.peak_torque_N_m, winding) == pytest.approx(heat.continuous)


@pytest.mark.parametrize("motor", KNOWN, ids=lambda m: m.id)
def test_there_are_seconds_between_warm_and_hot(motor: Motor) -> None:
    assert motor.thermal_time_constant_winding_s is not None
    heat = motor_heat(motor, DRIVE)
    rate = heat.heat * (DRIVE * motor.peak_torque_N_m) ** 2
    slow = 5.9 if motor.thermal_time_constant_winding_s < 30.0 else 1.7  # K/s; RE 50: a winding of 72 s
    assert slow < rate < 10.0
    assert heat.hottest - heat.derate == DERATE_K


def test_a_long_interval_does_not_overshoot() -> None:
    heat = motor_heat(catalogue.motor("maxon-re30-310007"), DRIVE)
    winding, _ = warmed(heat, 100.0, 30.0, 0.0, 1e9)
    assert 30.0 < winding < 100.0


def test_the_allowed_torque_falls_from_the_limit_to_the_continuous_one() -> None:
    heat = motor_heat(catalogue.motor("maxon-re30-310007"), DRIVE)
    assert allowed(heat, 2.0, 20.0) == 2.0
    assert allowed(heat, 2.0, heat.derate) == 2.0
    assert allowed(heat, 2.0, heat.hottest) == pytest.approx(heat.continuous)
    assert allowed(heat, 2.0, heat.derate + 15.0) == pytest.approx((2.0 + heat.continuous) / 2.0)
    assert allowed(heat, 2.0, 500.0) == pytest.approx(heat.continuous)
    assert allowed(heat, 0.1, 500.0) == 0.1


@pytest.mark.parametrize("drive", [0.0, -1.0, float("nan"), float("inf")])
def test_a_drive_that_is_none_is_refused(drive: float) -> None:
    with pytest.raises(ValueError, match=r"^drive is"):
        motor_heat(MOTORS[0], drive)


@pytest.mark.parametrize("ambient", [95.0, float("nan")])
def test_air_that_is_too_hot_is_refused(ambient: float) -> None:
    with pytest.raises(ValueError, match=r"^ambient_C is .* 95 C"):
        motor_heat(catalogue.motor("maxon-re30-310007"), DRIVE, ambient)


@pytest.mark.parametrize("motor", KNOWN, ids=lambda m: m.id)
def test_a_torque_may_be_held_as_long_as_its_integration_says(motor: Motor) -> None:
    """Integrated step by step, the resistance following the temperature; cold, and warm from the continuous torque."""
    heat = motor_heat(motor, DRIVE)
    for share in (1.3, 2.0, 3.0):
        torque = share * heat.continuous
        for before, limit in ((0.0, heat.hottest), (0.0, heat.derate), (heat.continuous, heat.hottest)):
            winding = housing = heat.ambient
            for _ in range(40_000 if before else 0):  # s, many times the slowest constant
                winding, housing = warmed(heat, winding, housing, before, 1.0)
            time = 0.0
            while winding < limit:
                winding, housing = warmed(heat, winding, housing, torque, 5e-3)
                time += 5e-3
            # Euler's steps of 5 ms over time constants of 12 s and more, and the last step
            assert hold_time(heat, torque, limit, before) == pytest.approx(time, rel=2e-3, abs=1e-2)
    assert hold_time(heat, heat.continuous, heat.hottest) == np.inf
    assert hold_time(heat, 2.0 * heat.continuous, heat.ambient) == 0.0


def test_without_thermal_data_no_time_is_reported() -> None:
    with pytest.raises(ValueError, match="not known"):
        hold_time(motor_heat(UNKNOWN[0], DRIVE), 1.0, 1.0)
