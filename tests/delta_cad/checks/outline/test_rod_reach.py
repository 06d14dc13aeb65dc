"""Reach of the rods: never below dense sampling, box by box, and within its gap of the true extreme."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import CollisionBody, bodies_of
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import turn_about_x
from delta_cad.checks.outline.enclosed_maximum import enclosed_maximum
from delta_cad.checks.outline.envelope import DIRECTIONS, shoulder_range, swept_outline
from delta_cad.checks.outline.rod_reach import GAP_MM, RodReach
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.placement import CHAINS, SIDES
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS, at, changed, machine, part, placement, rod

RING = part("ring", rod(5.5, (0, -2.25, 0), (0, 2.25, 0)))  # a socket's eye: its axis swings with the rod's lean
PLACEMENT = placement()
TILT = np.radians(30.0)  # of the synthetic machine's sockets
CUBES = [LIMITS, replace(LIMITS, bottom_height_mm=85.0, half_side_mm=20.0), replace(LIMITS, half_side_mm=30.0)]


def with_rings() -> Assembly:
    assembly = machine()
    for i in CHAINS:
        for j in SIDES:
            assembly = changed(assembly, f"socket_{i}_{j}_elbow", part=RING, placement=at())
    return assembly


MACHINE = with_rings()
MESHES = MeshLibrary(MACHINE.parts, 0.05, 0.35)
BODIES = bodies_of(MACHINE.occurrences, MESHES)


def reach(body: CollisionBody, p: np.ndarray, d: np.ndarray, turns: np.ndarray | None = None) -> np.ndarray:
    """(n,) reach of a body's mesh at handle positions (n, 3), straight from the placement.

    With turns (k,), shares of the free turn, it is the farthest of them.
    """
    frame = PLACEMENT(p)[body.link]
    if turns is not None and body.link.startswith("rod"):
        lean = np.arccos(np.clip(frame[:, :3, 1] @ GEOMETRY.tangential[int(body.link[4])], -1.0, 1.0))
        free = np.arccos(np.clip(np.cos(TILT) / np.cos(lean), 0.0, 1.0))
        turned = (frame @ turn_about_x(share * free) for share in turns)
        return np.max(
            [((f[:, :3, :3] @ body.hull.T + f[:, :3, 3:]).transpose(0, 2, 1) @ d).max(axis=1) for f in turned], 0
        )
    return ((frame[:, :3, :3] @ body.vertices.T + frame[:, :3, 3:]).transpose(0, 2, 1) @ d).max(axis=1)


def polished(body: CollisionBody, limits: CheckLimits, d: np.ndarray, turns: np.ndarray | None = None) -> float:
    """The extreme over the cube from below: random positions, then ever closer about the best of them."""
    rng, low = np.random.default_rng(5), limits.centre_mm - limits.half_side_mm
    best, value, scale = limits.centre_mm, -np.inf, 2.0 * limits.half_side_mm
    for _ in range(40):
        p = np.clip(best + rng.uniform(-scale, scale, (200, 3)), low, low + 2.0 * limits.half_side_mm)
        found = reach(body, p, d, turns)
        if found.max() > value:
            best, value = p[found.argmax()], float(found.max())
        scale *= 0.8
    return value


@pytest.mark.parametrize("name", ["socket_0_0_elbow", "socket_1_1_elbow", "socket_2_0_wrist", "tube_0_1", "tube_1_0"])
def test_no_position_in_a_box_reaches_beyond_its_bound(name: str) -> None:
    """The adversary samples corners, edges and the inside of boxes of all sizes, along directions all round."""
    rng, body = np.random.default_rng(11), BODIES[name]
    rods = RodReach(PLACEMENT, LIMITS, shoulder_range(GEOMETRY, LIMITS))
    halves = np.exp(rng.uniform(np.log(0.01), np.log(6.0), (120, 1))) * rng.uniform(0.0, 1.0, (120, 3))
    centres = LIMITS.centre_mm + rng.uniform(-1.0, 1.0, (120, 3)) * (LIMITS.half_side_mm - halves)
    for angle in rng.uniform(0.0, 2.0 * np.pi, 8):
        d = np.array([np.cos(angle), np.sin(angle), 0.0])
        bound, at_centre = rods.bounds(body, d, centres, halves)
        assert at_centre == pytest.approx(reach(body, centres, d), abs=1e-9)  # rounding of 100 mm
        for inside in np.clip(rng.uniform(-1.6, 1.6, (30, 1, 3)), -1.0, 1.0):
            assert (reach(body, centres + inside * halves, d) <= bound + 1e-9).all()


@pytest.mark.parametrize("name", ["socket_0_0_elbow", "socket_1_1_elbow", "socket_2_0_wrist"])
def test_no_turn_of_a_rod_about_itself_reaches_beyond_its_bound(name: str) -> None:
    rng, body, shares = np.random.default_rng(12), BODIES[name], np.linspace(-1.0, 1.0, 7)
    theta = shoulder_range(GEOMETRY, LIMITS)
    rods, still = RodReach(PLACEMENT, LIMITS, theta, TILT), RodReach(PLACEMENT, LIMITS, theta)
    halves = np.exp(rng.uniform(np.log(0.01), np.log(6.0), (60, 1))) * rng.uniform(0.0, 1.0, (60, 3))
    centres = LIMITS.centre_mm + rng.uniform(-1.0, 1.0, (60, 3)) * (LIMITS.half_side_mm - halves)
    exceeded = False
    for angle in rng.uniform(0.0, 2.0 * np.pi, 5):
        d = np.array([np.cos(angle), np.sin(angle), 0.0])
        bound, at_centre = rods.bounds(body, d, centres, halves)
        assert (reach(body, centres, d, shares) <= at_centre + 1e-9).all()
        for inside in np.clip(rng.uniform(-1.6, 1.6, (6, 1, 3)), -1.0, 1.0):
            turned = reach(body, centres + inside * halves, d, shares)
            assert (turned <= bound + 1e-9).all()
            exceeded |= bool((turned > still.bounds(body, d, centres, halves)[0] + 0.01).any())
    assert exceeded  # without the turn the bound would be wrong


def test_bounds_err_by_no_more_than_the_boxes_own_travel() -> None:
    """A travel |dp| moves the elbow by at most |dp| L_B / w, w > 40 mm, so 0.05 mm each way."""
    rods = RodReach(PLACEMENT, LIMITS, shoulder_range(GEOMETRY, LIMITS))
    centres = LIMITS.poses_mm()
    for name in ("socket_0_0_elbow", "socket_2_0_wrist", "tube_1_0"):
        for d in DIRECTIONS:
            bound, at_centre = rods.bounds(BODIES[name], d, centres, np.full_like(centres, 0.01))
            assert (bound - at_centre).max() < 0.1


@pytest.mark.quick(1)
@pytest.mark.parametrize("limits", CUBES)
def test_the_refined_bound_meets_the_polished_extreme(limits: CheckLimits) -> None:
    """Tightness: 0.05 mm, less than a mesh's deviation.

    Across its own chain the elbow does not move: only the ring's lean tells positions apart, whole surfaces of the cube
    come close to the extreme, and the number of boxes ends the search above the gap of 0.02 mm.
    """
    rods = RodReach(PLACEMENT, limits, shoulder_range(GEOMETRY, limits))
    for name in ("socket_0_0_elbow", "socket_1_0_elbow"):
        for d in DIRECTIONS:
            bound, attained = rods.refined(BODIES[name], d, -np.inf)
            extreme = polished(BODIES[name], limits, d)
            assert bound >= extreme
            assert attained <= extreme + 0.01  # the adversary's last steps are 0.01 mm
            assert bound <= attained + 0.05


def test_the_outline_of_the_whole_machine_is_as_tight() -> None:
    """Beyond the true sweep there is the gap of the rods, or that of the shoulder angle, and the mesh's deviation."""
    outline = swept_outline(MACHINE, LIMITS, MESHES)
    for k, d in enumerate(DIRECTIONS):
        body = outline.bodies[k]
        assert not body.link.startswith("platform")
        true = polished(body, LIMITS, d, np.linspace(-1.0, 1.0, 9))
        assert true <= outline.reach_mm[k] - body.mesh.deviation_mm <= true + 0.05


def test_what_stays_below_the_floor_is_not_looked_into() -> None:
    rods = RodReach(PLACEMENT, LIMITS, shoulder_range(GEOMETRY, LIMITS))
    body, d = BODIES["socket_0_0_elbow"], DIRECTIONS[0]
    bound, attained = rods.refined(body, d, 500.0)
    assert attained == 500.0
    assert bound == rods.coarse(body, d)


def test_shoulder_range_meets_the_polished_extremes() -> None:
    rng = np.random.default_rng(4)
    for limits in CUBES:
        theta = shoulder_range(GEOMETRY, limits)
        on_surface = np.clip(rng.uniform(-1.3, 1.3, (200_000, 3)), -1.0, 1.0)
        sampled = inverse_kinematics(GEOMETRY, (limits.centre_mm + limits.half_side_mm * on_surface) / 1000.0)
        assert (theta[:, 0] <= sampled.min(axis=0)).all()
        assert (theta[:, 1] >= sampled.max(axis=0)).all()
        assert theta[:, 0] == pytest.approx(sampled.min(axis=0), abs=1e-3)  # 0.5 mm between samples, 2e-2 rad / mm
        assert theta[:, 1] == pytest.approx(sampled.max(axis=0), abs=1e-3)


def test_elbow_socket_along_the_chain_in_closed_form() -> None:
    """With theta = 0 in the cube the ball reaches R + L_A, and the ring about it between its radius and its rim."""
    rods = RodReach(PLACEMENT, LIMITS, shoulder_range(GEOMETRY, LIMITS))
    bound, attained = rods.refined(BODIES["socket_0_0_elbow"], GEOMETRY.radial[0], -np.inf)
    assert attained > 40.0 + 82.0 + 5.5 - 0.06  # the facets of the ring stay 0.06 mm inside
    assert bound < 40.0 + 82.0 + np.hypot(5.5, 2.25) + GAP_MM


def test_enclosed_maximum_of_a_known_function_and_of_one_that_never_tightens() -> None:
    centres, halves = np.zeros((1, 3)), np.ones((1, 3))

    def parabola(c: np.ndarray, h: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        slack = np.abs(2.0 * (c - 0.3) * h).sum(axis=1)
        value = 2.0 - ((c - 0.3) ** 2).sum(axis=1)
        return value + slack, value

    bound, attained = enclosed_maximum(parabola, centres, halves, 1e-3)
    assert attained <= 2.0 <= bound <= attained + 1e-3
    bound, attained = enclosed_maximum(lambda c, _: (np.full(len(c), 7.0), np.zeros(len(c))), centres, halves, 1e-3)
    assert (bound, attained) == (7.0, 0.0)
    one = np.array([[0.4, 0.4, 0.4]])
    spike = enclosed_maximum(
        lambda c, h: (np.where((np.abs(c - one) <= h).all(axis=1), 1.0, -1.0), -np.ones(len(c))), centres, halves, 0.1
    )
    assert spike == (1.0, -1.0)  # one box alive all the way: the cuts end, the bound stays


def test_enclosed_maximum_keeps_the_bounds_of_boxes_that_were_set_aside() -> None:
    """The first box is left at once, its bound is within the gap; the second one tightens below it."""

    def two(c: np.ndarray, _: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        if len(c) == 2:
            return np.array([1.05, 2.0]), np.array([0.9, 1.0])
        return np.full(len(c), 1.0), np.full(len(c), 0.9)

    found = enclosed_maximum(two, np.array([[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]), np.ones((2, 3)), 0.1)
    assert found == (1.05, 1.0)
