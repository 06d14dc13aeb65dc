"""Joints, their axes and ranges, and the torque that holds the machine."""
