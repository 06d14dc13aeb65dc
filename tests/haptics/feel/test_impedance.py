"""Impedance off the centre against the simulated loop: a force that swings on the handle, and how fast that moves."""

from __future__ import annotations

import numpy as np
import pytest

import haptics.feel.loops
from delta_cad.mechanism import jacobian
from haptics.control.wall_cap import UNCAPPED
from haptics.feel.loops import DEFAULT_WALL, LoopLimits, Plane, places, plane
from haptics.loop.choice import BOARD, DAMPED
from haptics.loop.hardware import board_controller, reading_age, real_plant
from haptics.loop.simulation import simulate, timing
from haptics.loop.wall_trial import LOOP_SUBSTEPS
from haptics.loop.walls import WallStability, closed_form, proven_cap
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand
from haptics.rendering import law_table
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.virtual_wall import axis_wall
from tests.haptics.scene_machine import WITHOUT_NOISE

LEAN, SWING = 2.0, 0.2  # N: presses the handle into the wall, and swings about that
HELD, SETTLES, CYCLES = 0.7, 0.8, 30  # s held till all force has come in, s to settle; cycles that are measured
HOLD = Hand(mass=0.0, stiffness=2000.0, damping=20.0)


def simulated(machine: MachineModel, place: Plane, frequency: float, wall: bool) -> float:
    """|Z| from the Fourier coefficient of the handle's way, nothing linearised; no friction that sticks."""
    inwards = -1.0 if place.position[0] > 0.0 else 1.0
    period = DAMPED.period
    cycle = round(1.0 / (frequency * period))
    let_go = round(HELD / period)
    settles = let_go + round(SETTLES / period)
    ticks = settles + CYCLES * cycle
    w = 2.0 * np.pi / (cycle * period)
    push = np.zeros((ticks, 3))
    push[let_go:, 0] = SWING * np.cos(w * period * np.arange(ticks - let_go))
    law = law_table(ConstantForce([0.0, 0.0, 0.0]))
    if wall:
        push[let_go:, 0] += inwards * LEAN
        name = "+x" if inwards > 0.0 else "-x"
        law = law_table(axis_wall(name, place.position[0], stiffness=place.wall, damping=place.damping, blend=2e-5))
    plain = real_plant(machine, DAMPED)._replace(coulomb=0.0, arm_coulomb=0.0, ripple=0.0, cogging=0.0)
    run = simulate(
        plain,
        board_controller(machine, DAMPED, **WITHOUT_NOISE)._replace(walls=UNCAPPED),
        law,
        timing(period, DAMPED.delay + reading_age(machine), LOOP_SUBSTEPS),
        place.position,
        hand=HOLD,
        held=np.arange(ticks) < let_go,
        anchor=np.tile(place.position, (ticks, 1)),
        push=push,
        count=0.0,
    )
    assert not int(np.bitwise_or.reduce(run.bits[settles:]))
    turns = np.exp(-1j * w * period * np.arange(settles, ticks))
    way = (run.knob[settles:, 0] - run.knob[-1, 0]) * 2.0 * np.hanning(ticks - settles)  # without what still drifts
    held = np.sinc(w * period / 2.0 / np.pi)  # a force that is held for a period swings by less
    return held * SWING / (w * abs(2.0 * np.mean(way * turns)))


def plane_at(machine: MachineModel, name: str) -> Plane:
    """Impedance along x at a place, drives that damp and a wall of `DEFAULT_WALL` at most; no K-B plane."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(haptics.feel.loops, "RATES_Hz", ())
        patch.setattr(haptics.feel.loops, "DAMPINGS", (0.0,))
        cap, p = proven_cap(machine, DAMPED), places(machine, DAMPED)[name]
        stiffest = closed_form(cap, jacobian(machine.geometry, p), np.array([1.0, 0.0, 0.0]))[0]
        held = cap._replace(share=cap.share * min(1.0, DEFAULT_WALL / stiffest))
        return plane(machine, LoopLimits(DAMPED, {}, held), BOARD, p, "x")


def test_the_places_are_the_cube_s(machine: MachineModel) -> None:
    found = places(machine)
    assert np.abs(found["worst corner"] - machine.centre) == pytest.approx(np.full(3, machine.half_side))
    assert found["floor's middle"] == pytest.approx(machine.centre - [0.0, 0.0, machine.half_side])
    one = plane_at(machine, "worst corner")
    mass = WallStability(machine, p=one.position).here.effective_mass([1.0, 0.0, 0.0])
    w = 2.0 * np.pi * 10.0
    low = np.interp(10.0, WallStability(machine).at_handle().frequency / (2.0 * np.pi), one.lower)
    assert low == pytest.approx(w * mass, rel=0.25)  # and the joints' damping
    assert one.wall <= DEFAULT_WALL * (1.0 + 1e-12)


@pytest.mark.parametrize("frequency", [40.0, 100.0])
@pytest.mark.parametrize("wall", [False, True])
@pytest.mark.parametrize("name", ["floor's middle", "worst corner"])
def test_the_simulated_loop_has_that_impedance(machine: MachineModel, name: str, wall: bool, frequency: float) -> None:
    place = plane_at(machine, name)
    known = WallStability(machine).at_handle().frequency / (2.0 * np.pi)
    reported = np.interp(frequency, known, place.upper if wall else place.lower)
    assert simulated(machine, place, frequency, wall) == pytest.approx(reported, rel=0.03)
