"""`inspect`, `certify` and `verify` with each limit on a figure: told, proved or refuted, replayed, not forged."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.commands.cli import main
from delta_cad.common.units import MM_PER_M
from delta_cad.design import load_design
from delta_cad.dimensions.joint import known_joints
from delta_cad.mechanism import elbow_positions, inverse_jacobian, inverse_kinematics, jacobian, wrist_positions
from delta_cad.mechanism.geometry import THREE_FOLD, directions
from delta_cad.mechanism.limits import POSE_LIMITS
from delta_cad.mechanism.limits.friction import SIGNS
from tests.optimizer.certify.designs import call, changed, masses, redigested

# Condition -> field of the requirements, the only one that states it.
FIELDS = {limit.name: limit.fields_[0].name for limit in POSE_LIMITS if len(limit.fields_) == 1}
MEASURED = {"couple index": "couple_index", "friction": "friction", "position step": "position_step"}
"""Row of `inspect` -> condition."""


def on_a_grid(path: Path) -> dict[str, float]:
    """Worst couple index, friction, N, and position step, mm, on 21^3 points, each by plain linear algebra."""
    design = load_design(path)
    g, line, cube, known = design.geometry, np.linspace(-1.0, 1.0, 21), design.workspace, known_joints(design)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    p = np.array([0.0, 0.0, cube.bottom_height + cube.half_side]) + cube.half_side * grid
    n = (wrist_positions(g, p) - elbow_positions(g, inverse_kinematics(g, p))) / g.forearm_length
    couples = np.linalg.svd(np.cross(np.broadcast_to(directions(THREE_FOLD)[1], n.shape), n), compute_uv=False)[:, 2]
    sums = known["friction"].drive * SIGNS @ np.linalg.inv(jacobian(g, p))
    level = np.linalg.norm(sums[..., :2], axis=-1) + known["friction"].level
    steps = np.linalg.inv(inverse_jacobian(g, p)) @ SIGNS.T * known["encoder_count"]
    return {
        "couple_index": float(couples.min()),
        "friction": float(np.hypot(np.abs(sums[..., 2]) + known["friction"].upright, level).max()),
        "position_step": float(np.linalg.norm(steps, axis=-2).max()) * MM_PER_M,
    }


@pytest.fixture(scope="module")
def rows(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """Rows of `certify` by their condition where none is asked; the masses are known."""
    folder = tmp_path_factory.mktemp("free")
    path = changed(folder)
    file = masses(folder, load_design(path), turning=2e-6)
    with redirect_stdout(io.StringIO()) as reported:
        assert call("certify", "--design", path, "--out", folder / "c.json", "--mass-properties", file, "--json") == 0
    return {row["condition"]: row for row in json.loads(reported.getvalue())["conditions"]}


def requested(rows: dict[str, dict[str, Any]], room: float, names: Any = FIELDS) -> dict[str, float]:
    """Limits that leave each figure a share of itself as room, or lack it."""
    signs = {name: 1.0 if rows[name]["limit_is"] == "at most" else -1.0 for name in names}
    return {FIELDS[name]: rows[name]["attained"] * (1.0 + signs[name] * room) for name in names}


def test_the_table_has_what_the_commands_can_be_required() -> None:
    assert {"kappa", "lean", "elbow_angle", "couple_index", "friction", "position_step", "effective_mass"} <= set(
        FIELDS
    )


def test_inspect_tells_them_whether_required_or_not(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    rows: dict[str, dict[str, Any]],
) -> None:
    monkeypatch.setattr("delta_cad.structure.hardware.thresholds.refused", lambda _: ())  # no hardware is looked at
    found = on_a_grid(changed(tmp_path))
    for room, code, holds in ((None, 0, None), (0.01, 0, True), (-0.01, 1, False)):
        limits = {} if room is None else requested(rows, room, MEASURED.values())
        assert main(["inspect", "--design", str(changed(tmp_path, **limits)), "--json"]) == code
        reported = {row["quantity"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
        for name, condition in MEASURED.items():
            assert reported[name]["value"] == pytest.approx(found[condition], rel=1e-3)  # between points of the grid
            assert reported[name]["value"] == pytest.approx(rows[condition]["attained"], rel=1e-9)
            assert (reported[name]["unit"], reported[name]["holds"]) == (rows[condition]["unit"], holds)
            assert bool(reported[name]["limit"]) is (room is not None)


def test_they_are_proved_or_refuted_and_replayed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: dict[str, dict[str, Any]]
) -> None:
    out = tmp_path / "c.json"
    path = changed(tmp_path, **requested(rows, 0.002))
    file = masses(tmp_path, load_design(path), turning=2e-6)
    weighed = "--mass-properties", file
    assert call("certify", "--design", path, "--out", out, *weighed, "--json") == 0
    proved = {row["condition"]: row for row in json.loads(capsys.readouterr().out)["conditions"]}
    for name, limit in requested(rows, 0.002).items():
        row = next(row for condition, row in proved.items() if FIELDS.get(condition) == name)
        assert (row["verdict"], row["limit"]) == ("proved", pytest.approx(limit, rel=1e-12))
        ordered = [row["attained"], row["proved"], row["limit"]]
        assert ordered == sorted(ordered, reverse=row["limit_is"] == "at least")
    data = json.loads(out.read_text())
    assert data["limits"]["encoder_count_rad"] == known_joints(load_design(path))["encoder_count"]
    assert call("verify", out, "--design", path, *weighed) == 0
    assert "couple_index proved again" in capsys.readouterr().out

    def forged(change: Callable[[dict[str, Any]], object], *more: str | Path) -> tuple[int, str]:
        other = json.loads(json.dumps(data))
        change(other)
        (tmp_path / "forged.json").write_text(json.dumps(redigested(other)))
        code = call("verify", tmp_path / "forged.json", *more)
        return code, capsys.readouterr().err

    def looser(condition: str, factor: float | None) -> Callable[[dict[str, Any]], object]:
        def change(other: dict[str, Any]) -> None:
            key = next(key for key in other["limits"] if key.startswith(condition))
            limit = other["limits"][key] = None if factor is None else factor * other["limits"][key]
            kept = [f for f in other["findings"] if factor is not None or f["condition"] != condition]
            other["findings"] = [f | {"limit": limit} if f["condition"] == condition else f for f in kept]

        return change

    # what is broken, and what the design asks left out
    for factor in (1.01, None):
        for condition in ("kappa", "couple_index"):
            code, err = forged(
                looser(condition, factor and (factor if condition == "kappa" else 1.0 / factor)), "--design", path
            )
            assert (code, condition in err) == (1, True)
    # less that rubs, and finer counts than the design's: proved as well, of another machine
    for key, name in (("joint_friction_N_m", "friction"), ("encoder_count_rad", "position_step")):
        less = lambda other, key=key: other["limits"].update({key: 0.9 * other["limits"][key]})  # noqa: E731
        assert forged(less)[0] == 0
        code, err = forged(less, "--design", path, *weighed)
        assert (code, f"{name}: design " in err) == (1, True)

    path = changed(tmp_path, **requested(rows, -0.002))
    file = masses(tmp_path, load_design(path), turning=2e-6)
    assert call("certify", "--design", path, "--out", out, *weighed) == 1
    reported, err = capsys.readouterr()
    for name in FIELDS:
        row = rows[name]
        found = re.search(rf"{name} is refuted: {re.escape(row['figure'])} is (\S+) ", err)
        assert found is not None
        assert float(found[1]) == pytest.approx(row["attained"], rel=2e-3)
        assert re.search(rf"(?m)^{re.escape(row['figure'])} +refuted +[<>]= ", reported)
    assert call("verify", out, "--design", path, *weighed) == 1
    assert capsys.readouterr().err.count("confirmed") == len(FIELDS)


def test_one_is_proved_of_every_machine_within_a_tolerance(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], rows: dict[str, dict[str, Any]]
) -> None:
    out, index = tmp_path / "c.json", rows["couple_index"]["attained"]
    path = changed(tmp_path, couple_index_min=0.93 * index)
    assert call("certify", "--design", path, "--out", out, "--tolerance", "0.05", "--json") == 0
    assert call("verify", out, "--design", path, "--without-gravity") == 0
    capsys.readouterr()
    path = changed(tmp_path, couple_index_min=0.99999 * index)
    assert call("certify", "--design", path, "--out", out, "--tolerance", "0.05") == 1
    reported, err = capsys.readouterr()
    assert "not all proved (couple_index)" in err
    need = re.search(r"0\.05 mm would need couple index >= (\S+)", reported + err)
    assert need is not None
    assert 0.93 * index < float(need[1].rstrip(",;")) < index
