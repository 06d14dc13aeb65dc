"""Numbers written with their unit: `"12 cm"` in the place of a number of mm."""

from __future__ import annotations

import math
import re
from decimal import Decimal, localcontext

from delta_cad.common.units import GRAVITY_M_S2

LONGEST = 64  # characters of a number with its unit; more is no quantity
_DIGITS = 60  # carried while a decimal number is scaled, so that its double is the nearest one
DEGREES = 180.0 / math.pi  # of a radian
_NUMBER = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*(.*?)\s*", re.DOTALL)
_COMMA = re.compile(r"\s*([+-]?[0-9]+),([0-9]+)\s*(.*?)\s*", re.DOTALL)

# Unit that a field's name ends with -> the kind of quantity; its units, each with how many of the field's it is.
KINDS: dict[str, tuple[str, dict[str, str]]] = {
    "mm": ("a length", {"mm": "1", "cm": "10", "m": "1000", "um": "0.001", "in": "25.4"}),
    "N": ("a force", {"N": "1", "mN": "0.001", "kN": "1000"}),
    "N m": ("a torque", {"N m": "1", "mN m": "0.001", "N cm": "0.01", "N mm": "0.001"}),
    "N/mm": ("a stiffness", {"N/mm": "1", "N/m": "0.001", "kN/m": "1", "N/um": "1000"}),
    "kg": ("a mass", {"kg": "1", "g": "0.001"}),
    "deg": ("an angle", {"deg": "1", "rad": ""}),
    "m/s^2": ("an acceleration", {"m/s^2": "1", "mm/s^2": "0.001"}),
    "kg m^2": ("an inertia", {"kg m^2": "1", "g m^2": "0.001", "kg mm^2": "0.000001", "g cm^2": "0.0000001"}),
}
# How the parts of a unit may be spelled, as regular expressions.
_SPELLINGS = {" ": "[ ·*]?", "^2": r"(?:\^?2|²)", "deg": "(?:deg|°)", "um": "[uµμ]m"}


def _spelled(name: str) -> str:
    """Writes the regular expression of a unit's spellings."""
    for part, spelling in _SPELLINGS.items():
        name = name.replace(part, spelling)
    return name


class QuantityError(ValueError):
    """A text that is no number of the unit asked for; its message says what to write."""


def quantity(text: str, unit: str) -> float | None:
    """Converts a text with a unit to a number in the field's unit.

    Args:
        text: Such as "12 cm".
        unit: The field's, a key of `KINDS`; "" for a number without one.

    Returns:
        The number, rounded once; None where the text does not begin with a number.

    Raises:
        QuantityError: The text has no unit, one that is not known, one of another kind, or the field has none.
    """
    if len(text) > LONGEST:
        return None
    if (comma := _COMMA.fullmatch(text)) is not None:
        written = f"{comma[1]}.{comma[2]} {comma[3]}".rstrip()
        raise QuantityError(f"has a comma for the decimal point: write {written if not comma[3] else f'{written!r}'}")
    if (found := _QUANTITY.fullmatch(text)) is None:
        return None
    number, written = float(found[1]), found[2]
    if not math.isfinite(number):
        raise QuantityError("must be finite")
    if not written:
        of = f", the number of {unit}" if unit else ""
        raise QuantityError(f"is text: write {number:.15g}{of}, without quotes")
    if not unit:
        raise QuantityError(f"is a number without unit: write {number:.15g}")
    (kind, units), (of, name) = KINDS[unit], _kind_of(written)
    if not name:
        raise QuantityError(f"has no unit that is known here: write the number of {unit}, or with {', '.join(units)}")
    if of != unit:
        weight = f"; {number * GRAVITY_M_S2:.6g} if the weight of that mass is meant"
        also = weight if (unit, name) == ("N", "kg") else ""
        raise QuantityError(f"is {KINDS[of][0]}, not {kind}: write the number of {unit}{also}")
    if not units[name]:
        return number * DEGREES
    with localcontext() as context:
        context.prec = _DIGITS
        return float(Decimal(found[1]) * Decimal(units[name]))


def pattern(unit: str) -> str:
    """Writes the regular expression (ECMA 262) of the texts that `quantity` takes for a unit of `KINDS`."""
    return rf"^\s*{_NUMBER}\s*(?:{'|'.join(map(_spelled, KINDS[unit][1]))})\s*$"


def _kind_of(written: str) -> tuple[str, str]:
    """Finds the key of `KINDS` and the unit that a text spells; empty texts where it spells none."""
    every = ((unit, name) for unit, (_, units) in KINDS.items() for name in units)
    return next(((unit, name) for unit, name in every if re.fullmatch(_spelled(name), written)), ("", ""))
