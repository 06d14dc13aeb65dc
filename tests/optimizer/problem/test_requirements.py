"""The requirements file: what is accepted, what is refused and with which words."""

from __future__ import annotations

import copy
import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from delta_cad.mechanism.limits import HandleInertia
from optimizer.problem.requirements import (
    Bounds,
    RequirementsError,
    load_requirements,
    requirements_from_dict,
    requirements_hash,
)
from tests.optimizer.tasks import INERTIA

JOYSTICK = Path(__file__).parents[3] / "joystick.toml"
MISSING = object()


def contract() -> dict[str, Any]:
    """The example of the contract, without what is optional."""
    return {
        "name": "dashboard-joystick",
        "requirements": {
            "envelope_width_mm": 270.0,
            "envelope_depth_mm": 220.0,
            "force_N": 3.0,
            "joint_torque_N_m": 0.8,
        },
        "bounds_mm": {
            "upper_arm_length": [82, 82],
            "forearm_length": [40, 130],
            "base_radius": [40, 40],
            "platform_radius": [20, 45],
            "bottom_height": [40, 100],
            "half_side": [0, 100],
        },
    }


def test_committed_file_is_the_papers_task_within_our_hardware() -> None:
    given = load_requirements(JOYSTICK)
    task = given.requirements
    assert (task.envelope_width_mm, task.envelope_depth_mm, task.force_N, task.joint_torque_N_m) == (270, 220, 3, 0.8)
    assert given.bounds_mm.base_radius == (40, 40)
    assert given.bounds_mm.upper_arm_length == (82, 82)
    assert given.limits.outline_radius_max_mm == 122
    assert given.limits.parallelogram_width_mm == 54


def test_defaults_are_filled_in_and_whole_numbers_are_lengths() -> None:
    given = requirements_from_dict(contract())
    assert given.bounds_mm.forearm_length == (40.0, 130.0)
    assert given.limits.outline_radius_max_mm is None
    assert given.limits.gravity_torque_N_m == 0.0
    assert given.step_3.half_side_mm is None


def test_hash_sees_every_number_but_not_the_spelling_of_defaults() -> None:
    given = requirements_from_dict(contract())
    spelled = requirements_from_dict(contract() | {"limits": {"gravity_torque_N_m": 0.0}, "step_3": {}})
    other = contract()
    other["bounds_mm"]["half_side"] = [0, 100.00000001]
    assert requirements_hash(spelled) == requirements_hash(given)
    assert requirements_hash(requirements_from_dict(other)) != requirements_hash(given)


def test_hash_leaves_out_what_is_not_stated_and_sees_each_number_of_the_masses() -> None:
    """A limit that is added to the program changes no hash."""
    asked = contract() | {"limits": {"effective_mass_max_kg": 0.4}, "inertia": INERTIA}
    hashes = {requirements_hash(requirements_from_dict(data)) for data in (contract(), asked)}
    for name in INERTIA:
        changed = asked | {"inertia": INERTIA | {name: 0.0123}}
        hashes.add(requirements_hash(requirements_from_dict(changed)))
    assert len(hashes) == 2 + len(INERTIA)
    text = json.dumps(requirements_from_dict(contract()).model_dump(mode="json", exclude_none=True))
    assert "null" not in text
    assert "inertia" not in text
    assert "effective_mass" not in text


def test_an_effective_mass_is_asked_with_its_masses() -> None:
    given = requirements_from_dict(contract() | {"limits": {"effective_mass_max_kg": 0.4}, "inertia": INERTIA})
    assert given.limits.effective_mass_max_kg == 0.4
    assert given.values["inertia"] == HandleInertia(*INERTIA.values())
    assert requirements_from_dict(contract() | {"inertia": INERTIA}).limits.effective_mass_max_kg is None
    assert requirements_from_dict(contract()).values["inertia"] is None


REFUSED = [
    ("name", "../up", 'name = "../up": must be 1 to 64 letters'),
    ("name", MISSING, "name: is missing; must be 1 to 64 letters"),
    ("requirements", 3, "requirements = 3: must be a table"),
    ("requirements", MISSING, "requirements: is missing; must be a table"),
    ("requirements.force_N", MISSING, "requirements.force_N: is missing; must be a number > 0 and <= 1000 N"),
    ("requirements.force_N", 0, "requirements.force_N = 0: must be a number > 0 and <= 1000 N"),
    ("requirements.force_N", True, "requirements.force_N = true: must be a number"),
    ("requirements.force_N", float("nan"), "requirements.force_N = NaN: must be finite"),
    ("requirements.joint_torque_N_m", float("inf"), "requirements.joint_torque_N_m = Infinity: must be finite"),
    ("requirements.envelope_width_m", 0.27, "requirements.envelope_width_m = 0.27: unknown key; known here: envelope"),
    ("speed", 1, "speed = 1: unknown key; known here: name, requirements, bounds_mm, limits, step_3"),
    ("bounds_mm.half_side", [100, 0], "bounds_mm.half_side = [100.0, 0.0]: bounds are swapped: must be [lower, upper]"),
    ("bounds_mm.half_side", [0, 0], "bounds_mm.half_side = [0.0, 0.0]: upper bound must be > 0 mm"),
    ("bounds_mm.half_side", [0, float("nan")], "bounds_mm.half_side[1] = NaN: must be finite"),
    ("bounds_mm.base_radius", [40], "bounds_mm.base_radius[1] = [40]: must be [lower, upper], two numbers"),
    ("bounds_mm.base_radius", 40, "bounds_mm.base_radius = 40: must be [lower, upper], two numbers, each >= 1"),
    ("bounds_mm.base_radius", [0, 40], "bounds_mm.base_radius[0] = 0: must be [lower, upper], two numbers"),
    ("bounds_mm.base_radius", ["40", 40], 'bounds_mm.base_radius[0] = "40": must be [lower, upper]'),
    ("bounds_mm.base_radius", MISSING, "bounds_mm.base_radius: is missing; must be [lower, upper]"),
    ("limits.kappa_max", 0.5, "limits.kappa_max = 0.5: must be a number >= 1 and <= 1e+06"),
    ("limits.lean_max_deg", 90, "limits.lean_max_deg = 90: must be a number > 0 and < 90 deg"),
    ("limits.shoulder_deg", [80, -45], "limits.shoulder_deg = [80.0, -45.0]: bounds are swapped"),
    ("limits.gravity_m_s2", [0, 0], "limits.gravity_m_s2[2] = [0, 0]: must be a list of 3 numbers"),
    ("limits.outline_overhead_mm", [-1, 0], "limits.outline_overhead_mm[0] = -1: must be [along W, along D]"),
    ("limits.gravity_torque_N_m", 0.8, "limits.gravity_torque_N_m = 0.8: must be < requirements.joint_torque_N_m"),
    ("limits.shoulder_deg", [10, 10], "shoulder: shoulder is (0.1745"),
    (
        "limits.effective_mass_max_kg",
        0.4,
        "limits.effective_mass_max_kg = 0.4: needs the masses of what moves: table ",
    ),
    ("limits.effective_mass_max_kg", 0, "limits.effective_mass_max_kg = 0: must be a number > 0 and <= 1000 kg"),
    ("limits.effective_mass_max_kg", 1001, "limits.effective_mass_max_kg = 1001: must be a number > 0 and <= 1000 kg"),
    ("limits.effective_mass_max_kg", True, "limits.effective_mass_max_kg = true: must be a number"),
    ("inertia", INERTIA | {"carried_mass_kg": 0}, "inertia.carried_mass_kg = 0: must be a number > 0 and <= 1000 kg"),
    (
        "inertia",
        INERTIA | {"elbow_mass_kg": -1e-9},
        "inertia.elbow_mass_kg = -1e-09: must be a number >= 0 and <= 1000",
    ),
    (
        "inertia",
        INERTIA | {"cross_mass_kg": -1001},
        "inertia.cross_mass_kg = -1001: must be a number >= -1000 and",
    ),
    (
        "inertia",
        INERTIA | {"joint_inertia_kg_m2": 2000},
        "inertia.joint_inertia_kg_m2 = 2000: must be a number >= 0",
    ),
    ("inertia", {"carried_mass_kg": 0.1}, "inertia.elbow_mass_kg: is missing; must be a number >= 0 and <= 1000 kg"),
    ("inertia", INERTIA | {"speed": 1}, "inertia.speed = 1: unknown key; known here: carried_mass_kg, elbow_mass_kg"),
    ("inertia", 3, "inertia = 3: must be a table"),
    ("requirements.force_N", 1e-9, "torque: force is 1e-09; it must be within 1e-06 and 1e+06 N"),
    ("requirements.joint_torque_N_m", 1e-9, "torque: torque_max is 1e-09; it must be within 1e-06 and 1e+06 N m"),
    ("step_3.half_side_mm", 120, "step_3.half_side_mm = 120.0: must be within bounds_mm.half_side = [0, 100] mm"),
    ("step_3.half_side_mm", 0, "step_3.half_side_mm = 0: must be a number > 0 and <= 1000 mm"),
]


@pytest.mark.parametrize(("field", "value", "words"), REFUSED, ids=[f"{f}={v!r:.20}" for f, v, _ in REFUSED])
def test_refusal_names_file_field_value_and_what_is_allowed(field: str, value: Any, words: str) -> None:
    data = copy.deepcopy(contract())
    *path, last = field.split(".")
    table = data
    for part in path:
        table = table.setdefault(part, {})
    if value is MISSING:
        del table[last]
    else:
        table[last] = value
    with pytest.raises(RequirementsError, match="^" + re.escape(f"task.toml: {words}")) as caught:
        requirements_from_dict(data, "task.toml")
    assert "\n" not in str(caught.value)


def test_a_value_that_is_no_table_is_refused() -> None:
    with pytest.raises(RequirementsError, match=r"^requirements: \[1, 2\]: must be a table$"):
        requirements_from_dict([1, 2])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"name = \xff", "task.toml: is not UTF-8 text: invalid start byte at byte 7"),
        (b"name = ", "task.toml: is not TOML we can read: Invalid value"),
        (b"name = 'a'\nname = 'b'", "task.toml: is not TOML we can read: Cannot overwrite a value"),
        (b"name = " + b"1" * 5000, "task.toml: is not TOML we can read: Exceeds the limit"),
        (b"name = " + b"[" * 100_000, "task.toml: is not TOML we can read: "),
    ],
    ids=["encoding", "syntax", "twice", "digits", "nested"],
)
def test_unreadable_file_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    file = tmp_path / "task.toml"
    file.write_bytes(content)
    with pytest.raises(RequirementsError, match="^" + re.escape(words)):
        load_requirements(file)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(RequirementsError, match=r"^none\.toml: cannot be read: No such file"):
        load_requirements(tmp_path / "none.toml")


def test_every_variable_has_bounds_in_the_committed_file() -> None:
    assert list(tomllib.loads(JOYSTICK.read_text())["bounds_mm"]) == list(Bounds.model_fields)


def test_reading_loads_neither_cad_nor_solvers() -> None:
    code = (
        "import sys, optimizer.problem.requirements as r; r.load_requirements(sys.argv[1]);"
        "print([m for m in ('cadquery', 'OCP', 'scipy', 'pymoo', 'numba') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(JOYSTICK)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
