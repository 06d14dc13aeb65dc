"""Limits on the lengths alone, which closed forms decide for the whole cube."""
