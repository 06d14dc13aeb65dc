"""Torque with gravity against the work of gravity, by hand and in 50 digits."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal

import numpy as np
import pytest

from delta_cad.mechanism import DeltaGeometry, GeometryError, direct_margin, worst_joint_torque
from delta_cad.mechanism.limits import HeldMasses, HoldingTorque, Limits
from delta_cad.mechanism.limits.holding_torque import gravity_torque
from optimizer.certify.replay import breaks
from tests.delta_cad.mechanism.limits.proving import poses
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins

MASSES = HeldMasses(1.5, 2.0, -9.5, 0.08, 0.003, -0.0004, 4e-4, 3e-6)


def exact(g: DeltaGeometry, limit: HoldingTorque, point: np.ndarray) -> list[Decimal | None]:
    return exact_margins(g, Limits.of(limit), tuple(map(float, point)))[HoldingTorque]


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
