"""Pictures of what was simulated: one a file, data in, figure out. Importing one of them loads matplotlib."""
