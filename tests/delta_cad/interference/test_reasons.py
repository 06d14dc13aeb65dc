"""Interference of neighbouring chains is refused before a solid is made: the smallest machines that solids refused."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from delta_cad.assembly.drive import over_carriage
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, Reason, dimensions, link_placement
from delta_cad.dimensions.capstan import SLEEVE_OVER_MM, carriage_frame
from delta_cad.interference import reasons
from delta_cad.interference.ferrule_insertion import ferrule_clearance_mm
from delta_cad.interference.moving_bodies import DistanceField, cup_margin, nearest, sector_clearance
from delta_cad.interference.reasons import INTERFERENCE_FORMS, drive_clearances, fold_interference
from delta_cad.interference.shapes import Beam, Block, Prism, Ring, Round, union_distance
from delta_cad.interference.static_obstacles import key_swing_rad, pinion_clearance_mm, slide_in_clearance_mm
from delta_cad.mechanism import elbow_positions, inverse_kinematics
from delta_cad.mechanism.errors import UnreachableError
from delta_cad.mechanism.placement import spring_sway
from delta_cad.mechanism.workspace import Cube
from delta_cad.solids.capstan import make_sector
from delta_cad.solids.platform import make_platform
from delta_cad.structure.hardware.refusals import refusals
from delta_cad.structure.loads import sampled_mm
from tests.delta_cad.interference.machines import CHANGES, machine, of, synthesized
from tests.delta_cad.solids.measured import placed

WIDE = {"mechanism__base_radius_mm": 40.0, "mechanism__platform_radius_mm": 33.0}
REFUSED = {one["why"]: name for name, one in CHANGES.items() if "refused" in one}


def spread(d: Dimensions, more_mm: float) -> Dimensions:
    """A machine whose chains stand farther out, at base and platform alike: no angle changes."""
    m = d.design.mechanism
    radii = {name: getattr(m, name) + more_mm for name in ("base_radius_mm", "platform_radius_mm")}
    return dimensions(d.design.model_copy(update={"mechanism": m.model_copy(update=radii)}))


def named(reasons: tuple[Reason, ...] | list[Reason]) -> set[tuple[str, str]]:
    return {(one.part, one.feature) for one in reasons}


@pytest.mark.parametrize("what", REFUSED)
def test_what_meets_is_refused(what: str) -> None:
    name = REFUSED[what]
    assert {tuple(one) for one in CHANGES[name]["refused"]} <= named(refusals(machine(name)))


def test_rods_come_as_near_to_their_motor_as_lines_of_points_say() -> None:
    """Rods as points on the way from elbow to wrist, the motor as a cylinder, its cheek by a pad as thick as it is."""
    d = dimensions(machine("folded"))
    g, f, cube = machine("folded").geometry, d.forearm, machine("folded").cube
    (inside, face), pad = d.layers.motor_cheek_mm, d.bracket.motor_pad_radius_mm
    solids = (d.motor.diameter_mm / 2, face, face + d.motor.length_mm), (pad, inside, face)

    def apart(at: np.ndarray) -> float:
        p, found = at / MM_PER_M, np.inf
        elbows = elbow_positions(g, inverse_kinematics(g, p)) * MM_PER_M
        for i, elbow in enumerate(elbows):
            radial, tangential = g.radial[i], g.tangential[i]
            wrist = at + g.platform_radius * MM_PER_M * radial
            way = elbow + np.linspace(0.1, 0.9, 161)[:, None] * (wrist - elbow)
            off = np.hypot(way @ radial - g.base_radius * MM_PER_M, way[:, 2])
            for side in (-1.0, 1.0):
                y = way @ tangential + side * f.width_mm / 2
                for radius, low, high in solids:
                    adjacent = np.maximum(np.maximum(low - y, y - high), 0.0)
                    found = min(found, np.hypot(np.maximum(off - radius, 0.0), adjacent).min() - f.tube_outer_mm / 2)
        return found

    first = sampled_mm(d.design.workspace, 9)
    start = first[np.argmin([apart(p) for p in first])]
    step = np.linspace(-0.25, 0.25, 17) * cube.half_side_mm
    around = start + np.stack(np.meshgrid(step, step, 0.0), axis=-1).reshape(-1, 3)
    found = min(apart(p) for p in around)
    near = nearest(drive_clearances(d)[0], d.design.workspace, 3)
    assert near < 2.0
    assert near == pytest.approx(found, abs=0.1)
    (reason,) = fold_interference(d, 2.1)
    assert reason.field == "cube.bottom_height_mm"


def test_rods_too_short_to_be_unfolded_are_refused_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    """The height at which they are unfolded most is beyond their reach."""

    def within_reach(apart: DistanceField, cube: Cube, count: int) -> float:
        if cube.bottom_height > 0.09:
            raise UnreachableError("too high")
        return nearest(apart, cube, count)

    monkeypatch.setattr(reasons, "nearest", within_reach)
    (reason,) = fold_interference(dimensions(machine("folded_springs")), 2.1)
    assert reason.key == ("rod_tube", "beside the drive")


def test_committed_machines_pass() -> None:
    for path in ("best.json", "docs/gallery/pocket-40.json", "docs/gallery/direct-83.json"):
        found = dimensions(of(path))
        assert [reason for form in INTERFERENCE_FORMS.values() for reason in form(found, 0.0)] == []


def test_a_thicker_platforms_springs_hang_farther_from_it() -> None:
    """Along the rod at no lean: boss, coil, what is asked, and what the spring strays."""
    d = dimensions(synthesized(**WIDE, hardware__platform_thickness_mm=30.0))
    f = d.forearm
    sway = spring_sway(f.width_mm, f.eye_y_mm, f.eye_z_mm, f.tilt_limit_rad)
    off = np.hypot(f.length_mm - f.eyes_x_mm[1], f.eye_z_mm) - 15.0
    assert off - (f.spring.mean_diameter_mm + f.spring.wire_mm) / 2 - sway.across_mm >= 2.0
    assert f.eyes_x_mm[0] + f.eyes_x_mm[1] == pytest.approx(f.length_mm)


@pytest.mark.parametrize("path", ["examples/synthesized.json", "docs/gallery/direct-83.json"])
def test_a_clearance_that_no_lengths_keep_is_refused(path: str) -> None:
    reasons = {one.field: one for one in refusals(of(path, requirements__clearance_min_mm=3.0))}
    assert "requirements.clearance_min_mm" in reasons
    assert ("assembly", "clearance") not in named(refusals(of(path, requirements__clearance_min_mm=2.4)))
    wanted = reasons.get("hardware.arm_thickness_mm")
    assert (wanted is not None) == ("direct" in path)
    if wanted is not None:  # by hand: a screw's head of 5.5 mm, and 3 mm, and 0.13 that meshes are off, to cheeks that
        assert wanted.message.endswith(f"{5.5 + 2 * (3.13 - 1.0):g}")  # stand 1 mm beside the arm


def test_rods_keep_of_what_they_hang_on_what_is_required() -> None:
    wide, usual = (dimensions(synthesized(**WIDE, requirements__clearance_min_mm=v)).forearm for v in (2.4, 1.0))
    assert (wide.room_mm, usual.room_mm) == (2.4, 2.0)
    assert wide.stand_off_mm > usual.stand_off_mm
    assert wide.eyes_x_mm[0] > usual.eyes_x_mm[0]


def test_sleeves_pass_an_arm_whose_sector_is_larger() -> None:
    small = dimensions(machine("sleeves"))
    large = dimensions(synthesized())
    assert small.capstan is not None
    assert large.capstan is not None
    assert ferrule_clearance_mm(small, small.capstan) < -0.5 < ferrule_clearance_mm(large, large.capstan)
    thick = replace(small, layers=replace(small.layers, arm_mm=(-3.0, small.capstan.end_y_mm[1] - 8.0)))
    assert ferrule_clearance_mm(thick, small.capstan) != ferrule_clearance_mm(small, small.capstan)


def test_wrists_come_as_near_to_sectors_as_the_exact_solids_do() -> None:
    """At the four positions of a grid where they are nearest: an edge's points lie 1.5 mm apart."""
    d = dimensions(machine("wrists"))
    assert d.capstan is not None
    positions = sampled_mm(machine("wrists").workspace, 5)
    apart, links = sector_clearance(d, d.capstan, "platform")(positions, False, None), link_placement(d)
    sector, platform = make_sector(d).solid, make_platform(d).solid
    for k in np.argsort(apart.min(axis=1))[:4]:
        placed_at, i = links(positions[k : k + 1]), int(apart[k].argmin())
        one = placed(sector, placed_at[f"upper_arm_{i}"][0])
        exact = one.distance(placed(platform, placed_at["platform"][0]))
        assert exact - 1e-6 <= max(apart[k, i], 0.0) <= exact + 0.1


def foot_met(d: Dimensions, along: np.ndarray) -> bool:
    """Whether a second sleeve's axis runs into the foot block on a straight way to beside its seat, at home."""
    assert d.capstan is not None
    c, b = d.capstan, d.bracket
    carriage = carriage_frame(c)
    start = carriage[:3, 3] - (SLEEVE_OVER_MM - 0.5) * carriage[:3, 1]
    x, y, z = (start - np.linspace(0.0, 60.0, 601)[:, None] * (carriage[:3, :3] @ along)).T
    turn = d.home_rad
    x, z = b.shoulder_u_mm + x * np.cos(turn) - z * np.sin(turn), x * np.sin(turn) + z * np.cos(turn)
    adjacent = (y > d.layers.encoder_cheek_mm[1]) & (y < d.layers.motor_cheek_mm[0])
    low, high = b.foot_u_mm
    return bool((adjacent & (x > low) & (x < high) & (z < b.base_top_mm + b.foot_height_mm)).any())


def test_a_sleeve_comes_next_to_the_foot_block_that_is_in_its_way() -> None:
    """Where short arms are nearly upright the carriage looks down at the foot."""
    outside = np.array([-1.0, 0.0, 0.0])
    for design, meets in ((machine("long_rods"), True), (synthesized(), False)):
        d = dimensions(design)
        assert d.capstan is not None
        along = np.array(over_carriage(d, d.capstan)[0].along)
        assert foot_met(d, outside) == meets == (along[2] < 0.0)
        assert not foot_met(d, along)
        assert np.linalg.norm(along) == pytest.approx(1.0)


def test_cups_part_by_what_they_lack() -> None:
    """Wrists that stand apart by so much more than a machine's lacks leave nothing lacking, at any position."""
    d = dimensions(machine("cups"))
    positions = sampled_mm(machine("cups").workspace, 3)
    lacking = -cup_margin(d, 2.14)(positions, False, None).min()
    assert lacking > 0.0
    wider = spread(d, lacking / np.sqrt(3.0))
    assert cup_margin(wider, 2.14)(positions, False, None).min() == pytest.approx(0.0, abs=1e-9)


def test_a_key_has_room_where_motors_stand_far_apart_and_none_between_them() -> None:
    d, far = dimensions(machine("motors")), spread(dimensions(machine("motors")), 30.0)
    assert key_swing_rad(d) < radians(60.0) <= key_swing_rad(far)
    assert d.capstan is not None
    assert far.capstan is not None
    assert slide_in_clearance_mm(d, d.capstan) < 0.0 < slide_in_clearance_mm(far, far.capstan)
    assert pinion_clearance_mm(d, d.capstan) < pinion_clearance_mm(far, far.capstan)


def test_links_are_where_the_assembly_has_them() -> None:
    d = dimensions(machine("cups"))
    assert link_placement(d).drive_ratio == 1.0
    assert link_placement(dimensions(machine("sleeves"))).drive_ratio == 3.0


GRID = np.stack(np.meshgrid(*[np.linspace(-14.0, 14.0, 29)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
HELD = np.array(
    [
        [18.0, 0.0, 14.0],
        [-15.0, 0.0, -4.0],
        [19.0, 3.0, 2.0],
        [-11.0, 8.0, 9.0],
        [2.0, -13.0, 1.0],
        [0.0, 6.0, -16.0],
        [12.0, 12.0, 12.0],
    ]
)


def ring(p: np.ndarray) -> np.ndarray:
    turn = np.arctan2(p[:, 2], p[:, 0])
    radius = np.hypot(p[:, 0], p[:, 2])
    return (radius >= 4.0) & (radius <= 9.0) & (turn >= -0.5) & (turn <= 2.0) & (np.abs(p[:, 1]) <= 3.0)


def beam(p: np.ndarray) -> np.ndarray:
    inside = np.zeros(len(p), dtype=bool)
    for share in np.linspace(0.0, 1.0, 201):
        inside |= np.hypot(p[:, 0] - 10.0 * share, p[:, 2]) <= 6.0 - 3.0 * share
    return inside & (np.abs(p[:, 1]) <= 3.0)


SHAPES = {
    "ring": (Ring((4.0, 9.0), (-0.5, 2.0), (-3.0, 3.0)), ring),
    "beam": (Beam(10.0, (6.0, 3.0), (-3.0, 3.0)), beam),
    "prism": (Prism([(0.0, 0.0, 6.0), (10.0, 0.0, 3.0)], (-3.0, 3.0)), beam),
    "round": (
        Round(6.0, (-3.0, 3.0), (2.0, 1.0)),
        lambda p: (np.hypot(p[:, 0] - 2.0, p[:, 2] - 1.0) <= 6.0) & (np.abs(p[:, 1]) <= 3.0),
    ),
    "block": (
        Block(np.eye(3), (1.0, 0.0, 0.0), (-2.0, -3.0, -4.0), (6.0, 3.0, 4.0)),
        lambda p: (p[:, 0] >= -1.0) & (p[:, 0] <= 7.0) & (np.abs(p[:, 1]) <= 3.0) & (np.abs(p[:, 2]) <= 4.0),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_point_is_as_far_off_as_the_nearest_grid_point_inside(name: str) -> None:
    """Half a cell's diagonal of 0.87 mm too far at most; only far off, beyond the largest balls, a bound is told."""
    shape, inside = SHAPES[name]
    there = GRID[inside(GRID)]
    nearest = np.linalg.norm(HELD[:, None] - there, axis=2).min(axis=1)
    off = union_distance([shape], HELD)
    near = off < 20.0
    assert (off <= nearest + 1e-9).all()
    assert (off[near] >= nearest[near] - 0.87).all()
    assert (union_distance([shape], there) <= 1e-9).all()
    assert (union_distance([shape], GRID[~inside(GRID)]) > -0.02).all()
