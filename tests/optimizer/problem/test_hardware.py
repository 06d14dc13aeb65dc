"""Table `[hardware]` of a requirements file: what it may name, and the design file that comes of it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.design import design_from_dict, load_design
from optimizer.problem.brief import brief_from_dict
from optimizer.problem.requirements import (
    Requirements,
    RequirementsError,
    load_requirements,
    requirements_from_dict,
    requirements_hash,
)
from optimizer.search.result import Result
from optimizer.synthesis.output import DesignFile, design_of
from optimizer.synthesis.three_step import Run
from tests.committed import ROOT
from tests.optimizer.problem.requirements import ROPE

JOYSTICK = (ROOT / "tests/references/joystick.toml").read_text(encoding="utf-8")


def task(folder: Path, hardware: str) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "task.toml"
    path.write_text(f"{JOYSTICK}\n[hardware]\n{hardware}\n", encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def solved() -> list[Result]:
    return Run(load_requirements(ROOT / "tests/references/joystick.toml"), "sqp", seed=1).results()


def test_the_first_of_what_may_be_used_stands_in_the_design(tmp_path: Path, solved: list[Result]) -> None:
    stated = 'motor = ["faulhaber-3257g024cr", "maxon-re30-310007"]\ndrive = "capstan"\ncapstan_ratio = 12.0'
    given = load_requirements(task(tmp_path, stated))
    design = design_of(given, solved, "sqp", 1, "d.json")
    assert (design.hardware.motor, design.hardware.capstan_ratio) == ("faulhaber-3257g024cr", 12.0)
    assert design.hardware.cable == "steel-0.54-7x7"  # the default


def test_own_parts_are_named_from_where_the_design_file_stands(tmp_path: Path, solved: list[Result]) -> None:
    """The folder is beside the requirements; the design goes elsewhere, and is read from there."""
    path = task(tmp_path / "task", 'catalogue = "my-parts"\ncable = "mine"')
    (path.parent / "my-parts").mkdir()
    (path.parent / "my-parts" / "cable.csv").write_text(ROPE, encoding="utf-8")
    given, out = load_requirements(path), tmp_path / "out" / "deep" / "d.json"
    out.parent.mkdir(parents=True)
    design = design_of(given, solved, "sqp", 1, out.name, folder=out.parent)
    assert design.hardware.catalogue == "../../task/my-parts"
    DesignFile(out, given).finish(design)
    again = load_design(out)
    assert again == design
    assert catalogue.cable.chosen(again.hardware).breaking_load_N == 150.0


def test_a_folder_given_by_hand_takes_the_place_of_the_named_one(tmp_path: Path, solved: list[Result]) -> None:
    parts = tmp_path / "parts"
    parts.mkdir()
    (parts / "cable.csv").write_text(ROPE, encoding="utf-8")
    path = task(tmp_path / "task", 'catalogue = "nowhere"\ncable = "mine"')
    given = load_requirements(path, parts)
    assert given.hardware_from(tmp_path) == {"catalogue": "parts", "cable": "mine"}
    assert design_of(given, solved, "sqp", 1, "d.json", folder=tmp_path).hardware.cable == "mine"
    with pytest.raises(RequirementsError, match="nowhere"):
        load_requirements(path)


def test_a_task_without_hardware_stays_the_task_that_it_was() -> None:
    """Checkpoints and designs are known by this hash."""
    given = load_requirements(ROOT / "tests/references/joystick.toml")
    assert given.hardware_from(Path()) == {}
    assert requirements_hash(given) == "3ccdceaa83bffeed207260aa487bb017fc8efd37980fb282e7b92eff62ea33aa"


def test_another_motor_is_another_task(tmp_path: Path) -> None:
    keys = [key for key, row in catalogue.motor.rows.items() if "capstan" in row.drives]
    assert len(
        {requirements_hash(load_requirements(task(tmp_path, f'motor = "{key}"\ncapstan_ratio = 5'))) for key in keys}
    ) == len(keys)


@pytest.mark.parametrize(
    ("stated", "field", "words"),
    [
        ('motor = "unobtainium"', "hardware.motor", ["unobtainium", "maxon-re30-310007"]),
        ('motor = ["maxon-re30-310007", "unobtainium"]', "hardware.motor", ["unobtainium"]),
        ('motor = "maxon-ec60flat-625858"', "hardware.motor", ["capstan"]),
        ('motor = "maxon-re50-370354"\ncapstan_ratio = 9.4', "hardware.capstan_ratio", ["9.4", "< 9.36768"]),
        ("motor = []", "hardware.motor", ["at least one"]),
        ('belt = "x"', "hardware.belt", ["unknown key", "motor"]),
        ("capstan_ratio = 1.0", "hardware.capstan_ratio", ["1.0", ">= 2"]),
        ("capstan_ratio = [9.0, 99.0]", "hardware.capstan_ratio", ["99.0", "<= 30"]),
        ('catalogue = "none"', "hardware.catalogue", ["none: cannot be read"]),
        ("motor = 2026-01-01", "hardware.motor", ["text"]),
    ],
)
def test_hardware_that_no_design_can_name_is_refused_before_any_search(
    stated: str, field: str, words: list[str], tmp_path: Path
) -> None:
    with pytest.raises(RequirementsError) as caught:
        load_requirements(task(tmp_path, stated))
    assert caught.value.file == "task.toml"
    assert caught.value.field.startswith(field)
    assert all(word in str(caught.value) for word in words), str(caught.value)


def test_a_motor_of_another_drive_may_stand_further_down_the_list(tmp_path: Path) -> None:
    given = load_requirements(task(tmp_path, 'motor = ["maxon-re30-310007", "maxon-ec60flat-625858"]'))
    assert given.hardware_from(tmp_path) == {"motor": "maxon-re30-310007"}


def test_a_table_of_another_shape_is_refused_wherever_it_comes_from() -> None:
    data: dict[str, Any] = load_requirements(ROOT / "tests/references/joystick.toml").model_dump(exclude_none=True)
    with pytest.raises(RequirementsError) as caught:
        requirements_from_dict(data | {"hardware": 3})
    assert caught.value.field == "hardware"
    assert isinstance(requirements_from_dict(data | {"hardware": {"motor": "x"}}), Requirements)  # an atlas names none


def test_design_from_dict_reads_own_parts_from_a_folder(tmp_path: Path) -> None:
    (tmp_path / "cable.csv").write_text(ROPE, encoding="utf-8")
    data = load_design(ROOT / "examples" / "synthesized.json").model_dump(mode="json", by_alias=True, exclude_none=True)
    data["hardware"]["cable"] = "mine"
    assert design_from_dict(data, own_parts=tmp_path).hardware.cable == "mine"


def test_a_folder_of_own_parts_that_a_command_names_and_is_none_is_refused(tmp_path: Path) -> None:
    data = {"name": "d", "requirements": {"envelope_width_mm": 270, "envelope_depth_mm": 220, "force_N": 3}}
    with pytest.raises(RequirementsError, match=r"must be a folder with some of motor\.csv"):
        brief_from_dict(data, own_parts=tmp_path / "none")
