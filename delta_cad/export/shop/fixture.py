"""The calibration plate with its columns and spacers: made parts, their STEP files and drawings, and the poses."""

from __future__ import annotations

import math
from dataclasses import dataclass
from math import cos, sin
from pathlib import Path

import numpy as np

from delta_cad.common.units import G_PER_KG, MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import FITTED_RA_UM
from delta_cad.export.drawings.part.controlled import Controlled, Length, Round
from delta_cad.export.drawings.write import Drawn, titles_of, write_part_drawing
from delta_cad.export.shop.profile import write_profiles
from delta_cad.export.shop.quotation import QuotedPart, quoted, write_quotation
from delta_cad.export.step import write_part_step
from delta_cad.mechanism import GeometryError, joint_angles
from delta_cad.mechanism.placement import CHAINS, chain_stand
from delta_cad.solids.boring import Boring, along_z, blind, fitted, tapped
from delta_cad.solids.making import GRAPHITE, made_part, material, round_z
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import bore_z, cut, feature, fuse

# Where the seats of a calibration plate are, and how high it stands: seven cones on three levels, poses in the cube.
_SEAT_WIDER_MM = 4.0  # a cone's mouth over the stem's diameter
_SEAT_WALL_MM = 1.0  # depth of the mouth before it narrows, which a drawing gives its place by
LEVELS = 3
_RING = 6  # seats about the one in the middle
SHARE = 0.8  # of the cube's half side at which the ring is: from 0.6 the error in the cube's corners would be 0.11 mm
_EDGE_MM = 4.0  # least way from a level to the cube's bottom and top
_PLATE_MM = 12.0
COLUMN_MM, _SPIGOT_MM, _SPIGOT_LONG_MM = 20.0, 10.0, 8.0
_NEXT_TO_MM = 20.0  # from the base plate's rim to a column: arms and rods stay within a cone over the plate there
_CLEAR_MM = 6.0  # from a column to a motor and its leads, seen from above
_RIM_MM = 6.0  # of the plate beyond a column


@dataclass(frozen=True)
class Seats:
    """Sizes of a calibration plate and the poses it gives, mm, base frame.

    Attributes:
        mouth_mm: Diameter of a cone where it begins.
        relief_mm: Diameter of the bore through it, for the stem's thread.
        places_mm: (7, 2) of the cones' axes.
        column_radius_mm: From the base's axis to a column.
        columns_rad: Azimuths of the columns, between the chains.
        column_mm: Length of a column under the plate, without its spigot.
        spacer_mm: Height of a spacer.
        poses_mm: (21, 3) of the platform's centre, level by level, the lowest first.
    """

    mouth_mm: float
    relief_mm: float
    places_mm: np.ndarray
    column_radius_mm: float
    columns_rad: tuple[float, ...]
    column_mm: float
    spacer_mm: float
    poses_mm: np.ndarray

    @property
    def plate_radius_mm(self) -> float:
        """Outer radius of the plate."""
        return self.column_radius_mm + COLUMN_MM / 2 + _RIM_MM


def seats_of(d: Dimensions) -> Seats:
    """Computes the seats for a machine.

    Returns:
        The seats.

    Raises:
        GeometryError: The cube is too low for three levels of whole millimetres.
    """
    from delta_cad import catalogue

    cube, stem = d.design.cube, d.platform
    mouth = stem.stem_diameter_mm + _SEAT_WIDER_MM
    # from the plate's lower face to the platform's centre: the stem's edge lies where the cone is as wide as the stem
    edge = stem.boss_diameter_mm / 2 + stem.stem_length_mm  # over the platform's centre; it stands on its hub
    below = edge - _SEAT_WALL_MM - _SEAT_WIDER_MM / 2
    bench = d.base.top_mm - d.base.thickness_mm
    lowest, highest = cube.bottom_height_mm + _EDGE_MM, cube.bottom_height_mm + 2 * cube.half_side_mm - _EDGE_MM
    column = math.ceil(lowest + below - bench)
    first = bench + column - below
    spacer = math.floor((highest - first) / (LEVELS - 1))
    if spacer < _SPIGOT_LONG_MM + 1.0:
        raise GeometryError(f"a cube of {2 * cube.half_side_mm:g} mm is too low for the three levels of a fixture")
    radius = float(round(SHARE * cube.half_side_mm))
    angles = np.arange(_RING) * math.pi / 3.0
    places = np.vstack([np.zeros(2), radius * np.column_stack([np.cos(angles), np.sin(angles)])])
    places += [d.design.workspace.centre_x * MM_PER_M, 0.0]
    poses = [(x, y, first + level * spacer) for level in range(LEVELS) for x, y in places]
    relief = catalogue.screw(stem.stem_thread).clearance_hole_mm
    return Seats(
        mouth, relief, places, _column_radius_mm(d), d.base.between_rad, float(column), float(spacer), np.array(poses)
    )


def _column_radius_mm(d: Dimensions) -> float:
    """Computes how far out columns stand: outside the base plate, and clear of each motor with its leads."""
    u, face, half = d.bracket.motor_axis_mm[0], d.layers.motor_face_mm, d.motor.diameter_mm / 2
    end = face + d.motor.length_mm + max((behind for leads in d.leads for _, behind in leads.outside_mm), default=0.0)
    radius = d.base.radius_mm + max(d.outs_mm) + _NEXT_TO_MM + COLUMN_MM / 2

    def apart_mm(angle: float, i: int) -> float:
        stand = chain_stand(d.design.geometry, i)
        x, y = (radius * np.array([cos(angle), sin(angle)]) - stand[:2, 3]) @ stand[:2, :2]
        across, along = max(abs(x - u) - half, 0.0), max(face - y, y - end, 0.0)
        return math.hypot(across, along) - COLUMN_MM / 2

    while min(apart_mm(angle, i) for angle in d.base.between_rad for i in CHAINS) < _CLEAR_MM:
        radius += 1.0
    return radius


def _nominal_readings_deg(d: Dimensions, seats: Seats) -> np.ndarray:
    """Computes what encoders of a machine as drawn read at the poses, (21, 3) degrees, to tell a wrong seat by."""
    return np.degrees(joint_angles(d.design.geometry, seats.poses_mm / MM_PER_M))


_CONE_DEG = 90.0
_THREAD, _THREAD_MM = "M6", 12.0  # by which a column stands on the bench
_COUNTS = {"calibration_plate": 1, "calibration_column": 3, "calibration_spacer": 6}
_PLACE_MM = 0.02  # of seats among each other, and of the heights of columns and spacers


def fixture_parts(s: Seats) -> tuple[Part, Part, Part]:
    """Makes plate (base frame, its lower face at z = 0), column and spacer (upright on z = 0)."""
    return (
        _plate(s),
        _post("calibration_column", "column", s.column_mm),
        _post("calibration_spacer", "spacer", s.spacer_mm),
    )


def _plate(s: Seats) -> Part:
    number, through = "calibration_plate", (0.0, _PLATE_MM)
    boring, places = Boring(), [(float(x), float(y)) for x, y in s.places_mm]
    seats = [blind(along_z(s.mouth_mm, at, (0.0, _SEAT_WALL_MM)), _CONE_DEG) for at in places]
    boring.add(
        f"seat {s.mouth_mm:g} x {_SEAT_WALL_MM:g}, below it a cone of {_CONE_DEG:g} deg, "
        f"all places within {_PLACE_MM:g}",
        seats,
    )
    boring.add(f"{s.relief_mm:g} through", (along_z(s.relief_mm, at, through) for at in places))
    columns = [s.column_radius_mm * np.array([cos(a), sin(a)]) for a in s.columns_rad]
    spigots = [fitted(along_z(_SPIGOT_MM, (float(x), float(y)), through), "H7") for x, y in columns]
    boring.add(f"{_SPIGOT_MM:g} H7 through, columns", spigots)
    disc = bore_z(2 * s.plate_radius_mm, (0.0, 0.0), through)
    solid = feature(number, "seats", "cube.half_side_mm", lambda: cut(disc, boring.tools))
    text = f"calibration plate {2 * s.plate_radius_mm:g} x {_PLATE_MM:g}, seats towards the machine"
    extent = round_z(s.plate_radius_mm, through)
    return made_part(number, text, solid, material("aluminium-6082", GRAPHITE), extent, boring.holes)


def _post(number: str, name: str, length: float) -> Part:
    """A round post with a spigot at its head; a column has a thread in its foot, a spacer the spigot's bore."""
    boring, axis = Boring(), (0.0, 0.0)
    if name == "column":
        thread = tapped(along_z(0.0, axis, (0.0, length)), _THREAD, _THREAD_MM)
        boring.add(f"{_THREAD} x {_THREAD_MM:g}, drilled {thread.depth_mm:g} deep, bench", [thread])
    else:
        deep = _SPIGOT_LONG_MM + 0.5
        boring.add(f"{_SPIGOT_MM:g} H7 x {deep:g}", [fitted(blind(along_z(_SPIGOT_MM, axis, (0.0, deep))), "H7")])
    body = fuse(bore_z(COLUMN_MM, axis, (0.0, length)), bore_z(_SPIGOT_MM, axis, (0.0, length + _SPIGOT_LONG_MM)))
    solid = feature(number, "bore", "cube.half_side_mm", lambda: cut(body, boring.tools))
    text = f"calibration {name} {COLUMN_MM:g} x {length:g}, spigot {_SPIGOT_MM:g} h6 x {_SPIGOT_LONG_MM:g}"
    extent = round_z(COLUMN_MM / 2, (0.0, length + _SPIGOT_LONG_MM))
    return made_part(number, text, solid, material("aluminium-6082", GRAPHITE), extent, boring.holes)


def _held(part: Part, s: Seats) -> Controlled:
    """What of a part is held closer than the general tolerance."""
    height = {"calibration_column": s.column_mm, "calibration_spacer": s.spacer_mm}.get(part.number)
    if height is None:
        return Controlled()
    spigot = Round(_SPIGOT_MM, "h6", surface_um=FITTED_RA_UM[6])
    return Controlled((Length(2, 0.0, height, _PLACE_MM),), rounds=(spigot,))


def write_fixture(d: Dimensions, folder: Path) -> Drawn:
    """Writes a machine's fixture: STEP file, drawing and profile of each part, `quotation.zip`, `poses.csv` to fill in.

    Returns:
        What came of the drawings.

    Raises:
        GeometryError: The cube is too low for it.
        OSError: It cannot be written.
    """
    seats, drawn, rows = seats_of(d), Drawn(), list[QuotedPart]()
    parts = fixture_parts(seats)
    for part in parts:
        held = _held(part, seats)
        write_part_step(part, folder / f"{part.number}.step", held=held, revision=d.design.drawn_revision)
        grams = part.solid.Volume() * 1e-9 * part.material.density_kg_m3 * G_PER_KG
        titles = titles_of(d, part, _COUNTS[part.number], f"{grams:.0f}")
        drawn += write_part_drawing(part, held, titles, folder)
        rows.append(quoted(part, titles))
    write_profiles(parts, folder)
    write_quotation(rows, folder)
    (folder / "poses.csv").write_text(_poses_text(d, seats), encoding="utf-8")
    return drawn


def _poses_text(d: Dimensions, seats: Seats) -> str:
    """Gives the poses in the columns that `python -m haptics calibrate` reads, readings as of a machine as drawn.

    The readings are there to be replaced by those of the made one: left as they are, they calibrate to nothing.
    """
    lines = ["x_mm,y_mm,z_mm,reading_0_deg,reading_1_deg,reading_2_deg"]
    for p, readings in zip(seats.poses_mm, _nominal_readings_deg(d, seats), strict=True):
        lines.append(",".join([*(f"{v:.6f}" for v in p), *(f"{v:.4f}" for v in readings)]))
    return "\n".join(lines) + "\n"
