"""The views of a part, each with what is told in it."""
