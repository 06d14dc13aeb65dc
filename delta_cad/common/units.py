"""Units: the one place where metres become millimetres; the Earth's gravity."""

MM_PER_M = 1000.0
M_PER_MM = 1e-3
G_PER_KG = 1000.0
GRAVITY_M_S2 = 9.81  # the Earth's to 0.5 %, as [RCIM2018] takes it
DOWN = (0.0, 0.0, -GRAVITY_M_S2)  # the default gravity in the base frame, m/s^2: the base stands level
