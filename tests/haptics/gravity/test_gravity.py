"""Holding torque: against the solids' potential energy, a gradient through the forward kinematics, and the paper."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.holding import holding_torque
from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses, PointMasses, masses_from_dict
from delta_cad.export.mass_properties import MassProperties, link_mass_properties
from delta_cad.mechanism import DeltaGeometry, UnreachableError, forward_kinematics, inverse_kinematics, jacobian
from delta_cad.mechanism.geometry import VERTICAL
from haptics.gravity import gravity_torque, potential_energy
from tests.haptics.scene_machine import MASSES as SCENES

PUBLISHED = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)
MASSES = Masses(0.07, 0.0013, -0.0003, 1.5e-4, 0.002, 0.0008, 0.002, 3e-4)
DOWN = np.array([0.0, 0.0, -9.81])

inside = st.tuples(st.floats(-0.0375, 0.0375), st.floats(-0.0375, 0.0375), st.floats(0.057112, 0.132112))
direction = st.tuples(*[st.floats(-10.0, 10.0)] * 3)


@given(inside, direction)
def test_it_is_the_gradient_of_the_potential_energy(p: tuple[float, ...], g: tuple[float, ...]) -> None:
    theta, step = inverse_kinematics(PUBLISHED, p), 1e-5
    ahead = forward_kinematics(PUBLISHED, theta + step * np.eye(3))
    behind = forward_kinematics(PUBLISHED, theta - step * np.eye(3))
    energy = potential_energy(PUBLISHED, MASSES, ahead, g) - potential_energy(PUBLISHED, MASSES, behind, g)
    # central difference: error step^2 / 6 x third derivative, some 1e-10 of the torque, and 1e-16 J / step by rounding
    assert gravity_torque(PUBLISHED, MASSES, p, g) == pytest.approx(energy / (2.0 * step), rel=1e-7, abs=1e-9)


def links_of(assembly: Assembly) -> dict[str, MassProperties]:
    """The moving links that have parts."""
    return {link: body for link, body in link_mass_properties(assembly).items() if link != "base"}


def test_it_is_what_the_solids_ask_for(best_assembly: Assembly, best_masses: dict[str, Any]) -> None:
    geometry = best_assembly.placement.geometry
    masses = masses_from_dict(best_masses, geometry.forearm_length)
    bodies = {link: (body.mass_kg, body.centre_m * 1000.0) for link, body in links_of(best_assembly).items()}
    pinion = bodies["pinion_0"]
    off_axis = float(np.hypot(pinion[1][0], pinion[1][2])) / 1000.0
    even = {link: body for link, body in bodies.items() if not link.startswith("pinion")}
    rng = np.random.default_rng(5)
    home = np.array(best_assembly.home_mm)
    p_mm = home + rng.uniform(-30.0, 30.0, (20, 3))
    for g in (DOWN, np.array([3.0, -5.0, -7.0])):
        own = gravity_torque(geometry, masses, p_mm / 1000.0, g)
        # not in ours: the solids' centres off the chain's plane and off the rods' axes, below 1 um by symmetry
        assert own == pytest.approx(holding_torque(best_assembly, even, p_mm, g), abs=2e-6)
        # nor the pinion's two set screws, at a right angle, which turn about the motor's axis: 19 uN m of some 50 mN m
        unbalance = best_assembly.placement.drive_ratio * pinion[0] * off_axis * np.linalg.norm(g)
        beyond = np.abs(own - holding_torque(best_assembly, bodies, p_mm, g)).max()
        assert 0.5 * unbalance < beyond < unbalance + 2e-6
        assert unbalance < 25e-6


def test_the_scenes_masses_are_those_of_the_solids(best: Design, best_masses: dict[str, Any]) -> None:
    built = masses_from_dict(best_masses, best.geometry.forearm_length, drive_torque(best))
    # three digits of each and more are written: 0.1 % and what a small change of a part leaves room for
    assert vars(SCENES) == pytest.approx(vars(built), rel=2e-3)


def test_the_papers_equations_word_for_word() -> None:
    m1, m2, m3 = 0.06, 0.05, 0.02
    rng = np.random.default_rng(6)
    for p in np.array([0.0, 0.0, 0.09]) + rng.uniform(-0.03, 0.03, (20, 3)):
        theta = inverse_kinematics(PUBLISHED, p)
        wrist, elbow = (m1 / 3.0 + m3 / 2.0) * DOWN, (m2 / 2.0 + m3 / 2.0) * DOWN
        torque = jacobian(PUBLISHED, p).T @ (3.0 * wrist)
        for i in range(3):
            arm = 0.082 * (np.cos(theta[i]) * PUBLISHED.radial[i] + np.sin(theta[i]) * VERTICAL)
            axis = -PUBLISHED.tangential[i]  # theta grows towards +z: the turn is from the radius to z
            torque[i] += np.cross(axis, arm) @ elbow
        held = gravity_torque(PUBLISHED, PointMasses(m1, m2, m3), p, DOWN)
        assert held == pytest.approx(-torque, rel=1e-12)


def test_upright_and_centred_all_joints_hold_alike_and_lift() -> None:
    torque = gravity_torque(PUBLISHED, MASSES, [0.0, 0.0, 0.09], DOWN)
    assert torque == pytest.approx(np.full(3, torque[0]), rel=1e-12)
    assert torque[0] > 0.0
    assert gravity_torque(PUBLISHED, MASSES, [0.0, 0.0, 0.09], -DOWN) == pytest.approx(-torque)
    assert gravity_torque(PUBLISHED, MASSES, np.full((2, 4, 3), [0.0, 0.0, 0.09]), DOWN).shape == (2, 4, 3)


def test_out_of_reach_is_refused() -> None:
    with pytest.raises(UnreachableError, match="chain 0"):
        gravity_torque(PUBLISHED, MASSES, [0.0, 0.0, 0.5], DOWN)
