"""The one real build of the committed design: what it holds and how its files agree."""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Iterator
from typing import Any

import pytest

from delta_cad.design import Design, design_hash
from delta_cad.dimensions import Dimensions
from delta_cad.export.shop.jigs import jigs_of
from tests.committed import Built
from tests.delta_cad.export.shop.quoted import check_quotation
from tests.terminal import said


def test_the_committed_design_builds_and_all_its_checks_hold(built: Built) -> None:
    failed = [c for c in built.record["checks"] if not c["passed"]] if built.stdout else built.stderr
    assert built.code == 0, failed
    assert said(built.stderr) == ""
    assert built.record["passed"] is True
    assert built.record["failed"] == []
    assert built.record["folder"] == str(built.folder)


def test_its_figures_stay_where_they_are(built: Built) -> None:
    """Of a sweep and of a shop, which the figures of the gallery's `best.json` leave out in the quick tests."""
    values = {check["name"]: check["value"] for check in built.record["checks"]}
    # polished: another processor has other last digits
    assert values["clearance"] == pytest.approx(2.373485502217071, rel=1e-6)
    assert built.record["cost_EUR"] == 3207.83


def test_the_build_holds_every_promised_file_and_its_hash(built: Built, best_assembly: Any) -> None:
    names = {str(p.relative_to(built.folder)) for p in built.folder.rglob("*") if p.is_file()}
    promised = {
        "assembly.step",
        "assembly.glb",
        "bom.csv",
        "bom.json",
        "mass_properties.json",
        "structure.json",
        "checks.json",
        "report.html",
        "manifest.json",
    }
    assert promised <= names
    made = {part.number for part in best_assembly.parts if part.make}
    drawn = {"encoder_board", "wave_spring", "rod_spring", "crimp_sleeve"}  # no printer makes them: no mesh
    for suffix, expected in (("step", made | drawn), ("stl", made), ("3mf", made)):
        assert {
            n.removeprefix("parts/").removesuffix(f".{suffix}")
            for n in names
            if n.startswith("parts/") and n.endswith(suffix)
        } == expected
    assert sum(n.startswith("views/") and n.endswith(".png") for n in names) >= 3
    manifest = json.loads((built.folder / "manifest.json").read_text())
    assert manifest["status"] == "passed"
    listed = {entry: digest for entry, digest in _hashes(manifest["files"]) if entry != "manifest.json"}
    assert set(listed) == names - {"manifest.json"}
    for name, digest in listed.items():
        assert hashlib.sha256((built.folder / name).read_bytes()).hexdigest() == digest, name
    assert [p.name for p in built.folder.parent.iterdir()] == [built.folder.name]  # nothing is left beside it


def test_a_shop_gets_every_made_part_and_jig_in_one_archive(
    built: Built, best_assembly: Any, best_dimensions: Dimensions
) -> None:
    made = {part.number: part for part in best_assembly.parts if part.is_drawn}
    rows = check_quotation(built.folder)
    assert [row["part_number"] for row in rows] == [*made, *(jig.part.number for jig in jigs_of(best_dimensions))]
    assert all(f"{number}/{number}.pdf" in row["files"].split() for number, row in zip(made, rows, strict=False))
    with (built.folder / "bom.csv").open(newline="", encoding="utf-8") as file:
        listed = {row["part_number"]: row for row in csv.DictReader(file)}
    for row in rows:
        assert row["quantity"] == listed[row["part_number"]]["quantity"]
        assert float(row["mass_g"]) == pytest.approx(float(listed[row["part_number"]]["unit_mass_g"]), rel=5e-3)
    profiles = {path.name for path in (built.folder / "profiles").iterdir()}
    assert profiles == {name.split("/")[1] for row in rows for name in row["files"].split() if "profile" in name}


def _hashes(files: Any) -> Iterator[tuple[str, str]]:
    entries = files.items() if isinstance(files, dict) else [(f["path"], f) for f in files]
    for name, entry in entries:
        yield name, entry if isinstance(entry, str) else entry["sha256"]


def test_the_written_report_is_the_printed_record(built: Built, best: Design) -> None:
    record = built.record
    record.pop("folder")
    assert json.loads((built.folder / "checks.json").read_text()) == record
    assert record["input_sha256"] == design_hash(best)
    names = [c["name"] for c in record["checks"]]
    assert len(names) == len(set(names))
    for name in (
        "reach",
        "lean",
        "joint closure",
        "ball tilt",
        "envelope width",
        "envelope depth",
        "torque with gravity",
        "drive torque",
    ):
        assert name in names
    assert any(name.startswith("clearance") for name in names)


def test_masses_of_report_and_file_agree(built: Built) -> None:
    masses = json.loads((built.folder / "mass_properties.json").read_text())
    assert masses["total_mass_kg"] == built.record["total_mass_kg"]
    assert masses["moving_mass_kg"] == built.record["moving_mass_kg"]
    assert sum(body["mass_kg"] for body in masses["bodies"].values()) == pytest.approx(
        masses["total_mass_kg"], rel=1e-12
    )
    assert 0.2 < masses["moving_mass_kg"] < 0.5 * masses["total_mass_kg"]  # kg; the feasibility study has 0.335
