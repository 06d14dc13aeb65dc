"""Force laws, one a file: its parameters and their checks, compiled force and energy, and its function of states."""
