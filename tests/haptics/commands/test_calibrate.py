"""The command `calibrate`: what it writes, what it refuses, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.calibration.poses import Poses
from haptics.calibration.record import load_calibration
from haptics.commands.cli import main
from tests.committed import BEST
from tests.designs import below_elbows
from tests.haptics.calibration.devices import cube_points, made, measured, poses_text
from tests.haptics.calibration.test_accuracy import on_a_line


@pytest.fixture
def poses(best: Design) -> Poses:
    rng = np.random.default_rng(1)
    return measured(made(best, rng), cube_points(best, rng, 40), rng)


def ran(folder: Path, poses: Poses, *more: str) -> tuple[int, Path]:
    path, out = folder / "poses.csv", folder / "calibration.json"
    path.write_text(poses_text(poses))
    return main(["calibrate", "--design", str(BEST), str(path), "--out", str(out), *more]), out


def test_it_writes_what_it_found(
    best: Design, poses: Poses, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, out = ran(tmp_path, poses, "--json")
    facts = json.loads(capsys.readouterr().out)
    assert code == 0
    assert facts["passed"]
    assert facts["fit"]["after_rms_mm"] < 0.1 * facts["fit"]["before_rms_mm"]
    assert any("base_radius_0" in one for one in facts["not_told"])
    found = load_calibration(out, best)
    assert found.unknowns.table[0, 2] * 1e3 == pytest.approx(facts["chains"][0]["upper_arm_length_mm"])
    assert ran(tmp_path, poses)[0] == 0
    table = capsys.readouterr().out
    assert "forearm_length_mm" in table
    assert "+-" in table


def test_a_wrong_pose_is_named_and_nothing_written(
    poses: Poses, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    poses.positions[7, 1] += 0.003
    code, out = ran(tmp_path, poses, "--json")
    facts = json.loads(capsys.readouterr().out)
    assert (code, facts["fit"]["worst_pose"], facts["file"]) == (1, 8, None)
    assert [cause["kind"] for cause in facts["causes"]] == ["label"]
    assert not out.exists()


def test_a_platform_that_hangs_is_refused_as_everywhere(
    poses: Poses, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "hanging.json"
    path.write_text(json.dumps(below_elbows()))
    assert ran(tmp_path, poses, "--design", str(path))[0] == 2
    reported = capsys.readouterr().err
    assert reported.startswith("hanging.json: cube.bottom_height_mm = 34.5: must have the assembly mode det S > 0")
    assert "also at (0.0, 0.0, 40.7) mm" in reported
    assert reported.count("\n") == 1


def test_bad_input_is_one_line(poses: Poses, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    few = Poses(poses.positions[:5], poses.readings[:5])
    for given, more in ((few, ()), (poses, ("--position-sigma", "0")), (poses, ("--frame", "mine"))):
        try:
            code = ran(tmp_path, given, *more)[0]
        except SystemExit as end:
            code = int(str(end.code))
        said = capsys.readouterr()
        assert (code, said.out) == (2, "")
        assert said.err.count("\n") == 1
    assert main(["calibrate", "--design", str(BEST), str(tmp_path / "no.csv")]) == 2
    assert "no.csv" in capsys.readouterr().err


def test_poses_on_a_line_fit_and_are_not_kept(best: Design, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The residual is that of good poses; the error over the cube is not, and the proposed poses mend it."""
    rng = np.random.default_rng(1)
    device = made(best, rng)
    p = on_a_line(best, cube_points(best, rng, 60))
    code, out = ran(tmp_path, measured(device, p, rng), "--json")
    facts = json.loads(capsys.readouterr().out)
    assert (code, facts["passed"], facts["file"], out.exists()) == (1, False, None, False)
    assert facts["fit"]["misfit"] < 1.5
    assert facts["fit"]["after_rms_mm"] < 0.05
    assert facts["fit"]["predicted_worst_mm"] > facts["accuracy_max_mm"] == 0.1
    more = facts["helpful_poses"]
    assert more["predicted_worst_mm"] <= 0.1
    both = measured(device, np.vstack([p, np.array(more["positions_mm"]) / 1e3]), rng)
    assert ran(tmp_path, both)[0] == 0
    assert out.exists()
    out.unlink()
    assert ran(tmp_path, measured(device, p, rng), "--accuracy", "5")[0] == 0  # knowingly
    capsys.readouterr()
    assert ran(tmp_path, measured(device, p, rng))[0] == 1
    assert "measure as well" in capsys.readouterr().out


def test_radians_are_named_with_the_refusal(poses: Poses, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, out = ran(tmp_path, Poses(poses.positions, np.radians(poses.readings)))
    said = capsys.readouterr()
    assert (code, said.out, said.err.count("\n"), out.exists()) == (2, "", 1, False)
    assert "the readings are in radians" in said.err
