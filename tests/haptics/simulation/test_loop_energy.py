"""A wall that the passivity verdict calls passive gives no energy in the simulated loop; one that is not gives some."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import load_design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses
from delta_cad.mechanism import jacobian
from haptics.control.filters import backward_difference
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand, Plant
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.simulation.assumptions import default_controller, encoder_count, nominal_plant
from haptics.simulation.loop import SimulatedRun, simulate, timing
from haptics.stability.discrete import Timing as LinearTiming
from haptics.stability.estimator_models import linear_models
from haptics.stability.linear import linearise
from haptics.stability.passivity import required_friction
from tests.committed import PUBLISHED

MASSES = Masses(0.074, 0.0013, -0.0003, 1.5e-4, 0.002, 0.00075, 0.002, 3.25e-4)
HOME = np.array([0.0, 0.0, 0.0946])
STIFFNESS, DELAY, TICKS, BEGIN = 1500.0, 0.5e-3, 6000, 1000
GUIDE = Hand(0.0, 60.0, 20e3)
UNBOUNDED = {"energy": 1e3, "energy_start": 1e3, "ramp_power": 1e3, "frozen_torque": np.inf}


@pytest.fixture(scope="module")
def machine() -> MachineModel:
    design = load_design(PUBLISHED)
    floating = design.requirements.model_copy(update={"gravity_m_s2": (0.0, 0.0, 0.0)})
    design = design.model_copy(update={"requirements": floating})
    return MachineModel(design, MASSES, drive_torque(design))


def pushed(machine: MachineModel, par: Plant, count: float, frequency: float) -> SimulatedRun:
    """The handle is led in and out of a wall, all the time inside it, by 0.5 mm about a depth of 1 mm."""
    wall = law_table(axis_wall("+x", -1e-3, stiffness=STIFFNESS))
    controller = default_controller(machine, estimator=backward_difference(1e-3), **UNBOUNDED)
    anchor = np.tile(HOME, (TICKS, 1))
    swing = 0.5e-3 * np.sin(2.0 * np.pi * frequency * (np.arange(TICKS) - BEGIN) * 1e-3)
    anchor[BEGIN:, 0] += swing[BEGIN:]
    return simulate(
        par,
        controller,
        wall,
        timing(1e-3, DELAY, 20),
        HOME,
        hand=GUIDE,
        anchor=anchor,
        push=np.zeros((TICKS, 3)),
        count=count,
    )


def taken_from_the_hand(machine: MachineModel, par: Plant, record: SimulatedRun, frequency: float) -> float:
    """Work of the motors and of the friction against the handle's motion over whole swings, J: what a hand pays."""
    swings = round((TICKS - 2 * BEGIN) * 1e-3 * frequency)
    rows = slice(2 * BEGIN - 1, 2 * BEGIN - 1 + round(swings / frequency / 1e-3) + 1)
    p, v = record.position[rows], record.velocity[rows]
    rates = np.linalg.solve(jacobian(machine.geometry, p), v[..., None])[..., 0]
    power = par.viscous * (rates**2).sum(axis=1)
    # the motors' torque is held between arrivals: by the angle that the joints turn, half a tick with each torque
    turned = 0.5e-3 * (rates[1:] + rates[:-1])
    held = 0.5 * (record.torque[rows][:-1] + np.vstack([record.torque[rows.start - 1], record.torque[rows][:-2]]))
    return float(np.trapezoid(power, dx=1e-3) - (held * turned).sum())


@pytest.mark.parametrize("frequency", [2.0, 5.0, 10.0])
def test_a_passive_wall_takes_energy_and_one_that_is_not_gives_it(machine: MachineModel, frequency: float) -> None:
    (model,) = linear_models(backward_difference(1e-3))
    demand = required_friction(LinearTiming(1e-3, DELAY), model, STIFFNESS, 0.0).friction
    bare = nominal_plant(machine)._replace(coulomb=0.0, current_lag=0.0, viscous=1.0)
    per_viscous = linearise(bare, HOME).effective_friction([1.0, 0.0, 0.0])
    passive, active = (bare._replace(viscous=share * demand / per_viscous) for share in (1.1, 0.3))
    paid, got = (
        taken_from_the_hand(machine, par, pushed(machine, par, 0.0, frequency), frequency) for par in (passive, active)
    )
    assert paid > 0.0
    assert got < 0.0
    # with counts: half of one at the handle, times the stiffness, times the way
    count = encoder_count(machine)
    counted = taken_from_the_hand(machine, passive, pushed(machine, passive, count, frequency), frequency)
    swings = round((TICKS - 2 * BEGIN) * 1e-3 * frequency)
    at_handle = 0.5 * count * np.abs(jacobian(machine.geometry, HOME)[0]).sum()
    assert counted > -STIFFNESS * at_handle * 4.0 * 0.5e-3 * swings
