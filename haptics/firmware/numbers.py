"""The numbers of a design as C writes them: records field by field, memories in rows."""

from __future__ import annotations

from typing import Any

from numba.core.types import Float

from haptics.control.supervisor.limits import SafetyLimits
from haptics.firmware.layout import WIDE, is_record, is_table, members, record_name
from haptics.firmware.literals import literal
from haptics.firmware.precision import Precision

STALE = "DELTA_STALE_S"  # Macro of the age at which the host's last command is too old, s


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
        real = isinstance(part, Float)
        if real and precision.single:
            lines.append(f"{inner}.{field}{WIDE} = {own or literal(held)},")
        text = literal(held, precision.real if real else part)
        lines.append(f"{inner}.{field} = {f'(delta_real)({own})' if own else text},")
    return "{ /* " + record_name(kind) + " */\n" + "\n".join(lines) + "\n" + "    " * depth + "}"
