"""The sampled loop in time, what is assumed of it, and its series."""
