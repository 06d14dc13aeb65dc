"""`init` and `schema` of the optimizer: files to begin with, valid and complete, replaced only if that is asked."""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from delta_cad.design import Hardware
from delta_cad.design.feel_defaults import feel_defaults
from optimizer.commands import cli
from optimizer.commands.init import PRESETS, preset_text
from optimizer.problem.brief import MOVED, UNUSED, DesignBrief, load_brief
from optimizer.problem.requirements import AngleBounds
from tests.committed import ROOT
from tests.delta_cad.design.json_schema import violations

WIDEST = 120  # characters of a line, as of our own code


def call(*arguments: str | Path) -> int:
    return cli.main([str(argument) for argument in arguments])


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_is_a_brief(preset: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert call("init", preset) == 0
    assert f"{preset}.toml" in capsys.readouterr().out
    given = load_brief(tmp_path / f"{preset}.toml")
    assert given.name == preset
    assert given.notes == ()
    assert given.goal.maximize or given.goal.minimize
    assert [path.name for path in tmp_path.iterdir()] == [f"{preset}.toml"]


def test_presets_ask_what_they_are_named_after() -> None:
    tasks = {preset: tomllib.loads(preset_text(preset))["requirements"] for preset in PRESETS}
    joystick = tomllib.loads((ROOT / "examples/synthesized.toml").read_text(encoding="utf-8"))
    for field in ("envelope_width_mm", "envelope_depth_mm", "force_N", "peak_force_N"):
        assert tasks["dashboard"][field] == joystick["requirements"][field]
    feel = tomllib.loads(preset_text("dashboard"))["feel"]
    assert feel["kappa_max"] == joystick["limits"]["kappa_max"]
    assert feel["stiffness_min_N_mm"] == joystick["requirements"]["stiffness_min_N_mm"]
    cubes = {preset: (task.get("cube_side_mm"), task["force_N"]) for preset, task in tasks.items()}
    assert cubes == {
        "dashboard": (None, 3),
        "desktop": (150, 10),
        "pocket": (40, 3),
        "large": (250, 3),
        "maker": (60, 2),
    }


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_sets_limits_of_feel_no_looser_than_the_defaults(preset: str) -> None:
    given = tomllib.loads(preset_text(preset))
    force, feel = given["requirements"]["force_N"], given["feel"]
    assert feel["friction_max_N"] <= 0.2 * force + 1e-12
    for field, default in feel_defaults(force).items():
        assert feel[field] >= default if field.endswith("_min") else feel[field] <= default + 1e-12, field


@pytest.mark.parametrize("preset", PRESETS)
def test_every_field_stands_in_it_with_a_sentence(preset: str) -> None:
    text = preset_text(preset)
    table, found = "", []
    for line in text.splitlines():
        assert len(line) <= WIDEST, line
        if line.startswith("["):
            table = line[1 : line.index("]")]
        elif (field := re.fullmatch(r"(# )?(\w+) = (.+?) +# (.+)", line)) is not None:
            found.append(f"{table}.{field[2]}".lstrip("."))
    wanted = ["name", *(f"hardware.{entry}" for entry in Hardware.model_fields)]
    for name, info in DesignBrief.model_fields.items():
        inner = AngleBounds.model_fields if name == "bounds_deg" else getattr(info.annotation, "model_fields", {})
        fields = [f"{name}.{field}" for field in inner]
        if name in ("panel", "placement"):  # in one line: a table that stands there asks for a panel
            fields = [name]
        wanted += [field for field in fields if field not in MOVED and field not in UNUSED and name not in UNUSED]
    assert sorted(found) == sorted(wanted)


@pytest.mark.parametrize("preset", PRESETS)
def test_each_line_may_be_taken_in(preset: str, tmp_path: Path) -> None:
    """All of them at once but the folder, which is not there, the other goal, and a free outline's own cube."""
    path = tmp_path / "all.toml"
    lines = [re.sub(r"^# (\w+ = )", r"\1", line) for line in preset_text(preset).splitlines()]
    goal = "minimize" if preset == "dashboard" else "maximize"
    outline = ("envelope_width_mm", "envelope_depth_mm", "peak_force_N")
    left = ("catalogue", goal, *(outline if preset != "dashboard" else ()))
    path.write_text("\n".join(line for line in lines if not line.startswith(left)), encoding="utf-8")
    given = load_brief(path)
    assert given.bounds_mm.base_radius is not None
    assert given.feel.position_step_max_mm is not None


def test_the_files_name_is_the_designs(tmp_path: Path) -> None:
    assert call("init", "pocket", "--out", tmp_path / "new" / "my-arm.toml") == 0
    assert load_brief(tmp_path / "new" / "my-arm.toml").name == "my-arm"
    assert call("init", "pocket", "--out", tmp_path / "my arm.toml") == 0  # no name of a design
    assert load_brief(tmp_path / "my arm.toml").name == "pocket"


def test_a_file_is_replaced_only_if_that_is_required(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("mine", encoding="utf-8")
    assert call("init", "--out", path) == 2
    err = capsys.readouterr().err
    assert "mine.toml" in err
    assert "--force" in err
    assert err.count("\n") == 1
    assert path.read_text(encoding="utf-8") == "mine"
    assert call("init", "--out", path, "--force") == 0
    assert load_brief(path).outline_mm == (270.0, 220.0)
    capsys.readouterr()
    assert call("init", "--out", tmp_path, "--force") == 2  # a folder
    assert capsys.readouterr().err.count("\n") == 1


def test_an_unknown_preset_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as caught:
        call("init", "palace")
    assert caught.value.code == 2
    assert all(preset in capsys.readouterr().err for preset in ("palace",))


def test_the_schema_is_printed_with_examples_that_it_takes(capsys: pytest.CaptureFixture[str]) -> None:
    assert call("schema") == 0
    schema = json.loads(capsys.readouterr().out)
    assert schema["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert len(schema["examples"]) == len(PRESETS)
    for example in schema["examples"]:
        assert violations(schema, example, schema) == []


def test_the_schema_of_own_parts_knows_their_ids(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("schema", "--catalogue", ROOT / "examples" / "my-parts") == 0
    assert "example-30" in capsys.readouterr().out
    assert call("schema", "--catalogue", tmp_path) == 2
    assert capsys.readouterr().err.startswith(f"--catalogue {tmp_path}: ")


def test_neither_loads_cad_nor_solvers(tmp_path: Path) -> None:
    code = (
        "import sys; from optimizer.commands.cli import main\nmain(['init', '--out', sys.argv[1]]); main(['schema'])\n"
        "print([m for m in ('cadquery', 'OCP', 'scipy', 'pymoo', 'numba', 'matplotlib') if m in sys.modules])"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "a.toml")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout.splitlines()[-1] == "[]"


@pytest.mark.parametrize("command", ["synthesize", "front", "atlas"])
def test_commands_tell_all_that_is_wrong_with_requirements(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    base = tmp_path / "r.toml"
    base.write_text(
        (ROOT / "examples/synthesized.toml").read_text(encoding="utf-8").replace("force_N = 3.0", 'force_N = "3 kg"')
        + "belt = 1\n",
        encoding="utf-8",
    )
    file = base
    if command == "atlas":
        file = tmp_path / "g.toml"
        file.write_text('base = "r.toml"\naxes = {"limits.kappa_max" = [2, 3]}\n', encoding="utf-8")
        base.write_text(base.read_text(encoding="utf-8").replace("kappa_max = 2.27", "kappa_max = 0"), encoding="utf-8")
    assert call(command, file, "--out", tmp_path / "out") == 2
    found = capsys.readouterr()
    assert found.out == ""
    lines = found.err.splitlines()
    assert [line.split(" = ")[0] for line in lines] == [
        "r.toml: requirements.force_N",
        "r.toml: limits.kappa_max" if command == "atlas" else "r.toml: hardware.belt",
    ]


@pytest.mark.slow  # 1300 s of processor: five searches, each to its end
@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_is_built_and_passes_every_check(preset: str, tmp_path: Path) -> None:
    def run(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "optimizer", *words]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert run("init", preset).returncode == 0
    ended = run("design", f"{preset}.toml", "--minutes", "30")
    assert ended.returncode == 0, ended.stdout[-2000:]
    assert ended.stdout.startswith("built: ")
    assert (tmp_path / "out" / preset / "report.html").is_file()
