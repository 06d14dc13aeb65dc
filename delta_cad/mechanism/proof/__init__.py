"""Proof over the continuum of a cube: affine forms, enclosures of every figure, branch and bound."""
