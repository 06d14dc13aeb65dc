"""The design file of a result, with where it comes from."""

from __future__ import annotations

import importlib.metadata
from pathlib import Path
from typing import Any

from delta_cad.design import Design, design_from_dict, design_to_json
from optimizer.evaluator import VARIABLES
from optimizer.requirements import Requirements, requirements_hash
from optimizer.result import Result


def design_of(given: Requirements, results: list[Result], method: str, seed: int, file: str) -> Design:
    """The last result as a design.

    Args:
        given: What the customer gave; its limits become the design's requirements.
        results: One for each step, the last of them wanted.
        method: That found them.
        seed: That they were found with.
        file: Name that error messages start with.

    Returns:
        The design, its provenance filled in.

    Raises:
        DesignError: The design file refuses the lengths.
    """
    lengths = dict(zip(VARIABLES, results[-1].design_mm, strict=True))
    limits, task = given.limits, given.requirements
    asked: dict[str, Any] = task.model_dump()
    if limits.kappa_max is not None:
        asked["kappa_max"] = limits.kappa_max
    if limits.lean_max_deg is not None:
        asked["lean_max_deg"] = limits.lean_max_deg
    if limits.shoulder_deg is not None:
        asked["shoulder_min_deg"], asked["shoulder_max_deg"] = limits.shoulder_deg
    if limits.clearance_min_mm is not None:
        asked["clearance_min_mm"] = limits.clearance_min_mm
    asked["gravity_m_s2"] = list(limits.gravity_m_s2)
    data = {
        "schema": "delta-design/1",
        "name": given.name,
        "mechanism": {
            **{f"{name}_mm": lengths[name] for name in VARIABLES[:4]},
            "parallelogram_width_mm": limits.parallelogram_width_mm,
        },
        "cube": {f"{name}_mm": lengths[name] for name in VARIABLES[4:]},
        "requirements": asked,
        "provenance": {
            "program": "optimizer synthesize",
            "version": importlib.metadata.version("delta-haptics"),
            "method": method,
            "seed": seed,
            "requirements_sha256": requirements_hash(given),
            "steps": [_step(result) for result in results],
        },
    }
    return design_from_dict(data, file)


def write_design(design: Design, path: Path) -> None:
    """Writes a design file whole or not at all: beside its place, then renamed."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(path.name + ".part")
    partial.write_text(design_to_json(design), encoding="utf-8")
    partial.replace(path)


def _step(result: Result) -> dict[str, Any]:
    record = result.record()
    names = ("step", "objective", "objective_name", "status", "max_torque_N_m", "max_kappa", "proven_bound", "gap")
    return {name: record[name] for name in names}
