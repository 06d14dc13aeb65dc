"""Units: the one place where metres become millimetres."""

MM_PER_M = 1000.0
M_PER_MM = 1e-3
