"""`certify` and `verify` with the effective mass: proved or refuted with the masses of a machine."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import design_hash, load_design
from delta_cad.drive.masses import load_masses
from delta_cad.mechanism.limits.effective_mass import effective_mass
from tests.optimizer.certify.designs import call, changed, masses


def heaviest(path: Path, file: Path) -> float:
    """The largest effective mass on 61^3 points, by a plain eigenvalue problem, kg."""
    design = load_design(path)
    inertia = load_masses(file, design).handle_inertia
    line, cube = np.linspace(-1.0, 1.0, 61), design.workspace
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    points = np.array([0.0, 0.0, cube.bottom_height + cube.half_side]) + cube.half_side * grid
    return float(effective_mass(design.geometry, points, inertia).max())


def test_effective_mass_is_proved_or_refuted_and_replayed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "c.json"
    file = masses(tmp_path, load_design(changed(tmp_path)), turning=2e-6)
    largest = heaviest(changed(tmp_path), file)
    path = changed(tmp_path, effective_mass_max_kg=largest * 1.001)
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file, "--json") == 0
    told = json.loads(capsys.readouterr().out)
    row = next(row for row in told["conditions"] if row["condition"] == "effective_mass")
    assert (row["verdict"], row["unit"], row["limit"]) == ("proved", "kg", largest * 1.001)
    # the grid misses the extreme by less than a step's square of the curvature, 1e-4
    assert largest * (1.0 - 1e-12) <= row["attained"] <= row["proved"] <= row["limit"]
    assert row["proved"] <= largest * (1.0 + 2e-4)
    data = json.loads(out.read_text())
    assert data["limits"]["effective_mass_max_kg"] == largest * 1.001
    assert set(data["limits"]["inertia"]) == {
        "carried_mass_kg", "elbow_mass_kg", "cross_mass_kg", "joint_inertia_kg_m2",
    }  # fmt: skip
    assert call("verify", out, "--design", path, "--mass-properties", file) == 0
    words = capsys.readouterr().out
    assert "effective_mass proved again" in words
    assert words.endswith("kg m^2 at a joint, checked\n")
    for told_so, code in (((), 1), (("--without-gravity",), 1), (("--as-recorded",), 0)):
        assert call("verify", out, "--design", path, *told_so) == code
    told, err = capsys.readouterr()
    assert "requirements.effective_mass_max_kg = " in err.splitlines()[1]
    assert "AS RECORDED, their file not given: --mass-properties\n" in told.splitlines(True)[-1]

    path = changed(tmp_path, effective_mass_max_kg=largest * 0.999)
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file) == 1
    told, err = capsys.readouterr()
    found = re.match(r"design\.json: effective_mass is refuted: effective mass is (\S+) kg at \(", err)
    assert found is not None
    assert largest * (1.0 - 1e-5) <= float(found[1]) <= largest * (1.0 + 2e-4)  # six digits are told
    assert re.search(r"(?m)^effective mass +refuted +<= ", told)
    assert call("verify", out, "--design", path, "--mass-properties", file) == 1
    assert re.search(r"effective_mass is refuted at \(.*, confirmed$", capsys.readouterr().err.strip())


def test_an_effective_mass_without_masses_is_left_out_and_missed_by_verify(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where no build stands
    path, out = changed(tmp_path, effective_mass_max_kg=0.4), tmp_path / "c.json"
    for more in ((), ("--gravity-torque", "0.1")):
        assert call("certify", "--design", path, "--out", out, *more) == 1
        told, err = capsys.readouterr()
        assert "design.json: requirements.effective_mass_max_kg = 0.4 is left out, it needs the masses" in err
        assert "effective mass" not in told
        assert call("verify", out, "--design", path, *more) == 1
        assert "effective_mass: design" in capsys.readouterr().err


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
    told, err = capsys.readouterr()
    assert f"--mass-properties out/{design.name}/mass_properties.json: taken, as none was given" in err
    assert "effective mass" in told
    other = changed(tmp_path, effective_mass_max_kg=9.0)  # of which that build is none
    assert call("certify", "--design", other, "--out", tmp_path / "c.json") in (0, 1)
    assert "taken" not in capsys.readouterr().err


def test_known_masses_make_a_row_and_a_tight_limit_though_nothing_asks_for_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, out = changed(tmp_path), tmp_path / "c.json"
    file = masses(tmp_path, load_design(path), turning=2e-6)
    assert call("certify", "--design", path, "--out", out, "--mass-properties", file, "--tight", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    row = next(row for row in told["conditions"] if row["condition"] == "effective_mass")
    assert (row["verdict"], row["limit"]) == ("not asked", None)
    assert json.loads(out.read_text())["limits"]["effective_mass_max_kg"] == row["proved"]
    assert call("verify", out, "--design", path, "--mass-properties", file) == 0
