"""What passes what of other chains, before any solid is made: shapes that solids hold, at sampled positions."""
