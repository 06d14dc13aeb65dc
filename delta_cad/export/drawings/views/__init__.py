"""The views of a part with their annotations."""
