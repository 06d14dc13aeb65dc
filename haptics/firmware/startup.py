"""The start-up in C: its functions for the header and the code, and how refusals are told."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int64, typeof

from haptics.control.controller import WORK
from haptics.control.startup import record as r
from haptics.control.startup.record import ABOUT, Refusal, StartMemory, StartUp, Step
from haptics.control.supervisor.faults import EXTERNAL
from haptics.control.supervisor.memory import reset_memory
from haptics.firmware.literals import initialiser, literal
from haptics.firmware.memories import START, SUPERVISOR
from haptics.firmware.precision import Precision
from haptics.firmware.templates import rendered


def arguments(start: StartUp | None) -> tuple[Any, ...] | None:
    """Types of the start-up's arguments, as the compiler has them; None without one."""
    if start is None:
        return None
    vector = typeof(np.zeros(3))
    return typeof(start), typeof(_memory(start)), float64, vector, int64, vector


def header(precision: Precision) -> str:
    """What the header says of it."""
    return rendered(
        "startup.h",
        steps=",\n".join(f"    DELTA_STARTUP_{step.name} = {int(step)}" for step in Step),
        refusals=",\n".join(f"    DELTA_REFUSED_{refusal.name} = {int(refusal)}" for refusal in Refusal),
        start_struct=START.definition(precision),
    )


def code(start: StartUp, precision: Precision) -> str:
    """Its functions around the translated ones."""
    return rendered(
        "startup.c",
        design=initialiser(start, typeof(start), 0, precision),
        initial=SUPERVISOR.initialiser(reset_memory(start.limits), literal, precision),
        mask=EXTERNAL,
    )


def table() -> str:
    """Rows of the guide: code, what was found, its unit, what to do."""
    return "\n".join(f"| {int(one)} {one.name} | {text} | {unit} | {do} |" for one, (text, unit, do) in ABOUT.items())


def _memory(start: StartUp) -> StartMemory:
    return StartMemory(np.zeros(r.MEMORY), reset_memory(start.limits), np.zeros(WORK))
