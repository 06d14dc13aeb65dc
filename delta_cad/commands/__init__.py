"""The commands of `python -m delta_cad`."""
