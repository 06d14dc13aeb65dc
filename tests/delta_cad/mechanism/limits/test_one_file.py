"""A limit is one file and its line in the list: docs/extend/limit.diff in a copy of the packages, proved, replayed."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from delta_cad.common.numba_code.kept import PACKAGES, ROOT
from delta_cad.mechanism import Cube, cube_extremes
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED

EXAMPLE = ROOT / "docs" / "extend" / "limit.diff"
TRIAL = """
import json
import numpy as np
from delta_cad.design.file import DesignRequirements
from delta_cad.mechanism import Cube, DeltaGeometry, elbow_positions, inverse_kinematics
from delta_cad.mechanism.limits import LIMITS, Limits
from delta_cad.mechanism.proof.extremes import worst_figures
from delta_cad.mechanism.proof.prove import prove
from optimizer.certify.replay import breaks, replay
from optimizer.problem.evaluator import figures
from optimizer.commands.synthesize import _summary
from optimizer.problem.requirements import LimitTable, requirements_from_dict
from optimizer.problem.step import step_problem
from optimizer.search.result import Result

FIELD = "elbow_height_max_mm"
g, cube = DeltaGeometry(0.040, 0.030, 0.082, 0.112079), Cube(0.057112, 0.0375)
worst = next(w for w in worst_figures(g, cube, Limits.measured({"force_N": 3.0})) if w.figure.name == "elbow_height")
out = {"worst": worst.value, "searched": [], "said": []}
out["fields"] = [FIELD in table.model_fields for table in (LimitTable, DesignRequirements)]
middle = np.array([0.0, 0.0, cube.bottom_height + cube.half_side])
place = (np.array([worst.position]) - middle) / cube.half_side
seen = figures(np.array([[0.082, 0.112079, 0.040, 0.030, cube.bottom_height, cube.half_side]]), place)
for share in (1.001, 0.999):
    stated = Limits.stated({"force_N": 3.0, "joint_torque_N_m": 9.0, "elbow_height_max_mm": 1e3 * share * worst.value})
    stated = Limits.from_record(json.loads(json.dumps(stated.record())))
    limit = stated["elbow_height"]
    proof = prove(g, cube, Limits.of(limit))
    found = next(f for f in proof.findings if f.condition == "elbow_height")
    out["searched"].append(float(limit.margin(seen)[0, 0]))
    out["said"].append(limit.words(lambda value, upwards: f"{value:.2f}"))
    if share > 1.0:
        low = np.array([-cube.half_side, 0.0, cube.bottom_height])
        size = (cube.upper - low) / 2.0 ** proof.leaves[:, ::2]
        low = low + proof.leaves[:, 1::2] * size
        out["proved"] = [found.verdict, replay(g, [limit], low, low + size)[1]]
        leaves = low, low + size
        allowed = limit
    else:
        point = np.array(found.point)
        again = replay(g, [limit], *leaves, max_boxes=5_000)[1]
        height = elbow_positions(g, inverse_kinematics(g, point))[:, 2].max()
        out["refuted"] = [found.verdict, breaks(g, limit, point), breaks(g, allowed, point), again.condition]
        out["heights"] = [found.limit, found.value, height]
        out["less strict"] = Limits.of(allowed).less_strict_than(Limits.of(limit))
ranges = {"upper_arm_length": 82.0, "forearm_length": 112.079, "base_radius": 40.0, "platform_radius": 30.0}
ranges |= {"bottom_height": 57.112, "half_side": 37.5}
values = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0, "force_N": 3.0, "joint_torque_N_m": 9.0}
task = {"name": "one", "requirements": values, "bounds_mm": {name: [mm, mm] for name, mm in ranges.items()}}
task["limits"] = {FIELD: 1e3 * worst.value}
result = Result(step_problem(requirements_from_dict(task), 2), "sqp", tuple(ranges.values()), "converged")
out["reported"] = [result.record()["max_elbow_height_mm"], _summary(result)]
print(json.dumps(out))
"""


def with_the_example(folder: Path) -> Path:
    """A copy of the packages with the example's file and its lines in the list."""
    for name in PACKAGES:
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("__pycache__"))
    subprocess.run(["git", "apply", "--include=delta_cad/*", EXAMPLE], cwd=folder, check=True)
    return folder


@pytest.mark.slow
def test_its_file_and_its_line_are_all_that_a_limit_needs(tmp_path):
    copy = with_the_example(tmp_path / "copy")
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path / "compiled"), "NUMBA_OPT": "1"}
    process = subprocess.run([sys.executable, "-c", TRIAL], cwd=copy, env=environment, capture_output=True, text=True)
    assert process.stderr == ""
    found = json.loads(process.stdout)
    assert found["fields"] == [True, True]
    highest = cube_extremes(PUBLISHED, Cube(BOTTOM, HALF), 3.0).elbow_z_max.value
    assert found["worst"] == pytest.approx(highest, rel=1e-12)
    assert found["proved"] == ["proved", None]
    assert found["refuted"] == ["refuted", True, False, "elbow_height"]
    limit, value, height = found["heights"]
    assert limit == pytest.approx(0.999 * found["worst"], rel=1e-12)
    assert value == pytest.approx(height, rel=1e-12)
    assert limit < height <= found["worst"] * (1.0 + 1e-9)
    assert found["searched"] == pytest.approx([share * highest / 0.082 for share in (0.001, -0.001)], rel=1e-9)
    assert found["less strict"] == "elbow_height"
    mm, line = found["reported"]
    assert mm == pytest.approx(1e3 * highest, rel=1e-9)
    assert f", elbow height {mm:.4g} mm; converged" in line
    assert [f"elbow height <= {1e3 * share * found['worst']:.2f} mm" for share in (1.001, 0.999)] == found["said"]
