"""Force laws: the force at the handle over positions and velocities."""

from haptics.rendering.laws.constant_force import constant_force
from haptics.rendering.laws.home import home
from haptics.rendering.laws.operating_resistance import operating_resistance
from haptics.rendering.laws.spring import spring_damper
from haptics.rendering.laws.virtual_wall import virtual_wall
from haptics.rendering.table import force, law_table, stored_energy

__all__ = [
    "constant_force",
    "force",
    "home",
    "law_table",
    "operating_resistance",
    "spring_damper",
    "stored_energy",
    "virtual_wall",
]
