"""Assembly mode: det S > 0 in the whole cube, against the position that forward kinematics returns."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.range.forward import check_forward
from delta_cad.checks.range.ranges import check_ranges
from delta_cad.commands.cli import main
from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    direct_margin,
    forward_kinematics,
    inverse_kinematics,
    joint_angles,
)
from delta_cad.mechanism.enclosure.interval import exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.limits import AssemblyMode
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import cube_grid
from tests.delta_cad.mechanism.limits.proving import poses
from tests.delta_cad.mechanism.stated_limits import limits
from tests.designs import below_elbows, minimal

OTHER_ASSEMBLY = DeltaGeometry(0.056, 0.024, 0.099, 0.087)
CUBE = Cube(0.0345, 0.0095)
"""A cube within reach and without a singularity, whose platform hangs below its elbows."""


def test_forward_kinematics_returns_another_position_than_that_of_a_platform_below_its_elbows() -> None:
    p = cube_grid(CUBE, 5)
    back = forward_kinematics(OTHER_ASSEMBLY, joint_angles(OTHER_ASSEMBLY, p))
    assert np.linalg.norm(back - p, axis=-1).min() > 0.02
    assert np.isnan(inverse_kinematics(OTHER_ASSEMBLY, p, off_branch="nan")).all()


def test_a_platform_below_its_elbows_is_refuted_by_its_assembly_mode_alone() -> None:
    proof = prove(OTHER_ASSEMBLY, CUBE, limits())
    assert [(f.condition, f.verdict) for f in proof.findings] == [("reach", "proved"), ("assembly_mode", "refuted")]
    finding = proof.findings[1]
    assert finding.value is not None
    assert finding.value < -0.5
    assert (np.array(finding.point) >= CUBE.lower).all()
    assert (np.array(finding.point) <= CUBE.upper).all()


def test_both_checks_refuse_a_platform_below_its_elbows() -> None:
    given = CheckLimits(34.5, 9.5, 300.0, 300.0, pose=limits())
    found = {r.name: r for r in check_ranges(OTHER_ASSEMBLY, given)}
    assert found["reach"].passed
    assert not found["assembly mode"].passed
    assert found["assembly mode"].value is not None
    assert found["assembly mode"].value < -0.5
    forward = check_forward(OTHER_ASSEMBLY, given)
    assert not forward.passed
    assert forward.value is not None
    assert forward.value > 20.0
    sound = check_forward(DeltaGeometry(0.04, 0.03, 0.082, 0.112079), CheckLimits(57.112, 37.5, 300.0, 300.0))
    assert sound.passed


def test_inspect_names_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for data, code in ((below_elbows(), 1), (minimal(), 0)):
        path = tmp_path / "design.json"
        path.write_text(json.dumps(data))
        assert main(["inspect", "--design", str(path), "--json"]) == code
        rows = {row["quantity"]: row for row in json.loads(capsys.readouterr().out)["rows"]}
        row = rows["assembly mode, det S / L_B^3"]
        assert row["limit"] == "> 0"
        assert row["holds"] is (code == 0)
        assert (row["value"] > 0.0) is (code == 0)


def test_the_second_arithmetic_sees_the_sign_at_a_position() -> None:
    modes = set()
    for g, p in poses(np.random.default_rng(3), 40, 1e-4):
        pose, above = SlopePose(g, p[None], p[None]), bool(direct_margin(g, p) > 0.0)
        assert bool(AssemblyMode().proved_by_intervals(pose, exactly)[0]) is above
        assert AssemblyMode().refuted_by_intervals(pose, exactly) is not above
        modes.add(above)
    assert modes == {True, False}
