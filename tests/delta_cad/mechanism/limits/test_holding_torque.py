"""Torque with gravity against the work of gravity in 50 digits; proofs in both arithmetics."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, GeometryError, direct_margin, worst_joint_torque
from delta_cad.mechanism.enclosure.interval import exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.limits import HeldMasses, HoldingTorque, Limits
from delta_cad.mechanism.limits.holding_torque import gravity_torque
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.limits.proving import leaves, poses, verdict
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins, samples

CUBE = Cube(BOTTOM, HALF)
MASSES = HeldMasses(1.5, 2.0, -9.5, 0.08, 0.003, -0.0004, 4e-4, 3e-6)
ROW = FIRST[HoldingTorque]


def random_masses(rng: np.random.Generator) -> HeldMasses:
    """Of machines from a toy's to a robot's, gravity from any side."""
    x, y, z, arm, off = rng.normal(size=5) * [5.0, 3.0, 9.0, 0.01, 0.003]
    return HeldMasses(x, abs(y), z, *([rng.uniform(0.0, 0.3), arm, off, *(rng.uniform(0.0, 1.0, 2) * [0.01, 1e-3])]))


def exact(g: DeltaGeometry, limit: HoldingTorque, point: np.ndarray) -> list[Decimal | None]:
    return exact_margins(g, Limits.of(limit), tuple(map(float, point)))[HoldingTorque]


@pytest.mark.parametrize("size", [0.0, 1e-6, 1e-4, 1e-3])
def test_both_arithmetics_contain_the_exact_margins(size: float) -> None:
    rng = np.random.default_rng(29)
    told = seconds = 0
    for g, p in poses(rng, 30):
        limit = HoldingTorque(rng.uniform(0.1, 10.0), rng.uniform(0.05, 1.0), random_masses(rng))
        box = np.array([*p, *(size * rng.uniform(0.0, 1.0, 3)), 0.0])
        pose, work, out = room()
        margins(box, numbers(g, Limits.of(limit)), BITS[HoldingTorque], pose, work, out)
        ours = out[ROW : ROW + HoldingTorque.enclosure.rows, [LOW, HIGH]]
        second = limit.second(SlopePose(g, (box[:3] - box[3:6])[None], (box[:3] + box[3:6])[None]), exactly)
        for point in samples(box, rng, 8 if size else 1):
            for (low, high), form, value in zip(ours.tolist(), second, exact(g, limit, point), strict=True):
                if value is None:
                    continue
                if not np.isnan(low):
                    told += 1
                    assert Decimal(low) <= value <= Decimal(high)
                if not np.isnan(form.box.lo[0]):
                    seconds += 1
                    assert Decimal(float(form.box.lo[0])) <= value <= Decimal(float(form.box.hi[0]))
    assert min(told, seconds) >= (150 if size == 0.0 else 900)


def test_the_figure_is_what_the_margins_are_about() -> None:
    """Just above the figure of a position all margins are positive, just below one is negative."""
    rng = np.random.default_rng(3)
    tried = 0
    for g, p in poses(rng, 60, 1e-4):
        limit = HoldingTorque(3.0, 1.0, random_masses(rng))
        figure = float(HoldingTorque.figures[0].worst(limit, g, p))
        if not 1e-3 < figure < 1e3 or sum(m is not None and m < 0 for m in exact(g, replace(limit, torque_max=1e4), p)):
            continue  # beyond the direct singularity nothing is said
        tried += 1
        assert min(exact(g, replace(limit, torque_max=figure * (1 + 1e-9)), p)) > 0  # type: ignore[type-var]
        assert min(exact(g, replace(limit, torque_max=figure * (1 - 1e-9)), p)) < 0  # type: ignore[type-var]
    assert tried > 25


def test_by_hand_on_the_axis() -> None:
    """Level arms, that turn together and lift the platform by L_A a radian: each by a third of it."""
    g, p = DeltaGeometry(0.06, 0.048, 0.06, 0.12), np.array([0.0, 0.0, 0.096])
    straight = HeldMasses(0.0, 0.0, -10.0, 0.3, 0.002, 0.0, 0.0, 0.0)
    np.testing.assert_allclose(gravity_torque(g, p, straight), 10.0 * (0.3 * 0.06 / 3.0 + 0.002), rtol=1e-12)
    square = replace(straight, carried_mass=0.0, arm_moment=0.0, cross_moment=0.002)  # level arms: it moves sideways
    np.testing.assert_allclose(gravity_torque(g, p, square), 0.0, atol=1e-15)
    loose = replace(straight, loose_mass=0.1, loose_moment=0.001)
    more = gravity_torque(g, p, loose) - gravity_torque(g, p, straight)
    np.testing.assert_allclose(more, worst_joint_torque(g, p, 1.0) + 0.01, rtol=1e-12)


@pytest.mark.slow
def test_a_cube_is_proved_just_above_its_worst_and_refuted_just_below() -> None:
    rng = np.random.default_rng(11)
    for _ in range(6):
        masses = random_masses(rng)
        free = HoldingTorque(3.0, 10.0, masses)
        (figure,) = free.figures
        worst = CubeSearch(CUBE)(lambda p, f=figure, k=free: f.worst(k, PUBLISHED, p), -1.0)
        limit = HoldingTorque(3.0, worst.value * 1.001, masses)
        assert verdict(PUBLISHED, CUBE, limit).verdict == "proved"
        low, high = leaves(CUBE, prove(PUBLISHED, CUBE, Limits.of(limit)).leaves)
        assert replay(PUBLISHED, [limit], low, high)[1] is None
        tight = replace(limit, torque_max=worst.value * 0.999)
        found = verdict(PUBLISHED, CUBE, tight)
        assert found.verdict == "refuted"
        assert found.value is not None
        assert tight.torque_max < found.value <= worst.value * (1.0 + 1e-9)
        assert breaks(PUBLISHED, tight, np.array(found.point))
        assert not breaks(PUBLISHED, limit, np.array(worst.position))
        assert replay(PUBLISHED, [tight], low, high, max_boxes=4_000)[1] is not None


def test_beyond_the_direct_singularity_nothing_is_refuted_of_it() -> None:
    """That the platform is beyond it is another limit's to say: the sign of det S would make any torque too much."""
    tried = 0
    for g, p in poses(np.random.default_rng(2), 300, 1e-4):
        limit = HoldingTorque(1e-3, 1e3, MASSES)
        if direct_margin(g, p) > -1e-3:
            continue
        tried += 1
        assert max(exact(g, limit, p)) < 0  # type: ignore[type-var]
        assert not breaks(g, limit, p)
        assert not np.isnan(gravity_torque(g, p, MASSES)).any()
    assert tried > 5


def test_masses_that_cannot_be_are_refused() -> None:
    for name, value in (("carried_mass", -1.0), ("loose_mass", float("nan")), ("gravity_y", -1.0)):
        with pytest.raises(GeometryError, match=name):
            replace(MASSES, **{name: value})
    data = HoldingTorque(3.0, 0.4, MASSES).record()
    for key in data:
        with pytest.raises(GeometryError, match="belong together"):
            HoldingTorque.from_record(data | {key: None})
    with pytest.raises(GeometryError, match="held_masses"):
        HoldingTorque.from_record(data | {"held_masses": {"carried_mass_kg": 1.0}})
