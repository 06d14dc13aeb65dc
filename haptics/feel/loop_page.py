"""The device in its loop as facts (JSON types) and as a part of the page."""

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.feel.loops import AXIS, DEFAULT_WALL, DEFINITIONS, N_PER_MM, LoopSheet
from haptics.feel.summary import Summary
from haptics.stability.noise import FORCE, MOTION, SPRING, BAND_Hz, NoiseFigures
from haptics.stability.walls import SHARE, FourWalls

TOLD_Hz = (5.0, 20.0, 60.0, 150.0, 500.0)  # at which impedances are told
WALLS = ("own", "port", "worst", "nominal")


def dynamics(summaries: dict[str, Summary]) -> dict[str, float]:
    """Dynamic range and peak acceleration (m/s^2) from the worst of the cube, isotropy of mass at its centre."""
    worst = {name: summaries[name].worst[0] for name in ("force_continuous", "friction_max", "force_peak", "mass_max")}
    return {
        "dynamic_range": worst["force_continuous"] / worst["friction_max"],
        "peak_acceleration": worst["force_peak"] / worst["mass_max"],
        "isotropy": summaries["mass_min"].centre / summaries["mass_max"].centre,
    }


def loop_facts(sheet: LoopSheet, summaries: dict[str, Summary]) -> dict[str, Any]:
    """The facts, with a unit in every key."""
    loop, moves = sheet.loop, dynamics(summaries)
    return {
        "period_ms": 1e3 * loop.period,
        "delay_periods": list(loop.delays),
        "current_lag_ms": 1e3 * loop.current_lag,
        "velocity_filter_Hz": loop.corner,
        "damping_N_s_per_m": loop.damping,
        "drive_damping_share_of_short_circuit": loop.drive_damping,
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
            "force_allowed_N_rms": FORCE,
            "motion_allowed_um_rms": 1e6 * MOTION,
            "band_Hz": list(BAND_Hz),
        },
        "dynamic_range": moves["dynamic_range"],
        "peak_acceleration_m_per_s2": moves["peak_acceleration"],
        "isotropy_of_mass": moves["isotropy"],
        "first_resonance_Hz": sheet.first_resonance,
        "force_bandwidth_Hz": sheet.force_bandwidth,
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


def loop_markdown(sheet: LoopSheet, summaries: dict[str, Summary]) -> list[str]:
    """The part of the page, lines of Markdown."""
    loop, moves = sheet.loop, dynamics(summaries)
    return [
        f"## Walls in the loop on the board, {1e-3 / loop.period:g} kHz",
        "",
        f"A wall has {loop.damping:g} N s/m of its own, the drives damp by {100.0 * loop.drive_damping:g} % of their "
        f"motors' short circuit, currents follow within {1e3 * loop.current_lag:g} ms, a torque comes "
        f"{loop.delays[1]:g} period ({loop.delays[0]:g} to {loop.delays[2]:g}) after its reading. One formula is "
        "behind them, `b + B >= K (T / 2 + delay + lag)`; a hand only helps. N/mm at the centre:",
        "",
        "| axis | b, N s/m | own damping | averaged port | worst hand | nominal hand | formula |",
        "|---|---:|---:|---:|---:|---:|---:|",
        *(
            f"| {axis} | {w.friction:.2f} | {_four(w)} | {N_PER_MM * w.formula:.1f} |"
            for axis, w in sheet.walls.items()
        ),
        "",
        f"What is rendered is at most {SHARE:g} of the worst at its pose: {_range(summaries['wall'])} over the cube.",
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
        f"| noise in a wall of {N_PER_MM * DEFAULT_WALL:g} N/mm | {_told(sheet.wall_noise)} | at most {FORCE:g} N and "
        f"{1e6 * MOTION:g} um are taken for unnoticed |",
        f"| damping that noise allows | {sheet.spring_damping:.1f} N s/m | beside a spring of {SPRING[0]:g} N/m |",
        f"| dynamic range | {moves['dynamic_range']:.1f} | {DEFINITIONS['dynamic_range']} |",
        f"| peak acceleration | {moves['peak_acceleration']:.0f} m/s^2 | {DEFINITIONS['peak_acceleration']} |",
        f"| isotropy of mass, centre | {moves['isotropy']:.2f} | {DEFINITIONS['isotropy']} |",
        f"| force bandwidth | {sheet.force_bandwidth:.0f} Hz | {DEFINITIONS['force_bandwidth']} |",
        f"| first resonance | {sheet.first_resonance:.0f} Hz | {DEFINITIONS['first_resonance']} |",
        "",
        "### Definitions and sources",
        "",
        *(f"- {name.replace('_', ' ')}: {text}." for name, text in DEFINITIONS.items()),
        "",
    ]


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
