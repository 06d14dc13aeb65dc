"""Positions of the seats of a calibration plate, and its height: seven cones on three levels, poses in the cube.

The plate stands over the machine on three columns, between the chains, on whatever the base plate is screwed to with
its feet off. The knob is taken off; the upper edge of the handle's stem, a sharp circle, centres itself in a cone of 90
degrees, whatever the stem's diameter is. Spacers under the plate make the other levels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.mechanism import GeometryError, joint_angles

SEAT_WIDER_MM = 4.0  # a cone's mouth over the stem's diameter
SEAT_WALL_MM = 1.0  # depth of the mouth before it narrows, which a drawing gives its place by
LEVELS = 3
RING = 6  # seats about the one in the middle
SHARE = 0.8  # of the cube's half side at which the ring is: from 0.6 the error in the cube's corners would be 0.11 mm
EDGE_MM = 4.0  # least way from a level to the cube's bottom and top
PLATE_MM = 12.0
COLUMN_MM, SPIGOT_MM, SPIGOT_LONG_MM = 20.0, 10.0, 8.0
BESIDE_MM = 20.0  # from the base plate's rim to a column: arms and rods stay within a cone over the plate there
RIM_MM = 6.0  # of the plate beyond a column


@dataclass(frozen=True)
class Seats:
    """Sizes of a calibration plate and the poses it gives, mm, base frame.

    Attributes:
        mouth_mm: Diameter of a cone where it begins.
        relief_mm: Diameter of the bore through it, for the stem's thread.
        places_mm: (7, 2) of the cones' axes.
        column_radius_mm: From the middle to a column.
        column_mm: Length of a column under the plate, without its spigot.
        spacer_mm: Height of a spacer.
        poses_mm: (21, 3) of the platform's centre, level by level, the lowest first.
    """

    mouth_mm: float
    relief_mm: float
    places_mm: np.ndarray
    column_radius_mm: float
    column_mm: float
    spacer_mm: float
    poses_mm: np.ndarray

    @property
    def plate_radius_mm(self) -> float:
        """Outer radius of the plate."""
        return self.column_radius_mm + COLUMN_MM / 2 + RIM_MM


def seats_of(d: Dimensions) -> Seats:
    """Computes the seats for a machine.

    Returns:
        The seats.

    Raises:
        GeometryError: The cube is too low for three levels of whole millimetres.
    """
    from delta_cad import catalogue

    cube, stem = d.design.cube, d.platform
    mouth = stem.stem_diameter_mm + SEAT_WIDER_MM
    # from the plate's lower face to the platform's centre: the stem's edge lies where the cone is as wide as the stem
    edge = stem.boss_diameter_mm / 2 + stem.stem_length_mm  # over the platform's centre; it stands on its hub
    below = edge - SEAT_WALL_MM - SEAT_WIDER_MM / 2
    bench = d.base.top_mm - d.base.thickness_mm
    lowest, highest = cube.bottom_height_mm + EDGE_MM, cube.bottom_height_mm + 2 * cube.half_side_mm - EDGE_MM
    column = math.ceil(lowest + below - bench)
    first = bench + column - below
    spacer = math.floor((highest - first) / (LEVELS - 1))
    if spacer < SPIGOT_LONG_MM + 1.0:
        raise GeometryError(f"a cube of {2 * cube.half_side_mm:g} mm is too low for the three levels of a fixture")
    radius = float(round(SHARE * cube.half_side_mm))
    angles = np.arange(RING) * math.pi / 3.0
    places = np.vstack([np.zeros(2), radius * np.column_stack([np.cos(angles), np.sin(angles)])])
    poses = [(x, y, first + level * spacer) for level in range(LEVELS) for x, y in places]
    relief = catalogue.screw(stem.stem_thread).clearance_hole_mm
    beside = d.base.radius_mm + BESIDE_MM + COLUMN_MM / 2
    return Seats(mouth, relief, places, beside, float(column), float(spacer), np.array(poses))


def nominal_readings_deg(d: Dimensions, seats: Seats) -> np.ndarray:
    """Computes what encoders of a machine as drawn read at the poses, (21, 3) degrees, to tell a wrong seat by."""
    return np.degrees(joint_angles(d.design.geometry, seats.poses_mm / MM_PER_M))
