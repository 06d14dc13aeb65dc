"""Dimensioned drawings of the made parts and of the assembly; see `write` for what is written."""
