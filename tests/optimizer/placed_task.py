"""The joystick's task with the hardware of `best.json`, its placement symmetric or free: as `design` poses its lengths.

Masses, friction and the torque that the weight takes are those of the committed machine, rounded; the outline has what
that machine takes beyond eq. (1).
"""

from __future__ import annotations

from typing import Any

from optimizer.problem.requirements import Requirements, requirements_from_dict

FREE: dict[str, Any] = {
    "bounds_mm": {"side_shift": [0.0, 40.0], "centre_x": [-30.0, 30.0]},
    "bounds_deg": {"azimuth": [95.0, 140.0]},
}


def joystick_task(placed: dict[str, Any] | None = None, **limits: Any) -> Requirements:
    """The requirements of the first edition, whose second step finds the largest cube.

    Args:
        placed: Tables that free the placement, such as `FREE`; None where it is three-fold symmetric.
        **limits: Entries of `[limits]` in the place of those here.
    """
    data: dict[str, Any] = {
        "name": "joystick",
        "requirements": {
            "envelope_width_mm": 270.0,
            "envelope_depth_mm": 220.0,
            "force_N": 3.0,
            "joint_torque_N_m": 0.3957,
        },
        "bounds_mm": {
            "upper_arm_length": [60.0, 130.0],
            "forearm_length": [100.0, 220.0],
            "base_radius": [31.18, 80.0],
            "platform_radius": [21.3, 66.0],
            "bottom_height": [40.0, 140.0],
            "half_side": [0.0, 60.0],
        },
        "limits": {
            "parallelogram_width_mm": 50.0,
            "outline_overhead_mm": [9.6, 13.2],
            "kappa_max": 2.27,
            "couple_index_min": 0.4,
            "lean_max_deg": 30.0,
            "shoulder_deg": [-60.0, 65.0],
            "gravity_torque_N_m": 0.0315,
            "effective_mass_max_kg": 0.4,
            "friction_max_N": 0.8,
            "clearance_min_mm": 2.0,
            "joint_diameter_mm": 9.89,
        }
        | limits,
        "hardware": {"ball_diameter_mm": 6.0},
        "inertia": {
            "carried_mass_kg": 0.0764,
            "elbow_mass_kg": 0.0038,
            "cross_mass_kg": 0.0014,
            "joint_inertia_kg_m2": 2.7e-4,
        },
        "joints": {
            "friction_N_m": 0.0121,
            "ball_upright_N": 0.12,
            "ball_level_N": 0.18,
            "encoder_count_deg": 0.02,
        },
    }
    for table, fields in (placed or {}).items():
        data[table] = data.get(table, {}) | fields
    return requirements_from_dict(data)
