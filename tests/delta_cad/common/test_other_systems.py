"""macOS and Windows, whose absences are simulated: what has not the modules and calls of Linux still works, or says so.

Not run on these systems: a `sitecustomize` module hides, in a process and in those that it starts, what they lack.

45 s of processor: commands, all modules and a solid, each in processes of their own, on two systems.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

from delta_cad.common.refusal import _extras, not_installed
from tests.committed import BEST, ROOT
from tests.terminal import HANGS_S

MACOS = """
import ctypes, os
del os.sched_getaffinity
class Library(ctypes.CDLL):
    def __getattr__(self, name):
        if name == "renameat2":
            raise AttributeError(name)
        return super().__getattr__(name)
ctypes.CDLL = Library
"""
WINDOWS = """
import os, shutil, signal, subprocess, sys, tempfile
class Without:
    def __init__(self, finder):
        self.finder = finder
    def find_spec(self, name, path=None, target=None):
        hidden = ("fcntl", "resource", "termios", "pwd", "grp", "pty", "tty")
        return None if name in hidden else self.finder.find_spec(name, path, target)
    def __getattr__(self, name):
        return getattr(self.finder, name)
sys.meta_path[:] = [Without(finder) for finder in sys.meta_path]
for name in ("fcntl", "resource", "termios", "pwd", "grp"):
    sys.modules.pop(name, None)
for name in ("sched_getaffinity", "pwrite", "nice", "O_NONBLOCK", "O_DIRECTORY", "fork", "killpg", "mkfifo"):
    delattr(os, name)
for name in ("SIGALRM", "SIGKILL", "setitimer", "ITIMER_REAL", "pthread_sigmask"):
    delattr(signal, name)
subprocess.Popen.kill = lambda run: run.send_signal(9)
shutil._use_fd_functions = False
opened = os.open
def refusing(path, *rest, **more):
    if os.path.isdir(path):
        raise PermissionError(13, "Permission denied", os.fspath(path))
    return opened(path, *rest, **more)
os.open = refusing
"""
NO_LOCKS = "note: this system has no file locks: run one command at a time on a folder of results"
PAPER = ROOT / "tests" / "references" / "joystick.toml"
SYSTEMS = {"macos": MACOS, "windows": WINDOWS}


@pytest.fixture(params=SYSTEMS)
def system(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[str, dict[str, str]]:
    """Its name, and the environment in which Python lacks what it has not."""
    place = tmp_path / "hidden"
    place.mkdir()
    (place / "sitecustomize.py").write_text(SYSTEMS[request.param])
    return request.param, os.environ | {"PYTHONPATH": os.pathsep.join([str(place), str(ROOT)])}


def run(room: dict[str, str], folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, *words]
    return subprocess.run(command, cwd=folder, env=room, capture_output=True, text=True, timeout=5 * HANGS_S)


def test_what_is_hidden_is_hidden(system: tuple[str, dict[str, str]], tmp_path: Path) -> None:
    code = (
        "import os; from importlib.util import find_spec; print(hasattr(os, 'sched_getaffinity'), find_spec('fcntl'))"
    )
    name, room = system
    found = run(room, tmp_path, "-c", code).stdout.strip()
    assert found.startswith("False ModuleSpec" if name == "macos" else "False None")


@pytest.mark.parametrize("package", ["delta_cad", "optimizer", "haptics"])
def test_every_module_of_a_package_loads(system: tuple[str, dict[str, str]], tmp_path: Path, package: str) -> None:
    """Its help, and each module that the geometry kernel is not loaded with."""
    name, room = system
    assert run(room, tmp_path, "-m", package, "--help").returncode == 0
    names = sorted(path.relative_to(ROOT).with_suffix("") for path in (ROOT / package).rglob("*.py"))
    modules = [".".join(path.parts) for path in names if path.stem not in ("__init__", "__main__")]
    loaded = run(room, tmp_path, "-c", f"from importlib import import_module\nfor m in {modules}: import_module(m)")
    assert (name, loaded.returncode, loaded.stderr) == (name, 0, "")


def test_a_design_is_inspected(system: tuple[str, dict[str, str]], tmp_path: Path) -> None:
    done = run(system[1], tmp_path, "-m", "delta_cad", "inspect", "--design", str(BEST), "--json")
    assert done.returncode == 0
    assert json.loads(done.stdout)["name"] == "synthesized"
    made = run(system[1], tmp_path, "-m", "optimizer", "init", "pocket")
    assert (made.returncode, (tmp_path / "pocket.toml").exists()) == (0, True)


STEP = f"""
from pathlib import Path
from delta_cad.common.worker_process import WorkerProcess
from delta_cad.design import load_design
from delta_cad.dimensions import dimensions
from delta_cad.export.folder import output_folder
from delta_cad.export.manifest import write_manifest
from delta_cad.solids.base_plate import make_base_plate
from optimizer.study.cluster import workers_here
d = dimensions(load_design(Path({str(BEST)!r})))
for text in ("first", "second"):
    with WorkerProcess("tests.delta_cad.common.forked", low_priority=True), output_folder(Path("out"), "x") as folder:
        assert make_base_plate(d).solid.isValid()
        (folder.path / "a").write_text(text)
        write_manifest(folder.path, input_hash="", status="passed", fingerprint="", left_out=())
assert workers_here() >= 1
print(Path("out/x/a").read_text(), sorted(path.name for path in Path("out").iterdir()))
"""


def test_a_part_is_made_and_a_folder_takes_the_place_of_another(
    system: tuple[str, dict[str, str]], tmp_path: Path
) -> None:
    name, room = system
    done = run(room, tmp_path, "-c", STEP)
    said = {"macos": "", "windows": f"{NO_LOCKS}\n"}[name]
    assert (done.returncode, done.stdout, done.stderr) == (0, "second ['x']\n", said)


JOURNAL = """
from pathlib import Path
from optimizer.codesign.search_log import Journal
from optimizer.synthesis.checkpoint import CheckpointError
first = Journal(Path("a.jsonl"), {"seed": 0}, False)
assert [first.memoize("sum", n, lambda n=n: 2 * n, int) for n in (1, 2)] == [2, 4]
try:
    Journal(Path("a.jsonl"), {"seed": 0}, True)
except CheckpointError as error:
    print(error)
first.close()
again = Journal(Path("a.jsonl"), {"seed": 0}, True)
print(again.memoize("sum", 2, lambda: 0, int))
"""


def test_the_journal_of_a_search_is_locked_where_there_are_locks_and_says_so_where_not(
    system: tuple[str, dict[str, str]], tmp_path: Path
) -> None:
    name, room = system
    done = run(room, tmp_path, "-c", JOURNAL)
    assert done.returncode == 0
    assert done.stdout.splitlines()[-1] == "4"
    assert ("another run" in done.stdout) is (name == "macos")
    assert done.stderr == ("" if name == "macos" else f"{NO_LOCKS}\n")


INTERRUPTED = """
import signal, time
from delta_cad.common import console
console.GRACE_S = console._AGAIN_S = 0.05
with console.Request() as required:
    signal.raise_signal(signal.SIGINT)
    print(required(), flush=True)
    while True:
        time.sleep(0.01)
"""


def test_who_does_not_look_is_interrupted_without_an_alarm_too(
    system: tuple[str, dict[str, str]], tmp_path: Path
) -> None:
    done = run(
        system[1],
        tmp_path,
        "-c",
        f"try:\n{INTERRUPTED.replace(chr(10), chr(10) + '  ')}\nexcept KeyboardInterrupt: print('ended')",
    )
    assert (done.stdout, done.stderr) == ("True\nended\n", "")


@pytest.mark.parametrize(
    ("module", "words", "extras"),
    [
        ("cadquery", ["delta_cad", "check", "--design", str(BEST)], "cad"),
        ("numba", ["delta_cad", "inspect", "--design", str(BEST)], ""),
        ("viser", ["delta_cad", "view", "--design", str(BEST)], "view"),
        ("cadquery", ["optimizer", "design", "pocket.toml"], "optimize,cad"),
        ("pymoo", ["optimizer", "synthesize", str(PAPER), "--method", "ga"], "optimize"),
        ("dask", ["optimizer", "atlas", "GRID.toml"], "optimize,atlas"),
        ("numpy", ["haptics", "gravity", "--design", str(BEST), "--at", "0,0,90"], "sim"),
    ],
)
def test_a_command_whose_library_is_missing_names_the_extra_that_has_it(
    tmp_path: Path, module: str, words: list[str], extras: str
) -> None:
    """All but `inspect`, whose proofs are interpreted without the compiler."""
    (tmp_path / "sitecustomize.py").write_text(WINDOWS.split("for name in")[0].replace('"fcntl"', f'"{module}"'))
    subprocess.run([sys.executable, "-m", "optimizer", "init", "pocket"], cwd=tmp_path, check=True, capture_output=True)
    (tmp_path / "GRID.toml").write_text('base = "pocket.toml"\n[axes]\n"feel.friction_max_N" = [0.6, 0.8]\n')
    room = os.environ | {"PYTHONPATH": os.pathsep.join([str(tmp_path), str(ROOT)])}
    done = run(room, tmp_path, "-m", *words)
    if not extras:
        assert done.returncode == 0
        return
    assert done.returncode != 0
    assert (
        "is not installed in this Python: make install and start .venv/bin/python, or pip install "
        f"'.[{extras}]', in a checkout of delta-haptics" in done.stderr
    )
    assert "Traceback" not in done.stderr


def test_every_extra_that_a_message_names_is_one_of_the_package() -> None:
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for package, found in _extras().items():
        assert all(any(one.startswith(package) for one in extras[extra]) for extra in found)
    assert not_installed("fcl", "cad").count("'.[cad]'") == not_installed("viser", "cad").count("'.[cad,view]'") == 1
