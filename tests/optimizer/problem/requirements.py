"""Examples of requirements in both editions, and the lines that others are refused with."""

from __future__ import annotations

from typing import Any

import pytest

from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.problem.requirements import RequirementsError, requirements_from_dict
from tests.committed import ROOT

JOYSTICK, COMMITTED = ROOT / "tests/references/joystick.toml", ROOT / "examples/synthesized.toml"
OUTLINE = {"envelope_width_mm": 270, "envelope_depth_mm": 220}
CUBE = {"cube_side_mm": 75}
ROPE = "id,diameter_mm,breaking_load_N\nmine,0.5,150\n"


def first_edition() -> dict[str, Any]:
    """The example of the contract, without what is optional."""
    bounds = {"upper_arm_length": [82, 82], "forearm_length": [40, 130], "base_radius": [40, 40]}
    bounds |= {"platform_radius": [20, 45], "bottom_height": [40, 100], "half_side": [0, 100]}
    task = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0, "force_N": 3.0, "joint_torque_N_m": 0.8}
    return {"name": "dashboard-joystick", "requirements": task, "bounds_mm": bounds}


def second_edition() -> dict[str, Any]:
    """The example of the contract, without its folder of own parts."""
    return {
        "name": "dashboard-joystick",
        "requirements": OUTLINE | CUBE | {"force_N": 3, "peak_force_N": 8, "clearance_min_mm": 2},
        "feel": {"kappa_max": 2.27, "effective_mass_max_kg": 0.4, "friction_max_N": 0.7, "stiffness_min_N_mm": 8},
        "hardware": {"motor": ["maxon-re30-310007"], "drive": ["capstan"]},
        "goal": {"maximize": "cube_side"},
    }


def brief(**tables: Any) -> DesignBrief:
    return brief_from_dict({"name": "d"} | tables, "r.toml")


def lines_of_brief(data: object) -> list[str]:
    """What a brief is refused with, a line each."""
    with pytest.raises(RequirementsError) as caught:
        brief_from_dict(data, "r.toml")
    return _lines(caught.value)


def lines_of_requirements(data: object) -> list[str]:
    """What requirements of the first edition are refused with, a line each."""
    with pytest.raises(RequirementsError) as caught:
        requirements_from_dict(data, "r.toml")
    return _lines(caught.value)


def _lines(error: RequirementsError) -> list[str]:
    assert all(line.startswith("r.toml: ") and line.isprintable() for line in error.lines)
    return list(error.lines)


def fields(lines: list[str]) -> list[str]:
    """The fields that lines are about."""
    return [line.split(": ")[1].split(" = ")[0] for line in lines]
