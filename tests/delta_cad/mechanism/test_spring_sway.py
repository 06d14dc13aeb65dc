"""How far a spring strays, against pairs of rods that lean and turn, each rod by itself."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from delta_cad.mechanism.placement import spring_sway


@pytest.mark.parametrize("eye_mm", [(0.8, 5.5), (4.0, 0.5)])
def test_no_pair_of_rods_lets_its_spring_stray_farther(eye_mm: tuple[float, float]) -> None:
    """Eyes as vectors on rods 54 mm apart along y; and no bound is far beyond what some pair does.

    A rod that leans turns about itself by no more than `cos(lean) cos(turn) >= cos(tilt)`. The spring runs from the eye
    of the one rod to that of the other; its direction is taken against the shoulder axis, its middle against where it
    lies while neither rod turns.
    """
    width, tilt, (inside, aside) = 54.0, np.radians(31.0), eye_mm
    bound = spring_sway(width, inside, aside, tilt)
    along, across, turned = [], [], []
    for lean in np.linspace(0.0, tilt, 25):
        most = float(np.arccos(min(np.cos(tilt) / np.cos(lean), 1.0)))
        rod = np.array([np.cos(lean), np.sin(lean), 0.0])  # x square to the shoulder axis y
        facing, normal = np.array([-np.sin(lean), np.cos(lean), 0.0]), np.array([0.0, 0.0, 1.0])
        near, far = inside * facing + aside * normal, -inside * facing + aside * normal
        for first, second in product(np.linspace(-most, most, 9), repeat=2):
            a, b = Rotation.from_rotvec(first * rod).apply(near), Rotation.from_rotvec(second * rod).apply(far)
            spring = np.array([0.0, width, 0.0]) + b - a
            moved = (a - near + b - far) / 2.0
            turned.append(np.arccos(spring[1] / np.linalg.norm(spring)))
            along.append(abs(moved[1]))
            across.append(np.hypot(moved[0], moved[2]))
    for found, limit, share in (
        (max(along), bound.along_mm, 0.5),  # the eyes' turns inwards cancel
        (max(across), bound.across_mm, 0.95),
        (max(turned), bound.turn_rad, 0.85),
    ):
        assert share * limit <= found <= limit * (1.0 + 1e-12)
