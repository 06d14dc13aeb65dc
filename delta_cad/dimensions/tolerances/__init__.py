"""Fits, thread run-outs and drills of what is made; what tolerances make of a shoulder's preload and alignment."""

from __future__ import annotations

from bisect import bisect_left
from math import ceil, pi, radians, tan

from delta_cad import catalogue
from delta_cad.dimensions.bracket import BracketDimensions
from delta_cad.dimensions.layers import SPAN_MM

LENGTH_MM = 0.02  # either way, of every length of the shoulder's stack: milled or turned in one clamping, and measured
STACK = 5  # such lengths: arm, sector, foot block, depth of the seat in either cheek
WIDTH_MM = 0.12  # by which a bearing may be narrower, ISO 492 normal class up to a bore of 10 mm, as of 10 to 18
WAVE_SHARE = 0.2  # of a wave spring's force and rate by which they may be larger than stated; they are never smaller
WORKING = (0.2, 0.8)  # share of its free height over its strip by which a wave spring is pressed, as makers advise
DOWEL_PLAY_MM = 0.004  # of radius, at most: 3 m6 in H7
MANDREL_FIT, MANDREL_MM = "h5", 0.008  # by which it may be thinner than its seats' nominal diameter, up to 18 mm
LIP_ROOM_MM = 0.1  # of a cup's lip over the rod jig's pad
JIG_DEPTH_MM, JIG_MOUTH_MM = (
    0.05,
    0.05,
)  # either way, of depth and diameter of the jig's seats: both move a ball's height
SEATS_MM = 0.018, 0.011  # by which they may be wider: H7 of the motor's cheek, H6 of the encoder's
TILT_RAD = radians(10.0 / 60.0)
"""Tilt that a deep groove bearing bears: 2 to 10 minutes of arc by its clearance.

Source: RBC Bearings, misalignment: 0.0005 to 0.003 (rbcbearings.com/ballbearings/misalignment.htm); GRW gives at least
13 minutes of free tilt for a 608 of clearance C4, and warns of noise beyond 2 to 3
(iecltd.co.uk/catalogues/grw/misalignment).
"""
END_TORQUE_N_m = {"M2.5": 0.5, "M3": 1.0, "M4": 2.2}
"""Torque of a stainless screw in a shaft's end: 0.7 of its proof stress at a friction of 0.14 (VDI 2230)."""

MAGNET_WIDER_UM = 30.0
"""By which a magnet's seat may be wider: bonded, and never too narrow."""
BALL_CENTRE_MM = 0.05  # from a ball's centre to the axis of its hole, at most
EROSION_UM = 20.0  # diameter of a ball's eroded hole, either way
TUBE_SHORTER_MM = 0.3  # by which a rod's tube may be shorter; a longer one holds the ends apart in the jig
SPIGOT_TURNED_MM = 0.05  # diameter of a rod end's spigot, either way: a quarter of the bond on either side
LINER_TURNED_MM = 0.01  # diameters of a plastic shell and of its cup, either way: half of the bond between them
BAR_WIDER_UM = 20.0  # by which a cross-bar's bore may be wider than nominal: the bond's thickness
NOMINAL_MM = (3.0, 6.0, 10.0, 18.0, 30.0, 50.0, 80.0, 120.0)
"""Upper ends of the ranges of nominal diameter of the two tables below."""
GRADES_UM = {
    5: (4, 5, 6, 8, 9, 11, 13, 15),
    6: (6, 8, 9, 11, 13, 16, 19, 22),
    7: (10, 12, 15, 18, 21, 25, 30, 35),
}
"""Standard tolerances, um. Source: ISO 286-1, table 1; 6, 7 as precisemetal.in/tolerence-table.php has them."""
FREE_UM = {"H": (0,) * 8, "G": (2, 4, 5, 6, 7, 9, 10, 12), "m": (2, 4, 6, 7, 8, 9, 11, 13)}
"""Least deviations of a bore from its nominal diameter, of a pin `m` too, um. Source: ISO 286-1, tables 5 and 6."""
FITTED_RA_UM = {5: 0.4, 6: 0.8, 7: 1.6}
"""Roughness Ra that goes with a grade: ground or honed, finely bored, reamed."""
PLACE_MM = 0.05
"""Zone for the axes of a part's fitted bores, as milled in one clamping; how square a pin's or a pilot's is to the face
that its part stands on, too, which the check of mates holds."""
RING_UM = 8.0  # by which a bearing's bore or outside may be smaller than nominal, ISO 492 normal class up to 18 mm
PRINTED_PLACE_MM = 0.4
"""The same of a printed part, whose holes are reamed where they are printed: +-0.2 mm, as printing services state.

Source: arti90.com/en/design-clues, printit4me.com.au/guides/designing-for-3d-printing (both read 2026-11-28).
"""
PRINTED_WIDER_UM = 200.0  # by which a cross-bar's bore in a printed boss may be wider: epoxy fills that
SLOT_MM, SLOT_CUTTER_MM = 0.4, 2.0  # by which a pin's slot is longer than wide; of the cutter that mills it
PREDRILLED_MM, PREDRILLED_ZONE_MM = 2.5, 0.05  # of holes for 3 mm pins that are reamed together: drill, zone
STOP_ZONE_MM = 0.1  # of a stop pin, and of the ends of the sector's slot, which meet it
MOTOR_ZONE_MM, BOARD_ZONE_MM = 0.2, 0.1
"""Zones of the threads in a motor's face, about its pilot, and of the holes of a circuit board, of which makers state
none: ISO 2768-m of such circles, and what boards are drilled to; the check of mates states the largest borne."""
CHIP_PLACE_MM, CHIP_HEIGHT_MM = 0.1, 0.25
"""Either way: a chip's sensor from the middle of its board's holes, 0.05 in its package and 0.05 of that; its height,
0.85 to 1.2 of a TSSOP-16. Source: MT6835 data sheet, 13."""
BOARD_THREADS_MM = 0.2  # zone of an encoder board's threads, at most: half of it adds to the encoder's centring
COAXIAL_MM = 0.05  # zone for the axis of an encoder's magnet in its shaft: half of it adds to the encoder's centring
TRUE_MM = 0.05  # zone for the axes of a pinion's groove and of a cross-bar's studs, half of it in their chains
RUN_OUT_MM = {0.4: 1.5, 0.45: 1.6, 0.5: 1.8, 0.7: 2.4, 0.8: 2.7, 1.0: 3.2, 1.25: 3.9, 1.5: 4.6}
"""From a thread's usable end to the full depth of its blind drill, by pitch, mm. Source: DIN 76-1, e2 (short)."""
DRILL_STEP_MM = 0.5  # to which the depth of a drill is rounded up
TIP_DEG = 118.0  # point angle of a twist drill, DIN 338 type N


def deviations_um(fit: str, nominal_mm: float) -> tuple[int, int]:
    """Looks up the lower and the upper deviation of a bore, of a shaft `h` or of a pin `m`, um.

    Args:
        fit: Tolerance class, such as "H7", "G7", "h6".
        nominal_mm: Nominal diameter, above 0 and up to 120 mm.

    Raises:
        ValueError: The class or the diameter is not in the tables.
    """
    letter, grade = fit[:1], int(fit[1:]) if fit[1:].isdigit() else 0
    if letter not in (*FREE_UM, "h") or grade not in GRADES_UM or not 0.0 < nominal_mm <= NOMINAL_MM[-1]:
        raise ValueError(
            f"fit {fit} of {nominal_mm:g} mm: known are G, H, h and m of grades {min(GRADES_UM)} to {max(GRADES_UM)} "
            f"up to {NOMINAL_MM[-1]:g} mm"
        )
    row = bisect_left(NOMINAL_MM, nominal_mm)
    wide = GRADES_UM[grade][row]
    return (-wide, 0) if letter == "h" else (FREE_UM[letter][row], FREE_UM[letter][row] + wide)


def bar_bore(printed: bool) -> tuple[float, float]:
    """Gives by how much a cross-bar's bore may be wider than nominal, um, and the zone for its axis, mm, by process."""
    return (PRINTED_WIDER_UM, PRINTED_PLACE_MM) if printed else (BAR_WIDER_UM, PLACE_MM)


def drilled_mm(size: str, thread_mm: float) -> float:
    """Computes how deep a blind hole is drilled, to its full diameter, for a usable depth of thread, mm.

    Args:
        size: Thread, such as "M4".
        thread_mm: Usable depth.
    """
    depth = thread_mm + RUN_OUT_MM[catalogue.screw(size).pitch_mm]
    return DRILL_STEP_MM * ceil(depth / DRILL_STEP_MM - 1e-9)


def tip_mm(diameter_mm: float, tip_deg: float = TIP_DEG) -> float:
    """Gives the height of a drill's tip, mm; 0 for a flat end, `tip_deg` = 0."""
    return diameter_mm / 2.0 / tan(radians(tip_deg) / 2.0) if tip_deg else 0.0


def spring_height_mm(spring: catalogue.WaveSpring) -> tuple[float, float]:
    """Computes the least and the largest height that the shoulder's stack leaves its wave spring, mm.

    The height is foot block and both seats' depths less arm, sector and both bearings.
    """
    return spring.work_height_mm - STACK * LENGTH_MM, spring.work_height_mm + STACK * LENGTH_MM + 2 * WIDTH_MM


def preload_range_N(spring: catalogue.WaveSpring) -> tuple[float, float]:
    """Computes the least and the largest preload of a shoulder's bearings over all tolerances, N."""
    rate = spring.rate_N_mm
    if rate is None:
        rate = spring.force_N / (spring.free_height_mm - spring.work_height_mm)
    low, high = spring_height_mm(spring)
    return (
        spring.force_N - rate * (high - spring.work_height_mm),
        spring.force_N + rate * (spring.work_height_mm - low),
    )


def working_mm(spring: catalogue.WaveSpring) -> tuple[float, float]:
    """Gives the heights between which a wave spring works, mm: lowest and highest."""
    way = spring.free_height_mm - spring.thickness_mm
    return spring.free_height_mm - WORKING[1] * way, spring.free_height_mm - WORKING[0] * way


def seat_tilt_rad(bracket: BracketDimensions) -> float:
    """Computes the largest tilt of a shoulder's shaft in its bearings by their seats' offset, rad.

    Both cheeks' dowel holes are reamed on the foot block with a mandrel through the two seats. What is left is the
    mandrel's play in them, and that of the dowels when a cheek has been off: it turns a cheek by twice the play over
    the dowels' distance, opposite ways, and lifts it by once the play.
    """
    apart = bracket.cheek_dowel_u_mm[1] - bracket.cheek_dowel_u_mm[0]
    by_mandrel = sum(wide + MANDREL_MM for wide in SEATS_MM) / 2
    by_dowels = 2 * DOWEL_PLAY_MM * (1.0 + 2 * -bracket.cheek_screw_z_mm / apart)
    return (by_mandrel + by_dowels) / SPAN_MM


def minutes(angle_rad: float) -> float:
    """Gives an angle in minutes of arc."""
    return angle_rad * 180.0 / pi * 60.0
