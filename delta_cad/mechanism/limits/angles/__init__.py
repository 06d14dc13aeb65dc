"""Limits of the angles at which a chain stands."""
