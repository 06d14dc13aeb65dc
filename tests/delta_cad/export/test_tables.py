"""Bill of materials, hole list, manifest."""

from __future__ import annotations

import csv
import hashlib
import json
from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.export.bom import bill_of_materials, write_bom
from delta_cad.export.manifest import ManifestError, versions, write_manifest
from delta_cad.export.mass_properties import mass_report
from delta_cad.export.step import write_assembly_step
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
    from delta_cad.export.fingerprint import step_fingerprint

    manifest = json.loads((build / "manifest.json").read_text())
    assert set(manifest["files"]) == {"assembly.step", "parts/a.stl"}
    for name, entry in manifest["files"].items():
        data = (build / name).read_bytes()
        assert entry == {"sha256": hashlib.sha256(data).hexdigest(), "bytes": len(data)}
    assert manifest["step_fingerprint"] == step_fingerprint(step_file)
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
