"""Measurements of [RCIM2018] on its prototype; copied from its text and table 13, never adjusted."""

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry

STIFFNESS_N_PER_MM = {"x": 4.9, "y": 5.1, "z": 4.5}  # Largest stable wall along each axis, table 13
# Where the joint torques were read, from the origin of the handle's travel.
GRAVITY_POSITIONS_MM = ((0.0, 0.0, 0.0), (1.5243, 17.6991, 33.3409))
# Torque of the three joints at each position, mN m.
GRAVITY_TORQUES_MN_M = ((16.18, 16.28, 16.34), (15.62, 13.45, 18.76))
# Azimuths of the chains in the frame of those positions. Not printed: the only order of three chains at 120 deg, one of
# them along x, that fits the second row.
GRAVITY_AZIMUTHS_DEG = (180.0, 300.0, 60.0)
# The prototype, table 11.
GRAVITY_LENGTHS_MM = {"base_radius": 40.0, "platform_radius": 30.0, "upper_arm_length": 82.0, "forearm_length": 112.1}
_SAME_MM = 0.1  # Tables 11 and 12 print the forearm's length as 112.1 and 112.079


def of_published_lengths(g: DeltaGeometry) -> bool:
    """Whether a mechanism is that of the prototype; else what is measured there is of another machine."""
    return g.three_fold and all(
        abs(MM_PER_M * getattr(g, name) - length) <= _SAME_MM for name, length in GRAVITY_LENGTHS_MM.items()
    )
