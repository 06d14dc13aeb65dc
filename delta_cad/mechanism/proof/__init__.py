"""Proof over the continuum of a cube: the margins of all limits, branch and bound."""
