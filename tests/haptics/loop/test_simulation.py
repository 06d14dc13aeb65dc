"""The sampled loop: torque by the book, held, late and quantised; and stable exactly where the eigenvalues say.

A wall that the passivity verdict calls passive gives no energy in the simulated loop; one that is not gives some.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from delta_cad.design import load_design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses
from delta_cad.mechanism import inverse_kinematics, jacobian
from haptics.control.controller import FACTOR, FORCE, VELOCITY, Controller, fresh, tick
from haptics.control.pose import POSITION
from haptics.control.supervisor.memory import ENABLE, REQUEST
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.gravity import gravity_torque
from haptics.loop.assumptions import (
    default_controller,
    default_estimator,
    encoder_count,
    joint_friction,
    nominal_plant,
)
from haptics.loop.discrete import Timing as LinearTiming
from haptics.loop.discrete import linear_model
from haptics.loop.linear import linearise
from haptics.loop.passivity import required_friction
from haptics.loop.simulation import SimulatedRun, simulate, timing
from haptics.model.ball_joints import ball_friction
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand, Plant
from haptics.rendering import law_table
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import axis_wall
from tests.committed import PUBLISHED
from tests.haptics.control.signals import backward_difference
from tests.haptics.scene_machine import MASSES

HOME = np.array([0.0, 0.0, 0.0946])
NOTHING = law_table(ConstantForce([0.0, 0.0, 0.0]))


@pytest.fixture(scope="module")
def controller(machine: MachineModel) -> Controller:
    return default_controller(machine)


def still(ticks: int, at: Any = HOME) -> dict[str, Any]:
    return {"hand": FREE, "anchor": np.tile(at, (ticks, 1)), "push": np.zeros((ticks, 3)), "count": 0.0}


def settled(controller: Controller, laws: np.ndarray, p: Any, ticks: int = 800) -> tuple[np.ndarray, Any]:
    """Torque and memory after the ramp, the handle not moving."""
    memory, out = fresh(controller), np.zeros(3)
    memory.supervisor[REQUEST] = ENABLE
    theta = inverse_kinematics(_geometry(controller), p)
    for k in range(ticks):
        assert (
            tick(controller, memory, laws, k * 1e-3, theta, theta, ALL_FRESH, out) & ~(1 << 19) == 0
        )  # all but the ramp's own bit
    return out, memory


def _geometry(controller: Controller) -> Any:
    from delta_cad.mechanism import DeltaGeometry

    m = controller.model
    return DeltaGeometry(0.030 + m.radius_difference, 0.030, m.upper_arm_length, m.forearm_length)


def test_the_torque_is_that_of_force_and_weight(machine: MachineModel, controller: Controller) -> None:
    p, point = np.array([0.01, -0.02, 0.1]), np.array([0.012, -0.02, 0.099])
    laws = law_table(SpringDamper(stiffness=300.0, damping=3.0, point=point), ConstantForce([0.1, 0.2, -0.3]))
    out, memory = settled(controller, laws, p)
    force = 300.0 * (point - p) + [0.1, 0.2, -0.3]
    expected = jacobian(machine.geometry, p).T @ force
    expected += gravity_torque(machine.geometry, MASSES, p, machine.design.requirements.gravity_m_s2)
    assert out == pytest.approx(expected, rel=1e-9)
    assert memory.work[FORCE] == pytest.approx(force, rel=1e-9)
    assert memory.work[POSITION] == pytest.approx(p, abs=1e-12)
    assert memory.work[VELOCITY] == pytest.approx(np.zeros(3), abs=1e-12)
    assert memory.work[FACTOR] == 1.0


def test_a_force_above_its_limit_keeps_its_direction(machine: MachineModel, controller: Controller) -> None:
    wanted = np.array([3.0, -4.0, 12.0])
    _, memory = settled(controller._replace(force=2.6), law_table(ConstantForce(wanted)), HOME)
    assert memory.work[FORCE] == pytest.approx(0.2 * wanted, rel=1e-12)
    out, memory = settled(controller, law_table(ConstantForce(3.0 * wanted)), HOME)  # more than the joints can give
    factor = memory.work[FACTOR]
    assert 0.0 < factor < 1.0
    held = gravity_torque(machine.geometry, MASSES, HOME, machine.design.requirements.gravity_m_s2)
    assert out - held == pytest.approx(factor * jacobian(machine.geometry, HOME).T @ (3.0 * wanted), rel=1e-9)
    assert np.abs(out).max() == pytest.approx(controller.limits.torque, rel=1e-12)


def test_gravity_alone_keeps_a_handle_where_it_is(machine: MachineModel, controller: Controller) -> None:
    start = np.array([0.01, 0.0, 0.0946])
    record = simulate(nominal_plant(machine), controller, NOTHING, timing(), start, **still(4000))
    assert np.abs(record.position - start).max() < 2e-3  # it sinks while gravity's torque comes in
    before, after = record.position[2000:3000].mean(axis=0), record.position[3000:].mean(axis=0)
    assert np.abs(after - before).max() < 5e-6  # swings on the bristles, held where friction caught it
    assert np.ptp(record.position[3000:], axis=0).max() < 0.3e-3
    assert (record.bits == 0).all()


def test_the_same_seed_gives_the_same_doubles(machine: MachineModel, controller: Controller) -> None:
    laws = law_table(SpringDamper(stiffness=500.0, damping=2.0, point=HOME))

    def run(seed: int) -> np.ndarray:
        more = still(300) | {"count": encoder_count(machine), "seed": seed}
        return simulate(
            nominal_plant(machine), controller, laws, timing(), np.array([0.003, 0.0, 0.0946]), **more
        ).position

    assert np.array_equal(run(1), run(1))
    assert not np.array_equal(run(1), run(2))


def test_readings_are_counts_and_half_a_count_off_at_most(machine: MachineModel, controller: Controller) -> None:
    count, more = encoder_count(machine), still(200)
    more["push"][:, 0] = 0.8
    record = simulate(nominal_plant(machine), controller, NOTHING, timing(), HOME, **(more | {"count": count}))
    read, true = (inverse_kinematics(machine.geometry, p) for p in (record.measured, record.position))
    assert np.abs(read - true).max() <= 0.5 * count * (1.0 + 1e-6)
    turns = np.diff(read, axis=0) / count
    assert turns == pytest.approx(np.round(turns), abs=1e-6)
    assert np.abs(turns).max() >= 1.0


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3, 2.7e-3])
def test_a_torque_arrives_after_its_delay(machine: MachineModel, delay: float) -> None:
    """Without weight and friction only the late torques move the handle: no motion before, motion after."""
    design = machine.design
    floating = replace(
        machine,
        design=design.model_copy(
            update={"requirements": design.requirements.model_copy(update={"gravity_m_s2": (0.0, 0.0, 0.0)})}
        ),
    )
    bare = nominal_plant(floating)._replace(coulomb=0.0, viscous=0.0, current_lag=0.0)
    laws = law_table(ConstantForce([1.0, 0.0, 0.0]))
    record = simulate(bare, default_controller(floating), laws, timing(1e-3, delay), HOME, **still(12))
    assert np.abs(record.torque[1]).max() > 0.0
    first = int(np.argmax(np.abs(record.torque).max(axis=1) > 0.0))
    moved = np.abs(record.velocity).max(axis=1) > 1e-12  # seen at the tick after
    arrived = int(np.argmax(moved))
    assert arrived == first + 1 + int(np.floor(delay / 1e-3 + 1e-9))


@pytest.mark.parametrize("delay", [0.0, 0.237e-3, 1e-3, 1.961e-3])
@pytest.mark.parametrize("substeps", [1, 2, 5])
def test_a_delay_is_kept_whatever_the_steps(machine: MachineModel, delay: float, substeps: int) -> None:
    """A rigid mass without friction, pushed from `first T + delay` on, has the velocity of the time since then."""
    required = machine.design.requirements.model_copy(update={"gravity_m_s2": (0.0, 0.0, 0.0)})
    floating = replace(machine, design=machine.design.model_copy(update={"requirements": required}))
    bare = nominal_plant(floating)._replace(coulomb=0.0, viscous=0.0, current_lag=0.0)
    laws, ticks = law_table(ConstantForce([1e-2, 0.0, 0.0])), 12
    unbounded = {"slew": 1e9, "ramp": 1e-9, "ramp_power": 1e9}
    controller = default_controller(floating, **unbounded)
    record = simulate(bare, controller, laws, timing(1e-3, delay, substeps), HOME, **still(ticks))
    first = int(np.argmax(np.abs(record.torque).max(axis=1) > 0.0))
    assert np.ptp(record.torque[first:], axis=0) == pytest.approx(np.zeros(3), abs=1e-7)
    reported = (np.arange(ticks) - first) * 1e-3 - delay
    mass = linearise(bare, HOME).mass
    gained = np.linalg.solve(mass, np.array([1e-2, 0.0, 0.0]))[0] * np.maximum(reported, 0.0)
    assert record.velocity[:, 0] == pytest.approx(gained, rel=1e-3, abs=1e-9)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_it_is_stable_where_the_eigenvalues_are(machine: MachineModel, axis: str) -> None:
    """The whole nonlinear loop in the small against the exact linear one: no count, no Coulomb friction, in a wall."""
    hand, damping, delay, lag = Hand(0.2, 5.0, 300.0), 8.0, 0.5e-3, 0.2e-3
    par = nominal_plant(machine)._replace(coulomb=0.0, viscous=1e-3, current_lag=lag)
    estimator = backward_difference(1e-3)
    normal = np.eye(3)["xyz".index(axis)]
    model = linear_model(estimator)
    loop = linearise(par, HOME).joint_loop(normal, hand, LinearTiming(1e-3, delay, lag), model)
    limit = loop.stiffness_limit(damping).value
    # pressed into the wall once it is there, so that it is not left
    unbounded = {"energy": 1e3, "energy_start": 1e3, "ramp_power": 1e3, "frozen_torque": np.inf}
    controller = default_controller(machine, estimator=estimator, **unbounded)
    growth = []
    depth = 0.2e-3
    for share in (0.95, 1.05):
        stiffness = share * limit
        face = float(HOME @ normal) - depth
        wall = axis_wall(f"+{axis}", face, stiffness=stiffness, damping=damping, blend=1e-6)
        more = still(3000) | {"hand": hand}
        more["push"][:] = np.clip((np.arange(3000) - 1000) / 500.0, 0.0, 1.0)[:, None] * normal * stiffness * depth
        more["push"][2000] += 0.02 * normal
        record = simulate(par, controller, law_table(wall), timing(1e-3, delay), HOME, **more)
        along = record.position @ normal
        early, late = np.ptp(along[2050:2250]), np.ptp(along[2750:2950])
        growth.append(late / early)
    assert growth[0] < 0.9
    assert growth[1] > 1.1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"period": 0.0}, "period is"),
        ({"period": float("nan")}, "period is"),
        ({"delay": -1e-3}, "delay is"),
        ({"delay": 1.0}, "delay is"),
        ({"substeps": 0}, "substeps is"),
    ],
)
def test_clocks_that_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        timing(**arguments)


def test_runs_that_are_refused(machine: MachineModel, controller: Controller) -> None:
    par = nominal_plant(machine)
    with pytest.raises(ValueError, match=r"push \(4, 3\)"):
        simulate(par, controller, NOTHING, timing(), HOME, **(still(5) | {"push": np.zeros((4, 3))}))
    with pytest.raises(ValueError, match=r"count is -1\.0"):
        simulate(par, controller, NOTHING, timing(), HOME, **(still(5) | {"count": -1.0}))


def test_friction_comes_from_the_idle_torque(machine: MachineModel) -> None:
    friction = joint_friction(machine)
    idle = 0.16 * 25.9e-3  # A times N m/A, RE 30
    balls = ball_friction(machine.design, machine.centre)
    drive = [whole - share for whole, share in zip(friction.coulomb, balls, strict=True)]
    assert friction.drive == pytest.approx(drive)
    assert drive[2] == pytest.approx(machine.drive.ratio * idle, rel=0.01)
    assert drive[1] + friction.viscous[1] * 900.0 / machine.drive.ratio == pytest.approx(drive[2], rel=1e-9)
    assert sorted(friction.viscous) == list(friction.viscous)
    assert default_estimator(2e-3).pole == pytest.approx(np.exp(-2.0 * np.pi * 100.0 * 2e-3))


PUBLISHED_MASSES = Masses(0.074, 0.0013, -0.0003, 1.5e-4, 0.002, 0.00075, 0.002, 3.25e-4)
STIFFNESS, DELAY, TICKS, BEGIN = 1500.0, 0.5e-3, 6000, 1000
GUIDE = Hand(0.0, 60.0, 20e3)
UNBOUNDED = {"energy": 1e3, "energy_start": 1e3, "ramp_power": 1e3, "frozen_torque": np.inf}


@pytest.fixture(scope="module")
def floating() -> MachineModel:
    design = load_design(PUBLISHED)
    floating = design.requirements.model_copy(update={"gravity_m_s2": (0.0, 0.0, 0.0)})
    design = design.model_copy(update={"requirements": floating})
    return MachineModel(design, PUBLISHED_MASSES, drive_torque(design))


def pushed(floating: MachineModel, par: Plant, count: float, frequency: float) -> SimulatedRun:
    """The handle is led in and out of a wall, all the time inside it, by 0.5 mm about a depth of 1 mm."""
    wall = law_table(axis_wall("+x", -1e-3, stiffness=STIFFNESS))
    controller = default_controller(floating, estimator=backward_difference(1e-3), **UNBOUNDED)
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


def taken_from_the_hand(floating: MachineModel, par: Plant, record: SimulatedRun, frequency: float) -> float:
    """Work of the motors and of the friction against the handle's motion over whole swings, J: what a hand pays."""
    swings = round((TICKS - 2 * BEGIN) * 1e-3 * frequency)
    rows = slice(2 * BEGIN - 1, 2 * BEGIN - 1 + round(swings / frequency / 1e-3) + 1)
    p, v = record.position[rows], record.velocity[rows]
    rates = np.linalg.solve(jacobian(floating.geometry, p), v[..., None])[..., 0]
    power = par.viscous * (rates**2).sum(axis=1)
    # the motors' torque is held between arrivals: by the angle that the joints turn, half a tick with each torque
    turned = 0.5e-3 * (rates[1:] + rates[:-1])
    held = 0.5 * (record.torque[rows][:-1] + np.vstack([record.torque[rows.start - 1], record.torque[rows][:-2]]))
    return float(np.trapezoid(power, dx=1e-3) - (held * turned).sum())


@pytest.mark.parametrize("frequency", [2.0, 5.0, 10.0])
def test_a_passive_wall_takes_energy_and_one_that_is_not_gives_it(floating: MachineModel, frequency: float) -> None:
    model = linear_model(backward_difference(1e-3))
    demand = required_friction(LinearTiming(1e-3, DELAY), model, STIFFNESS, 0.0).friction
    bare = nominal_plant(floating)._replace(coulomb=0.0, current_lag=0.0, viscous=1.0)
    per_viscous = linearise(bare, HOME).effective_friction([1.0, 0.0, 0.0])
    passive, active = (bare._replace(viscous=share * demand / per_viscous) for share in (1.1, 0.3))
    paid, got = (
        taken_from_the_hand(floating, par, pushed(floating, par, 0.0, frequency), frequency)
        for par in (passive, active)
    )
    assert paid > 0.0
    assert got < 0.0
    # with counts: half of one at the handle, times the stiffness, times the way
    count = encoder_count(floating)
    counted = taken_from_the_hand(floating, passive, pushed(floating, passive, count, frequency), frequency)
    swings = round((TICKS - 2 * BEGIN) * 1e-3 * frequency)
    at_handle = 0.5 * count * np.abs(jacobian(floating.geometry, HOME)[0]).sum()
    assert counted > -STIFFNESS * at_handle * 4.0 * 0.5e-3 * swings
