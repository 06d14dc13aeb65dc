"""The parallelogram: cross-bars with their studs, balls, cups on the rods' ends, tubes, springs across the pair.

Cups are pressed from outside upon balls that stand on studs along the shoulder axis: the turn of a rod in the chain's
plane is a spin about the stud and free, the lean is all that a cup must give way to.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import asin, ceil, cos, degrees, pi, radians, sin, sqrt

from delta_cad import catalogue
from delta_cad.design.stands import EVEN, Gap, narrowest_gap
from delta_cad.dimensions.arm import ArmDimensions
from delta_cad.dimensions.joint import (
    CLEARANCE_MM,
    CUP_MATERIAL,
    EYE_MM,
    LINER_MM,
    JointDimensions,
    chosen_spring,
    joint_dimensions,
)
from delta_cad.dimensions.rules import ARM, BOTTOM, FOREARM, WIDTH, another, ceil_sig, larger, require, smaller
from delta_cad.mechanism.placement import spring_sway

GUSSET = (0.65, 0.9)  # of the cup's radius, along and across the rod: the gusset's shoulder, before the cup's dome
CROSS_BAR_MM = 8.0  # the least; it grows with loads and lengths
BAR_GLUE_MM = 0.02  # radial, bar in its bosses: retaining compound
BAR_WALL_MM = 1.0  # least metal around a bar that is bonded
TUBE_GLUE_MM = 0.1  # radial, spigot in the tube: what the epoxy asks
BALL_GLUE_MM = 0.025  # radial, pin in its ball: retaining compound
WRAP_RAD = radians(86.0)  # of the cup about its ball: more holds more, but at 90 deg the ball no longer drops in
_CUP_WALL_MM = 1.7  # plastic shell and metal together
LINER_GLUE_MM = 0.02  # radial, shell in its cup
END_MATERIAL, TUBE_ADHESIVE = "aluminium-6082", "araldite-2011"
TILT_MARGIN_RAD = radians(3.0)  # room beyond the largest lean
_LEAN_RAD = radians(28.0)  # where the requirements state none
_ROOM_MM = 2.0  # between a rod and the bar it hangs on, at the largest tilt, where no more is asked
_STEM_ROOM_MM = 0.5  # between the end of a rod's stem and the stud, there
_NECK_MM = 2.5  # of a rod's end between its stem and the tube: the springs bend it, the shorter the less
BAR_BEYOND_MM = 1.0  # of a cross-bar from the boss that holds it, at least: its cones are not bonded
_STUD_SHOULDER_MM = 0.8  # step from the neck to the bar's cone, radial
_EYE_Z_MM = 5.5  # and aside of it: the spring's loop passes the ring on the tube
EYE_WALL_MM = 1.4  # around its hole: a laser leaves 0.7 of the sheet at least
_PRINTED_EYE_MM = 2.0  # least hole of a printed one
EYE_PLAY_MM = 0.9  # beside the spring's wire: a cord of 0.5 mm, and room
EYE_GLUE_MM = 0.05  # radial, eye on its tube: opened with a drill of that size where the laser leaves it narrower
_EYE_RING_MM = 1.4  # around that bore, likewise
_EYE_SHEETS_MM = (2.0, 2.5, 3.0, 4.0)  # in stock, of which eyes are cut: the spring's loop goes around them
BOND_N_MM2 = 2.0  # even shear for ever, epoxy on sanded aluminium: a tenth of what it bears at once
_BOND_SAFETY = 5.0
_ROD_FORCE = 6.1  # N in a rod per N at the handle, in the worst pose and direction of the worst design looked at
_BOND_LEAST_MM = 8.0
# Of an epoxy's lap shear strength: what it bears for years. Loads that last ask for a partial safety factor of 4 at
# least (adhesivestoolkit.com, Durability Design and Testing, Safety, below its table 2). The data sheet that the row
# names tells what fluctuates: 30 % is borne 1e5 to 1e6 times, 20 % up to 1e7, 15 % more often than that.
_GLUE_USE = 0.25
_FOLD_LEAST = 0.05  # below, no rod is long enough for its springs, and is refused by its length


@dataclass(frozen=True)
class ForearmDimensions:
    """Two equal rods with a cup at either end, on the balls of the elbow's and of the wrist's cross-bar.

    Attributes:
        width_mm: Distance of the balls of a cross-bar.
        stand_off_mm: From a ball's centre to where the bar begins.
        neck_diameter_mm: Of the stud behind its ball.
        pin_diameter_mm: Of the stud's end, bonded in the ball.
        pin_past_mm: How far the pin reaches past the ball's centre.
        bar_length_mm: Between the ends of both cones.
        cone_mm: Length of the cone at 45 deg from the stud's shoulder to the bar.
        lip_mm: From the ball's centre to the plane of the lip, outwards.
        cup_radius_mm: Of the cup's outside, a sphere about the ball's centre.
        liner_radius_mm: Of the outside of the plastic shell in the cup, likewise.
        stem_mm: Along the rod, where the rod's end reaches across its axis: room for the stud that leans.
        eyes_x_mm: Along the rod, from the elbow's ball to the eyes of its two springs.
        eye_y_mm: From the rod's axis inwards to the insides of the springs' loops.
        eye_hole_y_mm: From the rod's axis inwards to the middle of an eye's hole, on whose edges the loop bears.
        eye_z_mm: From the rod's axis aside: of the first away from the arm (-z), of the second towards it (+z).
        eye_mm: Thickness of an eye: a ring on the tube with a lug, cut from sheet.
        eye_room_mm: Least distance of the eyes' lugs from the arm that folds beside them, the rods not turned.
        shoulder_mm: Along the rod, from the ball's centre to the tube.
        room_mm: Between a rod and the bar it hangs on, at the largest tilt.
        tilt_limit_rad: Tilt that the joint is made for, clear of everything; springs hold the rods' turn within it.
        wrist_radius_min_mm: Smallest platform radius at which the cups of neighbouring chains keep clear.
    """

    length_mm: float
    width_mm: float
    ball_diameter_mm: float
    seat_diameter_mm: float
    neck_diameter_mm: float
    pin_diameter_mm: float
    pin_past_mm: float
    stand_off_mm: float
    bar_diameter_mm: float
    bar_length_mm: float
    cone_mm: float
    lip_mm: float
    cup_radius_mm: float
    liner_radius_mm: float
    stem_mm: float
    eyes_x_mm: tuple[float, float]
    eye_y_mm: float
    eye_hole_y_mm: float
    eye_z_mm: float
    eye_diameter_mm: float
    eye_mm: float
    eye_room_mm: float
    shoulder_mm: float
    spigot_diameter_mm: float
    spigot_length_mm: float
    tube_outer_mm: float
    tube_bore_mm: float
    tube_length_mm: float
    room_mm: float
    tilt_limit_rad: float
    wrist_radius_min_mm: float
    ball: catalogue.Ball
    spring: catalogue.TensionSpring
    joint: JointDimensions

    @property
    def eye_bore_mm(self) -> float:
        """Bore of an eye around its tube."""
        return self.tube_outer_mm + 2 * EYE_GLUE_MM

    @property
    def eye_ring_mm(self) -> float:
        """Diameter of an eye's ring."""
        return self.eye_bore_mm + 2 * _EYE_RING_MM

    @property
    def between_eyes_mm(self) -> float:
        """Length of a spring between its eyes at no lean."""
        return self.width_mm - 2 * self.eye_y_mm


def wrist_radius_min_mm(
    cup_radius_mm: float, width_mm: float, clearance_mm: float, gaps: Sequence[Gap] = EVEN
) -> float:
    """Computes the platform radius at which the cups of neighbouring chains are a clearance apart, mm.

    A wrist lies `r sin(h) - L_c / 2 cos(h)` from the plane half-way to its neighbour's, h being half the angle between
    both chains; a cup reaches its sphere's radius.
    """
    gap = narrowest_gap(gaps)
    return (cup_radius_mm + clearance_mm / 2 + width_mm * gap.half_cosine / 2) / gap.half_sine


def eyes_mm(
    arm: ArmDimensions, fold_rad: float, lean_rad: float, next_to_mm: float, length_mm: float, end_mm: float
) -> tuple[float, float]:
    """Computes where along a rod its two springs are hung, from the elbow's ball, mm.

    Rods fold until they lie beside the arm. The arm is the hull of two circles, of its boss and of its root, `L` apart:
    a spring `x` along the rod and `z` aside, away from the arm, is `x cos(lean) sin(phi - b) + z cos(phi - b) - r` off
    its edge, with `sin(b) = (root - r) / L`. The first spring lies away from the arm, near the elbow; the second on the
    other side, near the wrist: their torques on the rod cancel, and both balls are pressed.

    Args:
        arm: The upper arm.
        fold_rad: Least angle between upper arm and rod, at the elbow.
        lean_rad: Largest lean.
        next_to_mm: Least distance of a spring's axis from the arm.
        length_mm: Of the rod.
        end_mm: Least distance of an eye from a ball.
    """
    turn = min(fold_rad - asin((arm.beam_root_radius_mm - arm.boss_radius_mm) / arm.length_mm), pi / 2)
    needed, rise = arm.boss_radius_mm + next_to_mm, max(sin(turn), _FOLD_LEAST) * cos(lean_rad)
    first = max(end_mm, (needed - _EYE_Z_MM * cos(turn)) / rise)
    return first, max(length_mm - first, (needed + _EYE_Z_MM * cos(turn)) / rise)


def _eye_room_mm(arm: ArmDimensions, fold_rad: float, lean_rad: float, along_mm: float, around_mm: float) -> float:
    """Computes how far what stands around a rod stays off the arm that folds beside it, see `eyes_mm`, mm.

    Args:
        arm: The upper arm.
        fold_rad: Least angle between upper arm and rod, at the elbow.
        lean_rad: Largest lean.
        along_mm: From the elbow along the rod.
        around_mm: Reach from the rod's axis, in any direction.
    """
    turn = min(fold_rad - asin((arm.beam_root_radius_mm - arm.boss_radius_mm) / arm.length_mm), pi / 2)
    return along_mm * sin(turn) * cos(lean_rad) - arm.boss_radius_mm - around_mm


def tilt_N_mm2() -> float:
    """Gives the stress across the bond of a spigot that it may bear for ever."""
    strength = catalogue.adhesive(TUBE_ADHESIVE).shear_strength_MPa
    assert strength is not None
    return _GLUE_USE * strength


def _tilted_mm(moment_N_mm: float, spigot_mm: float) -> float:
    """Computes how long the bond of a spigot must be for the moment that its springs tilt it by for ever, mm.

    Its stress across is `6 M / (d b^2)`; along it bears all that it may of the rod's force as well.
    """
    across = sqrt(tilt_N_mm2() ** 2 - BOND_N_MM2**2)
    return sqrt(6.0 * moment_N_mm / (spigot_mm * across))


def _eye_mm(force_N: float, tube_mm: float) -> float:
    """Chooses the sheet of which a spring's eyes are cut: the thinnest whose bond holds the spring's largest force.

    The force turns the ring about the tube at the lug's lever `z`: `F z / (pi d^2 w / 2)` of shear for ever.
    """
    needed = 2.0 * force_N * _EYE_Z_MM / (pi * tube_mm**2 * BOND_N_MM2)
    return next((sheet for sheet in _EYE_SHEETS_MM if sheet >= needed), _EYE_SHEETS_MM[-1])


def _ball(diameter_mm: float) -> catalogue.Ball:
    """The finest ball of a diameter in the catalogue."""
    rows = [row for row in catalogue.ball.rows.values() if isinstance(row, catalogue.Ball)]
    stock = sorted({row.diameter_mm for row in rows})
    require(
        diameter_mm in stock,
        "joint_ball",
        "diameter",
        f"the catalogue has no ball of {diameter_mm:g} mm; it has {', '.join(f'{v:g}' for v in stock)} mm",
        *another("ball_diameter_mm"),
    )
    return min(rows, key=lambda row: (abs(row.diameter_mm - diameter_mm), row.grade))


def forearm_dimensions(
    *,
    length_mm: float,
    width_mm: float,
    ball_mm: float,
    boss_width_mm: float,
    arm: ArmDimensions,
    fold_rad: float,
    tube: catalogue.Tube,
    force_N: float,
    lean_max_deg: float | None,
    clearance_mm: float,
    bar_mm: float = CROSS_BAR_MM,
    peak_N: float = 0.0,
    wrist_boss_mm: float = 0.0,
    gaps: Sequence[Gap] = EVEN,
    printed_eyes: bool = False,
) -> ForearmDimensions:
    """Dimensions a parallelogram of a length between ball centres and a width along the shoulder axis.

    Args:
        length_mm: Between the ball centres of a rod.
        width_mm: Between the ball centres of a cross-bar.
        ball_mm: Diameter of the balls, of the catalogue.
        boss_width_mm: Of the elbow's boss, which holds the cross-bar.
        arm: The upper arm, over which the elbow's spring folds.
        fold_rad: Least angle between upper arm and rod, at the elbow.
        tube: What the rods are cut of.
        force_N: At the handle, for ever; the bond of tube and spigot is made for it.
        lean_max_deg: Largest lean; None: 28 deg.
        clearance_mm: Between cups of neighbouring chains, and between a rod with its springs and what it hangs on.
        bar_mm: Diameter of the cross-bars.
        peak_N: Largest force at the handle; the springs are made for it.
        wrist_boss_mm: Diameter of the platform's bosses, which a thicker platform has, beside its springs.
        gaps: Of the chains.
        printed_eyes: Whether the springs' eyes are printed.

    Raises:
        DimensionError: No such ball; too narrow for the elbow boss that holds the cross-bar, or for any spring; too
            short for the rods' ends.
    """
    row, room = _ball(ball_mm), max(_ROOM_MM, clearance_mm)
    lean = _LEAN_RAD if lean_max_deg is None else radians(lean_max_deg)
    tilt = lean + TILT_MARGIN_RAD
    neck, pin = round(0.565 * ball_mm, 1), round(0.42 * ball_mm, 1)  # as strong in the ball as at the bar
    rod, step = tube.outer_mm / 2, neck / 2 + _STUD_SHOULDER_MM
    stand_off = ceil(10.0 * (rod + room + step * sin(tilt)) / cos(tilt)) / 10.0
    stem = ceil(10.0 * (step + _STEM_ROOM_MM + rod * sin(tilt)) / cos(tilt)) / 10.0
    bar, cone = width_mm - 2 * stand_off, bar_mm / 2 - step
    narrowest = boss_width_mm + 2 * max(BAR_BEYOND_MM, cone) + 2 * stand_off
    require(
        width_mm >= narrowest - 1e-9,
        "cross_bar",
        "length",
        f"{width_mm:g} mm between its balls are too narrow for the elbow's boss; at least {ceil_sig(narrowest)} mm",
        larger(WIDTH),
    )
    spring = chosen_spring(width_mm - 2 * EYE_MM, EYE_MM, peak_N)
    seat = ball_mm + 2 * CLEARANCE_MM
    coil = spring.mean_diameter_mm + spring.wire_mm
    eye = max(spring.wire_mm + EYE_PLAY_MM, _PRINTED_EYE_MM if printed_eyes else 0.0)
    loop = (spring.mean_diameter_mm - spring.wire_mm) / 2  # radius inside
    shoulder = stem + _NECK_MM
    sway = spring_sway(width_mm, EYE_MM, _EYE_Z_MM, tilt)  # of a spring whose rods lean, and turn about themselves
    adjacent = coil / 2 + room + sway.across_mm + sway.turn_rad * boss_width_mm / 2
    sheet = _eye_mm(spring.force_max_N, tube.outer_mm)
    end = max(shoulder + sheet, max(bar_mm / 2 + BAR_WALL_MM, wrist_boss_mm / 2) + adjacent + _EYE_Z_MM)
    first, second = eyes_mm(arm, fold_rad, lean, adjacent, length_mm, end)
    require(
        length_mm - second >= end - 1e-9,
        "rod_eye",
        "springs",
        f"rods that fold to {degrees(fold_rad):.1f} deg beside the arm leave the eyes of its springs "
        f"{length_mm - second:.2f} mm to the wrist; at least {end:.2f}",
        larger(FOREARM),
        larger(BOTTOM),
        smaller(ARM),
    )
    spigot = tube.inner_mm - 2 * TUBE_GLUE_MM
    joint = joint_dimensions(
        ball_mm=ball_mm,
        wrap_rad=WRAP_RAD,
        spring=spring,
        width_mm=width_mm,
        eye_mm=EYE_MM,
        lever=(first + second) / length_mm - 1.0,
        lean_rad=lean,
        cup=catalogue.material(CUP_MATERIAL),
        ball=catalogue.material(row.material),
    )
    sheared = _BOND_SAFETY * _ROD_FORCE * force_N / (BOND_N_MM2 * pi * spigot)
    held = max(_BOND_LEAST_MM, ceil(sheared), ceil(_tilted_mm(joint.pressed_max_N * shoulder, spigot)))
    least = max(24.0, 2 * held + 4.0)
    tube_length = length_mm - 2 * shoulder
    require(
        tube_length >= least,
        "rod_tube",
        "length",
        f"{tube_length:g} mm are left for a tube between its ends; at least {least:g}",
        larger(FOREARM),
    )
    cup = seat / 2 + _CUP_WALL_MM
    return ForearmDimensions(
        length_mm=length_mm,
        width_mm=width_mm,
        ball_diameter_mm=ball_mm,
        seat_diameter_mm=seat,
        neck_diameter_mm=neck,
        pin_diameter_mm=pin,
        pin_past_mm=round(0.1 * ball_mm, 1),
        stand_off_mm=stand_off,
        bar_diameter_mm=bar_mm,
        bar_length_mm=bar,
        cone_mm=cone,
        lip_mm=seat / 2 * cos(WRAP_RAD),
        cup_radius_mm=cup,
        liner_radius_mm=seat / 2 + LINER_MM,
        stem_mm=stem,
        eyes_x_mm=(first, second),
        eye_y_mm=EYE_MM,
        eye_hole_y_mm=EYE_MM + loop - sqrt(loop**2 - (sheet / 2) ** 2) - eye / 2,
        eye_z_mm=_EYE_Z_MM,
        eye_diameter_mm=eye,
        eye_mm=sheet,
        eye_room_mm=_eye_room_mm(arm, fold_rad, lean, min(first, second), _EYE_Z_MM + eye / 2 + EYE_WALL_MM),
        shoulder_mm=shoulder,
        spigot_diameter_mm=spigot,
        spigot_length_mm=held,
        tube_outer_mm=tube.outer_mm,
        tube_bore_mm=tube.inner_mm,
        tube_length_mm=tube_length,
        room_mm=room,
        tilt_limit_rad=tilt,
        wrist_radius_min_mm=wrist_radius_min_mm(cup, width_mm, clearance_mm, gaps),
        ball=row,
        spring=spring,
        joint=joint,
    )
