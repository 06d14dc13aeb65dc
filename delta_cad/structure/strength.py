"""Allowable loads of every part, computed from its dimensions, with sources.

A redesigned part changes its lines here, as it does in `beam_model.py`.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, hypot, pi, radians, sin, sqrt

from delta_cad import catalogue
from delta_cad.catalogue.families.fasteners.insert import insert_of
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import CLAMP_SCREW, DOWEL_MM
from delta_cad.dimensions.capstan import ROPE_FACTOR, SET_SCREW, WEB_MM, SET_TORQUE_N_m
from delta_cad.dimensions.forearm import BOND_N_MM2, END_MATERIAL, ForearmDimensions, tilt_N_mm2
from delta_cad.dimensions.joint import CUP_MATERIAL, SPRING_SHARE
from delta_cad.dimensions.tolerances import preload_range_N
from delta_cad.dimensions.tolerances.cable_setting import CableSetting, cable_setting
from delta_cad.drive import drive_torque
from delta_cad.structure.beam_model import moduli_N_mm2
from delta_cad.structure.bearing import BallBearing, ball_bearing
from delta_cad.structure.section import ring

BUCKLING_FACTOR = 3.0  # Euler's load over what a rod may bear: its joints' play and its own bow take the rest
_RETAINED_N_mm2 = 6.0  # shear of a retaining compound on aluminium with primer: a fifth of what it bears on steel
_SCREW_PROOF_N_mm2 = 450.0  # A2-70, ISO 3506-1
_SCREW_USE = 0.7  # of the proof stress when tightened by hand with a torque key, torsion included (VDI 2230)
_SCREW_FRICTION = 0.14  # of thread and head, dry stainless on aluminium, thread lock included (VDI 2230, class B)
PRESSED_N_mm2 = 125.0  # pressure of a pin on EN AW-6082: half its proof stress
_GLUED_N_mm2 = 1.5  # shear of epoxy on sanded PETG or polyamide, a quarter of what it bears at once; from memory: check
_PRINT_FRICTION = 0.25  # of a printed bore on a ground shaft, the low end of PETG and polyamide on steel; from memory
_SHEAR_SHARE = 0.577  # of a plastic's strength in shear (von Mises)
_FACE_FRICTION = 0.12  # of two dry machined faces of aluminium, the low end (VDI 2230)
_MOTOR_RADIAL_N = 28.0  # 5 mm before the flange: RE 30, as its row
_MOTOR_SHAFT_MM = 6.0  # whose shaft has 5 by those who use it: what has no figure of its own bears more than is taken
_MOTOR_LOAD_MM = 5.0
_MOTOR_SPAN = 0.7  # distance of a motor's two bearings over its length; from memory
_END_USE = 0.5  # of the proof stress of aluminium, which does not creep at room temperature
_PLASTIC_USE = 0.25  # of the yield stress: what thermoplastics bear for years at room temperature; from memory: check
LIFE_HOURS = 10_000.0  # five years of eight hours a working day
STROKES_PER_S = 0.5  # the duty: full strokes there and back, at the worst place under the whole force


@dataclass(frozen=True)
class Allowables:
    """Levers and limits of load-bearing parts, mm, N, N mm, N/mm^2; None where a direct drive has no such part.

    Attributes:
        bearing: Of the shoulder.
        stroke_rad: From the smallest to the largest shoulder angle over the cube.
        preload_N: Axial, of the shoulder's bearings, the least over the tolerances.
        motor_N: What the motor's shaft may bear across for ever.
        peak_share: Of the time that the motor's winding bears the peak torque that the controller lets it give.
        stub_mm: Diameter of the motor's shaft where it carries the arm.
        stub_lever_mm: From the motor's face to the arm's middle.
        stub_N_mm2: Proof stress of that shaft.
        setting: How the cable is tensioned, and what of it the strands bear and hold.
        middle_rad: Shoulder angle in the middle of the arm's stroke.
        cable_N: What the cable may bear.
        pinion_N: Difference between the strands that the pinion's set screws hold on the motor's shaft.
        stud_1_mm2: Largest bending stress in a stud for 1 N of a rod square to it.
        stud_N_mm2: Proof stress of the stud.
        forearm: The rods, for their ends and ball joints.
        preload_reserve_N: Least preload that must be left when a joint bears its load.
        end_N_mm2: Stress that a rod's end may bear for ever.
        plastic_N_mm2: Pressure that the shell of a cup may bear for ever.
        tilt_N_mm2: Stress across the bond of a spigot that it may bear for ever.
        bond_mm2: Area by which a cup's spigot is bonded into the tube.
        bond_N_mm2: Shear stress that the bond may bear.
        buckling_N: What a rod may bear in compression.
        hub_N_mm: Tilting moment that the arm's seat on its shaft holds.
        bar_1_mm3: Shear in a cross-bar's bond for 1 N mm of tilting moment.
        bar_mm2: Area of that bond.
        bar_N_mm2: Shear stress that it may bear.
        arm_1_mm3: Largest stress in the root of an upper arm by tilt and by torque of 1 N mm; None where it is cut.
        arm_N_mm2: What a printed one may bear across its layers for ever.
        grip_N_mm: Torque that a printed clamp holds on the motor's shaft by friction; None where it is cut.
        spoke_1_mm3: Largest stress in a platform's web for 1 N mm at its wrist; None where it is cut.
        spoke_N_mm2: As of the arm.
        sector_mm: Radius of the circle of the dowels between arm and sector.
        sector_pins: How many these are.
        sector_N: What one of them may bear.
        foot_mm: Height of the shoulder over the screws of the cheeks.
        foot_pins_mm: Distance of the dowels of a cheek.
        foot_pin_N: What one of them may bear.
        foot_edge_mm: From the screws of a cheek to the edge of the block that it would tilt over.
        foot_screw_N: Clamping force of one of these screws.
        motor_mm: From the motor's face to the strands on its pinion.
        motor_edge_mm: From the middle of its screws to the edge that it would tilt over.
        motor_slip: Clamping force of a screw that keeps the motor from turning, for a force of 1 N at the cable.
        motor_screws: How many hold it.
        motor_screw_N: Clamping force of one of them.
        base_mm: Height of the shoulder over the base plate.
        base_edge_mm: From the middle of the foot block to the edge that it would tilt over.
        base_screw_N: Clamping force of one of the screws from below.
    """

    bearing: BallBearing | None
    stroke_rad: float
    preload_N: float
    motor_N: float
    peak_share: float
    stub_mm: float | None
    stub_lever_mm: float
    stub_N_mm2: float
    setting: CableSetting | None
    middle_rad: float
    cable_N: float | None
    pinion_N: float | None
    stud_1_mm2: float
    stud_N_mm2: float
    forearm: ForearmDimensions
    preload_reserve_N: float
    end_N_mm2: float
    plastic_N_mm2: float
    tilt_N_mm2: float
    bond_mm2: float
    bond_N_mm2: float
    buckling_N: float
    hub_N_mm: float
    bar_1_mm3: float
    bar_mm2: float
    bar_N_mm2: float
    arm_1_mm3: tuple[float, float] | None
    arm_N_mm2: float
    grip_N_mm: float | None
    spoke_1_mm3: float | None
    spoke_N_mm2: float
    sector_mm: float | None
    sector_pins: int
    sector_N: float
    foot_mm: float
    foot_pins_mm: float
    foot_pin_N: float
    foot_edge_mm: float
    foot_screw_N: float
    motor_mm: float
    motor_edge_mm: float
    motor_slip: float
    motor_screws: int
    motor_screw_N: float
    base_mm: float
    base_edge_mm: float
    base_screw_N: float


def screw_N(row: catalogue.Screw) -> float:
    """Computes the clamping force of a stainless cap screw that is tightened as usual, N.

    Source:
        VDI 2230: a share of the proof stress on the stress area `pi/4 (d - 0.9382 P)^2` (ISO 898-1); or on less where
        a low head bears less than the thread: below its socket.
    """
    area = pi / 4.0 * (row.diameter_mm - 0.9382 * row.pitch_mm) ** 2
    return _SCREW_USE * _SCREW_PROOF_N_mm2 * min(area, _head_mm2(row))


def lasting_N_mm2(d: Dimensions, number: str) -> float:
    """Gives the stress that a printed part may bear across its layers for ever, N/mm^2."""
    strength = catalogue.material(d.material_of(number)).design_strength_Pa
    assert strength is not None
    return _PLASTIC_USE * strength * 1e-6


def clamping_N(d: Dimensions, row: catalogue.Screw, held: str = "", threaded: str = "") -> float:
    """Computes the clamping force that a screw keeps between two parts, either of which may be printed, N.

    Of metal it is what the screw is tightened to. Plastic creeps under more than a quarter of its strength: under the
    head's ring, and around the insert that the thread is in, whose plastic shears on the cylinder over its knurls.

    Args:
        d: The machine.
        row: The screw.
        held: Number of the part under its head; "": metal.
        threaded: Number of the part with its thread; "": metal.
    """
    found = screw_N(row)
    if d.is_printed(held):
        ring = pi / 4.0 * (row.head_diameter_mm**2 - row.clearance_hole_mm**2)
        found = min(found, lasting_N_mm2(d, held) * ring)
    if d.is_printed(threaded):
        insert = insert_of(row.id)
        sheared = 0.0 if insert is None else pi * insert.outer_mm * insert.length_mm
        found = min(found, _SHEAR_SHARE * lasting_N_mm2(d, threaded) * sheared)
    return found


def _head_mm2(row: catalogue.Screw) -> float:
    """Computes the section in tension that bears what a head does on the cone between its socket's floor and the shank.

    The cone bears the force by tension across it and by shear along it (von Mises); the socket counts as a circle of
    its area. DIN 7984 states less than the thread's tensile loads for the same reason.
    """
    inner, outer = row.socket_mm * sqrt(sqrt(3.0) / (2.0 * pi)), row.diameter_mm / 2.0
    width, height = outer - inner, row.head_height_mm - row.socket_depth_mm
    return pi * (inner + outer) * (width**2 + height**2) / sqrt(width**2 + 3.0 * height**2)


def tightening_N_m(row: catalogue.Screw) -> float:
    """Computes the torque by which a stainless screw gets its clamping force, N m.

    Source:
        VDI 2230: `F (0.159 P + 0.577 d2 mu + Dk / 2 mu)` with d2 of ISO 724 and Dk between head and clearance hole.
    """
    flank = row.diameter_mm - 0.6495 * row.pitch_mm
    under_head = (row.head_diameter_mm + row.clearance_hole_mm) / 4.0
    lever = 0.159 * row.pitch_mm + _SCREW_FRICTION * (0.577 * flank + under_head)
    return screw_N(row) * lever / MM_PER_M


def set_screws_N_mm(d: Dimensions) -> float:
    """Computes the torque that a pinion's set screws hold on the motor's shaft by the friction of their tips, N mm.

    A tip's ring is as wide as the hole that its thread is cut into, which is more than it is: safe. So is to leave out
    its bite and the friction of the bore opposite.

    Source:
        VDI 2230, as in `tightening_N_m`, the tip in place of the head.
    """
    row = catalogue.set_screw(SET_SCREW)
    flank, tip = row.diameter_mm - 0.6495 * row.pitch_mm, row.tap_drill_mm / 2.0
    force = SET_TORQUE_N_m * MM_PER_M / (0.159 * row.pitch_mm + _SCREW_FRICTION * (0.577 * flank + tip))
    return len(d.set_screws_rad) * _FACE_FRICTION * force * d.motor.shaft_diameter_mm / 2.0


def clamp_N_mm(size: str, width_mm: float) -> float:
    """Computes the tilting moment at which a split clamp opens at one end of its bore, N mm.

    The screw presses the bore evenly over its width; a moment adds a pressure that grows linearly, and takes the last
    of it from one end at F b / 6 (core of a rectangle). The screw's lever about the slit's end is left out: safe.
    """
    return screw_N(catalogue.screw(size)) * width_mm / 6.0


def stack_N_mm(size: str, outer_mm: float, inner_mm: float) -> float:
    """Computes the tilting moment at which an arm that is clamped along its shaft opens at one edge, N mm.

    The screw presses the ring of the collar evenly; a moment takes the last of it from one edge at F k with k the core
    of a ring, (Ro^2 + Ri^2) / (4 Ro).
    """
    outer, inner = outer_mm / 2.0, inner_mm / 2.0
    return screw_N(catalogue.screw(size)) * (outer**2 + inner**2) / (4.0 * outer)


def stud_stress_1_mm2(f: ForearmDimensions) -> float:
    """Computes the largest bending stress in a stud for 1 N of its rod, square to it: in the pin or in the neck."""
    rim = sqrt((f.ball_diameter_mm / 2) ** 2 - (f.pin_diameter_mm / 2) ** 2)
    sections = ((rim, f.pin_diameter_mm), (f.stand_off_mm, f.neck_diameter_mm))
    return max(32.0 * lever / (pi * diameter**3) for lever, diameter in sections)


def allowables(d: Dimensions) -> Allowables:
    """Gathers what the parts of a design may bear."""
    f, b, layers = d.forearm, d.bracket, d.layers
    report, capstan = drive_torque(d.design), d.capstan
    shoulder = d.extremes.shoulder_max.value - d.extremes.shoulder_min.value
    young, _ = moduli_N_mm2(d.tube.material)
    euler = pi**2 * young * ring(f.tube_outer_mm, f.tube_bore_mm).about_y_mm4 / f.length_mm**2
    stud, steel = (catalogue.material(one).yield_strength_Pa for one in ("aluminium-7075", "steel"))
    assert stud is not None
    assert steel is not None
    arm = layers.arm_mm[1] - layers.arm_mm[0]
    boss = layers.elbow_boss_mm[1] - layers.elbow_boss_mm[0]
    cheek = min(y1 - y0 for y0, y1 in (layers.encoder_cheek_mm, layers.motor_cheek_mm))
    metal, plastic = (catalogue.material(one).yield_strength_Pa for one in (END_MATERIAL, CUP_MATERIAL))
    assert metal is not None
    assert plastic is not None
    clamping = clamping_N(d, catalogue.screw(CLAMP_SCREW), "upper_arm", "upper_arm")
    bonded = min(boss, d.platform.boss_length_mm)
    if capstan is None:
        hub = clamp_N_mm(CLAMP_SCREW, arm) * clamping / screw_N(catalogue.screw(CLAMP_SCREW))
    else:
        hub = stack_N_mm(d.shaft.end_screw, d.shaft.washer_diameter_mm, d.shaft.diameter_mm)
    return Allowables(
        bearing=None if capstan is None else ball_bearing(d.bearing),
        stroke_rad=max(shoulder, radians(1.0)),
        preload_N=0.0 if d.preload is None else preload_range_N(d.preload)[0],
        motor_N=_motor_N(d),
        peak_share=min((report.continuous_torque_N_m / report.controlled_torque_N_m) ** 2, 1.0),
        stub_mm=d.motor.shaft_diameter_mm if capstan is None else None,
        stub_lever_mm=layers.motor_face_mm,
        stub_N_mm2=steel * 1e-6,
        setting=cable_setting(d),
        middle_rad=sum(d.stops_rad) / 2.0,
        cable_N=None if capstan is None else d.cable.breaking_load_N / ROPE_FACTOR,
        pinion_N=None if capstan is None else set_screws_N_mm(d) / capstan.run.pinion_mm,
        stud_1_mm2=stud_stress_1_mm2(f),
        stud_N_mm2=stud * 1e-6,
        forearm=f,
        preload_reserve_N=SPRING_SHARE * f.joint.preload_N,
        end_N_mm2=_END_USE * metal * 1e-6,
        plastic_N_mm2=_PLASTIC_USE * plastic * 1e-6,
        tilt_N_mm2=tilt_N_mm2(),
        bond_mm2=pi * f.spigot_diameter_mm * f.spigot_length_mm,
        bond_N_mm2=BOND_N_MM2,
        buckling_N=euler / BUCKLING_FACTOR,
        hub_N_mm=hub,
        bar_1_mm3=6.0 / (f.bar_diameter_mm * bonded**2),
        bar_mm2=pi * f.bar_diameter_mm * bonded,
        bar_N_mm2=_GLUED_N_mm2 if d.is_printed("upper_arm") or d.is_printed("platform") else _RETAINED_N_mm2,
        arm_1_mm3=_arm_1_mm3(d) if d.is_printed("upper_arm") else None,
        arm_N_mm2=lasting_N_mm2(d, "upper_arm"),
        grip_N_mm=_PRINT_FRICTION * clamping * d.arm.shaft_bore_mm if d.is_printed("upper_arm") else None,
        spoke_1_mm3=6.0 / (2.0 * d.platform.hub_radius_mm * d.platform.plate_mm**2)
        if d.is_printed("platform")
        else None,
        spoke_N_mm2=lasting_N_mm2(d, "platform"),
        sector_mm=None if capstan is None else d.arm.dowel_circle_mm / 2,
        sector_pins=len(d.arm.dowel_angles_rad),
        sector_N=PRESSED_N_mm2 * DOWEL_MM * min(arm, WEB_MM),
        foot_mm=-b.cheek_screw_z_mm,
        foot_pins_mm=b.cheek_dowel_u_mm[1] - b.cheek_dowel_u_mm[0],
        foot_pin_N=PRESSED_N_mm2 * DOWEL_MM * min(cheek, 5.0),
        foot_edge_mm=b.foot_height_mm / 2,
        foot_screw_N=min(
            clamping_N(d, catalogue.screw("M3"), held, "foot_block") for held in ("motor_cheek", "encoder_cheek")
        ),
        motor_mm=layers.motor_face_mm - (0.0 if capstan is None else capstan.middle_y_mm),
        motor_edge_mm=d.motor.diameter_mm / 2 - _off_mm(d),
        motor_slip=0.0 if capstan is None else _slip(d, capstan.run.pinion_mm),
        motor_screws=len(b.motor_screws_rad),
        motor_screw_N=clamping_N(d, d.motor.mount_screw, "motor_cheek"),
        base_mm=-b.base_top_mm,
        base_edge_mm=(b.foot_u_mm[1] - b.foot_u_mm[0]) / 2,
        base_screw_N=clamping_N(d, catalogue.screw("M4"), "base_plate", "foot_block"),
    )


def _arm_1_mm3(d: Dimensions) -> tuple[float, float]:
    """Stress in the rectangle of an upper arm's root for 1 N mm: of tilt, and of torque about the shoulder."""
    thick, high = d.layers.arm_mm[1] - d.layers.arm_mm[0], 2.0 * d.arm.beam_root_radius_mm
    return 6.0 / (high * thick**2), 6.0 / (thick * high**2)


def _slip(d: Dimensions, pinion_mm: float) -> float:
    """Computes the clamping force of each screw whose friction holds a motor against 1 N at the cable."""
    return pinion_mm / (_FACE_FRICTION * d.motor.mount_circle_mm / 2 * len(d.bracket.motor_screws_rad))


def _off_mm(d: Dimensions) -> float:
    """Distance of the middle of a motor's screws from its axis: 0 unless one of its holes is left empty."""
    angles = d.bracket.motor_screws_rad
    across = hypot(sum(map(cos, angles)), sum(map(sin, angles)))
    return d.motor.mount_circle_mm / 2 * across / len(angles)


def _motor_N(d: Dimensions) -> float:
    """What the motor's shaft may bear across at the pinion: as much as loads its front bearing as its rated load does.

    Of its row, stated at a distance from the flange; else the RE 30's by the shaft's area.
    """
    m = d.motor
    rated, at = m.max_radial_load_N, m.radial_load_distance_mm
    if rated is None or at is None:
        rated, at = _MOTOR_RADIAL_N * (m.shaft_diameter_mm / _MOTOR_SHAFT_MM) ** 2, _MOTOR_LOAD_MM
    span = _MOTOR_SPAN * m.length_mm
    lever = d.layers.motor_face_mm - (0.0 if d.capstan is None else d.capstan.middle_y_mm)
    return rated * (span + at) / (span + lever)
