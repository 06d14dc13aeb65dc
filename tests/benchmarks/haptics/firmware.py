"""The C controller's tick on this machine: compiled as its README says, every tick timed on its own."""

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
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT

SUBJECT = "controller in C"
TICKS, ROUNDS = 50_000, 7
HARNESS = """\
#define _POSIX_C_SOURCE 199309L
#include "delta_controller.h"
#include <stdio.h>
#include <stdlib.h>
#include <time.h>
static double theta[%(n)d][3] = {
%(angles)s
};
static const double laws[][DELTA_LAW_COLUMNS] = {
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
    double torque[3], sum = 0.0, empty = 1.0;
    long long bits = 0;
    delta_start(&memory);
    delta_enable(&memory);
    for (long k = 0; k < 1000; k++) {
        double a = seconds(), b = seconds();
        if (b - a < empty) empty = b - a;
    }
    for (long k = 0; k < %(ticks)d; k++) {
        double begun = seconds();
        bits |= delta_tick(&memory, laws[0], %(rows)d, k * DELTA_PERIOD_S, theta[k %% %(n)d], torque);
        took[k] = seconds() - begun - empty;
        sum += torque[0];
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
    from haptics.rendering import law_table
    from haptics.rendering.laws.operating_resistance import OperatingResistance
    from haptics.rendering.laws.virtual_wall import axis_wall
    from haptics.simulation.assumptions import default_controller
    from tests.haptics.scene_machine import scene_machine

    compiler = shutil.which("cc")
    if compiler is None:
        raise RuntimeError("no C compiler (cc) on this machine")
    design = load_design(ROOT / "best.json")
    controller = default_controller(scene_machine(design))
    half = design.cube.half_side_mm / 1000.0
    middle = np.array([0.0, 0.0, design.cube.bottom_height_mm / 1000.0 + half])
    turn = np.linspace(0.0, 2.0 * math.pi, 4000, endpoint=False)
    way = 0.6 * half * np.stack([np.cos(turn), np.sin(turn), np.sin(2.0 * turn)], axis=-1)
    angles = inverse_kinematics(design.geometry, middle + way)
    laws = law_table(
        OperatingResistance(stiffness=400.0, damping=10.0, dead_radius=1.5e-3, full_radius=10e-3, origin=middle),
        *(axis_wall(f"+{axis}", middle[k] + 0.3 * half, stiffness=2000.0, damping=5.0) for k, axis in enumerate("xyz")),
    )
    say(f"{ROUNDS} rounds of {TICKS:,} ticks, resistance and three walls")
    with tempfile.TemporaryDirectory() as folder:
        for name, text in sources(controller, design.name).items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        harness = HARNESS % {
            "n": len(angles),
            "ticks": TICKS,
            "rows": len(laws),
            "angles": _rows(angles),
            "laws": _rows(laws),
        }
        (Path(folder) / "bench.c").write_text(harness, encoding="utf-8")
        command = [
            compiler,
            "-std=c99",
            "-O2",
            "-ffp-contract=off",
            "delta_controller.c",
            "bench.c",
            "-o",
            "bench",
            "-lm",
        ]
        subprocess.run(command, cwd=folder, check=True)
        told = [
            subprocess.run(["./bench"], cwd=folder, check=True, capture_output=True, text=True) for _ in range(ROUNDS)
        ]
    rows = [[float(word) for word in run.stdout.split()] for run in told]
    if any(int(row[3]) & LATCHING for row in rows):
        raise RuntimeError("the supervisor stopped the controller; nothing was rendered")
    note = "cc -O2 -ffp-contract=off; each tick timed by itself, the clock's own time taken off"
    return [
        of_repeats(SUBJECT, "a tick, median", [row[0] * 1e6 for row in rows], "us", 0.5, note=note),
        of_repeats(SUBJECT, "a tick, 99 of 100 are below", [row[1] * 1e6 for row in rows], "us", 1.0, note=note),
    ]


def _rows(array: np.ndarray) -> str:
    return ",\n".join("{" + ", ".join(repr(float(value)) for value in row) + "}" for row in array)
