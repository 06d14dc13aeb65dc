"""The searches: GA, SQP on active points, and results that recompute their own violations."""
