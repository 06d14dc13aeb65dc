"""`certify` and `verify` with the effective mass: with the masses of a machine."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from delta_cad.design import design_hash, load_design
from tests.optimizer.certify.designs import call, changed, masses


def test_the_masses_of_the_build_are_taken_where_it_stands_in_this_folder(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = changed(tmp_path, effective_mass_max_kg=10.0)
    design = load_design(path)
    place = tmp_path / "out" / design.name
    place.mkdir(parents=True)
    made = json.loads(masses(tmp_path, design, turning=2e-6).read_text()) | {"input_sha256": design_hash(design)}
    (place / "mass_properties.json").write_text(json.dumps(made))
    assert call("certify", "--design", path, "--out", tmp_path / "c.json") in (0, 1)
    reported, err = capsys.readouterr()
    assert f"--mass-properties out/{design.name}/mass_properties.json: taken, as none was given" in err
    assert "effective mass" in reported
    other = changed(tmp_path, effective_mass_max_kg=9.0)  # of which that build is none
    assert call("certify", "--design", other, "--out", tmp_path / "c.json") in (0, 1)
    assert "taken" not in capsys.readouterr().err


def test_known_masses_make_a_row_and_a_tight_limit_though_nothing_asks_for_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path), turning=2e-6)
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file, "--tight", "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    row = next(row for row in reported["conditions"] if row["condition"] == "effective_mass")
    assert (row["verdict"], row["limit"]) == ("not asked", None)
    assert json.loads(out.read_text())["limits"]["effective_mass_max_kg"] == row["proved"]
    assert call("verify", out, "--design", path, "--mass-properties", file) == 0
