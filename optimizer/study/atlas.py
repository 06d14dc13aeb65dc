"""The atlas as files: table, record, page and map of many sets; the row of a set that is a brief, with its machine."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from delta_cad.design import design_to_json
from optimizer.codesign.hardware import price_EUR
from optimizer.codesign.search import Search
from optimizer.paper.page import markdown_table
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.problem.variables import named, variables_mm
from optimizer.study.grid import MACHINES, AtlasRow, Grid
from optimizer.study.machines import MachinePoint, best_machine
from optimizer.study.table import csv_text, json_text

_SCHEMA = "delta-atlas/1"
_DESIGNS, PICTURE = "designs", "atlas.png"
_UNITS = {"half_side": "_mm", "cube_side": "_mm", "outline": "_mm", "effective_mass": "_kg", "cost": "_EUR"}
_LINES_MAX = 500  # rows of the table on the page; all are in the CSV
_LEFT_OUT = ("method", "conflict_step", "ending", "seconds")  # columns of the CSV that the page spares
_NAME_ROOM = 40  # letters of a brief's name in those of its machines: with a set's number within what a folder may have


def machine_row(one: Mapping[str, Any]) -> AtlasRow:
    """Finds the machine of one set: what closed forms pass with masses of its own solids.

    Returns:
        What its row of the atlas says of it; `machine`: hardware and figures by column, None where there is none;
        `design`: text of its design file.
    """
    brief = brief_from_dict(one["requirements"], f"set {one['index']}", Path(one["folder"]))
    search = Search(brief, seed=one["seed"])
    point = best_machine(search)
    if point is None:
        return {"message": "; ".join(search.log.reasons), "machine": None}
    name = f"{brief.name[:_NAME_ROOM]}-set-{one['index']}"
    design = design_to_json(point.design.model_copy(update={"name": name}))
    return {"feasible": True, "machine": _machine_columns(point), "steps": [_step(brief, point)], "design": design}


def _machine_columns(point: MachinePoint) -> dict[str, Any]:
    choice, figures = point.choice, asdict(point.figures)
    width, depth = figures.pop("outline_mm")
    hardware = {"motor": choice.motor, "drive": choice.drive, "ratio": choice.ratio}
    return hardware | {"parallelogram_width_mm": choice.width_mm, "width_mm": width, "depth_mm": depth} | figures


def _step(brief: DesignBrief, point: MachinePoint) -> dict[str, Any]:
    """The objective and the lengths, as the paper's steps record theirs."""
    design, figures = point.design, point.figures
    lengths = variables_mm(design.mechanism.model_dump(), design.cube.model_dump())
    variables = named(lengths)
    objectives: dict[str, Callable[[], float]] = {
        "cube_side": lambda: figures.cube_side_mm,
        "outline": lambda: figures.outline_mm[0],
        "effective_mass": lambda: figures.effective_mass_kg,
        "cost": lambda: price_EUR(brief, point.choice, lengths),
    }
    return {
        "step": MACHINES,
        "objective_name": brief.objective,
        "objective": objectives[brief.objective](),
        "variables": variables,
        "max_torque_N_m": design.requirements.joint_torque_N_m,
        "max_kappa": figures.kappa,
        "feasible": True,
        "status": "closed forms",
    }


def atlas_files(
    grid: Grid, rows: Sequence[AtlasRow], folder: Path, draw: Callable[[], bytes]
) -> dict[Path, str | bytes]:
    """Writes all files of an atlas: path -> content; the map is drawn where the grid can be `mapped`.

    Args:
        grid: The grid.
        rows: One for each set, by their index.
        folder: Where the files will stand.
        draw: Draws the map.
    """
    picture: dict[Path, str | bytes] = {folder / PICTURE: draw()} if mapped(grid) else {}
    table = flat(rows)
    return picture | {
        folder / "atlas.json": json_text(record(grid, rows)),
        folder / "atlas.csv": csv_text(_columns(table), table),
        folder / "atlas.md": page(grid, rows, PICTURE if picture else None, folder.as_posix()),
        **{folder / _DESIGNS / f"set-{row['index']}.json": row["design"] for row in rows if row.get("machine")},
    }


def record(grid: Grid, rows: Sequence[AtlasRow]) -> dict[str, Any]:
    """Gathers the atlas as plain data for JSON."""
    return {
        "schema": _SCHEMA,
        "name": grid.name,
        "grid_sha256": grid.sha256,
        "axes": [{"field": axis.field, "values": list(axis.values)} for axis in grid.axes],
        "rows": list(rows),
    }


def flat(rows: Sequence[AtlasRow]) -> list[dict[str, Any]]:
    """Lays rows out as columns: inputs, seed, method, what contradicts, each step's objective, the last step's design.

    What infeasible rows have not is left out.
    """
    table = []
    for row in rows:
        line: dict[str, Any] = {"set": row["index"]}
        line |= {field: _plain(value) for field, value in row["inputs"].items()}
        line |= {"seed": row["seed"], "method": row["method"], "feasible": row["feasible"]}
        line |= {"conflict": " ".join(row["conflict"]), "conflict_step": row["conflict_step"]}
        line |= row.get("machine") or {}
        line |= {objective_column(step): step["objective"] for step in row["steps"]}
        if row["steps"]:
            last = row["steps"][-1]
            line |= last["variables"] | {"max_torque_N_m": last["max_torque_N_m"], "max_kappa": last["max_kappa"]}
            line |= {"ending": last["status"]}
        table.append(line | {"seconds": row["seconds"]})
    return table


def objective_column(step: Mapping[str, Any]) -> str:
    """Names the column of a step's objective."""
    name = step["objective_name"]
    return f"step_{step['step']}_{name}{_UNITS.get(name, '')}"


def _columns(table: Sequence[Mapping[str, Any]]) -> list[str]:
    """Lists the columns of all lines: those of the fullest first, in its order."""
    return list(dict.fromkeys(name for line in (max(table, key=len), *table) for name in line))


def page(grid: Grid, rows: Sequence[AtlasRow], picture: str | None, folder: str) -> str:
    """Writes the atlas as Markdown.

    Args:
        grid: The grid.
        rows: One for each set, by their index.
        picture: File name of the map; None without one.
        folder: Where the files stand, as commands name it.
    """
    met = sum(row["feasible"] for row in rows)
    reasons = Counter(" and ".join(row["conflict"]) for row in rows if row["conflict"])
    lines = [
        f"# Atlas {grid.name}",
        "",
        f"{len(rows)} sets by `{rows[0]['method']}`; {met} are met, {len(rows) - met} are not.",
        "",
        *(f"- `{axis.field}`: {', '.join(_text(value) for value in axis.values)}" for axis in grid.axes),
        f"- seeds: {', '.join(str(seed) for seed in dict.fromkeys(row['seed'] for row in rows))}",
        "",
    ]
    if reasons:
        counted = "; ".join(f"{reason} ({count})" for reason, count in reasons.most_common())
        lines += [f"What cannot be met together, and in how many sets: {counted}.", ""]
    if picture is not None:
        lines += [f"![{grid.name}]({picture})", ""]
    if any(row.get("machine") for row in rows):
        lines += [
            "Each machine passed the closed forms of its parts, with masses of solids of its hardware; what moves is",
            f"seen to when it is built: `python -m delta_cad build --design {folder}/{_DESIGNS}/set-N.json`.",
            "",
        ]
    lines += [
        f"- set {row['index']} has none: {row['message']}" for row in rows if "machine" in row and not row["machine"]
    ]
    lines += [""] if lines[-1] else []
    table = [{name: value for name, value in line.items() if name not in _LEFT_OUT} for line in flat(rows)]
    columns = _columns(table)
    cells = [[_text(line.get(name)) for name in columns] for line in table[:_LINES_MAX]]
    lines.append(markdown_table(columns, cells))
    if len(table) > _LINES_MAX:
        lines += ["", f"The first {_LINES_MAX} of {len(table)} rows; all are in atlas.csv."]
    return "\n".join(lines) + "\n"


def mapped(grid: Grid) -> bool:
    """Tells whether the grid can be drawn: two axes of numbers, at least two of each."""
    return len(grid.axes) == 2 and all(
        len(axis.values) > 1 and not any(isinstance(value, list | str) for value in axis.values) for axis in grid.axes
    )


def _plain(value: Any) -> Any:
    return " to ".join(f"{v:g}" for v in value) if isinstance(value, list) else value


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return "[" + ", ".join(_text(v) for v in value) + "]"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
