"""What a shop asks for beside the solids: the list of holes, tolerances as data."""
