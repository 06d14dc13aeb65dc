"""The C controller's tick: on this machine timed one by one, compiled as its README says; on bare cores counted."""

from __future__ import annotations

import math
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from delta_cad.design import load_design
from delta_cad.mechanism import inverse_kinematics
from haptics.model.machine import MachineModel
from tests.benchmarks.figure import Figure, of_repeats
from tests.committed import BEST

SUBJECT = "controller in C"
TICKS, ROUNDS = 50_000, 7
COUNTED = 6000  # Ticks on a bare core
HARNESS = """\
#define _POSIX_C_SOURCE 199309L
#include "delta_controller.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
static delta_real theta[%(n)d][3] = {
%(angles)s
};
static const delta_real laws[][DELTA_LAW_COLUMNS] = {
%(laws)s
};
static int order(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}
static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}
int main(void)
{
    static delta_memory memory;
    static double took[%(ticks)d];
    delta_real torque[3];
    const int fresh[3] = { 1, 1, 1 };
    double sum = 0.0, empty = 1.0;
    long long bits = 0;
    delta_start(&memory);
    delta_enable(&memory);
    for (long k = 0; k < 1000; k++) {
        double a = seconds(), b = seconds();
        if (b - a < empty) empty = b - a;
    }
    for (long k = 0; k < %(ticks)d; k++) {
        double begun = seconds();
        bits |= delta_tick(&memory, laws[0], %(rows)d, k * DELTA_PERIOD_S, theta[k %% %(n)d],
                           theta[k %% %(n)d], fresh, torque);
        took[k] = seconds() - begun - empty;
        sum += (double)torque[0];
    }
    qsort(took, %(ticks)d, sizeof took[0], order);
    printf("%%.17g %%.17g %%.17g %%lld\\n", took[%(ticks)d / 2], took[%(ticks)d / 100 * 99], sum, bits);
    return 0;
}
"""


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.

    Raises:
        RuntimeError: There is no C compiler.
    """
    from haptics.control.supervisor.faults import LATCHING
    from haptics.firmware.generate import sources
    from haptics.firmware.precision import DOUBLE, MIXED
    from haptics.loop.assumptions import default_controller
    from haptics.rendering import law_table
    from haptics.rendering.laws.operating_resistance import OperatingResistance
    from haptics.rendering.laws.virtual_wall import axis_wall
    from tests.haptics.scene_machine import scene_machine

    compiler = shutil.which("cc")
    if compiler is None:
        raise RuntimeError("no C compiler (cc) on this machine")
    design = load_design(BEST)
    machine = scene_machine(design)
    controller = default_controller(machine)
    half = design.cube.half_side_mm / 1000.0
    middle = np.array([0.0, 0.0, design.cube.bottom_height_mm / 1000.0 + half])
    turn = np.linspace(0.0, 2.0 * math.pi, 4000, endpoint=False)
    way = 0.6 * half * np.stack([np.cos(turn), np.sin(turn), np.sin(2.0 * turn)], axis=-1)
    angles = inverse_kinematics(design.geometry, middle + way)
    laws = law_table(
        OperatingResistance(stiffness=400.0, damping=10.0, dead_radius=1.5e-3, full_radius=10e-3, origin=middle),
        *(axis_wall(f"+{axis}", middle[k] + 0.3 * half, stiffness=2000.0, damping=5.0) for k, axis in enumerate("xyz")),
    )
    values = {"n": len(angles), "ticks": TICKS, "rows": len(laws), "angles": _rows(angles), "laws": _rows(laws)}
    note = "cc -O2 -ffp-contract=off; each tick timed by itself, the clock's own time taken off"
    found = []
    for precision, name, targets in ((DOUBLE, "a tick", (0.5, 1.0)), (MIXED, "a tick in single precision", (0.5, 1.0))):
        say(f"{ROUNDS} rounds of {TICKS:,} ticks, resistance and three walls: {name}")
        rows = _timed(compiler, sources(controller, design.name, precision), HARNESS % values)
        if any(int(row[3]) & LATCHING for row in rows):
            raise RuntimeError("the supervisor stopped the controller; nothing was rendered")
        for k, what in enumerate(("median", "99 of 100 are below")):
            figures = [row[k] * 1e6 for row in rows]
            found.append(of_repeats(SUBJECT, f"{name}, {what}", figures, "us", targets[k], note=note))
    return found + _counted(machine, say)


def _timed(compiler: str, files: dict[str, str], harness: str) -> list[list[float]]:
    """Median, 99th percentile, a sum and the bits of each round."""
    with tempfile.TemporaryDirectory() as folder:
        for name, text in {**files, "bench.c": harness}.items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        flags = ["-std=c99", "-O2", "-ffp-contract=off", "delta_controller.c", "bench.c", "-o", "bench", "-lm"]
        subprocess.run([compiler, *flags], cwd=folder, check=True)
        reported = [
            subprocess.run(["./bench"], cwd=folder, check=True, capture_output=True, text=True) for _ in range(ROUNDS)
        ]
    return [[float(word) for word in run.stdout.split()] for run in reported]


def _counted(machine: MachineModel, say: Callable[[str], None]) -> list[Figure]:
    """Instructions a tick on bare cores under QEMU, and the load that an assumed number of cycles would mean."""
    from haptics.control.correction import correction
    from haptics.firmware.precision import DOUBLE, MIXED
    from haptics.loop.choice import at_rate
    from haptics.loop.hardware import board_controller
    from tests.haptics.calibration.devices import made
    from tests.haptics.firmware.rig import COUNTS, EMPTY, TWINS, compile_bare, recording, replay, write

    found = []
    measured = correction(machine.geometry, made(machine.design, np.random.default_rng(4), machine.drive.ratio))
    for core, precision, known, rate, clock, cycles, target in (
        ("m7", DOUBLE, None, 8000.0, 600e6, 2.0, 20.0),
        ("m7", DOUBLE, measured, 8000.0, 600e6, 2.0, 20.0),
        ("m4", MIXED, None, 4000.0, 168e6, 1.5, 80.0),
    ):
        name = f"Cortex-{core.upper()}, {'single' if precision.single else 'double'}"
        name += "" if known is None else ", calibrated"
        say(f"{name}: {COUNTED:,} ticks under QEMU")
        recorded = recording(machine, COUNTED, 7, 1.0 / rate)._replace(laws=TWINS)
        took = []
        for limits in ({}, EMPTY):
            controller = board_controller(machine, at_rate(rate), stale=0.1, **limits)
            with tempfile.TemporaryDirectory() as folder:
                image = compile_bare(write(controller, precision, Path(folder), known), core)
                took.append(replay(image, recorded, "f4" if precision.single else "f8")[0]["took"] / COUNTS)
        note = f"counted by QEMU, {len(TWINS)} laws, faults; no cycles, caches or wait states"
        figures = ("median", float(np.median(took[0]))), ("most, of an empty energy tank", float(took[1].max()))
        found += [
            Figure(SUBJECT, f"{name}: instructions a tick, {what}", value, "", note=note) for what, value in figures
        ]
        load = 100.0 * figures[1][1] * cycles / clock * rate
        note = f"if an instruction takes {cycles:g} cycles at {clock / 1e6:g} MHz, which no chip has confirmed"
        found.append(Figure(SUBJECT, f"{name}: load at {rate / 1e3:g} kHz", load, "%", target, note=note))
    return found


def _rows(array: np.ndarray) -> str:
    return ",\n".join("{" + ", ".join(repr(float(value)) for value in row) + "}" for row in array)
