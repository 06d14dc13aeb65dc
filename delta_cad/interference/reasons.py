"""Interference before CAD: which parts are too close, one closed form for each pair, and the fields that change it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from math import cos, degrees, pi, radians, sqrt

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, Reason, link_placement
from delta_cad.dimensions.bracket import MESHES_MM
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.direction import SLEEVE_OFF_MM
from delta_cad.dimensions.forearm import ForearmDimensions
from delta_cad.dimensions.layers import SWING_RAD
from delta_cad.dimensions.platform import BOSS_BEVEL_MM
from delta_cad.dimensions.rules import ARM, BASE, BOTTOM, FOREARM, PLATFORM, RATIO, SECTOR, WIDTH, Way, larger, smaller
from delta_cad.interference.ferrule_insertion import ferrule_clearance_mm
from delta_cad.interference.moving_bodies import (
    FAR_MM,
    FEW,
    ROUGH,
    DistanceField,
    arm_alone,
    arm_shapes,
    cup_margin,
    nearest,
    rod_points,
    sector_clearance,
    spring_clearance,
    spring_points,
)
from delta_cad.interference.shapes import Bar, Block, Shape, union_distance
from delta_cad.interference.static_obstacles import (
    board,
    cheeks,
    key_swing_rad,
    motor,
    pinion_clearance_mm,
    sector_clearance_mm,
    slide_in_clearance_mm,
)
from delta_cad.mechanism.errors import UnreachableError
from delta_cad.mechanism.placement import CHAINS, SIDES, chain_stand, chain_turn
from delta_cad.mechanism.workspace import Cube

# Rods and springs beside their own drive: motor, cheeks and board, and the arm with its sector.
_WIDEST_RAD = radians(60.0)  # at an elbow, that rods may be asked to keep off a drive by


def drive_clearances(d: Dimensions) -> tuple[DistanceField, DistanceField]:
    """Gives how near rods and the springs across them come to their own chain's drive, over positions.

    First to what stands, cheeks, motor and the encoder's board; then to the arm with its sector. Each is nearest
    somewhere else.
    """
    shoulder = np.eye(4)
    shoulder[0, 3] = d.bracket.shoulder_u_mm
    turns = arm_shapes(d, d.capstan) if d.capstan else arm_alone(d)
    return _adjacent(d, [*cheeks(d), motor(d), *board(d)], shoulder), _adjacent(d, turns, None)


def _adjacent(d: Dimensions, shapes: Sequence[Shape], shoulder: np.ndarray | None) -> DistanceField:
    """How near rods and springs come to shapes of their chain: in the shoulder's frame, or None: in the arm's."""
    g, moving = d.design.geometry, {"rod": rod_points(d.forearm), "spring": spring_points(d)}
    inside, outside = d.layers.encoder_board_mm[0], d.layers.motor_face_mm + d.motor.length_mm
    pairs = [*product(CHAINS, SIDES, moving)]

    def apart(positions_mm: np.ndarray, rough: bool, only: int | None) -> np.ndarray:
        placed = link_placement(d)(positions_mm)
        some, off = slice(None, None, ROUGH if rough else 1), []
        for i, side, link in pairs if only is None else [pairs[only]]:
            points, radii = (held[some] for held in moving[link])
            frame = placed[f"{link}_{i}_{side}"]
            turned = chain_turn(g, i)[:3, :3] if link == "spring" else frame[:, :3, :3]  # all that it strays is level
            at = points @ np.swapaxes(turned, -2, -1) + frame[:, None, :3, 3]
            adjacent = np.broadcast_to(radii, at.shape[:2])
            inverse = np.linalg.inv(placed[f"upper_arm_{i}"] if shoulder is None else chain_stand(g, i) @ shoulder)
            seen = at @ np.swapaxes(inverse[..., :3, :3], -2, -1) + inverse[..., None, :3, 3]
            y, found = seen[..., 1], np.full(at.shape[:2], FAR_MM)
            near = np.maximum(inside - y, y - outside) - adjacent < FAR_MM
            if near.any():
                found[near] = np.minimum(union_distance(shapes, seen[near]) - adjacent[near], FAR_MM)
            off.append(found.min(axis=1))
        return np.stack(off, axis=1)

    return apart


def fold_interference(d: Dimensions, least_mm: float) -> Iterator[Reason]:
    """Gives the reason why rods that fold onto their own drive are too near.

    Args:
        d: The machine.
        least_mm: Least distance between them.
    """
    cube, long, forearm = d.design.workspace, d.arm.length_mm, d.forearm.length_mm
    drive = drive_clearances(d)

    def shortfall(at: Cube) -> float:
        try:
            return least_mm - min(nearest(apart, at, FEW) for apart in drive)
        except UnreachableError:  # so high does not fold
            return 0.0

    lacking = shortfall(cube)
    if lacking <= 0.0:
        return
    sharpest = d.travel.forearm_angle_max
    fold, lowest = pi - sharpest.value, sharpest.position[2] * MM_PER_M
    # |AB|^2 = L_A^2 + L_B^2 - 2 L_A L_B cos(fold), of which a higher cube changes z^2 alone
    opened = 2.0 * long * forearm * max(cos(fold) - cos(_WIDEST_RAD), 0.0)
    bottom_mm = d.design.cube.bottom_height_mm + sqrt(lowest**2 + opened) - lowest
    if fold >= _WIDEST_RAD or shortfall(replace(cube, bottom_height=bottom_mm / MM_PER_M)) > 0.0:
        return  # no height parts them: it is not for the fold
    own = f"what holds {d.motor.id}, or their arm" if d.capstan is None else "their own drive, its arm or its sector"
    message = (
        f"rods that fold to {degrees(fold):.1f} deg, or springs across them, come within {least_mm - lacking:.2f} mm "
        f"of {own}; at least {least_mm:.2f}"
    )
    yield Reason("rod_tube", "beside the drive", message, (larger(BOTTOM), larger(FOREARM), smaller(ARM)))


# Ends of rods, turned about themselves, beside the bosses of the cross-bars that they hang on: elbow's and wrist's.
_RIM_POINTS = 48  # around a boss's end
_LEANS, _TURNS = 7, 9  # between none and the largest lean, and from one end of a turn to the other
_LONG_MM = 40.0  # of a tube that is looked at: farther out no boss comes near


def rod_end(f: ForearmDimensions) -> list[Shape]:
    """Lists the square stem of a rod's end and the tube behind it, in the rod's frame."""
    rod, x = f.tube_outer_mm / 2, np.array([1.0, 0.0, 0.0])
    stem = Block(np.eye(3), (0.0, 0.0, 0.0), (f.stem_mm, -rod, -rod), (f.shoulder_mm, rod, rod))
    return [stem, Bar(rod, _LONG_MM, f.shoulder_mm * x, x)]


def _rims(radius_mm: float, half_mm: float) -> np.ndarray:
    """(n, 3) both edges of a boss's bevelled end, its axis along y."""
    turns = np.linspace(0.0, 2.0 * np.pi, _RIM_POINTS, endpoint=False)
    rims = (radius_mm - BOSS_BEVEL_MM, half_mm), (radius_mm, half_mm - BOSS_BEVEL_MM)
    return np.concatenate([np.stack([r * np.cos(turns), 0.0 * turns + y, r * np.sin(turns)], axis=1) for r, y in rims])


def boss_clearance_mm(f: ForearmDimensions, radius_mm: float, length_mm: float, lean_rad: float) -> float:
    """Computes how near a rod's end comes to the end of its cross-bar's boss at leans up to one, mm.

    It leans towards the boss and is turned about itself as far as its joints let it.

    Args:
        f: The rods.
        radius_mm: Of the boss.
        length_mm: Of the boss.
        lean_rad: The largest lean.
    """
    rims = _rims(radius_mm, length_mm / 2) - np.array([0.0, f.width_mm / 2, 0.0])
    seen = []
    for lean in np.linspace(0.0, min(lean_rad, f.tilt_limit_rad), _LEANS):
        free = float(np.arccos(np.clip(cos(f.tilt_limit_rad) / cos(lean), -1.0, 1.0)))
        along = np.array([np.cos(lean), -np.sin(lean), 0.0])
        aside, up_ = np.array([np.sin(lean), np.cos(lean), 0.0]), np.array([0.0, 0.0, 1.0])
        for turn in np.linspace(-free, free, _TURNS):
            y, z = np.cos(turn) * aside + np.sin(turn) * up_, np.cos(turn) * up_ - np.sin(turn) * aside
            seen.append(rims @ np.stack([along, y, z], axis=1))
    return float(union_distance(rod_end(f), np.concatenate(seen)).min())


def _rod_boss_interference(d: Dimensions, least_mm: float) -> Iterator[Reason]:
    """Gives the reason why rods that lean and turn come too near to the elbow's boss.

    The wrist's boss follows from the same, see `delta_cad.dimensions.platform`.

    Args:
        d: The machine.
        least_mm: Least distance between them.
    """
    f, (low, high), lean = d.forearm, d.layers.elbow_boss_mm, d.travel.lean_max.value
    near = boss_clearance_mm(f, d.arm.boss_radius_mm, high - low, lean)
    if near >= least_mm:
        return
    message = (
        f"rods that lean by {degrees(lean):.1f} deg come within {near:.2f} mm of the arm's boss; at least "
        f"{least_mm:.2f}"
    )
    yield Reason("rod_cup", "beside its boss", message, (larger(WIDTH), larger(FOREARM)))


_CUPS_MM = 0.14  # beyond the clearance: what meshes of cups are off together
_SLID_MM = 0.1  # that a drive leaves its neighbour as it slides in

_Margin = Callable[[Dimensions, CapstanDimensions], float]
"""Margin of a machine; negative: its shortfall."""
_Form = Callable[[Dimensions, float], Iterable[Reason]]
"""A machine, what is to be left beyond what must be, mm -> reasons."""


def _least_mm(d: Dimensions) -> float:
    return d.design.requirements.clearance_min_mm + MESHES_MM


def _over_cube(kind: str) -> _Margin:
    """What "sector", "rod" or "spring" of another chain keep of a sector over the cube."""

    def margin(d: Dimensions, c: CapstanDimensions) -> float:
        return nearest(sector_clearance(d, c, kind), d.design.workspace) - _least_mm(d)

    return margin


def _springs(d: Dimensions, _: CapstanDimensions) -> float:
    """What springs of different chains keep of one another over the cube."""
    return nearest(spring_clearance(d), d.design.workspace, FEW) - _least_mm(d)


# Part, feature, in words, spare, whether it is an angle: what chains that stand farther out pass.
_CHAINS_APART: tuple[tuple[str, str, str, _Margin, bool], ...] = (
    ("pinion", "beside a neighbour's cheek", "mm apart", lambda d, c: pinion_clearance_mm(d, c) - _least_mm(d), False),
    ("sector", "beside a neighbour's cheek", "mm apart", lambda d, c: sector_clearance_mm(d, c) - _least_mm(d), False),
    ("motor", "on its way in", "mm from a cheek", lambda d, c: slide_in_clearance_mm(d, c) - _SLID_MM, False),
    ("motor_screw", "key", "deg free", lambda d, _: key_swing_rad(d) - SWING_RAD, True),
    ("sector", "beside a neighbour's", "mm apart", _over_cube("sector"), False),
    ("sector", "beside a neighbour's rods", "mm apart", _over_cube("rod"), False),
    ("sector", "beside a neighbour's springs", "mm apart", _over_cube("spring"), False),
    ("rod_spring", "beside a neighbour's", "mm apart", _springs, False),
)
_APART: tuple[Way, ...] = larger(BASE, PLATFORM), smaller(SECTOR)


def _chains(
    part: str, feature: str, words: str, margin: _Margin, is_angle: bool, d: Dimensions, margin_mm: float
) -> Iterator[Reason]:
    """Drives, sectors, rods of neighbours: chains farther out, at base and platform alike, pass one another."""
    if d.capstan is None or (lacking := -margin(d, d.capstan)) <= (0.0 if is_angle else -margin_mm):
        return
    shortfall = f"{degrees(lacking):.0f} deg less than a key needs" if is_angle else f"{lacking:.2f} {words} too few"
    yield Reason(part, feature, shortfall, (*_APART, larger(SECTOR)) if is_angle else _APART)


def _platform(d: Dimensions, margin_mm: float) -> Iterator[Reason]:
    """Lowered arms and sectors next to the platform's wrists: a higher cube clears them."""
    if d.capstan is None or (lacking := -_over_cube("platform")(d, d.capstan)) <= -margin_mm:
        return
    shortfall = f"the platform's wrists come {lacking:.2f} mm too near to arms with their sectors"
    yield Reason("platform", "beside a sector", shortfall, (larger(BOTTOM), smaller(SECTOR)))


def _sleeves(d: Dimensions) -> Iterator[Reason]:
    """Both ferrules of a cable on the paths to their seats, past the arm: a larger sector clears them."""
    if d.capstan is None or (reserve := ferrule_clearance_mm(d, d.capstan) - SLEEVE_OFF_MM) >= 0.0:
        return
    shortfall = f"a sleeve of the cable lacks {-reserve:.2f} mm to pass the arm on its way to its seat"
    yield Reason("crimp_sleeve", "beside the arm", shortfall, (larger(SECTOR, RATIO), larger(SECTOR)))


def _cups(d: Dimensions, margin_mm: float) -> Iterator[Reason]:
    """Cups of neighbouring wrists, the rods turned about themselves."""
    clear = d.design.requirements.clearance_min_mm
    reserve = cup_margin(d, clear + _CUPS_MM + margin_mm)
    if (lacking := -nearest(reserve, d.design.workspace, FEW)) <= 0.0:
        return
    message = f"cups of neighbouring rods that turn about themselves lack {lacking:.2f} mm of {clear + margin_mm:g}"
    ways = larger(PLATFORM), larger(BASE, PLATFORM), smaller(WIDTH)
    yield Reason("rod_cup", "beside a neighbour's", message, ways)


INTERFERENCE_FORMS: dict[str, _Form] = {
    "sleeves": lambda d, _: _sleeves(d),
    **{f"{one[0]} {one[1]}": partial(_chains, *one) for one in _CHAINS_APART},
    "platform": _platform,
    "rod beside boss": lambda d, margin_mm: _rod_boss_interference(d, _least_mm(d) + margin_mm),
    "folded": lambda d, margin_mm: fold_interference(d, _least_mm(d) + margin_mm),
    "cups": _cups,
}
"""Every form, by its name.

All shapes lie within the solids, and positions are sampled: what is refused fails, by up to `MESHES_MM` of what meshes
are off; what passes may still fail.
"""
