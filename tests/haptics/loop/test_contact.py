"""Drives that damp more while a wall is touched: when that is, how much, and that switching it gives nobody energy."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from delta_cad.mechanism import inverse_kinematics, jacobian
from haptics.control.controller import TOUCHED, Controller, fresh, tick
from haptics.control.supervisor.faults import FaultCode
from haptics.control.supervisor.memory import DISABLE, ENABLE, REQUEST, RESET, SIGNALS
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.control.wall_cap import UNCAPPED
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import DAMPED
from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors, stiff_plant
from haptics.loop.linear import linearise
from haptics.loop.simulation import simulate, timing
from haptics.loop.wall_trial import LOOP_SUBSTEPS
from haptics.loop.walls import closed_form
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand, Plant
from haptics.model.sensor import EXACT
from haptics.rendering import law_table
from haptics.rendering.law import GAIN, ForceLaw
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.home import Home
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import VirtualWall, axis_wall
from tests.haptics.scene_machine import WITHOUT_NOISE

T, WALL = DAMPED.period, 5000.0


@pytest.fixture(scope="module")
def controller(machine: MachineModel) -> Controller:
    return board_controller(machine, DAMPED, energy=1e3, energy_start=1e3, ramp_power=1e3, **WITHOUT_NOISE)


def touched(controller: Controller, machine: MachineModel, p: np.ndarray, *laws: ForceLaw, gain: float = 1.0) -> float:
    memory, table = fresh(controller), law_table(*laws)
    table[-1, GAIN] = gain
    memory.supervisor[REQUEST] = ENABLE
    theta = inverse_kinematics(machine.geometry, p)
    tick(controller, memory, table, 0.0, theta, theta, ALL_FRESH, np.zeros(3))
    return memory.work[TOUCHED]


@pytest.mark.parametrize("capped", [True, False])
def test_a_wall_is_touched_behind_its_face(machine: MachineModel, controller: Controller, capped: bool) -> None:
    used = controller if capped else controller._replace(walls=UNCAPPED)
    rng, c = np.random.default_rng(3), machine.centre
    others = (SpringDamper(400.0, 5.0, c + 0.01), Home(100.0, 2.0, 0.2, c), ConstantForce([1.0, 2.0, 3.0]))
    assert touched(used, machine, c, *others) == 0.0
    for normal in rng.normal(size=(8, 3)):
        n = normal / np.linalg.norm(normal)
        wall = VirtualWall(5e3, c, tuple(n), 2.0)
        for depth in (1e-6, 1e-3):
            assert touched(used, machine, c - depth * n, *others, wall) == 1.0
            assert touched(used, machine, c + depth * n, *others, wall) == 0.0
            assert touched(used, machine, c - depth * n, *others, wall, gain=0.0) == 0.0
    assert touched(used, machine, c, wall, axis_wall("+z", c[2] - 1e-3, stiffness=1.0)) == 1.0


def test_where_the_handle_is_not_known_no_wall_is_touched(controller: Controller) -> None:
    memory, wall = fresh(controller), law_table(axis_wall("+x", -1.0, stiffness=1e3))
    memory.supervisor[REQUEST] = ENABLE
    tick(controller, memory, wall, 0.0, np.full(3, np.nan), np.zeros(3), ALL_FRESH, np.zeros(3))
    assert memory.work[TOUCHED] == 0.0


def test_without_force_no_wall_is_touched(machine: MachineModel, controller: Controller) -> None:
    """Inside a wall all the time: off before enabling, after disabling, and after a fault until it is over."""
    memory, wall = fresh(controller), law_table(axis_wall("+x", machine.centre[0] - 1e-3, stiffness=1e3))
    theta, reported = inverse_kinematics(machine.geometry, machine.centre), []
    stop = FaultCode.EMERGENCY_STOP.bit
    for k, (request, signal) in enumerate(
        [(0, 0), (ENABLE, 0), (0, 0), (DISABLE, 0), (0, 0), (ENABLE, 0), (0, stop), (0, 0), (RESET, 0), (ENABLE, 0)]
    ):
        memory.supervisor[REQUEST], memory.supervisor[SIGNALS] = request, float(signal)
        tick(controller, memory, wall, k * T, theta, theta, ALL_FRESH, np.zeros(3))
        reported.append(memory.work[TOUCHED])
    assert reported == [0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]


@pytest.fixture(scope="module")
def floating(machine: MachineModel) -> MachineModel:
    required = machine.design.requirements.model_copy(update={"gravity_m_s2": (0.0, 0.0, 0.0)})
    return replace(machine, design=machine.design.model_copy(update={"requirements": required}))


def smooth(par: Plant) -> Plant:
    """Without weight and what rubs or ripples: only what is damped takes energy."""
    return par._replace(
        coulomb=0.0, arm_coulomb=0.0, ripple=0.0, cogging=0.0, gravity_x=0.0, gravity_y=0.0, gravity_z=0.0
    )


@pytest.mark.parametrize("inside", [True, False])
def test_the_handle_slows_down_as_the_drives_damp(floating: MachineModel, inside: bool) -> None:
    """Pushed off along a wall that gives no force: M v' = -J^-T b J^-1 v, after the delay of the first command."""
    par, ticks = smooth(stiff_plant(floating)), 33
    p, v = floating.centre, np.array([0.0, 2e-3, 1e-3])
    still = np.zeros((ticks, 3))
    run = simulate(
        par, board_controller(floating, DAMPED, **WITHOUT_NOISE),
        law_table(axis_wall("+x", p[0] + (-1e-3 if inside else 1e-3), stiffness=0.0)),
        timing(T, 1.5 * T, 8), np.concatenate([p, v]), hand=FREE, anchor=still, push=still, count=0.0,
    )  # fmt: skip
    here, back = linearise(par, p), np.linalg.inv(jacobian(floating.geometry, p))

    def slowed(viscous: float, seconds: float) -> np.ndarray:
        return expm(-seconds * viscous * np.linalg.solve(here.mass, back.T @ back))

    damped = par.in_contact.viscous if inside else par.viscous
    reported = slowed(damped, (ticks - 2.5) * T) @ slowed(par.viscous, 1.5 * T) @ v
    # neither J nor M changes by 0.1 % over the 10 um on which the handle moves; masses that turn push by v^2
    assert run.velocity[-1] - v == pytest.approx(reported - v, rel=0.01, abs=1e-7)


CYCLES = (1e-3, 5e-3, 0.02, 0.1)
# Poses, as shares of the cube's half side, and the axis across which the wall stands.
PLACES = (((0.0, 0.0, 0.0), 0), ((0.0, 0.0, 0.5), 2), ((0.6, 0.6, 0.6), 0), ((-0.6, 0.6, -0.6), 1))


def left_over(
    floating: MachineModel, par: Plant, cycle: float, place: tuple[float, ...] = (0.0, 0.0, 0.0), axis: int = 0,
    noisy: bool = False,
) -> float:  # fmt: skip
    """The least, over a run, of the work that was done on a handle less what it and a wall hold, J.

    The wall is of 5 N/mm, or somewhat less than is rendered there. The handle is pushed to and fro over its face, which
    it meets and leaves at each turn; `noisy` with the encoders' counts, noise and age, and the work of the force that
    the spring gives since its reading is off.
    """
    quiet = {} if noisy else WITHOUT_NOISE
    controller = board_controller(floating, DAMPED, energy=1e3, energy_start=1e3, ramp_power=1e3, **quiet)
    controller = controller._replace(force=100.0)
    held, ticks, p = round(0.7 / T), round(1.6 / T), floating.centre + floating.half_side * np.array(place)
    time, push, normal = T * np.arange(ticks - held), np.zeros((ticks, 3)), np.eye(3)[axis]
    push[held:, axis] = 0.3 + np.sign(np.sin(2.0 * np.pi * time / cycle))
    push[held:, axis] += 0.3 * np.random.default_rng(1).normal(size=ticks - held)
    cap = closed_form(controller.walls, jacobian(floating.geometry, p), normal, DAMPED.damping)[0]
    stiffness = min(WALL, 0.8 * cap)  # the same all around, where a cap would change with the pose
    age = reading_age(floating) if noisy else 0.0
    run = simulate(
        par, controller, law_table(axis_wall(f"+{'xyz'[axis]}", p[axis], stiffness=stiffness, damping=DAMPED.damping)),
        timing(T, DAMPED.delay + age, LOOP_SUBSTEPS), p, hand=Hand(mass=0.0, stiffness=2000.0, damping=20.0),
        anchor=np.tile(p, (ticks, 1)), push=push, count=encoder_count(floating) if noisy else 0.0,
        errors=sensor_errors(floating) if noisy else EXACT, held=np.arange(ticks) < held,
    )  # fmt: skip
    assert not int(np.bitwise_or.reduce(run.bits[held:]))
    depth = np.maximum(run.position[held:, axis] - p[axis], 0.0)
    assert np.count_nonzero(np.diff(depth > 0.0)) >= 2
    holds = run.energy[held:] + 0.5 * stiffness * depth**2
    work = np.cumsum(np.sum(push[held:-1] * np.diff(run.knob[held:], axis=0), axis=1))
    wrong = stiffness * (depth - np.maximum(run.measured[held:, axis] - p[axis], 0.0))  # of the force, by the readings
    mistaken = np.cumsum(np.append(0.0, wrong[:-2] * np.diff(run.position[held:, axis])[1:]))  # acts a tick later
    return float((work + mistaken - (holds[1:] - holds[0])).min())


@pytest.mark.parametrize("noisy", [False, True])
@pytest.mark.parametrize(("place", "axis"), PLACES)
def test_meeting_and_leaving_a_wall_gives_no_energy(
    floating: MachineModel, place: tuple[float, ...], axis: int, noisy: bool
) -> None:
    par = smooth(real_plant(floating, DAMPED, 0))
    least = min(left_over(floating, par, cycle, place, axis, noisy) for cycle in CYCLES)
    assert least >= (
        -1e-7 if noisy else 0.0
    )  # a 1000th of what noise does in the spring: its part in the law's damping


@pytest.mark.parametrize(("place", "axis"), PLACES)
def test_without_that_damping_the_wall_gives_energy(
    floating: MachineModel, place: tuple[float, ...], axis: int
) -> None:
    par = smooth(real_plant(floating, DAMPED, 0))._replace(contact_damping=0.0)
    assert min(left_over(floating, par, cycle, place, axis, noisy=True) for cycle in CYCLES) < -1e-5
