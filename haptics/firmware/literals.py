"""Values in C text: numbers written out to the last bit, and casts between kinds that are told."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from numba.core import types

from haptics.firmware.layout import c_type
from haptics.firmware.precision import REAL, SINGLE

Value = tuple[str, Any]  # C text and the compiler's type


def literal(value: float, kind: Any = REAL) -> str:
    """A number in C that reads back to the last bit; of single precision where that is its kind."""
    if isinstance(value, bool | int):
        return f"{int(value)}LL"
    if math.isnan(value):
        return "NAN"
    if math.isinf(value):
        return "INFINITY" if value > 0 else "(-INFINITY)"
    text = repr(float(str(np.float32(value)))) + "f" if kind == SINGLE else repr(float(value))
    return text if value >= 0.0 else f"({text})"


def cast(value: Value, kind: Any) -> str:
    """A value as C text of another kind: explicitly, so that no compiler warns of what is meant."""
    text, own = value
    if own == kind or not (isinstance(kind, types.Float) or isinstance(own, types.Float)):
        return text
    whole = re.fullmatch(r"(\d+)LL( /\* \w+ \*/)?", text)
    if not isinstance(own, types.Float) and whole:
        return literal(float(whole[1]), kind) + (whole[2] or "")
    return f"(({c_type(kind)})({text}))"


def as_whole(text: str) -> str | None:
    """A literal of a whole number as an integer; None for other text."""
    found = re.fullmatch(r"\(?(-?\d+)(?:LL|\.0f?)?\)?( /\* \w+ \*/)?", text)
    return f"{found[1]}{found[2] or ''}" if found else None
