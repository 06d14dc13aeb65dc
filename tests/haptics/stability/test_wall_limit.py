"""The search for the stiffest wall on known answers and on the linear loop."""

from itertools import product

import numpy as np
import pytest

from delta_cad.drive.masses import Masses
from delta_cad.mechanism import DeltaGeometry
from haptics.control.filters import backward_difference
from haptics.model.hands import HAND_MODELS, HANDS, RANGES
from haptics.model.plant import plant
from haptics.rendering.laws.virtual_wall import AXES
from haptics.stability.discrete import Timing
from haptics.stability.estimator_models import linear_models
from haptics.stability.linear import linearise
from haptics.stability.wall_limit import search
from tests.haptics.stability.loops import axis_loop, monotone

PLANT = plant(
    DeltaGeometry(0.040, 0.030, 0.082, 0.112079),
    Masses(0.07, 0.0013, -0.0003, 1.5e-4, 0.002, 0.0008, 0.0021, 3.2e-4),
)
POSE = [0.01, 0.0, 0.09]
T = 1e-3
(DIFFERENCE,) = linear_models(backward_difference(T))


@pytest.mark.parametrize(
    ("limit", "protocol"), [(4950.0, 4900.0), (1100.0, 1100.0), (1299.0, 1100.0), (4499.0, 4300.0)]
)
def test_protocol_and_bisection(limit: float, protocol: float) -> None:
    asked: list[float] = []

    def stable(K: float) -> bool:
        asked.append(K)
        return limit >= K

    found = search(stable, tolerance=1.0)
    assert found.protocol == protocol
    assert limit - 1.0 <= found.bisection <= limit
    assert [K for K, _ in found.history] == asked
    assert all(answer == (limit >= K) for K, answer in found.history)
    assert asked[:2] == [1100.0, 1300.0]
    assert len(set(asked)) == len(asked)
    assert not found.ceiling_reached


def test_first_step_that_oscillates_leaves_the_bisection_below_it() -> None:
    found = search(lambda K: K <= 700.0, tolerance=5.0)
    assert found.protocol is None
    assert 695.0 <= found.bisection <= 700.0


def test_ceiling() -> None:
    found = search(lambda _: True, ceiling=2000.0)
    assert (found.protocol, found.bisection, found.ceiling_reached) == (1900.0, 1900.0, True)
    assert search(lambda _: True, ceiling=1900.0).protocol == 1900.0
    assert search(lambda _: True, ceiling=1100.0).history == ((1100.0, True),)


@pytest.mark.parametrize("name", ["start", "step", "tolerance"])
def test_parameters_that_cannot_be_are_refused(name: str) -> None:
    for value in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match=name):
            search(lambda _: True, **{name: value})


def test_ceiling_below_the_start_is_refused() -> None:
    for ceiling in (1000.0, float("inf")):
        with pytest.raises(ValueError, match="ceiling"):
            search(lambda _: True, ceiling=ceiling)


def test_search_finds_the_limit_of_the_linear_loop() -> None:
    for (name, hand), viscous, delay in product(HANDS.items(), (0.0, 4e-4), (0.0, T)):
        here, timing = linearise(PLANT._replace(viscous=viscous), POSE), Timing(T, delay)
        rigid = hand._replace(grasp_stiffness=0.0)  # an arm rigidly on the handle, whose damping is in the formula
        along = axis_loop(here, AXES["x"], rigid, timing, DIFFERENCE).stiffness_limit(1.0)
        # light damping: K < 2 b / T / (1 + 2 delay / T) of all damping there is, to first order; 15 % covers 28 N s/m
        damping = here.effective_friction(AXES["x"]) + hand.damping + 1.0
        assert along.value == pytest.approx(2.0 * damping / T / (1.0 if delay == 0.0 else 3.0), rel=0.15), name
        loop = here.joint_loop(AXES["x"], hand, timing, DIFFERENCE)
        limit = loop.stiffness_limit(1.0)
        assert monotone(along)
        assert monotone(limit)
        assert loop.radius(0.999 * limit.value, 1.0) < 1.0 < loop.radius(1.001 * limit.value, 1.0)
        found = search(lambda k, loop=loop: bool(loop.radius(k, 1.0) < 1.0), ceiling=1e5, tolerance=1.0)
        assert found.bisection == pytest.approx(limit.value, abs=1.0)


def test_axes_are_unit_vectors_of_the_base_frame() -> None:
    np.testing.assert_array_equal([AXES[name] for name in "xyz"], np.eye(3))


def test_hands_grow_from_light_to_firm_and_say_where_they_come_from() -> None:
    assert list(HANDS) == ["light", "medium", "firm"]
    for field in ("damping", "stiffness", "grasp_stiffness"):
        values = [getattr(hand, field) for hand in HANDS.values()]
        assert values == sorted(values)
        assert values[0] > 0.0
    for hand in HANDS.values():  # the middle direction's limits are not known, its own figures lie within the others'
        given = (hand.mass, hand.damping, hand.stiffness, hand.grasp_stiffness, hand.grasp_damping)
        assert all(low < value < high for value, (low, high) in zip(given, RANGES, strict=True))
    for name, model in HAND_MODELS.items():
        assert model.hand is HANDS[name]
        assert model.meaning
        assert "2012" in model.source
        assert model.confirmed.startswith(("yes: ", "partly: ", "no, "))
