"""The feel sheet: a page, the same facts as JSON types, and which maps belong to it."""

from __future__ import annotations

import csv
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from textwrap import wrap
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.feel.field import COMMAND_STEPS
from haptics.feel.holds import DEFINITION, hold_facts, hold_markdown
from haptics.feel.loop_page import loop_markdown, loop_text, sheet_facts
from haptics.feel.loops import DEFINITIONS
from haptics.feel.sheet import MASS_ERROR, Feel
from haptics.feel.summary import QUANTITIES, Quantity, Summary
from haptics.loop.assumptions import joint_friction
from haptics.loop.hardware import reading_age
from haptics.model.hands import HAND_MODELS
from haptics.model.machine import MachineModel

# Published figures of devices on the market, each with the source that was opened and how it was tested.
FILE = Path(__file__).with_name("reference_devices.csv")
LABELS = {
    "workspace_mm": "workspace, mm",
    "force_continuous_N": "force, continuous, N",
    "force_peak_N": "force, peak, N",
    "stiffness_N_per_mm": "stiffest wall, N/mm",
    "apparent_mass_g": "apparent mass, g",
    "friction_N": "friction, N",
    "resolution_mm": "position resolution, mm",
}


@dataclass(frozen=True)
class _PublishedDevice:
    """One figure of a device.

    Attributes:
        device: Maker and name.
        quantity: One of `LABELS`.
        value: The figure; None where it is text.
        bound: "<", ">", "~" or nothing before it.
        text: The text; empty where it is a figure.
        test: How it was tested, or "unknown".
        source: Where it is published; somebody of this project opened it.
    """

    device: str
    quantity: str
    value: float | None
    bound: str
    text: str
    test: str
    source: str

    @property
    def shown(self) -> str:
        """Text of the value in a table."""
        return self.text if self.value is None else f"{self.bound} {self.value:g}".strip()


def reference_devices() -> tuple[_PublishedDevice, ...]:
    """Published figures of the data file, in its order."""
    with FILE.open(encoding="utf-8", newline="") as file:
        return tuple(
            _PublishedDevice(
                device=row["device"],
                quantity=row["quantity"],
                value=float(row["value"]) if row["value"] else None,
                bound=row["bound"],
                text=row["text"],
                test=row["test"],
                source=row["source"],
            )
            for row in csv.DictReader(file, strict=True)
        )


_SCHEMA = "delta-feel/2"
MAPS = (
    *("mass_max", "isotropy", "friction_max", "force_continuous", "force_peak", "acceleration"),
    *("position_step", "wall", "gravity"),
)
_PROJECT = "this design"
_WIDTH = 110


def map_values(sheet: Feel, quantity: Quantity) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """x, y, z (mm) and values (3, ny, nx) of a quantity's map, in its unit."""
    p = MM_PER_M * sheet.positions
    return p[0, 0, :, 0], p[0, :, 0, 1], p[:, 0, 0, 2], quantity.factor * sheet.slices[quantity.name]


def feel_facts(sheet: Feel) -> dict[str, Any]:
    """The facts as JSON types, with a unit in every key."""
    friction = joint_friction(sheet.machine)
    return {
        "schema": _SCHEMA,
        "name": sheet.machine.design.name,
        "answers": [asdict(answer) for answer in sheet.answers],
        "summary": {summary.quantity.key: _summary_facts(summary) for summary in sheet.summaries.values()},
        "hold": {"definition": DEFINITION, "forces": hold_facts(sheet.holds)},
        "loop": sheet_facts(sheet.loop, sheet.machine),
        "rendered_wall_N_per_mm": {name: _summary_facts(over) for name, over in sheet.rendered.items()},
        "beside": [
            {
                "device": row.device,
                "quantity": row.quantity,
                "value": row.shown,
                "test": row.test,
                "source": row.source,
            }
            for row in reference_devices()
        ],
        "maps": {quantity.key: _map_facts(sheet, quantity) for quantity in QUANTITIES if quantity.name in MAPS},
        "assumptions": {
            "joint_friction_coulomb_N_m": list(friction.coulomb),
            "drive_friction_coulomb_N_m": list(friction.drive),
            "joint_friction_viscous_N_m_s_per_rad": list(friction.viscous),
            "torque_ripple_share": sheet.drive.ripple,
            "cogging_N_m": sheet.drive.cogging,
            "command_steps": COMMAND_STEPS,
            "mass_error": MASS_ERROR,
            "continuous_torque_N_m": sheet.drive.continuous,
            "peak_torque_N_m": sheet.drive.peak,
            "peak_torque_of_the_motor_N_m": sheet.drive.motor,
            "encoder_count_rad": sheet.drive.count,
        },
    }


def _summary_facts(summary: Summary) -> dict[str, Any]:
    factor = summary.quantity.factor
    return {
        "centre": factor * summary.centre,
        "best": factor * summary.best[0],
        "best_at_mm": (MM_PER_M * summary.best[1]).tolist(),
        "worst": factor * summary.worst[0],
        "worst_at_mm": (MM_PER_M * summary.worst[1]).tolist(),
    }


def _map_facts(sheet: Feel, quantity: Quantity) -> dict[str, Any]:
    x, y, z, values = map_values(sheet, quantity)
    return {  # every fourth: the picture has them all
        "x_mm": x[::4].tolist(),
        "y_mm": y[::4].tolist(),
        "z_mm": z.tolist(),
        "values_z_y_x": values[:, ::4, ::4].tolist(),
    }


def feel_text(sheet: Feel) -> str:
    """Answers and summary as plain text."""
    lines = [f"{sheet.machine.design.name}: what it will feel like", ""]
    for answer in sheet.answers:
        lines += [
            f"{answer.question} {answer.short}",
            *wrap(answer.text, _WIDTH, initial_indent="  ", subsequent_indent="  "),
        ]
    head = f"{'':44}{'unit':>6}{'centre':>9}{'best':>9}{'worst':>9}   worst at, mm"
    rows = [
        f"{s.quantity.label:<44}{s.quantity.unit:>6}{_number(s, s.centre):>9}{_number(s, s.best[0]):>9}"
        f"{_number(s, s.worst[0]):>9}   {_place(s.worst[1])}"
        for s in sheet.summaries.values()
    ]
    return "\n".join([*lines, "", head, *rows, "", *loop_text(sheet.loop, sheet.rendered, sheet.machine)])


def _number(summary: Summary, value: float) -> str:
    return f"{summary.quantity.factor * value:.{summary.quantity.digits}f}"


def _place(p: np.ndarray) -> str:
    return ", ".join(f"{MM_PER_M * x + 0.0:.1f}" for x in p)


def feel_markdown(sheet: Feel) -> str:
    """Writes the feel sheet as a Markdown page: figures over the cube, other devices, walls, what is assumed."""
    machine, design = sheet.machine, sheet.machine.design
    side = 2.0 * design.cube.half_side_mm
    low, usual, most = (1e3 * torque for torque in joint_friction(machine).drive)
    lines = [
        f"# What {design.name} will feel like",
        "",
        f"Predicted from the design and the masses of its solids, over its cube of {side:g} mm. Nothing was measured; "
        "what is assumed stands at the end.",
        "",
    ]
    for answer in sheet.answers:
        lines += [f"**{answer.question} {answer.short}** {answer.text}", ""]
    lines += [
        "## Figures over the cube",
        "",
        "| figure | unit | centre | best | worst | worst at x, y, z, mm |",
        "|---|---|---:|---:|---:|---|",
    ]
    for s in sheet.summaries.values():
        lines.append(
            f"| {s.quantity.label} | {s.quantity.unit} | {_number(s, s.centre)} | {_number(s, s.best[0])} | "
            f"{_number(s, s.worst[0])} | {_place(s.worst[1])} |"
        )
    lines += [
        "",
        "Effective mass: felt along a direction with the others free. Friction: Coulomb friction of the joints, the "
        "rods' ball joints included, against a steady motion (the limit `friction_max_N` is proved of a bound, which "
        "lies above it); in the best direction it is also the smallest force that moves a handle at rest, and hides "
        "smaller forces from a resting hand. Force in every direction: the largest ball in the polytope of "
        f"forces that the joints give beside the weight. {_stops(sheet)} Torque ripple: "
        f"{DEFINITIONS['ripple']}.",
        "",
        *hold_markdown(sheet.machine, sheet.holds),
        *loop_markdown(sheet.loop, sheet.summaries, sheet.rendered, sheet.machine),
        "## Beside devices on the market",
        "",
        *_comparison(sheet, reference_devices()),
        "",
        _stops(sheet),
        "",
        "Only figures whose source was opened; how theirs were tested stands beside their sources, where it is known. "
        "A stiffness of the others is what a library renders with them, not a limit by our protocol; ours is what is "
        "rendered, at the worst pose and direction and at the centre.",
        "",
    ]
    by_source: dict[tuple[str, str, str], list[str]] = {}
    for row in reference_devices():
        by_source.setdefault((row.device, row.test, row.source), []).append(LABELS[row.quantity])
    sources = [
        f"- {device}: {'; '.join(labels)}. Test: {test}. From: {source}."
        for (device, test, source), labels in by_source.items()
    ]
    lines += [
        "## Maps",
        "",
        "Light is good in all of them; the cross is the cube's axis; a picture's three slices share one scale.",
        "",
    ]
    for quantity in QUANTITIES:
        if quantity.name in MAPS:
            lines += [f"![{quantity.label}]({quantity.name}.png)", ""]
    lines += [
        "## What is assumed",
        "",
        f"- Coulomb friction of a joint {usual:.1f} mN m ({low:.1f} to {most:.1f}), from the motor's idle current; it "
        "scales all friction figures.",
        f"- Loop: {sheet.loop.loop.label}; the delay is {sheet.loop.loop.delays[0]:g} to "
        f"{sheet.loop.loop.delays[2]:g} ticks, currents follow within {1e3 * sheet.loop.loop.current_lag:g} ms.",
        f"- A motor's torque is off its current's by {100.0 * sheet.drive.ripple:g} %, and cogs by "
        f"{1e3 * sheet.drive.cogging:.2g} mN m at the joint.",
        f"- An encoder's reading has {math.degrees(sheet.loop.noise_rad):.2g} degrees rms of noise; where the "
        "catalogue tells none of its row, a count of 18 bits, with a quarter to four times that as its range: "
        f"figures of noise go with it. A reading's age: {_age(machine)}.",
        f"- Continuous torque {sheet.drive.continuous:.2f} N m (the smaller of the drive's and the design's limit), "
        f"peak {sheet.drive.peak:.2f} N m likewise; the motors by themselves {sheet.drive.motor:.2f} N m for "
        f"{machine.drive.peak_time_s:g} s.",
        f"- A current command of {COMMAND_STEPS} steps from minus to plus the peak.",
        *(f"- {name} hand: {model.meaning}." for name, model in HAND_MODELS.items()),
        "",
        "## Sources of the others' figures",
        "",
        *sources,
    ]
    return "\n".join(lines) + "\n"


def _age(machine: MachineModel) -> str:
    age = reading_age(machine)
    return f"{1e6 * age:g} us, as the catalogue tells" if age > 0.0 else "not told by any source, taken as none"


def _stops(sheet: Feel) -> str:
    """States the force that the controller gives, and what the motors by themselves could."""
    stop = sheet.machine.drive.required_peak_N_m
    if sheet.drive.motor <= stop:
        own = f"{sheet.drive.motor:.2f} N m at a joint"
        return f"The motors' own limit, {own}, is no more than the {stop:g} N m that the design asks for."
    given, own = (sheet.summaries[name].worst[0] for name in ("force_peak", "force_motor"))
    return (
        f"The controller stops at the design's {stop:g} N m at a joint, so that this device gives {given:.1f} N in "
        f"every direction everywhere; with motors let go to their own limit, {sheet.drive.motor:.2f} N m, it would be "
        f"{own:.1f} N for {sheet.machine.drive.peak_time_s:g} s."
    )


def _comparison(sheet: Feel, rows: tuple[_PublishedDevice, ...]) -> list[str]:
    devices = list(dict.fromkeys(row.device for row in rows))
    side = 2.0 * sheet.machine.design.cube.half_side_mm
    mass, friction = sheet.summaries["mass_max"], sheet.summaries["friction_max"]
    project = {
        "workspace_mm": f"{side:g} x {side:g} x {side:g}",
        "force_continuous_N": f"{sheet.summaries['force_continuous'].worst[0]:.1f} everywhere, any direction",
        "force_peak_N": f"{sheet.summaries['force_peak'].worst[0]:.1f} likewise, as the controller gives it",
        "stiffness_N_per_mm": f"{1e-3 * sheet.summaries['wall'].worst[0]:.1f} worst, "
        f"{1e-3 * sheet.summaries['wall'].centre:.1f} centre, where {sheet.loop.loop.condition}",
        "apparent_mass_g": f"{1e3 * mass.centre:.0f} centre, {1e3 * mass.worst[0]:.0f} worst",
        "friction_N": f"{friction.centre:.2f} centre, {friction.worst[0]:.2f} worst",
        "resolution_mm": f"{MM_PER_M * sheet.summaries['position_step'].worst[0]:.1g}, a count; its reading's noise is "
        f"{MM_PER_M * sheet.loop.noise_rad / sheet.drive.count * sheet.summaries['position_step'].worst[0]:.1g} rms",
    }
    shown = {(row.device, row.quantity): row.shown for row in rows}
    lines = [f"| | {_PROJECT} | {' | '.join(devices)} |", f"|---|---|{'---|' * len(devices)}"]
    for quantity, label in LABELS.items():
        cells = " | ".join(shown.get((device, quantity), "not known") for device in devices)
        lines.append(f"| {label} | {project[quantity]} | {cells} |")
        if quantity == "force_peak_N" and sheet.drive.motor > sheet.drive.peak:
            own = f"{sheet.summaries['force_motor'].worst[0]:.1f} likewise, which the controller does not give"
            lines.append(f"| the same at the motor's own limit, N | {own} |{' - |' * len(devices)}")
    return lines
