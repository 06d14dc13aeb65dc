"""Why hardware cannot do, in closed form and all at once, and what would do in its place."""
