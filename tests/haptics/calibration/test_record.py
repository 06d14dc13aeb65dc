"""Files of poses and of calibrations: there and back, and everything else refused in one line."""

from __future__ import annotations

import copy
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.calibration.accuracy import accuracy
from haptics.calibration.fit import Noise, fit
from haptics.calibration.poses import COLUMNS, Poses, PosesError, load_poses
from haptics.calibration.record import (
    Calibration,
    CalibrationError,
    calibration_of,
    load_calibration,
    save_calibration,
    to_dict,
)
from tests.haptics.calibration.devices import cube_points, made, measured, poses_text


@pytest.fixture(scope="module")
def calibration(best: Design) -> Calibration:
    rng = np.random.default_rng(1)
    poses = measured(made(best, rng), cube_points(best, rng, 30), rng)
    found = fit(best.geometry, poses, noise=Noise(2e-5, 5e-5))
    return calibration_of(best, found, 30, accuracy(found, best))


def test_a_calibration_there_and_back(best: Design, calibration: Calibration, tmp_path: Path) -> None:
    path = tmp_path / "calibration.json"
    save_calibration(calibration, path)
    again = load_calibration(path, best)
    np.testing.assert_allclose(again.unknowns.table, calibration.unknowns.table, rtol=1e-14)
    np.testing.assert_allclose(again.sigma, calibration.sigma, rtol=1e-14)
    assert (again.name, again.unidentifiable, again.fit) == (
        calibration.name,
        calibration.unidentifiable,
        calibration.fit,
    )
    raw = json.loads(path.read_text())
    assert raw["chains"][1]["upper_arm_length_mm"] == pytest.approx(1e3 * calibration.unknowns.table[1, 2])
    assert raw["chains"][2]["zero_deg"] == pytest.approx(np.degrees(calibration.unknowns.table[2, 6]))


Change = Callable[[dict[str, Any]], object]
DAMAGE: dict[str, tuple[Change, str]] = {
    "schema": (lambda d: d.update(schema="delta-calibration/2"), "schema"),
    "key": (lambda d: d.update(more=1), "more"),
    "missing": (lambda d: d.pop("fit"), "fit"),
    "design": (lambda d: d.update(design_sha256="0" * 64), "design_sha256"),
    "two chains": (lambda d: d["chains"].pop(), "chains"),
    "chain's key": (lambda d: d["chains"][1].update(zero_rad=0.1), "chains[1].zero_rad"),
    "metres": (lambda d: d["chains"][0].update(forearm_length_mm=0.143), "chains[0].forearm_length_mm"),
    "truth": (lambda d: d["chains"][0].update(zero_deg=True), "chains[0].zero_deg"),
    "text": (lambda d: d["chains"][0].update(zero_deg="1"), "chains[0].zero_deg"),
    "wave": (lambda d: d["chains"][2].update(cos_1_deg=11.0), "chains[2].cos_1_deg"),
    "negative": (lambda d: d["uncertainty"][2].update(sin_2_deg=-1.0), "uncertainty[2].sin_2_deg"),
    "turns": (lambda d: d.update(encoder_turns=0.0), "encoder_turns"),
    "words": (lambda d: d.update({"not_told": "all"}), "not_told"),
    "figures": (lambda d: d.update(fit={"poses": []}), "fit"),
    "name": (lambda d: d.update(name=3), "name"),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_calibration_that_is_refused(best: Design, calibration: Calibration, tmp_path: Path, kind: str) -> None:
    change, field = DAMAGE[kind]
    data = copy.deepcopy(to_dict(calibration))
    change(data)
    path = tmp_path / "calibration.json"
    path.write_text(json.dumps(data))
    with pytest.raises(CalibrationError) as refused:
        load_calibration(path, best)
    assert refused.value.field == field


@pytest.mark.parametrize("text", ["", "[]", "{", '{"schema": NaN}', '{"schema": 1, "schema": 2}'])
def test_what_is_no_calibration(best: Design, tmp_path: Path, text: str) -> None:
    path = tmp_path / "calibration.json"
    path.write_text(text)
    with pytest.raises(CalibrationError):
        load_calibration(path, best)
    with pytest.raises(CalibrationError):
        load_calibration(tmp_path / "nothing.json", best)


def test_poses_there_and_back(tmp_path: Path) -> None:
    poses = Poses(np.array([[0.01, -0.02, 0.1]]), np.array([[0.1, -0.2, 0.3]]))
    path = tmp_path / "poses.csv"
    path.write_text(poses_text(poses))
    again = load_poses(path)
    np.testing.assert_allclose(again.positions, poses.positions, rtol=1e-8)
    np.testing.assert_allclose(again.readings, poses.readings, rtol=1e-8)
    head, row = path.read_text().splitlines()
    order = [3, 0, 5, 1, 4, 2]  # columns may stand in any order
    path.write_text("\n".join(",".join(line.split(",")[k] for k in order) for line in (head, row)) + "\r\n\r\n")
    np.testing.assert_allclose(load_poses(path).readings, poses.readings, rtol=1e-8)


HEAD = ",".join(COLUMNS) + "\n"


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("", "columns"),
        ("x,y\n1,2\n", "columns"),
        (HEAD + "1,2,3,4,5\n", "row 1"),
        (HEAD + "1,2,3,4,5,6\n1,2,3,4,5,\n", "row 2 reading_2_deg"),
        (HEAD + "nan,2,3,4,5,6\n", "row 1 x_mm"),
        (HEAD + "1,2,inf,4,5,6\n", "row 1 z_mm"),
        (HEAD + "1,2,3,4,5,1e6\n", "row 1 reading_2_deg"),
        (HEAD + '"1,2,3', ""),
        (HEAD + "1,2,3,4,5,6\n" * 20_001, "rows"),
    ],
)
def test_poses_that_are_refused(tmp_path: Path, text: str, field: str) -> None:
    path = tmp_path / "poses.csv"
    path.write_text(text)
    with pytest.raises(PosesError) as refused:
        load_poses(path)
    assert refused.value.field == field


def test_poses_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "poses.csv"
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(PosesError):
        load_poses(path)
