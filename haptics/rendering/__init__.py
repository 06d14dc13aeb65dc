"""Force laws: what is felt at the handle, over positions and velocities."""

from haptics.rendering.forces import (
    constant_force,
    force,
    home,
    operating_resistance,
    spring_damper,
    stored_energy,
    virtual_wall,
)

__all__ = [
    "constant_force",
    "force",
    "home",
    "operating_resistance",
    "spring_damper",
    "stored_energy",
    "virtual_wall",
]
