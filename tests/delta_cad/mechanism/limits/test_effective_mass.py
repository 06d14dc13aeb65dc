"""The handle's effective mass against particles that move, 50 digits and haptics' mass matrix; proofs, both ways."""

from __future__ import annotations

import math
from decimal import Decimal
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given

from delta_cad.drive.masses import Masses
from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    MechanismError,
    closure_margin,
    direct_margin,
    elbow_positions,
    joint_angles,
    wrist_positions,
)
from delta_cad.mechanism.enclosure.interval import exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.geometry import RADIAL
from delta_cad.mechanism.inverse import elbow_arm, require_closed
from delta_cad.mechanism.limits import EffectiveMass, HandleInertia, Limits
from delta_cad.mechanism.limits.effective_mass import effective_mass, handle_inertia
from delta_cad.mechanism.proof.margins import FIRST
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import CubeSearch
from haptics.model.plant import STATES, motion, plant
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.limits.proving import bounds, exact, leaves, poses, verdict
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PROPERTY, PUBLISHED, mechanisms, paper_h, points
from tests.delta_cad.mechanism.proof.exact_oracle import samples

ROW = FIRST[EffectiveMass]
CUBE = Cube(BOTTOM, HALF)
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

    shoulders = g.base_radius * RADIAL
    total = platform * v @ v + rotor * (velocity(lambda at: joint_angles(g, at)) ** 2).sum()
    for share, mass in arm:
        total += mass * (velocity(lambda at, f=share: (1.0 - f) * shoulders + f * elbows(at)) ** 2).sum()
    for share, mass in rod:
        places = velocity(lambda at, f=share: (1.0 - f) * elbows(at) + f * wrist_positions(g, at))
        total += mass * (places**2).sum()
    return float(total)


def test_the_inertia_is_that_of_the_particles():
    rng = np.random.default_rng(19)
    for g, p in poses(rng, 60, 1e-4):  # w > 10 mm, some 80 steps from the fold
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
    ours = handle_inertia(g, p, INERTIA)
    state = np.zeros(STATES)
    state[:3] = p
    m11, m22, m33, m12, m13, m23 = motion(plant(g, MACHINE), 0.0, state, np.empty((6, 3)))
    theirs = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
    np.testing.assert_allclose(ours, theirs, rtol=1e-9, atol=1e-9 * np.abs(ours).max())


def test_at_a_fold_it_is_infinite_and_beyond_it_is_not_a_number():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    fold = np.array([0.02, 0.0, 0.0625])  # chain 0 folded upright, both lengths exact in binary
    p = fold + np.outer([-1e-6, 0.0, 1e-9, 1e-6, 1e-3], [0.0, 0.0, 1.0])
    found = effective_mass(g, p, INERTIA)
    assert np.isnan(found[0])
    assert found[1] == math.inf
    assert (np.diff(found[1:]) < 0.0).all()


# enclosure


def random_inertia(rng):
    """Masses of machines from a toy's to a robot's, the rods' of any distribution."""
    rod, centre, slender = rng.uniform(0.002, 0.2), rng.uniform(0.2, 0.8), rng.uniform(0.0, 0.5)
    turning = rod * slender * centre * (1.0 - centre)
    wrist, elbow = rod * centre**2 + turning, rod * (1.0 - centre) ** 2 + turning
    cross = rod * centre * (1.0 - centre) - turning
    return HandleInertia(rng.uniform(0.01, 0.5) + 3.0 * wrist, elbow, cross, 10.0 ** rng.uniform(-6.0, -2.5))


@pytest.mark.parametrize("size", [0.0, 1e-6, 1e-4, 1e-3])
def test_bounds_contain_the_exact_margin(size):
    rng = np.random.default_rng(29)
    told = 0
    for g, p in poses(rng, 40):
        limit = EffectiveMass(rng.uniform(0.1, 2.0), random_inertia(rng))
        box = np.array([*p, *(size * rng.uniform(0.0, 1.0, 3)), 0.0])
        low, high = bounds(g, limit, box)
        told += bool(np.isfinite(low))
        for point in samples(box, rng, 8 if size else 1):
            value = exact(g, limit, point)
            assert np.isnan(low) or value is None or Decimal(low) <= value <= Decimal(high)
        if size == 0.0:  # some roundings of the largest entry
            assert high - low <= 1e-10 * (limit.mass_max + abs(float(value)))
    assert told >= 36


def test_bounds_are_right_to_second_order():
    rng = np.random.default_rng(31)
    tried = 0
    for g, p in poses(rng, 200, 1e-4):
        limit = EffectiveMass(1.0, random_inertia(rng))
        eigenvalues = np.linalg.eigvalsh(handle_inertia(g, p, limit.inertia))
        if eigenvalues[2] - eigenvalues[1] < 0.05 * eigenvalues[2]:  # where two meet the largest has a kink
            continue
        tried += 1
        errors = []
        for size in (4e-6, 2e-6):
            box = np.array([*p, size, size, size, 0.0])
            corners = p + size * np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, 8).T
            values = limit.mass_max - effective_mass(g, corners, limit.inertia)
            low, high = bounds(g, limit, box)
            errors.append((values.min() - low, high - values.max()))
            width = values.max() - values.min()
            assert 0.0 <= errors[-1][0] <= 0.25 * width
        # half the box, a quarter of the error but for one of the third order: size over the way to the fold, 0.3 mm
        assert errors[1][0] == pytest.approx(errors[0][0] / 4.0, rel=0.2)
    assert tried > 100


@pytest.mark.slow
def test_bounds_hold_close_to_a_fold():
    rng = np.random.default_rng(37)
    told = 0
    for g, p in poses(rng, 40, 1e-4):
        away = np.array([*(p[:2] / (np.linalg.norm(p[:2]) + 1e-9)), 1.0])
        inside, outside = 0.0, 1.0
        for _ in range(50):  # the way out to the fold
            middle = (inside + outside) / 2.0
            inside, outside = (
                (middle, outside) if (closure_margin(g, p + middle * away) > 0.0).all() else (inside, middle)
            )
        limit = EffectiveMass(1e4, random_inertia(rng))
        for short in (1e-3, 1e-5, 1e-7):
            at = p + (inside - short) * away
            for size in (0.0, 0.1 * short, 0.9 * short, 2.0 * short):
                box = np.array([*at, size, size, size, 0.0])
                low, high = bounds(g, limit, box)
                told += bool(np.isfinite(low))
                for point in samples(box, rng, 6):
                    value = exact(g, limit, point)
                    assert np.isnan(low) or value is None or Decimal(low) <= value <= Decimal(high)
                if size > short:  # the box holds the fold and what is beyond
                    assert not low > -math.inf
    assert told > 200


def test_bounds_hold_where_two_eigenvalues_meet():
    """On the axis all directions sideways weigh alike; beside it one is heavier, to first order: the lift covers it."""
    rng = np.random.default_rng(53)
    flat = DeltaGeometry(0.06, 0.01, 0.06, 0.10)  # forearms lie low: sideways is heavier than up
    for z in np.linspace(0.02, 0.06, 8):
        limit = EffectiveMass(1.0, INERTIA)
        eigenvalues = np.linalg.eigvalsh(handle_inertia(flat, np.array([0.0, 0.0, z]), limit.inertia))
        assert eigenvalues[2] - eigenvalues[1] < 1e-12
        assert eigenvalues[1] - eigenvalues[0] > 1e-3
        for size in (1e-3, 1e-4, 1e-6):
            box = np.array([0.0, 0.0, z, size, size, size, 0.0])
            low, high = bounds(flat, limit, box)
            assert np.isfinite(low)
            for point in samples(box, rng, 12):
                assert Decimal(low) <= exact(flat, limit, point) <= Decimal(high)


def test_nothing_is_said_where_a_chain_is_open():
    for size in (0.0, 1e-3):
        low, high = bounds(PUBLISHED, EffectiveMass(1.0, INERTIA), np.array([0.0, 0.0, 0.3, size, size, size, 0.0]))
        assert np.isnan(low)
        assert np.isnan(high)


# proof


@cache
def designs():
    """Random designs, each with its masses and the heaviest position that a search of its cube finds."""
    rng, found = np.random.default_rng(41), []
    while len(found) < 40:
        a, lb, bottom, half = rng.uniform([-0.02, 0.06, 0.02, 0.01], [0.04, 0.25, 0.2, 0.06])
        g, cube, inertia = DeltaGeometry(a + 0.05, 0.05, 0.082, lb), Cube(bottom, half), random_inertia(rng)
        search = CubeSearch(cube, 31)
        closed = search(lambda p, g=g: closure_margin(g, p).min(axis=-1), 1.0)
        try:
            require_closed(g, closed.position)
        except MechanismError:
            continue
        if closed.value > 1e-4:  # w > 10 mm: closer to a fold a proof takes seconds
            found.append((g, cube, inertia, search(lambda p, g=g, i=inertia: effective_mass(g, p, i), -1.0)))
    return found


@pytest.mark.parametrize("n", range(40))
def test_random_designs_are_proved_just_above_and_refuted_just_below(n):
    g, cube, inertia, heaviest = designs()[n]
    assert verdict(g, cube, EffectiveMass(1.001 * heaviest.value, inertia)).verdict == "proved"
    limit = EffectiveMass(0.999 * heaviest.value, inertia)
    found = verdict(g, cube, limit)
    assert found.verdict == "refuted"
    assert found.limit == limit.mass_max
    assert exact(g, limit, found.point) < 0
    assert found.value == effective_mass(g, np.array(found.point), inertia)
    assert limit.mass_max < found.value <= heaviest.value * (1.0 + 1e-9)
    assert (cube.lower <= found.point).all()
    assert (found.point <= cube.upper).all()
    assert breaks(g, limit, np.array(found.point))
    # the search's own heaviest position is one that the second arithmetic refuses, too
    assert breaks(g, limit, np.array(heaviest.position))
    assert not breaks(g, EffectiveMass(1.001 * heaviest.value, inertia), np.array(heaviest.position))


# the second arithmetic


@pytest.mark.quick(2)
@pytest.mark.parametrize("n", range(5))
def test_what_is_proved_is_proved_again_and_nothing_too_tight(n):
    g, cube, inertia, heaviest = designs()[n]
    limit = EffectiveMass(1.001 * heaviest.value, inertia)
    proof = prove(g, cube, Limits.of(limit))
    low, high = leaves(cube, proof.leaves)
    assert limit.second_proof(SlopePose(g, low, high), exactly).mean() > 0.3  # the same boxes, mostly
    examined, unproved = replay(g, [limit], low, high)
    assert unproved is None
    assert examined < 20 * len(low) + 1_000
    tight = EffectiveMass(0.999 * heaviest.value, inertia)
    _, unproved = replay(g, [tight], low, high, max_boxes=4_000)
    assert unproved is not None
    assert unproved.condition == "effective_mass"


@pytest.mark.slow
def test_no_box_is_proved_again_that_holds_a_heavier_position():
    rng = np.random.default_rng(43)
    proved = 0
    for g, p in poses(rng, 30, 1e-4):
        inertia = random_inertia(rng)
        for size in (1e-5, 1e-4, 1e-3):
            box = np.array([*p, size, size, size, 0.0])
            corners = samples(box, rng, 100)
            if not (closure_margin(g, corners) > 1e-5).all():
                continue
            heaviest = float(effective_mass(g, corners, inertia).max())
            pose = SlopePose(g, (p - size)[None], (p + size)[None])
            assert not EffectiveMass(heaviest * (1.0 - 1e-12), inertia).second_proof(pose, exactly)[0]
            room = 1.0 + 300.0 * size  # relative width of a box: twice its size over w
            proved += bool(EffectiveMass(heaviest * room, inertia).second_proof(pose, exactly)[0])
    assert proved > 50


@pytest.mark.slow
def test_at_a_position_the_second_arithmetic_decides_to_the_last_digits():
    rng = np.random.default_rng(47)
    for g, p in poses(rng, 60):
        inertia = random_inertia(rng)
        value = 1.0 - float(exact(g, EffectiveMass(1.0, inertia), p))
        pose = SlopePose(g, p[None], p[None])
        for factor, lighter in ((1.0 - 1e-9, False), (1.0 + 1e-9, True)):
            limit = EffectiveMass(value * factor, inertia)
            assert limit.second_refutation(pose, exactly) is not lighter
            assert bool(limit.second_proof(pose, exactly)[0]) is lighter


def test_where_a_chain_is_open_the_second_arithmetic_says_nothing():
    limit, p = EffectiveMass(1.0, INERTIA), np.array([[0.0, 0.0, 0.3]])
    pose = SlopePose(PUBLISHED, p, p)
    assert not limit.second_proof(pose, exactly)[0]
    assert not limit.second_refutation(pose, exactly)


@pytest.mark.parametrize("field", ["carried_mass", "elbow_mass", "cross_mass", "joint_inertia"])
def test_other_masses_are_another_machine(field):
    limit = EffectiveMass(0.3, INERTIA)
    for towards in (math.inf, -math.inf):
        masses = vars(INERTIA) | {field: math.nextafter(getattr(INERTIA, field), towards)}
        other = EffectiveMass(0.3, HandleInertia(**masses))
        assert other.laxer(limit)
        assert Limits.of(other).laxer(Limits.of(limit)) == "effective_mass"


def test_the_elbow_arm_is_what_makes_it_heavy():
    """Towards a fold the mass grows with the inverse square of w."""
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    p = np.array([0.02, 0.0, 0.0625]) + np.outer([1e-5, 1e-6, 1e-7], [0.0, 0.0, 1.0])
    at_elbow = INERTIA.elbow_mass + INERTIA.joint_inertia / g.upper_arm_length**2
    expected = at_elbow * (g.forearm_length / elbow_arm(g, p).min(axis=-1)) ** 2
    np.testing.assert_allclose(effective_mass(g, p, INERTIA), expected, rtol=2e-2)
