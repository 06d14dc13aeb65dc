"""The largest walls as facts (JSON types) and as a page of text."""

from __future__ import annotations

from collections.abc import Mapping
from textwrap import wrap
from typing import Any

from haptics.loop.choice import LoopChoice
from haptics.loop.passivity import Verdict
from haptics.loop.stiffness import CEILING, PLACES, AxisWall, End, Range, Stiffness
from haptics.loop.walls import STABILITY_MARGIN, START, StiffnessLimits
from haptics.model.hands import CORNERS

_SCHEMA = "delta-stiffness/2"
_N_PER_MM = 1e-3  # N/m in N/mm
_WIDTH = 110
FOUR = ("own", "passive", "worst", "nominal")  # walls of a loop, as `Walls` names them
FOUR_TEXT = (
    "own damping: passive with any hand by the device alone, B = 0; passive: with any passive hand and the wall's "
    "damping; worst and nominal hand: stable; formula: (b + B) / (T / 2 + delay + lag). Rendered at a pose is "
    f"{STABILITY_MARGIN:g} of the formula with the least friction and the largest delay"
)
_NOTE = (
    "friction: least, nominal and largest also differ in how far and how damped a joint gives way before it slips "
    "(assumptions.py), a guess on which stiff walls and grasps that damp little depend more than on all else",
    "simulation: 0.6 of the design's force leant on the wall; counts, sticking friction, saturation and leaving the "
    "wall are in it. A swing above 3 counts that is not halved within 0.5 s counts as oscillation, so that it may stop "
    "short of the linear limit. Where the encoders' counts lie moves it by some 10 %",
    "linear: the limit of the exact sampled model of the whole device, viscous friction only",
    "passivity asks for every passive hand, not for three: it knows neither the hands nor friction that sticks, and "
    "says nothing of what a user feels",
    "paper: one prototype whose masses, motors, encoders, filter and hand are not given; nothing here is fitted to it",
)


def stiffness_facts(name: str, result: Stiffness) -> dict[str, Any]:
    """The facts.

    Returns:
        JSON types, with a unit in every key.
    """
    return {
        "schema": _SCHEMA,
        "name": name,
        "period_ms": result.period * 1e3,
        "delay_ms": [delay * 1e3 for delay in result.delays],
        "damping_asked_N_s_per_m": result.damping,
        "damping_limit_N_s_per_m": result.cap.limit,
        "damping_applied_N_s_per_m": result.cap.applied(result.damping),
        "default_wall_N_per_mm": START * _N_PER_MM,
        "default_wall_oscillates_with": [{"axis": axis, "hand": hand} for axis, hand in result.unstable_cases],
        "axes": {wall.axis: _axis_facts(wall) for wall in result.axes},
        "notes": list(_NOTE),
    }


def _axis_facts(wall: AxisWall) -> dict[str, Any]:
    protocol = wall.nominal.protocol
    return {
        "published_N_per_mm": wall.published * _N_PER_MM,
        "simulated_N_per_mm": {
            "nominal_case": _corner(End(wall.nominal.bisection, wall.corner)),
            "protocol": None if protocol is None else protocol * _N_PER_MM,
            "bisection": wall.nominal.bisection * _N_PER_MM,
            "ceiling_reached": wall.nominal.ceiling_reached,
            **_range(wall.simulated),
            "asked": [[stiffness * _N_PER_MM, stands] for stiffness, stands in wall.nominal.history],
        },
        "linear_N_per_mm": {"nominal": wall.linear_nominal * _N_PER_MM, **_range(wall.linear)},
        "default_wall_stands_with": dict(wall.steady),
        "passivity": {
            "default_wall": _verdict(wall.default_verdict),
            "found_limit": None if wall.limit_verdict is None else _verdict(wall.limit_verdict),
        },
        "simulated_pushes": wall.trials,
    }


def _range(result: Range) -> dict[str, Any]:
    return {
        name: {"stiffness": end.stiffness * _N_PER_MM, **_corner(end), "or_more": end.open}
        for name, end in (("lowest", result.lowest), ("highest", result.highest))
    }


def _corner(end: End) -> dict[str, Any]:
    return {"hand": end.corner.hand, "friction": end.corner.friction, "delay_ms": end.corner.delay * 1e3}


def _verdict(result: Verdict) -> dict[str, Any]:
    return {
        "verdict": result.kind.value,
        "friction_N_s_per_m": result.friction,
        "friction_asked_N_s_per_m": result.demand.friction,
        "friction_missing_N_s_per_m": result.missing_friction,
        "at_rad_per_s": result.demand.frequency,
        "spectral_margin": result.spectral_margin,
        "worst_hand": result.worst_hand,
        "spectral_radius": dict(result.radii),
        "reason": result.reason,
    }


def stiffness_text(name: str, result: Stiffness) -> str:
    """The facts as lines of plain text."""
    applied = result.cap.applied(result.damping)
    delays = ", ".join(f"{delay * 1e3:g}" for delay in sorted(set(result.delays)))
    lines = [
        f"{name}: largest stable wall in the paper loop, N/mm; period {result.period * 1e3:g} ms, delay {delays} ms, "
        f"damping {result.damping:g} N s/m asked, {applied:.3g} applied",
        "",
        f"{'':6}{'paper':>7}{'simulated':>11}{'':>10}{'':>22}{'linear':>9}",
        f"{'axis':<6}{'':>7}{'protocol':>11}{'bisection':>10}{'range':>22}{'nominal':>9}{'range':>18}",
    ]
    for wall in result.axes:
        first, middle = wall.nominal.protocol, wall.nominal.bisection
        more = ">=" if wall.nominal.ceiling_reached else ""
        protocol = f"below {START * _N_PER_MM:g}" if first is None else f"{more}{first * _N_PER_MM:.1f}"
        lines.append(
            f"{wall.axis:<6}{wall.published * _N_PER_MM:7.1f}{protocol:>11}"
            f"{more + format(middle * _N_PER_MM, '.2f'):>10}"
            f"{_span(wall.simulated):>22}{wall.linear_nominal * _N_PER_MM:9.2f}{_span(wall.linear):>18}"
        )
    lines += ["", f"nominal: {result.axes[0].corner}. The ranges' ends:"]
    for label, chosen in (("simulated", lambda wall: wall.simulated), ("linear", lambda wall: wall.linear)):
        for which in ("lowest", "highest"):
            at: dict[str, list[str]] = {}
            for wall in result.axes:
                at.setdefault(str(getattr(chosen(wall), which).corner), []).append(wall.axis)
            says = "; ".join(f"{', '.join(axes)}: {corner}" for corner, axes in at.items())
            lines.append(f"  {label:<10}{which:<8}  {says}")
    lines += [
        "",
        f"Default wall, {START * _N_PER_MM:g} N/mm, simulated, friction and delay nominal, {PLACES} places of counts:",
    ]
    for wall in result.axes:
        says = ", ".join(f"{hand} {'stands' if stands else 'OSCILLATES'}" for hand, stands in wall.steady.items())
        low = wall.simulated.lowest
        short = f"; oscillates with {low.corner}" if low.stiffness < START else ""
        lines.append(f"  {wall.axis}  {says}{short}")
    lines += ["", "Passivity verdict (friction and delay nominal), kept apart from what is simulated:"]
    for wall in result.axes:
        for stiffness, verdict in ((START, wall.default_verdict), (wall.nominal.bisection, wall.limit_verdict)):
            if verdict is not None:
                lines.append(f"  {wall.axis}  {stiffness * _N_PER_MM:5.2f} N/mm: {verdict.kind.value}")
                lines += wrap(verdict.reason, _WIDTH, initial_indent=" " * 7, subsequent_indent=" " * 7)
    notes = [line for note in _NOTE for line in wrap(note, _WIDTH, subsequent_indent="  ")]
    return "\n".join([*lines, "", *notes])


def loop_facts(loop: LoopChoice) -> dict[str, Any]:
    """A loop as facts: its name, and what decides its walls."""
    return {
        "loop": loop.label,
        "rate_Hz": 1.0 / loop.period,
        "delay_ticks": list(loop.delays),
        "current_lag_ms": 1e3 * loop.current_lag,
        "velocity_filter_Hz": loop.corner,
        "wall_damping_N_s_per_m": loop.damping,
        "drive_damping_share_of_short_circuit": loop.drive_damping,
        "drive_damping_at_a_wall_share_of_short_circuit": loop.contact_damping,
    }


def walls_facts(loop: LoopChoice, walls: Mapping[str, StiffnessLimits]) -> dict[str, Any]:
    """The four walls in a loop, axis by axis, as facts."""
    axes = {
        axis: {f"{name}_N_per_mm": getattr(wall, name) * _N_PER_MM for name in FOUR}
        | {
            "worst_hand": wall.worst_hand,
            "formula_N_per_mm": wall.formula * _N_PER_MM,
            "device_friction_N_s_per_m": wall.friction,
        }
        for axis, wall in walls.items()
    }
    return loop_facts(loop) | {"rendered_share": STABILITY_MARGIN, "axes": axes}


def walls_text(loop: LoopChoice, walls: Mapping[str, StiffnessLimits]) -> list[str]:
    """The same as lines of text."""
    return [
        f"{loop.label}: walls at the centre, N/mm:",
        f"{'axis':<6}{'own damping':>13}{'passive':>10}{'worst hand':>12}{'nominal hand':>14}{'formula':>9}",
        *(
            f"{axis:<6}{w.own * _N_PER_MM:13.2f}{w.passive * _N_PER_MM:10.2f}{w.worst * _N_PER_MM:12.2f}"
            f"{w.nominal * _N_PER_MM:14.2f}{w.formula * _N_PER_MM:9.2f}   worst: {_who(w)}"
            for axis, w in walls.items()
        ),
    ]


def _who(walls: StiffnessLimits) -> str:
    known = walls.worst_hand not in CORNERS
    return walls.worst_hand if known else f"corner {walls.worst_hand} of the hands' ranges"


def _span(result: Range) -> str:
    top = f"{result.highest.stiffness * _N_PER_MM:.1f}" + (" or more" if result.highest.open else "")
    low = result.lowest.stiffness * _N_PER_MM
    return f"{low:.2f} to {top}" if result.lowest.stiffness < CEILING else f"{low:.0f} or more"
