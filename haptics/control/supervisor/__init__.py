"""What lets nothing unsafe pass: faults, limits, and the calls of a tick."""
