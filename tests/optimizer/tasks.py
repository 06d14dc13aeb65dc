"""The paper's tasks as requirements, and a store in memory, for the tests of the optimiser."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from optimizer.problem.evaluator import fold_points, shared_points
from optimizer.problem.requirements import Requirements, requirements_from_dict
from optimizer.synthesis.checkpoint import Checkpoint

Range = tuple[float, float]


def task(
    forearm_length: Range = (40, 130),
    platform_radius: Range = (20, 45),
    bottom_height: Range = (40, 100),
    half_side: Range = (0, 100),
    base_radius: Range = (40, 40),
    upper_arm_length: Range = (82, 82),
    limits: dict[str, Any] | None = None,
    half_side_mm: float | None = None,
    torque: float = 0.8,
    inertia: dict[str, float] | None = None,
    joints: dict[str, float] | None = None,
) -> Requirements:
    """270 x 220 mm, 3 N, 0.8 N m, R + L_A <= 122 mm, with the bounds of [RCIM2018] table 3 unless told otherwise."""
    return requirements_from_dict(
        {
            "name": "task",
            "requirements": {
                "envelope_width_mm": 270.0,
                "envelope_depth_mm": 220.0,
                "force_N": 3.0,
                "joint_torque_N_m": torque,
            },
            "bounds_mm": {
                "upper_arm_length": upper_arm_length,
                "forearm_length": forearm_length,
                "base_radius": base_radius,
                "platform_radius": platform_radius,
                "bottom_height": bottom_height,
                "half_side": half_side,
            },
            "limits": {"outline_radius_max_mm": 122.0} if limits is None else limits,
            "step_3": {} if half_side_mm is None else {"half_side_mm": half_side_mm},
        }
        | ({} if inertia is None else {"inertia": inertia})
        | ({} if joints is None else {"joints": joints})
    )


INERTIA = {"carried_mass_kg": 0.08, "elbow_mass_kg": 0.02, "cross_mass_kg": 0.004, "joint_inertia_kg_m2": 2.1e-4}
"""About that of a machine built for the former task, with 4.3 turns of the pinion a turn of the arm."""
JOINTS = {"friction_N_m": 0.012, "ball_upright_N": 0.05, "ball_level_N": 0.08, "encoder_count_deg": 0.022}
"""About what its joints rub and tell."""


class Memory(Checkpoint):
    """A store that keeps everything as JSON, as a file would."""

    def __init__(self) -> None:
        self._done = {}

    def append(self, record: dict[str, Any]) -> None:
        self.take(json.loads(json.dumps(record, allow_nan=False)))


def sample_points(designs: np.ndarray, n: int) -> np.ndarray:
    """(D, K, 3) surface grid, centre and fold points of each design."""
    fixed = shared_points(n)
    return np.concatenate([np.broadcast_to(fixed, (len(designs), *fixed.shape)), fold_points(designs)], axis=1)
