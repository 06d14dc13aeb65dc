"""Bearing ball of a ball joint, with the blind hole by which it is bonded on its stud."""

from __future__ import annotations

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import BALL_GLUE_MM
from delta_cad.dimensions.tolerances import EROSION_UM
from delta_cad.solids.boring import Boring, along_y, blind, within
from delta_cad.solids.making import made_part, ordered
from delta_cad.solids.materials import material
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import ball, cut, feature

HOLE_ROOM_MM = 0.3  # between the pin's end and the floor of the hole: adhesive


def make_joint_ball(d: Dimensions) -> Part:
    """Ball about the origin, its hole open towards +y; bought, and eroded because it is hardened through."""
    number, f, row = "joint_ball", d.forearm, d.forearm.ball
    hole, radius = f.pin_diameter_mm + 2 * BALL_GLUE_MM, f.ball_diameter_mm / 2
    floor = -f.pin_past_mm - HOLE_ROOM_MM
    sphere = ball(f.ball_diameter_mm, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    deep, boring = radius - floor, Boring()
    eroded = within(blind(along_y(hole, (0.0, 0.0), (radius, floor))), -EROSION_UM, EROSION_UM)
    boring.add(f"{hole:.2f} x {deep:g} from the ball's surface, eroded on centre", [eroded])
    solid = feature(number, "hole", "hardware.ball_diameter_mm", lambda: cut(sphere, boring.tools))
    rim = (radius**2 - (hole / 2) ** 2) ** 0.5
    extent = (-radius, radius), (-radius, rim), (-radius, radius)
    description = f"{row.description}, eroded {hole:.2f} x {deep:g}; bonded on its stud"
    return made_part(number, description, solid, material(row.material), extent, boring.holes, **ordered(row))
