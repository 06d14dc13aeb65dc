"""The bounds that the proof stands on, against the placement itself at many points of many boxes."""

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest
from scipy.spatial import KDTree

from delta_cad.assembly.tessellation import MeshLibrary, tessellate
from delta_cad.checks.clearance.bodies import DistanceEngine, body, boxes_gap, revolved_about_y
from delta_cad.checks.clearance.containment import winding_number
from delta_cad.checks.clearance.joint_ranges import BOXES_MOST, BOXES_PER_EDGE, FoldError, Raster, joint_ranges
from delta_cad.checks.clearance.motion import box_motion, cube_boxes
from delta_cad.checks.clearance.pairing import ClearancePair, clearance_pairs, spaces_of
from delta_cad.checks.links import chain_of, fixed_frame, swept_links
from delta_cad.mechanism import inverse_kinematics, rod_lean
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.placement import CHAINS
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS, at, ball, box, machine, placement, rod

MACHINE = machine()
MESHES = MeshLibrary(MACHINE.parts, 0.2, 0.6)
DOMAINS = joint_ranges(GEOMETRY, LIMITS.centre_mm, LIMITS.half_side_mm)
RNG = np.random.default_rng(7)


def random_boxes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Boxes of many sizes and shapes inside the cube."""
    halves = LIMITS.half_side_mm * 0.3 * RNG.uniform(0.01, 1.0, (count, 3)) * RNG.uniform(0.05, 1.0, (count, 1))
    centres = LIMITS.centre_mm + RNG.uniform(-1, 1, (count, 3)) * (LIMITS.half_side_mm - halves)
    return centres, halves


def chain_state(p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Shoulder angles (n, 3), forearm vectors (n, 3, 3) mm and rod frames (n, 3, 3, 3), from the placement."""
    theta = inverse_kinematics(GEOMETRY, p / 1000.0)
    rods = np.stack([placement()(p)[f"rod_{i}_0"][..., :3, :3] for i in CHAINS], axis=1)
    return theta, rods[..., :, 0] * 112.079, rods


def plane_angle(s: np.ndarray) -> np.ndarray:
    """(n, 3) angle of forearms in their chain's plane, 0..2 pi: some pass the horizontal inwards."""
    return np.mod(np.arctan2(s[..., 2], (s * GEOMETRY.radial).sum(-1)), 2.0 * np.pi)


def test_box_motion_bounds_hold_and_are_not_idle() -> None:
    centres, halves = random_boxes(300)
    motion = box_motion(GEOMETRY, centres, halves)
    theta0, s0, rods0 = chain_state(centres)
    assert motion.theta == pytest.approx(theta0, abs=1e-12)
    tightest = {"theta": 0.0, "forearm": 0.0, "rotation": 0.0}
    for _ in range(40):
        corner = (
            np.sign(RNG.uniform(-1, 1, centres.shape)) if RNG.uniform() < 0.5 else RNG.uniform(-1, 1, centres.shape)
        )
        theta, s, rods = chain_state(centres + corner * halves)
        change = np.abs(theta - theta0)
        assert (change <= motion.theta_change + 1e-12).all()
        forearm = np.linalg.norm(s - s0, axis=-1)
        assert (forearm <= motion.forearm + 1e-9).all()
        cosine = (np.einsum("ncij,ncij->nc", rods, rods0) - 1.0) / 2.0
        angle = np.arccos(np.clip(cosine, -1.0, 1.0))
        assert (angle <= motion.rotation + 1e-7).all()  # arccos near 1 is good to 1e-8
        plane, plane0 = plane_angle(s), plane_angle(s0)
        assert (np.abs(plane - plane0) <= motion.rotation + 1e-12).all()
        lean = rod_lean(GEOMETRY, (centres + corner * halves) / 1000.0)
        assert (lean >= motion.lean_low - 1e-12).all()
        assert (lean <= motion.lean_high + 1e-12).all()
        finite = np.isfinite(motion.theta_change)
        assert finite.mean() > 0.9
        for name, ratio in (
            ("theta", change / motion.theta_change),
            ("forearm", forearm / motion.forearm),
            ("rotation", angle / motion.rotation),
        ):
            tightest[name] = max(tightest[name], float(ratio[finite].max()))
    assert tightest["theta"] > 0.8  # a bound far above the truth would pass the test and stall the proof
    assert tightest["forearm"] > 0.5
    assert tightest["rotation"] > 0.5


def test_elbow_angle_is_the_angle_from_arm_to_forearm() -> None:
    centres, halves = random_boxes(50)
    theta, s, _ = chain_state(centres)
    plane = plane_angle(s)
    assert box_motion(GEOMETRY, centres, halves).elbow_angle == pytest.approx(plane - theta, abs=1e-12)


def test_a_box_that_holds_a_fold_is_not_bounded() -> None:
    motion = box_motion(GEOMETRY, np.array([[0.0, 0.0, 100.0]]), np.array([[100.0, 100.0, 100.0]]))
    assert np.isinf(motion.theta_change).all()


def test_cube_boxes_fill_the_cube() -> None:
    centres, halves = cube_boxes(LIMITS.centre_mm, LIMITS.half_side_mm, 4)
    assert (8.0 * halves.prod(axis=1)).sum() == pytest.approx((2 * LIMITS.half_side_mm) ** 3)
    assert (centres - halves).min(axis=0) == pytest.approx(LIMITS.corners_mm.min(axis=0))
    assert (centres + halves).max(axis=0) == pytest.approx(LIMITS.corners_mm.max(axis=0))


def test_domains_hold_all_angles_and_little_more() -> None:
    p = np.concatenate([LIMITS.corners_mm, LIMITS.centre_mm + RNG.uniform(-37.5, 37.5, (20000, 3))])
    theta, s, _ = chain_state(p)
    plane = plane_angle(s)
    lean = rod_lean(GEOMETRY, p / 1000.0)
    assert (theta >= DOMAINS.theta[:, 0]).all()
    assert (theta <= DOMAINS.theta[:, 1]).all()
    assert np.degrees(theta.min() - DOMAINS.theta.min()) < 5.0
    zero = np.zeros((len(p), 2))
    for i in CHAINS:
        for raster, x, y in (
            (DOMAINS.neighbours[i], theta[:, i], theta[:, (i + 1) % 3]),
            (DOMAINS.at_wrist[i], plane[:, i], lean[:, i]),
            (DOMAINS.at_elbow[i], plane[:, i] - theta[:, i], lean[:, i]),
        ):
            assert raster.touched(np.stack([x, y], axis=1), zero).all()


@pytest.mark.parametrize("kind", ["neighbours", "at_wrist", "at_elbow"])
def test_rasters_hold_little_more_than_what_occurs(kind: str) -> None:
    """Of pairs of angles that are 1.8 degrees off all that occurs none is held; by coarse boxes some up to 3.1."""
    axis = np.linspace(-1.0, 1.0, 61)
    p = LIMITS.centre_mm + LIMITS.half_side_mm * np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    motion = box_motion(GEOMETRY, p, np.zeros_like(p))
    theta, elbow, lean = motion.theta, motion.elbow_angle, motion.lean
    others = {
        "neighbours": (theta, np.roll(theta, -1, 1)),
        "at_wrist": (theta + elbow, lean),
        "at_elbow": (elbow, lean),
    }
    for i, raster in enumerate(getattr(DOMAINS, kind)):
        occur = np.stack([angles[:, i] for angles in others[kind]], axis=1)
        grid = np.stack(np.meshgrid(*np.linspace(raster.low, raster.high, 150).T), axis=-1).reshape(-1, 2)
        off = grid[KDTree(occur).query(grid)[0] > np.radians(1.8)]
        assert not raster.touched(off, np.zeros_like(off)).any()


def test_rasters_near_a_fold_are_made_of_no_more_boxes_than_are_held() -> None:
    """Without an end to halving 1.6 million, 2.4 GB."""
    g = DeltaGeometry(base_radius=0.05795, platform_radius=0.03384, upper_arm_length=0.14528, forearm_length=0.15517)
    centres, halves = joint_ranges(g, np.array([0.0, 0.0, 96.70]), 71.738).pairs()
    assert centres.shape == halves.shape
    assert BOXES_PER_EDGE**3 < centres.shape[1] <= BOXES_MOST


def test_ranges_of_arms_much_shorter_than_their_rods_are_not_wider_than_their_stops() -> None:
    """Over a coarse box near such a fold the bound was 3.2 degrees beyond all that occurs, where a stop pin stands."""
    g = DeltaGeometry(base_radius=0.0529, platform_radius=0.02381, upper_arm_length=0.063194, forearm_length=0.3988)
    centre, half = np.array([0.0, 0.0, 426.476]), 29.976
    found = joint_ranges(g, centre, half).theta
    axis = np.linspace(-half, half, 41)
    occur = inverse_kinematics(g, (centre + np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)) / 1000.0)
    low, high = occur.min(axis=0), occur.max(axis=0)
    assert ((low - np.radians(1.5) < found[:, 0]) & (found[:, 0] <= low)).all()
    assert ((high <= found[:, 1]) & (found[:, 1] < high + np.radians(1.5))).all()


def test_raster_says_no_only_outside() -> None:
    raster = Raster.of_boxes(np.array([[0.0, 0.0], [10.0, 10.0]]), np.array([[1.0, 1.0], [1.0, 1.0]]))
    required = np.array([[0.5, 0.5], [5.0, 5.0], [9.5, 10.5], [0.0, 10.0], [20.0, 20.0]])
    assert raster.touched(required, np.full((5, 2), 0.1)).tolist() == [True, False, True, False, False]
    assert raster.touched(np.array([[5.0, 5.0]]), np.array([[4.5, 4.5]])).all()


def test_a_cube_with_a_fold_is_refused() -> None:
    with pytest.raises(FoldError, match=r"folds in the cube, or cannot be closed, as at \(.*\) mm"):
        joint_ranges(GEOMETRY, LIMITS.centre_mm, 80.0)


def test_a_cube_of_which_no_fold_can_be_excluded_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("delta_cad.checks.clearance.joint_ranges.BOXES_PER_EDGE", 1)
    monkeypatch.setattr("delta_cad.checks.clearance.joint_ranges.HALVINGS", 0)
    with pytest.raises(FoldError, match="may fold"):
        joint_ranges(GEOMETRY, LIMITS.centre_mm, 37.25)


@pytest.mark.quick(1)
@pytest.mark.parametrize("ratio", [9.5, 1.0])
def test_every_space_places_pairs_as_the_placement_does_and_bounds_their_travel(ratio: float) -> None:
    assembly = machine(ratio)
    pairs = clearance_pairs(assembly, LIMITS, MESHES)
    spaces = spaces_of(pairs, assembly.placement, DOMAINS, LIMITS, 0.0)
    names = [space.name for space in spaces]
    assert len(names) == (9 if ratio > 1.0 else 8)  # a direct drive leaves nothing fixed but the base
    kinds = [{frozenset(names) for names in space.pairs.names} for space in spaces]  # pieces of a body share its name
    assert sum(map(len, kinds)) < len(pairs)  # equal pairs of the chains are one
    by_names = {frozenset((p.a.name, p.b.name)): p for p in pairs}
    for space in spaces:
        kept = RNG.permutation(len(space.pairs.limit))[:10]
        for k in kept:
            a, b = space.pairs.bodies[space.pairs.first[k]], space.pairs.bodies[space.pairs.second[k]]
            pair = by_names[frozenset(space.pairs.names[k])]
            (check_round_pair if "round" in space.name else check_pair)(space, k, a, b, pair, assembly)


def check_round_pair(space, k, a, b, pair: ClearancePair, assembly) -> None:
    """A holder that is round is as far away at the one angle of its space as it is at any."""
    positions = LIMITS.centre_mm + RNG.uniform(-LIMITS.half_side_mm, LIMITS.half_side_mm, (20, 3))
    originals = {pair.a.name: pair.a, pair.b.name: pair.b}
    holder, rod = (originals[name] for name in space.pairs.names[k])
    variables = variables_of(space.name.removesuffix(", what is round"), positions, originals)
    (centre,), (half,) = space.root()
    assert half[0] == 0.0
    assert space.reachable(np.column_stack([np.full(20, centre[0]), variables[:, 1]]), np.zeros((20, 2))).all()
    frames = space.frames(np.column_stack([np.full(20, centre[0]), variables[:, 1]]))
    poses = frames[:, space.links.index(a.link)] @ a.placement, frames[:, space.links.index(b.link)] @ b.placement
    engine = DistanceEngine()
    reported = np.array([engine.distance(a, b, *both) for both in zip(*poses, strict=True)])
    relative = relative_pose(holder, rod, positions, assembly.placement)
    true = np.array([engine.distance(holder, b, np.eye(4), r) for r in relative])
    near = reported < space.pairs.limit[k]  # what is farther was left away
    strays = a.mesh.deviation_mm + holder.mesh.deviation_mm
    assert (reported <= true + 1e-6)[near].all()
    assert (reported >= true - strays - 0.003 * a.radius)[near].all()


def check_pair(space, k, a, b, pair: ClearancePair, assembly) -> None:
    """Relative pose and travel of one pair in its space, against the placement."""
    centres, halves = random_boxes(4)
    inside = centres + RNG.uniform(-1, 1, (6, 4, 3)) * halves
    positions = np.concatenate([centres, *inside])
    originals = {pair.a.name: pair.a, pair.b.name: pair.b}
    ordered = [originals[name] for name in space.pairs.names[k]]
    relative = relative_pose(*ordered, positions, assembly.placement).reshape(7, 4, 4, 4)
    variables = variables_of(space.name, positions, originals).reshape(7, 4, -1)
    frames = space.frames(variables[0])
    la, lb = space.links.index(a.link), space.links.index(b.link)
    own = np.linalg.inv(frames[:, la] @ a.placement) @ (frames[:, lb] @ b.placement)
    assert own == pytest.approx(relative[0], abs=1e-9), space.name

    width = np.abs(variables - variables[0]).max(axis=0)
    bound = np.min(
        [m[:, space.pairs.first[k]] + m[:, space.pairs.second[k]] for m in space.motion(variables[0], width)], 0
    )
    engine = DistanceEngine()
    start = [engine.distance(a, b, np.eye(4), r) for r in relative[0]]
    for r in relative[1:]:
        now = [engine.distance(a, b, np.eye(4), x) for x in r]
        assert (np.abs(np.subtract(now, start)) <= bound + 1e-6).all(), (space.name, a.name, b.name)


def relative_pose(a, b, p, placed) -> np.ndarray:
    """(n, 4, 4) part frame of b in part frame of a; swept pinions at angle 0, as bodies of revolution stand."""
    links = dict(placed(p))
    for name in swept_links(placed):
        links[name] = np.broadcast_to(fixed_frame(name, placed), links[name].shape)
    return np.linalg.inv(links[a.link] @ a.placement) @ (links[b.link] @ b.placement)


def variables_of(space: str, p: np.ndarray, bodies) -> np.ndarray:
    """(n, d) variables of a space at handle positions, computed here from forearm vectors."""
    theta, s, _ = chain_state(p)
    plane = plane_angle(s)
    lean = rod_lean(GEOMETRY, p / 1000.0)
    moving = [chain_of(b.link) for b in bodies.values() if b.link[0] in "ur"]
    i = moving[0] if moving else 0
    if space.startswith("fixed"):
        return np.zeros((len(p), 0))
    if space.startswith("an arm"):
        return theta[:, [i]]
    if space.startswith("two arms"):
        first = moving[0] if (moving[0] + 1) % 3 == moving[1] else moving[1]
        return theta[:, [first, (first + 1) % 3]]
    if space.startswith("the rods"):
        return lean[:, [i]]
    if space == "a rod and the platform":
        return np.stack([plane[:, i], lean[:, i]], axis=1)
    if space == "a rod and its arm":
        return np.stack([plane[:, i] - theta[:, i], lean[:, i]], axis=1)
    return p


def test_boxes_gap_never_exceeds_the_distance_and_finds_most_of_it() -> None:
    engine = DistanceEngine()
    sizes = [(2.0, 4.0, 6.0), (1.0, 10.0, 1.0), (5.0, 5.0, 0.5)]
    meshes = [tessellate(box((0, 0, 0), size), 0.1, 0.5) for size in sizes]
    found, exact = [], []
    for _ in range(400):
        k, m = RNG.integers(3, size=2)
        poses = []
        for _ in range(2):
            q, _r = np.linalg.qr(RNG.normal(size=(3, 3)))
            pose = at(*RNG.uniform(-6, 6, 3))
            pose[:3, :3] = q * np.sign(np.linalg.det(q))
            poses.append(pose)
        a, b = body("a", f"a{k}", "", meshes[k], poses[0]), body("b", f"b{m}", "", meshes[m], poses[1])
        gap = boxes_gap((b.centre - a.centre)[None], a.axes[None], a.half[None], b.axes[None], b.half[None])[0]
        found.append(gap)
        exact.append(engine.distance(a, b, a.placement, b.placement))
    found, exact = np.array(found), np.array(exact)
    assert (found <= exact + 1e-9).all()
    apart = exact > 0.1
    assert (found[apart] > 0.0).all()  # the separating axis theorem: a gap shows on one of the 15 axes
    assert np.median(found[apart] / exact[apart]) > 0.9


def test_revolved_body_holds_the_part_at_every_angle() -> None:
    stepped = tessellate(rod(5, (0, 0, 0), (0, 4, 0)).fuse(rod(2, (1, 4, 0), (1, 9, 0))).Solids()[0], 0.05, 0.3)
    offset = at(1.5, 0.0, -0.5)
    swept = revolved_about_y(stepped, offset)
    assert swept.is_watertight
    points = stepped.vertices @ offset[:3, :3].T + offset[:3, 3]
    radius = np.hypot(points[:, 0], points[:, 2])
    largest = [radius[points[:, 1] <= 4.0].max(), radius[points[:, 1] > 4.0].max()]
    exact = np.pi * (largest[0] ** 2 * 4.0 + largest[1] ** 2 * 5.0)
    assert exact < swept.volume_mm3 < 1.01 * exact
    for angle in RNG.uniform(0, 2 * np.pi, 8):
        c, s = np.cos(angle), np.sin(angle)
        for x, y, z in points[RNG.integers(len(points), size=20)] * [1 - 1e-6, 1, 1 - 1e-6]:
            inside = np.array([c * x + s * z, np.clip(y, 1e-4, 9 - 1e-4), c * z - s * x])
            assert winding_number(swept, inside) > 0.5


def test_among_more_corners_than_slabs_edges_stay_where_they_are() -> None:
    """As on a pinion, whose helix has corners at every height beside the collar's two."""
    stepped = tessellate(rod(5, (0, 0, 0), (0, 4, 0)).fuse(rod(2, (0, 4, 0), (0, 9, 0))).Solids()[0], 0.05, 0.3)
    heights = RNG.uniform(0.1, 8.9, 300)
    within = np.stack([np.ones(300), heights, np.zeros(300)], axis=1)
    faces = len(stepped.vertices) + np.arange(300).reshape(100, 3)
    many = replace(
        stepped, vertices=np.concatenate([stepped.vertices, within]), faces=np.concatenate([stepped.faces, faces])
    )
    alone, among = (revolved_about_y(mesh, np.eye(4)).volume_mm3 for mesh in (stepped, many))
    assert alone <= among < 1.001 * alone


def test_a_cone_is_swept_as_a_cone_and_a_shoulder_as_a_shoulder() -> None:
    """Frustum and cylinder, by their closed forms: 0.3 % for the circumscribed polygon, nothing for steps."""
    cone = cq.Solid.makeCone(5, 1, 10, dir=cq.Vector(0, 1, 0))
    solid = cone.fuse(cq.Solid.makeCylinder(3, 4, cq.Vector(0, 10, 0), cq.Vector(0, 1, 0))).Solids()[0]
    swept = revolved_about_y(tessellate(solid, 0.05, 0.3), np.eye(4))
    exact = np.pi * (10.0 * (25.0 + 5.0 + 1.0) / 3.0 + 9.0 * 4.0)
    assert exact < swept.volume_mm3 < 1.004 * exact
    assert swept.is_watertight


def test_box_levers_count_the_deviation() -> None:
    mesh = tessellate(ball(3), 0.3, 0.8)
    b = body("ball", "ball", "", mesh, at(10.0, 0.0, 0.0))
    assert b.lever(np.zeros(3)) >= 13.0
    assert b.lever_about_y() >= 13.0
    assert b.radius >= 3.0
    assert (b.half >= 3.0).all()


def test_bounds_for_all_angles_are_below_the_distance_at_any() -> None:
    pairs = clearance_pairs(MACHINE, LIMITS, MESHES)
    (swing,) = [s for s in spaces_of(pairs, MACHINE.placement, DOMAINS, LIMITS, 0.0) if s.name.startswith("an arm")]
    engine = DistanceEngine()
    always = swing.always_apart()
    assert (always > 1.0).any()
    (low, high) = (swing.root()[0] - swing.root()[1], swing.root()[0] + swing.root()[1])
    for theta in np.linspace(low, high, 4):
        frames = swing.frames(theta)[0]
        for k in np.flatnonzero(always > 0.0)[:80]:
            a, b = swing.pairs.bodies[swing.pairs.first[k]], swing.pairs.bodies[swing.pairs.second[k]]
            poses = [frames[swing.links.index(x.link)] @ x.placement for x in (a, b)]
            assert engine.distance(a, b, *poses) >= always[k]
