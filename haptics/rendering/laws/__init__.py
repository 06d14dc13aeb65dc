"""Force laws, one per file: parameters and their checks, compiled force and energy, and a function of states."""
