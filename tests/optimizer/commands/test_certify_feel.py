"""`inspect`, `certify` and `verify` with friction and position step: told, proved or refuted, replayed, not forged."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from delta_cad.commands.cli import main
from delta_cad.common.units import MM_PER_M
from delta_cad.design import load_design
from delta_cad.dimensions.joint import known_joints
from delta_cad.mechanism import inverse_jacobian, jacobian
from delta_cad.mechanism.limits.friction import SIGNS
from tests.optimizer.certify.designs import call, changed, redigested

QUANTITIES = {"friction": "friction_max_N", "position step": "position_step_max_mm"}
CONDITIONS = ("friction", "position_step")


def most(path: Path) -> tuple[float, float]:
    """The largest friction, N, and position step, mm, on 41^3 points, each by an inverse matrix of its own."""
    design = load_design(path)
    g, line, cube, known = design.geometry, np.linspace(-1.0, 1.0, 41), design.workspace, known_joints(design)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    p = np.array([0.0, 0.0, cube.bottom_height + cube.half_side]) + cube.half_side * grid
    sums = known["friction"].drive * SIGNS @ np.linalg.inv(jacobian(g, p))
    level = np.linalg.norm(sums[..., :2], axis=-1) + known["friction"].level
    steps = np.linalg.inv(inverse_jacobian(g, p)) @ SIGNS.T * known["encoder_count"]
    felt = np.hypot(np.abs(sums[..., 2]) + known["friction"].upright, level)
    return float(felt.max()), float(np.linalg.norm(steps, axis=-2).max()) * MM_PER_M


def test_inspect_tells_them_whether_asked_or_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found = dict(zip(QUANTITIES, most(changed(tmp_path)), strict=True))
    for factor, code, holds in ((None, 0, None), (1.01, 0, True), (0.99, 1, False)):
        asked = {} if factor is None else {QUANTITIES[name]: factor * value for name, value in found.items()}
        assert main(["inspect", "--design", str(changed(tmp_path, **asked)), "--json"]) == code
        rows = {row["quantity"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
        for name, unit in (("friction", "N"), ("position step", "mm")):
            assert rows[name]["value"] == pytest.approx(found[name], rel=1e-3)  # between points of the grid
            assert rows[name]["value"] >= found[name] * (1.0 - 1e-9)
            assert (rows[name]["unit"], rows[name]["holds"]) == (unit, holds)


def test_they_are_proved_or_refuted_and_replayed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out, found = tmp_path / "c.json", most(changed(tmp_path))
    path = changed(tmp_path, **dict(zip(QUANTITIES.values(), (1.002 * value for value in found), strict=True)))
    assert call("certify", "--design", path, "--out", out, "--json") == 0
    rows = {row["condition"]: row for row in json.loads(capsys.readouterr().out)["conditions"]}
    assert [rows[name]["verdict"] for name in CONDITIONS] == ["proved", "proved"]
    assert [rows[name]["limit_is"] for name in CONDITIONS] == ["at most", "at most"]
    data = json.loads(out.read_text())
    assert data["limits"]["encoder_count_rad"] == known_joints(load_design(path))["encoder_count"]
    assert call("verify", out, "--design", path, "--without-gravity") == 0
    assert "friction, position_step proved again" in capsys.readouterr().out
    # less that rubs, and finer counts than the design's: proved as well, of another machine
    for key, name in (("joint_friction_N_m", "friction"), ("encoder_count_rad", "position_step")):
        forged = json.loads(json.dumps(data))
        forged["limits"][key] *= 0.9
        (tmp_path / "forged.json").write_text(json.dumps(redigested(forged)))
        assert call("verify", tmp_path / "forged.json") == 0
        capsys.readouterr()
        assert call("verify", tmp_path / "forged.json", "--design", path, "--without-gravity") == 1
        assert f"{name}: design " in capsys.readouterr().err

    path = changed(tmp_path, **dict(zip(QUANTITIES.values(), (0.998 * value for value in found), strict=True)))
    assert call("certify", "--design", path, "--out", out) == 1
    err = capsys.readouterr().err
    assert all(f"{name} is refuted: " in err for name in CONDITIONS)
    assert call("verify", out, "--design", path, "--without-gravity") == 1
    err = capsys.readouterr().err
    assert err.count("confirmed") == 2
