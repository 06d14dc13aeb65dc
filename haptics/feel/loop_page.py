"""The device in its loop as facts (JSON types) and as a part of the page."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.feel.loops import AXIS, DEFAULT_WALL, DEFINITIONS, N_PER_MM, LoopSheet
from haptics.feel.structure import BuiltStructure
from haptics.feel.summary import Summary
from haptics.simulation.loops import LoopChoice
from haptics.stability.noise import FORCE, MOTION, SPRING, BAND_Hz, NoiseFigures, NoiseRange
from haptics.stability.walls import SHARE, FourWalls

TOLD_Hz = (5.0, 20.0, 60.0, 150.0, 500.0)  # at which impedances are told
WALLS = ("own", "port", "worst", "nominal")


def loop_facts(sheet: LoopSheet, built: BuiltStructure | None) -> dict[str, Any]:
    """The facts, with a unit in every key."""
    loop = sheet.loop
    return {
        "period_ms": 1e3 * loop.period,
        "delay_periods": list(loop.delays),
        "current_lag_ms": 1e3 * loop.current_lag,
        "velocity_filter_Hz": loop.corner,
        "damping_N_s_per_m": loop.damping,
        "drive_damping_share_of_short_circuit": loop.drive_damping,
        "drive_damping_in_contact_share_of_short_circuit": loop.contact_damping,
        "walls_N_per_mm": {axis: _walls(walls) for axis, walls in sheet.walls.items()},
        "rates": {
            f"{rate:g}_Hz": {axis: _walls(walls) for axis, walls in walls.items()}
            for rate, walls in sheet.rates.items()
        },
        "allowed_wall_share": SHARE,
        "default_wall_N_per_mm": DEFAULT_WALL * N_PER_MM,
        "default_wall_stands_with": {f"{axis}, {hand}": stands for (axis, hand), stands in sheet.standing.items()},
        "z_width": {
            "axis": AXIS,
            "damping_N_s_per_m": list(sheet.dampings),
            "stiffness_N_per_mm": {
                f"{rate:g}_Hz": {hand: (N_PER_MM * limits).tolist() for hand, limits in hands.items()}
                for rate, hands in sheet.z_width.items()
            },
            "passive_N_per_mm": (N_PER_MM * sheet.passive).tolist(),
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
            "band_Hz": list(BAND_Hz),
        },
        "first_resonance_Hz": sheet.first_resonance,
        "force_bandwidth_Hz": {
            name: {"within_3_dB": one.within, "less_than_minus_3_dB": one.less}
            for name, one in zip(("softest_structure", "stiffest_structure"), sheet.force_bandwidth, strict=True)
        },
        "current_loop_Hz": current_loop_Hz(loop),
        "structure_as_built": None
        if built is None
        else {
            "stiffness_centre_N_per_mm": N_PER_MM * built.centre,
            "stiffness_softest_N_per_mm": N_PER_MM * built.softest,
            "first_mode_centre_Hz": built.mode,
            "first_mode_lowest_Hz": built.slowest,
        },
        "impedance": {
            "axis": AXIS,
            "frequency_Hz": sheet.frequency[::10].tolist(),
            "places": {
                place: {
                    "position_mm": (MM_PER_M * one.position).tolist(),
                    "wall_N_per_mm": N_PER_MM * one.wall,
                    "free_N_s_per_m": one.free[::10].tolist(),
                    "at_wall_N_s_per_m": one.at_wall[::10].tolist(),
                }
                for place, one in sheet.impedances.items()
            },
        },
        "definitions": dict(DEFINITIONS),
    }


def _walls(walls: FourWalls) -> dict[str, Any]:
    figures = {name: N_PER_MM * getattr(walls, name) for name in WALLS}
    return figures | {
        "worst_hand": walls.worst_hand,
        "formula": N_PER_MM * walls.formula,
        "device_friction_N_s_per_m": walls.friction,
    }


def _noise(figures: NoiseFigures) -> dict[str, Any]:
    steady = figures.steady
    return {
        "force_N_rms": figures.force if steady else None,
        "motion_um_rms": 1e6 * figures.motion if steady else None,
        "quiet": figures.quiet,
    }


def loop_markdown(sheet: LoopSheet, summaries: dict[str, Summary], built: BuiltStructure | None) -> list[str]:
    """The part of the page, lines of Markdown."""
    loop = sheet.loop
    soft, stiff = sheet.force_bandwidth
    return [
        f"## Walls in the loop on the board, {1e-3 / loop.period:g} kHz",
        "",
        f"A wall has {loop.damping:g} N s/m of its own, the drives damp by {100.0 * loop.drive_damping:g} % of their "
        f"motors' short circuit, by {100.0 * loop.contact_damping:g} % while a wall is touched, currents follow within "
        f"{1e3 * loop.current_lag:g} ms, a torque comes {loop.delays[1]:g} period ({loop.delays[0]:g} to "
        f"{loop.delays[2]:g}) after its reading. One formula is behind them, `b + B >= K (T / 2 + delay + lag)`; what "
        "a hand adds or takes is in its columns. N/mm at the centre:",
        "",
        "| axis | b, N s/m | own damping | averaged port | worst hand | nominal hand | formula |",
        "|---|---:|---:|---:|---:|---:|---:|",
        *(
            f"| {axis} | {w.friction:.2f} | {_four(w)} | {N_PER_MM * w.formula:.1f} |"
            for axis, w in sheet.walls.items()
        ),
        "",
        f"What the tick renders is at most {SHARE:g} of the formula at its pose, with the least friction and the "
        f"largest delay: {_range(summaries['wall'])} over the cube, across the direction in which that is least.",
        "",
        "### What a faster loop buys",
        "",
        "The same loop at other rates, along x and z, own damping / averaged port / worst hand / nominal hand, N/mm:",
        "",
        "| rate, kHz | x | z |",
        "|---:|---|---|",
        *(
            f"| {rate / 1e3:g} | {_slashes(walls['x'])} | {_slashes(walls['z'])} |"
            for rate, walls in sheet.rates.items()
        ),
        "",
        "![Z-width](z_width.png)",
        "",
        "![Impedance](impedance.png)",
        "",
        *_impedances(sheet),
        "### Noise and dynamics",
        "",
        "| figure | value | meaning |",
        "|---|---:|---|",
        f"| noise in a wall of {N_PER_MM * DEFAULT_WALL:g} N/mm, centre | {_told(sheet.wall_noise)} | with the "
        f"structure as soft as asked; at most {FORCE:g} N and {1e6 * MOTION:g} um are taken for unnoticed |",
        *(
            f"| noise in the wall that is rendered, {place} | {_ranged(one)} | over structures and damping; "
            f"{_calm(one)} |"
            for place, one in sheet.noise.items()
        ),
        f"| damping that noise allows | {sheet.spring_damping:.1f} N s/m | beside a spring of {SPRING[0]:g} N/m |",
        *(
            f"| {label}, centre; best; worst | {_three(summaries[name])} | {DEFINITIONS[name]} |"
            for name, label in (
                ("dynamic_range", "dynamic range"),
                ("acceleration", "peak acceleration, m/s^2"),
                ("isotropy", "isotropy of mass"),
            )
        ),
        f"| force bandwidth, {AXIS}, centre | {soft.within:.0f} and {soft.less:.0f} Hz to {stiff.within:.0f} and "
        f"{stiff.less:.0f} Hz, structure as asked to ten times that | {DEFINITIONS['force_bandwidth']} |",
        f"| current loop | {current_loop_Hz(loop):.0f} Hz | {DEFINITIONS['current_loop']} |",
        f"| first resonance | {sheet.first_resonance:.0f} Hz | {DEFINITIONS['first_resonance']} |",
        *_structure(built, summaries["wall"]),
        "",
        "### Definitions and sources",
        "",
        *(f"- {name.replace('_', ' ')}: {text}." for name, text in DEFINITIONS.items()),
        "",
    ]


def current_loop_Hz(loop: LoopChoice) -> float:
    """Gives the corner of a loop's currents, Hz."""
    return 1.0 / (2.0 * math.pi * loop.current_lag)


def _structure(built: BuiltStructure | None, wall: Summary) -> list[str]:
    if built is None:
        return [f"| structural stiffness | not at hand | {DEFINITIONS['structural_stiffness']} |"]
    centre, worst = met(wall.centre, built.centre), met(wall.worst[0], built.softest)
    return [
        f"| structural stiffness, centre; softest | {N_PER_MM * built.centre:.1f}; {N_PER_MM * built.softest:.1f} "
        f"N/mm | {DEFINITIONS['structural_stiffness']} |",
        f"| the wall that is rendered, as a hand meets it, centre; worst | at least {N_PER_MM * centre:.1f}; "
        f"{N_PER_MM * worst:.1f} N/mm | {DEFINITIONS['met']} |",
        f"| first mode of that, centre; lowest of the cube | {built.mode:.0f}; {built.slowest:.0f} Hz | motors held, "
        "cable included, nobody at the knob |",
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
    """What would make the noise unnoticed."""
    if one.most.quiet:
        return f"unnoticed up to readings of {1e6 * one.reading:.1f} urad rms"
    damped = f", or a structure that damps {100.0 * one.loss:.0f} % of critical" if one.loss < math.inf else ""
    return f"NOT unnoticed: with this law that takes readings of {1e6 * one.reading:.1f} urad rms{damped}"


def _three(summary: Summary) -> str:
    digits = summary.quantity.digits
    return "; ".join(f"{value:.{digits}f}" for value in (summary.centre, summary.best[0], summary.worst[0]))


def _impedances(sheet: LoopSheet) -> list[str]:
    """|Z| of each place at some frequencies, let go and at the wall."""
    heads = " | ".join(f"{f:g} Hz" for f in TOLD_Hz)

    def cells(z: np.ndarray) -> str:
        return " | ".join(f"{np.interp(f, sheet.frequency, z):.3g}" for f in TOLD_Hz)

    lines = [
        f"|Z| along {AXIS}, N s/m:".replace("|", "\\|"),
        "",
        f"| place | x, y, z, mm | | {heads} |",
        f"|---|---|---|{'---:|' * len(TOLD_Hz)}",
    ]
    for place, one in sheet.impedances.items():
        at = ", ".join(f"{MM_PER_M * x + 0.0:.1f}" for x in one.position)
        lines += [
            f"| {place} | {at} | let go | {cells(one.free)} |",
            f"| | | wall of {N_PER_MM * one.wall:.1f} N/mm | {cells(one.at_wall)} |",
        ]
    return [*lines, ""]


def loop_text(sheet: LoopSheet) -> list[str]:
    """The same as a few lines of plain text."""
    head = f"{'axis':<6}{'own damping':>12}{'averaged port':>15}{'worst hand':>12}{'nominal hand':>14}{'formula':>9}"
    rows = [
        f"{axis:<6}{N_PER_MM * w.own:12.2f}{N_PER_MM * w.port:15.2f}{N_PER_MM * w.worst:12.2f}"
        f"{N_PER_MM * w.nominal:14.2f}{N_PER_MM * w.formula:9.2f}"
        for axis, w in sheet.walls.items()
    ]
    stands = "stands with each hand" if not sheet.shaken else f"OSCILLATES: {sheet.shaken}"
    return [
        f"Walls in the loop on the board, {1e-3 / sheet.loop.period:g} kHz, {sheet.loop.damping:g} N s/m, at the "
        "centre, N/mm:",
        head,
        *rows,
        f"{N_PER_MM * DEFAULT_WALL:g} N/mm, simulated with noise and all that gives way: {stands}; noise commands "
        f"{_told(sheet.wall_noise)}",
    ]


def _four(walls: FourWalls) -> str:
    return " | ".join(f"{N_PER_MM * getattr(walls, name):.1f}" for name in WALLS)


def _slashes(walls: FourWalls) -> str:
    return " / ".join(f"{N_PER_MM * getattr(walls, name):.1f}" for name in WALLS)


def _range(summary: Summary) -> str:
    return f"{N_PER_MM * summary.worst[0]:.1f} to {N_PER_MM * summary.best[0]:.1f} N/mm"


def _told(figures: NoiseFigures) -> str:
    return f"{figures.force:.3f} N, {1e6 * figures.motion:.3f} um rms" if figures.steady else "not stable"
