"""The task: requirements, design variables, figures over the cube, and the three steps of the paper."""
