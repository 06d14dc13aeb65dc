"""Interference before CAD: which parts are too close, one closed form for each pair, and the fields that change it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from math import degrees

from delta_cad.dimensions import Dimensions, Reason
from delta_cad.dimensions.bracket import MESHES_MM
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.layers import SWING_RAD
from delta_cad.dimensions.rules import BASE, BOTTOM, PLATFORM, RATIO, SECTOR, WIDTH, Way, larger, smaller
from delta_cad.interference.ferrule_insertion import ferrule_clearance_mm
from delta_cad.interference.moving_bodies import FEW, cup_margin, nearest, sector_clearance, spring_clearance
from delta_cad.interference.rod_vs_boss import rod_boss_interference
from delta_cad.interference.rod_vs_drive import fold_interference
from delta_cad.interference.static_obstacles import (
    key_swing_rad,
    pinion_clearance_mm,
    sector_clearance_mm,
    slide_in_clearance_mm,
)

CUPS_MM = 0.14  # beyond the clearance: what meshes of cups are off together
SLID_MM = 0.1  # that a drive leaves its neighbour as it slides in
SLEEVE_OFF_MM = -0.5  # that a sleeve leaves the arm on its way: the arm's edges are broken

Margin = Callable[[Dimensions, CapstanDimensions], float]
"""Margin of a machine; negative: its shortfall."""
Form = Callable[[Dimensions, float], Iterable[Reason]]
"""A machine, what is to be left beyond what must be, mm -> reasons."""


def interference_reasons(d: Dimensions, margin_mm: float = 0.0) -> list[Reason]:
    """Gives every reason why parts of neighbouring chains, sleeves and the arm, or rods and their drive cannot pass.

    All shapes lie within the solids, and positions are sampled: what is refused fails, by up to `MESHES_MM` of what
    meshes are off; what passes may still fail.

    Args:
        d: The machine.
        margin_mm: What is to be left beyond what must be.
    """
    return [reason for form in PASSING.values() for reason in form(d, margin_mm)]


def _least_mm(d: Dimensions) -> float:
    return d.design.requirements.clearance_min_mm + MESHES_MM


def _over_cube(kind: str) -> Margin:
    """What "sector", "rod" or "spring" of another chain keep of a sector over the cube."""

    def margin(d: Dimensions, c: CapstanDimensions) -> float:
        cube = d.design.cube
        return nearest(sector_clearance(d, c, kind), cube.bottom_height_mm, cube.half_side_mm) - _least_mm(d)

    return margin


def _springs(d: Dimensions, _: CapstanDimensions) -> float:
    """What springs of different chains keep of one another over the cube."""
    cube = d.design.cube
    return nearest(spring_clearance(d), cube.bottom_height_mm, cube.half_side_mm, FEW) - _least_mm(d)


# Part, feature, in words, spare, whether it is an angle: what chains that stand farther out pass.
CHAINS_APART: tuple[tuple[str, str, str, Margin, bool], ...] = (
    ("pinion", "beside a neighbour's cheek", "mm apart", lambda d, c: pinion_clearance_mm(d, c) - _least_mm(d), False),
    ("sector", "beside a neighbour's cheek", "mm apart", lambda d, c: sector_clearance_mm(d, c) - _least_mm(d), False),
    ("motor", "on its way in", "mm from a cheek", lambda d, c: slide_in_clearance_mm(d, c) - SLID_MM, False),
    ("motor_screw", "key", "deg free", lambda d, _: key_swing_rad(d) - SWING_RAD, True),
    ("sector", "beside a neighbour's", "mm apart", _over_cube("sector"), False),
    ("sector", "beside a neighbour's rods", "mm apart", _over_cube("rod"), False),
    ("sector", "beside a neighbour's springs", "mm apart", _over_cube("spring"), False),
    ("rod_spring", "beside a neighbour's", "mm apart", _springs, False),
)
APART: tuple[Way, ...] = larger(BASE, PLATFORM), smaller(SECTOR)


def _chains(
    part: str, feature: str, words: str, margin: Margin, is_angle: bool, d: Dimensions, margin_mm: float
) -> Iterator[Reason]:
    """Drives, sectors, rods of neighbours: chains farther out, at base and platform alike, pass one another."""
    if d.capstan is None or (lacking := -margin(d, d.capstan)) <= (0.0 if is_angle else -margin_mm):
        return
    lacks = f"{degrees(lacking):.0f} deg less than a key needs" if is_angle else f"{lacking:.2f} {words} too few"
    yield Reason(part, feature, lacks, (*APART, larger(SECTOR)) if is_angle else APART)


def _platform(d: Dimensions, margin_mm: float) -> Iterator[Reason]:
    """Lowered arms and sectors next to the platform's wrists: a higher cube clears them."""
    if d.capstan is None or (lacking := -_over_cube("platform")(d, d.capstan)) <= -margin_mm:
        return
    lacks = f"the platform's wrists come {lacking:.2f} mm too near to arms with their sectors"
    yield Reason("platform", "beside a sector", lacks, (larger(BOTTOM), smaller(SECTOR)))


def _sleeves(d: Dimensions) -> Iterator[Reason]:
    """Both ferrules of a cable on the paths to their seats, past the arm: a larger sector clears them."""
    if d.capstan is None or (spare := ferrule_clearance_mm(d, d.capstan) - SLEEVE_OFF_MM) >= 0.0:
        return
    lacks = f"a sleeve of the cable lacks {-spare:.2f} mm to pass the arm on its way to its seat"
    yield Reason("crimp_sleeve", "beside the arm", lacks, (larger(SECTOR, RATIO), larger(SECTOR)))


def _cups(d: Dimensions, margin_mm: float) -> Iterator[Reason]:
    """Cups of neighbouring wrists, the rods turned about themselves."""
    cube, clear = d.design.cube, d.design.requirements.clearance_min_mm
    spare = cup_margin(d, clear + CUPS_MM + margin_mm)
    if (lacking := -nearest(spare, cube.bottom_height_mm, cube.half_side_mm, FEW)) <= 0.0:
        return
    message = f"cups of neighbouring rods that turn about themselves lack {lacking:.2f} mm of {clear + margin_mm:g}"
    ways = larger(PLATFORM), larger(BASE, PLATFORM), smaller(WIDTH)
    yield Reason("rod_cup", "beside a neighbour's", message, ways)


PASSING: dict[str, Form] = {
    "sleeves": lambda d, _: _sleeves(d),
    **{f"{one[0]} {one[1]}": partial(_chains, *one) for one in CHAINS_APART},
    "platform": _platform,
    "rod beside boss": lambda d, margin_mm: rod_boss_interference(d, _least_mm(d) + margin_mm),
    "folded": lambda d, margin_mm: fold_interference(d, _least_mm(d) + margin_mm),
    "cups": _cups,
}
"""Every form, by its name."""
