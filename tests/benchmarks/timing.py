"""Clocks: functions timed in turns, child processes with their time and memory, slopes of growth."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryFile
from time import perf_counter, sleep

import numpy as np

ROOT = Path(__file__).parents[2]
POLL_S = 0.1  # the build holds its peak for seconds


def interleaved(
    functions: Mapping[str, Callable[[], object]], rounds: int, clock: Callable[[], float] = perf_counter
) -> dict[str, list[float]]:
    """Times of functions, s, one of each in every round, so that a slow spell of the machine hits all of them.

    Args:
        functions: What to time; each is called once before the clock starts.
        rounds: How often.
        clock: Seconds since any moment; `process_time` where nothing waits and the machine is shared.

    Returns:
        Name -> `rounds` times.
    """
    for function in functions.values():
        function()
    times: dict[str, list[float]] = {name: [] for name in functions}
    for _ in range(rounds):
        for name, function in functions.items():
            start = clock()
            function()
            times[name].append(clock() - start)
    return times


def ratios(above: Sequence[float], below: Sequence[float]) -> list[float]:
    """Quotients of two timings round by round."""
    return [a / b for a, b in zip(above, below, strict=True)]


@dataclass(frozen=True)
class Child:
    """What a child process cost.

    Attributes:
        wall_s: From start to end.
        processor_s: User and system time of it and of all its children.
        largest_bytes: Largest resident size of any one process of its tree.
        tree_bytes: Largest sum over its tree, shared pages counted once; 0 when it was not watched.
        code: Exit code.
        stdout: What it wrote.
        stderr: What it wrote to standard error.
    """

    wall_s: float
    processor_s: float
    largest_bytes: int
    tree_bytes: int
    code: int
    stdout: str
    stderr: str


def python(*arguments: str, watch: bool = False) -> Child:
    """Run this interpreter with arguments in the project's root.

    Args:
        arguments: Its arguments.
        watch: Whether to sample the memory of its whole tree; that costs it a little time.
    """
    with TemporaryFile() as out, TemporaryFile() as errors:
        start = perf_counter()
        process = subprocess.Popen([sys.executable, *arguments], cwd=ROOT, stdout=out, stderr=errors)
        tree, how = 0, os.WNOHANG if watch else 0
        while True:
            ended, status, usage = os.wait4(process.pid, how)
            if ended:
                break
            tree = max(tree, _tree_bytes(process.pid))
            sleep(POLL_S)
        wall = perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)  # wait4 took it: nobody may wait again
        out.seek(0)
        errors.seek(0)
        reported, complaint = out.read().decode(), errors.read().decode()
    busy = usage.ru_utime + usage.ru_stime
    return Child(wall, busy, usage.ru_maxrss * 1024, tree, process.returncode, reported, complaint)


def succeeded(child: Child) -> Child:
    """The child, if it did its work.

    Raises:
        RuntimeError: It did not, with the last line that it wrote.
    """
    if child.code:
        last = (child.stderr or child.stdout).strip().splitlines()[-1:]
        raise RuntimeError(f"a measured command ended with exit code {child.code}: {' '.join(last)}")
    return child


def _tree_bytes(pid: int) -> int:
    """Memory of a process and its descendants now, shared pages shared out; what has ended meanwhile counts 0."""
    total, waiting = 0, [pid]
    while waiting:
        here = Path("/proc") / str(waiting.pop())
        try:
            for line in (here / "smaps_rollup").read_text().splitlines():
                if line.startswith("Pss:"):
                    total += int(line.split()[1]) * 1024
            for thread in (here / "task").iterdir():
                waiting += [int(child) for child in (thread / "children").read_text().split()]
        except OSError:
            continue
    return total


def slope(sizes: Sequence[float], times: Sequence[float]) -> float:
    """Exponent of growth: slope of log time against log size, least squares."""
    return float(np.polyfit(np.log(sizes), np.log(times), 1)[0])
