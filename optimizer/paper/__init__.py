"""The published tables of [RCIM2018] recomputed."""
