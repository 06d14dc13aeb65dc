"""Margins over boxes against 50 decimal digits: no sample may lie outside the bounds."""

from decimal import Decimal

import numpy as np
import pytest

from delta_cad.mechanism import DeltaGeometry, closure_margin, conditioning
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.limits import POSE_LIMITS, HandleFriction, HandleInertia, HeldMasses, Kappa, Lean, Reach
from delta_cad.mechanism.proof.margins import FIRST, MARGINS, margins, numbers, room
from tests.delta_cad.mechanism.oracles import PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins, samples
from tests.delta_cad.mechanism.stated_limits import limits

ALL = (1 << MARGINS) - 1
INERTIA = HandleInertia(carried_mass=0.057, elbow_mass=0.0083, cross_mass=0.0039, joint_inertia=2.3e-4)
LIMITS = limits(
    elbow_arm_min=0.011,
    force=2.9,
    torque_max=0.31,
    kappa_max=2.3,
    shoulder=(-0.7, 1.13),
    lean_max=0.47,
    mass_max=0.31,
    inertia=INERTIA,
    couple_index_min=0.37,
    friction=(0.4, HandleFriction(0.012, 0.05, 0.08)),
    step=(1e-4, 3.8e-4),
    elbow_angle_min=0.5,
    held=(3.0, 0.4, HeldMasses(0.5, 1.0, -9.8, 0.08, 0.003, -4e-4, 4e-5, 3e-6)),
)
KAPPA = FIRST[Kappa]


def bounds(g, requested, box):
    pose, work, out = room()
    margins(box, numbers(g, requested), ALL, pose, work, out)
    return out


def exact_table(g, requested, point):
    """Every margin of the list; None where a limit is not asked or has no value there."""
    found = exact_margins(g, requested, tuple(point.tolist()))
    return [value for kind in POSE_LIMITS for value in found.get(kind, [None] * kind.enclosure.rows)]


def boxes(rng, size, n):
    """Mechanisms and boxes of half sides up to a size, m, all chains closed at the centre."""
    while n:
        g = DeltaGeometry(*rng.uniform([0.01, 0.01, 0.04, 0.05], [0.08, 0.08, 0.1, 0.2]))
        centre = rng.uniform([-0.05, -0.05, 0.01], [0.05, 0.05, 0.2])
        if (closure_margin(g, centre) > 1e-5).all():
            n -= 1
            yield g, np.array([*centre, *(size * rng.uniform(0.0, 1.0, 3)), 0.0])


def check(table, exact):
    """Holds every margin against its bounds."""
    for k, value in enumerate(exact):
        low, high = table[k, LOW], table[k, HIGH]
        if value is None or np.isnan(low):
            continue
        if k == KAPPA and low == 0.0:  # the second test of kappa proves the sign alone
            low = 0.0 if value >= 0 else np.inf
        assert Decimal(low) <= value <= Decimal(high), (k, low, value, high)


@pytest.mark.parametrize(("size", "count", "each"), [(0.01, 40, 12), (1e-3, 60, 12), (1e-6, 20, 6), (0.0, 150, 1)])
def test_boxes_contain_the_exact_margins(size, count, each):
    rng = np.random.default_rng(7)
    reported = 0
    for g, box in boxes(rng, size, count):
        table = bounds(g, LIMITS, box)
        reported += int(np.isfinite(table[:, LOW]).sum())
        for point in samples(box, rng, each):
            check(table, exact_table(g, LIMITS, point))
    assert reported > (3 if size == 0.01 else 12) * count  # the bounds say something


def test_bounds_touch_what_they_bound():
    # a wrong sign in a slope or a lost factor would leave the exact value inside only by luck: the bounds of a small
    # box must also be reached, to second order of its size
    rng = np.random.default_rng(3)
    for g, box in boxes(rng, 1e-4, 12):
        table = bounds(g, LIMITS, box)
        exact = [exact_table(g, LIMITS, p) for p in samples(box, rng, 48)]
        for k in range(MARGINS):
            values = np.array([float(e[k]) for e in exact])
            width = table[k, HIGH] - table[k, LOW]
            if np.isnan(width) or (k == KAPPA and conditioning(g, box[:3]) > 10.0):
                continue
            slack = max(values.min() - table[k, LOW], table[k, HIGH] - values.max())
            # eight corners are among 24 random ones nearly surely; 1e-4 m boxes are linear to a few per cent
            assert slack <= 0.25 * width, (k, slack, width)


@pytest.mark.parametrize("kappa_max", [1.0, 2.0, 5.0, 30.0])
def test_kappa_bounds_near_the_axis_and_near_a_singularity(kappa_max):
    requested = LIMITS.with_(Kappa(kappa_max))
    rng = np.random.default_rng(5)
    hidden = DeltaGeometry(0.03 + 0.016122, 0.03, 0.082, 0.094266)
    for g, centre in ((PUBLISHED, (0.0, 0.0, 0.08)), (PUBLISHED, (1e-7, 0.0, 0.1)), (hidden, (0.0, 0.0, 0.0298))):
        for size in (1e-2, 1e-3, 1e-5, 0.0):
            box = np.array([*centre, size, size, size, 0.0])
            table = bounds(g, requested, box)
            for point in samples(box, rng, 12):
                check(table, exact_table(g, requested, point))


def test_nothing_is_said_where_a_chain_is_open():
    table = bounds(PUBLISHED, LIMITS, np.array([0.0, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0]))
    known = {kind: slice(FIRST[kind], FIRST[kind] + kind.enclosure.rows) for kind in POSE_LIMITS}
    assert (table[known.pop(Reach), HIGH] < 0.0).all()
    assert np.isfinite(table[known.pop(Lean), LOW]).all()
    for rows in known.values():
        assert np.isnan(table[rows]).all()


def test_kappa_is_proved_just_above_and_never_just_below_its_value():
    rng = np.random.default_rng(13)
    by_second = 0
    for g, box in boxes(rng, 0.0, 400):
        kappa = float(conditioning(g, box[:3]))
        if not 1.001 < kappa < 1e3:
            continue
        # the NumPy value is good to a rounding times kappa
        for size, near in ((0.0, 1e-10 * kappa), (1e-6, 1e-3), (1e-5, 3e-2)):
            box[3:6] = size
            below = bounds(g, limits(kappa_max=kappa * (1 - 1e-12 * kappa)), box)[KAPPA, LOW]
            assert below < 0.0
            above = bounds(g, limits(kappa_max=kappa * (1 + near)), box)[KAPPA, LOW]
            assert above >= 0.0 or size > 0.0
            by_second += above == 0.0
    assert by_second > 10  # README (34) is at work near direct singularities


def test_kappa_is_not_proved_below_what_a_sample_of_the_box_has():
    rng = np.random.default_rng(17)
    hidden = DeltaGeometry(0.03 + 0.016122, 0.03, 0.082, 0.094266)
    level = DeltaGeometry(0.0625, 0.125, 0.0625, 0.125)
    axis = [(hidden, z) for z in np.linspace(0.0252, 0.03, 6)] + [(level, z) for z in np.linspace(0.128, 0.15, 6)]
    axis += [(PUBLISHED, z) for z in np.linspace(0.06, 0.13, 6)]
    # two eigenvalues meet on the axis: there the bounds live by their second-order terms
    cases = [(g, np.array([0.0, 0.0, z, 0.0, 0.0, 0.0, 0.0])) for g, z in axis] + list(boxes(rng, 0.0, 60))
    for g, box in cases:
        for size in (1e-5, 1e-4, 1e-3):
            box[3:6] = size * rng.uniform(0.2, 1.0, 3)
            kappa = conditioning(g, samples(box, rng, 200))
            if not np.isfinite(kappa).all() or kappa.max() > 1e4:
                continue
            requested = limits(kappa_max=float(kappa.max() * (1 - 1e-14 * kappa.max())))
            assert not bounds(g, requested, box)[KAPPA, LOW] >= 0.0, (g, box)
