"""The simulated scenes, one per file: the runs of a figure of the paper, their results, and the stated properties.

Importing one of them loads numba.
"""
