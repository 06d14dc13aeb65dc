"""Why a design's hardware cannot do, in closed form and all at once: no solid is made, only samples are posed.

Six kinds: a platform that hangs below its elbows, beside which nothing else is told; parts that cannot be given sound
dimensions; a drive that gives too little or breaks its cable; an outline that elbows or motors alone exceed; a cable
whose plane or length no tolerances hold; loads that parts or drives may not bear even if what moves weighed
as little as it can. Each is necessary: what passes here may still fail a check.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import cos

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.record import CAPSTAN_RATIO_LEAST, CAPSTAN_RATIO_MOST, SECTOR_LEAST_MM, SECTOR_MOST_MM
from delta_cad.dimensions import DimensionError, Dimensions, Reason, dimensions
from delta_cad.dimensions.capstan import ROPE_FACTOR, CapstanDimensions, thinnest_pinion_mm
from delta_cad.dimensions.rules import down, up
from delta_cad.dimensions.tolerances.cable import plane_chain, travel_chain
from delta_cad.dimensions.tolerances.general import CLASSES
from delta_cad.drive import drive_torque
from delta_cad.drive.report import BEND_LEAST_SHARE
from delta_cad.mechanism import direct_margin, reach_excess
from delta_cad.mechanism.geometry import RADIAL
from delta_cad.mechanism.inverse import forearm_vectors
from delta_cad.mechanism.placement import CHAINS, chain_frame
from delta_cad.passing.refused import passing
from delta_cad.structure.hardware.overloads import overloads
from delta_cad.structure.hardware.would_do import HEAVIER, border, named, one, rows
from delta_cad.structure.loads import sampled_mm

PROVEN_MM = 0.3  # beyond clearance and meshes: with 0.16 proofs were still undecided
COUNT = 5  # positions along an edge of the cube, its corners among them
SCANNED = 100  # radii of a sector
HEIGHTS = 41  # of a cube up to where it is out of reach
WIDER = 1.5  # times a sector's radius that it may be asked to have


@dataclass(frozen=True)
class Asked:
    """What a machine is held to.

    Attributes:
        weighed: How many times what moves at least is taken to weigh; 0: nothing weighs anything.
        spare_mm: What is to be left between what passes, beyond the clearance.
        aim_mm: What values that are told leave there.
    """

    weighed: float
    spare_mm: float
    aim_mm: float


NECESSARY = Asked(1.0, 0.0, PROVEN_MM)
"""What no machine does without: what is refused would fail."""
SURE = Asked(HEAVIER, 2.0 / 3.0 * PROVEN_MM, PROVEN_MM)
"""What values that are told are held to, so that solids pass, too."""
LEARNT = Asked(0.0, 0.0, 0.0)
"""What a search is told that learns weights and distances from solids."""


def refusals(design: Design, asked: Asked = NECESSARY) -> tuple[Reason, ...]:
    """Gives every reason why a design's hardware cannot do; none where it may.

    Args:
        design: A validated design.
        asked: What it is held to.

    Returns:
        Reasons, each with the field to change, its value and what would do.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    if hanging := _mode(design):  # parts, loads and advice would be about another machine than the forward kinematics'
        return hanging
    found = [*_turning(design), *_drive(design)]
    try:
        d = dimensions(design)
    except DimensionError as error:
        return (*(_with_motors(design, reason) for reason in error.reasons), *found)
    return (
        *found,
        *_outline(d),
        *_cable_plane(d),
        *_cable_travel(d),
        *passing(d, asked.spare_mm, asked.aim_mm),
        *overloads(d, asked.weighed),
    )


def _mode(design: Design) -> tuple[Reason, ...]:
    """The assembly mode where it is not the machine's own, of a cube that can be reached."""
    cube, field = design.cube, "cube.bottom_height_mm"
    positions = sampled_mm(cube.bottom_height_mm, cube.half_side_mm, COUNT)
    margins = direct_margin(design.geometry, positions / MM_PER_M)
    if margins.min() > 0.0 or reach_excess(design.geometry, positions / MM_PER_M).max() > 0.0:
        return ()
    x, y, z = (round(float(v), 1) + 0.0 for v in positions[np.argmin(margins)])  # no -0.0
    told = (
        f"{field} = {cube.bottom_height_mm:g} must be higher, or the forearms longer: det S > 0, the platform above "
        f"the elbows, is asked at every position, also at ({x:.1f}, {y:.1f}, {z:.1f}) mm"
    )
    return (Reason("cube", "assembly mode", told, field, cube.bottom_height_mm),)


def _turning(design: Design) -> Iterator[Reason]:
    """A constraint singularity inside the cube, where no rod holds the platform against turning: a higher cube."""
    cube, field = design.cube, "cube.bottom_height_mm"

    def positions(bottom_mm: float) -> np.ndarray:
        return sampled_mm(bottom_mm, cube.half_side_mm) / MM_PER_M

    def turns_at(bottom_mm: float) -> bool:
        """Whether the determinant of the couples that rods bear, README (48), changes its sign."""
        rods = forearm_vectors(design.geometry, positions(bottom_mm))
        (r1, r2, r3), (v1, v2, v3) = np.moveaxis((rods * RADIAL).sum(axis=-1), -1, 0), np.moveaxis(rods[..., 2], -1, 0)
        held = r1 * v2 * v3 + v1 * r2 * v3 + v1 * v2 * r3
        return bool(held.min() <= 0.0 <= held.max())

    if not turns_at(cube.bottom_height_mm):
        return
    top = MM_PER_M * (design.geometry.upper_arm_length + design.geometry.forearm_length)
    bad, bound = cube.bottom_height_mm, None
    for bottom in np.linspace(cube.bottom_height_mm, top, HEIGHTS)[1:].tolist():
        if reach_excess(design.geometry, positions(bottom)).max() > 0.0:
            break
        if not turns_at(bottom):
            bound = border(lambda mm: not turns_at(mm), bad, bottom)
            break
        bad = bottom
    asked = "another cube" if bound is None else f"at least {up(bound)} mm"
    told = f"{field} = {cube.bottom_height_mm:g} must be {asked}: somewhere in it rods let the platform turn"
    yield Reason("platform", "turning", told, field, cube.bottom_height_mm, bound)


def _drive(design: Design) -> list[Reason]:
    """Continuous and peak torque, the cable's strength and bend."""
    drive, h = drive_torque(design), design.hardware
    found: list[Reason] = []
    asked = (
        ("continuous", drive.continuous_torque_N_m, drive.required_torque_N_m, "nominal_torque_N_m"),
        ("peak", drive.peak_torque_N_m, drive.required_peak_N_m, "peak_torque_N_m"),
    )
    for words, value, required, column in asked:
        if value >= required:
            continue
        needed = required / (drive.ratio * drive.efficiency)
        others = rows("motor", design, lambda row, c=column, n=needed: getattr(row, c) >= n and h.drive in row.drives)
        advice, beside = f"a motor of at least {up(needed)} N m {words}{named(others)}", ()
        lasts = words == "continuous" or design.requirements.peak_torque_N_m is None
        least = f"requirements.{'joint' if lasts else 'peak'}_torque_N_m"
        ratio = drive.ratio * required / value
        highest = _ratio_most(design) if h.drive == "capstan" else 0.0
        if ratio <= highest:
            message = f"hardware.capstan_ratio = {h.capstan_ratio:g} must be at least {up(ratio)}, or {advice}"
            bound, field, held = ratio, "hardware.capstan_ratio", h.capstan_ratio
        else:
            if highest:
                advice += f", for hardware.capstan_ratio = {ratio:.4g} is out of reach: "
                advice += f"at most {down(highest)} on this sector"
            bound, field, held, beside = needed, "hardware.motor", h.motor, one("motor", others)
            message = f"hardware.motor = {h.motor} must be {advice}"
        told = f"{message}, or {least} at most {down(value)}: {value:.4g} of {required:.4g} N m at the joint, {words}"
        found.append(Reason("drive", f"{words} torque", told, field, held, bound, beside, (least, value)))
    tension, ratio, least = drive.cable_tension_N, drive.bend_ratio, drive.bend_ratio_least
    if tension is None or ratio is None or least is None:
        return found
    cable = catalogue.cable.chosen(h)
    if cable.breaking_load_N < ROPE_FACTOR * tension:
        needed = ROPE_FACTOR * tension
        others = rows("cable", design, lambda row: row.breaking_load_N >= needed)
        told = f"hardware.cable = {h.cable} must have a breaking load of at least {up(needed)} N{named(others)}"
        found.append(Reason("cable", "strength", told, "hardware.cable", h.cable, needed, one("cable", others)))
    if ratio < least:
        more = (least + 1.0) / (ratio + 1.0)
        radius, less = h.sector_radius_mm * more, h.capstan_ratio / more
        others = rows("cable", design, lambda row: _bend(h.sector_radius_mm / h.capstan_ratio, row) >= 0.0)
        if radius <= SECTOR_MOST_MM:
            field, held, bound, asked = (
                "hardware.sector_radius_mm",
                h.sector_radius_mm,
                radius,
                f"at least {up(radius)} mm",
            )
            beside = f"capstan_ratio = {h.capstan_ratio:g}"
        else:
            field, held, bound, asked = "hardware.capstan_ratio", h.capstan_ratio, less, f"at most {down(less)}"
            beside = f"sector_radius_mm = {h.sector_radius_mm:g}"
        told = (
            f"{field} = {held:g} must be {asked}, for a bend ratio of {least:g} at {beside} and cable = {h.cable}, "
            f"or another cable{named(others)}"
        )
        found.append(Reason("cable", "bend ratio", told, field, held, bound))
    return found


def _with_motors(design: Design, reason: Reason) -> Reason:
    """Names the motors whose shaft is as long as a pinion's bore asks for."""
    bound = reason.bound
    if (reason.part, reason.feature) != ("pinion", "bore") or not isinstance(bound, float):
        return reason
    others = rows("motor", design, lambda row: row.shaft_length_mm >= bound and "capstan" in row.drives)
    return replace(reason, message=f"{reason.message}{named(others)}", beside=one("motor", others))


def _ratio_most(design: Design) -> float:
    """Computes the largest ratio whose pinion goes round its motor's shaft."""
    h = design.hardware
    pinion = thinnest_pinion_mm(catalogue.motor.chosen(h), catalogue.cable.chosen(h).diameter_mm)
    return min(h.sector_radius_mm / pinion, CAPSTAN_RATIO_MOST)


def least_outline_mm(d: Dimensions) -> np.ndarray:
    """Computes (2,) what a machine takes at least along x and y: elbows farthest out, ends of its motors, base plate.

    Args:
        d: Its dimensions.
    """
    angle = min(max(0.0, d.extremes.shoulder_min.value), d.extremes.shoulder_max.value)
    elbow, half = d.bracket.shoulder_u_mm + d.arm.length_mm * cos(angle), d.forearm.bar_length_mm / 2
    u, face, radius = d.bracket.motor_axis_mm[0], d.layers.motor_cheek_mm[1], d.motor.diameter_mm / 2
    points = [(elbow, -half), (elbow, half), (elbow + d.arm.boss_radius_mm, 0.0)]
    points += [(u + side * radius, face + d.motor.length_mm) for side in (-1.0, 1.0)]
    for leads in d.leads:
        points += [(u + out, face + d.motor.length_mm + behind) for out, behind in leads.outside_mm]
    placed = np.concatenate([np.array(points) @ chain_frame(i)[:2, :2].T for i in CHAINS])
    return np.maximum(np.ptp(placed, axis=0), np.ptp(d.base.reach_mm, axis=1))


def _outline(d: Dimensions) -> list[Reason]:
    """Outline of what stands out farthest, the way round in which it fits best."""
    required, least = d.design.requirements, least_outline_mm(d)
    plate = np.ptp(d.base.reach_mm, axis=1)
    asked = {"envelope_width_mm": required.envelope_width_mm, "envelope_depth_mm": required.envelope_depth_mm}
    ways = ([*zip(asked, least, strict=True)], [*zip(asked, least[::-1], strict=True)])
    best = min(ways, key=lambda way: max(float(size) - asked[name] for name, size in way))
    return [
        Reason(
            "base_plate" if size in plate else "assembly",
            name.replace("_mm", "").replace("_", " "),
            f"requirements.{name} = {asked[name]:g} must be at least {up(size)} mm: "
            f"{'its feet stand' if size in plate else 'elbows and motors reach'} so far out",
            f"requirements.{name}",
            asked[name],
            float(size),
        )
        for name, size in best
        if size > asked[name]
    ]


def _cable_plane(d: Dimensions) -> list[Reason]:
    """A pinion so small that its groove's own climb leaves nothing of the fleet angle to tolerances."""
    if d.capstan is None:
        return []
    c, sector = d.capstan, d.design.hardware.sector_radius_mm

    def holds_at(radius: float, ratio: float) -> bool:
        return plane_chain(d, _scaled(c, radius, ratio), CLASSES[0]).holds

    if holds_at(sector, c.ratio):
        return []
    chain = plane_chain(d, c, CLASSES[0])
    told = f"it leaves its plane by {chain.rss[1]:.3f} mm of {chain.high:.3f} with the finest tolerances"
    if holds_at(sector, CAPSTAN_RATIO_LEAST):
        field, held = "hardware.capstan_ratio", c.ratio
        bound = border(lambda ratio: holds_at(sector, ratio), c.ratio, CAPSTAN_RATIO_LEAST)
        message = f"{field} = {held:g} must be at most {down(bound)}, or the cable a thinner one: {told}"
    else:
        field, held, bound = "hardware.cable", d.design.hardware.cable, c.cable_diameter_mm
        message = f"{field} = {held} must be one thinner than {bound:g} mm: {told}"
    widest = min(WIDER * sector, SECTOR_MOST_MM)
    if holds_at(widest, c.ratio):
        radius = border(lambda radius: holds_at(radius, c.ratio), sector, widest)
        if travel_chain(d, _scaled(c, radius, c.ratio), CLASSES[0]).holds:
            field, held, bound = "hardware.sector_radius_mm", sector, radius
            message = f"{field} = {held:g} must be at least {up(bound)} mm, or {message}"
    return [Reason("cable", "plane", message, field, held, bound)]


def _cable_travel(d: Dimensions) -> list[Reason]:
    """A cable so long that what it stretches and what sector and pinion are off leave its carriage no travel."""
    if d.capstan is None:
        return []
    c, sector = d.capstan, d.design.hardware.sector_radius_mm

    def holds_at(radius: float) -> bool:
        return travel_chain(d, _scaled(c, radius, c.ratio), CLASSES[0]).holds

    smaller = np.linspace(sector, SECTOR_LEAST_MM, SCANNED).tolist()  # the cable is cut in steps: may hold in between
    first = next((k for k, radius in enumerate(smaller) if holds_at(radius)), 0)
    if not first:
        return []
    bound = border(holds_at, smaller[first - 1], smaller[first])
    field = "hardware.sector_radius_mm"
    message = (
        f"{field} = {sector:g} must be at most {down(bound)} mm: a cable of {c.cable_length_mm:.0f} mm stretches and "
        f"differs by more than its carriage goes"
    )
    return [Reason("cable", "travel", message, field, sector, bound)]


def _scaled(c: CapstanDimensions, radius_mm: float, ratio: float) -> CapstanDimensions:
    """A capstan with another sector and ratio, as far as the tolerance chains of its cable read it."""
    wider = radius_mm - c.run.sector_mm
    beyond = c.run.beyond_rad * c.run.sector_mm / radius_mm  # the rim goes as far beyond the tangent point
    run = replace(c.run, sector_mm=radius_mm, pinion_mm=radius_mm / ratio, beyond_rad=beyond)
    return replace(c, run=run, rim_radius_mm=c.rim_radius_mm + wider)


def _bend(pinion_mm: float, cable: catalogue.Cable) -> float:
    """Bend ratio of a cable on a pinion less the least of its kind."""
    return (2.0 * pinion_mm - cable.diameter_mm) / cable.diameter_mm - BEND_LEAST_SHARE * cable.min_bend_ratio
