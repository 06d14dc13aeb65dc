"""Noise: the covariance beside the simulated device in time, beside a closed form, and its figures' order."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from haptics.control.filters import low_pass
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import BOARD, DAMPED, at_rate
from haptics.loop.discrete import Timing, axis, linear_model, loaded, sampled_loop
from haptics.loop.hardware import (
    LOSS,
    UNKNOWN_NOISE,
    board_controller,
    reading_age,
    real_plant,
    sensor_errors,
)
from haptics.loop.noise import BARELY, FORCE, MOTION, NoisyLoop, covariance, noise_range
from haptics.loop.simulation import simulate, timing
from haptics.loop.wall_trial import LOOP_SUBSTEPS
from haptics.loop.walls import WallStability
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.model.sensor import SensorErrors
from haptics.rendering import law_table
from haptics.rendering.laws.spring import SpringDamper
from haptics.scenes.noise import in_band
from tests.haptics.control.signals import backward_difference
from tests.haptics.loop.noise.built import structured, with_structure

T = DAMPED.period


def test_a_stiff_hold_passes_noise_as_it_is() -> None:
    """A handle that nothing moves: u = -K w - B (w - w before) / T, whose variance is plain."""
    model = linear_model(backward_difference(T))
    fixed = loaded(axis(1.0, 1e3), np.eye(1), stiffness=1e6)  # gives by 5e-4 of what is asked
    _, command = covariance(sampled_loop(fixed, Timing(T), model), 500.0, 0.3, np.array([[4e-12]]))
    assert float(command[0, 0]) == pytest.approx(4e-12 * ((500.0 + 0.3 / T) ** 2 + (0.3 / T) ** 2), rel=5e-3)
    smooth = linear_model(low_pass(T, 300.0))
    pole = np.exp(-2.0 * np.pi * 300.0 * T)
    _, command = covariance(sampled_loop(fixed, Timing(T), smooth), 0.0, 0.3, np.array([[4e-12]]))
    share = 2.0 * (1.0 - pole) ** 2 / (1.0 + pole)  # of white noise through (1 - a)(1 - 1/z) / (1 - a/z)
    assert float(command[0, 0]) == pytest.approx(4e-12 * (0.3 / T) ** 2 * share, rel=5e-3)


@pytest.mark.parametrize(
    ("stiffness", "damping", "noise", "kept"),
    [(400.0, 20.0, UNKNOWN_NOISE, 0.3), pytest.param(2000.0, 4.0, 2e-4, 0.0, marks=pytest.mark.slow)],
)
def test_the_simulated_device_shakes_as_the_covariance_says(
    machine: MachineModel, stiffness: float, damping: float, noise: float, kept: float
) -> None:
    """Monte Carlo: the whole nonlinear device in time, but friction that sticks; force and motion to 2 %."""
    ticks, skip, late = 200_000, 8_000, DAMPED.delay + reading_age(machine)
    par = real_plant(machine, DAMPED)._replace(coulomb=0.0, arm_coulomb=0.0)
    controller = board_controller(machine, DAMPED, energy=1e3, energy_start=1e3, ramp_power=1e3)
    laws = law_table(SpringDamper(stiffness=stiffness, damping=damping, point=machine.centre))
    still = np.tile(machine.centre, (ticks, 1))
    record = simulate(
        par, controller, laws, timing(T, late, LOOP_SUBSTEPS), machine.centre, hand=FREE, anchor=still,
        push=np.zeros((ticks, 3)), count=0.0, errors=SensorErrors(noise=noise, kept=kept), seed=3,
    )  # fmt: skip
    loop = NoisyLoop(machine, DAMPED, noise=noise, kept=kept)
    state, command = covariance(loop.loop, stiffness, damping, loop.error, kept)
    force = np.cov(record.force[skip:].T, bias=True)
    assert np.sqrt(np.diag(force)) == pytest.approx(np.sqrt(np.diag(command)), rel=0.02)
    n = loop.place.shape[1]
    reported = loop.place @ state[:n, :n] @ loop.place.T
    moved = np.cov(record.knob[skip:].T, bias=True)
    assert np.sqrt(np.trace(moved)) == pytest.approx(np.sqrt(np.trace(reported)), rel=0.02)
    narrow = np.cov(in_band(record.knob[skip:], T).T, bias=True)
    figures = loop.figures(stiffness, damping)
    assert np.sqrt(np.linalg.eigvalsh(narrow)[-1]) == pytest.approx(figures.motion, rel=0.02)
    assert np.sqrt(np.linalg.eigvalsh(command)[-1]) == figures.force


def test_figures_grow_with_noise_and_damping(machine: MachineModel) -> None:
    fine, coarse = (NoisyLoop(machine, DAMPED, noise=noise).figures(400.0, 5.0) for noise in (UNKNOWN_NOISE, 1e-3))
    assert coarse.force / fine.force == pytest.approx(1e-3 / UNKNOWN_NOISE)
    assert coarse.motion / fine.motion == pytest.approx(1e-3 / UNKNOWN_NOISE)
    assert fine.quiet
    assert not coarse.quiet
    loop = NoisyLoop(machine, DAMPED)
    limit = loop.damping_limit(400.0)
    assert loop.figures(400.0, 0.98 * limit).force < FORCE < loop.figures(400.0, 1.02 * limit).force
    assert NoisyLoop(machine, DAMPED, noise=0.1).damping_limit(400.0) == 0.0


def test_motion_limits_the_damping_too(machine: MachineModel) -> None:
    """On the structure of its parts, which rings in the band, motion is at its limit before force is."""
    loop = NoisyLoop(with_structure(machine), BOARD)
    limit = loop.damping_limit(400.0)
    assert limit > 0.0
    below, above = (loop.figures(400.0, share * limit) for share in (0.98, 1.02))
    assert below.motion < MOTION < above.motion
    assert above.force < FORCE
    assert below.over_threshold == pytest.approx(below.motion / 1e-8)


def test_a_loop_that_is_not_stable_has_no_figures(machine: MachineModel) -> None:
    figures = NoisyLoop(machine, at_rate(1000.0, DAMPED)).figures(400.0, 60.0)
    assert not figures.steady
    assert not figures.quiet
    assert figures.force == figures.motion == np.inf


def test_the_filter_is_chosen_for_the_noise(machine: MachineModel) -> None:
    """500 Hz: a spring may damp more than with 300 Hz and the encoders as the maker sets them; faster, far less."""
    allowed = NoisyLoop(machine, DAMPED).damping_limit(400.0)
    assert allowed > 1.2 * NoisyLoop(machine, replace(DAMPED, corner=300.0, sensing=1.0)).damping_limit(400.0)
    assert NoisyLoop(machine, replace(DAMPED, corner=1000.0)).damping_limit(400.0) < 0.6 * allowed
    assert WallStability(machine, DAMPED).stable(FREE) > 0.97 * WallStability(
        machine, replace(DAMPED, corner=1000.0)
    ).stable(FREE)


def test_the_default_wall_is_quiet_with_every_hand(machine: MachineModel) -> None:
    """5 N/mm at the centre, the structure as soft as asked: at most 0.05 N rms and 0.05 um rms in 150 to 500 Hz."""
    for hand in HANDS.values():
        for normal in np.eye(3):
            assert NoisyLoop(machine, DAMPED, hand=hand, normal=normal).figures(5000.0, DAMPED.damping).quiet


def test_the_range_of_noise_holds_structures_and_damping(machine: MachineModel) -> None:
    """A knob that rings within the band moves far more than one on the softest structure, which rings below it."""
    walls = [(np.eye(3)[0], 5000.0, DAMPED.damping)]
    found = noise_range(machine, DAMPED, machine.centre, walls)
    soft = NoisyLoop(machine, DAMPED, normal=np.eye(3)[0]).figures(5000.0, DAMPED.damping)
    assert found.least.motion < soft.motion < 0.3 * found.most.motion
    assert found.most.force == pytest.approx(soft.force, rel=0.1)  # which the structure hardly changes
    noise = sensor_errors(machine).noise
    assert found.reading < noise  # the default encoder's noise is not below what that asks for
    here = math.hypot(noise, encoder_count(machine) / math.sqrt(12.0))
    assert found.reading / here == pytest.approx(MOTION / found.most.motion)
    plain, x = real_plant(machine, DAMPED, 0), np.eye(3)[0]
    for share in np.geomspace(1.0, 10.0, 41):  # between the structures of the range, too, where it is 5.1 % more

        def moved(loss: float, noise: float | None = None, share: float = share) -> float:
            par = structured(plain, share * plain.structure_stiffness, loss)
            return (
                NoisyLoop(machine, DAMPED, noise=noise, hand=BARELY, normal=x, par=par)
                .figures(5000.0, DAMPED.damping)
                .motion
            )

        assert moved(LOSS[0]) <= 1.06 * found.most.motion
        assert moved(LOSS[0], found.reading) <= 1.06 * MOTION
        assert moved(found.loss) <= 1.06 * MOTION
    assert LOSS[0] < found.loss < LOSS[1]  # as much as is assumed would do
