"""What passes what in closed form comes as near as the exact solids do, and a search finds where."""

from __future__ import annotations

from math import radians

import cadquery as cq
import numpy as np
import pytest
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_State

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.builder import at
from delta_cad.design import Design
from delta_cad.dimensions import dimensions, link_placement
from delta_cad.dimensions.capstan import SLEEVE_OVER_MM, sleeve_frames
from delta_cad.dimensions.platform import BOSS_BEVEL_MM, STEM_FLATS_MM
from delta_cad.interference.ferrule_insertion import ferrule_clearance_mm, second_way_rad
from delta_cad.interference.moving_bodies import COUNT, arm_shapes, nearest, sector_clearance, sector_points
from delta_cad.interference.platform import platform_points, platform_shapes
from delta_cad.interference.reasons import boss_clearance_mm, drive_clearances
from delta_cad.interference.shapes import (
    TOGETHER,
    Bar,
    Block,
    Placed,
    Prism,
    Ring,
    Round,
    Shape,
    Windowed,
    collides,
    least_distance,
    union_distance,
)
from delta_cad.interference.static_obstacles import board, cheeks, foot, key_swing_rad, motor
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.bought_parts import make_joint_ball
from delta_cad.solids.capstan import make_cable_end, make_crimp_sleeve
from delta_cad.solids.forearm import make_cross_bar, make_rod_cup
from delta_cad.solids.platform import make_handle_stem, make_platform
from delta_cad.solids.upper_arm import make_upper_arm
from delta_cad.structure.beam_model import beam_model
from tests.delta_cad.interference.machines import machine, of, synthesized
from tests.delta_cad.solids.measured import placed


@pytest.mark.parametrize("seed", range(20))
def test_the_least_distance_of_points_is_that_of_all_of_them(seed: int) -> None:
    """Inside, near, and so far off that a bound is told."""
    rng = np.random.default_rng(seed)
    hulls = [
        Prism(rng.uniform([-20, -20, 1], [20, 20, 9], (4, 3)), (-3.0, 5.0 + seed), rng.uniform(0.0, 1.0)) for _ in "ab"
    ]
    shapes: list[Shape] = [*hulls, Round(4.0, (0.0, 9.0), (30.0, 0.0)), Placed(np.eye(3)[[1, 2, 0]], hulls[0])]
    far = rng.uniform(0.0, 80.0)
    points = rng.normal(0.0, 15.0, (7, 60, 3)) + np.array([far, 0.3 * far, -far])
    assert least_distance(shapes, points) == pytest.approx(float(union_distance(shapes, points).min()), abs=1e-12)
    assert least_distance(hulls, points[:1, :3]) == pytest.approx(float(union_distance(hulls, points[:1, :3]).min()))
    assert (hulls[0].lower_bound(points[0]) <= hulls[0].signed_distance(points[0]) + 1e-12).all()


def test_a_cables_end_round_its_nose_comes_as_near_to_the_platform_as_the_exact_solids_do() -> None:
    """In that corner of the cube where it is nearest: no other part of the sector is."""
    d, cube = dimensions(machine("plates")), machine("plates").cube
    assert d.capstan is not None
    corner = np.array([[-1.0, 1.0, 0.0]]) * cube.half_side_mm + [0.0, 0.0, cube.bottom_height_mm]
    apart, at = sector_clearance(d, d.capstan, "platform")(corner, False, None), link_placement(d)(corner)
    cable, platform = make_cable_end(d, 0).solid, make_platform(d).solid
    i = int(apart[0].argmin())
    exact = placed(cable, at[f"upper_arm_{i}"][0]).distance(placed(platform, at["platform"][0]))
    assert apart[0, i] == pytest.approx(exact, abs=0.1)


def test_ends_of_rods_come_as_near_to_the_arms_boss_as_the_exact_solids_do() -> None:
    """Leaning as far as they do, and turned as far as their joints let them or not at all."""
    d, lean = dimensions(machine("turned")), radians(22.167)
    f, (low, high) = d.forearm, d.layers.elbow_boss_mm
    cup, arm = make_rod_cup(d).solid, make_upper_arm(d).solid
    free = np.arccos(np.cos(f.tilt_limit_rad) / np.cos(lean))
    found = []
    for turn in np.linspace(-free, free, 9):
        one = cup.rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), float(np.degrees(turn)))
        one = one.rotate(cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), float(-np.degrees(lean)))
        found.append(arm.distance(one.translate(cq.Vector(d.arm.length_mm, f.width_mm / 2, 0.0))))
    assert boss_clearance_mm(f, d.arm.boss_radius_mm, high - low, lean) == pytest.approx(min(found), abs=0.05)


def test_springs_that_fold_come_near_the_encoders_cheek() -> None:
    """The capstan's own arm alone leaves them more room."""
    d = dimensions(machine("folded_cheeks"))
    cheek, arm = (nearest(one, d.design.workspace, 3) for one in drive_clearances(d))
    assert cheek < 1.5 < 2.0 < arm


def test_the_nearest_position_is_found_though_it_is_not_of_the_grids_nearest_pair() -> None:
    d = dimensions(machine("springs_below"))
    assert d.capstan is not None
    apart = sector_clearance(d, d.capstan, "spring")
    there = float(apart(np.array([[-42.58, -41.677, 74.514]]), False, None).min())
    assert nearest(apart, d.design.workspace, COUNT) < there + 0.05


def test_a_key_swings_over_the_base_plates_hole_and_not_behind_its_own_sector() -> None:
    """By a sixth of a turn and more, and by less."""
    assert key_swing_rad(dimensions(machine("keyed"))) > radians(60.0)
    assert key_swing_rad(dimensions(machine("covered"))) < radians(60.0)


def test_a_window_lets_through_what_is_off_its_edges() -> None:
    whole, window = Prism([(0.0, 0.0, 10.0)], (0.0, 3.0)), Prism([(0.0, 0.0, 6.0)], (0.0, 3.0))
    plate = Windowed(whole, window)
    points = np.array([[0.0, 1.0, 0.0], [4.0, 7.0, 0.0], [8.0, 1.0, 0.0], [0.0, 1.0, 13.0]])
    assert plate.signed_distance(points) == pytest.approx([6.0, np.hypot(2.0, 4.0), -1.0, 3.0], abs=0.02)


def test_bars_and_placed_shapes_are_where_they_are_put() -> None:
    bar = Bar(2.0, 10.0, np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 1.0]))
    assert bar.signed_distance(np.array([[6.0, 2.0, 8.0], [1.0, 2.0, 17.0]])) == pytest.approx([3.0, 4.0])
    upright = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]])
    disc = Placed(upright, Round(2.0, (0.0, 1.0)), (5.0, 0.0, 0.0))
    assert disc.signed_distance(np.array([[5.0, 6.0, 0.5], [5.0, 0.0, 4.0]])) == pytest.approx([4.0, 3.0])


@pytest.mark.parametrize("half", [0.4, 1.5, 2.6])
def test_a_rings_segment_is_as_far_off_as_its_nearest_point(half: float) -> None:
    """Brute force: points of a segment of the ring, in its plane, every 0.05 mm and 0.002 rad."""
    ring = Ring((15.0, 18.0), (0.7 - half, 0.7 + half), (0.0, 3.0))
    radius, angle = np.meshgrid(np.linspace(15.0, 18.0, 61), np.arange(0.7 - half, 0.7 + half, 0.002))
    solid = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=2).reshape(-1, 2)
    flat = np.random.default_rng(5).uniform(-25.0, 25.0, (200, 2))
    found = ring.signed_distance(np.stack([flat[:, 0], np.full(200, 1.5), flat[:, 1]], axis=1))
    nearest_mm = np.array([np.linalg.norm(solid - one, axis=1).min() for one in flat])
    assert np.maximum(found, 0.0) == pytest.approx(np.where(nearest_mm < 0.06, 0.0, nearest_mm), abs=0.06)


@pytest.mark.parametrize("count", [1, TOGETHER - 1, TOGETHER, 5 * TOGETHER + 3])
def test_rows_of_balls_meet_what_one_of_their_balls_meets(count: int) -> None:
    """Rows of 60 mm among shapes about the origin, each point by itself."""
    shapes: list[Shape] = [
        Prism([(0.0, 0.0, 10.0), (20.0, 5.0, 3.0)], (-2.0, 3.0), 0.5),
        Ring((15.0, 18.0), (0.3, 2.0), (4.0, 9.0)),
        Block(np.eye(3), (0.0, 12.0, -20.0), (-3.0, -3.0, -3.0), (4.0, 4.0, 4.0)),
        Bar(2.0, 30.0, np.array([-10.0, 0.0, 5.0]), np.array([0.6, 0.8, 0.0])),
    ]
    rng = np.random.default_rng(4)
    start, way = rng.uniform(-25.0, 25.0, (400, 2, 3)), rng.normal(size=(400, 2, 3))
    way *= 60.0 / np.linalg.norm(way, axis=2, keepdims=True)
    rows = start[:, :, None] + np.linspace(0.0, 1.0, count)[:, None] * way[:, :, None]
    one_by_one = (union_distance(shapes, rows) <= 1.7).any(axis=2)
    assert 0.02 < one_by_one.mean() < 0.9
    assert (collides(shapes, rows, 1.7) == one_by_one).all()


def test_bevels_take_corners_off() -> None:
    sharp, broken = (Prism([(0.0, 0.0, 10.0)], (0.0, 3.0), bevel) for bevel in (0.0, 0.5))
    points = np.array([[10.0, 3.0, 0.0], [12.0, 1.0, 0.0]])
    assert broken.signed_distance(points) - sharp.signed_distance(points) == pytest.approx(
        [0.5 / np.sqrt(2.0), 0.0], abs=0.01
    )


@pytest.mark.parametrize("path", ["examples/synthesized.json", "docs/gallery/desk-150.json"])
def test_no_slice_of_a_platforms_web_lies_across_its_windows_end(path: str) -> None:
    """A slice that did was counted whole where a wide window took three quarters of it."""
    d = dimensions(of(path))
    reach, slices = d.platform.window_reach_mm, beam_model(d).spoke.slices
    assert reach is not None
    ends = d.platform.radius_mm - np.cumsum([one.length_mm for one in slices][::-1])
    for end in reach[:2]:
        assert np.abs(ends - end).min() < 1e-6


BETWEEN_MM = 1.2  # what points of an edge, a few mm apart, see of it less than the kernel


def adjacent(solids: list[cq.Shape], count: int) -> np.ndarray:
    """(n, 3) points up to 4 mm off the surfaces of solids, as many of each."""
    rng, found = np.random.default_rng(1), []
    for solid in solids:
        vertices, triangles = solid.tessellate(0.05, 0.2)
        corners = np.array([one.toTuple() for one in vertices])[np.array(triangles)]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(normal, axis=1)
        some = rng.choice(len(area), count, p=area / area.sum())
        on = (rng.dirichlet((1.0, 1.0, 1.0), count)[:, :, None] * corners[some]).sum(axis=1)
        found.append(on + normal[some] / area[some][:, None] * rng.uniform(0.3, 4.0, (count, 1)))
    return np.concatenate(found)


def off_solids(solids: list[cq.Shape], points: np.ndarray) -> np.ndarray:
    """(n) how far points are off the nearest of several solids, by the kernel, which takes them apart once."""
    apart, inside = BRepExtrema_DistShapeShape(), [BRepClass3d_SolidClassifier(one.wrapped) for one in solids]
    apart.LoadS1(cq.Compound.makeCompound(solids).wrapped)
    found = []
    for spot in points:
        apart.LoadS2(cq.Vertex.makeVertex(*spot).wrapped)
        assert apart.Perform()
        for one in inside:
            one.Perform(gp_Pnt(*spot), 1e-7)
        found.append(0.0 if any(one.State() == TopAbs_State.TopAbs_IN for one in inside) else apart.Value())
    return np.array(found)


@pytest.mark.parametrize("name", ["plates", "wrists", "synthesized"])
def test_shapes_and_balls_of_a_platform_are_where_its_solids_are(name: str) -> None:
    """Of plate, windows, hub, bosses and stem, shapes; of bosses, cross-bars and their joints' balls, balls."""
    d = dimensions(machine(name))
    p, wide = d.platform, d.forearm.width_mm / 2
    wrists = [d.turn(i) @ at(p.radius_mm) for i in CHAINS]
    bars = [placed(make_cross_bar(d).solid, wrist) for wrist in wrists]
    balls = [placed(make_joint_ball(d).solid, wrist @ at(0.0, y)) for wrist in wrists for y in (-wide, wide)]
    fixed = [make_platform(d).solid, placed(make_handle_stem(d).solid, at(z=p.boss_diameter_mm / 2))]

    points = adjacent(fixed, 200)
    points = points[np.hypot(points[:, 0], points[:, 1]) > p.stem_diameter_mm / 2]  # in the stem's hole
    exact, suspended = off_solids([*fixed, *bars], points), off_solids(bars, points)
    seen = np.maximum(union_distance(platform_shapes(d), points), 0.0)
    assert (seen > exact - 0.05).all()  # as solids are tessellated
    flats = (p.stem_diameter_mm - STEM_FLATS_MM) / 2  # taken all the way round
    cut = np.where(points[:, 2] > p.boss_diameter_mm / 2, max(flats, BOSS_BEVEL_MM), BOSS_BEVEL_MM)
    stud = points[:, 2] > p.boss_diameter_mm / 2 + p.stem_length_mm - 4.0  # under the knob, left out
    assert (seen < exact + cut + 0.05)[(exact < suspended) & ~stud].all()
    assert (exact < suspended).mean() > 0.8

    centres, radii = platform_points(d)
    upright = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]])
    tips = (centres[:, None] + radii[:, None, None] * upright).reshape(-1, 3)
    assert off_solids([*fixed, *bars, *balls], tips).max() < 0.05
    half, boss = p.boss_length_mm / 2, p.boss_diameter_mm / 2
    rings = [(boss - 0.2, half + 1.0), (boss + 1.0, 0.7 * half), (boss + 1.0, 0.0)]  # beside a boss's end, and itself
    rings = rings if half > boss else rings[:1]  # a short one is seen by its ends' edges
    turns = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    around = np.array([(r * np.cos(t), sign * y, r * np.sin(t)) for r, y in rings for t in turns for sign in (-1, 1)])
    points = np.concatenate([around @ wrist[:3, :3].T + wrist[:3, 3] for wrist in wrists])
    near = (np.linalg.norm(points[:, None] - centres, axis=2) - radii).min(axis=1)
    assert (near < off_solids([*fixed, *bars, *balls], points) + BETWEEN_MM).all()


def test_shapes_of_a_drive_and_its_arm_are_where_its_solids_are() -> None:
    """Beside recesses and pockets, which hulls fill, and what is small: of nine points in ten the distance is known."""
    d = dimensions(of("best.json"))
    assert d.capstan is not None
    made, shoulder = assemble(d).occurrences, np.linalg.inv(d.stand(0))
    shoulder[0, 3] -= d.bracket.shoulder_u_mm

    def solids(*names: str) -> list[cq.Shape]:
        found = [one for one in made if one.name in names]
        assert len(found) == len(names)
        frames = [shoulder if one.link == "base" else np.eye(4) for one in found]
        return [placed(one.part.solid, frame @ one.placement) for one, frame in zip(found, frames, strict=True)]

    drive = ("motor_cheek_0", "encoder_cheek_0", "foot_block_0", "motor_0", "encoder_board_0")
    cable = ("capstan_cable_0_inner", "capstan_cable_0_inner_end", "capstan_cable_0_outer", "crimp_sleeve_0_0")
    for names, shapes, beyond in (  # a drive's edges are broken in its shapes, an arm's not
        (drive, [*cheeks(d), motor(d), *board(d), foot(d)], 0.01),
        (("upper_arm_0", "sector_0", "tension_carriage_0", *cable), arm_shapes(d, d.capstan), 0.1),
    ):
        points = adjacent(solids(*names), 60)
        if names is not drive:  # the elbow is left out
            points = points[points[:, 0] < d.arm.length_mm - d.arm.boss_radius_mm - 5.0]
        seen, exact = union_distance(shapes, points), off_solids(solids(*names), points)
        outside = seen > 0.0
        assert outside.mean() > 0.6
        assert np.quantile((seen - exact)[outside], 0.9) < 0.05
        assert np.quantile((exact - seen)[outside], 0.95) < beyond
        assert (~outside & (exact > 0.1)).mean() < 0.2
    parts = solids(*(one.name for one in made if one.link == "upper_arm_0"))
    assert np.quantile(off_solids(parts, sector_points(d, d.capstan)), 0.95) < 0.05


@pytest.mark.parametrize("design", [of("best.json"), synthesized()], ids=["first", "second"])
def test_sleeves_pass_the_arm_as_near_as_their_solids_do(design: Design) -> None:
    """The first comes along the shoulder's axis past the arm, the second over its carriage."""
    d = dimensions(design)
    assert d.capstan is not None
    arm, sleeve, (first, second) = make_upper_arm(d).solid, make_crimp_sleeve(d).solid, sleeve_frames(d.capstan)
    first[1, 3] = sum(d.layers.arm_mm) / 2
    second[1, 3] -= SLEEVE_OVER_MM
    way = second_way_rad(d, d.capstan)
    out = np.cos(way) * second[:3, 0] + np.sin(way) * second[:3, 2]
    passed = [first]
    for far in np.linspace(0.0, 58.0, 30):
        passed.append(second.copy())
        passed[-1][:3, 3] += far * out
    exact = min(arm.distance(placed(sleeve, frame)) for frame in passed)
    assert (
        exact - 0.8 < ferrule_clearance_mm(d, d.capstan) < exact + 0.1
    )  # a sleeve is taken as round and as wide as it is
