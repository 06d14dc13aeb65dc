"""A device as it came out of the shop: its lengths, zeros and encoders from poses at known positions."""
