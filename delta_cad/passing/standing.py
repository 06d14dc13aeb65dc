"""What stands beside a neighbouring drive: its motor, its pinion and its sector, and keys in its motor's screws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import cos, pi, sin

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.keys import CORNERS, KEYS_MM, LONG_MM, cut_key_mm, motor_screw_mm
from delta_cad.mechanism.placement import CHAINS, chain_frame
from delta_cad.passing.moving import sector_points
from delta_cad.passing.shapes import Block, Prism, Round, Shape, off_all_mm

AROUND = 48  # points around a motor and a pinion
ALONG_MM = 3.0  # between their circles, and between points of a key
SLID_MM = 40.0  # over which a drive's way on to its plate is looked at
SLIDES = 21
SWINGS = 31  # angles of an arm between its stops
TURNS = 72  # directions of a key's handle: every 5 degrees
SWING_RAD = pi / 3  # of a handle, to a hexagon's next corner
FAR_MM = 1e3


def cheeks(d: Dimensions) -> list[Shape]:
    """Lists both cheeks of a chain, as hulls in its shoulder's frame."""
    b, (outside, inside) = d.bracket, d.layers.encoder_cheek_mm
    leg = [b.leg_circle_mm, *b.foot_circles_mm]
    head = Round(b.head_radius_mm, (d.layers.encoder_head_mm[0], inside))
    return [Prism(b.motor_cheek_circles_mm, d.layers.motor_cheek_mm), Prism(leg, (outside, inside)), head]


def motor(d: Dimensions) -> Round:
    """The motor's body in its shoulder's frame."""
    face, (u, z) = d.layers.motor_cheek_mm[1], d.bracket.motor_axis_mm
    return Round(d.motor.diameter_mm / 2, (face, face + d.motor.length_mm), (u - d.bracket.shoulder_u_mm, z))


def foot(d: Dimensions) -> Block:
    """The foot block with the base plate under it, in its shoulder's frame."""
    low, high = (u - d.bracket.shoulder_u_mm for u in d.bracket.foot_u_mm)
    inside = d.layers.encoder_cheek_mm[1], d.layers.motor_cheek_mm[0]
    return Block(
        np.eye(3),
        (0.0, 0.0, 0.0),
        (low, inside[0], d.bracket.base_top_mm - d.base.thickness_mm),
        (high, inside[1], d.bracket.base_top_mm + d.bracket.foot_height_mm),
    )


def on_round(one: Round) -> np.ndarray:
    """Gives points on a cylinder's side, (n, 3)."""
    turns = np.linspace(0.0, 2.0 * np.pi, AROUND, endpoint=False)
    (x, z), (low, high) = one.at_mm, one.y_mm
    levels = np.linspace(low, high, int((high - low) / ALONG_MM) + 2)
    x, z = x + one.radius_mm * np.cos(turns), z + one.radius_mm * np.sin(turns)
    return np.stack([np.tile(x, len(levels)), np.repeat(levels, AROUND), np.tile(z, len(levels))], axis=1)


def seen_from(points: np.ndarray, chain: int, base_radius_mm: float) -> np.ndarray:
    """Gives points of one chain's shoulder frame in chain 0's when they are those of another chain."""
    out = np.array([base_radius_mm, 0.0, 0.0])
    return (points + out) @ chain_frame(chain)[:3, :3].T - out


def pinion(c: CapstanDimensions, d: Dimensions) -> list[Round]:
    """The pinion and its collar, in the shoulder's frame."""
    at = motor(d).at_mm
    low, (neck, high) = c.pinion_y_mm[0], c.collar_y_mm
    return [Round(c.pinion_radius_mm, (low, neck), at), Round(c.collar_radius_mm, (neck, high), at)]


def shaft_end(c: CapstanDimensions, d: Dimensions) -> Round:
    """What of a motor's shaft comes out of its pinion, in the shoulder's frame."""
    low = c.pinion_y_mm[0]
    tip = min(d.layers.motor_cheek_mm[1] - d.motor.shaft_length_mm, low)
    return Round(d.motor.shaft_diameter_mm / 2, (tip, low), motor(d).at_mm)


def pinion_off_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes how near a pinion comes to what stands on another chain."""
    points = np.concatenate([on_round(one) for one in pinion(c, d)])
    stands = [*cheeks(d), motor(d)]
    return min(float(off_all_mm(stands, seen_from(points, j, d.bracket.shoulder_u_mm)).min()) for j in CHAINS[1:])


def sector_off_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes how near a sector comes to what stands on another chain, between its arm's stops."""
    low, high = d.stops_rad
    stands: list[Shape] = [*cheeks(d), motor(d), *pinion(c, d)]
    turns, (x, y, z) = np.linspace(low, high, SWINGS)[:, None], sector_points(d, c).T
    cosine, sine = np.cos(turns), np.sin(turns)
    at = np.stack([cosine * x - sine * z, y + 0.0 * turns, sine * x + cosine * z], axis=2)
    return min(float(off_all_mm(stands, seen_from(at, j, d.bracket.shoulder_u_mm)).min()) for j in CHAINS[1:])


def sliding_off_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes how near a motor or pinion comes to another's motor cheek as either drive slides in along its radius."""
    u, cheek = d.bracket.shoulder_u_mm, cheeks(d)[0]
    points = np.concatenate([on_round(one) for one in (motor(d), *pinion(c, d), shaft_end(c, d))])
    way = np.linspace(0.0, SLID_MM, SLIDES)[:, None, None]
    found = FAR_MM
    for j in CHAINS[1:]:
        there, own = seen_from(points, j, u), chain_frame(j)[:3, 0]
        for out in (own, np.array([-1.0, 0.0, 0.0])):  # the motor's drive comes last, or the cheek's
            found = min(found, float(off_all_mm([cheek], there + way * out).min()))
    return found


def _in_the_way(d: Dimensions) -> list[tuple[Sequence[Shape], int]]:
    """What stands still around a motor's screws: shapes, each with the chain in whose frame they are."""
    block = foot(d)
    others: list[Shape] = [*cheeks(d), motor(d), block]
    return [([*cheeks(d)[1:], block], 0), (others, 1), (others, 2)]


def key_swing_rad(d: Dimensions, whole: bool = True) -> float:
    """Computes by how much a key's handle swings in a motor's screw beside what stands still, the least of all, rad.

    What swings by `SWING_RAD` may swing by more than is told.

    Args:
        d: The machine.
        whole: Whether all screws are looked at, not those up to the first in which no key swings far enough.

    It is one of the keys that `delta_cad.checks.contact.access` tries; what moves is left out.
    """
    row = catalogue.screw(d.motor.mount_thread)
    if row.socket_mm not in KEYS_MM:
        return 2.0 * pi
    long, short = KEYS_MM[row.socket_mm]
    keys = (short, long), (long, short), cut_key_mm(row.socket_mm), (LONG_MM.get(row.socket_mm, long), short)
    mouth = d.layers.motor_cheek_mm[0] + motor_screw_mm(d.motor, d.layers)[1] - row.head_height_mm
    radius, stands = CORNERS * row.socket_mm / 2.0, _in_the_way(d)

    def best(at: tuple[float, float]) -> float:
        """Swing of the key that swings farthest; of the first that swings far enough, which is all that is asked."""
        most = 0.0
        for key in keys:
            if (most := max(most, _swing(d, at, mouth, radius, row.socket_depth_mm, key, stands))) >= SWING_RAD:
                break
        return most

    least = 2.0 * pi
    for at in _screws(d):
        least = min(least, best(at))
        if least < SWING_RAD and not whole:
            break
    return least


def _screws(d: Dimensions) -> Iterator[tuple[float, float]]:
    (x, z), radius = motor(d).at_mm, d.motor.mount_circle_mm / 2
    for angle in d.bracket.motor_screws_rad:
        yield x + radius * cos(angle), z + radius * sin(angle)


def _swing(
    d: Dimensions,
    at: tuple[float, float],
    mouth: float,
    radius: float,
    depth: float,
    key: tuple[float, float],
    stands: list[tuple[Sequence[Shape], int]],
) -> float:
    """Swing of one key in one screw, rad."""
    inside, handle = key
    turns = np.linspace(0.0, 2.0 * np.pi, TURNS, endpoint=False)
    out = np.arange(0.0, handle, ALONG_MM)
    flat = np.stack([np.outer(np.cos(turns), out), 0.0 * np.outer(turns, out), np.outer(np.sin(turns), out)], axis=2)
    leg = np.arange(0.0, inside, ALONG_MM)[:, None] * np.array([0.0, -1.0, 0.0]) + np.array([at[0], mouth, at[1]])
    if any(
        (off_all_mm(shapes, seen_from(leg, -chain % 3, d.bracket.shoulder_u_mm)) < radius).any()
        for shapes, chain in stands
    ):
        return 0.0
    free = np.ones(TURNS, dtype=bool)
    for bend in (mouth - (inside - depth), mouth - inside):
        points = flat + np.array([at[0], bend, at[1]])
        free &= points[..., 2].min(axis=1) - radius > d.bracket.base_top_mm
        for shapes, chain in stands:
            there = seen_from(points, -chain % 3, d.bracket.shoulder_u_mm)
            free &= off_all_mm(shapes, there).min(axis=1) > radius
    if free.all():
        return 2.0 * pi
    longest = run = 0
    for one in np.roll(free, -int(free.argmin())):
        run = run + 1 if one else 0
        longest = max(longest, run)
    return (longest + 1) * 2.0 * pi / TURNS  # no more than that: up to a step at either end
