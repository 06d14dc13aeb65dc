"""A new device's first minute: is it what the design says, before it may render force."""
