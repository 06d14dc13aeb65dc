"""Dimensioned drawings of the made parts and of the assembly; `write` lists the files."""
