"""Supervisor and exact plant in one loop: energy to the hand, coming in inside a wall, and what it leaves alone."""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import pytest

from delta_cad.mechanism import inverse_kinematics, jacobian
from delta_cad.mechanism.forward import platform_positions
from haptics.control.pose_margins import pose_margins
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.faults import FaultCode, State
from haptics.control.supervisor.limits import SafetyLimits
from haptics.control.supervisor.safety import Supervisor
from haptics.gravity import gravity_torque
from haptics.model.plant import FREE, STATES, Hand, advance, energy
from tests.haptics.control.supervisor.rig import GEOMETRY, HOME, LIMITS, MASSES, PLANT

LIGHT = Hand(0.1, 3.0, 200.0)
DRAG = Hand(0.0, 2.0, 0.0)
SOFT = Hand(0.0, 0.5, 40.0)
DOWN = (0.0, 0.0, -9.81)
Law = Callable[[np.ndarray, np.ndarray], np.ndarray]


@dataclass
class Loop:
    """A scene on the plant, its angles quantised, its exact ones kept."""

    law: Law
    hand: Hand = FREE
    limits: SafetyLimits = LIMITS
    start: np.ndarray = field(default_factory=HOME.copy)
    supervised: bool = True

    def __post_init__(self) -> None:
        self.supervisor = Supervisor(self.limits)
        self.state = np.zeros(STATES)
        self.state[:3] = self.start
        self.anchor = self.start.copy()
        self.velocity, self.p = np.zeros(3), None
        self.theta: list[np.ndarray] = []
        self.rendered: list[np.ndarray] = []
        self.places: list[np.ndarray] = []
        self.seen: set[FaultCode] = set()
        self.now = 0.0

    def run(self, ticks: int, until: State | None = None) -> "Loop":
        room, out = np.zeros((13, STATES)), np.zeros(3)
        for _ in range(ticks):
            exact = inverse_kinematics(GEOMETRY, self.state[:3])
            theta = np.round(exact / self.limits.encoder_count) * self.limits.encoder_count
            p = platform_positions(GEOMETRY, theta)
            if self.p is not None:
                self.velocity += 0.2 * ((p - self.p) / 1e-3 - self.velocity)
            self.p = p
            torque = jacobian(GEOMETRY, p).T @ self.law(p, self.velocity)
            gravity = gravity_torque(GEOMETRY, MASSES, p, DOWN)
            self.supervisor.check(self.now, theta, p, *pose_margins(PLANT, p))
            self.supervisor.limit(torque, gravity, out)
            rendered = self.supervisor.memory[m.RENDERED : m.RENDERED + 3].copy()
            if not self.supervised:
                rendered = torque
                out = torque + gravity
            self.theta.append(exact)
            self.rendered.append(rendered)
            self.places.append(self.state[:3].copy())
            self.seen.update(self.supervisor.present)
            advance(PLANT, self.hand, self.anchor, np.zeros(3), out, 1e-3, 4, self.state, room)
            self.now += 1e-3
            if until is not None and self.supervisor.state is until:
                break
        return self

    def enable(self) -> "Loop":
        self.run(1)
        self.supervisor.enable()
        return self

    def given(self) -> tuple[np.ndarray, np.ndarray]:
        """Energy given to the mechanism tick by tick from the exact angles, and half a count for each change, J."""
        theta, rendered = np.array(self.theta), np.array(self.rendered)
        work = (rendered[:-1] * np.diff(theta, axis=0)).sum(axis=1)
        change = np.abs(np.diff(rendered, axis=0, prepend=0.0)).sum(axis=1)[:-1]
        return work, 0.5 * self.limits.encoder_count * change


def rising(steps: np.ndarray) -> float:
    """The largest sum over any window."""
    total = np.concatenate([[0.0], np.cumsum(steps)])
    return float((total - np.minimum.accumulate(total)).max())


def fastest(loop: Loop, ticks: int) -> float:
    """The largest kinetic energy of the machine while the loop runs, J."""
    return max(energy(PLANT, 0.0, loop.run(1).state)[0] for _ in range(ticks))


def pushing(p: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A scene that is a mistake: damping with the wrong sign, held in the cube by a spring."""
    push = 12.0 * v + 0.5 * np.sign(v) + 200.0 * (HOME - p)
    return push * min(1.0, 3.0 / max(float(np.linalg.norm(push)), 1e-9))


def to_home(p: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The paper's resistance without its dead zone, at 3 N."""
    away = HOME - p
    distance = np.linalg.norm(away)
    return min(400.0 * distance, 3.0) * away / max(distance, 1e-9) - 5.0 * v


def wall(p: np.ndarray, _v: np.ndarray) -> np.ndarray:
    """Below the home position, 4 N/mm."""
    return np.array([0.0, 0.0, 4000.0 * max(HOME[2] - p[2], 0.0)])


@pytest.mark.quick(1)
@pytest.mark.parametrize("hand", [SOFT, LIGHT], ids=["soft", "light"])
def test_a_scene_that_makes_energy_gives_no_more_than_the_tank(hand: Hand) -> None:
    limits = LIMITS._replace(energy=0.02, energy_start=0.02, speed=20.0, edge_margin=0.03, edge_far=0.04)
    loop = Loop(pushing, hand, limits).enable()
    loop.run(520)
    loop.state[3:6] += [0.1, 0.02, -0.05]
    loop.run(1000)
    work, allowance = loop.given()
    ends = limits.encoder_count * 3.0 * limits.torque
    assert rising(work - allowance) <= limits.energy + ends
    assert rising(work) > 0.8 * limits.energy, "it never asked for the energy"
    assert FaultCode.ENERGY_LIMITED in loop.seen
    assert loop.supervisor.memory[m.TANK] >= 0.0


def test_the_same_scene_without_the_supervisor_gives_more() -> None:
    limits = LIMITS._replace(energy=0.02, energy_start=0.02)
    loop = Loop(pushing, LIGHT, limits, supervised=False)
    loop.state[3:6] = [0.1, 0.02, -0.05]
    work, allowance = loop.run(300).given()
    assert rising(work - allowance) > 2.0 * limits.energy


@pytest.mark.slow
def test_a_handle_in_the_corner_goes_home_and_the_supervisor_has_nothing_to_say() -> None:
    corner = HOME + 0.9 * np.array([0.0375, -0.0375, 0.0375])
    loop = Loop(to_home, start=corner).enable().run(2500)
    assert loop.supervisor.state is State.ACTIVE
    assert loop.seen == {FaultCode.RAMP_HELD}
    assert np.linalg.norm(loop.state[:3] - HOME) < 5e-4  # 3 counts of 0.03 mm in each of three joints
    work, _ = loop.given()
    assert rising(work) < LIMITS.energy


def test_a_wall_that_is_hit_is_rendered_to_the_last_digit() -> None:
    loop = Loop(wall, LIGHT).enable().run(600)
    before = len(loop.rendered)
    loop.state[3:6] = [0.0, 0.0, -0.2]
    loop.run(60)
    assert loop.supervisor.present == ()
    worst = max(np.abs(loop.rendered[k]).max() for k in range(before, len(loop.rendered)))
    assert worst > 0.05
    assert loop.places[before + 12][2] < HOME[2]
    assert loop.state[2] > HOME[2], "thrown back"


def test_enabled_inside_a_wall_the_handle_is_let_out_and_not_thrown_out() -> None:
    depth = 0.002
    stored = 0.5 * 4000.0 * depth**2
    inside = HOME - [0.0, 0.0, depth]
    thrown = Loop(wall, DRAG, start=inside, supervised=False)
    assert fastest(thrown, 30) > 0.9 * stored
    loop = Loop(wall, DRAG, start=inside).enable()
    assert fastest(loop, 1200) < 0.2 * stored
    assert loop.state[2] > HOME[2] - 1e-4, "it came out"
    assert loop.supervisor.state is State.ACTIVE


def test_enabled_inside_a_wall_under_a_hand_that_holds_the_force_comes_in() -> None:
    firm = Hand(0.5, 30.0, 8000.0)
    loop = Loop(wall, firm, start=HOME - [0.0, 0.0, 0.002]).enable().run(1500)
    assert loop.supervisor.state is State.ACTIVE
    deep = HOME[2] - loop.state[2]
    # the wall of 4 N/mm against the hand of 8 N/mm, 2 mm apart; the encoder's 0.03 mm of 1.3 mm
    assert deep == pytest.approx(0.002 * 8000.0 / 12000.0, rel=0.03)


def test_the_braking_reaction_takes_energy_and_does_not_buzz() -> None:
    loop = Loop(lambda _p, v: 0.0 * v).enable().run(600)
    loop.state[3:6] = [0.0, 0.0, 1.2]
    loop.supervisor.limits = LIMITS._replace(speed=1.0, kink=np.inf)  # at once at that speed
    loop.run(1, until=State.FAULT)
    loop.run(20, until=State.FAULT)
    assert loop.supervisor.latched == (FaultCode.OVERSPEED,)
    kinetic = energy(PLANT, 0.0, loop.state)[0]
    loop.run(40)
    slower = energy(PLANT, 0.0, loop.state)[0]
    assert slower < 0.6 * kinetic
    work, allowance = loop.given()
    assert rising((work - allowance)[600:]) < 1e-4
