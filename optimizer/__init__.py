"""Dimensional synthesis of delta haptic devices: from a customer's requirements to the design variables."""
