"""What is single and what stays double in a controller for a board without doubles in hardware.

Pose, laws, filters and saturation lose nothing that a hand feels in single precision: a torque is 1e-5 N m off. Three
things would be lost, and stay in double:

- the clock: from 8,192 s on a single step of it is longer than the slack of a deadline;
- faults: bit 25 and bit 1 do not fit into 24 bits of mantissa, so those bits are kept where 53 are;
- sums over a long time: the heat of a motor grows by 1e-8 of itself in a tick, the tank and the energy given likewise.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.core import types

from haptics.control.supervisor import memory, supervisor
from haptics.model import motor_heat

REAL, SINGLE, INTEGER = types.float64, types.float32, types.int64
# Functions whose numbers all stay double: the clock's and the sum of heat; what is added to that is single.
EXACT_FUNCTIONS = (supervisor._clock, supervisor._motors, motor_heat.warmed)
# Places of the supervisor's memory that stay double -> their number.
EXACT_PLACES = {
    "LATCHED": 1,
    "PRESENT": 1,
    "SIGNALS": 1,
    "NOW": 1,
    "HEARD": 1,
    "TICKS": 1,
    "TANK": 1,
    "GIVEN": 1,
    "WINDING": 3,
    "HOUSING": 3,
}
EXACT_ARGUMENTS = ("now",)


class Precision(NamedTuple):
    """Kinds of the real numbers in a translation.

    Attributes:
        single: Whether what need not be double is single.
    """

    single: bool

    @property
    def real(self) -> Any:
        """Kind of a real number where nothing else is said."""
        return SINGLE if self.single else REAL

    def of_function(self, function: Any) -> Any:
        """Kind of the real numbers in a function."""
        return REAL if function in EXACT_FUNCTIONS else self.real

    def of_argument(self, name: str, function: Any) -> Any:
        """Kind of a real argument of a function."""
        return REAL if name in EXACT_ARGUMENTS else self.of_function(function)

    def place(self, name: str) -> int | None:
        """Where a place of the supervisor's memory lies among those that stay double; None if it does not."""
        if not self.single or name not in EXACT_PLACES:
            return None
        names = list(EXACT_PLACES)
        return sum(EXACT_PLACES[before] for before in names[: names.index(name)])

    def placed(self, values: Any) -> list[float]:
        """Of a whole memory, what stays double, in the order of its places."""
        return [
            float(values[getattr(memory, name) + k])
            for name, width in EXACT_PLACES.items()
            for k in range(width)
            if self.single
        ]


DOUBLE = Precision(single=False)
MIXED = Precision(single=True)
