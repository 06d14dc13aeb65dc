"""Why a design's hardware cannot do, in closed form and all at once: no solid is made, only samples are posed.

Six kinds: a platform that hangs below its elbows, beside which nothing else is told; parts that cannot be given sound
dimensions; a drive that gives too little or breaks its cable; an outline that elbows or motors alone exceed; a cable
whose plane or length no tolerances hold; loads that parts may not bear even if nothing had a weight. Each is necessary:
what passes here may still fail a check.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import fields, replace
from math import cos, tanh
from typing import Any

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.record import CAPSTAN_RATIO_LEAST, CAPSTAN_RATIO_MOST, SECTOR_LEAST_MM, SECTOR_MOST_MM
from delta_cad.dimensions import DimensionError, Dimensions, Reason, dimensions
from delta_cad.dimensions.cable.run import FRICTION
from delta_cad.dimensions.capstan import ROPE_FACTOR, CapstanDimensions, thinnest_pinion_mm, widest_pinion_mm
from delta_cad.dimensions.forearm import TUBE_GLUE_MM
from delta_cad.dimensions.joint import PRELOAD_N, PRELOAD_PER_N
from delta_cad.dimensions.rules import down, up
from delta_cad.dimensions.tolerances.cable import plane_chain, travel_chain
from delta_cad.dimensions.tolerances.general import CLASSES
from delta_cad.drive import drive_torque
from delta_cad.drive.report import BEND_LEAST_SHARE, SLACK_N
from delta_cad.mechanism import direct_margin, reach_excess
from delta_cad.mechanism.placement import CHAINS, chain_frame
from delta_cad.passing.refused import passing
from delta_cad.structure.holds import Holds, holds
from delta_cad.structure.loads import Borne, Load, borne, loads, sampled_mm
from delta_cad.structure.modes import Moving, MovingBody
from delta_cad.structure.table import StructureTable, structure_table

COUNT = 5  # positions along an edge of the cube, its corners among them
HALVINGS = 30  # of a range in which something begins to hold: to 1e-9 of it
SHARE_HALVINGS = 14  # of a force that is told with three digits
SCANNED = 100  # radii of a sector
WIDER = 1.5  # times a sector's radius that it may be asked to have
TOLD = 4  # rows of the catalogue that a message names at most
SLACK, SLIP = "cable's slack strand", "cable's slip"
TENSIONED = SLACK, SLIP  # what a higher tension of the cable holds
# Load -> the field of the design that sizes its part, and what of its row counts.
SIZED: dict[str, tuple[str, str]] = {
    "rod buckling": ("hardware.tube", "of a bending stiffness"),
    "rod end bending": ("hardware.tube", "of an inside diameter"),
    "stud": ("hardware.ball_diameter_mm", ""),
    "motor shaft": ("hardware.motor", "whose shaft may bear across"),
    "cable": ("hardware.cable", "of a breaking load"),
    "shoulder bearing": ("hardware.bearing", "of a static load"),
    "shoulder bearing life": ("hardware.bearing", "of a dynamic load"),
}


def refusals(design: Design) -> tuple[Reason, ...]:
    """Gives every reason why a design's hardware cannot do; none where it may.

    Args:
        design: A validated design.

    Returns:
        Reasons, each with the field to change, its value and what would do.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    if hanging := _mode(design):  # parts, loads and advice would be about another machine than the forward kinematics'
        return hanging
    found = _drive(design)
    try:
        d = dimensions(design)
    except DimensionError as error:
        return (*(_with_motors(design, one) for one in error.reasons), *found)
    return (*found, *_outline(d), *_cable_plane(d), *_cable_travel(d), *passing(d), *_borne(d))


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
        others = _rows("motor", design, lambda row, c=column, n=needed: getattr(row, c) >= n and h.drive in row.drives)
        advice, beside = f"a motor of at least {up(needed)} N m {words}{_named(others)}", ()
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
            bound, field, held, beside = needed, "hardware.motor", h.motor, _one("motor", others)
            message = f"hardware.motor = {h.motor} must be {advice}"
        told = f"{message}, or {least} at most {down(value)}: {value:.4g} of {required:.4g} N m at the joint, {words}"
        found.append(Reason("drive", f"{words} torque", told, field, held, bound, beside, (least, value)))
    tension, ratio, least = drive.cable_tension_N, drive.bend_ratio, drive.bend_ratio_least
    if tension is None or ratio is None or least is None:
        return found
    cable = catalogue.cable.chosen(h)
    if cable.breaking_load_N < ROPE_FACTOR * tension:
        needed = ROPE_FACTOR * tension
        others = _rows("cable", design, lambda row: row.breaking_load_N >= needed)
        told = f"hardware.cable = {h.cable} must have a breaking load of at least {up(needed)} N{_named(others)}"
        found.append(Reason("cable", "strength", told, "hardware.cable", h.cable, needed, _one("cable", others)))
    if ratio < least:
        more = (least + 1.0) / (ratio + 1.0)
        radius, less = h.sector_radius_mm * more, h.capstan_ratio / more
        others = _rows("cable", design, lambda row: _bend(h.sector_radius_mm / h.capstan_ratio, row) >= 0.0)
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
            f"or another cable{_named(others)}"
        )
        found.append(Reason("cable", "bend ratio", told, field, held, bound))
    return found


def _with_motors(design: Design, reason: Reason) -> Reason:
    """Names the motors whose shaft is as long as a pinion's bore asks for."""
    bound = reason.bound
    if (reason.part, reason.feature) != ("pinion", "bore") or not isinstance(bound, float):
        return reason
    others = _rows("motor", design, lambda row: row.shaft_length_mm >= bound and "capstan" in row.drives)
    return replace(reason, message=f"{reason.message}{_named(others)}", beside=_one("motor", others))


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
        bound = _border(lambda ratio: holds_at(sector, ratio), c.ratio, CAPSTAN_RATIO_LEAST)
        message = f"{field} = {held:g} must be at most {down(bound)}, or the cable a thinner one: {told}"
    else:
        field, held, bound = "hardware.cable", d.design.hardware.cable, c.cable_diameter_mm
        message = f"{field} = {held} must be one thinner than {bound:g} mm: {told}"
    widest = min(WIDER * sector, SECTOR_MOST_MM)
    if holds_at(widest, c.ratio):
        radius = _border(lambda radius: holds_at(radius, c.ratio), sector, widest)
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
    bound = _border(holds_at, smaller[first - 1], smaller[first])
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


def _border(holds: Callable[[float], bool], bad: float, good: float, halvings: int = HALVINGS) -> float:
    """Finds where something begins to hold between a value at which it does not and one at which it does."""
    for _ in range(halvings):
        middle = (bad + good) / 2.0
        bad, good = (bad, middle) if holds(middle) else (middle, good)
    return good


def _bend(pinion_mm: float, cable: catalogue.Cable) -> float:
    """Bend ratio of a cable on a pinion less the least of its kind."""
    return (2.0 * pinion_mm - cable.diameter_mm) / cable.diameter_mm - BEND_LEAST_SHARE * cable.min_bend_ratio


def _rows(name: str, design: Design, does: Callable[[Any], bool]) -> list[str]:
    """Finds the rows of a family that would do."""
    return [key for key, row in catalogue.family(name, design.hardware.own_parts).items() if does(row)]


def _named(ids: Sequence[str]) -> str:
    """Names rows that would do, for a message."""
    return f" ({', '.join(ids[:TOLD])})" if ids else " (the catalogue has none)"


def _one(name: str, ids: Sequence[str]) -> tuple[tuple[str, float | str], ...]:
    """Gives the first of the rows that would do, as what has to change."""
    return tuple((f"hardware.{name}", key) for key in ids[:1])


def _borne(d: Dimensions) -> list[Reason]:
    """Loads of weightless parts over what they may be, for both forces."""
    required, cube, table, limits = d.design.requirements, d.design.cube, structure_table(d), holds(d)
    nothing = MovingBody(0.0, np.zeros(3), np.zeros((3, 3)))
    what, positions = (
        Moving(nothing, nothing, (0.0, 0.0, 0.0)),
        sampled_mm(cube.bottom_height_mm, cube.half_side_mm, COUNT),
    )
    found: dict[str, Reason] = {}
    forces = {"force_N": required.force_N, "peak_force_N": required.peak_force_N}
    for field, force in forces.items():
        if force is None:
            continue
        given = borne(table, what, positions, force, np.zeros(3))
        for load in loads(table, limits, positions, given):
            if load.holds or (load.least and field == "peak_force_N"):  # of what lasts, see `structure_report`
                continue
            bears = force * _share_borne(table, limits, positions, given, load)
            half = float(given.cable.max()) / 2.0
            found[load.name] = _overloaded(d, load, (f"requirements.{field}", force, bears), half)
    return list(found.values())


def _share_borne(table: StructureTable, limits: Holds, positions: np.ndarray, given: Borne, load: Load) -> float:
    """Share of a force that a part bears where it bears least: weightless loads go with the force."""
    k = int(np.argmin(np.linalg.norm(positions - np.array(load.position_mm), axis=1)))
    one = {f.name: getattr(given, f.name)[k : k + 1] for f in fields(given)}

    def holds_at(share: float) -> bool:
        scaled = Borne(**{name: share * values for name, values in one.items()})
        return next(x for x in loads(table, limits, positions[k : k + 1], scaled) if x.name == load.name).holds

    return _border(holds_at, 1.0, 0.0, SHARE_HALVINGS)


def _overloaded(d: Dimensions, load: Load, force: tuple[str, float, float], half_N: float) -> Reason:
    """Says which field is to change for a load.

    Args:
        d: The design's dimensions.
        load: What a part may not bear.
        force: Field of the force that makes it, the force, and the one that the part would bear, N.
        half_N: Half the largest difference between the cable's strands.
    """
    told = f"{load.value:.4g} {load.unit}, {'at least' if load.least else 'at most'} {load.limit:.4g}"
    less = f"{force[0]} = {force[1]:g} at most {down(force[2], 3)} N"
    if force[2] == 0.0:  # the springs alone are too strong: those for a smaller force are weaker by so much at least
        share = max(load.margin, 0.0)
        weaker = d.forearm.joint.spring_N * share / (PRELOAD_N[1] / PRELOAD_N[0] * PRELOAD_PER_N)
        force = *force[:2], min(weaker, force[1] * share)
        less = f"{force[0]} = {force[1]:g} at most {down(force[2], 3)} N, for which weaker springs do"
        if PRELOAD_PER_N * force[2] < PRELOAD_N[0]:  # there are none
            force, less = (*force[:2], 0.0), "another parallelogram_width_mm, whose springs pull less"
    if load.name in TENSIONED:
        return _tensioned(d, load, half_N, told, less)
    field, column = SIZED.get(load.name, ("", ""))
    if not field:
        return Reason(load.name, "load", f"{less}: {told}", force[0], force[1], force[2] or None)
    held, more = getattr(d.design.hardware, field.split(".")[1]), 1.0 / load.margin
    needed, does, size = load.value, list[str](), None
    if load.name == "motor shaft":
        motor = f"hardware.motor = {held} one {column} of at least {up(needed)}"
        sector = d.design.hardware.sector_radius_mm
        wider = sector * more  # the same torque on a larger pinion pulls less
        beside = () if d.capstan is None else _with_ratio(d, wider)
        if d.capstan is None or wider > SECTOR_MOST_MM or any(ratio > CAPSTAN_RATIO_MOST for _, ratio in beside):
            return Reason(load.name, "load", f"{less}: {told}; or {motor}", *force)
        words = "".join(f" with {name} = {d.capstan.ratio:g} at least {up(ratio)}" for name, ratio in beside)
        field = "hardware.sector_radius_mm"
        message = f"{field} = {sector:g} must be at least {up(wider)} mm{words}: {told}; or {motor}; or {less}"
        return Reason(load.name, "load", message, field, sector, wider, beside)
    if load.name == "cable":
        needed = load.value * ROPE_FACTOR
        does = _rows("cable", d.design, lambda row: row.breaking_load_N >= needed)
    elif load.name == "shoulder bearing":
        does = _rows("bearing", d.design, lambda row: row.static_load_N >= needed and row.bore_mm == d.bearing.bore_mm)
    elif load.name == "shoulder bearing life":
        needed = d.bearing.dynamic_load_N * more ** (1.0 / 3.0)
        does = _rows("bearing", d.design, lambda row: row.dynamic_load_N >= needed)
    elif load.name == "stud":
        needed = d.forearm.ball_diameter_mm * more ** (1.0 / 3.0)
        sizes = sorted({row.diameter_mm for row in catalogue.ball.rows.values() if row.diameter_mm >= needed})
        does, size = [f"{v:g} mm" for v in sizes], next(iter(sizes), None)
    elif load.name == "rod end bending":
        needed = d.forearm.spigot_diameter_mm * more ** (1.0 / 3.0) + 2.0 * TUBE_GLUE_MM
        does = _rows("tube", d.design, lambda row: row.inner_mm >= needed)
    else:
        needed = d.tube.outer_mm * more ** (1.0 / 4.0)
        column = "of an outside diameter"
        does = _rows("tube", d.design, lambda row: row.outer_mm >= needed)
    words = f"{column} of at least {up(needed)}{_named(does)}".strip()
    message = f"{field} = {held} must be one {words}: {told}; or {less}"
    beside = () if load.name == "stud" else _one(field.split(".")[1], does)
    instead = (force[0], force[2]) if force[2] else None
    return Reason(load.name, "load", message, field, held, size or needed, beside, instead)


def _with_ratio(d: Dimensions, sector_mm: float) -> tuple[tuple[str, float], ...]:
    """Gives the ratio with which a larger sector's pinion passes the motor's screws, or nothing where it does."""
    ratio = sector_mm / widest_pinion_mm(d.motor, d.cable.diameter_mm)
    return (("hardware.capstan_ratio", ratio),) if ratio > d.design.hardware.capstan_ratio else ()


def _tensioned(d: Dimensions, load: Load, half_N: float, told: str, less: str) -> Reason:
    """Says for which torque the cable must be tensioned, or that the drive must give it first.

    Args:
        d: The design's dimensions.
        load: A slack strand that goes loose, or turns that slip.
        half_N: Half the difference between the strands.
        told: The load beside its limit, in words.
        less: The force that the cable would bear, in words.
    """
    drive, hardware = drive_torque(d.design), d.design.hardware
    assert d.capstan is not None
    # Euler: T + D / 2 = (T - D / 2) e^(friction wrap)
    factor = 1.0 if load.name == SLACK else 1.0 / tanh(FRICTION * d.capstan.run.wrap_rad / 2.0)
    torque = 2.0 * (factor * half_N - SLACK_N) * drive.efficiency * hardware.sector_radius_mm / MM_PER_M
    if drive.peak_torque_N_m < min(torque, drive.required_peak_N_m):
        field, held = "hardware.capstan_ratio", hardware.capstan_ratio
        torque = max(torque, drive.required_peak_N_m)
        bound = held * torque / drive.peak_torque_N_m
        message = f"{field} = {held:g} must be at least {up(bound)}, for a peak of {up(torque)} N m"
    else:
        field, held, bound = "requirements.peak_torque_N_m", drive.required_peak_N_m, torque
        message = f"{field} = {held:g} must be at least {up(torque)} N m"
    return Reason(
        load.name, "load", f"{message}, which the cable is tensioned for: {told}; or {less}", field, held, bound
    )
