"""What the proofs of every limit must do, whichever it is, against 50 digits and the worst figures that a search finds.

30 s of processor: boxes and proofs of each figure in both arithmetics, exact margins of thousands of points.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from decimal import Decimal
from functools import cache
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, closure_margin, direct_margin
from delta_cad.mechanism.enclosure.interval import exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.limits import (
    POSE_LIMITS,
    FigureOfMerit,
    Friction,
    HandleFriction,
    HandleInertia,
    HeldMasses,
    HoldingTorque,
    Kappa,
    Lean,
    Limits,
    PoseLimit,
    PositionStep,
    Reach,
    Torque,
)
from delta_cad.mechanism.limits.couple_index import couple_index
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.statics import conditioning
from delta_cad.mechanism.workspace import CubeSearch, Extreme
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.limits.proving import BOUNDED, leaves, moved, poses, stated
from tests.delta_cad.mechanism.oracles import PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins, samples

EACH = pytest.mark.parametrize(("kind", "figure"), BOUNDED, ids=lambda one: getattr(one, "name", None))
FLAT = DeltaGeometry(0.06, 0.01, 0.06, 0.10)
"""Its forearms lie low near the base, where turning about x and y is what the rods resist least."""


def machine(rng: np.random.Generator) -> dict[str, Any]:
    """What limits need of a machine, from a toy's to a robot's; the rods of any distribution, gravity from any side."""
    rod, centre, slender = rng.uniform(0.002, 0.2), rng.uniform(0.2, 0.8), rng.uniform(0.0, 0.5)
    turning = rod * slender * centre * (1.0 - centre)
    wrist, elbow = rod * centre**2 + turning, rod * (1.0 - centre) ** 2 + turning
    inertia = (
        rng.uniform(0.01, 0.5) + 3.0 * wrist,
        elbow,
        (rod * centre * (1.0 - centre) - turning) * rng.choice([1.0, 1.0, -1.0]),
    )
    x, y, z, along, across = rng.normal(size=5) * [5.0, 3.0, 9.0, 0.01, 0.003]
    held = x, abs(y), z, rng.uniform(0.0, 0.3), along, across, *(rng.uniform(0.0, 1.0, 2) * [0.01, 1e-3])
    friction = rng.uniform([1e-3, 0.0, 0.0], [0.03, 0.1, 0.1]) * (1.0, *(rng.random(2) < 0.7))
    return {
        "force_N": rng.uniform(0.1, 10.0),
        "inertia": HandleInertia(*inertia, 10.0 ** rng.uniform(-6.0, -2.5)),
        "held_masses": HeldMasses(*held),
        "friction": HandleFriction(*friction),
        "encoder_count": 3.8e-4,
    }


def cases(seed: int, count: int) -> Iterator[tuple[DeltaGeometry, np.ndarray, dict[str, Any]]]:
    """Mechanisms, a quarter of them placed, positions above the elbows, a quarter on the cube's axis, and machines."""
    rng = np.random.default_rng(seed)
    axis = [(FLAT, np.array([0.0, 0.0, z])) for z in np.linspace(0.02, 0.06, count)]  # where two eigenvalues meet
    for g, p in (*axis, *poses(rng, 2 * count, 1e-4), *poses(rng, count, 1e-4, placed=True)):
        if direct_margin(g, p) > 0.02 and conditioning(g, p) < 100.0:
            yield g, p, machine(rng)


def table(g: DeltaGeometry, limit: PoseLimit, box: np.ndarray) -> np.ndarray:
    """(rows, columns) of its margins over a box: centre, half sides, m."""
    pose, work, out = room()
    margins(np.append(box, 0.0), numbers(g, Limits.of(limit)), BITS[type(limit)], pose, work, out)
    return out[FIRST[type(limit)] :][: limit.enclosure.rows]


def exact(g: DeltaGeometry, limit: PoseLimit, point: np.ndarray) -> list[Decimal | None]:
    return exact_margins(g, Limits.of(limit), tuple(map(float, point)))[type(limit)]


@EACH
@pytest.mark.parametrize("size", [0.0, 1e-6, 1e-4, 1e-3])
def test_bounds_contain_the_exact_margins(kind: type[PoseLimit], figure: FigureOfMerit, size: float) -> None:
    rng, finite, tried = np.random.default_rng(29), 0, 0
    for n, (g, p, given) in enumerate(cases(29, 12)):
        tried += 1
        limit = stated(kind, figure, given, moved(figure, float(figure.worst(kind.measured(given), g, p)), 0.1))
        half = size * rng.uniform(0.0, 1.0, 3) * (1.0, 1.0, n % 3 > 0)
        bounds = table(g, limit, np.array([*p, *half]))
        finite += int(np.isfinite(bounds[:, LOW]).all())
        for point in samples(np.array([*p, *half]), rng, 8 if size else 1):
            for value, (low, high) in zip(exact(g, limit, point), bounds[:, [LOW, HIGH]], strict=True):
                if kind is Kappa and low == 0.0:  # README (34) proves the sign alone
                    assert value is not None
                    assert 0 <= value <= Decimal(high)
                else:
                    assert value is None or math.isnan(low) or Decimal(low) <= value <= Decimal(high)
    assert finite > 0.8 * tried


@EACH
def test_at_a_position_both_arithmetics_decide_to_the_last_digits(kind: type[PoseLimit], figure: FigureOfMerit) -> None:
    for g, p, given in cases(47, 12):
        value, pose = float(figure.worst(kind.measured(given), g, p)), SlopePose(g, p[None], p[None])
        if value in figure.range:  # a lean of 0 on the axis: nothing is stricter
            continue
        for share, kept in ((-1e-8, False), (1e-8, True)):
            limit = stated(kind, figure, given, moved(figure, value, share))
            assert bool(limit.proved_by_intervals(pose, exactly)[0]) is kept
            assert limit.refuted_by_intervals(pose, exactly) is not kept
            bounds = table(g, limit, np.array([*p, 0.0, 0.0, 0.0]))
            assert (bounds[:, LOW] >= 0.0).all() if kept else (bounds[:, HIGH] < 0.0).any()


@EACH
@pytest.mark.parametrize("size", [1e-5, 1e-4, 1e-3])
def test_no_box_is_proved_that_holds_a_worse_position(
    kind: type[PoseLimit], figure: FigureOfMerit, size: float
) -> None:
    rng, proved, tried = np.random.default_rng(43), np.zeros(2), 0
    for g, p, given in cases(43, 12):
        box = np.array([*p, size, size, size])
        corners = samples(box, rng, 60)
        if not (closure_margin(g, corners) > 1e-5).all():
            continue
        tried += 1
        values = figure.worst(kind.measured(given), g, corners)
        worst = float(values.max() if figure.upper else values.min())
        pose = SlopePose(g, corners.min(axis=0)[None], corners.max(axis=0)[None])
        strict = stated(kind, figure, given, moved(figure, worst, -1e-10))
        assert not strict.proved_by_intervals(pose, exactly)[0]
        assert not (table(g, strict, box)[:, LOW] >= 0.0).all()
        lax = stated(kind, figure, given, moved(figure, worst, 300.0 * size))  # twice its size over w, some 10 mm
        proved += bool(lax.proved_by_intervals(pose, exactly)[0]), bool((table(g, lax, box)[:, LOW] >= 0.0).all())
    assert (proved > 0.5 * tried).all()


@pytest.mark.parametrize("kind", [kind for kind in POSE_LIMITS if kind not in (Reach, Lean)], ids=lambda k: k.name)
def test_where_a_chain_is_open_the_second_arithmetic_says_nothing(kind: type[PoseLimit]) -> None:
    limit, p = kind.measured(machine(np.random.default_rng(1))), np.array([[0.0, 0.0, 0.3]])
    assert limit is not None
    assert not limit.proved_by_intervals(SlopePose(PUBLISHED, p, p), exactly)[0]
    assert not limit.refuted_by_intervals(SlopePose(PUBLISHED, p, p), exactly)


# proof


def least(values: np.ndarray, p: np.ndarray) -> np.ndarray:
    """The smallest of figures of positions (..., 3), one or three each."""
    return np.reshape(values, (*p.shape[:-1], -1)).min(axis=-1)


@cache
def designs() -> list[tuple[DeltaGeometry, Cube, dict[str, Any], CubeSearch]]:
    """Random designs some way from both singularities and from the rods' own, closer to which proofs take seconds."""
    rng, found = np.random.default_rng(41), []
    while len(found) < 8:
        a, lb, bottom, half = rng.uniform([-0.02, 0.06, 0.02, 0.01], [0.04, 0.25, 0.2, 0.06])
        g, cube = DeltaGeometry(a + 0.05, 0.05, 0.082, lb), Cube(bottom, half)
        search = CubeSearch(cube, 31)
        smallest = [
            search(lambda p, f=f, g=g: np.nan_to_num(least(f(g, p), p), nan=-1.0), 1.0).value
            for f in (closure_margin, direct_margin, couple_index)
        ]
        if smallest[0] > 1e-4 and min(smallest[1:]) > 0.05:
            found.append((g, cube, machine(rng), search))
    return found


@cache
def worst(n: int, kind: type[PoseLimit], figure: FigureOfMerit) -> Extreme:
    g, _, given, search = designs()[n]
    limit = kind.measured(given)
    return search(lambda p: figure.worst(limit, g, p), -1.0 if figure.upper else 1.0)


@EACH
@pytest.mark.parametrize("n", [0, 1, *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 8))])
def test_random_designs_are_proved_just_above_and_refuted_just_below(
    kind: type[PoseLimit], figure: FigureOfMerit, n: int
) -> None:
    g, cube, given, _ = designs()[n]
    value, at = worst(n, kind, figure)
    lax, strict = (stated(kind, figure, given, moved(figure, value, share)) for share in (1e-3, -1e-3))
    proof = prove(g, cube, Limits.of(lax))
    assert proof.verdict == "proved"
    (found,) = (f for f in prove(g, cube, Limits.of(strict)).findings if f.condition == kind.name)
    assert (found.verdict, found.limit) == ("refuted", strict.thresholds())
    assert found.point is not None
    assert found.value == strict.broken(g, np.array(found.point))
    beyond = [strict.bound(figure), found.value, moved(figure, value, 1e-9)]
    assert sorted(beyond, reverse=not figure.upper) == beyond
    assert any(margin < 0 for margin in exact(g, strict, np.array(found.point)) if margin is not None)
    assert (cube.lower <= found.point).all()
    assert (found.point <= cube.upper).all()
    assert breaks(g, strict, np.array(found.point))
    assert breaks(g, strict, np.array(at))
    assert not breaks(g, lax, np.array(at))
    # the second arithmetic, over the same boxes and their halves
    low, high = leaves(cube, proof.leaves)
    examined, unproved = replay(g, [lax], low, high)
    assert unproved is None
    assert examined < 50 * len(low) + 1_000
    _, unproved = replay(g, [strict], low, high, max_boxes=4_000)
    assert unproved is not None
    assert unproved.condition == kind.name


# another machine

NUMBERS = [
    (kind, name)
    for kind in (Torque, HoldingTorque, Friction, PositionStep)
    for name in kind.keys
    if name not in {figure.threshold for figure in kind.figures} | set(kind.mass_kinds)
]
MASSES = [(kind, name, key) for kind in POSE_LIMITS for name, masses in kind.mass_kinds.items() for key in masses.keys]


@pytest.mark.parametrize(("kind", "name"), NUMBERS)
def test_less_force_friction_or_count_is_less_strict(kind: type[PoseLimit], name: str) -> None:
    limit: Any = kind.measured(machine(np.random.default_rng(1)))
    less, more = (
        replace(limit, **{name: math.nextafter(getattr(limit, name), towards)}) for towards in (0.0, math.inf)
    )
    assert less.less_strict_than(limit)
    assert not more.less_strict_than(limit)


@pytest.mark.parametrize(("kind", "name", "key"), MASSES)
@pytest.mark.parametrize("towards", [math.inf, -math.inf])
def test_other_masses_are_another_machine(kind: type[PoseLimit], name: str, key: str, towards: float) -> None:
    limit: Any = kind.measured(machine(np.random.default_rng(1)))
    masses = getattr(limit, name)
    other = replace(limit, **{name: replace(masses, **{key: math.nextafter(getattr(masses, key), towards)})})
    assert other.less_strict_than(limit)
    assert Limits.of(other).less_strict_than(Limits.of(limit)) == kind.name
