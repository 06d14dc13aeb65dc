"""The bezel holds the handle where the square of the cube, with its limit around it, ends; it never pulls."""

from __future__ import annotations

import numpy as np
import pytest

from haptics.model.drive_train import KNOB
from haptics.model.plant import Hand, Plant, plant
from tests.haptics.model.test_plant import GEOMETRY, HOME, MASSES, acceleration, run, state_of

HALF, LIMIT, STIFFNESS, PUSH = 0.008, 0.003, 2e4, 3.0
SLOW = Hand(0.0, 6.0, 0.0)  # nothing but a damper: what it comes to is where the forces hold one another


def free() -> Plant:
    return plant(GEOMETRY, MASSES, (0.0, 0.0, 0.0), viscous=2e-3)


def bounded(par: Plant, damping: float = 20.0) -> Plant:
    return par._replace(bezel_half=HALF, bezel_limit=LIMIT, bezel_stiffness=STIFFNESS, bezel_damping=damping)


@pytest.mark.parametrize("way", [(1.0, 0.0), (0.0, -1.0), (-1.0, 1.0)])
def test_the_stem_rests_on_the_bezel_with_the_push_over_its_stiffness(way: tuple[float, float]) -> None:
    out = np.array([*way, 0.0]) / np.hypot(*way)
    state = run(bounded(free()), state_of(HOME), 2.0, 20000, force=PUSH * out, hand=SLOW)
    beyond = state[:2] - np.clip(state[:2], -HALF, HALF)  # from the square, which it slides along
    assert np.hypot(*beyond) == pytest.approx(LIMIT + PUSH / STIFFNESS, abs=2e-6)
    assert beyond @ out[:2] == pytest.approx(np.hypot(*beyond), abs=2e-6)
    assert np.abs(state[3:6]).max() < 1e-3


def test_where_the_structure_gives_way_it_is_the_stem_that_is_held() -> None:
    par = free()
    soft = bounded(
        par._replace(platform=par.platform - 0.03, knob=0.03, structure_stiffness=5e3, structure_damping=3.0)
    )
    state = run(soft, state_of(HOME), 2.0, 40000, force=np.array([PUSH, 0.0, 0.0]), hand=SLOW)
    assert state[0] + state[KNOB] == pytest.approx(HALF + LIMIT + PUSH / STIFFNESS, abs=5e-6)


def test_it_pushes_back_when_met_and_holds_nothing_that_leaves() -> None:
    par, met = free(), bounded(free(), damping=200.0)
    at = HOME + np.array([HALF + LIMIT + 1e-4, 0.0, 0.0])
    into, leaving = state_of(at, [0.1, 0.0, 0.0]), state_of(at, [-5.0, 0.0, 0.0])
    assert (acceleration(met, into) - acceleration(par, into))[0] < 0.0
    assert np.array_equal(acceleration(met, leaving), acceleration(par, leaving))


def test_within_the_limit_nothing_is_felt() -> None:
    for x, y in ((HALF + 0.99 * LIMIT, 0.0), (HALF + 0.7 * LIMIT, -HALF - 0.7 * LIMIT), (0.0, HALF)):
        inside = state_of(HOME + np.array([x, y, 0.0]), [0.1, -0.1, 0.1])
        assert np.array_equal(acceleration(bounded(free()), inside), acceleration(free(), inside))
