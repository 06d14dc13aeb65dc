"""One family of bought parts a module: its record, what must hold between its fields, the name of its CSV file."""
