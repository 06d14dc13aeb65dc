"""Values in C text: numbers to the last bit, casts between kinds, and the records of a design field by field."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
from numba.core import types

from haptics.control.supervisor.limits import SafetyLimits
from haptics.firmware.layout import WIDE, c_type, is_record, is_table, members, record_name
from haptics.firmware.precision import REAL, SINGLE, Precision

Value = tuple[str, Any]  # C text and the compiler's type
STALE = "DELTA_STALE_S"  # Macro of the age at which the host's last command is too old, s


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


def numbers(values: Any, kind: Any) -> str:
    """Numbers of an initialiser, six a line."""
    rows = [values[k : k + 6] for k in range(0, len(values), 6)]
    return ",\n        ".join(", ".join(literal(float(value), kind) for value in row) for row in rows)


def initialiser(value: Any, kind: Any, depth: int, precision: Precision, stale: str | None = None) -> str:
    """A record as C writes it, field by field; `stale` is what stands for the limit of that name."""
    inner = "    " * (depth + 1)
    lines = []
    for field, part in members(kind):
        held = getattr(value, field)
        if is_record(part):
            lines.append(f"{inner}.{field} = {initialiser(held, part, depth + 1, precision, stale)},")
            continue
        if is_table(part):
            size, width = held.size, held.shape[1]
            values = f"(delta_real[{size}]){{ {numbers(held.ravel(), precision.real)} }}"
            lines.append(f"{inner}.{field} = {{ {values}, {len(held)}, {width}, {width} }},")
            continue
        own = stale if isinstance(value, SafetyLimits) and field == "stale" else None
        real = isinstance(part, types.Float)
        if real and precision.single:
            lines.append(f"{inner}.{field}{WIDE} = {own or literal(held)},")
        text = literal(held, precision.real if real else part)
        lines.append(f"{inner}.{field} = {f'(delta_real)({own})' if own else text},")
    return "{ /* " + record_name(kind) + " */\n" + "\n".join(lines) + "\n" + "    " * depth + "}"
