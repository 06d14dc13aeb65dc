"""The three steps run one after the other, kept, taken up again, and written as a design."""
