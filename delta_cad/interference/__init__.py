"""Interference between chains before CAD: shapes contained in the solids, at sampled positions."""
