"""Where a capstan's cable leaves its sector, and what holds it there (arm's frame)."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from delta_cad.dimensions.capstan import ANCHOR_MM, CARRIAGE_FROM_MM, CARRIAGE_MM, CRIMP_MM, CapstanDimensions
from delta_cad.mechanism.placement import frames

RIM_MM = 3.5  # height of the rim's full width under the cable
SLEEVE_OVER_MM = (CARRIAGE_MM[1] + CRIMP_MM[0]) / 2 + 0.6  # aside of its seat, so far a sleeve passes over its carriage


def rim_end(c: CapstanDimensions, end: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Locates where the cable leaves the sector: point, tangent and normal away from it, each (3,) in the arm's frame.

    Args:
        c: The capstan.
        end: 0 for the smaller polar angle, where the cable has turned inwards round the nose; 1 for the larger.
    """
    sense = 1.0 if end else -1.0
    angle = c.rim_angles_rad[end] + sense * c.turns_rad[end]
    normal = np.array([cos(angle), 0.0, sin(angle)])
    tangent = sense * np.array([-sin(angle), 0.0, cos(angle)])
    beside = np.array([0.0, c.end_y_mm[end], 0.0])
    if end:
        return beside + c.pitch_radius_mm * normal, tangent, normal
    x, z = c.nose_centre_mm
    nose = np.array([x, 0.0, z]) + (c.nose_radius_mm + c.cable_diameter_mm / 2) * normal
    return beside + nose, tangent, normal


def carriage_frame(c: CapstanDimensions) -> np.ndarray:
    """(4, 4) frame of the tension carriage in the arm's frame: x outwards, y along the shoulder's axis, z off the rim.

    The origin lies on the cable's line where the carriage begins.
    """
    point, tangent, normal = rim_end(c, 1)
    frame = frames(normal, np.cross(tangent, normal), point + CARRIAGE_FROM_MM * tangent)
    assert np.allclose(frame[:3, 2], tangent)
    return frame


def sleeve_frames(c: CapstanDimensions) -> tuple[np.ndarray, np.ndarray]:
    """(4, 4) frames of both crimp sleeves in the arm's frame, behind the anchor's wall and in the carriage."""
    found = []
    for end, back in enumerate((ANCHOR_MM, CARRIAGE_FROM_MM + CARRIAGE_MM[0] - CRIMP_MM[1])):
        point, tangent, normal = rim_end(c, end)
        found.append(frames(normal, np.cross(tangent, normal), point + back * tangent))
    return found[0], found[1]
