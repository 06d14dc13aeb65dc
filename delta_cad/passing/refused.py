"""Why parts that come too close to others of the machine are refused, one form a pair of things that pass."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from functools import partial
from math import degrees, inf, sqrt

from delta_cad.design import Design
from delta_cad.dimensions import DimensionError, Dimensions, Reason, dimensions, spread
from delta_cad.dimensions.bracket import MESHES_MM
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.rules import BASE, BOTTOM, PLATFORM, RATIO, SECTOR, WIDTH, Way, larger, smaller
from delta_cad.mechanism import MechanismError
from delta_cad.passing.folding import folded
from delta_cad.passing.hanging import hanging
from delta_cad.passing.moving import COUNT, FEW, beside_sectors, beside_springs, nearest, spare_of_cups
from delta_cad.passing.sleeves import sleeves_off_mm
from delta_cad.passing.standing import SWING_RAD, key_swing_rad, pinion_off_mm, sector_off_mm, sliding_off_mm

CUPS_MM = 0.14  # beyond the clearance: what meshes of cups are off together
SLID_MM = 0.1  # that a drive leaves its neighbour as it slides in
SLEEVE_OFF_MM = -0.5  # that a sleeve leaves the arm on its way: the arm's edges are broken
FARTHEST_MM = 32.0  # that chains are estimated to stand farther out, at most
NEAR_MM, NEAR_SHARE = 0.1, 0.07  # to which that is looked for, and of it for keys
FASTEST = 2.0  # mm that neighbours part by at most, and some, for each by which they stand farther out
SLOWEST = 0.7  # that is taken to be so, where what overlaps tells no distance
ON_MM = 0.05
WIDER, WIDEST = 1.02, 2.5  # steps of a sector's radius, and the most it is estimated to grow
KEY_WIDER, KEY_WIDEST = 1.05, 1.6  # the same for keys

Spare = Callable[[Dimensions, CapstanDimensions, int], float]
"""What a machine has more than it must, by so many positions along an edge of its cube; negative: what it lacks."""
Form = Callable[[Dimensions, float, bool], Iterable[Reason]]
"""A machine, what is to be left beyond what must be, mm, and whether a search's estimates are computed -> reasons."""


def passing(d: Dimensions, margin_mm: float = 0.0, estimated: bool = False) -> list[Reason]:
    """Gives every reason why parts of neighbouring chains, sleeves and the arm, or rods and their drive cannot pass.

    All shapes lie within the solids, and positions are sampled: what is refused fails, by up to `MESHES_MM` of what
    meshes are off; what passes may still fail.

    Args:
        d: The machine.
        margin_mm: What is to be left beyond what must be.
        estimated: Whether reasons carry a search's estimates of what is enough.
    """
    return [reason for form in PASSING.values() for reason in form(d, margin_mm, estimated)]


def _least_mm(d: Dimensions) -> float:
    return d.design.requirements.clearance_min_mm + MESHES_MM


def _over_cube(kind: str) -> Spare:
    """What "sector", "rod" or "spring" of another chain keep of a sector over the cube."""

    def spare(d: Dimensions, c: CapstanDimensions, count: int) -> float:
        cube = d.design.cube
        return nearest(beside_sectors(d, c, kind), cube.bottom_height_mm, cube.half_side_mm, count) - _least_mm(d)

    return spare


def _springs(d: Dimensions, _: CapstanDimensions, count: int) -> float:
    """What springs of different chains keep of one another over the cube."""
    cube = d.design.cube
    return nearest(beside_springs(d), cube.bottom_height_mm, cube.half_side_mm, min(count, FEW)) - _least_mm(d)


# Part, feature, in words, spare, whether it is an angle: what chains that stand farther out pass.
CHAINS_APART: tuple[tuple[str, str, str, Spare, bool], ...] = (
    ("pinion", "beside a neighbour's cheek", "mm apart", lambda d, c, _: pinion_off_mm(d, c) - _least_mm(d), False),
    ("sector", "beside a neighbour's cheek", "mm apart", lambda d, c, _: sector_off_mm(d, c) - _least_mm(d), False),
    ("motor", "on its way in", "mm from a cheek", lambda d, c, _: sliding_off_mm(d, c) - SLID_MM, False),
    ("motor_screw", "key", "deg free", lambda d, _, count: key_swing_rad(d, count == COUNT) - SWING_RAD, True),
    ("sector", "beside a neighbour's", "mm apart", _over_cube("sector"), False),
    ("sector", "beside a neighbour's rods", "mm apart", _over_cube("rod"), False),
    ("sector", "beside a neighbour's springs", "mm apart", _over_cube("spring"), False),
    ("rod_spring", "beside a neighbour's", "mm apart", _springs, False),
)
APART: tuple[Way, ...] = larger(BASE, PLATFORM), smaller(SECTOR)


def _chains(
    part: str, feature: str, words: str, spare: Spare, is_angle: bool, d: Dimensions, margin_mm: float, estimated: bool
) -> Iterator[Reason]:
    """Drives, sectors, rods of neighbours: chains farther out, at base and platform alike, pass one another."""
    if d.capstan is None:
        return
    lacking, held = -spare(d, d.capstan, COUNT), d.design.mechanism.base_radius_mm
    if lacking <= (0.0 if is_angle else -margin_mm):
        return
    lacks = f"{degrees(lacking):.0f} deg less than a key needs" if is_angle else f"{lacking:.2f} {words} too few"
    found = Reason(part, feature, lacks, BASE, held, ways=(*APART, larger(SECTOR)) if is_angle else APART)
    if not estimated:
        yield found
    elif (more := _farther_mm(d, spare, lacking, is_angle)) is not None:
        yield replace(found, bound=held + more)
    elif is_angle:  # a motor that stands so near that its own arm's sector covers its screws at any angle
        sector = d.design.hardware.sector_radius_mm
        share = _growth(d.design, ("sector_radius_mm",), lambda d, c: spare(d, c, FEW) >= 0.0, KEY_WIDER, KEY_WIDEST)
        covered = ("", None, None) if share is None else (SECTOR, sector, sector * share)
        yield Reason(part, feature, lacks, *covered)
    else:
        yield Reason(part, feature, lacks)


def _platform(d: Dimensions, margin_mm: float, estimated: bool) -> Iterator[Reason]:
    """Arms and sectors that stand down beside the platform's wrists: a higher cube passes them."""
    spare, bottom = _over_cube("platform"), d.design.cube.bottom_height_mm
    if d.capstan is None or (lacking := -spare(d, d.capstan, COUNT)) <= -margin_mm:
        return

    def of(more_mm: float, count: int) -> float:
        cube = d.design.cube.model_copy(update={"bottom_height_mm": bottom + more_mm})
        try:
            higher = dimensions(d.design.model_copy(update={"cube": cube}))
        except (DimensionError, MechanismError):
            return -inf
        return -inf if higher.capstan is None else spare(higher, higher.capstan, count)

    more = _first_distance(of, lacking) if estimated else None
    lacks = f"the platform's wrists come {lacking:.2f} mm too near to arms with their sectors"
    held, bound = (None, None) if more is None else (bottom, bottom + more)
    yield Reason("platform", "beside a sector", lacks, BOTTOM, held, bound, ways=(larger(BOTTOM), smaller(SECTOR)))


def _farther_mm(d: Dimensions, spare: Spare, lacking: float, is_angle: bool) -> float | None:
    """By how much chains must stand farther out for something to have what it must; None: by too much."""

    def of(more_mm: float, count: int) -> float:
        try:
            farther = spread(d, more_mm)
        except DimensionError:
            return -inf
        return -inf if farther.capstan is None else spare(farther, farther.capstan, count)

    high = _first_angle(of) if is_angle else _first_distance(of, lacking)
    if high is None:
        return None
    while (still := -of(high, COUNT)) > 0.0:  # what few positions did not see
        high += still + ON_MM
        if high > FARTHEST_MM:
            return None
    return high


def _first_angle(of: Callable[[float, int], float]) -> float | None:
    """About the least by which chains must stand farther out for a key to swing, which goes in steps: bisection."""
    low, high = 0.0, 1.0
    while of(high, FEW) < 0.0:
        low, high = high, 2.0 * high
        if high > FARTHEST_MM:
            return None
    while high - low > max(NEAR_MM, high * NEAR_SHARE):
        middle = (low + high) / 2.0
        low, high = (middle, high) if of(middle, FEW) < 0.0 else (low, middle)
    return high


def _first_distance(of: Callable[[float, int], float], lacking: float) -> float | None:
    """The same for a distance, which grows by up to `FASTEST` mm with each: secants from below, then between both."""
    low, short, high, slope = 0.0, -lacking, inf, FASTEST
    while (more := low + max(NEAR_MM / 2.0 - short, NEAR_MM) / slope) <= FARTHEST_MM:
        more = min(more, (low + high) / 2.0)
        now = of(more, FEW)
        if now >= 0.0:
            high = more
        else:
            slope = min(max((now - short) / (more - low), SLOWEST), FASTEST)
            low, short = more, now
        if high - low <= NEAR_MM or 0.0 <= now <= NEAR_MM:
            return high
    return None


def _sleeves(d: Dimensions, _margin_mm: float, estimated: bool) -> Iterator[Reason]:
    """Both sleeves of a cable on their ways to their seats, beside the arm: a larger sector passes them."""
    if d.capstan is None or (spare := sleeves_off_mm(d, d.capstan) - SLEEVE_OFF_MM) >= 0.0:
        return
    names, held, bound = ("sector_radius_mm", "capstan_ratio"), d.design.hardware.sector_radius_mm, None
    if estimated:
        share = _growth(d.design, names, lambda d, c: sleeves_off_mm(d, c) >= SLEEVE_OFF_MM)
        held, bound = (None, None) if share is None else (held, held * share)
    lacks = f"a sleeve of the cable lacks {-spare:.2f} mm to pass the arm on its way to its seat"
    ways = larger(SECTOR, RATIO), larger(SECTOR)
    yield Reason("crimp_sleeve", "beside the arm", lacks, SECTOR, held, bound, ways=ways)


def _growth(
    design: Design,
    names: tuple[str, ...],
    does: Callable[[Dimensions, CapstanDimensions], bool],
    step: float = WIDER,
    most: float = WIDEST,
) -> float | None:
    """By how many times sector, or sector and ratio, must be larger for something to pass; None: by too many."""
    share, h = step, design.hardware
    while share < most:
        try:
            grown = h.model_copy(update={name: getattr(h, name) * share for name in names})
            larger = dimensions(design.model_copy(update={"hardware": grown}))
        except DimensionError:
            pass
        else:
            if larger.capstan is not None and does(larger, larger.capstan):
                return share
        share *= step
    return None


def _cups(d: Dimensions, margin_mm: float, _estimated: bool) -> Iterator[Reason]:
    """Cups of neighbouring wrists, the rods turned about themselves."""
    cube, clear = d.design.cube, d.design.requirements.clearance_min_mm
    spare = spare_of_cups(d, clear + CUPS_MM + margin_mm)
    if (lacking := -nearest(spare, cube.bottom_height_mm, cube.half_side_mm, FEW)) <= 0.0:
        return
    held = d.design.mechanism.platform_radius_mm
    message = f"cups of neighbouring rods that turn about themselves lack {lacking:.2f} mm of {clear + margin_mm:g}"
    ways = larger(BASE, PLATFORM), larger(PLATFORM), smaller(WIDTH)
    yield Reason("rod_cup", "beside a neighbour's", message, PLATFORM, held, held + lacking / sqrt(3.0), ways=ways)


PASSING: dict[str, Form] = {
    "sleeves": _sleeves,
    **{f"{one[0]} {one[1]}": partial(_chains, *one) for one in CHAINS_APART},
    "platform": _platform,
    "hanging": lambda d, margin_mm, _: hanging(d, _least_mm(d) + margin_mm),
    "folded": lambda d, margin_mm, estimated: folded(d, _least_mm(d) + margin_mm, estimated),
    "cups": _cups,
}
"""Every form, by its name."""
