"""Largest stable wall: the paper's protocol and a bisection for any predicate, and the analytic one as an interval.

The analytic limit is that of the linear loop: Coulomb friction, which calms small swings, quantisation, which stirs
them, and leaving the wall are not in it. It is an interval because nobody knows hand, friction and delay better than
a range. What the paper measured (`published`) stands beside it in reports; nothing is fitted to that. Importing this
module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike

from haptics.model.plant import Hand, Plant
from haptics.stability.discrete import Timing
from haptics.stability.estimator_models import LinearEstimator
from haptics.stability.linear import Linearised, linearise

# The paper's protocol, N/m: K_e starts at 1.1 N/mm and grows by 0.2 N/mm until the user feels oscillation.
START, STEP = 1100.0, 200.0
AXES: Mapping[str, tuple[float, float, float]] = MappingProxyType(
    {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
)

Predicate = Callable[[float], bool]  # Stiffness (N/m) -> whether the wall is stable


@dataclass(frozen=True)
class WallSearch:
    """Largest stable stiffness of a wall (the Z-width of one axis), as a search brackets it.

    Attributes:
        protocol: Last stable stiffness of the paper's steps, N/m; None if the first one oscillates.
        bisection: Largest stable stiffness to the tolerance, N/m.
        history: Each stiffness asked (N/m) with its answer, in order.
        ceiling_reached: It never oscillated up to the ceiling; both values are then lower bounds.
    """

    protocol: float | None
    bisection: float
    history: tuple[tuple[float, bool], ...]
    ceiling_reached: bool


def search(
    stable: Predicate, *, start: float = START, step: float = STEP, ceiling: float = 20e3, tolerance: float = 10.0
) -> WallSearch:
    """Largest stable stiffness by the paper's protocol, then by bisection within its last step.

    Args:
        stable: Asked once for each stiffness.
        start: First stiffness, N/m.
        step: N/m.
        ceiling: Where it gives up, N/m.
        tolerance: Of the bisection, N/m.

    Returns:
        Both values and the history. If the first stiffness oscillates already, the bisection is between 0 and it.

    Raises:
        ValueError: A parameter is not positive, or the ceiling lies below the start.
    """
    for name, value in (("start", start), ("step", step), ("tolerance", tolerance)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r} N/m; it must be finite and positive")
    if not (math.isfinite(ceiling) and ceiling >= start):
        raise ValueError(f"ceiling is {ceiling!r} N/m; it must be finite and at least the start, {start:g} N/m")
    history: list[tuple[float, bool]] = []

    def ask(stiffness: float) -> bool:
        answer = bool(stable(stiffness))
        history.append((stiffness, answer))
        return answer

    protocol: float | None = None
    for i in range(math.floor((ceiling - start) / step + 1e-9) + 1):  # the ceiling itself belongs to it
        stiffness = start + i * step
        if not ask(stiffness):
            break
        protocol = stiffness
    else:
        assert protocol is not None
        return WallSearch(protocol, protocol, tuple(history), ceiling_reached=True)
    low, high = protocol or 0.0, stiffness
    while high - low > tolerance:
        middle = (low + high) / 2.0
        low, high = (middle, high) if ask(middle) else (low, middle)
    return WallSearch(protocol, low, tuple(history), ceiling_reached=False)


@dataclass(frozen=True)
class WallCase:
    """One combination of what is not known.

    Attributes:
        hand: Its name.
        viscous: Friction of a joint, N m s/rad.
        delay: s.
        estimator: Its name.
        along: Limit with the effective mass along the normal alone, N/m.
        device: Limit with the whole device behind it, N/m: the better one.
        monotone: Below the limit all is stable and above it nothing, in both models.
    """

    hand: str
    viscous: float
    delay: float
    estimator: str
    along: float
    device: float
    monotone: bool


@dataclass(frozen=True)
class WallInterval:
    """Largest stable wall over all cases.

    Attributes:
        lowest: The case with the smallest limit of the whole device.
        highest: The one with the largest.
        cases: All of them.
    """

    lowest: WallCase
    highest: WallCase
    cases: tuple[WallCase, ...]


def wall_interval(
    par: Plant,
    p: ArrayLike,
    normal: ArrayLike,
    *,
    hands: Mapping[str, Hand],
    viscous: Sequence[float],
    delays: Sequence[float],
    estimators: Sequence[LinearEstimator],
    damping: float = 0.0,
    period: float = 1e-3,
    current_lag: float = 0.0,
) -> WallInterval:
    """Largest stable wall of the linear loop at a pose, over all combinations of what is not known.

    Args:
        par: The plant; its own viscous friction is replaced.
        p: (3,) platform centre, m.
        normal: (3,) unit normal of the wall.
        hands: By name.
        viscous: Frictions of a joint, N m s/rad; the two ends of the range will do, more are allowed.
        delays: s, likewise.
        estimators: Of the velocity, likewise; of no effect without damping.
        damping: Of the wall, N s/m.
        period: s.
        current_lag: s.

    Returns:
        The interval with its cases.

    Raises:
        ValueError: A set is empty, the pose is out of reach, the normal is no unit vector, or a figure cannot be.
    """
    cases: list[WallCase] = []
    for friction, delay in product(viscous, delays):
        here = linearise(par._replace(viscous=friction), p)
        timing = Timing(period, delay, current_lag)
        for (name, hand), estimator in product(hands.items(), estimators):
            along = here.axis_loop(normal, hand, timing, estimator).stiffness_limit(damping)
            device = here.joint_loop(normal, hand, timing, estimator).stiffness_limit(damping)
            monotone = along.monotone and device.monotone
            cases.append(WallCase(name, friction, delay, estimator.name, along.value, device.value, monotone))
    if not cases:
        raise ValueError("hands, viscous, delays and estimators must each hold at least one")
    ordered = sorted(cases, key=lambda case: case.device)
    return WallInterval(ordered[0], ordered[-1], tuple(cases))


def wall_predicate(
    here: Linearised, normal: ArrayLike, hand: Hand, timing: Timing, estimator: LinearEstimator, damping: float = 0.0
) -> Predicate:
    """The linear loop of the whole device as a predicate for `search`.

    Raises:
        ValueError: The normal is no unit vector.
    """
    loop = here.joint_loop(normal, hand, timing, estimator)
    return lambda stiffness: bool(np.all(loop.radius(stiffness, damping) < 1.0))
