"""Motor and capstan at the joint, and the masses of the bodies they move."""

from delta_cad.drive.report import DriveReport, drive_torque, joint_counts_per_turn

__all__ = ["DriveReport", "drive_torque", "joint_counts_per_turn"]
