"""Clearance over the whole cube: which bodies, in which configuration spaces, sampled and proven."""
