"""Disks that are full or must not be written, two runs in one place, caches and modules that are not there."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from tests.committed import BEST, ROOT
from tests.endurance.kills import LIMIT_S, TASK, digest, start
from tests.endurance.readers import unfit
from tests.terminal import said

SMALL = 2**18  # bytes: less than a build writes, more than a checkpoint needs to begin
CHECK = ["-m", "delta_cad", "check", "--design", str(BEST), "--out"]
BUILD = ["-m", "delta_cad", "build", "--design", str(BEST), "--out"]
SEARCH = [
    "-m",
    "optimizer",
    "synthesize",
    str(TASK),
    "--no-proof",
    "--population",
    "400",
    "--generations",
    "60",
    "--out",
]
PROVE = ["-m", "optimizer", "certify", "--design", str(BEST), "--out"]
NO_MODULES = """
import runpy, sys
class Missing:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in {names!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Missing())
sys.argv = [{program!r}, *sys.argv[1:]]
runpy.run_module({program!r}, run_name="__main__")
"""


def ended(arguments: list[str], codes: tuple[int, ...] = (2,), needs: str = "", **options: str) -> list[str]:
    """Runs Python to its end; what was wrong about its exit code and its one line."""
    run = start(arguments, **options)
    try:
        _, reported = run.communicate(timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        run.kill()
        run.communicate()
        return [f"no end: {' '.join(arguments)}"]
    text = said(reported.decode(errors="backslashreplace"))
    lines = [line for line in text.split("\n") if line and not line.startswith("note: ")]
    found = [] if run.returncode in codes else [f"exit code {run.returncode}, not {codes}: {text[-300:]!r}"]
    if run.returncode in (0, 1):
        return found
    if len(lines) != 1 or unfit(lines[0]) or needs not in lines[0]:
        found.append(f"not one line with {needs!r}: {text[-500:]!r}")
    return found


@contextmanager
def small_disk(folder: Path, size: int) -> Iterator[bool]:
    """A file system of a few bytes on a folder; whether this user may mount one."""
    folder.mkdir(parents=True)
    mount = ["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(folder)]
    try:
        mounted = subprocess.run(mount, capture_output=True).returncode == 0
    except FileNotFoundError:
        mounted = False
    try:
        yield mounted
    finally:
        if mounted:
            subprocess.run(["umount", "-l", str(folder)], check=True)


def full(folder: Path) -> list[str]:
    """Build, search and proof on a disk that becomes full, and with files that may not grow."""
    found, disk = [], folder / "disk"
    with small_disk(disk, SMALL) as mounted:
        if mounted:
            (disk / "kept").write_text("kept")
            found += ended([*BUILD, str(disk)], needs=str(disk))
            (disk / "filler").write_bytes(bytes(SMALL - 3 * 4096 * 8))
            found += ended([*SEARCH, str(disk / "b.json")], codes=(0, 2))
            with (disk / "rest").open("wb", buffering=0) as file, suppress(OSError):
                while file.write(bytes(4096)):
                    pass
            found += [f"not before the work: {one}" for one in ended([*CHECK, str(disk)], needs=str(disk))]
            found += ended([*PROVE, str(disk / "c.json")], needs=str(disk))
            names = {path.name for path in disk.iterdir()} - {"kept", "filler", "rest", "b.json"}
            left = [name for name in names if not name.endswith(".checkpoint.jsonl")]
            found += [f"left on the full disk: {name}" for name in left]
    small = folder / "small"
    small.mkdir()
    code = f"import os, resource, sys\nresource.setrlimit(resource.RLIMIT_FSIZE, ({2**15}, {2**15}))\n"
    code += "os.execv(sys.executable, [sys.executable, *sys.argv[1:]])"
    found += ended(["-c", code, *BUILD, str(small)], needs=str(small))
    return found + [f"left behind: {path.name}" for path in small.iterdir()]


def read_only(folder: Path) -> list[str]:
    """Places that cannot be written, told before the work; `/proc` refuses also who may do everything."""
    found = []
    (folder / "a file").write_text("")
    for place in (Path("/proc/none"), folder / "a file" / "below", Path("/dev/full/below")):
        for command in (BUILD, CHECK, SEARCH, PROVE):
            found += ended([*command, str(place)], needs=str(place.parent))
    with open("/dev/full", "wb") as nowhere:
        run = subprocess.run(
            [sys.executable, "-m", "delta_cad", "schema"], cwd=ROOT, stdout=nowhere, stderr=subprocess.PIPE, text=True
        )
    expected = (2, "standard output: No space left on device\n")
    return found + ([] if (run.returncode, said(run.stderr)) == expected else [f"schema >/dev/full: {run}"])


def two_at_once(folder: Path) -> list[str]:
    """Two builds into one folder: both end well, and the folder is one whole build."""
    runs = [start([*BUILD, str(folder)]) for _ in range(2)]
    found = []
    for run in runs:
        _, reported = run.communicate(timeout=LIMIT_S)
        if run.returncode != 0:
            found.append(f"exit code {run.returncode}: {reported.decode(errors='replace')[-300:]!r}")
    names = [path.name for path in folder.iterdir()]
    if names != ["synthesized"]:
        return [*found, f"left behind: {names}"]
    both = digest(folder / names[0])
    found += ended([*BUILD, str(folder)], codes=(0,))
    return found + ([] if digest(folder / names[0]) == both else ["two builds at once came to something else than one"])


def no_caches(folder: Path) -> list[str]:
    """Caches that cannot be written: the work is done nevertheless."""
    task = [*SEARCH, str(folder / "b.json"), "--steps", "1"]
    found = []
    for place in ("/proc/none", "/dev/full"):
        settings = {"NUMBA_CACHE_DIR": place, "XDG_CACHE_HOME": place, "HOME": place, "MPLCONFIGDIR": place}
        found += ended(task, codes=(0, 1), **settings)
    return found


def no_extras(folder: Path) -> list[str]:
    """Each extra left out: one line that says what to install."""
    front = ["front", str(TASK), "--out", str(folder)]
    cases: list[tuple[str, tuple[str, ...], list[str]]] = [
        ("delta_cad", ("cadquery", "OCP"), [*BUILD[2:], str(folder)]),
        ("delta_cad", ("trimesh", "fcl"), [*CHECK[2:], str(folder)]),
        ("optimizer", ("numba",), [*SEARCH[2:], str(folder / "b.json")]),
        ("optimizer", ("matplotlib",), front),
        ("optimizer", ("dask", "distributed"), ["atlas", str(folder / "g.toml"), "--out", str(folder)]),
        ("haptics", ("numba",), ["gravity", "--design", str(BEST), "--point-masses", "60,50,20"]),
        ("haptics", ("numba",), ["stiffness", "--design", str(BEST), "--out", str(folder)]),
    ]
    found = []
    for program, names, arguments in cases:
        code = NO_MODULES.format(names=set(names), program=program)
        found += [
            f"{program} {arguments[0]} without {names[0]}: {one}"
            for one in ended(["-c", code, *arguments], codes=(0, 2, 3))
        ]
    return found


TRIALS: dict[str, Callable[[Path], list[str]]] = {
    "a full disk": full,
    "places that cannot be written": read_only,
    "two builds at once": two_at_once,
    "no caches": no_caches,
    "no extras": no_extras,
}
