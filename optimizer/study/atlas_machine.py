"""One set of an atlas of machines: a brief, and the machine that closed forms pass with masses of its own solids."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from delta_cad.design import design_to_json
from optimizer.codesign.corrections import reference
from optimizer.codesign.hardware import price_EUR
from optimizer.codesign.search import Search
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.problem.evaluator import VARIABLES
from optimizer.study.grid import MACHINES
from optimizer.study.machines import MachinePoint, best_machine


def machine_of(one: Mapping[str, Any]) -> dict[str, Any]:
    """Finds the machine of one set.

    Args:
        one: A `grid.Set` whose requirements are a brief, as plain data.

    Returns:
        What its row of the atlas says of it; `machine`: hardware and figures by column, None where there is none;
        `design`: text of its design file.
    """
    brief = brief_from_dict(one["requirements"], f"set {one['index']}", Path(one["folder"]))
    search = Search(brief, _nothing, _nothing, reference(), one["seed"])
    point = best_machine(search)
    if point is None:
        return {"message": "; ".join(search.log.reasons), "machine": None}
    name = f"{brief.name[:NAME_ROOM]}-set-{one['index']}"
    design = design_to_json(point.design.model_copy(update={"name": name}))
    return {"feasible": True, "machine": _columns(point), "steps": [_step(brief, point)], "design": design}


NAME_ROOM = 40  # letters of a brief's name in those of its machines: with a set's number within what a folder may have


def _nothing(_: object) -> Any:
    """Builds nothing: an atlas lists what its lines build."""
    raise AssertionError


def _columns(point: MachinePoint) -> dict[str, Any]:
    """Hardware and figures of a machine, by column."""
    choice, figures = point.choice, asdict(point.figures)
    width, depth = figures.pop("outline_mm")
    told = {"motor": choice.motor, "drive": choice.drive, "ratio": choice.ratio}
    return told | {"parallelogram_width_mm": choice.width_mm, "width_mm": width, "depth_mm": depth} | figures


def _step(brief: DesignBrief, point: MachinePoint) -> dict[str, Any]:
    """What is sought, and the lengths, as the paper's steps tell theirs."""
    design, figures = point.design, point.figures
    lengths = design.mechanism.model_dump() | design.cube.model_dump()
    variables = {f"{name}_mm": lengths[f"{name}_mm"] for name in VARIABLES}
    sought: dict[str, Callable[[], float]] = {
        "cube_side": lambda: figures.cube_side_mm,
        "outline": lambda: figures.outline_mm[0],
        "effective_mass": lambda: figures.effective_mass_kg,
        "cost": lambda: price_EUR(brief, point.choice, list(variables.values())),
    }
    return {
        "step": MACHINES,
        "objective_name": brief.objective,
        "objective": sought[brief.objective](),
        "variables": variables,
        "max_torque_N_m": design.requirements.joint_torque_N_m,
        "max_kappa": figures.kappa,
        "feasible": True,
        "status": "closed forms",
    }
