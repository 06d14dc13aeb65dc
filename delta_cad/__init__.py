"""Delta haptic devices as checked, machinable CAD models; importing this package loads nothing else."""
