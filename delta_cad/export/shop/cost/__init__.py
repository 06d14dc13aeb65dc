"""What a machine costs: material, machining and bought parts, for one, ten and a hundred."""
