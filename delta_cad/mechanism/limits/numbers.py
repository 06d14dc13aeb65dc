"""Numbers of limits: read from certificates, held to their bounds, turned to radians; and masses that limits read."""

from __future__ import annotations

import math
import reprlib
import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields
from decimal import Decimal, localcontext
from typing import ClassVar, Self

from delta_cad.mechanism.errors import GeometryError


def number(key: str, value: object) -> float:
    """Reads a number of a certificate; true, false and text are none.

    Raises:
        GeometryError: It is none, or no double can hold it.
    """
    is_number = isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= sys.float_info.max
    require(key, value, is_number, "a finite number")
    return float(value)  # type: ignore[arg-type]


def require(name: str, value: object, holds: bool, allowed: str) -> None:
    """Refuses a number.

    Raises:
        GeometryError: It does not hold.
    """
    if not holds:
        raise GeometryError(f"{name} is {reprlib.repr(value)}; it must be {allowed}")


def strict_radians(degrees: float, towards: float) -> float:
    """Converts to radians, two doubles further towards the stricter side than any rounding can undo.

    Args:
        degrees: An angle.
        towards: Infinity for a lower threshold, minus infinity for an upper one.
    """
    return math.nextafter(math.nextafter(math.radians(degrees), towards), towards)


def cosine_sine(*terms: float) -> tuple[float, float]:
    """Computes cosine and sine of half the sum of some doubles, each the double nearest to the true value.

    The libraries' own functions promise no error bound; this is Taylor's series in 60 decimal digits.

    Args:
        terms: Angles whose halved sum, at most 4 in size, is the argument, rad.

    Returns:
        cos, sin: within 2^-53 of the true value.
    """
    with localcontext() as context:
        context.prec = 60
        x = sum((Decimal(t) for t in terms), Decimal(0)) / 2
        sums, term, k = [Decimal(1), Decimal(0)], Decimal(1), 0
        while abs(term) > Decimal("1e-50"):  # |x| <= 4: the terms fall from the fifth on
            k += 1
            term = term * x / k
            sums[k % 2] += -term if k % 4 >= 2 else term
            if term == 0:
                break
        return float(sums[0]), float(sums[1])


_MASS_MAX = 1e6
"""kg, kg m, kg m^2 or m/s^2: keeps every product of the proof far from underflow and overflow."""


@dataclass(frozen=True)
class Masses:
    """Masses and moments of a machine that a limit reads; not negative but for the signed ones."""

    keys: ClassVar[Mapping[str, str]]
    """Attribute -> key with unit, as a certificate has it, in their order."""
    signed: ClassVar[tuple[str, ...]] = ()

    def __post_init__(self) -> None:
        for field in fields(self):
            value, least = getattr(self, field.name), -_MASS_MAX if field.name in self.signed else 0.0
            holds = math.isfinite(value) and least <= value <= _MASS_MAX
            require(field.name, value, holds, f"within {least:g} and 1e6")

    def record(self) -> dict[str, float]:
        """The masses as a certificate has them."""
        return {key: getattr(self, name) for name, key in self.keys.items()}

    @classmethod
    def from_record(cls, table: str, data: object) -> Self:
        """The masses of a certificate.

        Raises:
            GeometryError: Other keys than these, or a number that the proof does not take.
        """
        keys = tuple(cls.keys.values())
        if not isinstance(data, dict) or set(data) != set(keys):
            raise GeometryError(f"{table} must have {', '.join(keys)}")
        return cls(*(number(f"{table}.{key}", data[key]) for key in keys))
