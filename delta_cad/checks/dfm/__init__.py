"""Manufacturability of parts: declared bores, corners, walls, setups."""
