"""Mathematics of the delta mechanism: NumPy only, no files, no clock, no randomness.

Every function takes positions or angles of shape (..., 3) in SI units; the formulas are derived in README.md.
"""
# ruff: noqa: F401  the names are for those who import the package

from delta_cad.mechanism.errors import BranchError, GeometryError, MechanismError, SingularError, UnreachableError
from delta_cad.mechanism.forward import forward_kinematics, platform_positions
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import (
    closure_margin,
    elbow_positions,
    forearm_angle,
    forearm_vectors,
    inverse_kinematics,
    joint_angles,
    reach_excess,
    rod_lean,
    wrist_positions,
)
from delta_cad.mechanism.jacobian import inverse_jacobian, jacobian
from delta_cad.mechanism.statics import conditioning, direct_margin, serial_margin, singular_values, worst_joint_torque
from delta_cad.mechanism.workspace import (
    Cube,
    CubeExtremes,
    Extreme,
    cube_extremes,
    cube_grid,
    cube_surface,
)
