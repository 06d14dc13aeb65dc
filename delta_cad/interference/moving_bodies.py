"""Clearance between moving bodies of different chains: sectors, rods and springs; cups at the wrists."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise, product
from math import sin

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, link_placement
from delta_cad.dimensions.capstan import (
    ANCHOR_MM,
    ANCHOR_SIDE_MM,
    CARRIAGE_MM,
    CARRIAGE_RADII_MM,
    CRIMP_MM,
    LUG_WALL_MM,
    RIM_MM,
    CapstanDimensions,
    lug_length_mm,
    rim_end,
)
from delta_cad.dimensions.forearm import GUSSET, ForearmDimensions
from delta_cad.interference.platform import platform_points, platform_shapes
from delta_cad.interference.shapes import Bar, Beam, Block, Placed, Points, Ring, Round, Shape, union_distance
from delta_cad.mechanism.placement import CHAINS, SIDES, chain_turn, spring_sway
from delta_cad.mechanism.workspace import Cube, cube_grid

COUNT = 4  # positions along an edge of the cube that are looked at first
FEW = 3  # where corners are what counts, or a bound is looked for
STARTS = {COUNT: 3, FEW: 2}  # nearest of them from which one goes on
HALVINGS, _ROUGH_HALVINGS = 4, 2  # how often the step is halved then, and the first of these, which look roughly
FAR_MM = 6.0  # beyond which nothing is looked at
_STEP_MM, _TUBE_STEP_MM = 1.5, 3.0  # between points of an edge, and of a tube's axis or a cable
ROUGH = 3  # one point of so many is looked at first
_ANCHOR_OFF_MM = -ANCHOR_SIDE_MM, ANCHOR_SIDE_MM  # of the anchor's wall and of the lug, off the cable's line
_LUG_OFF_MM = CARRIAGE_RADII_MM[0] - LUG_WALL_MM[0], CARRIAGE_RADII_MM[1] + LUG_WALL_MM[0]
_CABLE_PIECES = 3  # in which either half of a cable on its rim is seen: it climbs
_NOSE_POINTS, _END_POINTS, _GUSSET_POINTS = 24, 5, (3, 2)
_AROUND = np.array([*product((-1.0, 0.0, 1.0), repeat=3)])

DistanceField = Callable[[np.ndarray, bool, int | None], np.ndarray]
"""Positions (n, 3) of the handle, mm, whether a rough look is enough, and the number of a pair that alone is looked at
-> (n, pairs) distances, mm."""


def arm_alone(d: Dimensions) -> list[Shape]:
    """Lists what an arm without its sector is made of, in its frame, the elbow left out."""
    a, (under, over) = d.arm, d.layers.arm_mm
    beam = Beam(a.length_mm, (a.beam_root_radius_mm, a.boss_radius_mm), (under, over))
    if d.capstan is None:
        return [Round(a.flange_radius_mm, (under, over)), beam]
    web = d.capstan.web_y_mm[1]
    return [
        Round(a.flange_radius_mm, (under, web)),
        Round(a.collar_diameter_mm / 2, (web, d.layers.motor_cheek_mm[0])),
        beam,
    ]


def arm_shapes(d: Dimensions, c: CapstanDimensions) -> list[Shape]:
    """Lists what an arm with its sector is made of, in its frame: the cable as it is drawn, the elbow left out."""
    y, web = d.layers.sector_mm, c.web_y_mm
    found: list[Shape] = [
        Ring((c.rim_radius_mm - RIM_MM, c.rim_radius_mm), c.rim_angles_rad, y),
        Ring((d.arm.flange_radius_mm - 4.0, c.rim_radius_mm), c.rim_angles_rad, web),
        Round(c.nose_radius_mm, y, c.nose_centre_mm),
        *arm_alone(d),
    ]
    half, wound = c.cable_diameter_mm / 2, (c.rim_radius_mm, c.rim_radius_mm + c.cable_diameter_mm)
    for end, ((low, high), long, lowest) in enumerate(_ends(c)):
        point, tangent, normal = rim_end(c, end)
        axes = np.stack([normal, [0.0, 1.0, 0.0], tangent], axis=1)
        found.append(Block(axes, (point[0], 0.0, point[2]), (low, lowest, 0.0), (high, y[1], long)))
        sense, start = (1.0, -1.0)[end], c.rim_angles_rad[end]
        for a, b in pairwise(np.linspace(start, c.direction_rad - d.home_rad, _CABLE_PIECES + 1).tolist()):
            at = c.end_y_mm[end] - sense * c.run.climb * c.pitch_radius_mm * abs((a + b) / 2 - start)
            found.append(Ring(wound, (min(a, b), max(a, b)), (at - half, at + half)))
    point, tangent, _ = rim_end(c, 0)
    sleeve = Bar(CRIMP_MM[0] / 2, CRIMP_MM[1], point + ANCHOR_MM * tangent, tangent)
    (x, z), turned = c.nose_centre_mm, (c.rim_angles_rad[0] - c.turns_rad[0], c.rim_angles_rad[0])
    round_nose = Ring((0.0, c.nose_radius_mm + 2.0 * half), turned, (c.end_y_mm[0], c.end_y_mm[0]))  # its middle plane
    return [*found, sleeve, Placed(np.eye(3), round_nose, (x, 0.0, z))]


def sector_points(d: Dimensions, c: CapstanDimensions) -> np.ndarray:
    """Gives (n, 3) points of a sector's edges and cable, in the arm's frame: of its rim, nose, anchor and lug."""
    low, high = c.rim_angles_rad
    wide = d.layers.sector_mm

    def circle(radius: float, turns: np.ndarray) -> np.ndarray:
        return radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)

    edges = [
        (circle(c.rim_radius_mm, np.linspace(low, high, int((high - low) * c.rim_radius_mm / _STEP_MM) + 2)), wide),
        (np.array(c.nose_centre_mm) + circle(c.nose_radius_mm, np.linspace(0.0, 2.0 * np.pi, _NOSE_POINTS)), wide),
    ]
    for end, ((out, over), long, lowest) in enumerate(_ends(c)):
        point, tangent, normal = (v[[0, 2]] for v in rim_end(c, end))
        along = np.linspace(0.0, long, int(long / _STEP_MM) + 2)[:, None] * tangent
        across = np.linspace(out, over, _END_POINTS)[:, None] * normal
        sides = point + out * normal + along, point + over * normal + along, point + long * tangent + across
        edges.append((np.concatenate(sides), (lowest, wide[1])))
    point, tangent, normal = rim_end(c, 0)
    turns = np.linspace(0.0, 2.0 * np.pi, _NOSE_POINTS, endpoint=False)[:, None]
    sleeve = CRIMP_MM[0] / 2 * (np.cos(turns) * normal + np.sin(turns) * np.array([0.0, 1.0, 0.0]))
    flats = [np.insert(flat, 1, y, axis=1) for flat, levels in edges for y in levels]
    wound = c.rim_radius_mm + c.cable_diameter_mm
    for end, sense in enumerate((1.0, -1.0)):
        swept = abs(c.direction_rad - d.home_rad - c.rim_angles_rad[end])
        turned = np.linspace(0.0, swept, int(swept * wound / _TUBE_STEP_MM) + 2)
        climbed = c.end_y_mm[end] - sense * c.run.climb * c.pitch_radius_mm * turned
        flats.append(np.insert(circle(wound, c.rim_angles_rad[end] + sense * turned), 1, climbed, axis=1))
    around = circle(c.nose_radius_mm + c.cable_diameter_mm, np.linspace(low - c.turns_rad[0], low, _NOSE_POINTS))
    flats.append(np.insert(np.array(c.nose_centre_mm) + around, 1, c.end_y_mm[0], axis=1))
    return np.concatenate([*flats, point + (ANCHOR_MM + CRIMP_MM[1]) * tangent + sleeve])


def _ends(c: CapstanDimensions) -> tuple[tuple[tuple[float, float], float, float], ...]:
    """Anchor and lug: from where to where off the cable's line, how far along it, and from where along y."""
    pocket = c.end_y_mm[1] - CARRIAGE_MM[1] / 2
    return (_ANCHOR_OFF_MM, ANCHOR_MM, c.web_y_mm[0]), (_LUG_OFF_MM, lug_length_mm(), pocket)


def rod_points(f: ForearmDimensions) -> Points:
    """Gives a rod as balls in its own frame: tube and both cups."""
    tube = np.arange(f.shoulder_mm, f.length_mm - f.shoulder_mm, _TUBE_STEP_MM)
    x = np.array([0.0, f.length_mm, *tube])
    radius = np.array([f.cup_radius_mm] * 2 + [f.tube_outer_mm / 2] * len(tube))
    return np.stack([x, 0.0 * x, 0.0 * x], axis=1), radius


def spring_points(d: Dimensions) -> Points:
    """Gives a spring as balls about its middle, the shoulder's axis along y, with all that it strays."""
    f = d.forearm
    sway = spring_sway(f.width_mm, f.eye_y_mm, f.eye_z_mm, f.tilt_limit_rad)
    half, coil = f.between_eyes_mm / 2 + sway.along_mm, (f.spring.mean_diameter_mm + f.spring.wire_mm) / 2
    y = np.linspace(-half, half, int(2 * half / _STEP_MM) + 2)
    wound = f.between_eyes_mm / 2 - f.spring.mean_diameter_mm  # half of what is no loop: its side strays as its ends
    radius = np.full(len(y), coil + sway.across_mm + wound * sin(sway.turn_rad))
    return np.stack([0.0 * y, y, 0.0 * y], axis=1), radius


def sector_clearance(d: Dimensions, c: CapstanDimensions, kind: str) -> DistanceField:
    """Gives how near other chains' "sector", "rod" or "spring", or the "platform", come to an arm with its sector."""
    f, g, shapes, reach = d.forearm, d.design.geometry, arm_shapes(d, c), c.keep_out_radius_mm + FAR_MM
    edges, solid = sector_points(d, c), platform_shapes(d)
    points, radii = {
        "sector": lambda: (edges, np.zeros(len(edges))),
        "rod": lambda: rod_points(f),
        "spring": lambda: spring_points(d),
        "platform": lambda: platform_points(d),
    }[kind]()
    links = ("upper_arm_{}",) if kind == "sector" else tuple(f"{kind}_{{}}_{k}" for k in SIDES)
    pairs = [(i, link.format(j)) for i, j in product(CHAINS, CHAINS) if i != j for link in links]
    if kind == "platform":
        pairs = [(i, kind) for i in CHAINS]

    def apart(positions_mm: np.ndarray, rough: bool, only: int | None) -> np.ndarray:
        placed = link_placement(d)(positions_mm)
        some = slice(None, None, ROUGH if rough else 1)
        looked = pairs if only is None else [pairs[only]]
        found = np.full((len(positions_mm), len(looked)), FAR_MM)
        for k, (i, link) in enumerate(looked):
            frame = placed[link]
            if kind == "spring":  # what it strays is known about the shoulder's direction
                level = np.broadcast_to(chain_turn(g, int(link.split("_")[1])), frame.shape).copy()
                level[:, :3, 3] = frame[:, :3, 3]
                frame = level
            seen, ball = np.linalg.inv(placed[f"upper_arm_{i}"]) @ frame, radii[some]
            at = points[some] @ np.swapaxes(seen[:, :3, :3], 1, 2) + seen[:, None, :3, 3]
            near = np.hypot(at[..., 0], at[..., 2]) - ball < reach
            near &= np.abs(at[..., 1]) - ball < d.layers.sector_mm[1] + FAR_MM
            if near.any():
                off = np.full(near.shape, FAR_MM)
                off[near] = union_distance(shapes, at[near]) - np.broadcast_to(ball, near.shape)[near]
                found[:, k] = off.min(axis=1)
                if kind == "platform":
                    found[:, k] = np.minimum(found[:, k], _off_platform(d, solid, np.linalg.inv(seen), edges[some]))
        return found

    return apart


def _off_platform(d: Dimensions, solid: Sequence[Shape], arm: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """How near edges of a sector come to the platform, (n), the arm in its frame (n, 4, 4)."""
    at, p = edges @ np.swapaxes(arm[:, :3, :3], 1, 2) + arm[:, None, :3, 3], d.platform
    out, down = np.hypot(p.radius_mm + p.boss_diameter_mm / 2, p.boss_length_mm / 2), -p.boss_diameter_mm / 2
    near = (at[..., 2] > down - FAR_MM) & (np.hypot(at[..., 0], at[..., 1]) < out + FAR_MM)
    off = np.full(near.shape, FAR_MM)
    if near.any():
        off[near] = union_distance(solid, at[near])
    return off.min(axis=1)


def spring_clearance(d: Dimensions) -> DistanceField:
    """Gives how near springs of different chains come to one another, over positions, with all that they stray."""
    points, radii = spring_points(d)
    pairs = [(i, (i + 1) % 3, k, m) for i, k, m in product(CHAINS, SIDES, SIDES)]
    stray, turns = float(radii[0]), [d.turn(i)[:3, :3] for i in CHAINS]

    def apart(positions_mm: np.ndarray, rough: bool, only: int | None) -> np.ndarray:
        placed = link_placement(d)(positions_mm)
        some = points[:: ROUGH if rough else 1]
        off = []
        for i, j, k, m in pairs if only is None else [pairs[only]]:
            a, b = (
                placed[f"spring_{chain}_{side}"][:, None, :3, 3] + some @ turns[chain].T
                for chain, side in ((i, k), (j, m))
            )
            off.append(np.linalg.norm(a[:, :, None] - b[:, None], axis=3).min(axis=(1, 2)) - 2.0 * stray)
        return np.stack(off, axis=1)

    return apart


def cup_margin(d: Dimensions, needed_mm: float) -> DistanceField:
    """Gives by how much more than they must the wrists of neighbouring chains stand apart, over positions.

    Their cups keep a distance, the rods as they are and turned about themselves as far as they go. Where two points of
    them are `v` apart, and n is the direction in which the wrists part, they part by `s` more to be as far apart as
    needed: `(v n + s)^2 + |v - (v n) n|^2 = needed^2`.

    Returns:
        Positions -> (n, 1) mm, all of them as one pair; negative: what is lacking.
    """
    f, g = d.forearm, d.design.geometry
    rod, outer = f.tube_outer_mm / 2, f.cup_radius_mm
    along, across = (share * outer for share in GUSSET)
    edge, wide = np.linspace(0.0, along, _GUSSET_POINTS[0]), np.linspace(-rod, rod, _GUSSET_POINTS[1])
    edges = np.array([(-x, across, z) for x in edge for z in wide])  # of a gusset, from its ball

    def around(frame: np.ndarray, chain: int, side: int) -> np.ndarray:
        """(n, points, 3) points of a cup from its ball, as it is and turned."""
        lean = np.arcsin(np.clip(np.abs(frame[:, :, 0] @ g.tangential[chain]), 0.0, 1.0))
        free = np.arccos(np.clip(np.cos(f.tilt_limit_rad) / np.cos(lean), 0.0, 1.0))
        x, y, z = (edges * np.array([1.0, 1.0 if side else -1.0, 1.0])).T
        found = []
        for turn in (-free, 0.0 * free, free):
            cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
            local = np.stack([x + 0.0 * cosine, y * cosine - z * sine, y * sine + z * cosine], axis=2)
            found.append(local @ np.swapaxes(frame, 1, 2))
        return np.concatenate(found, axis=1)

    def lacking(v: np.ndarray, n: np.ndarray, needed: float) -> np.ndarray:
        along = v @ n
        adjacent = needed**2 - ((v - along[..., None] * n) ** 2).sum(axis=-1)
        return np.where(adjacent > 0.0, np.sqrt(np.maximum(adjacent, 0.0)) - along, -np.inf)

    def reserve(positions_mm: np.ndarray, rough: bool, only: int | None) -> np.ndarray:
        del rough, only
        placed = link_placement(d)(positions_mm)
        least = np.full(len(positions_mm), np.inf)
        for i in CHAINS:
            j = (i + 1) % 3
            n = g.radial[j] - g.radial[i]
            chord = float(np.linalg.norm(n))  # the wrists part along it, less half a parallelogram's width each
            n = n / chord
            apart_mm = d.platform.radius_mm * chord - f.width_mm / 2.0 * float(n @ (g.tangential[i] + g.tangential[j]))
            least = np.minimum(least, apart_mm - 2 * outer - needed_mm)
            a = around(placed[f"rod_{i}_1"][:, :3, :3], i, 1)
            b = around(placed[f"rod_{j}_0"][:, :3, :3], j, 0)
            between = apart_mm * n
            pairs = between + b[:, None] - a[:, :, None]
            more = lacking(pairs, n, needed_mm).max(axis=(1, 2))
            more = np.maximum(more, lacking(between + b, n, needed_mm + outer).max(axis=1))
            more = np.maximum(more, lacking(between - a, n, needed_mm + outer).max(axis=1))
            least = np.minimum(least, -more)
        return least[:, None]

    return reserve


def nearest(apart: DistanceField, cube: Cube, count: int = COUNT) -> float:
    """Searches a cube for where things come nearest: a grid, then steps that halve around its nearest positions.

    From each of these the pair goes on that is nearest there.

    Args:
        apart: Distances over positions.
        cube: The cube, m.
        count: Positions along an edge of the grid.

    Returns:
        The least that was found, mm.
    """
    positions = cube_grid(cube, count) * MM_PER_M
    low, high = positions.min(axis=0), positions.max(axis=0)
    found = apart(positions, True, None)
    least = float(found.min())
    if least >= FAR_MM:
        return least
    for k in np.argsort(found.min(axis=1), kind="stable")[: STARTS[count]]:
        at, pair, step = positions[k], int(np.argmin(found[k])), 2.0 * cube.half_side * MM_PER_M / (count - 1)
        for turn in range(HALVINGS):
            step /= 2.0
            around = np.clip(at + step * _AROUND, low, high)
            seen = apart(around, turn < _ROUGH_HALVINGS, pair)[:, 0]
            at, least = around[np.argmin(seen)], min(least, float(seen.min()))
    return least
