"""The files of the C controller of one design: header, code, the design's numbers, and how to use them."""

from __future__ import annotations

import math
import re
from functools import cache
from typing import Any

import numpy as np
from numba import float64, int64, typeof

from haptics.control import correction
from haptics.control.controller import (
    CEILING,
    FACTOR,
    FORCE,
    RENDERED,
    TOUCHED,
    VELOCITY,
    WORK,
    Controller,
    fresh,
    tick,
)
from haptics.control.correction import Correction
from haptics.control.pose import HOLDING, POSITION, RATES
from haptics.control.startup import record, steps
from haptics.control.startup.record import ABOUT, Refusal, StartMemory, StartUp, Step
from haptics.control.supervisor.faults import EXTERNAL, TABLE, FaultCode, State, findings
from haptics.control.supervisor.limits import SafetyLimits
from haptics.control.supervisor.memory import reset_memory
from haptics.firmware.layout import prelude
from haptics.firmware.literals import STALE, initialiser, literal
from haptics.firmware.memories import START, SUPERVISOR
from haptics.firmware.precision import DOUBLE, Precision
from haptics.firmware.templates import rendered
from haptics.firmware.translate import Translation
from haptics.rendering.law import GAIN, KIND, Law
from haptics.rendering.registry import COLUMNS, LAWS, layout

# Rows of the last tick's figures, by the names of their constants; FLAGS are the share of the wanted force that the
# joints could give, and whether a wall is touched.
WORK_ROWS = {
    "POSITION": POSITION,
    "RATES": RATES,
    "HOLDING": HOLDING,
    "VELOCITY": VELOCITY,
    "FORCE": FORCE,
    "RENDERED": RENDERED,
    "CEILING": CEILING,
    "FLAGS": FACTOR[0],
    "ROWS": WORK[0],
}
NEVER = (FaultCode.ORDER,)  # What the C controller cannot find: a tick keeps the order of its two halves itself


def sources(
    controller: Controller,
    name: str,
    precision: Precision = DOUBLE,
    start: StartUp | None = None,
    known: Correction | None = None,
) -> dict[str, str]:
    """The files.

    Args:
        controller: The controller of the design.
        name: Name of the design.
        precision: Of its real numbers.
        start: Parameters of the device's start-up; None leaves it out.
        known: Of the made device, from its calibration; None: it is as drawn.

    Returns:
        File name -> text.

    Raises:
        TranslationError: The tick holds something that has no translation.
    """
    memory, limits, real = fresh(controller), controller.limits, precision.real
    laws, vector = np.zeros((1, COLUMNS)), typeof(np.zeros(3))
    ticked = (typeof(controller), typeof(memory), typeof(laws), float64, vector, vector, int64, vector)
    begun = None
    if start:
        begun = StartMemory(np.zeros(record.MEMORY), reset_memory(start.limits), np.zeros(WORK))
        begun = (typeof(start), typeof(begun), float64, vector, int64, vector)
    translation = _translated(ticked, precision, begun, None if known is None else typeof(known))

    def initial(limits: SafetyLimits) -> str:
        return SUPERVISOR.initialiser(reset_memory(limits), literal, precision)

    values = {
        "name": name,
        "real": "float" if precision.single else "double",
        "single": precision.single,
        "period": literal(limits.period),
        "period_ms": limits.period * 1e3,
        "torque": literal(limits.torque, real),
        "torque_N_m": limits.torque,
        "slew": limits.slew * limits.period,
        "repeats": _ticks(limits.repeats),
        "all_repeat": _ticks(limits.all_repeat),
        "unread": _ticks(limits.unread),
        "stale": literal(limits.stale),
        "stale_macro": STALE,
        "stale_finite": math.isfinite(limits.stale),
        "walls": controller.walls,
        "design": initialiser(controller, typeof(controller), 0, precision, STALE),
        "initial": initial(limits),
        "prelude": prelude(precision, "\n".join(translation.functions.values())),
        "structs": translation.structs.values(),
        "functions": translation.functions.values(),
        "supervisor_struct": SUPERVISOR.definition(precision),
        "filter_rows": memory.filters.shape[0],
        "filter_columns": memory.filters.shape[1],
        "rows": WORK_ROWS,
        "touched_row": next(name for name, row in WORK_ROWS.items() if row == TOUCHED[0]),
        "touched_column": TOUCHED[1],
        "columns": COLUMNS,
        "kind": KIND,
        "gain": GAIN,
        "laws": {
            kind: {"name": law.parameters.__name__, "c_name": _c_name(law), "layout": layout(law)}
            for kind, law in LAWS.items()
        },
        "codes": list(FaultCode),
        "states": list(State),
        "faults": TABLE,
        "never": NEVER,
        "external": [f"DELTA_{fault.name}" for fault in findings(EXTERNAL)],
        "external_faults": findings(EXTERNAL),
        "external_mask": EXTERNAL,
        "made": "" if known is None else initialiser(known, typeof(known), 0, precision),
        "made_rows": correction.ROWS,
        "drawn": 3 * correction.DRAWN,
        "absolute": start is not None and start.absolute > 0.0,
        "start": initialiser(start, typeof(start), 0, precision) if start else "",
        "start_initial": initial(start.limits) if start else "",
        "start_struct": START.definition(precision),
        "steps": list(Step),
        "refusals": list(Refusal),
        "about_refusals": ABOUT,
    }
    written = {"delta_controller.h": "controller.h", "delta_controller.c": "controller.c", "README.md": "README.md"}
    return {file: rendered(template, **values) for file, template in written.items()}


@cache
def _translated(
    arguments: tuple[Any, ...],
    precision: Precision,
    start: tuple[Any, ...] | None = None,
    known: Any = None,
) -> Translation:
    """Tick in C for arguments of these types; numbers of a design come later, so that one translation serves all."""
    translation = Translation(precision)
    translation.add(tick, arguments)
    if start:
        translation.add(steps.start, start)
    if known:
        vector, out = typeof(np.zeros(3)), typeof(np.zeros((correction.ROWS, 3)))
        translation.add(correction.correct, (known, vector, out))
        translation.add(correction.turned, (out, vector, float64, vector))
    return translation


def _ticks(limit: float) -> int:
    """A limit in ticks as C has it; 0 for none."""
    return int(limit) if math.isfinite(limit) else 0


def _c_name(law: Law) -> str:
    """Name of a law in C: OperatingResistance is OPERATING_RESISTANCE."""
    return re.sub(r"(?<!^)(?=[A-Z])", "_", law.parameters.__name__).upper()
