"""Masses to begin a search from, of a machine of 86 mm and 3 N; those of the first candidate's solids follow."""

from __future__ import annotations

from delta_cad.drive.masses import Masses
from optimizer.codesign.lessons import Weighed


def reference() -> Weighed:
    """Gives them, rounded: nothing that is told rests on them."""
    masses = Masses(
        platform=0.065,
        arm_along=0.0022,
        arm_across=-0.0004,
        arm_inertia=1.85e-4,
        rod_elbow=0.0038,
        rod_cross=0.0014,
        rod_wrist=0.0038,
        rotor_inertia=8e-5,
    )
    return Weighed(masses, gravity_torque_N_m=0.036, upper_arm_mm=91.0, forearm_mm=143.0, ratio=4.8)
