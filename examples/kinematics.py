"""Kinematics and Jacobian of a design: `python examples/kinematics.py`, from the folder of best.json."""

import numpy as np

from delta_cad.design import load_design
from delta_cad.mechanism import conditioning, forward_kinematics, inverse_kinematics, jacobian, worst_joint_torque

design = load_design("best.json")
g = design.geometry  # metres
centre = design.workspace.centre  # of the cube, m
p = centre + np.array([0.020, 0.010, 0.005])

theta = inverse_kinematics(g, p)
back = forward_kinematics(g, theta)
J = jacobian(g, p)  # v = J theta_dot
torque = J.T @ [0.0, 0.0, 3.0]  # what the joints give for 3 N upwards on the hand, gravity not counted
kappa, worst = conditioning(g, p), worst_joint_torque(g, p, force=3.0).max()

# Expect three different shoulder angles, an error of rounding only, and no joint beyond the worst-case torque.
print(f"position          {p * 1000} mm")
print(f"shoulder angles   {np.degrees(theta).round(3)} deg")
print(f"there and back    {np.linalg.norm(back - p) * 1000:.1e} mm")
print(f"torques for 3 N   {torque.round(4)} N m")
print(f"worst direction   {worst:.4f} N m")
print(f"condition number  {kappa:.4f}")
