"""The customer's brief: what is enough, what follows where nothing is stated, what is refused and all at once."""

from __future__ import annotations

import copy
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.design import Hardware, hardware_from_dict
from delta_cad.mechanism.limits import LIMITS, Limits
from optimizer.problem.brief import (
    FEEL,
    MOVED,
    BriefBounds,
    BriefLimits,
    BriefRequirements,
    Feel,
    brief_from_dict,
    brief_hash,
    load_brief,
)
from optimizer.problem.requirements import Bounds, LimitTable, RequirementsError, load_requirements
from optimizer.problem.validation import MOST_REPORTED
from tests.committed import ROOT
from tests.optimizer.problem.requirements import (
    COMMITTED,
    CUBE,
    JOYSTICK,
    OUTLINE,
    ROPE,
    brief,
    fields,
    lines_of_brief,
    second_edition,
)

FIRST = [COMMITTED, JOYSTICK]


def test_the_example_of_the_contract_is_read(tmp_path: Path) -> None:
    path = tmp_path / "r.toml"
    path.write_text(
        'name = "dashboard-joystick"\n[requirements]\nenvelope_width_mm = 270\nenvelope_depth_mm = 220\nforce_N = 3\n'
        "peak_force_N = 8\ncube_side_mm = 75\nclearance_min_mm = 2\n[feel]\nkappa_max = 2.27\n"
        "effective_mass_max_kg = 0.4\nfriction_max_N = 0.7\nstiffness_min_N_mm = 8\n[hardware]\n"
        'motor = ["maxon-re30-310007"]\ndrive = ["capstan"]\ncatalogue = "my-parts"\n[goal]\nmaximize = "cube_side"\n'
    )
    (tmp_path / "my-parts").mkdir()
    (tmp_path / "my-parts" / "cable.csv").write_text(ROPE)
    given = load_brief(path)
    assert given.outline_mm == (270.0, 220.0)
    assert given.requirements.cube_side_mm == 75.0
    assert (given.feel.friction_max_N, given.feel.stiffness_min_N_mm) == (0.7, 8.0)
    assert given.objective == "cube_side"
    assert given.choices["motor"] == ("maxon-re30-310007",)
    assert "mine" in given.choices["cable"]
    assert given.notes == ()


def test_examples_of_the_page_are_read() -> None:
    page = (ROOT / "optimizer" / "README.md").read_text(encoding="utf-8")
    examples = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    assert len(examples) == 1
    given = brief_from_dict(tomllib.loads(examples[0]))
    assert given.outline_mm == (270.0, 220.0)
    assert all(getattr(given.feel, name) is not None for name in FEEL)


def test_the_example_behind_a_panel_is_read() -> None:
    given = load_brief(ROOT / "examples/dashboard-panel.toml")
    assert given.panel is not None
    assert given.panel.limit_mm == 3.0
    assert given.choices["leads"] == ("bent",)


def test_a_name_and_an_outline_or_a_cube_are_enough() -> None:
    wide, cubic = brief(requirements=OUTLINE), brief(requirements=CUBE)
    assert wide.requirements.cube_side_mm is None
    assert cubic.outline_mm is None
    for given in (wide, cubic):
        task = given.requirements
        assert (task.force_N, task.clearance_min_mm, task.gravity_m_s2) == (3.0, 2.0, (0.0, 0.0, -9.81))
        assert (task.peak_force_N, task.joint_torque_N_m, task.peak_torque_N_m) == (None, None, None)
        assert set(given.feel.model_dump().values()) == {None}
        assert set(given.bounds_mm.model_dump().values()) == {None}
        assert set(given.limits.model_dump().values()) == {None}
        assert given.hardware == {}


@pytest.mark.parametrize(
    ("task", "goal", "objective"),
    [
        (OUTLINE, {}, "cube_side"),
        (CUBE, {}, "outline"),
        (OUTLINE | CUBE, {}, "cube_side"),
        (OUTLINE | CUBE, {"maximize": "cube_side"}, "cube_side"),
        *((OUTLINE | CUBE, {"minimize": what}, what) for what in ("effective_mass", "outline", "cost")),
        *((CUBE, {"minimize": what}, what) for what in ("effective_mass", "outline", "cost")),
    ],
)
def test_the_goal_follows_where_none_is_stated(task: dict[str, Any], goal: dict[str, str], objective: str) -> None:
    for stated in (brief(requirements=task, goal=goal), brief(requirements=task, **({"goal": goal} if goal else {}))):
        assert stated.objective == objective
        assert (stated.goal.maximize is None) != (stated.goal.minimize is None)


@pytest.mark.parametrize("path", FIRST, ids=["committed", "former"])
def test_a_file_of_the_first_edition_is_a_brief_too(path: Path) -> None:
    old, new = load_requirements(path), load_brief(path)
    assert new.outline_mm == (old.requirements.envelope_width_mm, old.requirements.envelope_depth_mm)
    assert new.bounds_mm.model_dump() == old.bounds_mm.model_dump()
    assert new.feel.kappa_max == old.limits.kappa_max
    assert new.feel.couple_index_min == old.limits.couple_index_min
    assert new.feel.stiffness_min_N_mm == old.requirements.stiffness_min_N_mm
    assert new.requirements.clearance_min_mm == old.limits.clearance_min_mm
    assert new.limits.shoulder_deg == old.limits.shoulder_deg
    assert new.limits.parallelogram_width_mm == old.limits.parallelogram_width_mm
    assert new.objective == "cube_side"
    assert any("limits.joint_diameter_mm" in note for note in new.notes)
    unused = {"outline_overhead_mm", "joint_diameter_mm", "gravity_torque_N_m", "ball_diameter_mm"}
    own = {name: value for name, value in old.values.items() if value is not None and name != "shoulder_deg"}
    assert new.values == {name: value for name, value in own.items() if name not in unused}


def test_a_number_is_in_one_place_wherever_the_file_has_it() -> None:
    new = second_edition()
    new["requirements"] |= {"gravity_m_s2": [0, 9.81, 0]}
    new["feel"]["couple_index_min"] = 0.4
    old = copy.deepcopy(new)
    del old["feel"], old["requirements"]["clearance_min_mm"], old["requirements"]["gravity_m_s2"]
    old["requirements"]["stiffness_min_N_mm"] = 8
    old["limits"] = {"kappa_max": 2.27, "effective_mass_max_kg": 0.4, "couple_index_min": 0.4, "clearance_min_mm": 2}
    old["limits"] |= {"gravity_m_s2": [0, 9.81, 0], "friction_max_N": 0.7}
    a, b = brief_from_dict(new), brief_from_dict(old)
    assert a == b
    assert brief_hash(a) == brief_hash(b)
    assert set(b.limits.model_dump().values()) == {None}
    for field in MOVED:
        table, name = field.split(".")
        assert getattr(getattr(b, table), name) is None
    masses = {"inertia": None, "effective_mass_max_kg": None}
    assert Limits.stated({**a.values, **masses, "joint_torque_N_m": 0.4, "friction": (0.01, 0.0, 0.0)})["kappa"]


def test_written_out_it_is_read_as_the_same() -> None:
    for path in FIRST:
        given = load_brief(path)
        again = brief_from_dict(given.model_dump(exclude_none=True))
        assert brief_hash(again) == brief_hash(given)
        assert again.values == given.values


def test_the_hash_sees_every_number() -> None:
    hashes = {brief_hash(brief(requirements=OUTLINE))}
    for table, name, value in (
        ("requirements", "force_N", 3.0000001),
        ("requirements", "peak_force_N", 5),
        ("feel", "friction_max_N", 0.7),
        ("limits", "lean_max_deg", 28),
        ("bounds_mm", "base_radius", [30, 31]),
        ("hardware", "capstan_ratio", 5),
        ("name", "", "e"),
    ):
        data: dict[str, Any] = {"name": "d", "requirements": dict(OUTLINE)}
        data = data | {table: data.get(table, {}) | {name: value}} if name else data | {table: value}
        hashes.add(brief_hash(brief_from_dict(data)))
    assert len(hashes) == 8


def test_fields_are_those_of_the_limits_and_of_the_first_edition() -> None:
    """A limit that is added has its field in `[limits]` at once, and in `[feel]` once it is named there."""
    assert tuple(Feel.model_fields) == FEEL
    declared = {field.name for limit in LIMITS for field in limit.fields_} - {"shoulder_min_deg", "shoulder_max_deg"}
    assert declared <= set(BriefLimits.model_fields)
    assert set(BriefLimits.model_fields) == set(LimitTable.model_fields)
    assert set(BriefBounds.model_fields) == set(Bounds.model_fields)
    assert {new.split(".")[1] for new in MOVED.values()} <= {*Feel.model_fields, *BriefRequirements.model_fields}


def test_what_the_first_edition_states_and_design_does_not_use_is_lines_of_brief() -> None:
    masses = {"carried_mass_kg": 0.1, "elbow_mass_kg": 0.1, "cross_mass_kg": 0.0, "joint_inertia_kg_m2": 1e-4}
    limits = {"joint_diameter_mm": 8, "outline_overhead_mm": [1, 1], "gravity_torque_N_m": 0.1}
    joints = {"friction_N_m": 0.01}
    given = brief(requirements=OUTLINE, step_3={"half_side_mm": 30}, inertia=masses, joints=joints, limits=limits)
    unused = (
        "limits.outline_overhead_mm",
        "limits.joint_diameter_mm",
        "limits.gravity_torque_N_m",
        "step_3",
        "inertia",
        "joints",
    )
    assert [note.split()[0] for note in given.notes] == list(unused)
    assert brief(requirements=OUTLINE, limits={"lean_max_deg": 28}).notes == ()


def test_units_are_understood_wherever_a_number_stands() -> None:
    plain = brief(
        requirements={"cube_side_mm": 120, "force_N": 3, "gravity_m_s2": [0, 0, -9.81], "joint_torque_N_m": 0.4},
        feel={"effective_mass_max_kg": 0.3, "stiffness_min_N_mm": 8},
        limits={"shoulder_deg": [-60, 65], "lean_max_deg": 28},
        bounds_mm={"base_radius": [30, 40]},
        hardware={"sector_radius_mm": [38.7, 40.0], "ball_diameter_mm": 6.0},
    )
    texts = brief(
        requirements={
            "cube_side_mm": "12 cm",
            "force_N": "3000 mN",
            "gravity_m_s2": [0, 0, "-9810 mm/s^2"],
            "joint_torque_N_m": "400 mN m",
        },
        feel={"effective_mass_max_kg": "300 g", "stiffness_min_N_mm": "8 kN/m"},
        limits={"shoulder_deg": ["-60 deg", 65], "lean_max_deg": "28°"},
        bounds_mm={"base_radius": ["3 cm", 40]},
        hardware={"sector_radius_mm": ["38.7 mm", "4 cm"], "ball_diameter_mm": "6 mm"},
    )
    assert texts == plain
    assert brief_hash(texts) == brief_hash(plain)


def test_what_may_be_used_is_all_that_is_offered_where_nothing_is_stated() -> None:
    every = brief(requirements=OUTLINE).choices
    offered = [key for key, row in catalogue.family("motor").items() if "none" not in getattr(row, "drives", ())]
    assert every["motor"] == tuple(offered)
    assert every["drive"] == ("capstan", "direct")
    assert "maxon-re25-118752" not in every["motor"]  # its row says that it is offered for no drive
    assert "capstan_ratio" not in every
    for entry in catalogue.CHOSEN:
        assert all(hardware_from_dict({entry: value}, drive_fits=False) for value in every[entry])
    direct = brief(requirements=OUTLINE, hardware={"drive": "direct", "capstan_ratio": [4, 5]}).choices
    assert direct["drive"] == ("direct",)
    assert all("direct" in catalogue.motor(motor).drives for motor in direct["motor"])
    assert direct["capstan_ratio"] == (4, 5)
    mixed = brief(requirements=OUTLINE, hardware={"motor": "maxon-ec60flat-625858"})  # free drive: direct, no fault
    assert (mixed.choices["motor"], mixed.choices["drive"]) == (("maxon-ec60flat-625858",), ("direct",))


def test_own_parts_are_named_from_where_the_design_stands(tmp_path: Path) -> None:
    folder, out = tmp_path / "task", tmp_path / "out" / "d"
    (folder / "parts").mkdir(parents=True)
    out.mkdir(parents=True)
    (folder / "parts" / "cable.csv").write_text(ROPE)
    data = {"name": "d", "requirements": OUTLINE, "hardware": {"catalogue": "parts", "cable": ["mine"]}}
    given = brief_from_dict(data, "r.toml", folder)
    assert given.choices["cable"] == ("mine",)
    stated = given.hardware_from(out, {"motor": "maxon-re30-310009", "capstan_ratio": 5.0})
    assert stated == {
        "catalogue": "../../task/parts",
        "cable": "mine",
        "motor": "maxon-re30-310009",
        "capstan_ratio": 5.0,
    }
    assert hardware_from_dict(stated, folder=out).cable == "mine"
    by_hand = brief_from_dict(data | {"hardware": {"cable": "mine"}}, "r.toml", tmp_path, folder / "parts")
    assert by_hand.hardware_from(out, {})["catalogue"] == "../../task/parts"


def test_all_that_is_wrong_is_reported_at_once() -> None:
    found = lines_of_brief(
        {
            "name": "../up",
            "requirements": {
                "envelope_width_mm": "270 kg",
                "cube_side_mm": -1,
                "force_N": "three",
                "peak_force_N": float("inf"),
                "gravity_m_s2": [0, 0],
                "joint_torque_N_m": 0.4,
                "peak_torque_N_m": 0.3,
                "clearance_min_mm": 2,
            },
            "feel": {"kappa_max": 0, "hardness": 1},
            "limits": {"clearance_min_mm": 2, "shoulder_deg": [20, 10]},
            "bounds_mm": {"base_radius": [2, 1], "platform_radius": [0.5, "2000 mm"]},
            "goal": {"minimize": "weight"},
            "hardware": {"motor": "x", "drive": "belt", "capstan_ratio": 1},
            "speed": 3,
        }
    )
    assert sorted(fields(found)) == sorted(
        [
            "name",
            *(f"requirements.{f}" for f in ("envelope_width_mm", "cube_side_mm", "force_N", "peak_force_N")),
            "requirements.gravity_m_s2[2]",
            "requirements.peak_torque_N_m",
            "feel.kappa_max",
            "feel.hardness",
            "limits.clearance_min_mm",
            "limits.shoulder_deg",
            "bounds_mm.base_radius",
            "bounds_mm.platform_radius[0]",
            "bounds_mm.platform_radius[1]",
            "goal.minimize",
            *(f"hardware.{f}" for f in ("motor", "drive", "capstan_ratio")),
            "speed",
        ]
    )


def test_a_file_of_faults_without_end_is_reported_in_so_many_lines() -> None:
    found = lines_of_brief({"name": "d", "requirements": OUTLINE, "feel": {f"f{k}": k for k in range(1000)}})
    assert len(found) == MOST_REPORTED + 1
    assert "960" in found[-1]


def test_what_is_no_table_is_refused() -> None:
    assert len(lines_of_brief([1])) == 1
    with pytest.raises(RequirementsError) as caught:
        load_brief(ROOT / "nowhere.toml")
    assert caught.value.file == "nowhere.toml"


def test_entries_of_the_hardware_are_those_of_a_design() -> None:
    every = {name: info.get_default() for name, info in Hardware.model_fields.items() if info.get_default() is not None}
    given = brief(requirements=CUBE, hardware={name: [value] for name, value in every.items()})
    assert {name: values[0] for name, values in given.choices.items() if name in every} == every


def test_what_only_a_capstan_has_is_reported_where_all_drives_are_direct() -> None:
    task = {"name": "b", "requirements": {"cube_side_mm": 60.0}}
    direct = brief_from_dict(task | {"hardware": {"drive": "direct", "capstan_ratio": 5.0}})
    (note,) = direct.notes
    assert note.startswith("hardware.capstan_ratio is not used by design")
    assert brief_from_dict(task | {"hardware": {"capstan_ratio": 5.0}}).notes == ()
