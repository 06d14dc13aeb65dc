"""The outline that the machine sweeps, enclosed from both sides."""
