"""Bill of materials, manifest; speed, torque and inertia of a joint in robot descriptions, by hand."""

from __future__ import annotations

import csv
import hashlib
import json
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.export.bom import bill_of_materials, write_bom
from delta_cad.export.manifest import ManifestError, versions, write_manifest
from delta_cad.export.mass_properties import mass_report
from delta_cad.export.robot import Robot, sdf, urdf
from delta_cad.export.step import write_assembly_step
from delta_cad.solids.part import Consumable
from tests.delta_cad.export.machine import unit_masses

COLUMNS = (
    "item,part_number,description,quantity,make_or_buy,material,unit_mass_g,total_mass_g,standard,order_code,source,"
    "unit_cost_EUR,total_cost_EUR,cost_source"
)


@pytest.fixture
def build(machine: Assembly, tmp_path: Path) -> Path:
    fingerprint = write_assembly_step(machine, tmp_path / "assembly.step")
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "a.stl").write_bytes(b"abc")
    write_manifest(tmp_path, input_hash="ab" * 32, status="passed", fingerprint=fingerprint)
    return tmp_path


def test_the_bill_counts_every_occurrence_once(machine: Assembly, tmp_path: Path) -> None:
    write_bom(bill_of_materials(machine, unit_masses(machine)), tmp_path)
    text = (tmp_path / "bom.csv").read_bytes().decode()
    assert text.splitlines()[0] == COLUMNS
    assert "\r" not in text
    rows = list(csv.DictReader(text.splitlines()))
    assert {row["part_number"]: int(row["quantity"]) for row in rows} == {
        "base_plate": 1, "platform": 1, "upper_arm": 3, "rod_tube": 6, "ball_8": 6, "motor_30x68": 3,
    }  # fmt: skip
    assert [int(row["item"]) for row in rows] == [1, 2, 3, 4, 5, 6]
    assert [row["make_or_buy"] for row in rows] == ["make"] * 4 + ["buy"] * 2
    motor = next(row for row in rows if row["part_number"] == "motor_30x68")
    assert motor["description"] == "Motor 30 x 68, 60 W"
    assert (motor["unit_mass_g"], motor["total_mass_g"], motor["order_code"]) == ("240.0", "720.0", "M-30")


def test_the_bill_adds_up_to_the_mass_of_the_machine(machine: Assembly, tmp_path: Path) -> None:
    rows = bill_of_materials(machine, unit_masses(machine))
    for row in rows:
        assert row.total_mass_g == pytest.approx(row.quantity * row.unit_mass_g, abs=1e-9)
    whole_g = mass_report(machine)["total_mass_kg"] * 1000
    # each of the 20 occurrences is rounded to 0.1 mg
    assert sum(row.total_mass_g for row in rows) == pytest.approx(whole_g, abs=20 * 0.5e-4)
    write_bom(rows, tmp_path)
    listed = json.loads((tmp_path / "bom.json").read_text())
    assert listed["items"][0].keys() == set(COLUMNS.split(","))
    assert sum(item["total_mass_g"] for item in listed["items"]) == pytest.approx(whole_g, abs=20 * 0.5e-4)


def test_given_masses_are_used(machine: Assembly) -> None:
    masses = {part.number: 0.5 for part in machine.parts}
    assert {row.unit_mass_g for row in bill_of_materials(machine, masses)} == {500.0}


def test_the_manifest_lists_every_file_with_its_digest(build: Path, step_file: Path) -> None:
    from delta_cad.export.fingerprint import canonical

    manifest = json.loads((build / "manifest.json").read_text())
    assert set(manifest["files"]) == {"assembly.step", "parts/a.stl"}
    for name, entry in manifest["files"].items():
        data = (build / name).read_bytes()
        assert entry == {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
    assert manifest["step_fingerprint"] == canonical(step_file.read_bytes())[1]
    assert manifest["status"] == "passed"
    assert manifest["input_sha256"] == "ab" * 32


def test_versions_name_the_kernel() -> None:
    from importlib.metadata import version

    found = versions()
    assert version("cadquery-ocp").startswith(found["occt"])
    assert found["occt"].count(".") == 2
    assert found["cadquery"] == version("cadquery")


def test_a_package_that_is_not_there_is_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("delta_cad.export.manifest.PACKAGES", ("no-such-package",))
    assert versions()["no-such-package"] == "not installed"


def test_an_unknown_status_is_refused(build: Path) -> None:
    with pytest.raises(ManifestError, match="good"):
        write_manifest(build, input_hash="", status="good", fingerprint="")


@pytest.fixture(scope="module")
def robot(machine: Assembly, best: Design) -> Robot:
    """RE 30 at 4.8 : 1 on simple solids."""
    return Robot(machine, mass_report(machine)["bodies"], drive_torque(best), (-1.1, 1.0), (0.012, 3e-4))


def test_supplies_weigh_what_one_weighs_times_their_number(machine: Assembly) -> None:
    grease = Consumable("grease", "Grease", 3, "PTFE grease", 2.5, "", "", "")
    rows = bill_of_materials(replace(machine, supplies=(grease,)), unit_masses(machine))
    assert (rows[-1].item, rows[-1].quantity, rows[-1].unit_mass_g, rows[-1].total_mass_g) == (7, 3, 2.5, 7.5)
    assert rows[-1].make_or_buy == "buy"


def test_a_shoulder_is_as_many_times_slower_as_it_is_stronger(robot: Robot) -> None:
    """900 rad/s of an idle motor at 4.8 : 1; the torque is what the controller lets it give."""
    tree = ET.fromstring(urdf(robot))
    shoulders = [one for one in tree.iter("joint") if one.find("dynamics") is not None]
    assert len(shoulders) == 3
    for joint in shoulders:
        limit = joint.find("limit")
        assert limit is not None
        assert {key: float(value) for key, value in limit.items()} == pytest.approx(
            {"lower": -1.1, "upper": 1.0, "effort": 0.8, "velocity": 900.0 / 4.8}
        )
    assert {float(one.text or 0) for one in tree.iter("mechanicalReduction")} == {4.8}
    speeds = [float(one.text or 0) for one in ET.fromstring(sdf(robot)).iter("velocity")]
    assert speeds == pytest.approx([900.0 / 4.8] * 3)


def test_rotor_and_pinion_turn_by_the_square_of_the_ratio(robot: Robot) -> None:
    pinion = {"inertia_kg_m2": [[1.0, 0.0, 0.0], [0.0, 2e-7, 0.0], [0.0, 0.0, 1.0]]}
    turning = 4.8**2 * (3.33e-6 + 2e-7)
    for text in (urdf, sdf):
        reported = text(replace(robot, bodies={**robot.bodies, "pinion_0": pinion}))
        (said,) = (line for line in reported.splitlines() if "rotor and pinion add" in line)
        assert float(said.split("rotor and pinion add ")[1].split()[0]) == pytest.approx(turning)
