"""The requirements file: what is accepted, what is refused and with which words."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from delta_cad.mechanism.limits import HandleFriction, HandleInertia
from optimizer.problem.requirements import (
    RequirementsError,
    load_requirements,
    requirements_from_dict,
    requirements_hash,
)
from optimizer.problem.variables import LENGTHS
from tests.optimizer.messages import holds, refuses
from tests.optimizer.problem.requirements import COMMITTED, JOYSTICK, fields, first_edition, lines_of_requirements
from tests.optimizer.tasks import INERTIA


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
    given = requirements_from_dict(first_edition())
    assert given.bounds_mm.forearm_length == (40.0, 130.0)
    assert given.limits.outline_radius_max_mm is None
    assert given.limits.gravity_torque_N_m == 0.0
    assert given.step_3.half_side_mm is None


def test_what_a_machine_must_bear_is_required_where_it_is_stated() -> None:
    given = requirements_from_dict(first_edition())
    names = ("peak_force_N", "peak_torque_N_m", "stiffness_min_N_mm")
    assert [getattr(given.requirements, name) for name in names] == [None] * 3
    for numbers in ((9.0, 1.5, 8.0), (3.0, 0.8, 8.0)):  # a peak may be what holds for ever
        stated = first_edition()
        stated["requirements"] |= dict(zip(names, numbers, strict=True))
        required = requirements_from_dict(stated).requirements
        assert tuple(getattr(required, name) for name in names) == numbers


def test_hash_sees_every_number_but_not_the_spelling_of_defaults() -> None:
    given = requirements_from_dict(first_edition())
    spelled = requirements_from_dict(first_edition() | {"limits": {"gravity_torque_N_m": 0.0}, "step_3": {}})
    other = first_edition()
    other["bounds_mm"]["half_side"] = [0, 100.00000001]
    assert requirements_hash(spelled) == requirements_hash(given)
    assert requirements_hash(requirements_from_dict(other)) != requirements_hash(given)


def test_hash_leaves_out_what_is_not_stated_and_sees_each_number_of_the_masses() -> None:
    """A limit that is added to the program changes no hash."""
    required = first_edition() | {"limits": {"effective_mass_max_kg": 0.4}, "inertia": INERTIA}
    hashes = {requirements_hash(requirements_from_dict(data)) for data in (first_edition(), required)}
    for name in INERTIA:
        changed = required | {"inertia": INERTIA | {name: 0.0123}}
        hashes.add(requirements_hash(requirements_from_dict(changed)))
    assert len(hashes) == 2 + len(INERTIA)
    text = json.dumps(requirements_from_dict(first_edition()).model_dump(mode="json", exclude_none=True))
    assert "null" not in text
    assert "inertia" not in text
    assert "effective_mass" not in text


def test_an_effective_mass_is_required_with_its_masses() -> None:
    given = requirements_from_dict(first_edition() | {"limits": {"effective_mass_max_kg": 0.4}, "inertia": INERTIA})
    assert given.limits.effective_mass_max_kg == 0.4
    assert given.values["inertia"] == HandleInertia(*INERTIA.values())
    assert requirements_from_dict(first_edition() | {"inertia": INERTIA}).limits.effective_mass_max_kg is None
    assert requirements_from_dict(first_edition()).values["inertia"] is None


def test_what_is_felt_of_the_joints_is_required_with_what_they_are() -> None:
    required = {"friction_max_N": 0.7, "position_step_max_mm": "80 um"}
    joints = {"friction_N_m": "12 mN m", "ball_upright_N": 0.05, "encoder_count_deg": 0.022}
    given = requirements_from_dict(first_edition() | {"limits": required, "joints": joints})
    assert given.limits.position_step_max_mm == pytest.approx(0.08)
    assert given.values["friction"] == HandleFriction(0.012, 0.05, 0.0)
    assert given.values["encoder_count"] == pytest.approx(0.022 * math.pi / 180.0)
    plain = requirements_from_dict(first_edition())
    assert plain.values["friction"] is plain.values["encoder_count"] is None


def test_all_faults_of_a_file_are_reported_at_once() -> None:
    data = first_edition() | {"speed": 1, "step_3": {"half_side_mm": 120}}
    data["requirements"] |= {"force_N": -1, "peak_torque_N_m": 0.7}
    del data["requirements"]["envelope_width_mm"]
    data["bounds_mm"] |= {"base_radius": [0, 2000], "platform_radius": [45, 20]}
    data["limits"] = {"kappa_max": float("nan"), "gravity_torque_N_m": 0.9}
    assert sorted(fields(lines_of_requirements(data))) == [
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


def test_fields_of_the_second_edition_are_reported_as_such() -> None:
    data = first_edition() | {"goal": {"maximize": "cube_side"}}
    data["requirements"] |= {"cube_side_mm": 75}
    found = lines_of_requirements(data)
    assert holds(found[0], "requirements.cube_side_mm = 75: envelope_width_mm")
    assert [line.count("second edition") for line in found] == [1, 1]


def test_units_are_understood_in_the_first_edition_too() -> None:
    stated = first_edition()
    stated["requirements"] |= {"envelope_width_mm": "27 cm", "joint_torque_N_m": "800 mNm"}
    stated["bounds_mm"]["base_radius"] = ["4 cm", 40]
    assert requirements_from_dict(stated) == requirements_from_dict(first_edition())
    assert requirements_hash(requirements_from_dict(stated)) == requirements_hash(
        requirements_from_dict(first_edition())
    )


def test_hardware_is_reported_with_the_rest_and_may_have_units(tmp_path: Path) -> None:
    text = JOYSTICK.read_text(encoding="utf-8")
    path = tmp_path / "task.toml"
    path.write_text(f'{text}\n[hardware]\nsector_radius_mm = "4 cm"\n', encoding="utf-8")
    assert load_requirements(path).hardware_from(tmp_path) == {"sector_radius_mm": 40.0}
    wrong = text.replace("force_N = 3.0", "force_N = 0")
    path.write_text(f'{wrong}\n[hardware]\nmotor = "x"\ncapstan_ratio = [5, 99]\n', encoding="utf-8")
    with pytest.raises(RequirementsError) as caught:
        load_requirements(path)
    assert fields(list(caught.value.lines)) == ["requirements.force_N", "hardware.motor", "hardware.capstan_ratio"]


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
    assert list(tomllib.loads(file.read_text())["bounds_mm"]) == list(LENGTHS)


def test_reading_loads_neither_cad_nor_solvers() -> None:
    code = (
        "import sys, optimizer.problem.brief as b, optimizer.problem.requirements as r\n"
        "r.load_requirements(sys.argv[1]); b.load_brief(sys.argv[1])\n"
        "print([m for m in ('cadquery', 'OCP', 'scipy', 'pymoo', 'numba') if m in sys.modules])"
    )
    run = subprocess.run([sys.executable, "-c", code, str(JOYSTICK)], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
