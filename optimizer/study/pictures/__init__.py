"""Pictures of designs and fronts: one a file, data in, figure out. Importing one of them loads matplotlib."""
