"""The start-up in C: its functions for the header and the code, and how refusals are told."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, int64, typeof

from haptics.control.controller import WORK
from haptics.control.startup import record as r
from haptics.control.startup.record import ABOUT, StartMemory, StartUp, Step
from haptics.control.supervisor.faults import EXTERNAL
from haptics.control.supervisor.memory import SIGNALS, reset_memory
from haptics.firmware.numbers import exact_initial, exact_place, initialiser, numbers
from haptics.firmware.precision import Precision

HEADER = """
/* Start-up of a device that lies on its lower stops: stillness, zeros, signs, torque constants, weight, range. Call
 * delta_startup_tick once a period until delta_startup_step is DELTA_STARTUP_READY, in the cube's centre, or
 * DELTA_STARTUP_REFUSED; README.md has the codes. Then start the controller with the angles + the offsets. */
{macros}

typedef struct {{
    delta_real start[{start}];
    delta_real supervisor[{supervisor}];
    delta_real work[{work}];
{exact_field}}} delta_startup_memory;

typedef struct {{
    int code;         /* 0 for none */
    int joint;        /* 0 to 2; 3 for the whole device */
    double value;     /* what was found */
    double bound;     /* what is allowed */
}} delta_refusal;

void delta_startup_begin(delta_startup_memory *memory);
/* As delta_signal. */
void delta_startup_signal(delta_startup_memory *memory, long long bits);
/* One period: raw angles, their time, `fresh` as of delta_tick; torques out; bits of what the supervisor found. */
long long delta_startup_tick(delta_startup_memory *memory, double now, const delta_real theta[3], const int fresh[3],
                             delta_real torque[3]);
int delta_startup_step(const delta_startup_memory *memory);
delta_refusal delta_startup_refusal(const delta_startup_memory *memory);
/* What has to be added to the readings from then on, rad. */
void delta_startup_offsets(const delta_startup_memory *memory, delta_real offset[3]);
"""

CODE = """\
static const StartUp delta_new_device = {design};

void delta_startup_begin(delta_startup_memory *memory)
{{
    static const delta_real supervisor[{supervisor}] = {{
        {initial}
    }};
{exact_initial}    for (int k = 0; k < {start}; k++) memory->start[k] = 0;
    for (int k = 0; k < {work}; k++) memory->work[k] = 0;
    for (int k = 0; k < {supervisor}; k++) memory->supervisor[k] = supervisor[k];
}}

void delta_startup_signal(delta_startup_memory *memory, long long bits)
{{
    {signal} = (double)(bits & {mask}LL);
}}

long long delta_startup_tick(delta_startup_memory *memory, double now, const delta_real theta[3], const int fresh[3],
                             delta_real torque[3])
{{
    StartMemory m = {{
        {{ memory->start, {start}{none} }},
        {{ memory->supervisor, {supervisor}{memory_exact} }},
        {{ memory->work, {work_rows}, {work_columns}, {work_columns} }},
    }};
    row angles = {{ (delta_real *)theta, 3{none} }}, out = {{ torque, 3{none} }};
    return steps_start(&delta_new_device, &m, now, angles, delta_mask(fresh), out);
}}

int delta_startup_step(const delta_startup_memory *memory) {{ return (int)memory->start[{step}]; }}

delta_refusal delta_startup_refusal(const delta_startup_memory *memory)
{{
    const delta_real *s = memory->start;
    delta_refusal refusal = {{ (int)s[{code}], (int)s[{joint}], (double)s[{value}], (double)s[{bound}] }};
    return refusal;
}}

void delta_startup_offsets(const delta_startup_memory *memory, delta_real offset[3])
{{
    for (int k = 0; k < 3; k++) offset[k] = memory->start[{offset} + k];
}}
"""


def arguments(start: StartUp | None) -> tuple[Any, ...] | None:
    """Types of the start-up's arguments, as the compiler has them; None without one."""
    if start is None:
        return None
    vector = typeof(np.zeros(3))
    return typeof(start), typeof(_memory(start)), float64, vector, int64, vector


def header(start: StartUp, precision: Precision) -> str:
    """What the header says of it."""
    macros = [f"#define DELTA_STARTUP_{step.name} {int(step)}" for step in Step]
    macros += [f"#define DELTA_REFUSED_{refusal.name} {int(refusal)}" for refusal in ABOUT]
    return HEADER.format(macros="\n".join(macros), **_shapes(start, precision))


def code(start: StartUp, precision: Precision) -> str:
    """Its functions around the translated ones."""
    memory = _memory(start)
    return CODE.format(
        design=initialiser(start, typeof(start), 0, precision),
        initial=numbers(memory.supervisor, precision.real),
        signal=exact_place(precision, "SIGNALS", SIGNALS),
        mask=EXTERNAL,
        step=r.STEP,
        code=r.CODE,
        joint=r.JOINT,
        value=r.VALUE,
        bound=r.BOUND,
        offset=r.OFFSET,
        **_shapes(start, precision),
    )


def table() -> str:
    """Rows of the guide: code, what was found, its unit, what to do."""
    return "\n".join(f"| {int(one)} {one.name} | {text} | {unit} | {do} |" for one, (text, unit, do) in ABOUT.items())


def _memory(start: StartUp) -> StartMemory:
    return StartMemory(np.zeros(r.MEMORY), reset_memory(start.limits), np.zeros(WORK))


def _shapes(start: StartUp, precision: Precision) -> dict[str, Any]:
    memory, single = _memory(start), precision.single
    placed = precision.placed(memory.supervisor)
    return {
        "start": memory.start.size,
        "supervisor": memory.supervisor.size,
        "work": memory.work.size,
        "work_rows": WORK[0],
        "work_columns": WORK[1],
        "exact_field": f"    double exact[{len(placed)}];\n" if single else "",
        "memory_exact": ", memory->exact" if single else "",
        "none": ", NULL" if single else "",
        "exact_initial": exact_initial(placed) if single else "",
    }
