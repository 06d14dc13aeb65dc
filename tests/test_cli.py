"""The command line: exit codes, one line on stderr for every fault, JSON on stdout, and nothing loaded too early."""

from __future__ import annotations

import io
import json
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
from committed import BEST
from rich.console import Console

from delta_cad import cli, tables
from delta_cad.checks.report import CheckResult
from delta_cad.cli import main
from delta_cad.design import Design, design_schema
from delta_cad.inspection import inspection
from delta_cad.mechanism.workspace import Cube, cube_extremes

DATA: dict[str, Any] = json.loads(BEST.read_text())
COMMANDS = ("build", "check", "inspect")


def changed(**values: Any) -> dict[str, Any]:
    """The committed design with some numbers changed, as "section__field"."""
    data = deepcopy(DATA)
    for name, value in values.items():
        section, _, field = name.partition("__")
        if field:
            data[section][field] = value
        else:
            data[section] = value
    return data


def without(section: str, field: str) -> dict[str, Any]:
    data = deepcopy(DATA)
    del data[section][field]
    return data


def swapped() -> dict[str, Any]:
    return changed(mechanism=DATA["cube"], cube=DATA["mechanism"])


BAD_FILES: dict[str, tuple[bytes, tuple[str, ...]]] = {
    "empty": (b"", ("is not JSON",)),
    "binary": (bytes(range(256)), ("is not UTF-8",)),
    "text": (b"a delta robot, please", ("is not JSON",)),
    "list": (b"[1, 2]", ("must be an object",)),
    "number": (b"7", ("must be an object",)),
    "nan": (
        json.dumps(changed(cube__half_side_mm=float("nan"))).encode(),
        ("cube.half_side_mm", "NaN", "must be finite"),
    ),
    "infinite": (b'{"a": 1e999}', ("a", "Infinity", "must be finite")),
    "negative": (
        json.dumps(changed(mechanism__forearm_length_mm=-112.0)).encode(),
        ("mechanism.forearm_length_mm", "-112.0", "> 0"),
    ),
    "zero": (json.dumps(changed(requirements__force_N=0.0)).encode(), ("requirements.force_N", "0.0", "> 0")),
    "text for a number": (
        json.dumps(changed(mechanism__base_radius_mm="forty")).encode(),
        ("mechanism.base_radius_mm", '"forty"', "must be a number"),
    ),
    "unknown key": (json.dumps(changed(hardware__colour="red")).encode(), ("hardware.colour", '"red"', "known here")),
    "missing": (
        json.dumps(without("mechanism", "forearm_length_mm")).encode(),
        ("mechanism.forearm_length_mm", "missing"),
    ),
    "swapped": (json.dumps(swapped()).encode(), ("mechanism", "is missing")),
    "repeated": (b'{"schema": "delta-design/1", "schema": "delta-design/1"}', ("schema", "more than once")),
    "schema": (json.dumps(changed(schema="delta-design/9")).encode(), ("schema", "delta-design/9", "delta-design/1")),
    "motor": (
        json.dumps(changed(hardware__motor="perpetual")).encode(),
        ("hardware.motor", "perpetual", "maxon-re30-310007"),
    ),
    "name": (json.dumps(changed(name="../../etc")).encode(), ("name", "../../etc", "letters")),
    "reach": (
        json.dumps(changed(mechanism__forearm_length_mm=70.0)).encode(),
        ("mechanism.forearm_length_mm", "70.0", "must be >="),
    ),
    "deep": (b"[" * 100_000, ("JSON",)),
}


def refused(capsys: pytest.CaptureFixture[str], arguments: list[str], code: int = 2) -> str:
    """Runs a command that must refuse; returns its only line."""
    assert main(arguments) == code
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.endswith("\n")
    assert told.err.count("\n") == 1, told.err
    assert "Traceback" not in told.err
    return told.err


@pytest.mark.parametrize("what", BAD_FILES)
def test_a_nonsense_file_is_refused_in_one_line(what: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    content, words = BAD_FILES[what]
    file = tmp_path / "strange.json"
    file.write_bytes(content)
    out = tmp_path / "out"
    for command in COMMANDS:
        rest = [] if command == "inspect" else ["--out", str(out)]
        line = refused(capsys, [command, "--design", str(file), *rest])
        assert line.startswith("strange.json: ")
        for word in words:
            assert word in line
    assert not out.exists()


def test_a_missing_file_and_a_directory_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for command in COMMANDS:
        assert "absent.json: cannot be read" in refused(capsys, [command, "--design", str(tmp_path / "absent.json")])
        assert "cannot be read" in refused(capsys, [command, "--design", str(tmp_path)])


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ([], "COMMAND"),
        (["fly"], "fly"),
        (["build"], "--design"),
        (["inspect", "--design", "x", "--out", "y"], "--out"),
        (["build", "--design", "x", "--step-schema", "AP203"], "AP203"),
        (["schema", "--colour"], "--colour"),
    ],
)
def test_wrong_usage_ends_with_2_in_one_line(
    arguments: list[str], word: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert word in told.err
    assert "--help" in told.err


@pytest.mark.parametrize("arguments", [["--help"], *([c, "--help"] for c in (*COMMANDS, "schema"))])
def test_help_ends_with_0(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 0
    assert "usage: python -m delta_cad" in capsys.readouterr().out


def test_schema_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    told = capsys.readouterr()
    assert json.loads(told.out) == design_schema()
    assert told.err == ""


def test_inspect_prints_a_table_or_json_of_the_same_facts(best: Design, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", "--design", str(BEST), "--json"]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    data = json.loads(told.out)
    assert data["name"] == best.name
    assert data["rows"] == json.loads(json.dumps([row.to_json() for row in inspection(best)]))
    assert main(["inspect", "--design", str(BEST)]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    assert "\x1b" not in told.out  # no colours into a file
    assert "FAILS" not in told.out
    for row in data["rows"]:
        assert row["quantity"] in told.out


@pytest.mark.parametrize(
    ("requirement", "value"),
    [
        ("kappa_max", 1.5),
        ("lean_max_deg", 20.0),
        ("shoulder_min_deg", -30.0),
        ("shoulder_max_deg", 60.0),
        ("joint_torque_N_m", 0.2),
        ("envelope_width_mm", 150.0),
    ],
)
def test_inspect_says_which_requirement_fails(
    requirement: str, value: float, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "asking.json"
    file.write_text(json.dumps(changed(**{f"requirements__{requirement}": value})))
    assert main(["inspect", "--design", str(file)]) == 1
    assert capsys.readouterr().out.count("FAILS") >= 1
    assert main(["inspect", "--design", str(file), "--json"]) == 1
    rows = json.loads(capsys.readouterr().out)["rows"]
    assert f"{value:g}" in " ".join(row["limit"] for row in rows if row["holds"] is False)


def test_the_inspection_s_rows_are_the_mechanism_s_figures(best: Design) -> None:
    rows = {row.quantity: row for row in inspection(best)}
    # [RCIM2018] eq. (1) by hand: 27 + sqrt(3) 122 and 54 cos(30) / 2 + 183
    assert rows["longer side"].value == pytest.approx(238.310, abs=1e-3)
    assert rows["shorter side"].value == pytest.approx(206.383, abs=1e-3)
    assert (rows["longer side"].limit, rows["shorter side"].limit) == ("<= 270", "<= 220")
    extremes = cube_extremes(best.geometry, Cube(0.057112, 0.0375), 3.0)
    assert rows["worst condition number"].value == extremes.kappa_max.value
    assert rows["lowest elbow"].value == pytest.approx(1e3 * extremes.elbow_z_min.value)
    torque = rows["joint torque for 3 N in the worst direction"]
    assert torque.value == pytest.approx(0.316, abs=5e-4)  # the feasibility study's figure
    assert torque.at_mm == pytest.approx([1e3 * v for v in extremes.torque_max.position])
    assert rows["cube side 2 L"].value == 75.0
    # 0.96 x 9.85 x 85 mN m
    assert rows["joint torque, for ever"].value == pytest.approx(0.80376)
    assert rows["0.8 N m"].value == "continuous"
    for row in rows.values():
        if row.holds is not None and isinstance(row.value, float):
            sign, bound = row.limit.split()
            assert (
                row.holds
                == {"<=": row.value <= float(bound), ">=": row.value >= float(bound), ">": row.value > float(bound)}[
                    sign
                ]
            )


def test_a_direct_drive_has_no_cable_in_its_inspection() -> None:
    from delta_cad.design import design_from_dict

    rows = inspection(design_from_dict(changed(hardware__drive="direct", hardware__motor="maxon-ec60flat-625858")))
    assert not any("cable" in row.quantity for row in rows)
    assert any(row.quantity == "ratio" and row.value == 1.0 for row in rows)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_cube_out_of_reach_ends_with_2(
    command: str, best: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The design file's closed forms refuse it first; passed by, the mechanism does, and names the cube."""
    unchecked = best.model_copy(update={"cube": best.cube.model_copy(update={"half_side_mm": 60.0})})
    monkeypatch.setattr("delta_cad.design.load_design", lambda _: unchecked)
    rest = [] if command == "inspect" else ["--out", str(tmp_path / "out")]
    line = refused(capsys, [command, "--design", "best.json", *rest])
    assert line.startswith("best.json: cube: chain ")
    assert "mm" in line
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["build", "check"])
def test_a_part_without_sound_dimensions_ends_with_3(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "thin.json"
    file.write_text(json.dumps(changed(hardware__capstan_ratio=11.0)))
    line = refused(capsys, [command, "--design", str(file), "--out", str(tmp_path / "out")], code=3)
    assert line.startswith("thin.json: pinion, wall: ")
    assert "hardware.capstan_ratio must be <= 9.95" in line
    assert not (tmp_path / "out").exists()


def run(*arguments: str, code: str = "") -> subprocess.CompletedProcess[str]:
    command = ["-c", code] if code else ["-m", "delta_cad", *arguments]
    return subprocess.run([sys.executable, *command], capture_output=True, text=True)


def test_exit_codes_of_the_process(tmp_path: Path) -> None:
    asking, thin = tmp_path / "asking.json", tmp_path / "thin.json"
    asking.write_text(json.dumps(changed(requirements__kappa_max=1.5)))
    thin.write_text(json.dumps(changed(hardware__capstan_ratio=11.0)))
    out = str(tmp_path / "out")
    for arguments, code in (
        (["inspect", "--design", str(BEST)], 0),
        (["inspect", "--design", str(asking)], 1),
        (["inspect", "--design", str(tmp_path)], 2),
        (["inspect"], 2),
        (["build", "--design", str(thin), "--out", out], 3),
    ):
        ended = run(*arguments)
        assert ended.returncode == code, ended
        assert "Traceback" not in ended.stderr
        assert ended.stderr.count("\n") == (code >= 2)


HEAVY = "('cadquery', 'OCP', 'trimesh', 'vtkmodules', 'vtk', 'fcl', 'matplotlib', 'mujoco', 'gmsh')"


@pytest.mark.parametrize(
    "code",
    [
        "import delta_cad",
        "import delta_cad.design",
        "import delta_cad.cli",
        "import delta_cad.dimensions, delta_cad.placement, delta_cad.assembly, delta_cad.part, delta_cad.drive",
        "import delta_cad.inspection, delta_cad.tables",
        "from delta_cad.cli import main; main(['inspect', '--design', 'BEST'])",
        "from delta_cad.cli import main; main(['schema'])",
        *(
            f"from delta_cad.cli import main\ntry: main({a!r})\nexcept SystemExit: pass"
            for a in (["--help"], ["build", "--help"])
        ),
    ],
)
def test_no_cad_kernel_is_loaded_before_it_is_needed(code: str) -> None:
    code = code.replace("BEST", str(BEST))
    ended = run(code=f"import sys\n{code}\nprint('LOADED', [m for m in {HEAVY} if m in sys.modules])")
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.splitlines()[-1] == "LOADED []"


def test_help_loads_no_more_than_arguments_need() -> None:
    ended = run(
        code="import sys\nfrom delta_cad.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
        "print('LOADED', [m for m in ('numpy', 'scipy', 'pydantic', 'rich') if m in sys.modules])"
    )
    assert ended.stdout.splitlines()[-1] == "LOADED []"


def test_without_the_cad_extra_the_build_says_what_to_install() -> None:
    ended = run(
        code=f"import sys; sys.modules['cadquery'] = None\nfrom delta_cad.cli import main\n"
        f"sys.exit(main(['check', '--design', {str(BEST)!r}, '--out', '/nonexistent/out']))"
    )
    assert ended.returncode == 3
    assert ended.stderr.count("\n") == 1
    assert "cadquery is not installed: pip install 'delta-haptics[cad]'" in ended.stderr


def test_ctrl_c_ends_with_130_in_one_line(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(cli, "_run", interrupted)
    line = refused(capsys, ["check", "--design", str(BEST)], code=130)
    assert "interrupted" in line


def test_a_reader_that_goes_away_is_no_error() -> None:
    ended = subprocess.run(
        f"{sys.executable} -m delta_cad schema | head -c 10", shell=True, capture_output=True, text=True
    )
    assert ended.stderr == ""
    assert len(ended.stdout) == 10


def test_phases_are_shown_on_a_terminal_only(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with tables.phases("first") as show:
        show("second")
    told = capsys.readouterr()
    assert told.out + told.err == ""
    screen = io.StringIO()
    monkeypatch.setattr(tables, "Console", lambda **_: Console(file=screen, force_terminal=True, width=80))
    with tables.phases("loading") as show:
        show("solid upper_arm")
    assert " s\x1b[0m  solid upper_arm" in screen.getvalue()  # the time so far and the phase


def test_equal_checks_of_the_three_chains_are_one_line() -> None:
    def result(name: str, value: float, passed: bool = True) -> CheckResult:
        return CheckResult(name, passed, value, 1.0, "mm", worst_pair=(name,))

    results = [
        *(result(f"gap sector_{i} / motor_cheek_{i}", 1.2 + i) for i in range(3)),
        *(
            result(f"contact ball_stud_{i}_{j}_elbow / ball_socket_{i}_{j}_elbow", 0.5)
            for i in range(3)
            for j in range(2)
        ),
        *(result(f"solid part_{i}", 0.1) for i in range(4)),
        result("lean", 0.4),
    ]
    groups = tables.grouped(results)
    assert {name: len(found) for name, found in groups.items()} == {
        "gap sector / motor_cheek": 3,
        "contact ball_stud_elbow / ball_socket_elbow": 6,
        "solids": 4,
        "lean": 1,
    }
