"""Single and double precision in a controller for a board without doubles in hardware.

Pose, laws, filters and saturation lose nothing that a hand feels in single precision: a torque is 1e-5 N m off. Two
things would be lost, and stay in double:

- the clock: from 8,192 s on a single step of it is longer than the slack of a deadline;
- sums over a long time: the heat of a motor grows by 1e-8 of itself in a tick, the tank and the energy given likewise.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.core import types

from haptics.control.supervisor import supervisor
from haptics.model import motor_heat

REAL, SINGLE, INTEGER = types.float64, types.float32, types.int64
# Functions whose numbers all stay double: the clock's and the sum of heat; what is added to that is single.
EXACT_FUNCTIONS = (supervisor._clock, supervisor._motors, motor_heat.warmed)
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


DOUBLE = Precision(single=False)
MIXED = Precision(single=True)
