"""The mechanism over a box, enclosed in two arithmetics that share no code: affine forms, and slopes of intervals."""
