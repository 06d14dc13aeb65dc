"""A hundred machines in mirror symmetry, placed anywhere, against textbook vectors; proofs against a dense search.

20 s of processor, 60 s with the slow ones: two proofs of every limit and another program's search for each machine.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, forward_kinematics, inverse_kinematics, jacobian
from delta_cad.mechanism.limits import (
    POSE_LIMITS,
    FigureOfMerit,
    HandleFriction,
    HandleInertia,
    HeldMasses,
    Limits,
    PoseLimit,
    Reach,
)
from delta_cad.mechanism.proof.ball_friction import ball_friction
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.limits.proving import FIGURES, leaves, moved
from tests.delta_cad.mechanism.proof.deviating import Figures
from tests.delta_cad.mechanism.proof.deviating import figures as of_many
from tests.delta_cad.mechanism.proof.textbook import Loads, Machine, Pose, figures, pose

COUNT = 100
LOADS = Loads(
    *(3.0, 0.06, 0.01, 0.004, 2e-4),
    *((0.5, 0.0, -9.8), 0.08, 0.003, -4e-4, 0.0, 0.0),
    *(0.012, 0.05, 0.08, 3.8e-4),
)
NAMES = {"reach": "elbow_arm", "effective_mass": "mass", "torque_with_gravity": "holding_torque", "": "determinant"}
"""Figures that the search's program calls by another name."""
ABOVE = 1e-3
"""Share of a threshold, or rad, by which it is laxer or stricter than the worst that the search finds."""


def values_of(load: Loads) -> dict[str, Any]:
    """What limits need to know of the same."""
    gx, gy, gz = load.gravity
    held = load.held, load.along_arm, load.across_arm, load.loose_mass, load.loose_moment
    return {
        "force_N": load.force,
        "inertia": HandleInertia(load.carried, load.at_elbow, load.between, load.joint),
        "held_masses": HeldMasses(gx, gy, gz, *held),
        "friction": HandleFriction(load.drive, load.upright, load.level),
        "encoder_count": load.encoder_count,
    }


def limit_of(kind: type[PoseLimit], load: Loads = LOADS) -> PoseLimit:
    limit = kind.measured(values_of(load))
    assert limit is not None
    return limit


def drawn(g: DeltaGeometry, phi_deg: float, side_mm: float) -> Machine:
    """The machine in the words of the textbook: its azimuth in radians, not by its cosine."""
    phi, side = np.radians(phi_deg), side_mm / 1000.0
    radii = g.base_radius, side, side
    return Machine((0.0, phi, -phi), radii, g.platform_radius, g.upper_arm_length, g.forearm_length)


@cache
def placed() -> list[tuple[DeltaGeometry, Cube, Machine]]:
    """Machines of a joystick's size with their cubes, in which no chain comes near its fold."""
    rng, found = np.random.default_rng(43), []
    while len(found) < COUNT:
        R, r, arm, rod, phi, share = rng.uniform([25, 15, 70, 100, 100, 0.7], [50, 40, 110, 180, 140, 1.5])
        bottom, half, centre = rng.uniform([50, 15, -20], [110, 45, 20])
        side = R * share
        g = DeltaGeometry(R / 1e3, r / 1e3, arm / 1e3, rod / 1e3, (side - R) / 1e3, float(np.cos(np.radians(phi))))
        cube = Cube(bottom / 1e3, half / 1e3, centre / 1e3)
        machine = drawn(g, phi, side)
        with np.errstate(invalid="ignore"):
            seen = searched(machine, cube, grid(cube, 5))
        held = seen.determinant.min() > 0.1 * g.forearm_length**3 and seen.couple_index.min() > 0.1
        if held and seen.elbow_arm.min() > 0.01 and seen.kappa.max() < 8.0:  # not where one of them is not a number
            found.append((g, cube, machine))
    return found


def grid(cube: Cube, n: int) -> np.ndarray:
    """Positions of both halves of a cube's surface, (k, 3)."""
    line = np.linspace(-1.0, 1.0, n)
    unit = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    unit = unit[(np.abs(unit) == 1.0).any(axis=1)]
    middle = np.array([cube.centre_x, 0.0, cube.bottom_height + cube.half_side])
    return middle + cube.half_side * unit


def searched(m: Machine, cube: Cube, p: np.ndarray) -> Figures:
    """Figures at positions, kept inside the cube's doubles, by the program that knows machines of unequal chains."""
    return of_made(m, chains_of(m)[None], np.clip(p, cube.lower, cube.upper))


def chains_of(m: Machine) -> np.ndarray:
    """(3, 8) its chains as that program has them."""
    return np.array([[radius, 0, 0, m.platform_radius, 0, 0, m.upper_arm, m.forearm] for radius in m.base_radii])


def of_made(m: Machine, chains: np.ndarray, p: np.ndarray) -> Figures:
    """Figures of machines whose chains (machines, 3, 8) stand at the azimuths of another."""
    masses = LOADS.carried, LOADS.at_elbow, LOADS.between, LOADS.joint
    held = LOADS.gravity[0], LOADS.gravity[2], LOADS.held, LOADS.along_arm, LOADS.across_arm
    joints = LOADS.drive, LOADS.upright, LOADS.level, LOADS.encoder_count
    azimuths = tuple(np.degrees(m.azimuths).tolist())
    return of_many(chains, p, LOADS.force, masses, held, joints, azimuths)


def worst(m: Machine, cube: Cube, figure: FigureOfMerit, coarse: Figures, p: np.ndarray) -> tuple[float, np.ndarray]:
    """The worst of a figure: the best of a dense grid, then finer and finer ones about the best so far."""
    name = NAMES.get(figure.name, figure.name)
    pick = np.argmax if figure.upper else np.argmin
    found = getattr(coarse, name)[0]
    best = p[pick(found)]
    step, around = cube.half_side / 10.0, np.stack(np.meshgrid(*[[-1.0, -0.5, 0.0, 0.5, 1.0]] * 3), -1).reshape(-1, 3)
    for _ in range(16):
        near = np.clip(best + step * around, cube.lower, cube.upper)
        found = getattr(searched(m, cube, near), name)[0]
        best, step = near[pick(found)], 0.5 * step
    return float(found[pick(found)]), best


def positions(cube: Cube, rng: np.random.Generator, n: int) -> np.ndarray:
    return rng.uniform(cube.lower, cube.upper, (n, 3))


# figures


def test_every_figure_of_a_hundred_machines_is_that_of_textbook_vectors() -> None:
    rng, loads = np.random.default_rng(1), [LOADS]
    loads.append(LOADS._replace(gravity=(-2.0, 1.5, -9.0), loose_mass=4e-5, loose_moment=3e-6, between=-0.002))
    for g, cube, machine in placed():
        for p, load in zip(positions(cube, rng, 2), loads, strict=True):
            at = pose(machine, p)
            np.testing.assert_allclose(inverse_kinematics(g, p), at.theta, atol=1e-12)
            np.testing.assert_allclose(forward_kinematics(g, at.theta), p, atol=1e-12)
            np.testing.assert_allclose(jacobian(g, p), at.jacobian, rtol=1e-9, atol=1e-9 * np.abs(at.jacobian).max())
            expected = figures(machine, at, load)
            found = {f.name: float(f.worst(limit_of(kind, load), g, p)) for kind, f in FIGURES}
            assert found == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_a_mirrored_position_has_mirrored_figures() -> None:
    rng, mirror = np.random.default_rng(2), np.diag([1.0, -1.0, 1.0])
    for g, cube, _ in placed():
        p = positions(cube, rng, 4)
        order = [0, 2, 1]
        np.testing.assert_allclose(inverse_kinematics(g, p @ mirror), inverse_kinematics(g, p)[:, order], rtol=1e-13)
        turned = (mirror @ jacobian(g, p))[..., order]
        np.testing.assert_allclose(jacobian(g, p @ mirror), turned, rtol=1e-9, atol=1e-12)
        for kind, figure in FIGURES:
            limit = limit_of(kind)
            np.testing.assert_allclose(figure.worst(limit, g, p @ mirror), figure.worst(limit, g, p), rtol=1e-11)


def test_both_programs_of_the_tests_agree() -> None:
    rng = np.random.default_rng(3)
    for _, cube, machine in placed()[:20]:
        (p,) = positions(cube, rng, 1)
        expected, found = figures(machine, pose(machine, p), LOADS), searched(machine, cube, p[None])
        for name, value in expected.items():
            size = machine.forearm**3 if name == "" else 1.0
            assert getattr(found, NAMES.get(name, name))[0, 0] / size == pytest.approx(value, rel=1e-9)


def test_ball_joints_take_no_more_than_their_bound_which_is_near() -> None:
    lean, turn, step = 1.3e-3, 0.7e-3, 1e-6
    rng = np.random.default_rng(4)

    def angles(machine: Machine, at: Pose) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Lean of the rods, their direction in the plane of their chains, and that less the arm's."""
        n, radial = at.rods / machine.forearm, np.cross(at.axes, [0.0, 0.0, 1.0])
        flat = np.arctan2(n[:, 2], (n * radial).sum(axis=1))
        return np.arcsin((n * at.axes).sum(axis=1)), flat, flat - at.theta

    for g, cube, machine in placed()[:3]:
        upright, level = ball_friction(g, cube, lean, turn)
        most = np.zeros(2)
        corners = cube.lower + (cube.upper - cube.lower) * np.stack(np.meshgrid(*[[0.001, 0.999]] * 3), -1).reshape(
            -1, 3
        )
        for p in np.concatenate([corners, positions(cube, rng, 8)]):
            for k, v in enumerate([np.array([0.0, 0.0, 1.0]), *np.array([[1, 0, 0], [0, 1, 0], [0.6, 0.8, 0]])]):
                ends = [angles(machine, pose(machine, p + side * step * v)) for side in (0.5, -0.5)]
                rates = [(after - before) / step for after, before in zip(*ends, strict=True)]
                at = ends[0][0]
                taken = sum(
                    (lean * np.hypot(rate * np.sin(at), rates[0]) + turn * np.abs(rate) * np.cos(at)).sum()
                    for rate in rates[1:]
                )
                most[min(k, 1)] = max(most[min(k, 1)], taken)
        assert (most <= np.array([upright, level]) * (1.0 + 1e-5)).all()
        assert (most >= 0.8 * np.array([upright, level])).all()


# proofs


@cache
def extremes(n: int) -> dict[FigureOfMerit, tuple[float, np.ndarray]]:
    _, cube, machine = placed()[n]
    p = np.clip(grid(cube, 21), cube.lower, cube.upper)
    coarse = searched(machine, cube, p)
    return {figure: worst(machine, cube, figure, coarse, p) for _, figure in FIGURES}


def around(n: int, share: float) -> Limits:
    """Every limit, laxer than the worst by a share of it, or by as many rad; stricter for a negative one."""
    limits = []
    for kind in POSE_LIMITS:
        limit = limit_of(kind)
        for figure in kind.figures:
            if figure.threshold:
                limit = limit.with_bound(figure, moved(figure, extremes(n)[figure][0], share))
        limits.append(limit)
    return Limits.of(*limits)


@pytest.mark.parametrize("tens", [0, 1, *(pytest.param(n, marks=pytest.mark.slow) for n in range(2, 10))])
def test_what_a_dense_search_finds_is_proved_just_above_and_refuted_just_below(tens: int) -> None:
    for n in range(COUNT // 10 * tens, COUNT // 10 * (tens + 1)):
        g, cube, machine = placed()[n]
        lax, strict = around(n, ABOVE), around(n, -ABOVE)
        proof = prove(g, cube, lax)
        assert {f.condition: f.verdict for f in proof.findings} == dict.fromkeys(lax.names, "proved")
        folded = prove(g, cube, Limits.of(strict["reach"])).findings[0]
        findings = [folded, *prove(g, cube, strict.with_(Reach())).findings[1:]]
        for found in findings:
            limit = strict[found.condition]
            if not any(figure.threshold for figure in limit.figures):  # the assembly mode, whose bound is 0
                assert found.verdict == "proved"
                continue
            assert (found.condition, found.verdict) == (limit.name, "refuted")
            point = np.array(found.point)
            assert ((cube.lower <= point) & (point <= cube.upper)).all()
            real = figures(machine, pose(machine, point), LOADS)
            beyond = [(real[f.name] - limit.bound(f)) * (1.0 if f.upper else -1.0) for f in limit.figures]
            assert max(beyond) > 0.0
            assert breaks(g, limit, point)
        if n % 10 == 0:  # the second arithmetic over the same boxes
            low, high = leaves(cube, proof.leaves)
            assert replay(g, list(lax), low, high)[1] is None


def test_with_a_tolerance_no_machine_of_it_breaks_what_is_proved() -> None:
    tolerance, rng, proved = 2e-5, np.random.default_rng(6), 0
    for n in range(6):
        g, cube, machine = placed()[n]
        limits = around(n, 0.05)
        proof = prove(g, cube, limits, tolerance=tolerance, max_boxes=20_000)
        kept = [limits[f.condition] for f in proof.findings if f.verdict == "proved"]
        assert "refuted" not in {f.verdict for f in proof.findings}
        proved += len(kept)
        low, high = leaves(cube, proof.leaves)
        assert replay(g, kept, low, high, tolerance=tolerance)[1] is None
        made = chains_of(machine) + tolerance * np.sign(rng.uniform(-1.0, 1.0, (200, 3, 8)))
        found = of_made(machine, made, np.array([at for _, at in extremes(n).values()]))
        for limit in kept:
            for figure in limit.figures:
                values = getattr(found, NAMES.get(figure.name, figure.name))
                edge = limit.bound(figure)
                assert (values <= edge if figure.upper else values >= edge).all()
    assert proved > 0.8 * 6 * len(POSE_LIMITS)


def test_a_search_of_the_cube_finds_what_the_dense_one_does() -> None:
    for n in range(5):
        g, cube, _ = placed()[n]
        search = CubeSearch(cube, 21)
        for kind, figure in FIGURES:
            if figure.threshold:
                limit = limit_of(kind)
                found = search(
                    lambda p, f=figure, g=g, limit=limit: f.worst(limit, g, p), -1.0 if figure.upper else 1.0
                )
                assert found.value == pytest.approx(extremes(n)[figure][0], rel=2e-4, abs=1e-4)
