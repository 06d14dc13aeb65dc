"""What all three command lines share: version, completion, the design of the folder, hints at what was meant."""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import pytest

from delta_cad import catalogue
from delta_cad.commands import cli as delta_cad
from delta_cad.common.command_line import Parser, actions, hint
from delta_cad.common.options import POSITIVE, Option, add_options, number, whole
from delta_cad.common.refusal import meant, unknown_key
from haptics.commands import cli as haptics
from optimizer.commands import cli as optimizer
from tests.committed import BEST, DATA

CLIS = {"delta-cad": delta_cad, "delta-optimizer": optimizer, "delta-haptics": haptics}
NEEDS_NONE = {"verify", "front"}  # whose design is something to compare with, or to picture


def ended(main: Callable[[list[str]], int], arguments: list[str]) -> int:
    try:
        return main(arguments)
    except SystemExit as end:
        return int(end.code or 0)


@pytest.mark.parametrize("cli", CLIS.values(), ids=list(CLIS))
def test_every_command_tells_the_version(cli: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    for words in ([], *([module.NAME] for module in cli.COMMANDS)):
        assert ended(cli.main, [*words, "--version"]) == 0
        assert capsys.readouterr().out == f"delta-haptics {version('delta-haptics')}\n"


@pytest.mark.parametrize(("script", "cli"), CLIS.items())
def test_a_shell_completes_every_command_and_option(
    script: str, cli: ModuleType, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Bash itself is asked what it would offer."""
    assert ended(cli.main, ["--completion", "bash"]) == 0
    (tmp_path / "completion").write_text(capsys.readouterr().out)
    (tmp_path / "some-folder").mkdir()
    (tmp_path / "some.json").touch()

    def offered(*words: str) -> set[str]:
        asks = f"COMP_WORDS=({' '.join(repr(word) for word in (script, *words))}); COMP_CWORD={len(words)}"
        run = f"source completion; {asks}; _shtab_{script.replace('-', '_')}; printf '%s\\n' \"${{COMPREPLY[@]}}\""
        process = subprocess.run(["bash", "-c", run], cwd=tmp_path, capture_output=True, text=True, check=True)
        return set(process.stdout.split())

    assert offered("") >= {module.NAME for module in cli.COMMANDS}
    for module in cli.COMMANDS:
        parser = Parser(prog="-")
        add_options(parser, module.OPTIONS)
        options = {name for action in actions(parser) for name in action.option_strings if name.startswith("--")}
        hidden = {name for a in actions(parser) if a.help == argparse.SUPPRESS for name in a.option_strings}
        assert offered(module.NAME, "--") >= options - hidden


def test_files_and_folders_are_completed_where_they_are_meant(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(delta_cad.main, ["--completion", "bash"]) == 0
    reported = capsys.readouterr().out
    assert "_shtab_delta_cad_build___design_COMPGEN=_shtab_compgen_files" in reported
    assert "_shtab_delta_cad_build___out_COMPGEN=_shtab_compgen_dirs" in reported


@pytest.mark.parametrize("cli", CLIS.values(), ids=list(CLIS))
def test_the_same_option_has_the_same_name_and_meaning_everywhere(cli: ModuleType) -> None:
    for module in cli.COMMANDS:
        parser = Parser(prog="-")
        add_options(parser, module.OPTIONS)
        by_name = {name: action for action in actions(parser) for name in action.option_strings}
        assert "--masses" not in by_name or by_name["--masses"].help == argparse.SUPPRESS
        for name, kind in (("--design", "FILE"), ("--mass-properties", "FILE"), ("--catalogue", "DIR")):
            assert name not in by_name or (by_name[name].metavar, by_name[name].required) == (kind, False)
        if "--design" in by_name and module.NAME not in NEEDS_NONE:
            assert parser.get_default("settle") is not None


def test_the_design_of_the_folder_is_taken_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert ended(delta_cad.main, ["inspect", "--json"]) == 2
    assert capsys.readouterr().err.startswith(
        "python -m delta_cad inspect: --design FILE is needed: there is no best.json"
    )
    shutil.copy(BEST, tmp_path / "best.json")
    assert delta_cad.main(["inspect", "--json"]) == 0
    reported = capsys.readouterr()
    assert reported.err == "--design best.json: taken, as none was given\n"
    assert json.loads(reported.out)["name"] == DATA["name"]
    assert delta_cad.main(["inspect", "--json", "--design", str(BEST)]) == 0
    again = capsys.readouterr()
    assert (again.out, again.err) == (reported.out, "")


@pytest.mark.parametrize(("own", "taken"), [(None, "1"), ("3", "3")])
def test_a_program_multiplies_matrices_by_one_thread_unless_the_environment_says_otherwise(
    own: str | None, taken: str, tmp_path: Path
) -> None:
    code = """import os, numpy, threadpoolctl
def main():
    threads = {one["num_threads"] for one in threadpoolctl.threadpool_info() if one["user_api"] == "blas"}
    print(os.environ["OPENBLAS_NUM_THREADS"], threads == {1})
    return 0
"""
    (tmp_path / "threads.py").write_text(code)
    environment = {name: value for name, value in os.environ.items() if "THREADS" not in name}
    environment |= {"OPENBLAS_NUM_THREADS": own} if own else {}
    program = "from delta_cad.common.command_line import run_program\nrun_program('threads')\n"
    path = os.pathsep.join([str(tmp_path), environment.get("PYTHONPATH", "")])
    run = subprocess.run(
        [sys.executable, "-c", program],
        env=environment | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert run.stdout.split()[0] == taken
    assert own or run.stdout.split()[1] == "True"


def test_no_design_is_searched_where_none_is_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert haptics.main(["gravity", "--published", "--json"]) in (0, 1)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize(
    ("cli", "words", "meaning"),
    [
        (delta_cad, ["biuld"], "build"),
        (delta_cad, ["build", "--desing", "x"], "--design"),
        (optimizer, ["init", "dashbord"], "dashboard"),
        (haptics, ["simulate", "--scene", "resistence"], "resistance"),
        (delta_cad, ["xylophone"], ""),
    ],
)
def test_a_wrong_word_gets_a_hint(
    cli: ModuleType, words: list[str], meaning: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(cli.main, words) == 2
    reported = capsys.readouterr().err
    assert reported.count("\n") == 1
    assert (f"; did you mean {meaning}; see" in reported) == bool(meaning)
    assert ("did you mean" in reported) == bool(meaning)


def test_an_option_of_other_commands_is_reported_as_such(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended(delta_cad.main, ["schema", "--json"]) == 2
    reported = capsys.readouterr().err
    assert "--json; other commands have it, this one has not" in reported
    assert "did you mean" not in reported


@pytest.mark.parametrize(
    ("read", "good", "bad", "allowed"),
    [
        (number(0.01, 60.0, "s"), ["0.01", "6e1"], ["0.009", "61", "nan", "a"], "a number >= 0.01 and <= 60 s"),
        (
            number(POSITIVE, unit="mm", words=("max",)),
            ["1e-9", "max"],
            ["0", "-1", "inf", "mix"],
            "a number > 0 mm or max",
        ),
        (number(0.0), ["0"], ["-1"], "a number >= 0"),
        (whole(1), ["1", "99"], ["0", "1.5"], "a whole number >= 1"),
        (whole(0, 65535), ["65535"], ["65536", "-1"], "a whole number >= 0 and <= 65535"),
    ],
)
def test_a_value_out_of_its_bounds_is_refused_with_them(
    read: Callable[[str], object], good: list[str], bad: list[str], allowed: str, capsys: pytest.CaptureFixture[str]
) -> None:
    parser = Parser(prog="p")
    add_options(parser, [Option("--at", type=read)])
    for text in good:
        assert parser.parse_args([f"--at={text}"]).at == (text if text == "max" else float(text))
    for text in bad:
        with pytest.raises(SystemExit, match="2"):
            parser.parse_args([f"--at={text}"])
        assert capsys.readouterr().err == f"p: argument --at: {text}: must be {allowed}; see p --help\n"


def test_a_message_of_another_kind_gets_none() -> None:
    assert hint("the following arguments are required: --design", Parser(prog="-")) == ""


def test_what_is_meant_is_what_is_close() -> None:
    assert meant("cube_syde", ["clearance", "cube_side", "lean"]) == "cube_side"
    assert meant("k" * 100_000, ["cube_side"]) == ""
    motors = list(catalogue.family("motor"))
    assert meant("maxon-ec45", motors) == "maxon-ec45flat-411812"  # not the EC 60, as near by its letters
    assert meant("ec60flat", motors).startswith("maxon-ec60flat")
    assert meant("408057", motors) == "maxon-ec60flat-408057"
    heights = ["envelope_width_mm", "envelope_depth_mm"]
    assert meant("envelope_hight_mm", heights) == ""  # no height can be set: a width is not meant
    assert meant("envelope_hight_mm", [*heights, "height_max_mm"]) == "height_max_mm"
    assert meant("envelope_widht_mm", heights) == "envelope_width_mm"
    assert meant("peek_force_N", ["force_N", "peak_force_N"]) == "peak_force_N"
    assert unknown_key("motor", ["name"], ["hardware.motor"]).startswith("unknown key; did you mean hardware.motor?")
    assert unknown_key("zzz", ["name", "cube"]) == "unknown key; known here: name, cube"


# Options whose meaning, and so default and help, is a command's own; their name and unit are the same everywhere.
OWN = {
    "--out": "a file in some, a folder in others",
    "--design": "what is compared or drawn, in `verify` and `front`",
    "--mass-properties": "what is proved with, or compared",
    "--catalogue": "names the file that may name a folder, too",
    "--proof-minutes": "names the proofs",
    "--resume": "names what was left",
    "--force": "names what is overwritten",
    "--population": "of ours, or of the paper",
    "--generations": "of ours, or of the paper",
    "--gravity-torque": "reserved, or required of a certificate",
    "--tolerance": "proved, or required of a certificate",
    "--allow-remote": "who may connect, or where the board may be",
    "--rate": "of the controller, or of a simulated device",
    "--delay": "one, or a range",
    "--scene": "of a simulation, or of a device",
    "--seed": "of encoder counts",
    "--host": "listened on, or of a board",
    "--port": "listened on, or of a board",
}


def options() -> dict[str, list[tuple[str, argparse.Action]]]:
    """Option -> the commands that have it, with what each says of it."""
    found: dict[str, list[tuple[str, argparse.Action]]] = {}
    for script, cli in CLIS.items():
        for module in cli.COMMANDS:
            parser = Parser(prog="-")
            add_options(parser, module.OPTIONS)
            for action in parser._actions:
                for name in action.option_strings:
                    if action.help is not argparse.SUPPRESS:
                        found.setdefault(name, []).append((f"{script} {module.NAME}", action))
    return found


def test_an_option_is_the_same_in_every_command() -> None:
    for name, users in options().items():
        first = users[0][1]
        for command, action in users[1:]:
            assert action.nargs == first.nargs, (name, command)
            if name not in OWN:
                assert (action.metavar, action.default) == (first.metavar, first.default), (name, command)
                assert action.help == first.help, (name, command)
            elif first.metavar and name not in ("--out", "--tolerance"):
                assert action.metavar == first.metavar, (name, command)


def test_every_option_says_what_it_is_and_its_default_alike() -> None:
    for name, users in options().items():
        for command, action in users:
            text = action.help or ""
            assert len(text.split("default")[0]) > 4, (name, command, text)  # more than a default
            assert not re.search(r"default (?!:)|\(default", text), (name, command, text)
            known = action.default in (None, False, "", argparse.SUPPRESS) or "default" in text
            assert known, f"{command} {name} does not tell its default, {action.default}"
