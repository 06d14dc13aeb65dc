"""The outline of the moving machine, bounded from both sides."""
