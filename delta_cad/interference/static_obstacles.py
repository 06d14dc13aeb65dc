"""Static obstacles of the adjacent drive: motor, pinion, sector, and keys in the screws of the motor."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product
from math import cos, pi, sin

import numpy as np

from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.bracket import CHEEK_EDGE_MM
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.layers import (
    CORNERS,
    KEYS_MM,
    SWING_RAD,
    key_legs_mm,
    longest_run,
    motor_screw_mm,
)
from delta_cad.interference.moving_bodies import arm_shapes, sector_points
from delta_cad.interference.shapes import Block, Placed, Prism, Round, Shape, collides, least_distance, union_distance
from delta_cad.mechanism.inverse import inverse_kinematics
from delta_cad.mechanism.placement import CHAINS

_AROUND = 48  # points around a motor and a pinion
_ALONG_MM = 3.0  # between their circles, and between points of a key
_SLID_MM = 40.0  # over which a drive's way on to its plate is looked at
_SLIDES = 21
_SWINGS = 31  # angles of an arm between its stops
_TURNS = 72, 360  # directions of a key's handle: every 5 degrees, and every degree where those leave it open
HEIGHTS = 21  # of the handle on the cube's middle axis
_FAR_MM = 1e3

_Obstacle = tuple[Sequence[Shape], int]
"""Shapes, and the chain in whose frame they are."""
_ObstacleDistance = tuple[float, Shape, int]
"""How far a shape is off a point, the shape, and the chain in whose frame it is."""


def cheeks(d: Dimensions) -> list[Shape]:
    """Lists both cheeks of a chain, as hulls in its shoulder's frame."""
    b, (outside, inside), head = d.bracket, d.layers.encoder_cheek_mm, d.encoder_head_circles_mm
    leg = [*([b.leg_circle_mm] if d.capstan else head), *b.foot_circles_mm]
    return [
        Prism(b.motor_cheek_circles_mm, d.layers.motor_cheek_mm, CHEEK_EDGE_MM),
        Prism(leg, (outside, inside), CHEEK_EDGE_MM),
        Prism(head, (d.layers.encoder_head_mm[0], inside), CHEEK_EDGE_MM),
    ]


def motor(d: Dimensions) -> Round:
    """The motor's body in its shoulder's frame."""
    face, (u, z) = d.layers.motor_face_mm, d.bracket.motor_axis_mm
    return Round(d.motor.diameter_mm / 2, (face, face + d.motor.length_mm), (u - d.bracket.shoulder_u_mm, z))


def board(d: Dimensions) -> list[Block]:
    """The encoder's board in its shoulder's frame, its length upright; none where no encoder is there."""
    if not d.sensed_at_shoulder:
        return []
    long, wide = d.encoder.board_length_mm / 2, d.encoder.board_width_mm / 2
    back, front = d.layers.encoder_board_mm
    return [Block(np.eye(3), (0.0, 0.0, 0.0), (-wide, back, -long), (wide, front, long))]


def foot(d: Dimensions) -> Block:
    """The foot block with the base plate under it, in its shoulder's frame."""
    low, high = (u - d.bracket.shoulder_u_mm for u in d.bracket.foot_u_mm)
    inside = d.layers.encoder_cheek_mm[1], d.layers.motor_cheek_mm[0]
    return Block(
        np.eye(3),
        (0.0, 0.0, 0.0),
        (low, inside[0], d.bracket.base_top_mm - d.base.thickness_mm),
        (high, inside[1], d.bracket.base_top_mm + d.bracket.foot_height_mm),
        CHEEK_EDGE_MM,
    )


def _on_round(one: Round) -> np.ndarray:
    """Gives points on a cylinder's side, (n, 3)."""
    turns = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    (x, z), (low, high) = one.at_mm, one.y_mm
    levels = np.linspace(low, high, int((high - low) / _ALONG_MM) + 2)
    x, z = x + one.radius_mm * np.cos(turns), z + one.radius_mm * np.sin(turns)
    return np.stack([np.tile(x, len(levels)), np.repeat(levels, _AROUND), np.tile(z, len(levels))], axis=1)


def are_alike(design: Design) -> bool:
    """Decides whether what is of one chain is of all three: they stand alike about the cube's middle axis."""
    return design.geometry.three_fold and not design.cube.centre_x_mm


def _adjacent(d: Dimensions) -> list[tuple[int, int]]:
    """Pairs of chains (of what stands, of what comes near it) that stand for all: each where they stand alike."""
    pairs = [*permutations(CHAINS, 2)]
    return [pair for pair in pairs if pair[0] == 0] if d.design.geometry.three_fold else pairs


def _in_base(d: Dimensions, points: np.ndarray, chain: int) -> np.ndarray:
    """Gives points (..., 3) of a chain's shoulder frame in the base frame, mm."""
    stand, out = d.stand(chain), np.array([d.bracket.shoulder_u_mm, 0.0, 0.0])
    return (points + out) @ stand[:3, :3].T + stand[:3, 3]


def _seen_from(d: Dimensions, points: np.ndarray, chain: int, own: int) -> np.ndarray:
    """Gives points (..., 3) of one chain's shoulder frame in that of another, its own, mm."""
    stand, out = d.stand(own), np.array([d.bracket.shoulder_u_mm, 0.0, 0.0])
    return (_in_base(d, points, chain) - stand[:3, 3]) @ stand[:3, :3] - out


def pinion(c: CapstanDimensions, d: Dimensions) -> list[Round]:
    """The pinion and its collar, in the shoulder's frame."""
    at = motor(d).at_mm
    return [Round(c.pinion_radius_mm, c.groove_y_mm, at), Round(c.collar_radius_mm, c.collar_y_mm, at)]


def _shaft_end(c: CapstanDimensions, d: Dimensions) -> Round:
    """What of a motor's shaft comes out of its pinion, in the shoulder's frame."""
    low = c.pinion_y_mm[0]
    tip = min(d.layers.motor_face_mm - d.motor.shaft_length_mm, low)
    return Round(d.motor.shaft_diameter_mm / 2, (tip, low), motor(d).at_mm)


def pinion_clearance_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes the distance of a pinion to the static obstacles of another chain."""
    points = np.concatenate([_on_round(one) for one in pinion(c, d)])
    stands = [*cheeks(d), motor(d)]
    return min(least_distance(stands, _seen_from(d, points, j, i)) for i, j in _adjacent(d))


def sector_clearance_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes the distance of a sector to the static obstacles of another chain, between its arm's stops."""
    low, high = d.stops_rad
    stands: list[Shape] = [*cheeks(d), motor(d), *pinion(c, d)]
    turns, (x, y, z) = np.linspace(low, high, _SWINGS)[:, None], sector_points(d, c).T
    cosine, sine = np.cos(turns), np.sin(turns)
    at = np.stack([cosine * x - sine * z, y + 0.0 * turns, sine * x + cosine * z], axis=2)
    return min(least_distance(stands, _seen_from(d, at, j, i)) for i, j in _adjacent(d))


def slide_in_clearance_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes how near a motor or pinion comes to another's motor cheek as either drive slides in along its radius."""
    cheek, radial = cheeks(d)[0], d.design.geometry.radial
    points = np.concatenate([_on_round(one) for one in (motor(d), *pinion(c, d), _shaft_end(c, d))])
    way = np.linspace(0.0, _SLID_MM, _SLIDES)[:, None, None]
    found = _FAR_MM
    for i, j in _adjacent(d):
        there, own = _seen_from(d, points, j, i), radial[j] @ d.stand(i)[:3, :3]
        for out in (own, np.array([-1.0, 0.0, 0.0])):  # the motor's drive comes last, or the cheek's
            found = min(found, least_distance([cheek], there + way * out))
    return found


def _in_the_way(d: Dimensions, chain: int) -> list[_Obstacle]:
    """Static obstacles around a chain's motor screws."""
    block = foot(d)
    others: list[Shape] = [*cheeks(d), motor(d), block]
    own = [*pinion(d.capstan, d), _shaft_end(d.capstan, d)] if d.capstan is not None else []
    return [([*cheeks(d)[1:], block, *own], chain), *((others, i) for i in CHAINS if i != chain)]


def _arms(d: Dimensions) -> list[list[_Obstacle]]:
    """Arms with sectors for handle positions on the cube's middle axis, the middle first."""
    if d.capstan is None:
        return [[]]
    cube, still = d.design.workspace, arm_shapes(d, d.capstan)
    shares = np.linspace(0.0, 1.0, HEIGHTS)
    heights = cube.bottom_height + 2.0 * cube.half_side * shares[np.argsort(np.abs(shares - 0.5), kind="stable")]
    at = np.stack([cube.centre[0] + 0.0 * heights, 0.0 * heights, heights], axis=1)

    def arm(angle: float) -> list[Shape]:
        cosine, sine = np.cos(angle), np.sin(angle)
        axes = np.array([[cosine, 0.0, -sine], [0.0, 1.0, 0.0], [sine, 0.0, cosine]])
        return [Placed(axes, shape) for shape in still]

    return [[(arm(angles[i]), i) for i in CHAINS] for angles in inverse_kinematics(d.design.geometry, at)]


def key_swing_rad(d: Dimensions) -> float:
    """Computes by how much a key's handle swings in a motor's screw, rad: of the first in which it is too little.

    Beside what stands still, and beside arms with their sectors, which go up and down with the handle as suits. What
    swings by `SWING_RAD` may swing by more than is told.

    Args:
        d: The machine.

    It is one of the keys that `delta_cad.checks.contact.access` tries; what else moves is left out.
    """
    row = d.motor.mount_screw
    if row.socket_mm not in KEYS_MM:
        return 2.0 * pi
    keys = key_legs_mm(row.socket_mm)
    mouth = d.layers.motor_cheek_mm[0] + motor_screw_mm(d.motor, d.layers)[1] - row.head_height_mm
    radius, arms = CORNERS * row.socket_mm / 2.0, _arms(d)

    def best(at: tuple[float, float], chain: int) -> float:
        """Swing of the key that swings farthest; the search ends at the first that swings far enough."""
        most, still = 0.0, dict[tuple[float, float], np.ndarray]()
        point = np.array([[at[0], mouth, at[1]]])
        around = _off(d, _in_the_way(d, chain), point, chain)

        def free(
            at: tuple[float, float], key: tuple[float, float], adjacent: list[_ObstacleDistance], among: np.ndarray
        ) -> np.ndarray:
            return _free(d, chain, at, mouth, radius, row.socket_depth_mm, key, adjacent, among)

        for one in arms:
            arm = _off(d, one, point, chain)
            for key in keys:
                if key not in still:
                    still[key] = free(at, key, around, np.ones(_TURNS[0], dtype=bool))
                swing = _swing_rad(among := still[key])
                if swing >= SWING_RAD:  # what stands still leaves it room
                    left = free(at, key, arm, among)
                    swing = _swing_rad(left)
                    if SWING_RAD <= swing < SWING_RAD + 4.0 * pi / _TURNS[0]:  # it may be up to two steps less
                        near = np.repeat(left | np.roll(left, -1), _TURNS[1] // _TURNS[0])
                        swing = _swing_rad(free(at, key, [*around, *arm], near))
                if (most := max(most, swing)) >= SWING_RAD:
                    return most
        return most

    least = 2.0 * pi
    for chain, at in product(CHAINS[:1] if are_alike(d.design) else CHAINS, _screws(d)):
        least = min(least, best(at, chain))
        if least < SWING_RAD:
            break
    return least


def _screws(d: Dimensions) -> Iterator[tuple[float, float]]:
    (x, z), radius = motor(d).at_mm, d.motor.mount_circle_mm / 2
    for angle in d.bracket.motor_screws_rad:
        yield x + radius * cos(angle), z + radius * sin(angle)


def _off(d: Dimensions, stands: list[_Obstacle], point: np.ndarray, chain: int) -> list[_ObstacleDistance]:
    """Signed distances from a point (1, 3) of a chain's shoulder frame to all static obstacles."""
    found = []
    for shapes, of in stands:
        there = _seen_from(d, point, chain, of)
        found += [(float(shape.signed_distance(there)[0]), shape, of) for shape in shapes]
    return found


def _within(stands: list[_ObstacleDistance], reach: float) -> list[_Obstacle]:
    """What of it is nearer than a reach."""
    near = [([shape for off, shape, of in stands if of == chain and off < reach], chain) for chain in CHAINS]
    return [one for one in near if one[0]]


def _met_by_plate(d: Dimensions, points: np.ndarray, chain: int, radius: float) -> np.ndarray:
    """Whether balls at points (..., 3) in a chain's shoulder frame meet the base plate outside its large holes."""
    at = _in_base(d, points, chain)
    top, bottom = d.bracket.base_top_mm, d.bracket.base_top_mm - d.base.thickness_mm
    met = np.maximum(bottom - at[..., 2], at[..., 2] - top) < radius
    (x, y, z), rim = at[met].T, d.base.rim_mm or ((0.0, 0.0, d.base.radius_mm),)
    near = union_distance([Prism(rim, (bottom, top))], np.stack([x, z, y], axis=1)) < radius
    beyond = np.maximum(np.maximum(bottom - z, z - top), 0.0)
    for across, aside, hole in d.base.holes_mm:
        inside = hole - np.hypot(x - across, y - aside)
        near &= (inside < 0.0) | (np.hypot(inside, beyond) < radius)
    met[met] = near
    return met


def _free(
    d: Dimensions,
    chain: int,
    at: tuple[float, float],
    mouth: float,
    radius: float,
    depth: float,
    key: tuple[float, float],
    adjacent: list[_ObstacleDistance],
    among: np.ndarray,
) -> np.ndarray:
    """In which of the directions (n), from the first of a circle on, one key in one screw is free, (n)."""
    (inside, handle), free = key, among.copy()
    turns = np.linspace(0.0, 2.0 * np.pi, len(free), endpoint=False)
    out = np.linspace(radius, handle - radius, int(handle / _ALONG_MM) + 2)  # balls within it
    flat = np.stack([np.outer(np.cos(turns), out), 0.0 * np.outer(turns, out), np.outer(np.sin(turns), out)], axis=2)
    leg = np.arange(0.0, inside, _ALONG_MM)[:, None] * np.array([0.0, -1.0, 0.0]) + np.array([at[0], mouth, at[1]])
    stands = _within(adjacent, inside + handle)
    if any((union_distance(shapes, _seen_from(d, leg, chain, of)) < radius).any() for shapes, of in stands):
        return np.zeros_like(free)
    bends = np.array([[[at[0], mouth - inside + deep, at[1]]] for deep in (depth, 0.0)])
    points = flat[:, None] + bends  # (directions, bends, along the handle, 3)
    free &= ~_met_by_plate(d, points, chain, radius).any(axis=(1, 2))
    for shapes, of in stands:
        free[free] = ~collides(shapes, _seen_from(d, points[free], chain, of), radius).any(axis=1)
    return free


def _swing_rad(free: np.ndarray) -> float:
    """Longest run of directions of a circle (n) that are free, and up to a step at either end, rad."""
    if free.all() or not free.any():
        return 2.0 * pi * free[0]
    return (longest_run(free) + 1) * 2.0 * pi / len(free)
