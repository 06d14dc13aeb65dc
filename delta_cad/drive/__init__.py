"""Motor and capstan at the joint, and the masses of the bodies they move."""

from delta_cad.drive.friction import drive_friction_N_m, idle_torque_N_m
from delta_cad.drive.report import DriveReport, drive_torque, encoder_count_rad, joint_counts_per_turn

__all__ = [
    "DriveReport",
    "drive_friction_N_m",
    "drive_torque",
    "encoder_count_rad",
    "idle_torque_N_m",
    "joint_counts_per_turn",
]
