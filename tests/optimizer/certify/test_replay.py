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
from delta_cad.mechanism.limits import Kappa, Reach, Torque
from optimizer.certify.replay import replay
from tests.delta_cad.mechanism.stated_limits import limits

LIMITS = limits(elbow_arm_min=0.011, force=2.9, torque_max=0.31, kappa_max=2.3, shoulder=(-0.7, 1.13), lean_max=0.47)
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
    low, high = LIMITS["shoulder"].thresholds()
    lean_max = LIMITS["lean"].thresholds()
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
    reported = 0
    for g, low, high, p in boxes(size, 30):
        found = LIMITS[condition].interval_margins(SlopePose(g, low[None], high[None]), exactly)
        exact = sampled(g, condition, p)
        for k, margin in enumerate(found):
            below, above, values = margin.box.lo[0], margin.box.hi[0], exact[:, k]
            if np.isnan(below):
                continue
            reported += 1
            room = 1e-12 * np.abs(values).max() + 1e-15  # the NumPy figures round too
            assert (values >= below - room).all()
            assert (values <= above + room).all()
            if 0.0 < size <= 1e-5:
                # boxes of 0.01 mm are linear, and the corners are among the samples
                assert values.min() - below <= 0.05 * (above - below) + room
    assert reported > 10


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
