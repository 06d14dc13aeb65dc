"""`python -m haptics gravity`: facts, exit codes, one-line refusals."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from delta_cad.common.command_line import with_negatives
from delta_cad.design import Design, load_design
from delta_cad.drive.masses import MassError, PointMasses, load_masses
from haptics.commands.cli import main
from haptics.gravity import gravity_torque
from haptics.model.machine import load_machine
from tests.committed import BEST, Built, changed
from tests.designs import below_elbows
from tests.haptics.model.textbook import STEP, textbook
from tests.haptics.scene_machine import PLACED
from tests.terminal import said


def call(*arguments: object) -> int:
    try:
        return main([str(argument) for argument in arguments])
    except SystemExit as ended:
        return int(ended.code or 0)


@pytest.fixture(scope="module")
def masses(built: Built) -> Path:
    return built.folder / "mass_properties.json"


def test_it_tells_the_torques(masses: Path, best: Design, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("gravity", "--design", BEST, "--mass-properties", masses, "--at", "-10,5,90", "--json") == 0
    facts = json.loads(capsys.readouterr().out)
    known = load_masses(masses, best)
    expected = gravity_torque(best.geometry, known, [-0.010, 0.005, 0.090], best.requirements.gravity_m_s2)
    assert facts["holding_torque_N_m"] == pytest.approx(expected.tolist(), rel=1e-12)
    assert facts["position_mm"] == [-10.0, 5.0, 90.0]
    assert call("gravity", "--design", BEST, "--mass-properties", masses) == 0
    assert f"joint 2: {facts['holding_torque_N_m'][2]:9.5f}"[:7] in capsys.readouterr().out


def test_point_masses_need_no_build(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("gravity", "--design", BEST, "--point-masses", "60,50,20", "--at", "0,0,95", "--json") == 0
    torque = json.loads(capsys.readouterr().out)["holding_torque_N_m"]
    assert torque == pytest.approx(np.full(3, torque[0]).tolist())


def test_point_masses_do_not_hide_a_platform_below_its_elbows(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "hanging.json").write_text(json.dumps(below_elbows()))
    assert call("gravity", "--design", tmp_path / "hanging.json", "--point-masses", "60,50,20") == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.startswith("hanging.json: cube.bottom_height_mm = 34.5: must have the assembly mode det S > 0")
    assert reported.err.count("\n") == 1


@pytest.mark.parametrize("name", PLACED)
def test_it_holds_where_the_cube_stands(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Left to itself at the cube's middle, the point masses of the paper by differences of their potential energy."""
    design, path = PLACED[name], tmp_path / "placed.json"
    path.write_text(json.dumps(design.model_dump(mode="json", exclude_none=True, by_alias=True)))
    assert call("gravity", "--design", path, "--point-masses", "60,50,20", "--json") == 0
    facts, book = json.loads(capsys.readouterr().out), textbook(design)
    assert facts["position_mm"] == pytest.approx((1e3 * design.workspace.centre).tolist(), abs=1e-12)
    masses, p = PointMasses(0.06, 0.05, 0.02).masses(book.arm), design.workspace.centre
    angles, gravity = book.angles(p), np.array(design.requirements.gravity_m_s2)
    for joint, e in enumerate(STEP * np.eye(3)):
        ahead, behind = (book.potential(masses, book.position(angles + s * e, p), gravity) for s in (1.0, -1.0))
        assert facts["holding_torque_N_m"][joint] == pytest.approx((ahead - behind) / (2.0 * STEP), abs=1e-8)


def test_more_than_the_drive_holds_is_exit_1(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("gravity", "--design", BEST, "--point-masses", "3000,50,20") == 1
    assert "joint 0" in capsys.readouterr().out


def test_published(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("gravity", "--published") == 0
    assert "77.6" in capsys.readouterr().out  # height of the origin, mm
    assert call("gravity", "--published", "--json") == 0
    assert json.loads(capsys.readouterr().out)["identifiable"] == 2


def test_masses_of_another_design_are_refused(tmp_path: Path, masses: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text(json.dumps(changed(cube__half_side_mm=30.0)))
    with pytest.raises(MassError, match=r"json: input_sha256 = .*synthesized"):
        load_machine(other, masses)
    data = json.loads(masses.read_text())
    del data["input_sha256"]
    unsaid = tmp_path / "masses.json"
    unsaid.write_text(json.dumps(data))
    assert load_machine(other, unsaid).design == load_design(other)  # a file that does not say: the user's word


def test_a_full_disk_is_one_line(masses: Path) -> None:
    command = [sys.executable, "-m", "haptics", "gravity", "--design", str(BEST), "--mass-properties", str(masses)]
    with open("/dev/full", "w") as full:
        run = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, cwd=BEST.parent)
    assert run.returncode == 2
    assert said(run.stderr) == "standard output: No space left on device\n"


def test_without_a_build_it_says_which_command_makes_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(MassError, match="python -m delta_cad build --design"):
        load_machine(BEST)


def test_values_that_begin_with_a_minus_stay_with_their_option() -> None:
    assert with_negatives(["--at", "-1,2,3", "--json"]) == ["--at=-1,2,3", "--json"]
    assert with_negatives(["--at", "-.5,2,3"]) == ["--at=-.5,2,3"]
    assert with_negatives(["--at", "1,2,3", "-h"]) == ["--at", "1,2,3", "-h"]


def test_help_is_light() -> None:
    code = "import sys\nfrom haptics.commands.cli import main\n"
    code += "try: main(['gravity', '--help'])\nexcept SystemExit: pass\n"
    code += "print({'numpy', 'numba', 'cadquery'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.rstrip().endswith("set()")
