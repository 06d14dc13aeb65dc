"""What `front --machines` writes: the points as a table and as JSON, and a design file of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

from delta_cad.design import design_to_json
from optimizer.codesign.variants.front import AXES, MachinePoint, hardware_of

DESIGNS = "designs"
UNITS = {"effective_mass": "kg", "friction": "N", "stiffness": "N/mm", "outline": "mm wide", "cube": "mm"}
HEAD = ("limit", "cube mm", "outline mm", "effective mass kg", "friction N", "stiffness N/mm", "kappa", "built by")


def record(points: Sequence[MachinePoint], name: str) -> dict[str, Any]:
    """Gives the points as JSON types."""
    told = []
    for point in points:
        figures = {**asdict(point.figures), "outline_mm": list(point.figures.outline_mm)}
        hardware = {"motor": point.choice.motor, "drive": point.choice.drive, "ratio": point.choice.ratio}
        place = {"design": f"{DESIGNS}/{point.name}.json", "on_front": point.on_front}
        told.append({"axis": point.axis, "limit": point.limit, **hardware, **figures, **place})
    return {"schema": "delta-machines/1", "name": name, "points": told}


def design_files(points: Sequence[MachinePoint]) -> dict[str, str]:
    """Gives name and text of every design file."""
    return {f"{point.name}.json": design_to_json(point.design) for point in points}


def page(points: Sequence[MachinePoint], name: str, folder: str) -> str:
    """Writes the page.

    Args:
        points: The front.
        name: Of the requirements.
        folder: Where the files stand, as commands name it.
    """
    lines = [
        f"# The front of machines: {name}",
        "",
        "Each limit is relaxed and tightened by itself, the others stay as required. Figures are the worst in a cube,",
        "with masses from solids of the same hardware; every design passes the closed-form checks of its parts.",
        "Clearance is checked when a machine is built, with the command of its line. **Bold**: no other line is better",
        "in one figure and no worse in the others.",
        "",
        "![cube against effective mass, friction, stiffness and outline](machines.png)",
        "",
        "In [the same as a page](machines.html) each point opens its machine.",
    ]
    for choice in hardware_of(points):
        lines += ["", f"## {choice.motor}, {choice.drive} {choice.ratio:g}:1", ""]
        lines += [_row(HEAD), _row(("---",) * len(HEAD))]
        lines += [_row(_cells(point, folder)) for point in in_order(points) if point.choice == choice]
    return "\n".join(lines) + "\n"


def in_order(points: Sequence[MachinePoint]) -> list[MachinePoint]:
    """Sorts points as tables list them: what was asked first, then axis after axis by the limit."""
    order = ["asked", *(axis.name for axis in AXES)]
    return sorted(points, key=lambda p: (order.index(p.axis), p.limit or 0.0))


def limit_of(point: MachinePoint) -> str:
    """Names the limit that was moved, and its value."""
    if point.limit is None:
        return "as required"
    return f"{point.axis.replace('_', ' ')} {point.limit:.4g} {UNITS[point.axis]}"


def _cells(point: MachinePoint, folder: str) -> tuple[str, ...]:
    f = point.figures
    side = f"{f.cube_side_mm:.2f}"
    width, depth = f.outline_mm
    return (
        limit_of(point),
        f"**{side}**" if point.on_front else side,
        f"{width:.0f} x {depth:.0f}",
        f"{f.effective_mass_kg:.3f}",
        f"{f.friction_N:.2f}",
        f"{f.stiffness_N_mm:.1f}",
        f"{f.kappa:.2f}",
        f"`python -m delta_cad build --design {folder}/{DESIGNS}/{point.name}.json`",
    )


def _row(cells: Sequence[str]) -> str:
    return f"| {' | '.join(cells)} |"
