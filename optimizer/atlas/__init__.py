"""Many sets of requirements at once."""
