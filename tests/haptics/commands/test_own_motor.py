"""A motor of the user's own of which only the required columns are stated goes through every command."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import delta_cad.commands.cli
import haptics.model.machine
from delta_cad.catalogue import CatalogueError, own_parts
from delta_cad.design import load_design
from delta_cad.structure.hardware.refusals import refusals
from haptics.commands.cli import main
from haptics.feel.field import Drive
from haptics.feel.holds import holds
from optimizer.codesign.candidate import design_for
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import continuous_torque_N_m
from optimizer.problem.brief import brief_from_dict
from tests.committed import DATA
from tests.delta_cad.catalogue.test_own import MOTOR, written
from tests.haptics.scene_machine import scene_machine

RE_30 = {
    "diameter_mm": "30",
    "length_mm": "68",
    "shaft_diameter_mm": "5",
    "shaft_length_mm": "15.7",
    "pilot_diameter_mm": "15",
    "mass_g": "260",
    "mount_count": "6",
    "rotor_inertia_kg_m2": "3.33e-06",
    "torque_constant_N_m_A": "0.0259",
    "resistance_ohm": "0.611",
}
ROW = MOTOR | RE_30 | {"nominal_torque_N_m": "0.2"}
PEAK_FORCE_N = 4.8  # what the shaft's load of a motor that states none allows


def own_design(folder: Path, **cells: str) -> Path:
    """The machine that the tests know with the own motor, and its folder of parts beside it."""
    written(folder / "parts", motor=ROW | cells)
    data = json.loads(json.dumps(DATA))
    data["hardware"] |= {"catalogue": "parts", "motor": ROW["id"]}
    data["requirements"]["peak_force_N"] = PEAK_FORCE_N
    (folder / "own.json").write_text(json.dumps(data))
    return folder / "own.json"


@pytest.fixture
def design(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = own_design(tmp_path)
    monkeypatch.setattr(haptics.model.machine, "load_machine", lambda *_: scene_machine(load_design(path)))
    monkeypatch.chdir(tmp_path)
    return path


def test_it_is_inspected_and_its_closed_forms_refuse_nothing(design: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert delta_cad.commands.cli.main(["inspect", "--design", str(design), "--json"]) == 0
    rows = {row["quantity"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
    lasting, peak = rows["joint torque, continuous"], rows["joint torque, 1 s"]
    assert lasting["value"] == peak["value"] == pytest.approx(4.8 * 0.96 * 0.2)  # no peak is stated: the continuous one


@pytest.mark.parametrize(
    "words",
    [
        # a minute and 6 s; what a peak enters of it is `holds`, below
        pytest.param(["feel"], marks=pytest.mark.slow),
        pytest.param(["stiffness"], marks=pytest.mark.slow),
        ["simulate", "--scene", "home"],
        ["firmware", "--out", "c"],
        ["interfaces", "--out", "i"],
        ["gravity"],
        ["gravity", "--point-masses", "60,50,20"],
    ],
    ids=" ".join,
)
def test_every_command_takes_it(design: Path, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main([words[0], "--design", str(design), *words[1:]]) in (0, 1)
    assert "Traceback" not in capsys.readouterr().err


def test_its_force_may_be_held_for_a_time_that_is_not_known(design: Path) -> None:
    machine = haptics.model.machine.load_machine(design)
    torque = machine.drive.continuous_torque_N_m
    drive = Drive(
        continuous=torque, peak=torque, motor=torque, coulomb=0.0, count=1e-5, step=1e-3, ripple=0.0, cogging=0.0
    )
    (only,) = holds(machine, drive, machine.centre[None])
    assert (only.torque, only.limit, only.derate, only.warm) == (torque, None, None, None)


def test_the_closed_forms_of_a_design_s_search_take_it(design: Path) -> None:
    brief = brief_from_dict(
        {
            "name": "own",
            "requirements": {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0, "peak_force_N": PEAK_FORCE_N},
            "hardware": {"catalogue": "parts", "motor": ROW["id"]},
        },
        folder=design.parent,
    )
    choice, known = Selection(ROW["id"], "capstan", 4.8, 54.0), Corrections(reference())
    lasting = continuous_torque_N_m(brief, choice, known)
    assert 0.0 < lasting <= 4.8 * 0.96 * 0.2
    found = design_for(brief, choice, (91.0, 143.0, 31.0, 24.0, 64.0, 42.0), known, design.parent)
    assert found.requirements.peak_torque_N_m == pytest.approx(found.requirements.joint_torque_N_m)
    assert list(refusals(load_design(design))) == []


def test_a_motor_without_a_pilot_is_a_row_and_no_machine(tmp_path: Path) -> None:
    path = own_design(tmp_path, pilot_diameter_mm="0", pilot_height_mm="0")
    (reason,) = refusals(load_design(path))
    assert (reason.part, reason.feature, reason.field) == ("motor_cheek", "pilot bore", "hardware.motor")
    assert "pilot_diameter_mm = 0: must be > 0" in reason.message


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        ({"pilot_diameter_mm": "0"}, "both or neither of pilot_diameter_mm and pilot_height_mm"),
        ({"pilot_height_mm": "0"}, "both or neither of pilot_diameter_mm and pilot_height_mm"),
        ({"pilot_diameter_mm": "4"}, "a motor without a pilot has 0 as its diameter and height"),
        ({"pilot_diameter_mm": "0", "pilot_height_mm": "0", "mount_circle_mm": "4"}, "shaft_diameter_mm < pilot"),
    ],
)
def test_a_pilot_that_is_none_is_refused(cells: dict[str, str], words: str, tmp_path: Path) -> None:
    with pytest.raises(CatalogueError, match=words):
        own_parts(written(tmp_path, motor=ROW | cells))
