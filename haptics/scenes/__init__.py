"""The scenes that are simulated, one a file: the runs of a figure of the paper, what they came to, what is promised.

Importing one of them loads numba.
"""
