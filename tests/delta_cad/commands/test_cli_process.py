"""The command line as a process: exit codes, what is loaded when, readers that go away."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from delta_cad.common.console import INTERRUPTED
from delta_cad.common.refusal import not_installed
from tests.committed import BEST, changed
from tests.terminal import interrupted, said


def run(*arguments: str, code: str = "") -> subprocess.CompletedProcess[str]:
    command = ["-c", code] if code else ["-m", "delta_cad", *arguments]
    return subprocess.run([sys.executable, *command], capture_output=True, text=True)


def test_exit_codes_of_the_process(tmp_path: Path) -> None:
    asking, thin = tmp_path / "asking.json", tmp_path / "thin.json"
    asking.write_text(json.dumps(changed(requirements__kappa_max=1.5)))
    thin.write_text(json.dumps(changed(hardware__platform_thickness_mm=9.0)))
    out = str(tmp_path / "out")
    for arguments, code in (
        (["inspect", "--design", str(asking)], 1),
        (["inspect", "--out", out], 2),
        (["build", "--design", str(thin), "--out", out], 2),
    ):
        ended = run(*arguments)
        assert ended.returncode == code, ended
        assert "Traceback" not in ended.stderr
        assert said(ended.stderr).count("\n") == (code >= 2) + (arguments[0] == "build")  # and what --suggest does


HEAVY = "('cadquery', 'OCP', 'trimesh', 'vtkmodules', 'vtk', 'fcl', 'matplotlib', 'mujoco', 'gmsh')"


def test_no_cad_kernel_is_loaded_before_it_is_needed() -> None:
    """In one process, which looks after each: what one of them loaded, the next would still have."""
    steps = [
        "import delta_cad",
        "import delta_cad.design",
        "import delta_cad.commands.cli",
        "import delta_cad.dimensions, delta_cad.mechanism.placement, delta_cad.assembly.machine, delta_cad.solids.part",
        "import delta_cad.drive",
        "import delta_cad.commands.inspection, delta_cad.commands.tables",
        *(
            f"try: delta_cad.commands.cli.main({words!r})\nexcept SystemExit: pass"
            for words in (["--help"], ["build", "--help"], ["schema"], ["inspect", "--design", str(BEST)])
        ),
    ]
    looked = [f"{step}\nprint('LOADED', [m for m in {HEAVY} if m in sys.modules])" for step in steps]
    ended = run(code="\n".join(["import sys", *looked]))
    assert ended.returncode == 0, ended.stderr
    assert [line for line in ended.stdout.splitlines() if line.startswith("LOADED")] == len(steps) * ["LOADED []"]


def test_help_loads_no_more_than_arguments_need() -> None:
    ended = run(
        code="import sys\nfrom delta_cad.commands.cli import main\ntry: main(['--help'])\nexcept SystemExit: pass\n"
        "print('LOADED', [m for m in ('numpy', 'scipy', 'pydantic', 'rich') if m in sys.modules])"
    )
    assert ended.stdout.splitlines()[-1] == "LOADED []"


@pytest.mark.parametrize("module", ["cadquery", "trimesh"])  # the second is needed after a minute of work
def test_without_the_cad_extra_the_build_says_what_to_install_at_once(module: str, tmp_path: Path) -> None:
    ended = run(
        code=f"import sys; sys.modules[{module!r}] = None\nfrom delta_cad.commands.cli import main\n"
        f"code = main(['check', '--design', {str(BEST)!r}, '--out', {str(tmp_path / 'out')!r}])\n"
        f"print('LOADED', [m for m in {HEAVY} if m != {module!r} and m in sys.modules])\nsys.exit(code)"
    )
    assert ended.returncode == 3
    assert said(ended.stderr).count("\n") == 1
    assert not_installed(module, "cad") in ended.stderr
    assert ended.stdout.splitlines()[-1] == "LOADED []"


def test_a_reader_that_goes_away_is_no_error() -> None:
    ended = subprocess.run(
        f"{sys.executable} -m delta_cad schema | head -c 10", shell=True, capture_output=True, text=True
    )
    assert said(ended.stderr) == ""
    assert len(ended.stdout) == 10


@pytest.mark.quick(1)
@pytest.mark.parametrize(("kappa_max", "code"), [(3.0, 0), (1.5, 1)])
@pytest.mark.parametrize("options", [[], ["--json"]])
def test_the_exit_code_outlives_a_reader_that_goes_away(
    kappa_max: float, code: int, options: list[str], tmp_path: Path
) -> None:
    file = tmp_path / "asking.json"
    file.write_text(json.dumps(changed(requirements__kappa_max=kappa_max)))
    reading, writing = os.pipe()
    os.close(reading)  # before the first byte: every write fails
    try:
        ended = subprocess.run(
            [sys.executable, "-m", "delta_cad", "inspect", "--design", str(file), *options],
            stdout=writing,
            stderr=subprocess.PIPE,
            text=True,
        )
    finally:
        os.close(writing)
    assert (ended.returncode, said(ended.stderr)) == (code, "")


@pytest.mark.quick(2)
@pytest.mark.parametrize(("command", "after_s"), [("build", 0.0), ("build", 1.0), ("check", 4.0)])
def test_ctrl_c_at_any_moment_is_one_line_and_leaves_nothing(command: str, after_s: float, tmp_path: Path) -> None:
    """While the CAD kernel loads, too, of which a second try to load it would complain."""
    out = tmp_path / "out"
    words = [sys.executable, "-m", "delta_cad", command, "--design", str(BEST), "--out", str(out)]
    ended = interrupted(words, after_s)
    assert (ended.code, ended.said) == (INTERRUPTED, "interrupted; nothing was written\n")
    assert not out.exists() or list(out.iterdir()) == []
