"""Cross-bar with its studs, cup on a rod's end, and tube of the parallelogram."""

from __future__ import annotations

from math import sqrt

import cadquery as cq

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import (
    BALL_GLUE_MM,
    END_MATERIAL,
    EYE_WALL_MM,
    GUSSET,
    LINER_GLUE_MM,
    TUBE_GLUE_MM,
    ForearmDimensions,
)
from delta_cad.dimensions.joint import CLEARANCE_TOLERANCE_MM, CUP_MATERIAL, POCKET_MM
from delta_cad.solids.boring import Boring, along_y, between
from delta_cad.solids.making import BLUE, made_part, material, ordered, round_y
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    Point,
    ball,
    box,
    cut,
    cylinder,
    feature,
    fuse,
    hull_along_z,
    turned,
)


def make_cross_bar(d: Dimensions) -> Part:
    """Bar with a stud at either end, turned in one; centred, along y.

    A stud in one with the bar has no thread to weaken it: of 7075 its neck bears three times as much, and bends less,
    than the core of an M3 of stainless steel, and the balls' distance is that of two shoulders turned in one setting.
    """
    number, f = "cross_bar", d.forearm
    bar, neck, pin = f.bar_diameter_mm / 2, f.neck_diameter_mm / 2, f.pin_diameter_mm / 2
    half, ball_at, rim = f.bar_length_mm / 2, f.width_mm / 2, rim_mm(f)
    cone = half - f.cone_mm  # half of the bar before its cones
    end = ball_at + f.pin_past_mm
    side: list[Point] = [(bar, cone), (bar - f.cone_mm, half), (neck, half), (neck, ball_at - rim)]
    side += [(pin, ball_at - rim), (pin, end), (0.0, end)]
    profile = [(r, -y) for r, y in reversed(side)] + side
    solid = feature(number, "studs", "parallelogram_width_mm", lambda: turned(profile))
    description = (
        f"cross-bar {2 * bar:g} h6 with studs {2 * neck:g} and {2 * pin:g}, turned in one; "
        f"{2 * (ball_at - rim):.3f} +-0.02 between the balls' shoulders; balls bonded at assembly"
    )
    return made_part(number, description, solid, material("aluminium-7075"), round_y(bar, (-end, end)))


def rim_mm(f: ForearmDimensions) -> float:
    """From a ball's centre to the rim of its hole, on which the stud's shoulder seats it."""
    hole = f.pin_diameter_mm / 2 + BALL_GLUE_MM
    return sqrt((f.ball_diameter_mm / 2) ** 2 - hole**2)


def make_rod_cup(d: Dimensions) -> Part:
    """End of a rod: open cup towards +y about the origin for its plastic shell, gusset, spigot along +x."""
    number, f = "rod_cup", d.forearm
    rod, outer, lip = f.tube_outer_mm / 2, f.cup_radius_mm, f.lip_mm
    end, gusset = f.shoulder_mm + f.spigot_length_mm, f.shoulder_mm - 1.0
    along, across = (share * outer for share in GUSSET)

    def body() -> cq.Shape:
        upper = [(0.0, lip, 0.0), (0.0, across, 0.0), (along, across, 0.0), (gusset, rod, 0.0), (gusset, lip, 0.0)]
        stem = box((f.stem_mm, -rod, -rod), (f.shoulder_mm, rod, rod))
        spigot = cylinder(f.spigot_diameter_mm, (f.shoulder_mm - THROUGH_MM, 0, 0), (end, 0, 0))
        return fuse(_bowl(outer, lip), hull_along_z(upper, (-rod, rod)), stem, spigot)

    shape = feature(number, "body", "hardware.ball_diameter_mm", body)
    bore = 2 * (f.liner_radius_mm + LINER_GLUE_MM)
    seat = ball(bore, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    solid = feature(number, "seat", "hardware.ball_diameter_mm", lambda: cut(shape, [seat]))
    description = (
        f"rod's end, cup {bore:.3f} for its shell; hard anodised all over; "
        f"spigot {f.spigot_diameter_mm:g} sanded at assembly and bonded with {TUBE_GLUE_MM:g} around it"
    )
    wide = sqrt(outer**2 - lip**2)
    extent = (-wide, end), (-rod, outer), (-wide, wide)
    return made_part(number, description, solid, material(END_MATERIAL), extent)


def make_cup_shell(d: Dimensions) -> Part:
    """Plastic shell in a rod's cup, on which the ball slides; open towards -y about the origin, its pole along +y."""
    number, f = "cup_shell", d.forearm
    outer, lip = f.liner_radius_mm, f.lip_mm
    shape = feature(number, "body", "hardware.ball_diameter_mm", lambda: _bowl(outer, lip))
    boring = Boring()
    pole = along_y(POCKET_MM, (0.0, 0.0), (f.seat_diameter_mm / 2, outer))
    boring.add(f"{POCKET_MM:g} through at the pole: grease", [pole])
    seat = ball(f.seat_diameter_mm, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    solid = feature(number, "seat", "hardware.ball_diameter_mm", lambda: cut(shape, [seat, *boring.tools]))
    description = (
        f"bearing shell {2 * outer:.3f}; at assembly bonded in its cup, its seat lapped with ball and paste to "
        f"{f.seat_diameter_mm:.3f} +-{2 * CLEARANCE_TOLERANCE_MM:g} and gauged"
    )
    wide, top = sqrt(outer**2 - lip**2), sqrt(outer**2 - (POCKET_MM / 2) ** 2)
    extent = (-wide, wide), (lip, top), (-wide, wide)
    return made_part(number, description, solid, material(CUP_MATERIAL, BLUE), extent, boring.holes)


def _bowl(radius: float, lip: float) -> cq.Shape:
    """What of a ball about the origin lies above the plane of the lip."""
    beyond = radius + 1.0
    return ball(2 * radius, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)).cut(
        box((-beyond, -beyond, -beyond), (beyond, lip, beyond))
    )


def make_rod_eye(d: Dimensions) -> Part:
    """Ring of sheet about x on a rod's tube, with a spring's eye at (0, -y, +z), on whose edges its loop bears."""
    number, f = "rod_eye", d.forearm
    half, y, z = f.eye_mm / 2, -f.eye_hole_y_mm, f.eye_z_mm
    around = f.eye_diameter_mm / 2 + EYE_WALL_MM

    def body() -> cq.Shape:
        lug = box((-half, y - around, 0.0), (half, y + around, z))
        head = cylinder(2 * around, (-half, y, z), (half, y, z))
        return fuse(cylinder(f.eye_ring_mm, (-half, 0, 0), (half, 0, 0)), lug, head)

    boring = Boring()
    on_tube = between(f.eye_bore_mm, (-half, 0, 0), (half, 0, 0))
    boring.add(f"{f.eye_bore_mm:g} through, opened with a drill {f.eye_bore_mm:g}; bonded on the tube", [on_tube])
    eye = between(f.eye_diameter_mm, (-half, y, z), (half, y, z))
    boring.add(f"{f.eye_diameter_mm:g} through the lug, edges rounded R0.3: spring", [eye])
    shape = feature(number, "ring", "hardware.tube", body)
    solid = feature(number, "eye", "hardware.tube", lambda: cut(shape, boring.tools))
    first, second = f.eyes_x_mm
    description = (
        f"spring's eye on a rod, {'printed' if d.is_printed(number) else 'cut from sheet'} {f.eye_mm:g} thick; at "
        f"assembly bonded on the tube, {first:.1f} and {second:.1f} from the elbow's seat centre"
    )
    ring = f.eye_ring_mm / 2
    extent = (-half, half), (-max(ring, around - y), ring), (-ring, z + around)
    return made_part(number, description, solid, material(d.material_of(number)), extent, boring.holes)


def make_rod_tube(d: Dimensions) -> Part:
    """Tube of a rod, cut to length; along x from the origin."""
    number, f = "rod_tube", d.forearm
    tube = cylinder(f.tube_outer_mm, (0, 0, 0), (f.tube_length_mm, 0, 0))
    row, boring = d.tube, Boring()
    boring.add(f"{f.tube_bore_mm:g} through, as bought", [between(f.tube_bore_mm, (0, 0, 0), (f.tube_length_mm, 0, 0))])
    length = f"cut {f.tube_length_mm:g}; bond in a jig to {f.length_mm:.3f} between seat centres"
    description = f"{row.description}, {length}"
    across = (-f.tube_outer_mm / 2, f.tube_outer_mm / 2)
    extent = (0.0, f.tube_length_mm), across, across
    solid = cut(tube, boring.tools)
    return made_part(number, description, solid, material(row.material), extent, boring.holes, **ordered(row))
