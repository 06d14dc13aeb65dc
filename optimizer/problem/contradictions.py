"""Numbers of requirements that contradict each other whatever the design, in either edition of the file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from delta_cad.common.refusal import short
from delta_cad.mechanism.errors import GeometryError
from delta_cad.mechanism.limits import LIMITS
from optimizer.problem.validation import Fault

_Known = Mapping[str, Any]
"""Dotted field, such as "requirements.force_N" -> value, of the fields that have one and are not refused."""
SHOULDER = ("shoulder_min_deg", "shoulder_max_deg")  # in a file of requirements the two numbers of `shoulder_deg`


def swapped(known: _Known) -> Iterator[Fault]:
    """Finds lower bounds above their upper bounds, and a half side fixed at zero."""
    for field, value in known.items():
        if field.startswith(("bounds_mm.", "bounds_deg.")) or field == "limits.shoulder_deg":
            low, high = value
            if low > high:
                yield field, short([low, high]), "bounds are swapped: must be [lower, upper]"
            elif field == "bounds_mm.half_side" and high == 0.0:
                yield field, short([low, high]), "upper bound must be > 0 mm"
    low, shift = known.get("bounds_mm.base_radius", (None,))[0], known.get("bounds_mm.side_shift", (0.0,))[0]
    if low is not None and low + shift <= 0.0:
        allowed = f"must be > {-low:g} mm, for chains 1 and 2 stand at base_radius + side_shift from the axis"
        yield "bounds_mm.side_shift", short(list(known["bounds_mm.side_shift"])), allowed


def peaks(known: _Known) -> Iterator[Fault]:
    """Finds peak requirements that are smaller than the continuous ones."""
    for lasting, brief, unit in (("force_N", "peak_force_N", "N"), ("joint_torque_N_m", "peak_torque_N_m", "N m")):
        least, peak = known.get(f"requirements.{lasting}"), known.get(f"requirements.{brief}")
        if least is not None and peak is not None and peak < least:
            allowed = f"must be >= requirements.{lasting} = {least:g} {unit}, the continuous one"
            yield f"requirements.{brief}", short(peak), allowed


def beyond_proof(known: _Known, more: Mapping[str, Any]) -> Iterator[Fault]:
    """Finds limits outside the range that proofs accept, such as a torque below its minimum.

    Args:
        known: The file's fields.
        more: What limits are made from beside them: `inertia`, where it is known.

    Yields:
        Name of the limit, no value, and the range that its proof accepts.
    """
    values = {**limit_values(known), **more}
    if values.get(SHOULDER[0], 0.0) > values.get(SHOULDER[1], 180.0):  # told by `swapped`
        values = {name: value for name, value in values.items() if name not in SHOULDER}
    for limit in LIMITS:
        try:
            limit.stated(values)
        except KeyError:  # it is made from a field that is not known
            continue
        except GeometryError as error:
            needs = getattr(limit, "needs", "")
            if not needs or values.get(needs) is not None:
                yield limit.name, "", str(error)


def limit_values(known: _Known) -> dict[str, Any]:
    """Gives the values that limits are built from: fields by name without their table, `shoulder_deg` as two."""
    tables = ("requirements.", "limits.", "feel.")
    values = {field.split(".")[1]: value for field, value in known.items() if field.startswith(tables)}
    return values | dict(zip(SHOULDER, values.pop("shoulder_deg", ()), strict=False))
