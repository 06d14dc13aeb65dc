"""The studio: requirements as sliders, the largest cube or smallest machine while they move, a build from the page."""
