"""Faults planted one at a time in the assembly of the committed design: which of them do the checks refuse.

On demand by `make faults`; a sample runs with the tests.
"""
