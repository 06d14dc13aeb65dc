"""The one table of load-bearing parts of a design, computed from its dimensions, that all modules here use.

A redesigned part changes its function here and nothing else. Left out, because nothing computes them well: the
preloaded faces of screw joints, the slit of a direct drive's clamp (whose screw closes it).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain, pairwise
from math import cos, hypot, pi, sin, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.bracket import KEY_SLOT_MM, key_rad, key_slot_floor_mm
from delta_cad.dimensions.forearm import END_MATERIAL
from delta_cad.dimensions.layers import MOTOR_PLAY_MM
from delta_cad.dimensions.platform import knob_centre_mm
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.structure.beam import Beam, BeamSlice, tapered
from delta_cad.structure.bearing import (
    BallBearing,
    axial_stiffness_N_mm,
    ball_bearing,
    radial_stiffness_N_mm,
)
from delta_cad.structure.mounting import Mounting, mounting
from delta_cad.structure.rod_end import joint_N_mm
from delta_cad.structure.section import POISSON, Section, circle, rectangle, ribs, ring, stepped_plate

_SPOKE_ROOT = 1.1  # thicknesses by which a platform's web goes on in its hub, which gives way: by finite elements
CHEEK_ROOT = 0.5  # thicknesses by which a cheek's foot gives on its block: between the free length and one thickness
# A round bar's root tilts in what it grows from by what this share of its diameter would bend: a stamp of radius a on a
# half-space turns by 3 (1 - nu^2) M / (4 E a^3) (Johnson, Contact Mechanics), a bar of length l by 4 M l / (pi E a^4).
ROOT = 0.27
_Circle = tuple[float, float, float]  # x, z, radius
_RIB_LIMIT_MM = 0.5  # a window's ribs are at least so wide, together


@dataclass(frozen=True)
class CableSpring:
    """The cable between sector and pinion; None in the table of a direct drive.

    Attributes:
        rope_N: E A of the settled rope.
        new_N: The same of a new one.
        radius_mm: Of the cable's middle on the sector.
        direction_rad: From the shoulder to the pinion, angle in the chain's plane.
        ends_rad: Polar angles of the rim at which the cable leaves it, arm's frame.
        beyond_mm: Free length beyond either of these ends.
        y_mm: Place along the shoulder axis.
        across_rad: Angle of the strands between sector and pinion against the common tangent.
        sector_mm_N: How far the rim gives along the cable for 1 N.
        motor_mm_N: How far the motor's shaft gives at the pinion for 1 N.
    """

    rope_N: float
    new_N: float
    radius_mm: float
    direction_rad: float
    ends_rad: tuple[float, float]
    beyond_mm: tuple[float, float]
    y_mm: float
    across_rad: float
    sector_mm_N: float
    motor_mm_N: float


@dataclass(frozen=True)
class _ShoulderBearings:
    """The two bearings of a shoulder and the cheeks that carry them, encoder's side first.

    Attributes:
        bearing: Both bearings.
        y_mm: Their places along the shoulder axis.
        radial_N_mm: Stiffness of a bearing across its axis.
        axial_N_mm: Stiffness of a bearing along its axis.
        shaft_mm_N: How far the shaft's overhang from the arm gives at each bearing for 1 N.
        cheeks: Cantilevers from the foot block to the bearing; x up, y along the shoulder axis, z inwards.
    """

    bearing: BallBearing
    y_mm: tuple[float, float]
    radial_N_mm: float
    axial_N_mm: float
    shaft_mm_N: tuple[float, float]
    cheeks: tuple[Beam, Beam]


@dataclass(frozen=True)
class BeamModel:
    """Load-bearing parts of one design; all chains are equal.

    Attributes:
        geometry: The mechanism, m.
        width_mm: Distance of a chain's two rods, L_c.
        knob_mm: Height of the knob's centre over the wrists.
        arm: Upper arm from its bore's edge to the elbow; x along it, y along the shoulder axis.
        shoulder: Bearings and cheeks of a capstan's shoulder; None where the motor's own shaft carries the arm.
        stub: The motor's shaft from its face to the arm, of a direct drive; else None.
        motor_cheek: Printed cheek that carries a direct drive's motor, from the foot block to the shoulder's axis; x
            up, y along the axis, z inwards. None of a capstan, and where it is cut: metal gives a fiftieth of it.
        motor_cheek_mm: Place of its middle along the shoulder axis.
        cable: None for a direct drive.
        stud: Stud from the end of its bar to the ball's centre.
        elbow_bar: Cross-bar from the elbow's boss to its end, where the stud begins.
        wrist_bar: The same from the platform's boss.
        rod: Tube of a rod.
        joint_N_mm: Stiffness of one ball joint and its rod's end along the rod, in tension and compression alike.
        spoke: Platform from the hub to a wrist's boss; x outwards, y along the boss, z up.
        spoke_up_mm: Height of the spoke's middle over the wrists.
        stem: Handle from the platform's top to the knob's centre.
        mounting: Base plate and what it stands on; None where it is rigid.
    """

    geometry: DeltaGeometry
    width_mm: float
    knob_mm: float
    arm: Beam
    shoulder: _ShoulderBearings | None
    stub: Beam | None
    motor_cheek: Beam | None
    motor_cheek_mm: float
    cable: CableSpring | None
    stud: Beam
    elbow_bar: Beam
    wrist_bar: Beam
    rod: Beam
    joint_N_mm: float
    spoke: Beam
    spoke_up_mm: float
    stem: Beam
    mounting: Mounting | None = None


def with_new_rope(table: BeamModel) -> BeamModel:
    """Gives the same machine before its cables have settled."""
    return table if table.cable is None else replace(table, cable=replace(table.cable, rope_N=table.cable.new_N))


def moduli_N_mm2(material: str) -> tuple[float, float]:
    """Gives Young's and the shear modulus of a material of the catalogue, of what is printed after creep, N/mm^2."""
    young = catalogue.material(material).design_modulus_Pa * 1e-6
    return young, young / (2.0 * (1.0 + POISSON))


def beam_model(d: Dimensions) -> BeamModel:
    """Makes the table of a design from its dimensions."""
    direct = d.capstan is None
    knob = knob_centre_mm(d)
    f = d.forearm
    stud = _stud(d)
    elbow_boss = d.layers.elbow_boss_mm[1] - d.layers.elbow_boss_mm[0]
    rod = BeamSlice(f.tube_length_mm, ring(f.tube_outer_mm, f.tube_bore_mm), *moduli_N_mm2(d.tube.material))
    top = d.platform.boss_diameter_mm / 2
    stem = BeamSlice(knob - top, circle(d.platform.stem_diameter_mm), *moduli_N_mm2("aluminium-6082"))
    return BeamModel(
        geometry=d.design.geometry,
        width_mm=f.width_mm,
        knob_mm=knob,
        arm=_arm(d),
        shoulder=None if direct else _shoulder(d),
        stub=_motor_stub(d) if direct else None,
        motor_cheek=_cheek(d, d.bracket.motor_cheek_circles_mm, [], d.layers.motor_cheek_mm)
        if direct and d.is_printed("motor_cheek")
        else None,
        motor_cheek_mm=sum(d.layers.motor_cheek_mm) / 2.0,
        cable=_cable(d),
        stud=Beam(stud),
        elbow_bar=_bar(d, elbow_boss),
        wrist_bar=_bar(d, d.platform.boss_length_mm),
        rod=Beam((rod,)),
        joint_N_mm=joint_N_mm(f, moduli_N_mm2(END_MATERIAL)[0]),
        spoke=_spoke(d),
        spoke_up_mm=top - d.platform.plate_mm / 2,
        stem=Beam((stem,)),
        mounting=mounting(d),
    )


def _stud(d: Dimensions) -> tuple[BeamSlice, ...]:
    """Neck from the shoulder at the bar's end to the ball's rim, pin from there to the ball's centre.

    The pin is bonded in the ball, whose steel takes it over from half a diameter inside the rim.
    """
    f, (e, g) = d.forearm, moduli_N_mm2("aluminium-7075")
    rim = sqrt((f.ball_diameter_mm / 2) ** 2 - (f.pin_diameter_mm / 2) ** 2)
    free = min(f.pin_diameter_mm / 2, rim)
    steel = moduli_N_mm2(f.ball.material)
    neck = BeamSlice(f.stand_off_mm - rim, circle(f.neck_diameter_mm), e, g)
    return (neck, BeamSlice(free, circle(f.pin_diameter_mm), e, g), BeamSlice(rim - free, circle(rim), *steel))


def _bar(d: Dimensions, boss_mm: float) -> Beam:
    """Cross-bar from the end of a boss, to whose mouth it is bonded, to its cone's foot and along the cone."""
    f, (e, g) = d.forearm, moduli_N_mm2("aluminium-7075")
    overhang = (f.bar_length_mm - boss_mm) / 2
    cone = min(f.cone_mm, overhang)
    middle = circle(f.bar_diameter_mm - f.cone_mm)
    into = ROOT * f.bar_diameter_mm
    return Beam((BeamSlice(overhang - cone + into, circle(f.bar_diameter_mm), e, g), BeamSlice(cone, middle, e, g)))


def _arm(d: Dimensions) -> Beam:
    """The upper arm, a tapering plate; a clamp's slit counts as closed, its hub as no wider than the beam."""
    a, (y0, y1), (b0, b1) = d.arm, d.layers.arm_mm, d.layers.elbow_boss_mm

    begins = a.length_mm - a.boss_radius_mm

    def section(x: float) -> Section:
        half = a.beam_root_radius_mm + (a.boss_radius_mm - a.beam_root_radius_mm) * x / a.length_mm
        return rectangle(b1 - b0 if x > begins else y1 - y0, 2 * half)

    places, moduli = (a.shaft_bore_mm / 2, begins, a.length_mm), moduli_N_mm2(d.material_of("upper_arm"))
    return Beam(tuple(piece for ends in pairwise(places) for piece in tapered(*ends, section, *moduli)))


def _shoulder(d: Dimensions) -> _ShoulderBearings:
    layers, bearing = d.layers, ball_bearing(d.bearing)
    first, second_ = layers.bearings_mm
    y = sum(first) / 2, sum(second_) / 2
    assert d.preload is not None
    assert d.capstan is not None
    young, _ = moduli_N_mm2("stainless-1.4305")
    second = circle(d.shaft.diameter_mm).about_y_mm4
    free = (layers.arm_mm[0] - y[0], y[1] - d.capstan.web_y_mm[1])
    b = d.bracket
    motor = [(b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1], b.motor_pad_radius_mm)]
    pilot = [(motor[0][0], motor[0][1], d.motor.pilot_diameter_mm / 2)]
    return _ShoulderBearings(
        bearing=bearing,
        y_mm=y,
        radial_N_mm=radial_stiffness_N_mm(bearing, d.design.requirements.force_N),
        axial_N_mm=axial_stiffness_N_mm(bearing, d.preload.force_N),
        shaft_mm_N=tuple(length**3 / (3.0 * young * second) for length in free),  # type: ignore[arg-type]
        cheeks=(
            _cheek(d, [b.leg_circle_mm], [], layers.encoder_cheek_mm),
            _cheek(d, [(0.0, 0.0, b.head_radius_mm), *motor], pilot, layers.motor_cheek_mm),
        ),
    )


def outline_width_mm(circles: list[_Circle], height: float) -> float:
    """Computes how wide the hull of circles (x, z, radius) is at a height z, mm.

    The hull's reach in a direction is the largest of the circles'; at a height its edges are the least over all
    directions of the tangent's crossing.
    """
    angles = np.linspace(-pi / 2, pi / 2, 721)[1:-1]
    cosine, sine = np.cos(angles), np.sin(angles)
    right = np.max([x * cosine + z * sine + r for x, z, r in circles], axis=0)
    left = np.max([-x * cosine + z * sine + r for x, z, r in circles], axis=0)
    return float(np.min((right - height * sine) / cosine) + np.min((left - height * sine) / cosine))


def _cheek(d: Dimensions, head: list[_Circle], open_: list[_Circle], y_mm: tuple[float, float]) -> Beam:
    """A cheek above its foot block, as wide as its outline without the large bores; the bearing fills its seat.

    Of what is open, a motor's pilot bore, the motor's pocket around it is thinner; the motor's face does not count.
    """
    b, c, thickness, deep = d.bracket, d.capstan, y_mm[1] - y_mm[0], d.layers.motor_pocket_mm
    top = b.base_top_mm + b.foot_height_mm
    foot = [(u - b.shoulder_u_mm, z, 0.0) for u in b.foot_u_mm for z in (b.base_top_mm, top)]
    circles = [*head, *foot]
    pocket = [(x, z, d.motor.diameter_mm / 2 + MOTOR_PLAY_MM) for x, z, _ in open_ if deep]

    slot = c is not None and c.collar_at_motor and bool(open_)
    angle, slot_mm = (key_rad(c, b, d.motor), key_slot_floor_mm(c, y_mm[0])) if c is not None and slot else (0.0, 0.0)

    def section(z: float) -> Section:
        bores, pockets = _chords_mm(open_, z), _chords_mm(pocket, z)
        width = outline_width_mm(circles, max(z, top)) - bores
        cut = sum(_slotted_mm(z, bore, angle, slot_mm, circles) for bore in open_) if slot else 0.0
        cut, thin = min(cut, width), min(max(pockets - bores, 0.0), width)
        if cut:  # in a slot's height all of the width counts as being as thin as slot and pocket leave it
            return stepped_plate(thickness, width, min(slot_mm + (deep if thin else 0.0), thickness - 0.1), cut)
        return rectangle(thickness, width) if not thin else stepped_plate(thickness, width, deep, thin)

    return Beam(tapered(top - CHEEK_ROOT * thickness, 0.0, section, *moduli_N_mm2(d.material_of("motor_cheek"))))


def _chords_mm(circles: list[_Circle], z: float) -> float:
    """Width of circles (x, z, radius) at a height z, mm."""
    return sum(2 * sqrt(max(0.0, r**2 - (z - at) ** 2)) for _, at, r in circles)


def _slotted_mm(z: float, bore: _Circle, angle_rad: float, deep_mm: float, circles: list[_Circle]) -> float:
    """Width that the key's slot takes at a height, from a bore out to the edge at an angle, mm.

    The cheek folds along the slot's line, which counts as level at its middle's height; on either side the stress takes
    the slot's depth to spread over the whole thickness again (by finite elements: 13 % of what the cheek gives). A
    steep slot may be longer than the cheek is wide there: it takes all of that, which is safe.
    """
    x, at, r = bore
    edge = max((cx - x) * cos(angle_rad) + (cz - at) * sin(angle_rad) + cr for cx, cz, cr in circles)
    middle = at + (r + edge) / 2 * sin(angle_rad)
    return edge - r if abs(z - middle) < KEY_SLOT_MM / 2 + deep_mm else 0.0


def _motor_stub(d: Dimensions) -> Beam:
    """The shaft of a direct drive's motor from its face to the arm's middle; its bearings count as rigid."""
    shaft = BeamSlice(d.layers.motor_face_mm, circle(d.motor.shaft_diameter_mm), *moduli_N_mm2("steel"))
    return Beam((shaft,))


def _cable(d: Dimensions) -> CableSpring | None:
    c = d.capstan
    if c is None:
        return None
    low, high = c.rim_angles_rad
    _, shear = moduli_N_mm2("aluminium-7075")
    root, rim, web = d.arm.flange_radius_mm, c.rim_radius_mm, c.web_y_mm
    # shear of an annular plate under a torque, the share that the sector has of a full turn; holes neglected
    turn = (1 / root**2 - 1 / rim**2) / (4 * pi * shear * (web[1] - web[0])) * 2 * pi / (high - low)
    steel, _ = moduli_N_mm2("steel")
    overhang = d.layers.motor_face_mm - sum(d.layers.sector_mm) / 2
    laid, (new_N, settled_N) = c.laid(np.zeros(1)), d.cable.stiffness_N
    beyond = [sum(float(arc.length_mm[0]) for arc in arcs[1:]) for arcs in (laid.inner, laid.outer)]
    return CableSpring(
        rope_N=settled_N,
        new_N=new_N,
        radius_mm=c.pitch_radius_mm,
        direction_rad=c.direction_rad,
        ends_rad=(low, high),
        beyond_mm=(beyond[0], beyond[1]),
        y_mm=c.middle_y_mm,
        across_rad=c.run.tangent_rad,
        sector_mm_N=turn * c.pitch_radius_mm**2,
        motor_mm_N=overhang**3 / (3 * steel * circle(d.motor.shaft_diameter_mm).about_y_mm4),
    )


def _spoke(d: Dimensions) -> Beam:
    """A web of the platform between the hub and the boss, with its window."""
    p = d.platform
    r, corner = p.radius_mm, p.web_mm[1]
    near, far, reach = p.window_reach_mm or (r, r, 0.0)

    def section(x: float) -> Section:
        # tangent of the hub's circle and the corner's: height of the hull of two circles over x
        dx, dy, dr = corner[0], corner[1], p.hub_radius_mm - corner[2]
        length = hypot(dx, dy)
        lean = np.arctan2(dy, dx) + np.arccos(dr / length)
        edge = (p.hub_radius_mm - x * cos(lean)) / sin(lean)
        wide = 2 * min(max(edge, 0.0), max(corner[1] + corner[2], p.hub_radius_mm))
        if near < x < far:
            open_mm = 2 * (1.5 + (reach - 1.5) * (x - near) / (far - near))
            return ribs(max(wide - open_mm, _RIB_LIMIT_MM), p.plate_mm, open_mm, far - near)
        return rectangle(wide, p.plate_mm)

    root = p.hub_radius_mm - _SPOKE_ROOT * p.plate_mm
    ends = [root, *([near, far] if p.window_reach_mm else []), r]  # no slice lies across a window's end
    material = moduli_N_mm2(d.material_of("platform"))
    pieces = (tapered(*piece, lambda x: section(max(x, p.hub_radius_mm)), *material) for piece in pairwise(ends))
    return Beam(tuple(chain.from_iterable(pieces)))
