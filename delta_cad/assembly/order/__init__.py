"""In which order a machine is put together: units, steps, and the way that each part comes in."""
