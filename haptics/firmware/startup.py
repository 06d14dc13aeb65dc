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
from haptics.firmware.literals import literal
from haptics.firmware.memories import START, SUPERVISOR
from haptics.firmware.numbers import initialiser
from haptics.firmware.precision import Precision

HEADER = """
/* Start-up of a device that lies on its lower stops: stillness, zeros, signs, torque constants, weight, range. Call
 * delta_startup_tick once a period until delta_startup_step is DELTA_STARTUP_READY, in the cube's centre, or
 * DELTA_STARTUP_REFUSED; README.md has the codes. Then start the controller with the angles + the offsets. */
typedef enum {{
{steps}
}} delta_startup_step_code;
typedef enum {{
{refusals}
}} delta_refusal_code;

/* What the start-up remembers. */
{start_struct}

typedef struct {{
    delta_startup_state start;
    delta_supervisor supervisor;
    delta_real work[DELTA_WORK_ROWS][3];
}} delta_startup_memory;

typedef struct {{
    delta_refusal_code code;
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
delta_startup_step_code delta_startup_step(const delta_startup_memory *memory);
delta_refusal delta_startup_refusal(const delta_startup_memory *memory);
/* What has to be added to the readings from then on, rad. */
void delta_startup_offsets(const delta_startup_memory *memory, delta_real offset[3]);
"""

CODE = """\
static const StartUp delta_new_device = {design};

void delta_startup_begin(delta_startup_memory *memory)
{{
    static const delta_startup_memory fresh = {{ .supervisor = {initial} }};
    *memory = fresh;
}}

void delta_startup_signal(delta_startup_memory *memory, long long bits)
{{
    memory->supervisor.signals = bits & {mask}LL;
}}

long long delta_startup_tick(delta_startup_memory *memory, double now, const delta_real theta[3], const int fresh[3],
                             delta_real torque[3])
{{
    StartMemory m = {{ &memory->start, &memory->supervisor, {{ &memory->work[0][0], DELTA_WORK_ROWS, 3, 3 }} }};
    row angles = {{ (delta_real *)theta, 3 }}, out = {{ torque, 3 }};
    return steps_start(&delta_new_device, &m, now, angles, delta_mask(fresh), out);
}}

delta_startup_step_code delta_startup_step(const delta_startup_memory *memory)
{{
    return (delta_startup_step_code)memory->start.step;
}}

delta_refusal delta_startup_refusal(const delta_startup_memory *memory)
{{
    const delta_startup_state *s = &memory->start;
    delta_refusal refusal = {{ (delta_refusal_code)s->code, s->joint, (double)s->value, (double)s->bound }};
    return refusal;
}}

void delta_startup_offsets(const delta_startup_memory *memory, delta_real offset[3])
{{
    for (int k = 0; k < 3; k++) offset[k] = memory->start.offset[k];
}}
"""


def arguments(start: StartUp | None) -> tuple[Any, ...] | None:
    """Types of the start-up's arguments, as the compiler has them; None without one."""
    if start is None:
        return None
    vector = typeof(np.zeros(3))
    return typeof(start), typeof(_memory(start)), float64, vector, int64, vector


def header(precision: Precision) -> str:
    """What the header says of it."""
    return HEADER.format(
        steps=",\n".join(f"    DELTA_STARTUP_{step.name} = {int(step)}" for step in Step),
        refusals=",\n".join(f"    DELTA_REFUSED_{refusal.name} = {int(refusal)}" for refusal in Refusal),
        start_struct=START.definition(precision),
    )


def code(start: StartUp, precision: Precision) -> str:
    """Its functions around the translated ones."""
    return CODE.format(
        design=initialiser(start, typeof(start), 0, precision),
        initial=SUPERVISOR.initialiser(reset_memory(start.limits), literal, precision),
        mask=EXTERNAL,
    )


def table() -> str:
    """Rows of the guide: code, what was found, its unit, what to do."""
    return "\n".join(f"| {int(one)} {one.name} | {text} | {unit} | {do} |" for one, (text, unit, do) in ABOUT.items())


def _memory(start: StartUp) -> StartMemory:
    return StartMemory(np.zeros(r.MEMORY), reset_memory(start.limits), np.zeros(WORK))
