"""`inspect --kinematics`: anybody's delta by four lengths and a cube, without any hardware."""

from __future__ import annotations

import json
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.commands.cli import main
from delta_cad.mechanism import DeltaGeometry, inverse_kinematics, jacobian
from tests.committed import DATA

FLEXPICKER = {
    "mechanism": {
        "base_radius_mm": 163.6788,
        "platform_radius_mm": 43.8786,
        "upper_arm_length_mm": 524.0,
        "forearm_length_mm": 1244.0,
    },
    "cube": {"bottom_height_mm": 900.0, "half_side_mm": 150.0},
}
FALCON = {
    "mechanism": {
        "base_radius_mm": 37.23,
        "platform_radius_mm": 14.0,
        "upper_arm_length_mm": 60.0,
        "forearm_length_mm": 102.5,
    },
    "cube": {"bottom_height_mm": 75.0, "half_side_mm": 25.0},
}


def written(folder: Path, data: dict[str, Any]) -> Path:
    path = folder / "delta.json"
    path.write_text(json.dumps({"schema": "delta-design/1", "name": "delta", **data}))
    return path


def inspected(path: Path, capsys: pytest.CaptureFixture[str], code: int = 0) -> dict[str, dict[str, Any]]:
    assert main(["inspect", "--kinematics", "--design", str(path), "--json"]) == code
    said = capsys.readouterr()
    return {row["quantity"]: row for row in json.loads(said.out)["rows"]}


@pytest.mark.parametrize("data", [FLEXPICKER, FALCON], ids=["FlexPicker", "Falcon"])
def test_four_lengths_and_a_cube_are_enough(
    data: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Held to the Jacobian and the angles at the cube's corners and over its faces, and to arms in line."""
    rows = inspected(written(tmp_path, data), capsys)
    m, cube = data["mechanism"], data["cube"]
    g = DeltaGeometry(*(m[f"{name}_mm"] / 1e3 for name in ("base_radius", "platform_radius", "upper_arm_length",
                                                            "forearm_length")))  # fmt: skip
    half = cube["half_side_mm"]
    x, y, z = np.meshgrid(*[np.linspace(-half, half, 21)] * 3, indexing="ij")
    p = np.stack([x, y, z + cube["bottom_height_mm"] + half], axis=-1).reshape(-1, 3) / 1e3
    singular = np.linalg.svd(jacobian(g, p), compute_uv=False)
    theta = np.degrees(inverse_kinematics(g, p))
    assert rows["kappa"]["value"] == pytest.approx((singular[:, 0] / singular[:, -1]).max(), rel=2e-3)
    assert rows["shoulder, smallest"]["value"] == pytest.approx(theta.min(), abs=0.05)
    assert rows["shoulder, largest"]["value"] == pytest.approx(theta.max(), abs=0.05)
    torque = rows["torque for 1 N in the worst direction"]
    assert torque["value"] == pytest.approx(np.linalg.norm(jacobian(g, p), axis=-2).max(), rel=2e-3)
    assert (torque["limit"], torque["holds"]) == ("", None)  # none was stated
    aside = m["base_radius_mm"] - m["platform_radius_mm"]
    far = m["upper_arm_length_mm"] + m["forearm_length_mm"]
    assert rows["highest position on the axis"]["value"] == pytest.approx(sqrt(far**2 - aside**2))
    assert not {"motor", "friction", "effective mass", "least stiffness at the knob", "parallelogram width L_c"} & set(
        rows
    )


def test_what_is_stated_is_held(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stated = {"force_N": 9.0, "kappa_max": 2.0, "joint_torque_N_m": 0.7}
    rows = inspected(written(tmp_path, FALCON | {"requirements": stated}), capsys, code=1)
    assert rows["kappa"]["holds"] is False
    assert rows["torque for 9 N in the worst direction"]["holds"] is True


def test_hardware_is_not_looked_at(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = inspected(written(tmp_path, DATA | {"name": "delta", "hardware": {"motor": "of-another-shop"}}), capsys)
    assert rows["kappa"]["value"] == pytest.approx(2.27, abs=1e-3)


@pytest.mark.parametrize(
    ("section", "changes", "words"),
    [
        ("mechanism", {"collar_mm": 11.25}, ["mechanism.collar_mm = 11.25", "not modelled", "b + d + e"]),
        ("mechanism", {"forearm_length_mm": 30.0}, ["mechanism.forearm_length_mm = 30", "must be >="]),
        ("mechanism", {"forearm_length_mm": 2001.0}, ["forearm_length_mm = 2001", "<= 2000"]),
        ("cube", {"bottom_height_mm": None}, ["cube.bottom_height_mm"]),
    ],
)
def test_a_delta_that_is_none_is_refused(
    section: str, changes: dict[str, Any], words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, FALCON | {section: FALCON[section] | changes})
    assert main(["inspect", "--kinematics", "--design", str(path)]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert all(word in said.err for word in words), said.err


def test_without_the_flag_hardware_and_requirements_are_needed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", "--design", str(written(tmp_path, FALCON))]) == 2
    assert "parallelogram_width_mm: is missing" in capsys.readouterr().err
