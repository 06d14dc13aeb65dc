"""Torque that holds the machine: limits, symmetry, the paper's point masses, and power in joint space."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.holding import holding_torque, potential_energy
from delta_cad.mechanism import DeltaGeometry, forward_kinematics, inverse_kinematics, jacobian
from delta_cad.mechanism.placement import LinkPlacement

G = np.array([0.0, 0.0, -9.81])
GEOMETRY = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)
CENTRE = np.array([0.0, 0.0, 94.612])
POSES = CENTRE + np.random.default_rng(3).uniform(-37, 37, (25, 3))
NUMERIC_N_M = 2e-9
"""Central differences over 0.01 mm: rounding of an energy of 0.3 J (1e-16 relative) over 2e-5 m, times 0.1 m of
Jacobian, and h^2 / 6 of its third derivative; both below this."""

Bodies = dict[str, tuple[float, np.ndarray]]


def stand_in() -> Assembly:
    return Assembly("stand-in", (), (), (), LinkPlacement(GEOMETRY, 54.0, (14.5, -36.4), 9.85), CENTRE)


def bodies() -> Bodies:
    """Masses anywhere in their links, the same in each chain."""
    found: Bodies = {"platform": (0.12, np.array([0.0, 0.0, 14.0]))}
    for i in range(3):
        found[f"upper_arm_{i}"] = (0.045, np.array([21.0, 2.0, -6.0]))
        found[f"pinion_{i}"] = (0.002, np.array([0.0, 8.0, 0.0]))
        for j in range(2):
            found[f"rod_{i}_{j}"] = (0.006, np.array([56.0, 0.0, 0.0]))
    return found


def test_without_gravity_nothing_is_held() -> None:
    assert (holding_torque(stand_in(), bodies(), POSES, np.zeros(3)) == 0).all()
    assert (potential_energy(stand_in(), bodies(), POSES, np.zeros(3)) == 0).all()


def test_on_the_axis_all_chains_hold_the_same() -> None:
    on_axis = CENTRE + np.linspace([0, 0, -37], [0, 0, 37], 7)
    torque = holding_torque(stand_in(), bodies(), on_axis, G)
    np.testing.assert_allclose(torque, torque[:, :1] + np.zeros(3), atol=NUMERIC_N_M)
    assert (torque > 0.01).all()  # arms outwards and level: the joints lift


def test_a_third_of_a_turn_passes_the_torques_on() -> None:
    turn = np.array([[-0.5, -(0.75**0.5), 0], [0.75**0.5, -0.5, 0], [0, 0, 1]])
    here, there = (holding_torque(stand_in(), bodies(), p, G) for p in (POSES, POSES @ turn.T))
    np.testing.assert_allclose(there, np.roll(here, 1, axis=-1), atol=NUMERIC_N_M)


def test_torque_is_linear_in_gravity_and_in_mass() -> None:
    tilted = np.array([3.0, -2.0, -8.0])
    parts = sum(holding_torque(stand_in(), bodies(), POSES, c * e) for c, e in zip(tilted, np.eye(3), strict=True))
    np.testing.assert_allclose(holding_torque(stand_in(), bodies(), POSES, tilted), parts, atol=NUMERIC_N_M)
    heavier = {link: (2 * mass, centre) for link, (mass, centre) in bodies().items()}
    np.testing.assert_allclose(
        holding_torque(stand_in(), heavier, POSES, G),
        2 * holding_torque(stand_in(), bodies(), POSES, G),
        atol=2 * NUMERIC_N_M,
    )


def test_a_rod_counts_half_at_each_end_as_the_paper_has_it() -> None:
    """[RCIM2018] eqs. 17-22: platform and half of each forearm at the wrists, the other half and the arm at elbow."""
    m1, m2, m3, g = 0.13, 0.05, 0.014, 9.81
    found: Bodies = {"platform": (m1, np.zeros(3))}
    for i in range(3):
        found[f"upper_arm_{i}"] = (m2, np.array([41.0, 0.0, 0.0]))
        for j in range(2):
            found[f"rod_{i}_{j}"] = (m3 / 2, np.array([112.079 / 2, 0.0, 0.0]))
    theta = inverse_kinematics(GEOMETRY, POSES / 1e3)
    at_wrists = (m1 + 3 * m3 / 2) * g * jacobian(GEOMETRY, POSES / 1e3)[:, 2, :]  # J^T (0, 0, weight)
    at_elbows = (m2 / 2 + m3 / 2) * g * 0.082 * np.cos(theta)
    np.testing.assert_allclose(holding_torque(stand_in(), found, POSES, G), at_wrists + at_elbows, atol=NUMERIC_N_M)


@pytest.mark.parametrize("gravity", [G, np.array([3.0, -5.0, -7.0])])
def test_power_balances_in_joint_space(gravity: np.ndarray) -> None:
    """Each shoulder turned a little by forward kinematics: the torque's work is what the energy gains."""
    theta = inverse_kinematics(GEOMETRY, POSES / 1e3)
    step = 1e-4  # rad
    gained = []
    for k in range(3):
        turned = [forward_kinematics(GEOMETRY, theta + s * step * np.eye(3)[k]) * 1e3 for s in (1, -1)]
        plus, minus = (potential_energy(stand_in(), bodies(), p, gravity) for p in turned)
        gained.append((plus - minus) / (2 * step))
    # error of this oracle: step^2 / 6 of the third derivative, energy 0.3 J: some 1e-9
    np.testing.assert_allclose(holding_torque(stand_in(), bodies(), POSES, gravity), np.stack(gained, -1), atol=1e-8)


def test_potential_energy_of_known_heights() -> None:
    only = {"platform": (2.0, np.array([0.0, 0.0, 10.0]))}
    energy = potential_energy(stand_in(), only, np.array([[0, 0, 90.0], [5, -5, 100.0]]), G)
    np.testing.assert_allclose(energy, [2 * 9.81 * 0.100, 2 * 9.81 * 0.110], rtol=1e-14)


def test_the_committed_design_holds_its_own_weight_by_the_power_balance(
    best_assembly: Assembly, best_masses: dict[str, Any]
) -> None:
    """Masses from the solids, oracle from placed parts: weight times height of each occurrence's own centre."""
    moving = {
        link: (body["mass_kg"], 1e3 * np.array(body["centre_m"]))
        for link, body in best_masses["bodies"].items()
        if link != "base"
    }
    geometry = best_assembly.placement.geometry

    def energy(theta: np.ndarray) -> float:
        poses = best_assembly.poses(forward_kinematics(geometry, theta) * 1e3)
        total = 0.0
        for o in best_assembly.occurrences:
            own = best_masses["parts"][o.part.number]
            centre = poses[o.name] @ np.array([*(1e3 * np.array(own["centre_m"])), 1.0])
            total += own["mass_kg"] * 9.81 * centre[2] / 1e3
        return total

    for p in POSES[:3]:
        theta, step = inverse_kinematics(geometry, p / 1e3), 1e-4
        gained = [(energy(theta + step * e) - energy(theta - step * e)) / (2 * step) for e in np.eye(3)]
        np.testing.assert_allclose(holding_torque(best_assembly, moving, p, G), gained, atol=1e-8)
