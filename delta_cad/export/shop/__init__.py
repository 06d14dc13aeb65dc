"""Data for a workshop in addition to the solids: the list of holes, tolerances as data."""
