"""The requirements file: what is accepted, what is refused and with which words."""

from __future__ import annotations

import copy
import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest

from delta_cad.mechanism.limits import HandleFriction, HandleInertia
from optimizer.problem.requirements import (
    Bounds,
    RequirementsError,
    load_requirements,
    requirements_from_dict,
    requirements_hash,
)
from tests.optimizer.messages import holds, refuses
from tests.optimizer.tasks import INERTIA

JOYSTICK = Path(__file__).parents[2] / "references" / "joystick.toml"
COMMITTED = Path(__file__).parents[3] / "examples" / "synthesized.toml"
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


def test_former_file_is_the_papers_task_within_our_hardware() -> None:
    given = load_requirements(JOYSTICK)
    task = given.requirements
    assert (task.envelope_width_mm, task.envelope_depth_mm, task.force_N, task.joint_torque_N_m) == (270, 220, 3, 0.8)
    assert given.bounds_mm.base_radius == (40, 40)
    assert given.bounds_mm.upper_arm_length == (82, 82)
    assert given.limits.outline_radius_max_mm == 122
    assert given.limits.parallelogram_width_mm == 54


def test_committed_file_is_the_papers_outline_and_force_within_our_own_machine() -> None:
    """What the customer asks is the paper's; the drive's torque, its peak and the split of 122 mm are ours."""
    given, former = load_requirements(COMMITTED), load_requirements(JOYSTICK)
    task = given.requirements
    for name in ("envelope_width_mm", "envelope_depth_mm", "force_N"):
        assert getattr(task, name) == getattr(former.requirements, name)
    assert (task.joint_torque_N_m, task.peak_torque_N_m, task.peak_force_N) == (0.39, 0.8, 6.0)
    assert given.bounds_mm.base_radius == (31, 31)
    assert given.bounds_mm.upper_arm_length == (91, 91)
    assert given.limits.outline_radius_max_mm == 31 + 91
    assert (given.limits.kappa_max, given.limits.couple_index_min) == (former.limits.kappa_max, 0.4)
    # cups of neighbouring wrists at the least radius of the platform keep the clearance (sides of a hexagon)
    r, width = given.bounds_mm.platform_radius[0], given.limits.parallelogram_width_mm
    gap = math.sqrt(3.0) * r - width / 2.0 - given.limits.joint_diameter_mm
    assert given.limits.clearance_min_mm is not None
    assert gap >= given.limits.clearance_min_mm


def test_defaults_are_filled_in_and_whole_numbers_are_lengths() -> None:
    given = requirements_from_dict(contract())
    assert given.bounds_mm.forearm_length == (40.0, 130.0)
    assert given.limits.outline_radius_max_mm is None
    assert given.limits.gravity_torque_N_m == 0.0
    assert given.step_3.half_side_mm is None


def test_what_a_machine_must_bear_is_asked_where_it_is_stated() -> None:
    given = requirements_from_dict(contract())
    names = ("peak_force_N", "peak_torque_N_m", "stiffness_min_N_mm")
    assert [getattr(given.requirements, name) for name in names] == [None] * 3
    for numbers in ((9.0, 1.5, 8.0), (3.0, 0.8, 8.0)):  # a peak may be what holds for ever
        stated = contract()
        stated["requirements"] |= dict(zip(names, numbers, strict=True))
        asked = requirements_from_dict(stated).requirements
        assert tuple(getattr(asked, name) for name in names) == numbers


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


def test_what_is_felt_of_the_joints_is_asked_with_what_they_are() -> None:
    asked = {"friction_max_N": 0.7, "position_step_max_mm": "80 um"}
    joints = {"friction_N_m": "12 mN m", "ball_upright_N": 0.05, "encoder_count_deg": 0.022}
    given = requirements_from_dict(contract() | {"limits": asked, "joints": joints})
    assert given.limits.position_step_max_mm == pytest.approx(0.08)
    assert given.values["friction"] == HandleFriction(0.012, 0.05, 0.0)
    assert given.values["encoder_count"] == pytest.approx(0.022 * math.pi / 180.0)
    plain = requirements_from_dict(contract())
    assert plain.values["friction"] is plain.values["encoder_count"] is None


REFUSED = [
    ("name", "../up", 'name = "../up": 1 64'),
    ("name", MISSING, "name: 1 64"),
    ("requirements", 3, "requirements = 3: "),
    ("requirements", MISSING, "requirements: "),
    ("requirements.force_N", MISSING, "requirements.force_N: 1e-06 1000"),
    ("requirements.force_N", 0, "requirements.force_N = 0: 1e-06 1000"),
    ("requirements.force_N", True, "requirements.force_N = true: "),
    ("requirements.force_N", float("nan"), "requirements.force_N = NaN: "),
    ("requirements.peak_force_N", 2.9, "requirements.peak_force_N = 2.9: 3"),
    ("requirements.peak_torque_N_m", 0.79, "requirements.peak_torque_N_m = 0.79: requirements.joint_torque_N_m = 0.8"),
    ("requirements.peak_torque_N_m", 0, "requirements.peak_torque_N_m = 0: 0 100"),
    ("requirements.stiffness_min_N_mm", 0, "requirements.stiffness_min_N_mm = 0: 0 1000 N/mm"),
    ("requirements.joint_torque_N_m", float("inf"), "requirements.joint_torque_N_m = Infinity: "),
    ("requirements.envelope_width_m", 0.27, "requirements.envelope_width_m = 0.27: "),
    ("speed", 1, "speed = 1: bounds_mm step_3"),
    ("bounds_mm.half_side", [100, 0], "bounds_mm.half_side = [100.0, 0.0]: "),
    ("bounds_mm.half_side", [0, 0], "bounds_mm.half_side = [0.0, 0.0]: 0"),
    ("bounds_mm.half_side", [0, float("nan")], "bounds_mm.half_side[1] = NaN: "),
    ("bounds_mm.base_radius", [40], "bounds_mm.base_radius[1] = [40]: "),
    ("bounds_mm.base_radius", 40, "bounds_mm.base_radius = 40: 1"),
    ("bounds_mm.base_radius", [0, 40], "bounds_mm.base_radius[0] = 0: "),
    ("bounds_mm.base_radius", ["40", 40], 'bounds_mm.base_radius[0] = "40": '),
    ("bounds_mm.base_radius", MISSING, "bounds_mm.base_radius: "),
    ("limits.kappa_max", 0.5, "limits.kappa_max = 0.5: 1 1e+06"),
    ("limits.lean_max_deg", 90, "limits.lean_max_deg = 90: 0 90"),
    ("limits.shoulder_deg", [80, -45], "limits.shoulder_deg = [80.0, -45.0]: "),
    ("limits.gravity_m_s2", [0, 0], "limits.gravity_m_s2[2] = [0, 0]: 3"),
    ("limits.outline_overhead_mm", [-1, 0], "limits.outline_overhead_mm[0] = -1: "),
    ("limits.gravity_torque_N_m", 0.8, "limits.gravity_torque_N_m = 0.8: requirements.joint_torque_N_m"),
    ("limits.shoulder_deg", [10, 10], "shoulder: "),
    (
        "limits.effective_mass_max_kg",
        0.4,
        "limits.effective_mass_max_kg = 0.4: ",
    ),
    ("limits.friction_max_N", 0.7, "limits.friction_max_N = 0.7: joints.friction_N_m"),
    ("limits.position_step_max_mm", 0.1, "limits.position_step_max_mm = 0.1: joints.encoder_count_deg"),
    ("limits.friction_max_N", 0, "limits.friction_max_N = 0: 0 100"),
    ("limits.position_step_max_mm", 101, "limits.position_step_max_mm = 101: 0 5 um 0.101"),
    ("joints", {"friction_N_m": -1e-9}, "joints.friction_N_m = -1e-09: 0 100"),
    ("joints", {"encoder_count_deg": 0}, "joints.encoder_count_deg = 0: 0 180"),
    ("joints", {"ball_level_N": float("nan")}, "joints.ball_level_N = NaN: "),
    ("limits.effective_mass_max_kg", 0, "limits.effective_mass_max_kg = 0: 0 50"),
    ("limits.effective_mass_max_kg", 1001, "limits.effective_mass_max_kg = 1001: 0 50 g 1.001"),
    ("limits.effective_mass_max_kg", True, "limits.effective_mass_max_kg = true: "),
    ("inertia", INERTIA | {"carried_mass_kg": 0}, "inertia.carried_mass_kg = 0: 0 1000"),
    ("limits.couple_index_min", 0, "limits.couple_index_min = 0: 0 1"),
    ("limits.couple_index_min", 1, "limits.couple_index_min = 1: 0 1"),
    ("limits.couple_index_min", "0.4", 'limits.couple_index_min = "0.4": '),
    (
        "inertia",
        INERTIA | {"elbow_mass_kg": -1e-9},
        "inertia.elbow_mass_kg = -1e-09: 0 1000",
    ),
    (
        "inertia",
        INERTIA | {"cross_mass_kg": -1001},
        "inertia.cross_mass_kg = -1001: -1000",
    ),
    (
        "inertia",
        INERTIA | {"joint_inertia_kg_m2": 2000},
        "inertia.joint_inertia_kg_m2 = 2000: 0",
    ),
    ("inertia", {"carried_mass_kg": 0.1}, "inertia.elbow_mass_kg: 0 1000"),
    ("inertia", INERTIA | {"speed": 1}, "inertia.speed = 1: carried_mass_kg elbow_mass_kg"),
    ("inertia", 3, "inertia = 3: "),
    ("requirements.force_N", 1e-9, "requirements.force_N = 1e-09: 1e-06 1000"),
    ("requirements.joint_torque_N_m", 1e-9, "requirements.joint_torque_N_m = 1e-09: 1e-06 100"),
    ("step_3.half_side_mm", 120, "step_3.half_side_mm = 120.0: bounds_mm.half_side 0 100"),
    ("step_3.half_side_mm", 0, "step_3.half_side_mm = 0: 0 1000"),
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
    with pytest.raises(RequirementsError) as caught:
        requirements_from_dict(data, "task.toml")
    text = str(caught.value)
    assert text.startswith("task.toml: ")
    assert holds(text, words)
    assert "\n" not in text


def test_all_faults_of_a_file_are_told_at_once() -> None:
    data = contract() | {"speed": 1, "step_3": {"half_side_mm": 120}}
    data["requirements"] |= {"force_N": -1, "peak_torque_N_m": 0.7}
    del data["requirements"]["envelope_width_mm"]
    data["bounds_mm"] |= {"base_radius": [0, 2000], "platform_radius": [45, 20]}
    data["limits"] = {"kappa_max": float("nan"), "gravity_torque_N_m": 0.9}
    with pytest.raises(RequirementsError) as caught:
        requirements_from_dict(data, "task.toml")
    assert sorted(line.split(": ")[1].split(" = ")[0] for line in caught.value.lines) == [
        "bounds_mm.base_radius[0]",
        "bounds_mm.base_radius[1]",
        "bounds_mm.platform_radius",
        "limits.gravity_torque_N_m",
        "limits.kappa_max",
        "requirements.envelope_width_mm",
        "requirements.force_N",
        "requirements.peak_torque_N_m",
        "speed",
        "step_3.half_side_mm",
    ]


def test_fields_of_the_second_edition_are_told_as_such() -> None:
    data = contract() | {"goal": {"maximize": "cube_side"}}
    data["requirements"] |= {"cube_side_mm": 75}
    with refuses(RequirementsError, "requirements.cube_side_mm = 75: envelope_width_mm") as caught:
        requirements_from_dict(data, "task.toml")
    assert [getattr(caught.value, "lines", ())[k].count("second edition") for k in (0, 1)] == [1, 1]


def test_units_are_understood_in_the_first_edition_too() -> None:
    stated = contract()
    stated["requirements"] |= {"envelope_width_mm": "27 cm", "joint_torque_N_m": "800 mNm"}
    stated["bounds_mm"]["base_radius"] = ["4 cm", 40]
    assert requirements_from_dict(stated) == requirements_from_dict(contract())
    assert requirements_hash(requirements_from_dict(stated)) == requirements_hash(requirements_from_dict(contract()))


def test_hardware_is_told_with_the_rest_and_may_have_units(tmp_path: Path) -> None:
    text = JOYSTICK.read_text(encoding="utf-8")
    path = tmp_path / "task.toml"
    path.write_text(f'{text}\n[hardware]\nsector_radius_mm = "4 cm"\n', encoding="utf-8")
    assert load_requirements(path).hardware_from(tmp_path) == {"sector_radius_mm": 40.0}
    wrong = text.replace("force_N = 3.0", "force_N = 0")
    path.write_text(f'{wrong}\n[hardware]\nmotor = "x"\ncapstan_ratio = [5, 99]\n', encoding="utf-8")
    with pytest.raises(RequirementsError) as caught:
        load_requirements(path)
    fields = [line.split(": ")[1].split(" = ")[0] for line in caught.value.lines]
    assert fields == ["requirements.force_N", "hardware.motor", "hardware.capstan_ratio"]


def test_a_value_that_is_no_table_is_refused() -> None:
    with refuses(RequirementsError, "1", "2"):
        requirements_from_dict([1, 2])


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"name = \xff", "task.toml: 7"),
        (b"name = ", "task.toml: "),
        (b"name = 'a'\nname = 'b'", "task.toml: "),
        (b"name = " + b"1" * 5000, "task.toml: 4300"),
        (b"name = " + b"[" * 100_000, "task.toml: "),
        (b"[" + b"a." * 800 + b"a]", "task.toml: 32"),
        (b"name = 0x" + b"f" * 5000, "task.toml: name"),
        (b'"\\u001b[2J\\u202e\\n" = 1', "task.toml: "),
        (b"name = '" + b" " * 1_000_000 + b"'", "task.toml: 1"),
    ],
    ids=["encoding", "syntax", "twice", "digits", "nested", "dotted", "hexadecimal", "escapes", "large"],
)
def test_unreadable_file_is_refused(tmp_path: Path, content: bytes, words: str) -> None:
    file = tmp_path / "task.toml"
    file.write_bytes(content)
    with refuses(RequirementsError, words) as caught:
        load_requirements(file)
    assert str(caught.value).isprintable()


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with refuses(RequirementsError, "none.toml"):
        load_requirements(tmp_path / "none.toml")


@pytest.mark.parametrize("file", [JOYSTICK, COMMITTED], ids=["former", "committed"])
def test_every_variable_has_bounds_in_the_files(file: Path) -> None:
    assert list(tomllib.loads(file.read_text())["bounds_mm"]) == list(Bounds.model_fields)


def test_reading_loads_neither_cad_nor_solvers() -> None:
    code = (
        "import sys, optimizer.problem.requirements as r; r.load_requirements(sys.argv[1]);"
        "print([m for m in ('cadquery', 'OCP', 'scipy', 'pymoo', 'numba') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(JOYSTICK)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
