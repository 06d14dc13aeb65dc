"""One verdict: `inspect`, `check`, `build` and `certify` say the same of a design whose limits are near its figures."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from delta_cad.checks.range.ranges import check_ranges
from delta_cad.commands import cli as machines
from delta_cad.commands.inspection import limit_rows
from delta_cad.commands.pipeline import check_limits
from delta_cad.design import Design, DesignError, design_from_dict, load_design
from delta_cad.dimensions import joint
from delta_cad.drive.held import known_masses
from delta_cad.drive.masses import load_masses
from delta_cad.mechanism import UnreachableError, workspace
from delta_cad.mechanism.limits import HandleFriction, Limits, Torque
from delta_cad.mechanism.proof import extremes, judgement
from delta_cad.mechanism.proof.extremes import WorstFigure, worst_figures
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.certify.certificate import certify, limits_of
from optimizer.certify.gravity import allowance_of_masses
from tests.committed import COMMITTED
from tests.designs import minimal
from tests.optimizer.certify.designs import call, masses

NEAR = 1e-4
RUBS = HandleFriction(0.004, 0.05, 0.06)
ANGLE = 0.01  # rad; an angle near 0 has no relative distance
HALVINGS = workspace.HALVINGS
TURNS = 1e-3  # couple index; below it the platform turns freely, and a limit next to it would be negative
FREE = SimpleNamespace(tilt_limit_rad=math.nextafter(math.pi / 2.0, 0.0))


def designs(seed: int) -> Iterator[Design]:
    """Draws designs whose cube is within reach and without a singularity."""
    rng = np.random.default_rng(seed)
    while True:
        arm = rng.uniform(50.0, 110.0)
        lengths = {"upper_arm_length_mm": arm, "forearm_length_mm": arm * rng.uniform(1.2, 1.8)}
        lengths |= {"base_radius_mm": rng.uniform(25.0, 50.0), "platform_radius_mm": rng.uniform(20.0, 40.0)}
        cube = {"bottom_height_mm": arm * rng.uniform(0.5, 1.3), "half_side_mm": arm * rng.uniform(0.15, 0.5)}
        try:
            design = design_from_dict(minimal() | {"mechanism": minimal()["mechanism"] | lengths, "cube": cube})
            least, crossing = CubeSearch(design.workspace, 7).singularity(design.geometry)
        except (DesignError, UnreachableError):
            continue
        if crossing is None and least.value > NEAR:
            yield design


def near(design: Design, worst: list[WorstFigure], side: float) -> tuple[Design, set[str]]:
    """States every limit at a distance from its figure's worst value, to the lax side or the strict one.

    Returns:
        The design, and the figures that are bounded.
    """
    demand: dict[str, Any] = {}
    bounded = set()
    for one in worst:
        names = [field.name for field in one.limit.fields_] or ["joint_torque_N_m"]
        if not one.figure.threshold or one.figure.name == "reach" or isinstance(one.limit, Torque):
            continue  # the torque without gravity has the same field as that with it, and is less
        size = abs(one.value) if one.figure.relative else max(abs(one.value), ANGLE)
        value = one.value + side * NEAR * size * (1.0 if one.figure.upper else -1.0)
        demand[names[one.limit.figures.index(one.figure)]] = value * one.figure.scale
        bounded.add(one.figure.name or one.limit.name)
    required = design.requirements.model_copy(update=demand)
    return design.model_copy(update={"requirements": required}), bounded


def verdicts(design: Design, path: Path) -> dict[str, dict[str, bool]]:
    """What each command says of every figure; a build runs the checks of `check`."""
    data = json.loads(path.read_text())
    rows = limit_rows(design, known_masses(data, design))
    named = {f.words: f.name or kind.name for kind in judgement.POSE_LIMITS for f in kind.figures}
    d: Any = SimpleNamespace(design=design, stops_rad=(-math.pi, math.pi), forearm=FREE)
    share = allowance_of_masses(path, design)
    proved = certify(design, limits_of(design, share, load_masses(path, design).handle_inertia), gravity=share)
    figures = {kind.name: [f.name or kind.name for f in kind.figures] for kind in judgement.POSE_LIMITS}
    checks = check_ranges(design.geometry, check_limits(d, data))
    return {
        "inspect": {named[row.quantity.split(" for ")[0]]: row.holds for row in rows if row.holds is not None},
        "check": {one.name.replace(" ", "_"): one.passed for one in checks},
        "certify": {name: f.verdict == "proved" for f in proved.findings for name in figures[f.condition]},
    }


def finely(design: Design, limits: Any) -> list[WorstFigure]:
    """The worst figures by the search as users have it: a limit next to a coarse one may lie on the other side."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(extremes, "CubeSearch", CubeSearch)
        patch.setattr(workspace, "HALVINGS", HALVINGS)
        return worst_figures(design.geometry, design.workspace, limits)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """A search that is fast and sees little: the verdict is not its."""
    monkeypatch.setattr(extremes, "CubeSearch", partial(CubeSearch, n=7))
    monkeypatch.setattr(workspace, "HALVINGS", 14)
    known = {"friction": RUBS, "encoder_count": 2.0 * math.pi / 2**21}  # bounding the ball joints' takes half a second
    monkeypatch.setattr(joint, "known_joints", lambda _: known)


@pytest.mark.usefixtures("coarse")
@pytest.mark.parametrize(
    ("seed", "count"), [(0, 5), *(pytest.param(n, 27, marks=pytest.mark.slow) for n in range(1, 12))]
)
def test_every_command_has_the_same_verdict_next_to_a_limit(seed: int, count: int, tmp_path: Path) -> None:
    source, done = designs(seed), 0
    while done < count:
        design, path = next(source), tmp_path / "mass_properties.json"
        known = known_masses(json.loads(masses(tmp_path, design, 1e-4).read_text()), design)
        limits = Limits.measured(joint.limit_values(design, known))
        worst = finely(design, limits)
        if any(one.limit.name == "couple_index" and one.value < TURNS for one in worst):
            continue
        done += 1
        for side in (1.0, -1.0):
            demand, bounded = near(design, worst, side)
            said = verdicts(demand, path)
            assert len(bounded) == 10
            for command, found in said.items():
                assert {name: found[name] for name in bounded} == dict.fromkeys(bounded, side > 0.0), command
            assert said["check"].keys() == said["certify"].keys()
            assert said["inspect"].keys() == said["check"].keys()


@pytest.mark.parametrize(("most", "code"), [(0.79974, 0), (0.7997, 1)])
def test_friction_between_the_positions_of_a_grid_is_seen_by_all(
    most: float, code: int, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The largest of 11^3 positions of the committed machine is less than the largest over its cube."""
    data = json.loads(COMMITTED.read_text())
    del data["requirements"]["effective_mass_max_kg"]
    data["requirements"]["friction_max_N"] = most
    path = tmp_path / "design.json"
    path.write_text(json.dumps(data))
    monkeypatch.chdir(tmp_path)
    assert machines.main(["inspect", "--design", str(path), "--json"]) == code
    (row,) = (row for row in json.loads(capsys.readouterr().out)["rows"] if row["quantity"] == "friction")
    assert row["holds"] is (code == 0)
    assert call("certify", "--design", path, "--out", tmp_path / "certificate.json") == code
    design = load_design(path)
    d: Any = SimpleNamespace(design=design, stops_rad=(-math.pi, math.pi), forearm=FREE)
    built = check_limits(d, json.loads(masses(tmp_path, design, 1e-4).read_text()))
    found = {one.name: one for one in check_ranges(design.geometry, built)}["friction"]
    assert found.passed is (code == 0)
    assert found.value == row["value"] == pytest.approx(0.799730, abs=5e-6)
    limit = built.pose["friction"]
    on_grid = limit.figures[0].worst(limit, design.geometry, built.poses_mm() / 1e3).max()
    assert on_grid < 0.7997 < (found.value or 0.0)


def test_without_the_compiler_the_search_decides_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """As with an installation that has no numba: the same verdicts, which nothing proved."""
    design = design_from_dict(minimal())
    tight = {"kappa_max": 2.26, "lean_max_deg": 28.0, "shoulder_max_deg": 65.0, "shoulder_min_deg": -45.0}
    demand = design.model_copy(update={"requirements": design.requirements.model_copy(update=tight)})
    proved = limit_rows(demand)
    monkeypatch.setattr(judgement, "find_spec", lambda _: None)
    monkeypatch.setattr(judgement, "prove", None)
    searched = limit_rows(demand)
    assert [(row.quantity, row.holds, row.value) for row in searched] == [
        (row.quantity, row.holds, pytest.approx(row.value, rel=1e-9)) for row in proved
    ]
    assert [row.quantity for row in searched if row.holds is False] == ["kappa", "shoulder, largest"]
    assert {"not proved" in row.group for row in searched} == {True}
    assert {"not proved" in row.group for row in proved} == {False}
