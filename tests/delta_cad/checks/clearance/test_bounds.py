"""Bounds for all angles at once, pieces of bodies and gaps of hulls: never above what dense sampling finds."""

import tracemalloc

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, MeshLibrary, tessellate
from delta_cad.checks.clearance import configuration_spaces as spaces
from delta_cad.checks.clearance import pairing
from delta_cad.checks.clearance.bodies import CollisionBody, DistanceEngine, body
from delta_cad.checks.clearance.branch_and_bound import BoxBounds, prove
from delta_cad.checks.clearance.configuration_spaces import ConfigurationSpace, Pairs
from delta_cad.checks.clearance.half_plane import HalfPlaneProfile, profile_gap, rectangles_gap
from delta_cad.checks.clearance.joint_ranges import joint_ranges
from delta_cad.checks.clearance.pairing import clearance_pairs, spaces_of
from delta_cad.checks.clearance.segments import above, cells_of, cut, near, segments_of
from delta_cad.solids.part import Occurrence
from tests.delta_cad.checks.machines import GEOMETRY, L_B, LIMITS, at, ball, box, machine, part, rod

MACHINE = machine()
MESHES = MeshLibrary(MACHINE.parts, 0.2, 0.6)
DOMAINS = joint_ranges(GEOMETRY, LIMITS.centre_mm, LIMITS.half_side_mm)
RNG = np.random.default_rng(11)


def turned_about_y(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, 0], [0, 0, 0, 1.0]])


def random_frame(spread: float) -> np.ndarray:
    q, _r = np.linalg.qr(RNG.normal(size=(3, 3)))
    frame = at(*RNG.uniform(-spread, spread, 3))
    frame[:3, :3] = q * np.sign(np.linalg.det(q))
    return frame


def space_named(start: str) -> ConfigurationSpace:
    pairs = clearance_pairs(MACHINE, LIMITS, MESHES)
    (found,) = [s for s in spaces_of(pairs, MACHINE.placement, DOMAINS, LIMITS, 0.0) if s.name.startswith(start)]
    return found


def test_profiles_are_never_farther_apart_than_the_bodies_at_any_angle() -> None:
    shapes = [
        box((0, 0, 0), (9, 3, 2)),
        rod(3, (5, 0, 0), (5, 8, 1)),
        ball(4, (1, 1, 0)),
        rod(2, (0, 0, 0), (12, 0, 0)),
    ]
    meshes = [tessellate(shape, 0.1, 0.5) for shape in shapes]
    engine, tightest = DistanceEngine(), 0.0
    for _ in range(60):
        i, j = RNG.integers(len(meshes), size=2)
        one, other = random_frame(3.0), random_frame(25.0)
        gap = profile_gap(HalfPlaneProfile(meshes[i], one), HalfPlaneProfile(meshes[j], other))
        a, b = body("a", f"a{i}", "", meshes[i], one), body("b", f"b{j}", "", meshes[j], other)
        found = [engine.distance(a, b, one, turned_about_y(t) @ other) for t in np.linspace(0, 2 * np.pi, 73)]
        assert gap <= min(found) + 1e-9
        if gap > 0.0:
            tightest = max(tightest, gap / min(found))
    assert tightest > 0.8


def test_profiles_of_discs_and_rings_are_exact() -> None:
    """Side by side, one around the other, and at a corner: gaps that a turn does not change."""
    disc = tessellate(rod(10, (0, 0, 0), (0, 5, 0)), 0.01, 0.1)
    for shape, exact in (
        (rod(8, (0, 7, 0), (0, 9, 0)), 2.0),
        (rod(20, (0, 0, 0), (0, 5, 0)).cut(rod(13, (0, -1, 0), (0, 6, 0))), 3.0),
        (rod(20, (0, 9, 0), (0, 12, 0)).cut(rod(13, (0, 8, 0), (0, 13, 0))), 5.0),
    ):
        other = tessellate(shape.Solids()[0], 0.01, 0.1)
        for angle in (0.0, 0.3):
            gap = profile_gap(HalfPlaneProfile(disc, np.eye(4)), HalfPlaneProfile(other, turned_about_y(angle)))
            assert gap == pytest.approx(exact, abs=disc.deviation_mm + other.deviation_mm)


def test_a_triangle_around_the_axis_reaches_it() -> None:
    around = Mesh(np.array([[5.0, 0, -4], [-5, 0, -4], [0, 0, 6]]), np.array([[0, 1, 2]]), 0.0)
    assert HalfPlaneProfile(around, np.eye(4)).rectangles[0, 0] == 0.0
    adjacent = Mesh(around.vertices + np.array([20.0, 0, 0]), around.faces, 0.0)
    low = HalfPlaneProfile(adjacent, np.eye(4)).rectangles[0, 0]
    u = RNG.dirichlet(np.ones(3), 20000) @ adjacent.vertices
    assert low <= np.hypot(u[:, 0], u[:, 2]).min() <= low + 0.2


def test_rectangles_gap() -> None:
    a = np.array([0.0, 2.0, 0.0, 2.0])
    others = np.array([[5.0, 6, 0, 1], [1, 3, 6, 7], [5, 6, 6, 7], [1, 3, 1, 3], [-4, -1, 0, 1]])
    assert rectangles_gap(a, others) == pytest.approx([3, 4, 5, 0, 1])


def test_bounds_for_all_angles_of_two_arms_are_below_the_distance_at_any() -> None:
    arms = space_named("two arms")
    engine = DistanceEngine()
    always = arms.always_apart()
    assert (always > 1.0).any()
    assert (always < 0.0).any()  # the arms themselves sweep through one another
    centre, half = arms.root()
    frames = arms.frames(centre + RNG.uniform(-1, 1, (8, 2)) * half)
    for k in np.flatnonzero(always > 0.0):
        a, b = arms.pairs.bodies[arms.pairs.first[k]], arms.pairs.bodies[arms.pairs.second[k]]
        for one, other in frames:
            assert engine.distance(a, b, one @ a.placement, other @ b.placement) >= always[k]


def test_pieces_of_equal_bodies_are_made_once_and_stand_where_each_body_does() -> None:
    mesh, required = tessellate(box((0, 0, 0), (20, 6, 2)), 0.1, 0.5), list[str]()
    where = {
        "rod_0_0": np.eye(4),
        "rod_0_1": at(5, 0, 0),
        "rod_1_0": np.eye(4),
        "upper_arm_0": np.eye(4),
        "base": at(0, 9, 0),
    }
    bodies = [body(f"on {link}", "bar", link, mesh, frame) for link, frame in where.items()]
    pairs = Pairs(bodies, np.arange(4), np.full(4, 4), np.ones(4), [(b.name, "on base") for b in bodies[:4]])

    def halves(b: CollisionBody) -> list[CollisionBody]:
        required.append(b.link)
        return cells_of(b, 1)

    made = pairs.cut(halves, lambda a, _: a.link != "rod_1_0")
    assert len(made.limit) == 3 * 4 + 1
    for b in made.bodies:
        np.testing.assert_array_equal(b.placement, where[b.link])
        assert b.name == f"on {b.link}"
    assert required == ["rod_0_0", "base", "rod_0_1", "upper_arm_0"]
    required.clear()
    pairs.cut(halves)
    assert required == ["rod_0_0", "base", "rod_0_1", "upper_arm_0"]  # that of rod_1_0 is equal to that of rod_0_0


def test_two_arms_in_pieces_are_the_pairs_that_were_required(monkeypatch: pytest.MonkeyPatch) -> None:
    arms = space_named("two arms")
    engine, left = DistanceEngine(), ~(arms.always_apart() >= arms.pairs.limit)
    pieces = arms.in_pieces(left)
    assert {b.name for b in pieces.pairs.bodies} <= {b.name for b in arms.pairs.bodies}
    assert set(pieces.pairs.names) == {arms.pairs.names[k] for k in np.flatnonzero(left).tolist()}
    assert len(pieces.pairs.limit) > 4 * left.sum()
    centre, half = arms.root()
    for one, other in arms.frames(centre + RNG.uniform(-1, 1, (3, 2)) * half):

        def least(space: ConfigurationSpace, names: tuple[str, str], one: np.ndarray, other: np.ndarray) -> float:
            p = space.pairs
            held = [(p.bodies[p.first[k]], p.bodies[p.second[k]]) for k, of in enumerate(p.names) if of == names]
            return min(engine.distance(a, b, one @ a.placement, other @ b.placement) for a, b in held)

        for k in np.flatnonzero(left)[::7].tolist():
            names = arms.pairs.names[k]
            assert least(pieces, names, one, other) == pytest.approx(least(arms, names, one, other), abs=1e-9)
    in_pieces = prove(arms, DistanceEngine(), 3000)
    monkeypatch.setattr(spaces.TwoSwings, "in_pieces", lambda space, _: space)
    whole = prove(arms, DistanceEngine(), 3000)
    assert {names for names, _ in in_pieces.undecided} == {names for names, _ in whole.undecided}
    assert in_pieces.boxes <= whole.boxes


def test_arms_of_which_every_pair_is_apart_at_all_angles_need_no_box() -> None:
    """Of a large machine: none is left to be cut in pieces."""
    arms = space_named("two arms")
    apart = arms.always_apart() >= arms.pairs.limit + 1.0
    assert apart.any()
    given = arms._radius, arms._rasters, arms._stands[1]
    proof = prove(spaces.TwoSwings(arms.name, arms.pairs.chosen(apart), *given), DistanceEngine())
    assert (proof.undecided, proof.boxes, proof.calls) == ([], 0, 0)


def test_what_lies_inside_a_swept_body_is_not_called_apart() -> None:
    """A ball on its own shoulder axis, in the path of a bar that turns: the swept disc holds it, surfaces far apart."""
    bar = part("bar", box((-130, -6, -3), (130, 6, 3)))
    arm, on_axis = MACHINE.placement, 40.0 * np.sqrt(3.0)  # where the other shoulder axis meets the bar's plane
    occurrences = (
        Occurrence("bar", bar, "upper_arm_0", np.eye(4)),
        Occurrence("core", part("core", ball(2)), "upper_arm_1", at(0, on_axis, 0)),
    )
    a = Assembly("test", occurrences, (), (), arm, LIMITS.centre_mm)
    pairs = clearance_pairs(a, LIMITS, MeshLibrary(a.parts, 0.1, 0.5))
    (arms,) = spaces_of(pairs, arm, DOMAINS, LIMITS, 0.0)
    assert (arms.always_apart() < 0.0).all()


def test_clipped_triangles_fill_the_half_space() -> None:
    triangles = RNG.uniform(-5, 5, (300, 3, 3))
    triangles[:20, 0, 0] = 1.0  # corners in the plane
    triangles[20:30, :, 0] = 1.0  # whole triangles in the plane
    normal = np.array([1.0, 0.0, 0.0])
    upper, lower = above(triangles, normal, 1.0), above(triangles, -normal, -1.0)
    assert upper[..., 0].min() >= 1.0 - 1e-12
    assert lower[..., 0].max() <= 1.0 + 1e-12

    def area(t: np.ndarray) -> float:
        return float(np.linalg.norm(np.cross(t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]), axis=1).sum() / 2)

    in_plane = area(triangles[20:30])  # counted on both sides
    assert area(upper) + area(lower) == pytest.approx(area(triangles) + in_plane, rel=1e-12)


def test_pieces_are_the_whole_surface_and_their_levers_are_near_their_distances() -> None:
    mesh = tessellate(rod(2.5, (12, 0, 0), (100, 0, 0)), 0.05, 0.3)
    frame = at(L_B, 0, 0) @ np.diag([-1.0, -1.0, 1.0, 1.0])
    tube = body("tube", "tube", "rod_0", mesh, frame)
    pieces = segments_of(tube, 0.0)
    assert len(pieces) > 4
    assert sum(p.mesh.area_mm2 for p in pieces) == pytest.approx(mesh.area_mm2, rel=1e-9)
    for p in pieces:
        assert p.lever(np.zeros(3)) < 1.6 * (p.vertices[:, 0].min() + 2.5)
    engine = DistanceEngine()
    other = body("box", "box", "", tessellate(box((0, 0, 0), (3, 9, 2)), 0.1, 0.5), np.eye(4))
    for _ in range(40):
        pose = random_frame(60.0)
        whole = engine.distance(other, tube, pose, frame)
        assert min(engine.distance(other, p, pose, frame) for p in pieces) == pytest.approx(whole, abs=1e-9)


def test_short_bodies_are_not_cut() -> None:
    b = body("ball", "ball", "rod_0", tessellate(ball(3), 0.1, 0.5), np.eye(4))
    assert segments_of(b, 0.0) == [b]
    assert len(cut(b.mesh, np.eye(3)[0], np.array([-9.0, 9.0]))) == 1  # empty slabs are left out


def test_what_is_near_a_point_keeps_every_distance_within_reach() -> None:
    mesh = tessellate(box((0, 0, 0), (40, 30, 20)).cut(rod(5, (20, 15, -1), (20, 15, 21))).Solids()[0], 0.05, 0.3)
    frame = random_frame(30.0)
    b = body("block", "block", "", mesh, frame)
    engine = DistanceEngine()
    for n in range(60):
        point, reach = b.vertices[RNG.integers(len(mesh.vertices))] + RNG.uniform(-9, 9, 3), RNG.uniform(3, 15)
        local = near(b, point, reach, random_frame(1.0)[:3, :3] if n % 2 else None)
        probe = body("probe", f"probe {n}", "", tessellate(ball(0.5), 0.05, 0.3), at(*point))
        whole = engine.distance(probe, b, probe.placement, frame)
        if local is None:
            assert whole + 0.5 > reach
        elif whole + 0.5 <= reach:
            assert engine.distance(probe, local, probe.placement, frame) == pytest.approx(whole, abs=1e-9)
    assert near(b, b.centre, 100.0) is b
    assert near(b, b.centre + 200.0, 3.0) is None
    assert near(b, frame[:3, :3] @ [20, 15, 10] + frame[:3, 3], 2.0) is None  # in the bore


def test_cells_are_the_same_surface_and_leave_a_hollow_free() -> None:
    ring = rod(8, (0, 0, 0), (0, 6, 0)).cut(rod(6, (0, -1, 0), (0, 7, 0))).Solids()[0]
    whole = body("ring", "ring", "rod", tessellate(ring, 0.05, 0.3), random_frame(9.0))
    cells = cells_of(whole, 4)
    assert len({c.key for c in cells}) == 16
    assert sum(c.mesh.area_mm2 for c in cells) == pytest.approx(whole.mesh.area_mm2, rel=1e-9)
    hulls = [ConvexHull(b.hull).volume for b in (whole, *cells)]
    assert sum(hulls[1:]) < 0.7 * hulls[0]  # the ring's own share of the full cylinder is 0.44
    engine = DistanceEngine()
    inside = body("probe", "probe", "", tessellate(ball(1), 0.05, 0.3), whole.placement @ at(1.0, 3.0, -1.5))
    apart = [engine.distance(inside, c, inside.placement, c.placement) for c in (whole, *cells)]
    assert min(apart[1:]) == pytest.approx(apart[0], abs=1e-9)
    assert len(cells_of(whole, 0)) == 1


def test_a_flat_mesh_spans_a_hull_of_all_its_vertices() -> None:
    flat = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0.4, 0.3, 0]]), np.array([[0, 1, 2], [0, 1, 3]]), 0.0)
    assert len(flat.hull_points) == 4


def test_the_gap_of_hulls_is_never_above_the_distance_and_is_it_between_convex_bodies() -> None:
    shapes = [box((0, 0, 0), (4, 2, 9)), ball(3), box((0, 0, 0), (5, 5, 5)).cut(box((1, 1, 1), (4, 4, 6))).Solids()[0]]
    bodies = [body(f"{k}", f"{k}", "fixed", tessellate(s, 0.1, 0.5), random_frame(2.0)) for k, s in enumerate(shapes)]
    index = np.arange(3)
    pairs = Pairs(bodies, index[:1], index[1:2], np.ones(1), [("0", "1")])
    bounds = BoxBounds(spaces.Fixed("test", pairs, ("fixed",)))
    engine = DistanceEngine()
    for _ in range(200):
        i, j = RNG.integers(3, size=2)
        pose = random_frame(15.0)
        a, b = bodies[i], bodies[j]
        d, p, q = engine.closest_points(a, b, a.placement, pose @ b.placement)
        if d == 0.0:
            continue
        for normal, exact in ((q - p) / d, True), (random_frame(1.0)[0, :3], False):
            gap = bounds.hulls_gap(np.array([i]), np.array([j]), normal[None], np.eye(4)[None], pose[None])[0]
            assert gap <= d + 1e-9
            if exact and i == j == 0:  # boxes are convex; the meshes of balls not quite
                assert gap == pytest.approx(d, abs=1e-6)


def test_the_gaps_of_many_boxes_take_little_memory_and_are_those_of_each() -> None:
    bodies = [body(f"{k}", f"{k}", "fixed", tessellate(ball(3), 0.005, 0.1), at(9.0 * k, 0, 0)) for k in range(2)]
    pairs = Pairs(bodies, np.zeros(1, int), np.ones(1, int), np.ones(1), [("0", "1")])
    bounds, many = BoxBounds(spaces.Fixed("test", pairs, ("fixed",))), 20_000
    corners = len(bounds.hull(0))
    normal = RNG.normal(size=(many, 3))
    frames = np.tile(np.eye(4), (many, 1, 1))
    one, other = np.zeros(many, int), np.ones(many, int)
    tracemalloc.start()
    try:
        gaps = bounds.hulls_gap(one, other, normal, frames, frames, lambda _k, of, *_: np.zeros((len(of), corners)))
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert many * corners * 8 > 4 * peak  # else one array of all corners would do
    some = slice(0, many, 997)
    each = [
        bounds.hulls_gap(one[k], other[k], normal[k], frames[k], frames[k])
        for k in np.split(np.arange(many), many)[some]
    ]
    assert gaps[some] == pytest.approx(np.concatenate(each), abs=1e-12)


def test_a_halved_bound_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    """A reach of half the lever leaves away what the rod can hit, and the machine below is then wrongly proven."""
    tube = part("tube", rod(2.5, (12, 0, 0), (100, 0, 0)))
    post = part("post", ball(3))
    links = MACHINE.placement(LIMITS.centre_mm)
    middle = links["rod_0_1"] @ np.array([L_B - 40.0, 0, 0, 1])
    end = (np.linalg.inv(links["platform"]) @ middle)[:3]
    a = Assembly(
        "test",
        (Occurrence("tube", tube, "rod_0_1", np.eye(4)), Occurrence("post", post, "platform", at(*end))),
        (),
        (),
        MACHINE.placement,
        LIMITS.centre_mm,
    )
    meshes = MeshLibrary(a.parts, 0.1, 0.5)

    def undecided() -> bool:
        (wrist,) = spaces_of(clearance_pairs(a, LIMITS, meshes), a.placement, DOMAINS, LIMITS, 0.0)
        return bool(prove(wrist, DistanceEngine()).undecided)

    assert undecided()
    monkeypatch.setattr(pairing, "near", lambda b, point, reach, axes: near(b, point, reach / 2.0, axes))
    assert not undecided()
