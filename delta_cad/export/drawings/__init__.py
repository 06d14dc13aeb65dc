"""Dimensioned drawings of the made parts and of the assembly; see `drawn` for what is written."""
