"""Cost of a machine: material, machining and bought parts, for one, ten and a hundred."""
