"""Proofs of all machines within a tolerance, against machines made one by one: README (43)-(46)."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.mechanism import Cube, GeometryError
from delta_cad.mechanism.enclosure.interval import Interval, exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import LOW
from delta_cad.mechanism.geometry import largest_tolerance
from delta_cad.mechanism.limits import (
    POSE_LIMITS,
    AssemblyMode,
    EffectiveMass,
    FigureOfMerit,
    HandleFriction,
    HandleInertia,
    HeldMasses,
    Kappa,
    Limits,
    PoseLimit,
    Reach,
)
from delta_cad.mechanism.proof.extremes import worst_figures
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from delta_cad.mechanism.proof.prove import prove
from optimizer.certify.replay import replay
from optimizer.certify.tolerance import search_tolerance
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED
from tests.delta_cad.mechanism.proof.deviating import Figures, figures

CUBE = Cube(BOTTOM, HALF)
INERTIA = HandleInertia(0.1, 0.01, 0.005, 2e-4)
HELD = HeldMasses(0.5, 0.0, -9.8, 0.08, 0.003, -4e-4, 0.0, 0.0)
RUBS, COUNT = HandleFriction(0.012, 0.05, 0.08), 3.8e-4
VALUES = {
    "force_N": 3.0,
    "joint_torque_N_m": 0.8,
    "inertia": INERTIA,
    "held_masses": HELD,
    "friction": RUBS,
    "encoder_count": COUNT,
}
NAMES = {"reach": "elbow_arm", "effective_mass": "mass", "torque_with_gravity": "holding_torque"}
"""Figures that the oracle calls by another name."""
T = 5e-5
DRAWN = np.tile(
    [
        PUBLISHED.base_radius,
        0,
        0,
        PUBLISHED.platform_radius,
        0,
        0,
        PUBLISHED.upper_arm_length,
        PUBLISHED.forearm_length,
    ],
    (3, 1),
)
GAP = {
    "reach": 1.2, "torque": 6.5, "kappa": 3.0, "lean": 1.2, "shoulder_min": 1.4, "shoulder_max": 1.9,
    "effective_mass": 2.0, "couple_index": 1.9, "torque_with_gravity": 13.6, "friction": 2.3, "position_step": 7.8,
    "elbow_angle": 3.1,
}  # fmt: skip
"""How many times the tolerance proved the worst machine known breaks the limit; 1 would be exact, README (46)."""


def worst_of(chains: np.ndarray, p: np.ndarray) -> Figures:
    i, h = INERTIA, HELD
    held = (h.gravity_x, h.gravity_z, h.carried_mass, h.arm_moment, h.cross_moment)
    masses = (i.carried_mass, i.elbow_mass, i.cross_mass, i.joint_inertia)
    return figures(chains, p, 3.0, masses, held, (*RUBS, COUNT))


def of(found: Figures, figure: FigureOfMerit) -> np.ndarray:
    return getattr(found, NAMES.get(figure.name, figure.name))


def test_the_oracle_agrees_on_the_drawn_machine() -> None:
    p = np.random.default_rng(0).uniform(CUBE.lower, CUBE.upper, (50, 3))
    found = worst_of(DRAWN[None], p)
    for kind in POSE_LIMITS:
        limit = kind.measured(VALUES)
        assert limit is not None
        for figure in limit.figures:
            own = figure.worst(limit, PUBLISHED, p)
            if figure.threshold:
                np.testing.assert_allclose(of(found, figure)[0], own, rtol=1e-12)
            else:  # det S, there by L_B^3
                np.testing.assert_allclose(found.determinant[0] / PUBLISHED.forearm_length**3, own, rtol=1e-12)


def test_a_mirrored_machine_has_the_same_figures_at_the_mirrored_point() -> None:
    rng = np.random.default_rng(1)
    chains, p = DRAWN + 1e-3 * rng.uniform(-1.0, 1.0, (20, 3, 8)), rng.uniform(CUBE.lower, CUBE.upper, (20, 3))
    mirrored = chains[:, [0, 2, 1]] * np.array([1, -1, 1, 1, -1, 1, 1, 1])
    for a, b in zip(worst_of(chains, p), worst_of(mirrored, p * np.array([1.0, -1.0, 1.0])), strict=True):
        np.testing.assert_allclose(a, b, rtol=1e-9)


@pytest.fixture(scope="module")
def tight() -> Limits:
    """Each limit as tight as it is proved with the tolerance, to a tenth of what that costs."""
    limits = []
    worst = worst_figures(PUBLISHED, CUBE, Limits.measured(VALUES))
    for kind in POSE_LIMITS:
        limit = kind.measured(VALUES)
        assert limit is not None
        for one in worst:
            if type(one.limit) is kind and one.figure.threshold:
                away = 1e-7 * (1.0 if one.figure.upper else -1.0)
                limit = limit.with_bound(one.figure, one.value * (1.0 + away) if one.value > 0 else one.value - 1e-7)
        limits.append(limit)
    drawn = Limits.of(*limits)
    assert prove(PUBLISHED, CUBE, drawn).verdict == "proved"
    found = search_tolerance(PUBLISHED, CUBE, lambda _: drawn, T)
    assert 0.0 < found.tolerance < 1e-6
    for need in found.needs:
        assert need.bound is not None
        drawn = drawn.with_(drawn[need.condition].with_bound(need.figure, need.bound))
    return drawn


@pytest.mark.slow
def test_what_is_proved_and_replayed_holds_for_a_hundred_thousand_machines_at_their_worst_points(tight: Limits) -> None:
    proof = prove(PUBLISHED, CUBE, tight, tolerance=T)
    assert proof.verdict == "proved"
    low = np.array([-HALF, 0.0, BOTTOM])
    size = (CUBE.upper - low) / 2.0 ** proof.leaves[:, ::2]
    low = low + proof.leaves[:, 1::2] * size
    assert replay(PUBLISHED, list(tight), low, low + size, tolerance=T)[1] is None

    worst = worst_figures(PUBLISHED, CUBE, Limits.measured(VALUES))
    points = np.array([one.position for one in worst if one.figure.threshold])
    gradients = steepest(tight, points)
    rng, made = np.random.default_rng(2), 0
    breaking: dict[str, float] = {}
    while made < 100_000:
        away = rng.uniform(-1.0, 1.0, (5_000, 3, 8))
        away[::2] = np.sign(away[::2])  # corners of the tolerance
        away[: len(gradients)] = gradients
        found = worst_of(DRAWN + T * away, points)
        assert (found.determinant > 0.0).all()
        for limit in tight:
            for figure in limit.figures:
                if figure.threshold:
                    worst = of(found, figure)
                    assert (worst <= limit.bound(figure) if figure.upper else worst >= limit.bound(figure)).all()
        made += len(away)
    for factor in np.arange(1.0, 16.0, 0.05):
        found = worst_of(DRAWN + factor * T * gradients, points)
        for limit in tight:
            for figure in limit.figures:
                worst = of(found, figure) if figure.threshold else np.ones(1)
                edge = limit.bound(figure)
                if (worst > edge if figure.upper else worst < edge).any():
                    breaking.setdefault(figure.name, float(factor))
    assert breaking.keys() == GAP.keys()
    assert {name: factor for name, factor in breaking.items() if factor > GAP[name]} == {}


def steepest(tight: Limits, points: np.ndarray) -> np.ndarray:
    """Corners of the tolerance towards which each figure gets worse fastest at each point, (n, 3, 8)."""
    step, eye = 1e-7, np.eye(24).reshape(24, 3, 8)
    change, still = worst_of(DRAWN + step * eye, points), worst_of(DRAWN[None], points)
    found = []
    for limit in tight:
        for figure in limit.figures:
            if figure.threshold:
                towards = np.sign(of(change, figure) - of(still, figure)) * (1.0 if figure.upper else -1.0)
                found.extend(towards.T.reshape(-1, 3, 8))
    return np.array(found)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-4, 1e-3])
def test_neither_arithmetic_proves_what_one_machine_breaks(tolerance: float) -> None:
    rng, count, tried = np.random.default_rng(3), 60, 0
    p = rng.uniform(CUBE.lower, CUBE.upper, (count, 3))
    away = np.sign(rng.uniform(-1.0, 1.0, (count, 3, 8)))
    half = np.repeat(rng.choice([0.0, 1e-5, 1e-3], (count, 1)), 3, axis=1)
    found = worst_of(DRAWN + tolerance * away, p)
    pose, work, table = room()
    second = SlopePose(PUBLISHED, p - half, p + half, tolerance)
    for kind in POSE_LIMITS:
        free = kind.measured(VALUES)
        assert free is not None
        for figure in free.figures:
            if figure.threshold:
                limits = [stricter(free, figure, float(value)) for value in np.diagonal(of(found, figure))]
                assert not proved_again(limits, figure, second).any(), figure.name
                for limit, middle, size in zip(limits, p, half, strict=True):
                    k = numbers(PUBLISHED, Limits.of(limit), tolerance)
                    margins(np.array([*middle, *size, 0.0]), k, BITS[kind], pose, work, table)
                    assert not (table[FIRST[kind] : FIRST[kind] + kind.enclosure.rows, LOW] >= 0.0).all(), figure.name
                    tried += 1
    assert tried == count * 12


@pytest.mark.parametrize("kind", POSE_LIMITS)
def test_what_is_far_within_is_proved_again_in_each_box_alone(kind: type[PoseLimit]) -> None:
    """The test above would see a proof: limits that every second box keeps by far and the others break."""
    p = np.random.default_rng(4).uniform(CUBE.lower, CUBE.upper, (6, 3))
    found, second, free = worst_of(DRAWN[None], p), SlopePose(PUBLISHED, p, p, 1e-6), kind.measured(VALUES)
    assert free is not None
    for figure in free.figures:
        if figure.threshold:
            away = 1e-2 * (-1.0) ** np.arange(6) * (1.0 if figure.upper else -1.0)
            values = of(found, figure)[0] + away * np.abs(of(found, figure)[0])
            limits = [free.with_bound(figure, float(value)) for value in values]
            assert proved_again(limits, figure, second).tolist() == [True, False] * 3, figure.name


def proved_again(limits: list[PoseLimit], figure: FigureOfMerit, pose: SlopePose) -> np.ndarray:
    """Whether the second arithmetic proves each limit over its own box: at once where the bound comes as a number."""
    bounds, required = np.array([limit.bound(figure) for limit in limits]), []

    def exact(x: float) -> Interval:
        if x == bounds[0]:
            required.append(x)
            return exactly(bounds)
        return exactly(x)

    found = limits[0].proved_by_intervals(pose, exact)
    if not required:
        found = np.array([limit.proved_by_intervals(pose, exactly)[i] for i, limit in enumerate(limits)])
    return found


def stricter(free: PoseLimit, figure: FigureOfMerit, value: float) -> PoseLimit:
    """The limit that a machine of this figure just breaks."""
    return free.with_bound(figure, value * (1.0 - 1e-9 * (1.0 if figure.upper == (value > 0.0) else -1.0)))


def test_without_a_tolerance_nothing_changes_and_a_wrong_one_is_refused() -> None:
    limits = Limits.of(Reach(), AssemblyMode(), Kappa(2.3), EffectiveMass(0.6, INERTIA))
    a, b = prove(PUBLISHED, CUBE, limits), prove(PUBLISHED, CUBE, limits, tolerance=0.0)
    np.testing.assert_array_equal(a.leaves, b.leaves)
    for wrong in (-1e-9, float("nan"), float("inf"), largest_tolerance(PUBLISHED) * 1.001):
        with pytest.raises(GeometryError, match="tolerance is"):
            prove(PUBLISHED, CUBE, limits, tolerance=wrong)
    far = prove(PUBLISHED, CUBE, limits, tolerance=largest_tolerance(PUBLISHED))
    assert far.verdict == "undecided"
    assert far.boxes < 1_000
