"""`inspect --kinematics`: anybody's delta by lengths and a cube, in the conventions of others, without hardware."""

from __future__ import annotations

import json
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.commands.cli import main
from delta_cad.commands.kinematic import CollaredDelta
from delta_cad.design.lengths import lengths_from_dict
from delta_cad.mechanism import (
    DeltaGeometry,
    conditioning,
    forward_kinematics,
    inverse_kinematics,
    jacobian,
    worst_joint_torque,
)
from delta_cad.mechanism.inverse import elbow_positions, wrist_positions
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
        ("mechanism", {"collar_mm": 11.25}, ["mechanism.collar_mm = 11.25", "collar_elbow_mm and collar_wrist_mm"]),
        ("mechanism", {"collar_elbow_mm": -1.0}, ["mechanism.collar_elbow_mm = -1", ">= 0 and <= 3000 mm"]),
        ("mechanism", {"forearm_length_mm": 30.0}, ["mechanism.forearm_length_mm = 30", "must be >="]),
        ("mechanism", {"forearm_length_mm": 3001.0}, ["forearm_length_mm = 3001", "<= 3000 mm"]),
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


COLLARS = {"collar_elbow_mm": 11.25, "collar_wrist_mm": 11.25}
WITH_COLLARS = FALCON | {
    "mechanism": FALCON["mechanism"] | COLLARS,
    "cube": {"bottom_height_mm": 90.0, "half_side_mm": 25.0},
}


def falcon(collars_mm: float = 22.5) -> CollaredDelta:
    return CollaredDelta(DeltaGeometry(0.03723, 0.014, 0.06, 0.1025), collars_mm / 1e3)


def falcon_positions() -> np.ndarray:
    return np.random.default_rng(44).uniform([-0.03, -0.03, 0.09], [0.03, 0.03, 0.14], (200, 3))


def test_collars_close_their_chains_by_the_equation_of_libnifalcon() -> None:
    """(rho - d - e)^2 + v^2 = b^2 of elbows that the angles alone place, and bars of length b from one to the other."""
    delta, p = falcon(), falcon_positions()
    pose, g = delta.pose(p), delta.geometry
    apart = wrist_positions(g, p) - elbow_positions(g, pose.theta)
    v = (apart * g.tangential).sum(axis=-1)
    rho = np.sqrt((apart**2).sum(axis=-1) - v**2)
    assert (rho - delta.collars) ** 2 + v**2 == pytest.approx(np.full_like(v, 0.1025**2), rel=1e-12)
    assert np.linalg.norm(pose.bars, axis=-1) == pytest.approx(np.full_like(v, 0.1025), rel=1e-12)
    assert delta.in_reach(p).all()


def test_the_jacobian_of_a_delta_with_collars_is_that_of_its_angles() -> None:
    """By differences of the angles, which know no bars."""
    delta, p, step = falcon(), falcon_positions(), 1e-6
    steps = step * np.eye(3)
    slopes = [(delta.pose(p + way).theta - delta.pose(p - way).theta) / (2 * step) for way in steps]
    by_difference = np.stack(slopes, axis=-1)
    product = delta.jacobian(p) @ by_difference
    assert product == pytest.approx(np.broadcast_to(np.eye(3), product.shape), abs=1e-6)


def test_without_collars_all_is_as_in_the_mechanism() -> None:
    delta, p = falcon(0.0), falcon_positions()
    g = delta.geometry
    assert delta.pose(p).theta == pytest.approx(inverse_kinematics(g, p), abs=1e-12)
    assert delta.jacobian(p) == pytest.approx(jacobian(g, p), rel=1e-9)
    assert delta.conditioning(p) == pytest.approx(conditioning(g, p), rel=1e-9)
    assert delta.worst_torque(p, 3.0) == pytest.approx(worst_joint_torque(g, p, 3.0), rel=1e-9)
    low = np.array([[0.0, 0.0, 0.02], [0.3, 0.0, 0.1], [0.0, 0.0, -0.1]])
    assert delta.in_reach(low).tolist() == np.isfinite(inverse_kinematics(g, low, "nan")).all(axis=-1).tolist()


def test_the_falcon_is_inspected_with_its_collars(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rows = inspected(written(tmp_path, WITH_COLLARS), capsys)
    delta, axis = falcon(), np.linspace(-0.025, 0.025, 21)
    p = np.stack(np.meshgrid(axis, axis, axis + 0.115), axis=-1).reshape(-1, 3)
    pose = delta.pose(p)
    assert rows["kappa"]["value"] == pytest.approx(delta.conditioning(p).max(), rel=2e-3)
    assert rows["shoulder, smallest"]["value"] == pytest.approx(np.degrees(pose.theta.min()), abs=0.05)
    assert rows["shoulder, largest"]["value"] == pytest.approx(np.degrees(pose.theta.max()), abs=0.05)
    assert rows["lean"]["value"] == pytest.approx(np.degrees(np.abs(pose.lean).max()), abs=0.05)
    assert rows["collar at the elbow, from its axis to the bars"]["value"] == 11.25
    radius = rows["radius that is reached all round, at the height of the cube's middle"]["value"] / 1e3
    way = np.linspace(0.0, 2.0 * np.pi, 721)
    around = np.stack([np.cos(way), np.sin(way), np.zeros_like(way)], axis=-1)
    assert delta.in_reach(0.999 * radius * around + [0.0, 0.0, 0.115]).all()
    assert not delta.in_reach(1.002 * radius * around + [0.0, 0.0, 0.115]).all()
    without = inspected(written(tmp_path, WITH_COLLARS | {"mechanism": FALCON["mechanism"]}), capsys)
    assert abs(without["kappa"]["value"] - rows["kappa"]["value"]) > 0.01


def test_limits_of_a_delta_with_collars_are_held_or_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stated = {"kappa_max": 2.0, "shoulder_max_deg": 80.0}
    rows = inspected(written(tmp_path, WITH_COLLARS | {"requirements": stated}), capsys, code=1)
    assert (rows["kappa"]["holds"], rows["shoulder, largest"]["holds"]) == (False, True)
    path = written(tmp_path, WITH_COLLARS | {"requirements": {"couple_index_min": 0.4}})
    assert main(["inspect", "--kinematics", str(path)]) == 2
    assert "requirements.couple_index_min = 0.4: is not computed" in capsys.readouterr().err
    path = written(tmp_path, WITH_COLLARS | {"cube": {"bottom_height_mm": 90.0, "half_side_mm": 60.0}})
    assert main(["inspect", "--kinematics", str(path)]) == 2
    assert "make the cube smaller or move it" in capsys.readouterr().err


TRIANGLES = {
    "base_side_mm": 567.0, "base_joints_at": "middles", "platform_side_mm": 76.0, "platform_joints_at": "corners",
    "upper_arm_length_mm": 524.0, "forearm_length_mm": 1244.0,
}  # fmt: skip
"""FlexPicker IRB 360 of R. L. Williams, The Delta Parallel Robot, 2016, table 1: s_B, s_P, L and l."""


def test_triangles_of_the_classic_delta_stand_for_radii(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    own = lengths_from_dict({"mechanism": TRIANGLES, "cube": FLEXPICKER["cube"]}).design
    # angles and positions of the DeltaKin notes (Pieces98/Deltarobot_Kinematics), z down and the first arm along -y
    for angles, (x, y, z) in (
        ((10.0, 20.0, 30.0), (108.1354, -180.3484, -1243.5413)),
        ((0.0, 0.0, 60.0), (619.5159, -357.6777, -1040.1298)),
    ):
        found = forward_kinematics(own.geometry, np.radians(angles)) * 1e3
        assert found == pytest.approx([-y, x, -z], abs=1e-3)
    (tmp_path / "delta.json").write_text(json.dumps({"mechanism": TRIANGLES, "cube": FLEXPICKER["cube"]}))
    assert main(["inspect", "--kinematics", str(tmp_path / "delta.json"), "--json"]) == 0
    by_sides = {row["quantity"]: row["value"] for row in json.loads(capsys.readouterr().out)["rows"]}
    rows = inspected(written(tmp_path, FLEXPICKER), capsys)
    for quantity in ("kappa", "lean", "shoulder, largest", "highest position on the axis"):
        assert by_sides[quantity] == pytest.approx(rows[quantity]["value"], rel=1e-4)


def test_a_difference_of_radii_is_all_that_is_needed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Klipper's example-rotary-delta.cfg states R - r = 33.9 alone."""
    arms = {"upper_arm_length_mm": 170.0, "forearm_length_mm": 320.0}
    cube = {"bottom_height_mm": 270.0, "half_side_mm": 30.0}
    rows = inspected(written(tmp_path, {"mechanism": arms | {"radius_difference_mm": 33.9}, "cube": cube}), capsys)
    radii = {"base_radius_mm": 133.9, "platform_radius_mm": 100.0}
    same = inspected(written(tmp_path, {"mechanism": arms | radii, "cube": cube}), capsys)
    assert rows["kappa"]["value"] == pytest.approx(same["kappa"]["value"], rel=1e-9)
    assert rows["base radius less platform radius, R - r"]["value"] == 33.9
    assert not {"base radius R", "platform radius r"} & set(rows)
    inwards = lengths_from_dict({"mechanism": arms | {"radius_difference_mm": -20.0}, "cube": cube}).design.mechanism
    assert inwards.base_radius_mm - inwards.platform_radius_mm == pytest.approx(-20.0)


def test_a_delta_of_three_metres_is_inspected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Lengths in proportion have the figures of the small one."""
    scale = 3000.0 / 1244.0
    large = {part: {key: scale * value for key, value in FLEXPICKER[part].items()} for part in FLEXPICKER}
    large["mechanism"]["forearm_length_mm"] = 3000.0
    rows, small = (inspected(written(tmp_path, data), capsys) for data in (large, FLEXPICKER))
    assert rows["kappa"]["value"] == pytest.approx(small["kappa"]["value"], rel=1e-6)
    assert rows["highest position on the axis"]["value"] == pytest.approx(
        scale * small["highest position on the axis"]["value"]
    )


def test_the_workspace_is_what_the_inverse_kinematics_reaches(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    rows = inspected(written(tmp_path, FALCON), capsys)
    random = np.random.default_rng(1)
    low, high = np.array([-0.2, -0.2, 0.0]), np.array([0.2, 0.2, 0.1625])
    p = random.uniform(low, high, (200_000, 3))
    g = DeltaGeometry(0.03723, 0.014, 0.06, 0.1025)
    share = np.isfinite(inverse_kinematics(g, p, "nan")).all(axis=-1).mean()
    volume = rows["volume, elbows outwards and the platform above them"]["value"]
    assert volume == pytest.approx(share * float(np.prod(high - low)) * 1e3, rel=0.03)


@pytest.mark.parametrize(
    ("mechanism", "words"),
    [
        (TRIANGLES | {"base_joints_at": "sides"}, ['base_joints_at = "sides"', '"corners" or "middles"']),
        ({k: v for k, v in TRIANGLES.items() if k != "platform_joints_at"}, ["platform_joints_at: is missing"]),
        (TRIANGLES | {"base_radius_mm": 100.0}, ["mechanism.base_side_mm = 567", "leave one of both out"]),
        (TRIANGLES | {"base_side_mm": 1e5}, ["mechanism.base_side_mm = 100000", "<= 10392.3 mm"]),
        (TRIANGLES | {"radius_difference_mm": 9.0}, ["radius_difference_mm = 9", "base_radius_mm"]),
        (
            FALCON["mechanism"] | {"platform_joints_at": "corners"},
            ["platform_joints_at", "needs mechanism.platform_side"],
        ),
        ("lengths", ["mechanism"]),
    ],
)
def test_a_convention_that_is_not_clear_is_refused_in_one_line(
    mechanism: Any, words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, FLEXPICKER | {"mechanism": mechanism})
    assert main(["inspect", "--kinematics", str(path)]) == 2
    said = capsys.readouterr().err
    assert len(said.strip().splitlines()) == 1
    assert all(word in said for word in words), said


def test_one_file_is_inspected(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = written(tmp_path, FALCON)
    assert main(["inspect", "--kinematics", str(path), "--json"]) == 0
    named = capsys.readouterr().out
    assert main(["inspect", "--kinematics", "--design", str(path), "--json"]) == 0
    assert capsys.readouterr().out == named
    with pytest.raises(SystemExit) as ended:
        main(["inspect", "--kinematics", str(path), "--design", str(path)])
    assert ended.value.code == 2
    assert main(["inspect", "--kinematics", str(path), "--catalogue", str(tmp_path)]) == 2
    assert main(["inspect", "--kinematics", str(tmp_path / "none.json")]) == 2


def test_without_the_flag_hardware_and_requirements_are_needed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["inspect", "--design", str(written(tmp_path, FALCON))]) == 2
    assert "parallelogram_width_mm: is missing" in capsys.readouterr().err
