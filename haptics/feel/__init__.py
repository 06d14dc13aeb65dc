"""The feel sheet: figures over the cube and how they compare."""
