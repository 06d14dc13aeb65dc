"""From requirements to a built machine: lengths and hardware together, with a proved bound."""
