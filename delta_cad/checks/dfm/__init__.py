"""What parts are made of, and whether a shop can make them: bores where they are declared, corners, walls, setups."""
