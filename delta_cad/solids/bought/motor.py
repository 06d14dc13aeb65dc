"""A motor as its maker's outline has it: body, pilot, shaft."""

from __future__ import annotations

from math import cos, sin

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.solids.making import bought_part, round_y
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, bore_y, cut, feature, fuse, turned


def make_motor(d: Dimensions) -> Part:
    """Motor: mounting face at the origin, body along +y, shaft along -y."""
    m = d.motor
    r, tail = m.diameter_mm / 2, min(4.0, m.length_mm / 6)
    body = turned(
        [
            (0.0, -m.pilot_height_mm),
            (m.pilot_diameter_mm / 2, -m.pilot_height_mm),
            (m.pilot_diameter_mm / 2, 0.0),
            (r - 0.5, 0.0),
            (r, 0.5),
            (r, m.length_mm - tail),
            (r - 2.0, m.length_mm - tail),
            (r - 2.0, m.length_mm),
            (0.0, m.length_mm),
        ]
    )
    shaft = bore_y(m.shaft_diameter_mm, (0.0, 0.0), (-m.shaft_length_mm, 0.0))
    drill = catalogue.screw(m.mount_thread).tap_drill_mm
    tools = []
    for angle in d.bracket.motor_holes_rad:
        at = (m.mount_circle_mm / 2 * cos(angle), m.mount_circle_mm / 2 * sin(angle))
        tools.append(bore_y(drill, at, (-THROUGH_MM, motor_thread_mm(m))))
    shape = feature("motor", "body", "hardware.motor", lambda: cut(fuse(body, shaft), tools))
    extent = round_y(r, (-m.shaft_length_mm, m.length_mm))
    screwed, thread = len(d.bracket.motor_screws_rad), f"{m.mount_thread} x {motor_thread_mm(m):g}, mounting"
    empty = m.mount_count - screwed
    callout = f"{screwed}x {thread}; {empty}x without a screw, {thread}" if empty else thread
    threads = Hole(drill, m.mount_count, callout)
    return bought_part("motor", m, shape, "aluminium-black", extent, m.mass_g, holes=(threads,))
