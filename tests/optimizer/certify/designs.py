"""The published design with other requirements, made-up masses, and the command, for `certify` and `verify`."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

from delta_cad.design import Design, design_to_dict, load_design
from delta_cad.drive.held import KNOWN
from optimizer.commands import cli
from tests.committed import PUBLISHED


def call(*arguments: str | Path) -> int:
    return cli.main([str(argument) for argument in arguments])


def changed(
    tmp_path: Path, cube: dict[str, float] | None = None, mechanism: dict[str, float] | None = None, **requirements: Any
) -> Path:
    data = design_to_dict(load_design(PUBLISHED))
    data["mechanism"] |= mechanism or {}
    data["requirements"] = {
        "envelope_width_mm": 270.0,
        "envelope_depth_mm": 220.0,
        "force_N": 3.0,
        "joint_torque_N_m": 0.8,
    } | requirements
    data["cube"] |= cube or {}
    path = tmp_path / "design.json"
    path.write_text(json.dumps(data))
    return path


def masses(tmp_path: Path, design: Design, turning: float | None = None) -> Path:
    """Mass properties; `turning` is every body's moment of inertia in kg m^2, left out if None."""
    home = list(design.home_mm)
    bodies = {name: {"mass_kg": 0.01, "centre_m": [0.02, 0.0, 0.0]} for name in KNOWN}
    bodies |= {f"pinion_{i}": {"mass_kg": 0.002, "centre_m": [0.0, 0.01, 0.0]} for i in range(3)}
    if turning is not None:
        bodies = {name: body | {"inertia_kg_m2": diagonal(turning)} for name, body in bodies.items()}
    path = tmp_path / "mass_properties.json"
    path.write_text(json.dumps({"schema": "delta-mass-properties/1", "home_mm": home, "bodies": bodies}))
    return path


def diagonal(moment: float) -> list[list[float]]:
    return [[moment * (i == j) for j in range(3)] for i in range(3)]


def redigested(data: dict[str, Any]) -> dict[str, Any]:
    """What a forger does who knows the format: a digest that fits."""
    rest = {key: value for key, value in data.items() if key != "digest"}
    text = json.dumps(rest, sort_keys=True, separators=(",", ":"))
    return rest | {"digest": hashlib.sha256(text.encode()).hexdigest()}
