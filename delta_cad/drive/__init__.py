"""What moves the machine and what is moved: motor and capstan at the joint, masses of the bodies."""

from delta_cad.drive.report import DriveReport, drive_torque

__all__ = ["DriveReport", "drive_torque"]
