"""The moving platform and its handle, the base plate (both centred on the z axis), and the bench plate under it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise, product
from math import atan2, ceil, cos, floor, hypot, inf, pi, radians, sin, sqrt, tau
from typing import Protocol

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.stands import EVEN, EVEN_DEG, Gap, narrowest_gap
from delta_cad.dimensions.arm import ArmDimensions
from delta_cad.dimensions.bracket import PLATE_RIM_MM, BracketDimensions, Circle
from delta_cad.dimensions.forearm import BAR_BEYOND_MM, BAR_GLUE_MM, BAR_WALL_MM, ForearmDimensions
from delta_cad.dimensions.layers import Layers
from delta_cad.dimensions.rules import (
    BASE,
    DRILL_DIAMETERS,
    PLATFORM,
    PLATFORM_THICKNESS,
    WIDTH,
    another,
    ceil_sig,
    larger,
    reasons_of,
    require,
    smaller,
)
from delta_cad.dimensions.sizes import largest_force_N, plate_mm, stem_mm
from delta_cad.mechanism import joint_angles
from delta_cad.mechanism.placement import CHAINS

BASE_SCREW = "M4"  # foot blocks on the base plate
_UNDER_HEAD_MM = 1.0  # least metal between a counterbore and the far face
WRIST_MARK = "0"  # punched on the boss of wrist 0 where chains are placed: the platform fits in one position only
BOSS_BEVEL_MM = 0.4  # on the wrist bosses
STEM_FLATS_MM, STEM_FLATS_Z_MM = 8.0, (2.0, 8.0)  # for a spanner: across them, and from where to where of the stem
MOUNT_SCREW = "M5"  # that holds the base plate down
_MOUNT_SPREAD_RAD, _EVEN_RAD = radians(18.0), radians(60.0)  # mounting holes beside the feet, in a gap of twice that
_FLAT_LEAST_MM = 45.0  # from the plate's centre: beside a hole for the cables, feet that do not tip at once
_FOOT_RIM_MM, _MOUNT_RIM_MM = 10.0, 8.0  # from the axis of a foot, and of a mounting hole, to the plate's edge
_HOLE_RIM_MM = 8.0  # around the hole in the middle
_WINDOW_MM, _WINDOW_LEAST_MM, _WINDOW_RIM_MM = 34.0, 12.0, 5.0  # holes that lighten the plate
_PLATE_MM = 5.0  # the least; it grows with loads and lengths
_STEM_WALL_MM = 3.0  # of the hub around the stem
RIB_MM = 4.0  # width of what stays around a window of it
_WINDOW_LONG_MM, _WINDOW_REACH_MM, _WINDOW_CORNER_MM = 4.0, 3.0, 1.5  # of these: least length, half width; corners
WEB_CORNER_MM = 5.0, 3.0  # of a web, which ends so much inside its boss's ends, in corners of such a radius
_BOSS_LEAST_MM = 2 * WEB_CORNER_MM[0]  # length of a wrist boss, at whose ends its web's corners lie
LENGTH_MM = 1e-9  # roundings of a length that is asked
FACTOR = 1.5  # of the largest force at the handle: a user pushes against what the machine renders, and more
FOOT_FRICTION = 0.5  # of rubber on a dry, smooth table; from memory, the low end of 0.5 to 0.8
PAD_MM = 30.0, 6.0  # a pad of the bench plate: diameter, and height, more than that of the screws' heads beside it
PAD_RIM_MM = 3.0  # of the bench plate around it
BENCH_MATERIAL = "steel-s235"
BENCH_HOLE = "M6"  # whose clearance holes the bench plate has: wide enough for general tolerances
BENCH_MM = 6.0, 8.0, 10.0, 12.0, 15.0, 20.0  # plates in stock
_CHEEK_SHARE = 0.7  # of a cheek's outline by its thickness: seats, bores and pockets are cut out of it
_MARGIN_MM = 0.5  # that a bench plate leaves of the outline
_POSITIONS = 5  # along an edge of the cube, at which elbows are looked at


@dataclass(frozen=True)
class PlatformDimensions:
    """Platform plate with three wrist bosses, and the handle on it."""

    radius_mm: float
    boss_diameter_mm: float
    boss_length_mm: float
    bar_bore_mm: float
    plate_mm: float
    hub_radius_mm: float
    stem_diameter_mm: float
    stem_length_mm: float
    stem_thread: str

    @property
    def web_mm(self) -> tuple[Circle, ...]:
        """Circles (x, y, radius) whose hull the plate is from the hub to chain 0's boss."""
        aside, corner = self.boss_length_mm / 2 - WEB_CORNER_MM[0], WEB_CORNER_MM[1]
        u = self.radius_mm
        return (0.0, 0.0, self.hub_radius_mm), (u, aside, corner), (u, -aside, corner)

    @property
    def window_reach_mm(self) -> tuple[float, float, float] | None:
        """From where to where the window in it goes along x, and how far aside; None where there is no room."""
        near, far = self.hub_radius_mm + RIB_MM, self.radius_mm - self.boss_diameter_mm / 2 - 1.0
        reach = (self.boss_length_mm / 2 - WEB_CORNER_MM[0]) * far / self.radius_mm - RIB_MM
        return (near, far, reach) if far - near >= _WINDOW_LONG_MM and reach >= _WINDOW_REACH_MM else None

    @property
    def window_mm(self) -> tuple[Circle, ...]:
        """Circles whose hull this window is; none where there is no room."""
        if self.window_reach_mm is None:
            return ()
        (near, far, reach), r = self.window_reach_mm, _WINDOW_CORNER_MM
        return (near + r, 0.0, r), (far - r, reach - r, r), (far - r, r - reach, r)


@dataclass(frozen=True)
class BaseDimensions:
    """Base plate under the three foot blocks: discs about the stands, or six-sided where these would stand out alone.

    Attributes:
        radius_mm: Of the disc about a stand, which holds its block with a rim.
        rim_mm: Circles (x, y, radius) whose hull the plate is; empty for one disc, where no chain stands farther out.
        thickness_mm: Of the plate.
        top_mm: Height of its upper face in the base frame.
        centre_hole_mm: Diameter of the hole in its middle.
        window_mm: Diameter of the holes that lighten it, between the chains; 0 where there is no room.
        foot_circle_mm: Diameter on which the rubber feet stand.
        between_rad: Azimuths of the feet, half-way between the chains.
        mount_circle_mm: Diameter on which the mounting threads are, beside the feet; motors stand over some of them.
        mount_spread_rad: Angle between a mounting thread and the foot beside it.
        mount_hole_mm: Diameter of the sleeves' bores under them.
    """

    radius_mm: float
    rim_mm: tuple[Circle, ...]
    thickness_mm: float
    top_mm: float
    centre_hole_mm: float
    window_mm: float
    foot_circle_mm: float
    between_rad: tuple[float, ...]
    mount_circle_mm: float
    mount_spread_rad: float
    mount_hole_mm: float

    @property
    def feet_mm(self) -> list[tuple[float, float]]:
        """(x, y) of the feet, half-way between the chains."""
        return self._between_chains(self.foot_circle_mm / 2)

    @property
    def mounts_mm(self) -> list[tuple[float, float]]:
        """(x, y) of the mounting threads, one on either side of each foot; screws come from below."""
        radius, spread = self.mount_circle_mm / 2, self.mount_spread_rad
        return [at for sign in (-1, 1) for at in self._between_chains(radius, sign * spread)]

    def _between_chains(self, radius: float, spread: float = 0.0) -> list[tuple[float, float]]:
        return [(radius * cos(a + spread), radius * sin(a + spread)) for a in self.between_rad]

    @property
    def holes_mm(self) -> list[Circle]:
        """Circles (x, y, radius) of the large holes: that in the middle, and those between the chains."""
        out = (self.centre_hole_mm + self.foot_circle_mm) / 4
        windows = [(out * cos(a), out * sin(a), self.window_mm / 2) for a in self.between_rad if self.window_mm]
        return [(0.0, 0.0, self.centre_hole_mm / 2), *windows]

    @property
    def reach_mm(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """From where to where the plate lies along x and y."""
        rim = self.rim_mm or ((0.0, 0.0, self.radius_mm),)
        (x0, x1), (y0, y1) = ((min(c[k] - c[2] for c in rim), max(c[k] + c[2] for c in rim)) for k in (0, 1))
        return (x0, x1), (y0, y1)


def platform_dimensions(
    radius_mm: float,
    thickness_mm: float,
    forearm: ForearmDimensions,
    knob: catalogue.Knob,
    grown: float = 1.0,
    stem_grown: float = 1.0,
) -> PlatformDimensions:
    """Dimensions a platform for a wrist radius; the bosses of its cross-bars are as thick as `thickness_mm`.

    Args:
        radius_mm: Platform centre to wrist.
        thickness_mm: Of the bosses.
        forearm: Whose cross-bars it carries.
        knob: On its stem.
        grown: Second moment of the plate over that of the least, see `sizes.growth`.
        stem_grown: The same of the stem.

    Raises:
        DimensionError: Too thin around the cross-bars; the cups of neighbouring chains would come within the clearance
            of one another, or a boss would run into the hub; so thick that rods which lean leave its bosses no length.
    """
    least = forearm.bar_diameter_mm + 2 * BAR_WALL_MM
    require(
        thickness_mm >= least,
        "platform",
        "wrist boss",
        f"{thickness_mm:g} mm are too thin around the cross-bar; at least {least:g}",
        larger(PLATFORM_THICKNESS),
        larger(PLATFORM_THICKNESS, PLATFORM),
    )
    stem = stem_mm(stem_grown)
    hub = stem / 2 + _STEM_WALL_MM
    require(
        radius_mm >= hub + thickness_mm / 2 + 2.0,
        "platform",
        "hub",
        f"on a radius of {radius_mm:g} mm it meets the hub; at least {hub + thickness_mm / 2 + 2.0:g} mm",
        larger(PLATFORM),
    )
    require(
        radius_mm >= forearm.wrist_radius_min_mm,
        "platform",
        "wrists",
        f"neighbouring cups come within the clearance on a radius of {radius_mm:g} mm; at least "
        f"{ceil_sig(forearm.wrist_radius_min_mm)} mm",
        larger(PLATFORM),
        larger(BASE, PLATFORM),
        smaller(WIDTH),
    )
    # A boss's edge comes as near as `b cos(tilt) - r sin(tilt)` to the axis of a rod that hangs b beside its end.
    tilt, needed = forearm.tilt_limit_rad, forearm.tube_outer_mm / 2 + forearm.room_mm
    adjacent = (needed + thickness_mm / 2 * sin(tilt)) / cos(tilt)
    length = forearm.width_mm - 2 * adjacent
    ways = smaller(PLATFORM_THICKNESS), larger(WIDTH)
    message = f"rods that lean leave its wrists' bosses {max(length, 0.0):.1f} mm; at least {_BOSS_LEAST_MM:g}"
    require(length >= _BOSS_LEAST_MM - LENGTH_MM, "platform", "wrist boss, length", message, *ways)
    bore = forearm.bar_diameter_mm + 2 * BAR_GLUE_MM
    return PlatformDimensions(
        radius_mm=radius_mm,
        boss_diameter_mm=thickness_mm,
        boss_length_mm=min(
            forearm.bar_length_mm - 2 * max(BAR_BEYOND_MM, forearm.cone_mm),
            length,
            float(floor(DRILL_DIAMETERS * bore)),
        ),
        bar_bore_mm=bore,
        plate_mm=plate_mm(_PLATE_MM, grown),
        hub_radius_mm=hub,
        stem_diameter_mm=stem,
        stem_length_mm=25.0,
        stem_thread=knob.thread,
    )


def base_dimensions(
    bracket: BracketDimensions,
    thickness_mm: float,
    half_width_mm: float,
    behind_mm: float,
    gaps: Sequence[Gap] = EVEN,
    azimuths_deg: Sequence[float] = EVEN_DEG,
) -> BaseDimensions:
    """Dimensions a base plate that carries the brackets' feet with a rim of 4 mm at least.

    Feet and mounting holes are on circles about the base's axis, in each gap alike.

    Args:
        bracket: Brackets, screwed on from below.
        thickness_mm: Thickness of the plate.
        half_width_mm: How far the brackets reach aside of their chain's plane.
        behind_mm: How far arms and motors reach behind the base's centre, opposite to chain 0: so far the plate may.
        gaps: Of the chains.
        azimuths_deg: Of the chains.

    Raises:
        DimensionError: The screws' counterbores leave too little under their heads.
    """
    least = catalogue.screw(BASE_SCREW).counterbore_depth_mm + _UNDER_HEAD_MM
    require(
        thickness_mm >= least,
        "base_plate",
        "counterbore",
        f"{thickness_mm:g} mm leave too little under the screws' heads; at least {least:g} mm",
        larger("hardware.base_plate_thickness_mm"),
    )
    azimuths, out = [radians(angle) for angle in azimuths_deg], gaps[0].next_out_mm
    between = tuple((one + after) / 2 for one, after in pairwise([*azimuths, tau]))
    halves = [radians((after - one) / 2) for one, after in pairwise([*azimuths_deg, 360.0])]
    stands = [(cos(a) * off, sin(a) * off) for a, off in zip(azimuths, (0.0, out, out), strict=True)]
    spread = _MOUNT_SPREAD_RAD * (min(halves) / _EVEN_RAD)
    radius = ceil(hypot(bracket.foot_u_mm[1], half_width_mm) + PLATE_RIM_MM)
    behind = max(floor(behind_mm), _FLAT_LEAST_MM)
    is_round = behind >= radius - min(stands[1][0], 0.0)
    flat = float(radius if is_round else behind)
    adjacent = flat - _FOOT_RIM_MM  # of the feet, from the centre
    hole = min(bracket.foot_u_mm[0] + min(out, 0.0) - _HOLE_RIM_MM, adjacent - _HOLE_RIM_MM)
    lacking = EVEN[0].half_sine - narrowest_gap(gaps).half_sine  # of the way aside between even chains, as a share
    narrower = (hole + adjacent) / 2 * lacking
    room = 2 * floor((adjacent - hole) / 2 - _WINDOW_RIM_MM - narrower)
    mount, rim = radius - _MOUNT_RIM_MM, list[Circle]()
    if not is_round:
        mount = (flat - _MOUNT_RIM_MM) / cos(spread)
        corner, far = atan2(half_width_mm, bracket.foot_u_mm[1]), hypot(bracket.foot_u_mm[1], half_width_mm)
        for i, (azimuth, (x, y)) in enumerate(zip(azimuths, stands, strict=True)):
            for before, after, (x0, y0), reach, wide in (
                (corner, corner, (x, y), far, PLATE_RIM_MM),
                (halves[i - 1] - spread, halves[i] - spread, (0.0, 0.0), mount, _MOUNT_RIM_MM),
            ):
                ways = azimuth - before, azimuth + after
                rim += [(x0 + reach * cos(way), y0 + reach * sin(way), wide) for way in ways]
    elif out > 0.0:
        rim = [(x, y, float(radius)) for x, y in stands]
    return BaseDimensions(
        radius_mm=radius,
        rim_mm=tuple(rim),
        thickness_mm=thickness_mm,
        top_mm=bracket.base_top_mm,
        centre_hole_mm=float(floor(2 * hole)),
        window_mm=0.0 if room < _WINDOW_LEAST_MM else min(_WINDOW_MM, room),
        foot_circle_mm=2 * adjacent,
        between_rad=between,
        mount_circle_mm=2 * mount,
        mount_spread_rad=spread,
        mount_hole_mm=catalogue.screw(MOUNT_SCREW).clearance_hole_mm,
    )


@dataclass(frozen=True)
class BenchDimensions:
    """Steel plate under the base plate of a machine that stands free, on a rubber pad in each corner.

    Attributes:
        x_mm: From where to where it lies along x of the base frame.
        y_mm: Along y.
        thickness_mm: Of the plate.
        top_mm: Height of its upper face, which the base plate lies on.
        screw_mm: Length of the screws through it into the base plate's threads.
        mass_kg: Of the plate.
        tips_N: Least force at the knob that tips the machine, by what it weighs at least.
        slides_N: Least force that slides it.
    """

    x_mm: tuple[float, float]
    y_mm: tuple[float, float]
    thickness_mm: float
    top_mm: float
    screw_mm: float
    mass_kg: float
    tips_N: float
    slides_N: float

    @property
    def size_mm(self) -> tuple[float, float]:
        """Edges along x and y."""
        return self.x_mm[1] - self.x_mm[0], self.y_mm[1] - self.y_mm[0]

    def corners_mm(self, inside_mm: float) -> list[tuple[float, float]]:
        """(x, y) of points so far inside both edges of each corner, counter-clockwise."""
        (x0, x1), (y0, y1) = ((low + inside_mm, high - inside_mm) for low, high in (self.x_mm, self.y_mm))
        return [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]

    @property
    def pads_mm(self) -> list[tuple[float, float]]:
        """(x, y) of the pads."""
        return self.corners_mm(PAD_RIM_MM + PAD_MM[0] / 2)

    @property
    def ground_mm(self) -> float:
        """Height of the table."""
        return self.top_mm - self.thickness_mm - PAD_MM[1]


class _Machine(Protocol):
    """What a bench plate is dimensioned by of a machine, see `Dimensions`."""

    @property
    def design(self) -> Design: ...
    @property
    def arm(self) -> ArmDimensions: ...
    @property
    def layers(self) -> Layers: ...
    @property
    def bracket(self) -> BracketDimensions: ...
    @property
    def forearm(self) -> ForearmDimensions: ...
    @property
    def platform(self) -> PlatformDimensions: ...
    @property
    def base(self) -> BaseDimensions: ...
    @property
    def bench(self) -> BenchDimensions | None: ...
    @property
    def motor(self) -> catalogue.Motor: ...
    @property
    def knob(self) -> catalogue.Knob: ...
    def stand(self, i: int) -> np.ndarray:
        """(4, 4) frame of what stands on the base of chain i."""
        ...


def edges(
    feet_mm: np.ndarray,
    ground_mm: float,
    mass_kg: float,
    centre_mm: np.ndarray,
    knob_mm: np.ndarray,
    gravity_m_s2: np.ndarray,
) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
    """Computes what holds and what tips a machine over the line through each two feet.

    A force F at the height h over the table, a way s inside the line, turns it about this line by
    `F sqrt(h^2 + s^2)` at most over its directions; its weight holds by `W a`, its centre a way a inside.

    Args:
        feet_mm: (m, 2) corners of a convex polygon, counter-clockwise.
        ground_mm: Height of the table, base frame.
        mass_kg: Of the machine.
        centre_mm: (n, 3) its centre.
        knob_mm: (n, 3) the knob.
        gravity_m_s2: (3,) base frame.

    Returns:
        For each line: (n,) moment of the weight, N mm; (n,) lever of the force, mm; what each further kg in the middle
        of the feet adds to the moment, N mm.
    """
    down, middle = -float(gravity_m_s2[2]), feet_mm.mean(axis=0)
    for one, other in zip(feet_mm, np.roll(feet_mm, -1, axis=0), strict=True):
        inwards = np.array([one[1] - other[1], other[0] - one[0]]) / np.linalg.norm(other - one)
        lever = np.hypot(knob_mm[:, 2] - ground_mm, (knob_mm[:, :2] - one) @ inwards)
        aside = gravity_m_s2[:2] @ inwards * (centre_mm[:, 2] - ground_mm)
        held = mass_kg * (down * ((centre_mm[:, :2] - one) @ inwards) + aside)
        yield held, lever, down * float((middle - one) @ inwards)


def sliding_N_kg(gravity_m_s2: np.ndarray) -> float:
    """Computes the least force that slides a machine, for each kg of it.

    On a level table a weight W slides at `W mu / sqrt(1 + mu^2)`, the force raised by the angle of friction.
    """
    down, aside = -float(gravity_m_s2[2]), float(np.hypot(gravity_m_s2[0], gravity_m_s2[1]))
    return max(0.0, FOOT_FRICTION * down - aside) / sqrt(1.0 + FOOT_FRICTION**2)


def fixed_mass(d: _Machine) -> tuple[float, np.ndarray]:
    """Computes what stands on the base weighs at least, kg, and its centre in the base frame, (3,) mm.

    Motors, cheeks, foot blocks and the base plate, in closed form; left out is what moves, whose weight lies inside the
    feet of a bench plate and holds it down, and screws, pins, bearings, boards.
    """
    k, layers, b = d.bracket, d.layers, d.base
    aluminium = catalogue.material("aluminium-6082").density_kg_m3 / MM_PER_M**3
    (out, into), (inside, outside) = layers.encoder_cheek_mm, layers.motor_cheek_mm
    u, face = k.motor_axis_mm[0], layers.motor_face_mm
    x, y, radius = k.leg_circle_mm
    foot = (k.foot_u_mm[0] + k.foot_u_mm[1]) / 2
    pieces = [(d.motor.mass_g / 1e3, (u, face + d.motor.length_mm / 2, k.motor_axis_mm[1]))]
    for circles, low, high in (
        (k.motor_cheek_circles_mm, inside, outside),
        ([(x, y, radius), *k.foot_circles_mm], out, into),
    ):
        area, (cx, cz) = _hull(circles)
        at = (k.shoulder_u_mm + cx, (low + high) / 2, cz)
        pieces.append((_CHEEK_SHARE * area * (high - low) * aluminium, at))
    block = (k.foot_u_mm[1] - k.foot_u_mm[0]) * (inside - into) * k.foot_height_mm * aluminium
    pieces.append((block, (foot, (inside + into) / 2, b.top_mm + k.foot_height_mm / 2)))
    area, (px, py) = _hull(b.rim_mm or ((0.0, 0.0, float(b.radius_mm)),))
    plate = (area - sum(pi * r**2 for _, _, r in b.holes_mm)) * b.thickness_mm * aluminium
    mass, moment = plate, plate * np.array([px, py, b.top_mm - b.thickness_mm / 2])
    for i, (kg, at) in product(CHAINS, pieces):
        frame = d.stand(i)
        mass += kg
        moment = moment + kg * (frame[:3, :3] @ np.array(at) + frame[:3, 3])
    return mass, moment / mass


def _hull(circles: Sequence[Circle]) -> tuple[float, tuple[float, float]]:
    """Area and centroid of the hull of circles, by 60 points of each."""
    from scipy.spatial import ConvexHull

    turns = np.linspace(0.0, tau, 61)[:-1]
    rim = np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    points = np.concatenate([np.array([x, y]) + r * rim for x, y, r in circles])
    x, y = points[ConvexHull(points).vertices].T
    cross = x * np.roll(y, -1) - np.roll(x, -1) * y
    area = cross.sum() / 2.0
    cx, cy = (float(((one + np.roll(one, -1)) * cross).sum() / (6.0 * area)) for one in (x, y))
    return float(area), (cx, cy)


def knob_centre_mm(d: _Machine) -> float:
    """Height of the knob's centre over the wrists' plane."""
    return d.platform.boss_diameter_mm / 2 + d.platform.stem_length_mm + d.knob.height_mm - d.knob.diameter_mm / 2


def corners_of_cube_mm(d: _Machine) -> np.ndarray:
    """(8, 3) corners of the cube, where a machine tips first."""
    cube = d.design.cube
    middle = np.array([cube.centre_x_mm or 0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm])
    return middle + cube.half_side_mm * np.array(list(product((-1.0, 1.0), repeat=3)))


def upset_forces_N(
    d: _Machine, feet_mm: np.ndarray, ground_mm: float, plate: BenchDimensions | None = None
) -> tuple[float, float]:
    """Computes the least forces at the knob that tip and that slide a machine, by `fixed_mass` and its bench plate."""
    gravity = np.array(d.design.requirements.gravity_m_s2)
    mass, centre = fixed_mass(d)
    if plate is not None:
        own = np.array([sum(plate.x_mm) / 2, sum(plate.y_mm) / 2, plate.top_mm - plate.thickness_mm / 2])
        mass, centre = mass + plate.mass_kg, (mass * centre + plate.mass_kg * own) / (mass + plate.mass_kg)
    knob = corners_of_cube_mm(d) + np.array([0.0, 0.0, knob_centre_mm(d)])
    lines = edges(feet_mm, ground_mm, mass, np.broadcast_to(centre, knob.shape), knob, gravity)
    tips = min(float((held / lever).min()) for held, lever, _ in lines)
    return max(tips, 0.0), sliding_N_kg(gravity) * mass


def bench_dimensions(d: _Machine) -> BenchDimensions:
    """Dimensions the lightest steel plate on which a machine stands free: no wider than the machine itself, if it can.

    Of each thickness in stock that is as rigid as the base plate the smallest plate is sought that neither tips nor
    slides under `FACTOR` times the largest force; it grows from the base plate to the outline of elbows and motors. If
    that is not enough it grows to the outline that the requirements allow.

    Args:
        d: The machine without it.

    Raises:
        DimensionError: No plate in stock is enough within the outline.
    """
    force, required = FACTOR * largest_force_N(d.design.requirements), d.design.requirements
    (own_x, own_y), base = _reach_mm(d), d.base.reach_mm
    least = np.array(base) + np.array([-1.0, 1.0]) * PAD_RIM_MM
    own = np.stack([np.minimum(least[:, 0], [own_x[0], own_y[0]]), np.maximum(least[:, 1], [own_x[1], own_y[1]])], -1)
    sides = sorted((required.envelope_width_mm, required.envelope_depth_mm))
    along_y = np.ptp(own, axis=1)[1] >= np.ptp(own, axis=1)[0]
    allowed = np.array(sides if along_y else sides[::-1]) - 2.0 * _MARGIN_MM
    grown = np.maximum((allowed - np.ptp(own, axis=1)) / 2.0, 0.0)[:, None] * np.array([-1.0, 1.0])

    def made(low: np.ndarray, high: np.ndarray, share: float, thickness: float) -> BenchDimensions:
        return _bench(d, low + share * (high - low), thickness)

    def stands(one: BenchDimensions) -> bool:
        return min(one.tips_N, one.slides_N) >= force

    base_E = catalogue.material("aluminium-6082").youngs_modulus_Pa
    rigid = d.base.thickness_mm * (base_E / catalogue.material(BENCH_MATERIAL).youngs_modulus_Pa) ** (1 / 3)
    stock = [thickness for thickness in BENCH_MM if thickness >= rigid] or [BENCH_MM[-1]]
    for low, high in ((least, own), (own, own + grown)):
        found = []
        for thickness in stock:
            if not stands(made(low, high, 1.0, thickness)):
                continue
            near, far = 0.0, 1.0
            while (far - near) * float(np.abs(high - low).max()) > _MARGIN_MM:
                middle = (near + far) / 2.0
                near, far = (near, middle) if stands(made(low, high, middle, thickness)) else (middle, far)
            found.append(made(low, high, far, thickness))
        if found:
            return min(found, key=lambda one: one.mass_kg)
    largest = made(own, own + grown, 1.0, stock[-1])
    size = " x ".join(f"{edge:g}" for edge in (*largest.size_mm, largest.thickness_mm))
    message = (
        f"{force:g} N at the knob, {FACTOR:g} times the largest force, tip or slide it on any plate that the outline "
        f"allows: the largest, {size} mm of {largest.mass_kg:.1f} kg, tips at {largest.tips_N:.3g} N and slides at "
        f"{largest.slides_N:.3g} N"
    )
    wider = larger("requirements.envelope_width_mm"), larger("requirements.envelope_depth_mm")
    require(False, "bench_plate", "standing", message, *another("mounting"), *wider)
    return largest


def firmer_mounting(d: _Machine) -> str:
    """States which mounting holds a machine that does not stand: screws, and a bench plate where one is enough."""
    found = 'hardware.mounting = "screws" holds it'
    if d.bench is not None or reasons_of(lambda: bench_dimensions(d)):
        return found
    plate = bench_dimensions(d)
    size = " x ".join(f"{edge:g}" for edge in (*plate.size_mm, plate.thickness_mm))
    return f'{found}, or "plate": a steel plate of {size} mm, {plate.mass_kg:.1f} kg'


def _bench(d: _Machine, reach_mm: np.ndarray, thickness_mm: float) -> BenchDimensions:
    """A bench plate that reaches so far, (2, 2) mm, in whole millimetres inwards; with what it holds."""
    (x0, x1), (y0, y1) = ((float(ceil(low)), float(floor(high))) for low, high in reach_mm.tolist())
    density = catalogue.material(BENCH_MATERIAL).density_kg_m3 / MM_PER_M**3
    mass = ((x1 - x0) * (y1 - y0) - pi / 4 * d.base.centre_hole_mm**2) * thickness_mm * density
    top = d.base.top_mm - d.base.thickness_mm
    through = d.base.thickness_mm + thickness_mm
    screw = max(
        (one for one in catalogue.low_screw(f"low-{MOUNT_SCREW}").lengths_mm if one <= through), default=through
    )
    bare = BenchDimensions((x0, x1), (y0, y1), thickness_mm, top, screw, mass, inf, inf)
    tips, slides = upset_forces_N(d, np.array(bare.pads_mm), bare.ground_mm, bare)
    return BenchDimensions((x0, x1), (y0, y1), thickness_mm, top, screw, mass, tips, slides)


def _reach_mm(d: _Machine) -> tuple[tuple[float, float], tuple[float, float]]:
    """From where to where elbows and motors reach along x and y, at sampled positions of the cube."""
    at = np.linspace(-1.0, 1.0, _POSITIONS)
    cube = d.design.cube
    middle = np.array([cube.centre_x_mm or 0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm])
    grid = middle + cube.half_side_mm * np.array(list(product(at, repeat=3)))
    theta = joint_angles(d.design.geometry, grid / MM_PER_M)
    u, face, radius = d.bracket.motor_axis_mm[0], d.layers.motor_face_mm, d.motor.diameter_mm / 2
    drive = [(u + side * radius, face + d.motor.length_mm) for side in (-1.0, 1.0)]
    found, half = [], d.forearm.bar_length_mm / 2
    for i in CHAINS:
        flattest = float(np.clip(0.0, theta[:, i].min(), theta[:, i].max()))
        elbow, stand = d.bracket.shoulder_u_mm + d.arm.length_mm * cos(flattest), d.stand(i)
        arm = [(elbow, -half), (elbow, half), (elbow + d.arm.boss_radius_mm, 0.0)]
        found.append(np.array([*arm, *drive]) @ stand[:2, :2].T + stand[:2, 3])
    low, high = np.concatenate(found).min(axis=0).tolist(), np.concatenate(found).max(axis=0).tolist()
    return (low[0], high[0]), (low[1], high[1])
