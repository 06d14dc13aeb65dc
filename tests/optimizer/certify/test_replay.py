"""The second arithmetic: bounds hold for samples of the boxes, nothing false is proved, nothing true is broken."""

import numpy as np
import pytest

from delta_cad.mechanism import (
    DeltaGeometry,
    closure_margin,
    conditioning,
    direct_margin,
    joint_angles,
    rod_lean,
    worst_joint_torque,
)
from delta_cad.mechanism.enclosure.interval import Interval, exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose, definite
from delta_cad.mechanism.limits import AssemblyMode, EffectiveMass, HandleInertia, Kappa, Reach, Torque
from delta_cad.mechanism.limits.effective_mass import effective_mass
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.asked import limits

LIMITS = limits(elbow_arm_min=0.011, force=2.9, torque_max=0.31, kappa_max=2.3, shoulder=(-0.7, 1.13), lean_max=0.47)
MASSES = HandleInertia(carried_mass=0.07, elbow_mass=0.02, cross_mass=0.004, joint_inertia=2.1e-4)
PUBLISHED = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)


def boxes(size, n):
    """Mechanisms, lower and upper corners, and samples of the boxes, corners among them."""
    rng = np.random.default_rng(23)
    while n:
        g = DeltaGeometry(*rng.uniform([0.01, 0.01, 0.04, 0.05], [0.08, 0.08, 0.1, 0.2]))
        centre = rng.uniform([-0.05, -0.05, 0.01], [0.05, 0.05, 0.2])
        half = size * rng.uniform(0.1, 1.0, 3)
        unit = rng.uniform(-1.0, 1.0, (60, 3))
        unit[:30] = np.sign(unit[:30])
        if (closure_margin(g, centre) > 1e-4).all() and conditioning(g, centre) < 100.0:
            n -= 1
            low, high = centre - half, centre + half
            yield g, low, high, np.clip(centre + half * unit, low, high)


def sampled(g, condition, p):
    """(samples, margins) by the NumPy functions; the order is that of `PoseLimit.second`."""
    force, torque_max = LIMITS.get(Torque).force, LIMITS.get(Torque).torque_max
    la, lb, w2 = g.upper_arm_length, g.forearm_length, closure_margin(g, p)
    det, torque = direct_margin(g, p) * lb**3, worst_joint_torque(g, p, force)
    theta = joint_angles(g, p)
    low, high = LIMITS["shoulder"].told()
    lean_max = LIMITS["lean"].told()
    sides = np.stack([np.sin(rod_lean(g, p)), -np.sin(rod_lean(g, p))], axis=-1).reshape(len(p), 6)
    return {
        "reach": w2 - LIMITS.get(Reach).elbow_arm_min ** 2,
        "assembly_mode": det[:, None],
        "torque": (torque_max**2 - torque**2) * (det / (force * la))[:, None] ** 2,
        "shoulder": np.cos(theta - (low + high) / 2) - np.cos((high - low) / 2),
        "lean": lb * (np.sin(lean_max) + sides),
    }[condition]


@pytest.mark.parametrize("condition", ["reach", "assembly_mode", "torque", "shoulder", "lean"])
@pytest.mark.parametrize("size", [0.0, 1e-5, 1e-3, 5e-3])
def test_margins_bound_the_samples_and_are_nearly_reached(size, condition):
    told = 0
    for g, low, high, p in boxes(size, 30):
        found = LIMITS[condition].second(SlopePose(g, low[None], high[None]), exactly)
        exact = sampled(g, condition, p)
        for k, margin in enumerate(found):
            below, above, values = margin.box.lo[0], margin.box.hi[0], exact[:, k]
            if np.isnan(below):
                continue
            told += 1
            room = 1e-12 * np.abs(values).max() + 1e-15  # the NumPy figures round too
            assert (values >= below - room).all()
            assert (values <= above + room).all()
            if 0.0 < size <= 1e-5:
                # boxes of 0.01 mm are linear, and the corners are among the samples
                assert values.min() - below <= 0.05 * (above - below) + room
    assert told > 10


@pytest.mark.parametrize("size", [1e-5, 1e-4, 1e-3])
def test_kappa_is_proved_above_the_samples_and_never_below(size):
    proved = 0
    axis = [(PUBLISHED, np.array([0.0, 0.0, z])) for z in np.linspace(0.06, 0.13, 8)]
    rng = np.random.default_rng(3)
    more = [(g, c - size, c + size, c + size * rng.uniform(-1.0, 1.0, (100, 3))) for g, c in axis]
    for g, low, high, p in [*boxes(size, 40), *more]:
        kappa = conditioning(g, p)
        if not np.isfinite(kappa).all():
            continue
        p_box = SlopePose(g, low[None], high[None])
        short = Kappa(max(1.0, float(kappa.max()) * (1 - 1e-12 * float(kappa.max()))))
        assert not short.second_proof(p_box, exactly)[0]
        proved += bool(Kappa(float(kappa.max()) * 1.2).second_proof(p_box, exactly)[0])
    assert proved > 30


@pytest.mark.slow
@pytest.mark.parametrize("size", [1e-5, 1e-4, 1e-3])
def test_effective_mass_is_proved_above_the_samples_and_never_below(size):
    """Also with masses in other proportions: a rod whose centre is beyond its wrist couples its ends negatively."""
    proved = tried = 0
    rng = np.random.default_rng(4)
    for g, low, high, p in boxes(size, 60):
        masses = HandleInertia(*(rng.uniform(0.1, 1.0, 4) * [0.2, 0.04, 0.02 * rng.choice([-1.0, 1.0]), 1e-3]))
        mass = effective_mass(g, p, masses)
        if not np.isfinite(mass).all() or mass.max() > 100.0:
            continue
        tried += 1
        p_box, largest = SlopePose(g, low[None], high[None]), float(mass.max())
        # 1e-12: rounding of the samples' own eigenvalues, which near a fold are small differences of large numbers
        assert not EffectiveMass(largest * (1.0 - 1e-12 * largest - 1e-9), masses).second_proof(p_box, exactly)[0]
        proved += bool(EffectiveMass(largest * 1.2, masses).second_proof(p_box, exactly)[0])
    assert tried > 40
    assert proved > tried / 2


def test_definite_matrices():
    rng = np.random.default_rng(2)
    m = rng.uniform(-1.0, 1.0, (400, 3, 3))
    m = m + m.transpose(0, 2, 1) + 1.5 * np.eye(3)
    entries = {(i, j): exactly(m[:, i, j]) for i in range(3) for j in range(i, 3)}
    smallest = np.linalg.eigvalsh(m)[:, 0]
    assert 50 < (smallest > 0.0).sum() < 350
    for order in ((0, 1, 2), (2, 1, 0), (1, 2, 0)):
        np.testing.assert_array_equal(definite(entries, order), smallest > 0.0)
    wide = {key: Interval(x.lo - 0.05, x.hi + 0.05) for key, x in entries.items()}
    sure = definite(wide, (0, 1, 2))
    # a symmetric change of at most 0.05 an entry moves an eigenvalue by at most 0.15
    assert (smallest[sure] > 0.0).all()
    for _ in range(50):
        change = rng.choice([-0.05, 0.05], (400, 3, 3))
        change = np.triu(change) + np.triu(change, 1).transpose(0, 2, 1)
        assert (np.linalg.eigvalsh(m + change)[sure, 0] > 0.0).all()
    assert sure.any()


def test_points_break_a_condition_just_below_its_figure_and_not_just_above():
    for g, low, _, _ in boxes(0.0, 20):
        kappa, torque = float(conditioning(g, low)), float(worst_joint_torque(g, low, 3.0).max())
        mass = float(effective_mass(g, low, MASSES))
        for factor, broken in ((1 - 1e-8, True), (1 + 1e-8, False)):
            assert breaks(g, Torque(3.0, torque * factor), low) is broken
            most = Kappa(max(1.0, kappa * factor))
            assert breaks(g, most, low) is (broken and most.kappa_max > 1.0)
            assert breaks(g, EffectiveMass(mass * factor, MASSES), low) is broken
        assert breaks(g, AssemblyMode(), low) is bool(direct_margin(g, low) < 0.0)


def test_what_cannot_be_proved_is_named():
    low, high = np.array([[-0.01, 0.0, 0.08]]), np.array([[0.01, 0.01, 0.09]])
    worst = float(conditioning(PUBLISHED, [[x, 0.01, 0.09] for x in (-0.01, 0.01)]).max())
    examined, failed = replay(PUBLISHED, [Reach(), Kappa(worst * 0.9)], low, high)
    assert failed is not None
    assert failed.condition == "kappa"
    assert (np.array(failed.lower) >= low[0]).all()
    assert (np.array(failed.upper) <= high[0]).all()
    enough = Kappa(worst * 1.0001)
    assert replay(PUBLISHED, [Reach(), enough], low, high)[1] is None
    examined, failed = replay(PUBLISHED, [enough], low, high, max_boxes=3)
    assert failed is not None
    assert 3 <= examined <= 6
