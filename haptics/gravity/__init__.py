"""Holding torques against gravity, and what the published ones tell."""

from haptics.gravity.torque import arm_directions, gravity_torque, potential_energy

__all__ = ["arm_directions", "gravity_torque", "potential_energy"]
