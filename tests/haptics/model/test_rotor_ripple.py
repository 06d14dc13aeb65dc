"""The waves of a motor follow its rotor, which is a cable's twist ahead of the arm."""

from __future__ import annotations

import math

import numpy as np
import pytest

from haptics.model.drive_train import PHASE, ROTOR_RATE, STATES, TWIST, drive_torque
from haptics.model.plant import plant
from tests.haptics.model.test_plant import GEOMETRY, MASSES


@pytest.mark.parametrize("chain", range(3))
def test_ripple_and_cogging_follow_the_rotor_behind_its_cable(chain: int) -> None:
    """Rotor of 2e-5 kg m^2 at 0.1 N m, cable of 600 N m/rad twisted by 0.004 rad: the arm's own angle would give
    another wave, 0.5 rad of ripple and 0.19 of cogging away."""
    par = plant(GEOMETRY, MASSES, (0.0, 0.0, 0.0))._replace(
        rotor_inertia=2e-5,
        cable_stiffness=600.0,
        cable_damping=0.02,
        viscous=1e-3,
        ripple=0.05,
        ripple_per_rad=125.0,
        cogging=3e-3,
        cogging_per_rad=48.0,
    )
    angle, rate, twist, turning, current = 0.3, 0.5, 0.004, 0.8, 0.1
    state, out = np.zeros(STATES), np.zeros(STATES)
    state[TWIST + chain], state[ROTOR_RATE + chain] = twist, turning
    given = drive_torque.py_func(par, chain, current, state, np.zeros(6), angle, rate, out)
    cable = 600.0 * 0.004 + 0.02 * (0.8 - 0.5)
    wave = 0.05 * math.sin(125.0 * 0.304 + PHASE * chain)
    motor = 0.1 * (1.0 + wave) + 3e-3 * math.sin(48.0 * 0.304 + PHASE * chain)
    assert given == pytest.approx(cable, rel=1e-12)
    assert out[ROTOR_RATE + chain] == pytest.approx((motor - 1e-3 * 0.8 - cable) / 2e-5, rel=1e-12)
    assert out[TWIST + chain] == pytest.approx(0.3, rel=1e-12)
