"""The command line: exit codes, one line on stderr for every fault, JSON on stdout.

18 s of processor: refused designs search the thresholds of their reasons.
"""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from delta_cad.commands import build, check
from delta_cad.commands.cli import main
from delta_cad.commands.inspection import inspection
from delta_cad.design import Design, design_from_dict, design_schema, load_design
from delta_cad.mechanism.workspace import Cube, cube_extremes
from delta_cad.structure.hardware.refusals import refusals
from tests.committed import BEST, PUBLISHED, ROOT, changed

COMMANDS = ("build", "check", "drawings", "inspect")


def refused(capsys: pytest.CaptureFixture[str], arguments: list[str], code: int = 2) -> str:
    """Runs a command that must refuse; returns its only line."""
    assert main(arguments) == code
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.endswith("\n")
    assert reported.err.count("\n") == 1, reported.err
    assert "Traceback" not in reported.err
    return reported.err


def left_in(folder: Path) -> list[Path]:
    """What a refused command left behind: the folder is made before the work, and stays empty."""
    return list(folder.rglob("*")) if folder.exists() else []


@pytest.mark.parametrize("arguments", [["--help"], *([c, "--help"] for c in (*COMMANDS, "schema"))])
def test_help_ends_with_0(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == 0
    assert "usage: python -m delta_cad" in capsys.readouterr().out


def test_schema_prints_the_schema(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    reported = capsys.readouterr()
    assert json.loads(reported.out) == design_schema()
    assert reported.err == ""


def test_inspect_prints_a_table_or_json_of_the_same_facts(best: Design, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", "--design", str(BEST), "--json"]) == 0
    reported = capsys.readouterr()
    assert reported.err == ""
    data = json.loads(reported.out)
    assert data["name"] == best.name
    assert data["rows"] == json.loads(json.dumps([row.to_json() for row in inspection(best)]))
    assert main(["inspect", "--design", str(BEST), "--all"]) == 0
    reported = capsys.readouterr()
    assert reported.err == ""
    assert "\x1b" not in reported.out  # no colours into a file
    assert "FAILS" not in reported.out
    for row in data["rows"]:
        assert row["quantity"] in reported.out


@pytest.mark.parametrize(
    ("requirement", "value"),
    [
        ("kappa_max", 1.5),
        ("lean_max_deg", 20.0),
        ("shoulder_min_deg", -30.0),
        ("shoulder_max_deg", 50.0),
        ("joint_torque_N_m", 0.2),
        ("envelope_width_mm", 150.0),
    ],
)
def test_inspection_says_which_requirement_fails(requirement: str, value: float) -> None:
    """By which the process ends with 1: `test_cli_process`."""
    rows = inspection(design_from_dict(changed(**{f"requirements__{requirement}": value})))
    assert f"{value:g}" in " ".join(row.limit for row in rows if row.holds is False)


def test_the_inspection_s_rows_are_the_mechanism_s_figures() -> None:
    published = load_design(PUBLISHED)
    rows = {row.quantity: row for row in inspection(published)}
    # [RCIM2018] eq. (1) by hand: 27 + sqrt(3) 122 and 54 cos(30) / 2 + 183
    assert rows["longer side"].value == pytest.approx(238.310, abs=1e-3)
    assert rows["shorter side"].value == pytest.approx(206.383, abs=1e-3)
    assert (rows["longer side"].limit, rows["shorter side"].limit) == ("<= 270", "<= 220")
    extremes = cube_extremes(published.geometry, Cube(0.057112, 0.0375), 3.0)
    assert rows["kappa"].value == extremes.kappa_max.value
    assert rows["lowest elbow"].value == pytest.approx(1e3 * extremes.elbow_z_min.value)
    torque = rows["torque for 3 N in the worst direction"]
    assert torque.value == pytest.approx(0.316, abs=5e-4)  # the feasibility study's figure
    assert torque.at_mm == pytest.approx([1e3 * v for v in extremes.torque_max.position])
    assert rows["cube side 2 L"].value == 75.0
    # 0.96 x 9.85 x 85 mN m
    assert rows["joint torque, continuous"].value == pytest.approx(0.80376)
    assert rows["joint torque, continuous"].limit == ">= 0.8"
    for row in rows.values():
        if row.holds is not None and isinstance(row.value, float):
            sign, bound = row.limit.split()
            assert (
                row.holds
                == {"<=": row.value <= float(bound), ">=": row.value >= float(bound), ">": row.value > float(bound)}[
                    sign
                ]
            )


def test_a_folder_is_no_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "Is a directory" in refused(capsys, ["inspect", "--design", str(tmp_path)])


def test_a_direct_drive_has_no_cable_in_its_inspection() -> None:
    rows = inspection(design_from_dict(changed(hardware__drive="direct", hardware__motor="maxon-ec60flat-625858")))
    assert not any("cable" in row.quantity for row in rows)
    assert any(row.quantity == "ratio" and row.value == 1.0 for row in rows)


@pytest.mark.parametrize("command", COMMANDS)
def test_a_cube_out_of_reach_ends_with_2(
    command: str, best: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The design file's closed forms refuse it first; passed by, the mechanism does, and names the cube."""
    unchecked = best.model_copy(update={"cube": best.cube.model_copy(update={"half_side_mm": 80.0})})
    monkeypatch.setattr("delta_cad.design.load_design", lambda *_, **__: unchecked)
    rest = [] if command == "inspect" else ["--out", str(tmp_path / "out")]
    line = refused(capsys, [command, "--design", "best.json", *rest])
    assert line.startswith("best.json: cube: chain ")
    assert "mm" in line
    assert not left_in(tmp_path / "out")


def test_hardware_that_cannot_do_is_refused_with_every_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, rest = tmp_path / "thin.json", ["--out", str(tmp_path / "out")]
    file.write_text(json.dumps(changed(hardware__capstan_ratio=11.5, hardware__platform_thickness_mm=9.0)))
    assert main(["check", "--design", str(file), *rest]) == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    lines = reported.err.splitlines()
    assert lines[0].startswith("thin.json: pinion, wall: ")
    assert "hardware.capstan_ratio = 11.5 must be at most 10.99" in lines[0]
    for reason in (
        "hardware.platform_thickness_mm = 9 must be at least 10",
        "hardware.sector_radius_mm = 38.7 must be at least 52.79",
    ):
        assert sum(reason in line for line in lines) == 1
    assert "--suggest FILE" in lines[-1]
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["check", "inspect"])
def test_a_suggestion_is_a_design_that_nothing_refuses_with_the_requirements_of_the_first(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, better = tmp_path / "thin.json", tmp_path / "better.json"
    data = changed(hardware__platform_thickness_mm=9.0)
    file.write_text(json.dumps(data))
    arguments = [command, "--design", str(file), "--suggest", str(better), "--json"]
    assert main(arguments) == (0 if command == "inspect" else 2)
    reported = capsys.readouterr()
    record = json.loads(reported.out)
    assert record["suggested"]["values"] == {"hardware.platform_thickness_mm": 10.0}
    assert record["suggested"]["was"] == {"hardware.platform_thickness_mm": 9.0}
    (reason,) = record["refused"]
    assert (reason["part"], reason["feature"]) == ("platform", "wrist boss")
    assert {
        "was": {"hardware.platform_thickness_mm": 9.0},
        "enough": {"hardware.platform_thickness_mm": 10.0},
        "requirement": False,
    } in reason["changes"]
    assert "better.json: hardware.platform_thickness_mm = 10 (was 9)" in reported.err
    design = load_design(better)
    assert refusals(design) == ()
    assert design.requirements == design_from_dict(data).requirements
    assert design.cube == design_from_dict(data).cube
    text = better.read_text()
    assert main(arguments) == 2  # it is there now
    assert "better.json: exists" in capsys.readouterr().err
    assert better.read_text() == text


def test_a_suggestion_of_a_machine_of_own_parts_finds_them_from_its_own_folder(tmp_path: Path) -> None:
    given = json.loads((ROOT / "examples" / "synthesized.json").read_text())
    given["hardware"] |= {"catalogue": "my-parts", "platform_thickness_mm": 9.0}
    shutil.copytree(ROOT / "examples" / "my-parts", tmp_path / "a" / "my-parts")
    (tmp_path / "b").mkdir()
    (tmp_path / "a" / "thin.json").write_text(json.dumps(given))
    required = [
        "check",
        "--design",
        str(tmp_path / "a" / "thin.json"),
        "--suggest",
        str(tmp_path / "b" / "better.json"),
    ]
    assert main(required) == 2
    assert load_design(tmp_path / "b" / "better.json").hardware.catalogue == "../a/my-parts"


def test_inspect_tells_why_no_machine_can_be_built_next_to_the_mechanism_s_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "thin.json"
    file.write_text(json.dumps(changed(hardware__platform_thickness_mm=9.0)))
    assert main(["inspect", "--design", str(file), "--json"]) == 0
    reported = capsys.readouterr()
    record = json.loads(reported.out)
    assert {row["quantity"] for row in record["rows"]} >= {"kappa", "cube side 2 L"}
    assert [(one["part"], one["feature"]) for one in record["refused"]] == [("platform", "wrist boss")]
    assert reported.err.startswith("thin.json: no build: platform, wrist boss: ")
    assert main(["inspect", "--design", str(file)]) == 0
    assert "; no build: 1 reason" in capsys.readouterr().out.splitlines()[0]


def test_a_limit_that_is_not_computed_is_named_on_the_first_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "given.json"
    file.write_text(json.dumps(changed(requirements__effective_mass_max_kg=0.1)))
    assert main(["inspect", "--design", str(file), "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    (row,) = [row for row in data["rows"] if row["limit"] and isinstance(row["value"], str)]
    assert (row["quantity"], row["limit"]) == ("effective mass", "<= 0.1")
    assert main(["inspect", "--design", str(file)]) == 0
    assert capsys.readouterr().out.splitlines()[0].endswith("limits hold; not computed: effective mass")


@pytest.mark.parametrize("command", ["check", "inspect"])
def test_sums_that_cannot_be_do_not_hide_what_else_is_wrong(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A ratio whose groove cuts the shaft is refused with the file; its plate and its cable are told all the same."""
    file = tmp_path / "worse.json"
    file.write_text(json.dumps(changed(hardware__capstan_ratio=14.5, hardware__base_plate_thickness_mm=4.5)))
    assert main([command, "--design", str(file)]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("worse.json: hardware.capstan_ratio = 14.5: must be < 13.97")
    assert any("hardware.base_plate_thickness_mm = 4.5 must be at least" in line for line in lines)
    assert any("hardware.sector_radius_mm = 38.7 must be at least" in line for line in lines)


@pytest.mark.parametrize("command", ["build", "check"])
def test_a_part_that_cannot_be_made_ends_with_3(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from delta_cad.dimensions.rules import require

    def failing(*_: object) -> None:
        require(False, "stop_pin", "length", "none in stock")

    monkeypatch.setattr(build, "_built", failing)
    monkeypatch.setattr(check, "_checked", failing)
    line = refused(capsys, [command, "--design", str(BEST), "--out", str(tmp_path / "out")], code=3)
    assert line == "synthesized.json: stop_pin, length: none in stock\n"


@pytest.mark.parametrize("command", ["build", "check"])
def test_a_folder_that_cannot_be_used_is_refused_before_the_work(
    command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def worked(*_: object) -> None:
        raise AssertionError("the work was begun")

    monkeypatch.setattr(build, "_built", worked)
    monkeypatch.setattr(check, "_checked", worked)
    taken = tmp_path / "taken"
    taken.write_text("a file")
    for out in (taken, taken / "below"):
        line = refused(capsys, [command, "--design", str(BEST), "--out", str(out)])
        assert line.startswith(f"--out {out}: ")
        assert line.endswith("; must be a folder that can be written\n")
    assert taken.read_text() == "a file"


def test_a_build_s_place_that_holds_something_else_is_refused_before_the_work(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    held = tmp_path / load_design(BEST).name
    held.mkdir()
    (held / "thesis.txt").write_text("of years")
    line = refused(capsys, ["build", "--design", str(BEST), "--out", str(tmp_path)])
    assert line.startswith(f"--out {tmp_path}: {held}: holds thesis.txt, ")
    assert line.endswith("to lose nothing\n")
    assert (held / "thesis.txt").read_text() == "of years"


def test_a_folder_that_must_not_be_written_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Permissions do not stop every user, so the system's refusal is put in its place."""

    def forbidden(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(check, "_checked", forbidden)
    line = refused(capsys, ["check", "--design", str(BEST), "--out", str(tmp_path)])
    assert line == f"--out {tmp_path}: Permission denied; must be a folder that can be written\n"


def test_ctrl_c_ends_with_130_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(check, "_checked", interrupted)
    line = refused(capsys, ["check", "--design", str(BEST), "--out", str(tmp_path)], code=130)
    assert "interrupted" in line
