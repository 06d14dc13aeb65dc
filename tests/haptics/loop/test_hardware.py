"""Sensors and drives as catalogue and design tell them; the loops to choose from."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from delta_cad import catalogue
from delta_cad.design import design_from_dict
from delta_cad.dimensions import dimensions
from delta_cad.drive import drive_torque
from delta_cad.structure.beam_model import beam_model
from delta_cad.structure.compliance import cable_mm_N
from haptics.loop.assumptions import joint_friction, nominal_plant
from haptics.loop.choice import BOARD, PAPER, RATES_Hz, at_rate
from haptics.loop.hardware import (
    UNKNOWN_NOISE,
    compliance,
    drive_damping,
    reading_age,
    real_plant,
    sensor_errors,
    stiff_plant,
)
from haptics.loop.linear import linearise
from haptics.model.machine import MachineModel
from tests.committed import changed
from tests.delta_cad.dimensions.paneled import with_panel
from tests.haptics.scene_machine import MASSES


def with_hardware(**hardware: object) -> MachineModel:
    design = design_from_dict(changed(**{f"hardware__{name}": value for name, value in hardware.items()}))
    return MachineModel(design, MASSES, drive_torque(design))


def test_the_cable_is_that_of_the_structure(machine: MachineModel) -> None:
    """Beside the structure's own computation over the whole turn: ours is its softest, less what rim and shaft give."""
    whole = beam_model(dimensions(machine.design)).cable
    assert whole is not None
    cable = replace(whole, sector_mm_N=0.0, motor_mm_N=0.0)
    turned = np.linspace(-1.0, 1.0, 41)
    flexible = cable_mm_N(cable, np.stack([np.cos(turned), np.sin(turned)], axis=-1))
    softest = (cable.radius_mm**2 / flexible).min() / 1e3  # N m/rad
    assert compliance(machine).cable == pytest.approx(softest, rel=0.02)
    assert compliance(machine).structure == 1e3 * machine.design.requirements.stiffness_min_N_mm


def test_noise_and_age_are_the_catalogues() -> None:
    hall = with_hardware(encoder="as5048a-board")
    assert sensor_errors(hall).noise == pytest.approx(np.radians(0.06))
    assert sensor_errors(hall).once + sensor_errors(hall).twice == pytest.approx(0.1 * np.radians(0.8))
    fine = with_hardware(encoder="mt6825-board")
    assert sensor_errors(fine).noise == pytest.approx(UNKNOWN_NOISE)
    assert reading_age(fine) == pytest.approx(2e-6)
    assert catalogue.encoder("mt6835-board").counts_per_turn == 2**21
    finest = with_hardware(encoder="mt6835-board")
    assert sensor_errors(finest, PAPER).noise == pytest.approx(np.radians(0.0015))
    assert reading_age(finest, PAPER) == pytest.approx(10e-6)
    assert sensor_errors(hall) == sensor_errors(hall, PAPER)  # whose filter no source tells how to set
    motor = with_hardware(motor="maxon-re30-310009-500", encoder_at="motor")
    assert sensor_errors(motor) == (0.0, 0.0, 0.0, motor.drive.ratio, 1.0, 0.0)
    assert reading_age(motor) == 0.0


def test_a_slower_filter_of_the_encoder_leaves_less_noise() -> None:
    """White noise of one density through a filter of first order, stepped finely, read at the loop's rate."""
    fine = with_hardware(encoder="mt6835-board")
    rng, steps, every = np.random.default_rng(5), 2_000_000, 50
    step = BOARD.period / every
    driven = rng.standard_normal(steps)
    spread = {}
    for sensing in (1.0, 0.25):
        lag = 100e-6 / 4.0 / sensing  # settled to 2 % within four time constants
        pole = np.exp(-step / lag)
        read = lfilter([1.0 - pole], [1.0, -pole], driven)[::every]
        reported = sensor_errors(fine, replace(BOARD, sensing=sensing))
        spread[sensing] = read.std()
        assert reported.kept == pytest.approx(np.corrcoef(read[1:], read[:-1])[0, 1], abs=0.02)
    ratio = sensor_errors(fine).noise / sensor_errors(fine, PAPER).noise
    assert ratio == pytest.approx(spread[0.25] / spread[1.0], rel=0.03)
    assert reading_age(fine) - reading_age(fine, PAPER) == pytest.approx(75e-6)  # three time constants more of 25 us


def test_a_device_with_all_weighs_and_rubs_as_the_rigid_one(machine: MachineModel) -> None:
    rigid, real = nominal_plant(machine), real_plant(machine)
    assert linearise(real, machine.centre).mass == pytest.approx(linearise(rigid, machine.centre).mass, rel=1e-12)
    assert real.coulomb + real.arm_coulomb == pytest.approx(rigid.coulomb)
    assert (real.stop_low, real.stop_high) == dimensions(machine.design).stops_rad
    assert real.cogging == 0.0  # a winding without iron
    for place in (0, 2):
        assert real_plant(machine, place=place).viscous == stiff_plant(machine, place=place).viscous
        assert real_plant(machine, place=place).coulomb == joint_friction(machine).drive[place]


def test_a_motors_ripple_is_its_rows(machine: MachineModel, monkeypatch: pytest.MonkeyPatch) -> None:
    motor = catalogue.motor(machine.drive.motor)
    assert motor.commutator_segments == 13
    assert real_plant(machine).ripple_per_rad == pytest.approx(26.0 * machine.drive.ratio)
    even = replace(motor, commutator_segments=8, torque_ripple=0.0)
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", catalogue.motor.rows | {motor.id: even})
    par = real_plant(machine)
    assert (par.ripple, par.ripple_per_rad) == (0.0, pytest.approx(8.0 * machine.drive.ratio))
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", {motor.id: replace(even, commutation="brushless")})
    assert real_plant(machine).ripple_per_rad == pytest.approx(48.0 * machine.drive.ratio)


def test_a_panel_bounds_the_handle_and_a_design_without_one_does_not(machine: MachineModel) -> None:
    design = with_panel()
    par = real_plant(MachineModel(design, MASSES, drive_torque(design)))
    cube, panel = design.cube, design.panel
    assert panel is not None
    assert (par.bezel_half, par.bezel_limit) == (cube.half_side_mm / 1e3, panel.limit_mm / 1e3)
    assert par.bezel_stiffness > 0.0
    assert real_plant(machine).bezel_stiffness == 0.0


def test_a_design_that_cannot_be_built_has_no_stops(machine: MachineModel) -> None:
    broken = with_hardware(platform_thickness_mm=6.0)
    par = real_plant(broken)
    assert (par.stop_low, par.stop_high) == (-np.inf, np.inf)
    assert compliance(broken).cable == pytest.approx(compliance(machine).cable, rel=0.02)


def test_the_drives_damping_is_a_share_of_the_short_circuits(machine: MachineModel) -> None:
    """By power: a rotor driven at a rate through its resistance takes (k_t rate)^2 / R."""
    motor, rate = catalogue.motor(machine.drive.motor), 3.0
    taken = (motor.torque_constant_N_m_A * machine.drive.ratio * rate) ** 2 / motor.resistance_ohm
    assert drive_damping(machine, 1.0) * rate**2 == pytest.approx(taken)
    assert stiff_plant(machine).viscous - stiff_plant(machine, PAPER).viscous == pytest.approx(
        drive_damping(machine, BOARD.drive_damping)
    )


def test_a_faster_loop_keeps_what_is_not_its_rate() -> None:
    assert [round(1.0 / at_rate(rate).period) for rate in RATES_Hz] == [1000, 2000, 4000, 8000]
    assert replace(at_rate(8000.0), name="board") == BOARD
    assert at_rate(1000.0).current_lag == BOARD.current_lag < PAPER.current_lag
    assert at_rate(2000.0).delay == 0.25e-3
