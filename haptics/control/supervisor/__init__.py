"""The supervisor: faults, limits, and the calls of a tick."""
