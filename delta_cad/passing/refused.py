"""Why parts that come too close to others cannot do, and what would: chains farther out, as a rule."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import degrees, inf, sqrt

from delta_cad.design import Design
from delta_cad.dimensions import DimensionError, Dimensions, Reason, dimensions, spread
from delta_cad.dimensions.bracket import MESHES_MM
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.rules import up
from delta_cad.mechanism import MechanismError
from delta_cad.passing.folding import folded
from delta_cad.passing.hanging import hanging
from delta_cad.passing.moving import COUNT, FEW, beside_sectors, beside_springs, nearest, spare_of_cups
from delta_cad.passing.sleeves import sleeves_off_mm
from delta_cad.passing.standing import SWING_RAD, key_swing_rad, pinion_off_mm, sector_off_mm, sliding_off_mm

CUPS_MM = 0.14  # beyond the clearance: what meshes of cups are off together
SLID_MM = 0.1  # that a drive leaves its neighbour as it slides in
SLEEVE_OFF_MM = -0.5  # that a sleeve leaves the arm on its way: the arm's edges are broken
FARTHEST_MM = 32.0  # that chains may be asked to stand farther out
NEAR_MM, NEAR_SHARE = 0.1, 0.07  # to which that is looked for, and of it for keys
FASTEST = 2.0  # mm that neighbours part by at most, and some, for each by which they stand farther out
SLOWEST = 0.7  # that is taken to be so, where what overlaps tells no distance
ON_MM = 0.05
WIDER, WIDEST = 1.02, 2.5  # steps of a sector's radius, and the most it is asked to grow
KEY_WIDER, KEY_WIDEST = 1.05, 1.6  # the same for keys

Spare = Callable[[Dimensions, CapstanDimensions, int], float]
"""What a machine has more than it must, by so many positions along an edge of its cube; negative: what it lacks."""


def passing(d: Dimensions, spare_mm: float = 0.0, aim_mm: float = 0.0) -> list[Reason]:
    """Gives every reason why parts of neighbouring chains, sleeves and the arm, or rods and their drive cannot pass.

    All shapes lie within the solids, and positions are sampled: what is refused fails, by up to `MESHES_MM` of what
    meshes are off; what passes may still fail.

    Args:
        d: The machine.
        spare_mm: What is to be left beyond what must be.
        aim_mm: What a value that is told leaves, where anything is refused.
    """
    least = _least_mm(d) + spare_mm
    own = [*hanging(d, least, max(aim_mm - spare_mm, 0.0)), *folded(d, least), *_cups(d, spare_mm, aim_mm)]
    if (c := d.capstan) is None:
        return own
    return [*_sleeves(d, c), *_chains(d, c, spare_mm, aim_mm), *_platform(d, c, spare_mm, aim_mm), *own]


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


# Part, feature, in words, spare, whether it is an angle: what chains that stand farther out mend.
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


def _chains(d: Dimensions, c: CapstanDimensions, spare_mm: float, aim_mm: float) -> Iterator[Reason]:
    """Drives, sectors, rods of neighbours: chains farther out, at base and platform alike, pass one another."""
    m = d.design.mechanism
    for part, feature, words, spare, is_angle in CHAINS_APART:
        lacking = -spare(d, c, COUNT)
        if lacking <= (0.0 if is_angle else -spare_mm):
            continue
        field, held = "mechanism.base_radius_mm", m.base_radius_mm
        more = _farther_mm(d, spare, lacking, 0.0 if is_angle else aim_mm, is_angle)
        lacks = f"{degrees(lacking):.0f} deg less than a key needs" if is_angle else f"{lacking:.2f} {words} too few"
        if more is None:
            yield _covered(d, part, feature, lacks, spare) if is_angle else _too_large(d, part, feature, lacks)
            continue
        message = (
            f"base_radius_mm = {held:g} must be at least {up(held + more)} mm with platform_radius_mm at least "
            f"{up(m.platform_radius_mm + more)}, or the sector smaller: {lacks}"
        )
        beside = (("mechanism.platform_radius_mm", m.platform_radius_mm + more),)
        yield Reason(part, feature, message, field, held, held + more, beside)


def _too_large(d: Dimensions, part: str, feature: str, lacks: str) -> Reason:
    message = f"hardware.sector_radius_mm = {d.design.hardware.sector_radius_mm:g}: {lacks}; a smaller one, or "
    return Reason(part, feature, f"{message}another hardware.motor")


def _covered(d: Dimensions, part: str, feature: str, lacks: str, spare: Spare) -> Reason:
    """A motor that stands so near that its own arm's sector covers its screws at any angle: a larger pinion."""
    field, held = "hardware.sector_radius_mm", d.design.hardware.sector_radius_mm
    share = _growth(d.design, ("sector_radius_mm",), lambda d, c: spare(d, c, FEW) >= 0.0, KEY_WIDER, KEY_WIDEST)
    if share is None:
        return Reason(part, feature, f"{field} = {held:g}: {lacks}; another hardware.motor")
    message = f"{field} = {held:g} must be at least {up(held * share)} mm, or capstan_ratio less: {lacks}"
    return Reason(part, feature, message, field, held, held * share)


def _platform(d: Dimensions, c: CapstanDimensions, spare_mm: float, aim_mm: float) -> Iterator[Reason]:
    """Arms and sectors that stand down beside the platform's wrists: a higher cube passes them."""
    spare, field, bottom = _over_cube("platform"), "cube.bottom_height_mm", d.design.cube.bottom_height_mm
    lacking = -spare(d, c, COUNT)
    if lacking <= -spare_mm:
        return

    def of(more_mm: float, count: int) -> float:
        cube = d.design.cube.model_copy(update={"bottom_height_mm": bottom + more_mm})
        try:
            higher = dimensions(d.design.model_copy(update={"cube": cube}))
        except (DimensionError, MechanismError):
            return -inf
        return -inf if higher.capstan is None else spare(higher, higher.capstan, count) - aim_mm

    more = _first_distance(of, lacking + aim_mm)
    lacks = f"the platform's wrists come {lacking:.2f} mm too near to arms with their sectors"
    sector = f"hardware.sector_radius_mm = {d.design.hardware.sector_radius_mm:g}"
    if more is None:
        yield Reason("platform", "beside a sector", f"{sector}: {lacks}; a smaller one, or another cube", field)
        return
    message = f"{field} = {bottom:g} must be at least {up(bottom + more)} mm, or {sector} less: {lacks}"
    yield Reason("platform", "beside a sector", message, field, bottom, bottom + more)


def _farther_mm(d: Dimensions, spare: Spare, lacking: float, aim: float, is_angle: bool) -> float | None:
    """By how much chains must stand farther out for something to have what it must and more; None: by too much."""

    def of(more_mm: float, count: int) -> float:
        try:
            farther = spread(d, more_mm)
        except DimensionError:
            return -inf
        return -inf if farther.capstan is None else spare(farther, farther.capstan, count) - aim

    high = _first_angle(of) if is_angle else _first_distance(of, lacking + aim)
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


def _sleeves(d: Dimensions, c: CapstanDimensions) -> Iterator[Reason]:
    """Both sleeves of a cable on their ways to their seats, beside the arm: a larger sector passes them."""
    spare = sleeves_off_mm(d, c) - SLEEVE_OFF_MM
    if spare >= 0.0:
        return
    h, part, feature = d.design.hardware, "crimp_sleeve", "beside the arm"
    lacks = f"a sleeve of the cable lacks {-spare:.2f} mm to pass the arm on its way to its seat"
    share = _growth(d.design, ("sector_radius_mm", "capstan_ratio"), lambda d, c: sleeves_off_mm(d, c) >= SLEEVE_OFF_MM)
    field = "hardware.sector_radius_mm"
    if share is None:
        yield Reason(part, feature, f"{field} = {h.sector_radius_mm:g}, a larger one: {lacks}", field)
        return
    radius, ratio = h.sector_radius_mm * share, h.capstan_ratio * share
    message = (
        f"{field} = {h.sector_radius_mm:g} must be at least {up(radius)} mm with capstan_ratio at least {up(ratio)}: "
        f"{lacks}"
    )
    beside = (("hardware.capstan_ratio", ratio),)
    yield Reason(part, feature, message, field, h.sector_radius_mm, radius, beside)


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


def _cups(d: Dimensions, spare_mm: float, aim_mm: float) -> list[Reason]:
    """Cups of neighbouring wrists, the rods turned about themselves."""
    m, cube, clear = d.design.mechanism, d.design.cube, d.design.requirements.clearance_min_mm

    def spare(more_mm: float) -> float:
        needed = clear + CUPS_MM + more_mm
        return nearest(spare_of_cups(d, needed), cube.bottom_height_mm, cube.half_side_mm, FEW)

    if (lacking := -spare(0.0)) <= 0.0 and (not spare_mm or spare(spare_mm) >= 0.0):
        return []
    more = -spare(aim_mm) / sqrt(3.0)
    field, held = "mechanism.platform_radius_mm", m.platform_radius_mm
    message = (
        f"platform_radius_mm = {held:g} must be at least {up(held + more)} mm with base_radius_mm at least "
        f"{up(m.base_radius_mm + more)}: cups of neighbouring rods that turn about themselves lack {lacking:.2f} mm of "
        f"{clear:g}"
    )
    beside = (("mechanism.base_radius_mm", m.base_radius_mm + more),)
    return [Reason("rod_cup", "beside a neighbour's", message, field, held, held + more, beside)]
