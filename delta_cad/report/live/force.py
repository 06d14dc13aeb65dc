"""What the handle gives the hand in the scenes of the live page: forces as they are asked for, without the loop."""

from __future__ import annotations

import numpy as np

FREE, FLOOR, RESISTANCE = "none, weight held", "floor at half height", "viscous resistance"
SCENES = (FREE, FLOOR, RESISTANCE)
FLOOR_N_MM = 1.0  # 3 N at 3 mm: seen in the picture, and less than any loop of ours bears
RESISTANCE_N_S_MM = 0.02  # 2 N at 100 mm/s, a quick move of a hand


def felt(scene: str, most_N: float, above_mm: float, v_mm_s: np.ndarray) -> np.ndarray:
    """Computes the force on the hand.

    Args:
        scene: One of `SCENES`.
        most_N: Continuous force of the machine; more than that is not given.
        above_mm: Height of the handle over the cube's centre.
        v_mm_s: (3,) velocity of the handle.

    Returns:
        (3,) force in the base frame, N.
    """
    force = np.zeros(3)
    if scene == FLOOR:
        force[2] = FLOOR_N_MM * max(-above_mm, 0.0)
    elif scene == RESISTANCE:
        force = -RESISTANCE_N_S_MM * np.asarray(v_mm_s)
    size = float(np.linalg.norm(force))
    return force * (most_N / size) if size > most_N else force
