"""Commands killed at random moments: what stood before stands after, and the next run ends as an unkilled one."""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from random import Random

from delta_cad.design import load_design
from optimizer.synthesis.output import UNFINISHED
from tests.committed import BEST, ROOT

KILLS = 20  # of each command but a search of machines, of which one run takes as long as ten of others
LIMIT_S = 900.0  # of a run that is not killed: several times what a busy machine takes
TASK = ROOT / "examples/synthesized.toml"
GRID = """
base = "joystick.toml"
name = "grid"
steps = [1, 2]
method = "sqp"
[axes]
"requirements.joint_torque_N_m" = [0.5, 0.6, 0.7, 0.8]
"""
BRIEF = """
name = "small"
[requirements]
cube_side_mm = 40
force_N = 1
[hardware]
motor = "maxon-ec60flat-625858"
drive = "direct"
leads = "none"
[limits]
parallelogram_width_mm = 41
[bounds_mm]
upper_arm_length = [56, 58]
forearm_length = [98, 100]
platform_radius = [18, 19]
[goal]
minimize = "outline"
"""


@dataclass(frozen=True)
class Killed:
    """A command to kill.

    Attributes:
        name: Its name.
        arguments: Of `python`, for a folder; what takes up a killed run is among them.
        results: Relative places of what a whole run leaves, files or folders.
        rests: Endings of the names that a killed run may leave beside them.
        kills: How often.
    """

    name: str
    arguments: Callable[[Path], list[str]]
    results: tuple[str, ...]
    rests: tuple[str, ...] = (".part", ".checkpoint.jsonl")
    kills: int = KILLS


COMMANDS = (
    Killed(
        "build",
        lambda out: ["-m", "delta_cad", "build", "--design", str(BEST), "--out", str(out)],
        ("synthesized",),
        (".part",),
    ),
    Killed(
        "synthesize",
        lambda out: [
            "-m", "optimizer", "synthesize", str(TASK), "--out", str(out / "b.json"), "--resume", "--population", "60",
            "--generations", "60",
        ],
        ("b.json",),
    ),
    Killed(
        "front",
        lambda out: [
            "-m", "optimizer", "front", str(TASK), "--points", "4", "--seeds", "1", "--out", str(out), "--resume",
        ],
        ("synthesized-front",),
    ),
    Killed(
        "atlas",
        lambda out: [
            "-m", "optimizer", "atlas", str(out / "grid.toml"), "--out", str(out), "--workers", "1", "--resume",
        ],
        ("atlas/grid/atlas.json", "atlas/grid/atlas.csv"),
        (".part", "rows.jsonl"),
    ),
    Killed(
        "design",
        lambda out: ["-m", "optimizer", "design", str(out / "small.toml"), "--out", str(out), "--resume"],
        ("small",),
        (".part", ".design.jsonl"),
        5,
    ),
)  # fmt: skip


def digest(path: Path) -> str:
    """A hash of a file, or of all names and files of a folder; what differs between two whole runs is left out."""
    if path.is_dir():
        parts = [f"{file.relative_to(path)} {digest(file)}" for file in sorted(path.rglob("*")) if file.is_file()]
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()
    if path.suffix == ".json" and path.parent.name == "grid":
        data = json.loads(path.read_text())
        for row in data["rows"]:
            del row["seconds"]
        return hashlib.sha256(json.dumps(data).encode()).hexdigest()
    if path.name == "atlas.csv":
        lines = [line.rpartition(",")[0] for line in path.read_text().splitlines()]
        return hashlib.sha256("\n".join(lines).encode()).hexdigest()
    return hashlib.sha256(path.read_bytes()).hexdigest()


def start(arguments: list[str], **options: str) -> subprocess.Popen[bytes]:
    """Starts Python in a session of its own, so that all of it can be killed."""
    return subprocess.Popen(
        [sys.executable, *arguments], cwd=ROOT, env=os.environ | options, start_new_session=True,
        stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
    )  # fmt: skip


def _whole(killed: Killed, out: Path) -> dict[str, str]:
    """Runs a command to its end; the hashes of what it leaves."""
    run = start(killed.arguments(out))
    _, reported = run.communicate(timeout=LIMIT_S)
    if run.returncode != 0:
        raise AssertionError(f"{killed.name} ended with {run.returncode}: {reported.decode(errors='replace')[-500:]}")
    return {place: digest(out / place) for place in killed.results}


def _rests(killed: Killed, out: Path) -> list[str]:
    """What a run left besides its results and what it may leave."""
    known = {out / place for place in killed.results}
    return [
        str(path.relative_to(out))
        for path in out.rglob("*")
        if not any(path == one or path.is_relative_to(one) or one.is_relative_to(path) for one in known)
        and not any(part.endswith(killed.rests) for part in path.relative_to(out).parts)
        and path.name not in ("grid.toml", "joystick.toml", "small.toml", "atlas.md", "atlas.png")
    ]


def _unfinished(path: Path) -> bool:
    """Whether a file is a design that is sound and says that its run has not ended: the best so far."""
    return path.suffix == ".json" and UNFINISHED in load_design(path).provenance


def faults(killed: Killed, folder: Path, say: Callable[[str], None]) -> list[str]:
    """Kills a command at random moments, with and without a whole result of an earlier run in its place.

    Args:
        killed: The command.
        folder: Where it writes.
        say: Told what is being done.

    Returns:
        What was not as it should be.
    """
    rng, found, kills = Random(killed.name), [], killed.kills
    folder.mkdir(parents=True)
    (folder / "joystick.toml").write_bytes(TASK.read_bytes())
    (folder / "grid.toml").write_text(GRID)
    (folder / "small.toml").write_text(BRIEF)
    begun = time.monotonic()
    wanted = _whole(killed, folder)
    seconds = time.monotonic() - begun
    for place in killed.results:
        shutil.rmtree(folder / place) if (folder / place).is_dir() else (folder / place).unlink()
    for number in range(kills):
        if number == kills // 2:
            say(f"{killed.name}: taken up")
            if _whole(killed, folder) != wanted:
                found.append(f"{killed.name}: the run after {number} kills came to something else")
            left = [path.name for path in folder.rglob("*") if path.name.endswith(killed.rests)]
            found += [f"{killed.name}: {name} is left after a whole run" for name in left]
        after = rng.uniform(0.0, 1.0) * seconds
        say(f"{killed.name}: kill {number + 1} of {kills}, after {after:.1f} of {seconds:.1f} s")
        run = start(killed.arguments(folder))
        try:
            run.communicate(timeout=after)
        except subprocess.TimeoutExpired:
            os.kill(run.pid, signal.SIGKILL)  # alone: what it started must end by itself
            run.communicate()
        for place, content in wanted.items():
            there, finished_before = (folder / place).exists(), number >= kills // 2
            whole = there and digest(folder / place) == content
            if not whole and (finished_before or there) and (finished_before or not _unfinished(folder / place)):
                found.append(f"{killed.name}: {place} is not whole after a kill at {after:.1f} s")
        found += [f"{killed.name}: {rest} is left after a kill at {after:.1f} s" for rest in _rests(killed, folder)]
    return found
