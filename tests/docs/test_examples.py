"""The examples and the README's code run as they stand, and their numbers hold against something else."""

from __future__ import annotations

import json
import re
import shutil
import sys
from pathlib import Path
from runpy import run_path
from typing import Any

import numpy as np
import pytest

from delta_cad.commands.cli import main as delta_cad_main
from delta_cad.commands.inspection import inspection
from delta_cad.design import load_design
from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    conditioning,
    cube_grid,
    elbow_positions,
    forward_kinematics,
    inverse_kinematics,
    worst_joint_torque,
)
from delta_cad.mechanism.limits.effective_mass import HandleInertia, handle_inertia
from haptics.gravity import potential_energy
from tests.committed import COMMITTED, ROOT, Built

STEP = 1e-6  # rad, of central differences: errors of 1e-12 relative, and 1e-16 / 1e-6 from rounding
DIFFERENCES = 1e-8  # m/rad or J/rad, with room over both


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A folder with a copy of best.json, so that nothing is written into the project's."""
    shutil.copy(COMMITTED, tmp_path)
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")


def example(name: str, monkeypatch: pytest.MonkeyPatch, *arguments: str | Path) -> dict[str, Any]:
    """What an example's names stand for after its run."""
    monkeypatch.setattr(sys, "argv", [name, *map(str, arguments)])
    return run_path(str(ROOT / "examples" / f"{name}.py"), run_name="__main__")


def numeric_jacobian(g: DeltaGeometry, theta: np.ndarray) -> np.ndarray:
    """(3, 3) by central differences of the forward kinematics, m/rad."""
    turns = STEP * np.eye(3)
    return (forward_kinematics(g, theta + turns) - forward_kinematics(g, theta - turns)).T / (2.0 * STEP)


def vertical_mass_kg(g: DeltaGeometry, p: np.ndarray, what: HandleInertia) -> float:
    """Twice the kinetic energy of a handle that goes up by 1 m/s, joints and elbows by central differences."""
    up = STEP * np.array([0.0, 0.0, 1.0])
    theta = [inverse_kinematics(g, p + sign * up) for sign in (1.0, -1.0)]
    turn = (theta[0] - theta[1]) / (2.0 * STEP)
    elbow = (elbow_positions(g, theta[0]) - elbow_positions(g, theta[1])) / (2.0 * STEP)
    at_elbow = what.elbow_mass * (elbow**2).sum() + 2.0 * what.cross_mass * elbow[:, 2].sum()
    return what.carried_mass + at_elbow + what.joint_inertia * (turn**2).sum()


def sampled(cube: Cube) -> np.ndarray:
    return cube_grid(cube, 9).reshape(-1, 3)


def test_kinematics(monkeypatch: pytest.MonkeyPatch) -> None:
    ran = example("kinematics", monkeypatch)
    g, p, theta = ran["g"], ran["p"], ran["theta"]
    m = json.loads((ROOT / "best.json").read_text())["mechanism"]
    for i, phi in enumerate(np.radians(m["azimuths_deg"])):
        out = np.array([np.cos(phi), np.sin(phi), 0.0])
        elbow = (m["base_radii_mm"][i] / 1e3 + g.upper_arm_length * np.cos(theta[i])) * out
        elbow[2] = g.upper_arm_length * np.sin(theta[i])
        assert np.linalg.norm(p + g.platform_radius * out - elbow) == pytest.approx(g.forearm_length, abs=1e-15)
    J = numeric_jacobian(g, theta)
    assert ran["J"] == pytest.approx(J, abs=DIFFERENCES)
    assert ran["torque"] == pytest.approx(J.T @ [0.0, 0.0, 3.0], abs=3.0 * DIFFERENCES)
    assert ran["worst"] == pytest.approx(3.0 * np.linalg.norm(J, axis=0).max(), abs=3.0 * DIFFERENCES)
    assert ran["kappa"] == pytest.approx(np.linalg.cond(J), rel=1e-5)  # DIFFERENCES over the smallest singular value


def test_prove_cube(monkeypatch: pytest.MonkeyPatch) -> None:
    ran = example("prove_cube", monkeypatch)
    g, cube = ran["design"].geometry, ran["cube"]
    assert {f.condition: f.verdict for f in ran["proof"].findings} == dict.fromkeys(
        ("reach", "assembly_mode", "torque", "kappa", "lean"), "proved"
    )
    kappa = conditioning(g, sampled(cube))
    assert 2.0 < kappa.max() <= 2.27
    (broken,) = (f for f in ran["refuted"].findings if f.verdict == "refuted")
    point = np.array(broken.point)
    assert (point >= cube.lower).all()
    assert (point <= cube.upper).all()
    assert conditioning(g, point) == pytest.approx(broken.value)
    assert broken.value > broken.limit == 2.0


def test_synthesize(monkeypatch: pytest.MonkeyPatch) -> None:
    ran = example("synthesize", monkeypatch)
    first, second = ran["results"]
    assert second.objective < first.objective
    for result in (first, second):
        assert result.objective <= result.proof.bound <= result.objective * (1.0 + 1e-4)  # ten times the gap asked
    design = ran["design"]
    assert design.cube.half_side_mm == pytest.approx(second.objective, abs=2e-3)  # whole micrometres
    cube = Cube(design.cube.bottom_height_mm / 1000.0, design.cube.half_side_mm / 1000.0)
    p = sampled(cube)
    assert conditioning(design.geometry, p).max() <= 2.5
    assert worst_joint_torque(design.geometry, p, force=3.0).max() <= 0.8


def test_gravity(monkeypatch: pytest.MonkeyPatch, committed: Built) -> None:
    ran = example("gravity", monkeypatch, committed.folder / "mass_properties.json")
    g, masses, tilt = ran["machine"].geometry, ran["machine"].masses, ran["tilt"]
    assert ran["level"][:, 1] == pytest.approx(ran["level"][:, 2], abs=1e-12)  # mirror images
    fields = {"level": [0.0, 0.0, -9.81], "tilted": [9.81 * np.sin(tilt), 0.0, -9.81 * np.cos(tilt)]}
    theta = inverse_kinematics(g, ran["p"])
    for name, gravity in fields.items():
        for i, turn in enumerate(STEP * np.eye(3)):
            above, below = (forward_kinematics(g, theta + sign * turn) for sign in (1.0, -1.0))
            energy = potential_energy(g, masses, above, gravity) - potential_energy(g, masses, below, gravity)
            assert ran[name][:, i] == pytest.approx(energy / (2.0 * STEP), abs=DIFFERENCES)


def test_wall(monkeypatch: pytest.MonkeyPatch, committed: Built) -> None:
    ran = example("wall", monkeypatch, committed.folder / "mass_properties.json")
    depth = ran["depth"]
    machine, centre = ran["machine"], ran["centre"]
    # by symmetry the other entries of the column are 0
    mass = handle_inertia(machine.geometry, centre, machine.masses.handle_inertia)[2, 2]
    assert mass == pytest.approx(vertical_mass_kg(machine.geometry, centre, machine.masses.handle_inertia), rel=1e-6)
    assert depth[-1] == pytest.approx(2.0, abs=1e-3)  # mm; what is left swings with exp(-28 t)
    period = ran["device"].period
    touch = (np.argmax(depth > 0) - 1) * period  # the path begins with the centre, before the first tick
    assert touch == pytest.approx(np.sqrt(2.0 * 0.005 * mass / 2.0), abs=period)  # 2 N over 5 mm
    undamped = 2.0 + np.sqrt(2.0**2 + 2.0 * 2.0 * 5.0)  # mm: the push's work over the way goes into the spring
    assert 4.0 < depth.max() < undamped


def test_conditioning_map(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    ran = example("conditioning_map", monkeypatch, tmp_path / "map.png")
    kappa, inside = ran["kappa"], ran["inside"]
    assert np.nanmin(kappa) >= 1.0
    assert kappa[inside].max() <= 2.27
    assert (tmp_path / "map.png").read_bytes().startswith(b"\x89PNG")


def test_own_parts(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    ran = example("own_parts", monkeypatch)
    after = ran["after"]
    assert (after.motor, after.cable) == ("example-30", "example-rope")
    ratio = ran["design"].hardware.capstan_ratio
    assert after.continuous_torque_N_m == pytest.approx(ratio * 0.96 * 0.07)  # ratio, efficiency, the row's torque
    assert after.reflected_inertia_kg_m2 == pytest.approx(ratio**2 * 3e-6)
    capsys.readouterr()
    for folder in (None, ROOT / "examples" / "my-parts"):
        rows = inspection(load_design(Path("own.json"), folder))
        assert any(row.value == pytest.approx(after.continuous_torque_N_m) for row in rows)
    assert delta_cad_main(["inspect", "--design", "own.json", "--catalogue", "."]) == 2
    assert "--catalogue" in capsys.readouterr().err


def test_readme() -> None:
    (code,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(encoding="utf-8"), re.DOTALL)
    names: dict[str, Any] = {}
    exec(code, names)
    assert names["p"] == pytest.approx([0.0, 0.0, 0.095], abs=1e-15)
    assert names["theta"] == pytest.approx(np.repeat(names["theta"][0], 3), abs=1e-14)
    assert names["J"] == pytest.approx(numeric_jacobian(names["g"], names["theta"]), abs=DIFFERENCES)


def test_every_example_is_run() -> None:
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in (ROOT / "examples").glob("*.py")} <= tested
