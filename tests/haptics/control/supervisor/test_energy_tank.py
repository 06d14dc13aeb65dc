"""The energy tank: its sum by brute force, its share the largest, and an adversary who cannot empty it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptics.control.supervisor import memory as m
from haptics.control.supervisor.energy_tank import HALVINGS, need, slewed
from haptics.control.supervisor.energy_tank import share_allowed as share_in_memory

torques = st.floats(-2.0, 2.0)
three = st.tuples(torques, torques, torques).map(np.array)
steps = st.floats(1e-3, 3.0)
turns = st.floats(0.0, 0.2)


def share_allowed(
    level: float, turns: np.ndarray, growth: float, step: float, before: np.ndarray, target: np.ndarray
) -> float:
    memory = np.zeros(m.MEMORY)
    for place, values in ((m.TURNS, turns), (m.RENDERED, before), (m.WANTED, target)):
        memory[place : place + 3] = values
    return share_in_memory(level, growth, step, memory)


@given(torques, steps, turns, turns)
@settings(deadline=None)
def test_need_is_the_sum_over_the_ticks_of_braking(torque: float, step: float, turn: float, growth: float) -> None:
    left, whole, j = abs(torque), 0.0, 0
    while left > 0.0:
        whole += left * (turn + j * growth)
        left, j = left - step, j + 1
    # up to 2000 ticks of braking, whose square enters: 4e6 roundings of 2e-16
    assert need(torque, step, turn, growth) == pytest.approx(whole, rel=1e-9, abs=1e-12)


@given(three, three, steps, st.floats(0.0, 1.0), st.tuples(turns, turns, turns).map(np.array), turns)
@settings(deadline=None)
def test_the_share_is_the_largest_that_is_allowed(
    before: np.ndarray, target: np.ndarray, step: float, level: float, turn: np.ndarray, growth: float
) -> None:
    def whole(share: float) -> float:
        return sum(
            need(slewed(share * target[i], before[i], step), step, turn[i], growth) for i in range(3)
        )  # fmt: skip

    share = share_allowed(level, turn, growth, step, before, target)
    assert 0.0 <= share <= 1.0
    if share > 0.0:
        assert whole(share) <= level
    if share < 1.0:
        assert whole(min(share + 2.0**-HALVINGS, 1.0)) >= level
    grid = [whole(s) for s in np.linspace(0.0, 1.0, 30)]
    assert np.all(np.diff(grid) >= -1e-12), "more share, less need"  # rounding of sums of order 1


@pytest.mark.parametrize("level", [np.nan, -1.0, -np.inf])
def test_a_tank_in_debt_allows_nothing(level: float) -> None:
    assert share_allowed(level, np.full(3, 0.01), 0.001, 0.1, np.zeros(3), np.ones(3)) == 0.0


@pytest.mark.parametrize("seed", range(20))
def test_an_adversary_cannot_empty_it(seed: int) -> None:
    """Joints that speed up as fast as they may, always with the torque; a scene that asks for as much as it can."""
    rng = np.random.default_rng(seed)
    dt, gain, step, capacity = 1e-3, 5.0, rng.uniform(0.05, 0.5), rng.uniform(0.02, 0.5)
    level, torque, speed, given_away = capacity, np.zeros(3), np.zeros(3), 0.0
    lowest = capacity
    for _ in range(3000):
        turn = dt * (np.abs(speed) + gain)
        wanted = rng.uniform(0.2, 1.0) * np.sign(np.where(speed == 0.0, 1.0, speed))
        share = share_allowed(level, turn, dt * gain, step, torque, wanted)
        torque = np.array([slewed(share * wanted[i], torque[i], step) for i in range(3)])
        eager = rng.random() < 0.9
        speed = speed + gain * np.sign(torque) if eager else rng.uniform(-1.0, 1.0, 3) * np.abs(speed)
        given_away += (work := float(torque @ speed) * dt)
        level = min(level - work, capacity)
        lowest = min(lowest, level)
    assert lowest >= -1e-12  # rounding
    assert lowest < 0.2 * capacity, "the adversary got nothing"
