"""The supervisor's bound of a joint's speed holds for the true angle behind the counts of its encoder."""

import numpy as np
import pytest

from haptics.control.supervisor import memory as m
from tests.haptics.control.supervisor.rig import LIMITS, Rig

HEAVY = LIMITS._replace(joint_acceleration=1.0)
"""A joint so heavy that in a tick it gains a hundredth of a count: the counts decide the bound."""
MIDDLE = np.array([0.3, 0.4, 0.5])
"""Shoulder angles within their range, rad."""


class Counted:
    """A supervisor that reads counts of true angles; every tick is held to the bounds of the tick before."""

    def __init__(self) -> None:
        self.rig, self.true, self.read = Rig(HEAVY), np.zeros(3), np.zeros(3)
        self.bound = np.full(3, np.inf)
        self.turns(np.zeros(3))
        self.rig.supervisor.enable()
        self.turns(np.zeros(3))

    def turns(self, by: np.ndarray, dt: float = HEAVY.period) -> None:
        """Turns the joints by so many counts in a tick."""
        self.true = self.true + by
        read = np.round(self.true)
        assert (np.abs(read - self.read) * HEAVY.encoder_count <= self.bound).all(), "turned more than was reserved for"
        self.read = read
        self.rig.tick(theta=MIDDLE + read * HEAVY.encoder_count, dt=dt, margins=(1.0, 1.0))
        memory = self.rig.supervisor.memory
        fastest = memory[m.FASTEST : m.FASTEST + 3]
        assert (fastest * dt >= np.abs(by) * HEAVY.encoder_count).all(), "turned faster than the bound says"
        self.bound = memory[m.TURNS : m.TURNS + 3].copy()


def test_a_joint_that_creeps_within_its_counts() -> None:
    counted = Counted()
    counted.true = np.full(3, -0.4999)
    for _ in range(3):  # just less than a count a tick: read as 0, 1, 1 counts
        counted.turns(np.full(3, 0.9998))
    counted.turns(np.full(3, 1.5 * 0.9998), dt=HEAVY.late)  # as late as a tick in time may be; read as 2 counts


@pytest.mark.parametrize("seed", range(10))
def test_joints_that_wander(seed: int) -> None:
    rng = np.random.default_rng(seed)
    gain = HEAVY.joint_acceleration * HEAVY.period**2 / HEAVY.encoder_count  # counts a tick, gained in a tick
    counted, speed = Counted(), np.zeros(3)
    for _ in range(2000):
        speed = np.clip(speed + gain * rng.choice([-1.0, 1.0], 3), -3.0, 3.0)
        counted.turns(speed)


def test_a_bound_that_rises_with_a_late_tick_comes_down_again() -> None:
    counted = Counted()
    for _ in range(50):
        counted.turns(np.zeros(3))
    at_rest = HEAVY.encoder_count / HEAVY.period
    memory = counted.rig.supervisor.memory
    np.testing.assert_allclose(memory[m.FASTEST : m.FASTEST + 3], at_rest, rtol=1e-12)  # rounding
    counted.rig.tick(theta=MIDDLE, dt=4.0 * HEAVY.period, margins=(1.0, 1.0))
    late = 4.0 * HEAVY.period  # what it may have gained while nobody looked
    expected = HEAVY.encoder_count / late + HEAVY.joint_acceleration * late
    np.testing.assert_allclose(memory[m.FASTEST : m.FASTEST + 3], expected, rtol=1e-9)  # the clock's rounding
    counted.turns(np.zeros(3))
    assert (memory[m.FASTEST : m.FASTEST + 3] <= at_rest).all()
