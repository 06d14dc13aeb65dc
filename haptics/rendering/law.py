"""What a force law is: named parameters with their checks, a compiled force, and the energy that it stores.

A table of laws has a law in each row, in doubles: `KIND` (its number in the registry), `GAIN` (0 to 1, a factor of the
force), then its parameters in the order of its fields; what is left of the row is 0. A law's own file names its
columns by `columns` and nobody else reads them. Compiled functions trust the table, which only holds what was checked.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import fields
from functools import cache
from typing import Any, NamedTuple, get_type_hints

import numpy as np

from delta_cad.common.jit import compiled

KIND, GAIN, FIRST = 0, 1, 2  # Columns that all laws have, and the first of a law's own parameters


class LawError(ValueError):
    """A force law that is refused; the message names field, value and what is allowed."""


class _Parameter(NamedTuple):
    """Unit, width and check of a parameter; the annotation of a law's field.

    Attributes:
        unit: Unit of the numbers.
        width: How many columns it takes.
        checked: Field name, value and unit -> the checked number or vector; raises `LawError`.
    """

    unit: str
    width: int
    checked: Callable[[str, Any, str], Any]


class ForceLaw:
    """A law with its parameters: the base of one frozen dataclass a law, whose fields are annotated by `_Parameter`."""

    @classmethod
    def parameters(cls) -> dict[str, _Parameter]:
        """The parameter of each field, in the order of the columns."""
        return _parameters(cls)

    def __post_init__(self) -> None:
        self.values()

    def values(self) -> np.ndarray:
        """The checked parameters, one column after the other.

        Raises:
            LawError: A parameter is out of its bounds.
        """
        parts = [p.checked(name, getattr(self, name), p.unit) for name, p in self.parameters().items()]
        return np.concatenate([np.atleast_1d(part) for part in parts])


class Law(NamedTuple):
    """A law in all its forms, as the registry lists it.

    Attributes:
        parameters: The dataclass of its parameters.
        force: Compiled: table, row, position (m) and velocity (m/s) in six doubles -> fx, fy, fz at gain 1, N.
        energy: Compiled: table, row and position in three doubles (m) -> stored energy at gain 1, J; minus its gradient
            is the force at rest.
    """

    parameters: type[ForceLaw]
    force: Any
    energy: Any


@cache
def _parameters(law: type[ForceLaw]) -> dict[str, _Parameter]:
    hints = get_type_hints(law, include_extras=True)
    return {field.name: hints[field.name].__metadata__[0] for field in fields(law)}  # pyright: ignore


def columns(law: type[ForceLaw]) -> tuple[int, ...]:
    """First column of each parameter of a law, in the order of its fields."""
    first, places = FIRST, []
    for parameter in law.parameters().values():
        places.append(first)
        first += parameter.width
    return tuple(places)


@compiled
def spring_energy(stiffness, stretch, longest):
    """Energy of a spring whose pull stays constant beyond a longest stretch, J.

    Args:
        stiffness: N/m.
        stretch: Not negative, m.
        longest: m; may be infinite.
    """
    bent = min(stretch, longest)
    return stiffness * bent * (stretch - 0.5 * bent)


def finite(unit: str) -> _Parameter:
    """Declares a parameter of one column that must be a finite number of a unit."""
    return _number(unit, "", lambda _: True)


def not_negative(unit: str) -> _Parameter:
    """Declares a parameter of one column that must be finite and at least 0."""
    return _number(unit, " and not negative", lambda value: value >= 0.0)


def positive(unit: str) -> _Parameter:
    """Declares a parameter of one column that must be finite and above 0."""
    return _number(unit, " and positive", lambda value: value > 0.0)


def _number(unit: str, bound: str, holds: Callable[[float], bool]) -> _Parameter:
    def check(field: str, value: float, unit: str) -> float:
        if not (math.isfinite(value) and holds(value)):
            raise LawError(f"{field} is {value!r} {unit}; it must be finite{bound}")
        return float(value)

    return _Parameter(unit, 1, check)


def vector(unit: str) -> _Parameter:
    """Declares a parameter of three columns: finite numbers in the base frame.

    Args:
        unit: Unit of the numbers.
    """
    return _Parameter(unit, 3, _vector)


def direction() -> _Parameter:
    """Declares a direction: three finite numbers that are not all 0, of which the table holds the unit vector."""
    return _Parameter("1", 3, _direction)


def _vector(field: str, value: Any, unit: str) -> np.ndarray:
    array = np.asarray(value, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise LawError(f"{field} is {value!r}; it must be three finite numbers ({unit})")
    return array


def _direction(field: str, value: Any, unit: str) -> np.ndarray:
    n = _vector(field, value, unit)
    largest = float(np.abs(n).max())
    if largest == 0.0:
        raise LawError(f"{field} is (0, 0, 0); it must have a direction")
    n = n / largest  # so that its squares neither vanish nor overflow
    return n / np.sqrt(n @ n)
