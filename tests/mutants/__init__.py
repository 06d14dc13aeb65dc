"""Faults planted one at a time in a copy of the project, on demand by `make mutants`: which of them do tests catch."""
