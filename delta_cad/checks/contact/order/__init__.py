"""The order of assembly: every part has a path to its seat, every screw a key."""
