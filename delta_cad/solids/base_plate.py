"""The base plate under the three brackets (base frame)."""

from __future__ import annotations

from math import cos, pi, radians, sin

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.brackets import BASE_SCREW, DOWEL_MM
from delta_cad.solids.making import made_part, round_z
from delta_cad.solids.materials import GRAPHITE, material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.platform import turned_to_chain
from delta_cad.solids.primitive import THROUGH_MM, bore_z, cut, edge_break, feature

MOUNT_SPREAD_RAD = radians(18.0)  # mounting holes beside the feet
WINDOW_MM = 34.0


def between_chains(radius: float, spread: float = 0.0) -> list[tuple[float, float]]:
    """(x, y) half way between the chains, turned by `spread`."""
    return [
        (radius * cos(pi / 3 + i * 2 * pi / 3 + spread), radius * sin(pi / 3 + i * 2 * pi / 3 + spread)) for i in CHAINS
    ]


def make_base_plate(d: Dimensions) -> Part:
    """Disc with counterbored screw and dowel holes under each foot block, feet, mounting holes and a cable window."""
    number, b, k = "base_plate", d.base, d.bracket
    low, high = b.top_mm - b.thickness_mm, b.top_mm
    through = (low - THROUGH_MM, high + THROUGH_MM)
    disc = edge_break(number, bore_z(2 * b.radius_mm, (0.0, 0.0), (low, high)), ">Z or <Z", 1.0)
    screw, foot = catalogue.screw(BASE_SCREW), catalogue.screw(d.foot.thread)
    middle = (d.layers.encoder_cheek_mm[1] + d.layers.motor_cheek_mm[0]) / 2
    seat = low + screw.counterbore_depth_mm
    tools: list[cq.Shape] = [bore_z(b.centre_hole_mm, (0.0, 0.0), through)]
    for i in CHAINS:
        for u in k.base_screw_u_mm:
            tools.append(turned_to_chain(bore_z(screw.clearance_hole_mm, (u, middle), through), i))
            tools.append(
                turned_to_chain(bore_z(screw.counterbore_diameter_mm, (u, middle), (low - THROUGH_MM, seat)), i)
            )
        for u in k.base_dowel_u_mm:
            tools.append(turned_to_chain(bore_z(DOWEL_MM, (u, middle), through), i))
    tools += [bore_z(foot.tap_drill_mm, at, through) for at in between_chains(b.foot_circle_mm / 2)]
    mounts = [at for sign in (-1, 1) for at in between_chains(b.mount_circle_mm / 2, sign * MOUNT_SPREAD_RAD)]
    tools += [bore_z(b.mount_hole_mm, at, through) for at in mounts]
    middle_radius = (b.centre_hole_mm / 2 + b.foot_circle_mm / 2) / 2
    tools += [bore_z(WINDOW_MM, at, through) for at in between_chains(middle_radius)]
    solid = feature(number, "bores", "base_radius_mm", lambda: cut(disc, tools))
    holes = [
        Hole(b.centre_hole_mm, 1, f"{b.centre_hole_mm:g} through, cables"),
        Hole(screw.clearance_hole_mm, 6, f"{screw.clearance_hole_mm:g} through, foot blocks"),
        Hole(screw.counterbore_diameter_mm, 6, f"counterbore {screw.counterbore_depth_mm:g} deep from below"),
        Hole(DOWEL_MM, 6, f"{DOWEL_MM:g} H7 through, dowels"),
        Hole(foot.tap_drill_mm, 3, f"{d.foot.thread} through, feet"),
        Hole(b.mount_hole_mm, 6, f"{b.mount_hole_mm:g} through, mounting"),
        Hole(WINDOW_MM, 3, f"{WINDOW_MM:g} through, lightening"),
    ]
    description, extent = f"base plate {2 * b.radius_mm:g} x {b.thickness_mm:g}", round_z(b.radius_mm, (low, high))
    return made_part(number, description, solid, material("aluminium-6082", GRAPHITE), extent, holes)
