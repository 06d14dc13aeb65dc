"""Holding torques against gravity, and the masses that the published ones identify."""

from haptics.gravity.torque import arm_directions, gravity_torque, potential_energy

__all__ = ["arm_directions", "gravity_torque", "potential_energy"]
