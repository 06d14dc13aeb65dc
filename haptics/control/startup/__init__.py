"""Start-up of a new device: compares it with its design before it may render force."""
