"""Lower bound of the moving mass before CAD, for the gravity torque.

Left out is what dimensions do not tell in a line: gussets of rods, fillets, screws, shaft, cable. Of twenty machines
rods weigh 3 to 7 % more, platforms 1 to 6 %, arms of direct drives 1 %. A sector, which may weigh against its arm, is
taken as wide as its segment, without what is cut out of it: of capstans how high an arm's centre lies is an estimate.
"""

from __future__ import annotations

from math import asin, cos, pi, sin, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import RIM_MM
from delta_cad.dimensions.forearm import END_MATERIAL, EYE_WALL_MM, ForearmDimensions
from delta_cad.dimensions.joint import CUP_MATERIAL
from delta_cad.dimensions.platform import RIB_MM, STEM_FLATS_MM, STEM_FLATS_Z_MM, WEB_CORNER_MM
from delta_cad.drive.masses import rod_masses
from delta_cad.structure.modes import Moving, MovingBody

_CUPPED = 0.8  # of a ball's shell: what of both cups lies above their lips, at least
_CORE_PLAY = 0.2  # mm, that a thread's core is less than its drill at most
_PLATE, _TURNED = "aluminium-7075", "aluminium-6082"  # of cross-bars and sectors; of the stem


def mass_lower_bound(d: Dimensions) -> Moving:
    """Gives masses that what moves of a machine has at least, with their centres; inertias are left out.

    Args:
        d: The machine.
    """
    f = d.forearm
    joints = 2.0 * f.ball.mass_g / 1e3 + _bar_kg(f)
    middle, long = f.length_mm / 2.0 / MM_PER_M, f.length_mm / MM_PER_M
    return Moving(_platform(d, joints), _arm(d, joints), rod_masses(_rod_kg(d), middle, 0.0, long))


def _bar_kg(f: ForearmDimensions) -> float:
    """A cross-bar with its cones, necks and the pins in its balls, whose shoulders lie in the balls."""
    shoulder, past = f.bar_diameter_mm - 2.0 * f.cone_mm, (f.width_mm - f.bar_length_mm) / 2.0 + f.pin_past_mm
    cone = f.bar_diameter_mm**2 + f.bar_diameter_mm * shoulder + shoulder**2
    pin = min(f.pin_diameter_mm, f.neck_diameter_mm)
    whole = f.bar_diameter_mm**2 * (f.bar_length_mm - 2.0 * f.cone_mm) + 2.0 * (cone * f.cone_mm / 3.0 + pin**2 * past)
    return pi / 4.0 * whole * _kg_mm3(_PLATE)


def _rod_kg(d: Dimensions) -> float:
    """Tube, both ends with their spigots, cups and shells, both eyes, and half of both springs."""
    f, end = d.forearm, _kg_mm3(END_MATERIAL)
    wall_mm2 = pi / 4.0 * (f.tube_outer_mm**2 - f.tube_bore_mm**2)
    cups = 4.0 / 3.0 * pi * (f.cup_radius_mm**3 - f.liner_radius_mm**3) * _CUPPED * end
    cups += 4.0 / 3.0 * pi * (f.liner_radius_mm**3 - (f.seat_diameter_mm / 2.0) ** 3) * _CUPPED * _kg_mm3(CUP_MATERIAL)
    stems = 2.0 * (f.shoulder_mm - f.stem_mm) * f.tube_outer_mm**2 * end
    ends = 2.0 * _round_kg(f.spigot_diameter_mm, f.spigot_length_mm, END_MATERIAL) + stems + cups
    around = f.eye_diameter_mm / 2.0 + EYE_WALL_MM
    ring = pi / 4.0 * (f.eye_ring_mm**2 - f.eye_bore_mm**2)
    lug = 2.0 * around * max(f.eye_z_mm - f.eye_ring_mm / 2.0, 0.0) + pi / 2.0 * around**2
    eye_mm2 = ring + lug - pi / 4.0 * f.eye_diameter_mm**2
    eyes = 2.0 * eye_mm2 * f.eye_mm * _kg_mm3(d.material_of("rod_eye"))
    return wall_mm2 * f.tube_length_mm * _kg_mm3(d.tube.material) + ends + eyes + (f.spring.mass_g or 0.0) / 1e3


def _kg_mm3(material: str) -> float:
    return catalogue.material(material).density_kg_m3 / MM_PER_M**3


def _round_kg(diameter_mm: float, length_mm: float, material: str) -> float:
    return pi / 4.0 * diameter_mm**2 * length_mm * _kg_mm3(material)


def _body(pieces: list[tuple[float, tuple[float, float, float]]]) -> MovingBody:
    """A body of (kg, place in mm)."""
    mass = sum(kg for kg, _ in pieces)
    return MovingBody(mass, np.sum([kg * np.array(at) for kg, at in pieces], axis=0) / mass, np.zeros((3, 3)))


def _platform(d: Dimensions, joints_kg: float) -> MovingBody:
    """Bosses with their bars and balls, hub, webs between them, stem and knob; the stem's thread fills the hub's."""
    p, density = d.platform, _kg_mm3(d.material_of("platform"))
    top = p.boss_diameter_mm / 2.0
    bosses = pi / 4.0 * (p.boss_diameter_mm**2 - p.bar_bore_mm**2) * p.boss_length_mm
    hub = pi * p.hub_radius_mm**2 * 2.0 * top
    first, last = p.hub_radius_mm, p.radius_mm - top  # of a web, along its arm
    end = p.boss_length_mm / 2.0 - WEB_CORNER_MM[0]
    slope = (end + WEB_CORNER_MM[1] - p.hub_radius_mm) / p.radius_mm
    long = max(last - first, 0.0)
    window = max(end * last / p.radius_mm - RIB_MM, 0.0) * max(long - RIB_MM, 0.0)
    web = max((2.0 * p.hub_radius_mm + slope * (first + last)) * long - window, 0.0) * p.plate_mm
    web += 2.0 * max(p.hub_radius_mm + slope * last, 0.0) * _next_to_round(top, p.plate_mm)
    low, high = STEM_FLATS_Z_MM
    stem = _round_kg(p.stem_diameter_mm, p.stem_length_mm - high + low, _TURNED)
    stem += _round_kg(STEM_FLATS_MM, high - low, _TURNED)
    stem += _round_kg(catalogue.screw(p.stem_thread).tap_drill_mm - _CORE_PLAY, d.knob.thread_depth_mm - 1.0, _TURNED)
    knob = top + p.stem_length_mm + d.knob.height_mm - d.knob.diameter_mm / 2.0
    aside = float(d.design.geometry.radial[:, 0].mean())  # of what is once on each chain's radius, as a share of that
    return _body([
        (hub * density, (0.0, 0.0, 0.0)),
        (3.0 * (bosses * density + joints_kg), (aside * p.radius_mm, 0.0, 0.0)),
        (3.0 * web * density, (aside * (first + last) / 2.0, 0.0, 0.0)),
        (stem, (0.0, 0.0, top + p.stem_length_mm / 2.0)),
        (d.knob.mass_g / 1e3, (0.0, 0.0, knob)),
    ])  # fmt: skip


def _next_to_round(radius_mm: float, under_mm: float) -> float:
    """Area between a cylinder's side, from so much under its top up, and its upright tangent plane, mm^2."""
    low = max(radius_mm - under_mm, 0.0)
    segment = radius_mm**2 * (pi / 2.0 - asin(low / radius_mm)) - low * sqrt(radius_mm**2 - low**2)
    return radius_mm * (radius_mm - low) - segment / 2.0


def _arm(d: Dimensions, joints_kg: float) -> MovingBody:
    """Arm's plate between hub and boss, its boss with bar and balls, and the sector."""
    a, plate = d.arm, d.material_of("upper_arm")
    density = _kg_mm3(plate)
    long, root, end = a.length_mm - a.boss_radius_mm, a.beam_root_radius_mm, a.boss_radius_mm
    thick, boss = (high - low for low, high in (d.layers.arm_mm, d.layers.elbow_boss_mm))
    beam = (root + end) * long * thick * density
    ring = _round_kg(2.0 * end, boss, plate) - _round_kg(a.bar_bore_mm, boss, plate)
    half = -2.0 / 3.0 * root**3 * thick * density  # kg mm: of the hub's half behind the shoulder
    pieces = [
        (beam, (long * (root + 2.0 * end) / (3.0 * (root + end)) + half / beam, 0.0, 0.0)),
        (ring + joints_kg, (a.length_mm, 0.0, 0.0)),
    ]
    if (c := d.capstan) is not None:
        low, high = c.rim_angles_rad
        middle, opened = (low + high) / 2.0, (high - low) / 2.0
        wide = ((c.rim_radius_mm - RIM_MM, d.layers.sector_mm), (a.flange_radius_mm - 4.0, c.web_y_mm))
        for inner, (under, over) in wide:
            area = opened * (c.rim_radius_mm**2 - inner**2)
            out = 2.0 / 3.0 * sin(opened) * (c.rim_radius_mm**3 - inner**3) / area
            pieces.append((area * (over - under) * _kg_mm3(_PLATE), (out * cos(middle), 0.0, out * sin(middle))))
    return _body(pieces)
