"""`inspect`, `certify` and `verify` with the couple index: told, proved or refuted, replayed, within a tolerance."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from delta_cad.commands.cli import main
from delta_cad.design import load_design
from delta_cad.mechanism import elbow_positions, inverse_kinematics, wrist_positions
from delta_cad.mechanism.geometry import TANGENTIAL
from tests.optimizer.certify.designs import call, changed, redigested


def least(path: Path) -> float:
    """The smallest singular value of the couples on 61^3 points."""
    design = load_design(path)
    g, line, cube = design.geometry, np.linspace(-1.0, 1.0, 61), design.workspace
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    p = np.array([0.0, 0.0, cube.bottom_height + cube.half_side]) + cube.half_side * grid
    n = (wrist_positions(g, p) - elbow_positions(g, inverse_kinematics(g, p))) / g.forearm_length
    return float(np.linalg.svd(np.cross(np.broadcast_to(TANGENTIAL, n.shape), n), compute_uv=False)[:, 2].min())


def row_of(told: str) -> dict[str, object]:
    return next(row for row in json.loads(told)["conditions"] if row["condition"] == "couple_index")


def test_inspect_tells_it_whether_asked_or_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    index = least(changed(tmp_path))
    for asked, code, holds in (({}, 0, None), (index * 0.99, 0, True), (index * 1.01, 1, False)):
        path = changed(tmp_path, **({"couple_index_min": asked} if asked else {}))
        assert main(["inspect", "--design", str(path), "--json"]) == code
        rows = {row["quantity"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
        row = rows["couple index"]
        assert row["value"] == pytest.approx(index, rel=1e-9)  # the worst is a corner, which the grid has
        assert (row["unit"], row["holds"]) == ("", holds)
        assert row["limit"] == (f">= {asked:g}" if asked else "")


def test_it_is_proved_or_refuted_and_replayed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, index = tmp_path / "c.json", least(changed(tmp_path))
    path = changed(tmp_path, couple_index_min=index * 0.999)
    assert call("certify", "--design", path, "--out", out, "--json") == 0
    row = row_of(capsys.readouterr().out)
    assert (row["verdict"], row["unit"], row["limit"], row["limit_is"]) == ("proved", "", index * 0.999, "at least")
    assert row["limit"] <= row["proved"] <= row["attained"] <= index * (1.0 + 1e-12)
    data = json.loads(out.read_text())
    assert data["limits"]["couple_index_min"] == index * 0.999
    assert call("verify", out, "--design", path, "--without-gravity") == 0
    assert "couple_index proved again" in capsys.readouterr().out
    for change in (1.002, None):  # what is broken, and what the design asks left out
        forged = json.loads(json.dumps(data))
        bound = None if change is None else index * 0.999 * change
        forged["limits"]["couple_index_min"] = bound
        kept = [f for f in forged["findings"] if change is not None or f["condition"] != "couple_index"]
        forged["findings"] = [f | {"limit": bound} if f["condition"] == "couple_index" else f for f in kept]
        (tmp_path / "forged.json").write_text(json.dumps(redigested(forged)))
        assert call("verify", tmp_path / "forged.json", "--design", path, "--without-gravity") == 1
        assert "couple_index" in capsys.readouterr().err

    path = changed(tmp_path, couple_index_min=index * 1.001)
    assert call("certify", "--design", path, "--out", out) == 1
    told, err = capsys.readouterr()
    found = re.match(r"design\.json: couple_index is refuted: couple index is (\S+) at \(", err)
    assert found is not None
    assert float(found[1]) == pytest.approx(index, rel=1e-5)  # six digits are told
    assert re.search(r"(?m)^couple index +refuted +>= ", told)
    assert call("verify", out, "--design", path, "--without-gravity") == 1
    assert re.search(r"couple_index is refuted at \(.*, confirmed$", capsys.readouterr().err.strip())


def test_it_is_proved_of_every_machine_within_a_tolerance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, index = tmp_path / "c.json", least(changed(tmp_path))
    path = changed(tmp_path, couple_index_min=0.93 * index)
    assert call("certify", "--design", path, "--out", out, "--tolerance", "0.05", "--json") == 0
    assert row_of(capsys.readouterr().out)["verdict"] == "proved"
    assert call("verify", out, "--design", path, "--without-gravity") == 0
    capsys.readouterr()
    path = changed(tmp_path, couple_index_min=0.99999 * index)
    assert call("certify", "--design", path, "--out", out, "--tolerance", "0.05") == 1
    told, err = capsys.readouterr()
    assert "not all proved (couple_index)" in err
    need = re.search(r"0\.05 mm would need couple index >= (\S+)", told + err)
    assert need is not None
    assert 0.93 * index < float(need[1].rstrip(",;")) < index
