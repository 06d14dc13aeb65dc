"""The handle's effective mass against particles that move and the plant of haptics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given

from delta_cad.drive.masses import Masses
from delta_cad.mechanism import (
    DeltaGeometry,
    direct_margin,
    elbow_positions,
    joint_angles,
    wrist_positions,
)
from delta_cad.mechanism.inverse import elbow_arm
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass, handle_inertia
from haptics.model.plant import STATES, motion, plant
from tests.delta_cad.mechanism.limits.proving import poses
from tests.delta_cad.mechanism.oracles import PROPERTY, mechanisms, paper_h, points

MACHINE = Masses(0.074, 0.0013, -0.0003, 1.5e-4, 0.002, 0.00075, 0.002, 3.25e-4)  # as the committed design is built
INERTIA = MACHINE.handle_inertia
STEP = 4e-6  # m; the error is the fourth power of its share of the way to the fold, some 0.3 mm
FIVE = ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0))


def bodies(rng):
    """Particles: of an arm (share of L_A, kg), of a rod (share from the elbow, kg), m_p (kg), a rotor (kg m^2)."""
    arm, rod = (np.column_stack([rng.uniform(0.0, 1.2, 3), rng.uniform(1e-3, 0.2, 3)]) for _ in range(2))
    return arm, rod, rng.uniform(0.01, 1.0), rng.uniform(0.0, 1e-3)


def seen_by_the_handle(g, arm, rod, platform, rotor):
    """What the particles are in the words of the limit."""
    share, mass = rod.T
    return HandleInertia(
        carried_mass=platform + 3.0 * float((mass * share**2).sum()),
        elbow_mass=float((mass * (1.0 - share) ** 2).sum()),
        cross_mass=float((mass * share * (1.0 - share)).sum()),
        joint_inertia=float((arm[:, 1] * (arm[:, 0] * g.upper_arm_length) ** 2).sum()) + rotor,
    )


def twice_energy(g, p, v, arm, rod, platform, rotor):
    """Twice the kinetic energy of all particles, from where they are at five places along the motion."""

    def velocity(places):
        return sum(f * places(p + k * STEP * v) for k, f in FIVE) / (12.0 * STEP)

    def elbows(at):
        return elbow_positions(g, joint_angles(g, at))

    shoulders = g.base_radii[:, None] * g.radial
    total = platform * v @ v + rotor * (velocity(lambda at: joint_angles(g, at)) ** 2).sum()
    for share, mass in arm:
        total += mass * (velocity(lambda at, f=share: (1.0 - f) * shoulders + f * elbows(at)) ** 2).sum()
    for share, mass in rod:
        places = velocity(lambda at, f=share: (1.0 - f) * elbows(at) + f * wrist_positions(g, at))
        total += mass * (places**2).sum()
    return float(total)


def test_the_inertia_is_that_of_the_particles():
    rng = np.random.default_rng(19)
    # w > 10 mm, some 80 steps from the fold
    for g, p in (*poses(rng, 60, 1e-4), *poses(rng, 30, 1e-4, placed=True)):
        particles, v = bodies(rng), rng.uniform(-1.0, 1.0, 3)
        masses = seen_by_the_handle(g, *particles)
        m = handle_inertia(g, p, masses)
        np.testing.assert_array_equal(m, m.T)
        assert v @ m @ v == pytest.approx(twice_energy(g, p, v, *particles), rel=1e-7)
        # the heaviest direction: energies of sums of two velocities give the matrix
        unit = np.eye(3)
        sums = np.array([[twice_energy(g, p, a + b, *particles) for b in unit] for a in unit])
        alone = np.diag(sums) / 4.0
        own = (sums - alone[:, None] - alone) / 2.0
        assert effective_mass(g, p, masses) == pytest.approx(np.linalg.eigvalsh(own)[2], rel=1e-7)


def test_by_hand_on_the_axis():
    # level arms, forearms upright: a vertical motion turns every arm as much as it moves, rods and all
    g = DeltaGeometry(0.03, 0.09, 0.06, 0.12)
    masses = HandleInertia(0.1, 0.02, 0.005, 3.6e-5)
    m = handle_inertia(g, np.array([0.0, 0.0, 0.12]), masses)
    np.testing.assert_allclose(m, np.diag([0.1, 0.1, 0.1 + 3 * (0.02 + 0.01 + 0.01)]), atol=1e-15)
    assert effective_mass(g, np.array([0.0, 0.0, 0.12]), masses) == pytest.approx(0.22, rel=1e-14)


@PROPERTY
@given(mechanisms(), points())
def test_it_is_the_mass_matrix_of_haptics(g, p):
    assume((paper_h(g, p) < -1e-9).all())
    assume(p[2] > 0.0 and direct_margin(g, p) > 0.0)
    project = handle_inertia(g, p, INERTIA)
    state = np.zeros(STATES)
    state[:3] = p
    m11, m22, m33, m12, m13, m23 = motion(plant(g, MACHINE), 0.0, state, np.empty((6, 3)))
    theirs = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
    np.testing.assert_allclose(project, theirs, rtol=1e-9, atol=1e-9 * np.abs(project).max())


def test_at_a_fold_it_is_infinite_and_beyond_it_is_not_a_number():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    fold = np.array([0.02, 0.0, 0.0625])  # chain 0 folded upright, both lengths exact in binary
    p = fold + np.outer([-1e-6, 0.0, 1e-9, 1e-6, 1e-3], [0.0, 0.0, 1.0])
    found = effective_mass(g, p, INERTIA)
    assert np.isnan(found[0])
    assert found[1] == math.inf
    assert (np.diff(found[1:]) < 0.0).all()


def test_the_elbow_arm_is_what_makes_it_heavy():
    """Towards a fold the mass grows with the inverse square of w."""
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    p = np.array([0.02, 0.0, 0.0625]) + np.outer([1e-5, 1e-6, 1e-7], [0.0, 0.0, 1.0])
    at_elbow = INERTIA.elbow_mass + INERTIA.joint_inertia / g.upper_arm_length**2
    expected = at_elbow * (g.forearm_length / elbow_arm(g, p).min(axis=-1)) ** 2
    np.testing.assert_allclose(effective_mass(g, p, INERTIA), expected, rtol=2e-2)
