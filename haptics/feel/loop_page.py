"""The device in its loop as facts (JSON types) and as a part of the page."""

from __future__ import annotations

import math
from textwrap import wrap
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.feel.loops import DEFAULT_WALL, DEFINITIONS, N_PER_MM, LoopSheet
from haptics.feel.summary import Summary
from haptics.loop.choice import LoopChoice
from haptics.loop.hardware import structure_text
from haptics.loop.noise import FORCE, LEAST_FELT, MOTION, SPRING, BAND_Hz, NoiseFigures, NoiseRange
from haptics.loop.page import FOUR, FOUR_TEXT, loop_facts, walls_facts, walls_text
from haptics.loop.walls import StiffnessLimits
from haptics.model.machine import MachineModel

_REPORTED_Hz = (5.0, 20.0, 60.0, 150.0, 500.0)  # at which impedances are listed
_WIDTH = 110


def sheet_facts(sheet: LoopSheet, machine: MachineModel) -> dict[str, Any]:
    """The facts, with a unit in every key."""
    built, soft = machine.structure, ("softest_structure", "stiffest_structure")
    return loop_facts(sheet.loop) | {
        "walls": [walls_facts(one.loop, one.axes) for one in (sheet.walls, sheet.other)],
        "rates": {f"{rate:g}_Hz": walls_facts(sheet.loop, walls)["axes"] for rate, walls in sheet.rates.items()},
        "default_wall_N_per_mm": DEFAULT_WALL * N_PER_MM,
        "default_wall_stands_with": {
            f"{axis}, {hand}": stands for (axis, hand), stands in sheet.default_wall_stable.items()
        },
        "z_width": {
            "damping_N_s_per_m": list(sheet.dampings),
            "frequency_Hz": sheet.frequency[::10].tolist(),
            "planes": [
                {
                    "place": place,
                    "axis": axis,
                    "position_mm": (MM_PER_M * one.position).tolist(),
                    "stable_N_per_mm": {
                        f"{rate:g}_Hz": {hand: (N_PER_MM * limits).tolist() for hand, limits in hands.items()}
                        for rate, hands in one.stable.items()
                    },
                    "passive_N_per_mm": (N_PER_MM * one.passive).tolist(),
                    "passive_with_other_drives_N_per_mm": (N_PER_MM * one.passive_other).tolist(),
                    "wall_N_per_mm": N_PER_MM * one.wall,
                    "lower_impedance_N_s_per_m": one.lower[::10].tolist(),
                    "upper_impedance_N_s_per_m": one.upper[::10].tolist(),
                }
                for (place, axis), one in sheet.z_width.items()
            ],
        },
        "noise": {
            "reading_rad_rms": sheet.noise_rad,
            "spring": {"stiffness_N_per_m": SPRING[0], "damping_limit_N_s_per_m": sheet.spring_damping}
            | _noise(sheet.spring),
            "wall": _noise(sheet.wall_noise),
            "range": {
                place: {
                    "least": _noise(one.least),
                    "most": _noise(one.most),
                    "reading_that_is_quiet_rad_rms": one.reading,
                    "damping_that_is_quiet": one.loss if one.loss < math.inf else None,
                }
                for place, one in sheet.noise.items()
            },
            "force_allowed_N_rms": FORCE,
            "motion_allowed_um_rms": 1e6 * MOTION,
            "least_felt_um": 1e6 * LEAST_FELT,
            "band_Hz": list(BAND_Hz),
        },
        "first_resonance_Hz": sheet.first_resonance,
        "force_bandwidth_Hz": {
            name: {"within_3_dB": one.within, "less_than_minus_3_dB": one.less}
            for name, one in zip(soft, sheet.force_bandwidth, strict=True)
        },
        "current_loop_Hz": current_loop_Hz(sheet.loop),
        "structure": structure_text(machine),
        "structure_as_built": None
        if built is None
        else {
            "stiffness_centre_N_per_mm": N_PER_MM * built.centre,
            "stiffness_softest_N_per_mm": N_PER_MM * built.softest,
            "first_mode_centre_Hz": built.mode,
            "first_mode_lowest_Hz": built.slowest,
        },
        "definitions": dict(DEFINITIONS),
    }


def _noise(figures: NoiseFigures) -> dict[str, Any]:
    steady = figures.steady
    return {
        "force_N_rms": figures.force if steady else None,
        "motion_um_rms": 1e6 * figures.motion if steady else None,
        "quiet": figures.quiet,
    }


def _walls_lines(sheet: LoopSheet, rendered: dict[str, Summary]) -> list[str]:
    """The walls with both kinds of drives, one after the other, each with its condition, as lines of text.

    Args:
        sheet: The device in its loop.
        rendered: Name of the loop -> what it renders over the cube.
    """
    lines = []
    for one in (sheet.walls, sheet.other):
        over = rendered[one.loop.name]
        lines += [
            *walls_text(one.loop, one.axes),
            f"rendered, worst direction: {N_PER_MM * over.centre:.1f} N/mm at the centre, "
            f"{N_PER_MM * over.worst[0]:.1f} to {N_PER_MM * over.best[0]:.1f} over the cube",
            "",
        ]
    return [*lines, *wrap(FOUR_TEXT + ".", _WIDTH)]


def loop_text(sheet: LoopSheet, rendered: dict[str, Summary], machine: MachineModel) -> list[str]:
    """The loop as plain text, for the terminal."""
    stands = "stands with each hand" if not sheet.unstable_cases else f"OSCILLATES: {sheet.unstable_cases}"
    return [
        *_walls_lines(sheet, rendered),
        "",
        f"{N_PER_MM * DEFAULT_WALL:g} N/mm at the centre, {sheet.loop.name} loop, simulated with noise and all that "
        f"gives way: {stands}",
        *(
            f"noise in the wall that is rendered, {place}: {_ranged(one)}; {_calm(one)}"
            for place, one in sheet.noise.items()
        ),
        f"{structure_text(machine)}; first resonance {sheet.first_resonance:.0f} Hz",
    ]


def loop_markdown(
    sheet: LoopSheet, summaries: dict[str, Summary], rendered: dict[str, Summary], machine: MachineModel
) -> list[str]:
    """The part of the page, lines of Markdown."""
    loop = sheet.loop
    soft, stiff = sheet.force_bandwidth
    quantum = quantum_bound(summaries)
    return [
        "## Walls, with drives that add no damping and with drives that damp",
        "",
        "```text",
        *_walls_lines(sheet, rendered),
        "```",
        "",
        f"Everything below is of the {loop.label}.",
        "",
        "### What a faster loop buys",
        "",
        f"The {loop.name} loop at other rates, at the centre along x and z, own damping / passive / worst hand / "
        "nominal hand, N/mm:",
        "",
        "| rate, kHz | x | z |",
        "|---:|---|---|",
        *(
            f"| {rate / 1e3:g} | {_slashes(walls['x'])} | {_slashes(walls['z'])} |"
            for rate, walls in sheet.rates.items()
        ),
        "",
        "### Z-width",
        "",
        f"Counts limit no wall up to {N_PER_MM * quantum:.0f} N/mm, 2 f_c / quantum: {DEFINITIONS['quantum']}.",
        "",
        "![Z-width](z_width.png)",
        "",
        "![Impedance](impedance.png)",
        "",
        *_impedances(sheet),
        "### Noise and dynamics",
        "",
        f"{structure_text(machine)}.",
        "",
        "| figure | value | meaning |",
        "|---|---:|---|",
        f"| noise in a wall of {N_PER_MM * DEFAULT_WALL:g} N/mm, centre | {_rms_text(sheet.wall_noise)} | "
        f"limits: {FORCE:g} N and {1e6 * MOTION:g} um; sensitive hands feel {1e6 * LEAST_FELT:g} um |",
        *(
            f"| noise in the wall that is rendered, {place} | {_ranged(one)} | {_calm(one)} |"
            for place, one in sheet.noise.items()
        ),
        f"| damping that noise allows | {sheet.spring_damping:.1f} N s/m | in a spring of {SPRING[0]:g} N/m |",
        *(
            f"| {label}, centre; best; worst | {_three(summaries[name])} | {DEFINITIONS[name]} |"
            for name, label in (
                ("dynamic_range", "dynamic range"),
                ("acceleration", "peak acceleration, m/s^2"),
                ("isotropy", "isotropy of mass"),
            )
        ),
        f"| force bandwidth, x, centre | {soft.within:.0f} and {soft.less:.0f} Hz to {stiff.within:.0f} and "
        f"{stiff.less:.0f} Hz, softest to stiffest structure | {DEFINITIONS['force_bandwidth']} |",
        f"| current loop | {current_loop_Hz(loop):.0f} Hz | {DEFINITIONS['current_loop']} |",
        f"| first resonance | {sheet.first_resonance:.0f} Hz | {DEFINITIONS['first_resonance']} |",
        *_structure(machine, rendered[loop.name]),
        "",
        "### Definitions and sources",
        "",
        *(f"- {name.replace('_', ' ')}: {text}." for name, text in DEFINITIONS.items()),
        "",
    ]


def quantum_bound(summaries: dict[str, Summary]) -> float:
    """2 f_c / quantum, N/m, where it is least over the cube."""
    return 2.0 * summaries["friction_min"].best[0] / summaries["position_step"].worst[0]


def current_loop_Hz(loop: LoopChoice) -> float:
    """Gives the corner of a loop's currents, Hz."""
    return 1.0 / (2.0 * math.pi * loop.current_lag)


def _structure(machine: MachineModel, wall: Summary) -> list[str]:
    built = machine.structure
    if built is None:
        return []
    centre, worst = met(wall.centre, built.centre), met(wall.worst[0], built.softest)
    return [
        f"| lowest first mode of the cube | {built.slowest:.0f} Hz | the same at the slowest position |",
        f"| structural stiffness, centre; softest | {N_PER_MM * built.centre:.1f}; {N_PER_MM * built.softest:.1f} "
        f"N/mm | {DEFINITIONS['structural_stiffness']} |",
        f"| the wall that is rendered, as a hand meets it, centre; worst | at least {N_PER_MM * centre:.1f}; "
        f"{N_PER_MM * worst:.1f} N/mm | {DEFINITIONS['met']} |",
    ]


def met(wall: float, structure: float) -> float:
    """Stiffness of a wall behind what gives way, `K S / (K + S)`, in the unit of both."""
    return wall * structure / (wall + structure)


def _ranged(one: NoiseRange) -> str:
    low, high = one.least, one.most
    if not high.steady:
        return "not stable"
    return f"{low.force:.3f} to {high.force:.3f} N, {1e6 * low.motion:.3f} to {1e6 * high.motion:.3f} um rms"


def _calm(one: NoiseRange) -> str:
    """How far the motion is above the threshold of sensitive hands, and what keeps noise within the limits."""
    felt = f"up to {one.most.over_threshold:.1f} times what sensitive hands feel"
    if one.most.quiet:
        return f"{felt}; within limits up to readings of {1e6 * one.reading:.1f} urad rms"
    damped = f" or a structure that damps {100.0 * one.loss:.0f} % of critical" if one.loss < math.inf else ""
    return f"{felt}; OVER the limit: needs readings of {1e6 * one.reading:.1f} urad rms{damped}"


def _three(summary: Summary) -> str:
    digits = summary.quantity.digits
    return "; ".join(f"{value:.{digits}f}" for value in (summary.centre, summary.best[0], summary.worst[0]))


def _impedances(sheet: LoopSheet) -> list[str]:
    """|Z| of each plane at some frequencies, of the free handle and at the wall."""

    def cells(z: np.ndarray) -> str:
        return " | ".join(f"{np.interp(f, sheet.frequency, z):.3g}" for f in _REPORTED_Hz)

    lines = [
        "Range of \\|Z\\|, N s/m:",
        "",
        f"| place, axis | | {' | '.join(f'{f:g} Hz' for f in _REPORTED_Hz)} |",
        f"|---|---|{'---:|' * len(_REPORTED_Hz)}",
    ]
    for (place, axis), one in sheet.z_width.items():
        lines += [
            f"| {place}, {axis} | lower: free handle | {cells(one.lower)} |",
            f"| | upper: wall of {N_PER_MM * one.wall:.1f} N/mm | {cells(one.upper)} |",
        ]
    return [*lines, ""]


def _slashes(walls: StiffnessLimits) -> str:
    return " / ".join(f"{N_PER_MM * getattr(walls, name):.1f}" for name in FOUR)


def _rms_text(figures: NoiseFigures) -> str:
    return f"{figures.force:.3f} N, {1e6 * figures.motion:.3f} um rms" if figures.steady else "not stable"
