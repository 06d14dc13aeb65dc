"""Gravity compensation, force rendering and the simulated loop of a delta haptic device."""
