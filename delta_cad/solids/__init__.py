"""One part a file: `make_<part>(dimensions) -> Part`; every number comes from `dimensions` or the catalogue."""
