"""What touches: fits, screws, running gaps, and that nothing floats."""
