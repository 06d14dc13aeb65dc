"""One subject measured in a process of its own, so that nothing it dies of reaches the others.

`python -m tests.benchmarks.subject MODULE FILE` is that process: it calls `MODULE.run(say)` and writes the figures.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import traceback
from importlib import import_module
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from tests.benchmarks.figure import Figure
from tests.benchmarks.timing import ROOT


class NotMeasuredError(Exception):
    """A subject came to no figures; the message says why."""


def measure(module: str, limit_s: float) -> list[Figure]:
    """The figures of a subject; its progress goes to stderr.

    Args:
        module: Full name of a module with `run(say) -> list[Figure]`.
        limit_s: Time after which it is killed with all its children.

    Raises:
        NotMeasuredError: It raised, its process died, or its time is over.
    """
    with TemporaryDirectory() as folder:
        file = Path(folder) / "figures.json"
        command = [sys.executable, "-m", __name__, module, str(file)]
        process = subprocess.Popen(command, cwd=ROOT, stdout=sys.stderr, start_new_session=True)
        try:
            code = process.wait(limit_s)
        except subprocess.TimeoutExpired:
            raise NotMeasuredError(f"not ended after {limit_s:g} s") from None
        finally:
            if process.returncode is None:
                os.killpg(process.pid, signal.SIGKILL)
                process.wait()
        if not file.exists():
            raise NotMeasuredError(
                f"killed by signal {-code}" if code < 0 else f"its process ended with exit code {code}"
            )
        result = json.loads(file.read_text(encoding="utf-8"))
    if "failed" in result:
        raise NotMeasuredError(result["failed"])
    return [Figure.from_json(figure) for figure in result["figures"]]


def main(module: str, file: str) -> None:
    """Measures a subject in this process and writes what came of it, whole or not at all."""
    start = perf_counter()

    def say(text: str) -> None:
        print(f"{perf_counter() - start:8.1f} s  {text}", file=sys.stderr, flush=True)

    result: dict[str, object]
    try:
        figures: list[Figure] = import_module(module).run(say)
        for f in figures:
            say(f"{f.name}: {f.value:.4g} {f.unit}")
        result = {"figures": [f.to_json() for f in figures]}
    except Exception as error:
        traceback.print_exc()
        result = {"failed": f"{type(error).__name__}: {error}"}
    adjacent = Path(file + ".part")
    adjacent.write_text(json.dumps(result), encoding="utf-8")
    adjacent.rename(file)


if __name__ == "__main__":
    main(*sys.argv[1:])
