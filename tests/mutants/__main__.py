"""`python -m tests.mutants [WORD ...]`: plants each fault, or those with a word in it, and prints the share caught.

Exit code 1 if a fault survives or cannot be planted, or if tests fail without any.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from tests.committed import ROOT
from tests.mutants.mutants import MUTANTS

LIMIT_S = 1200.0
"""Of one run of tests: several times a room's own; a fault that makes a search endless is caught by it."""
LEFT_OUT = shutil.ignore_patterns(".*", "out", "__pycache__", "*.egg-info")


def failure(copy: Path, tests: list[str], cache: str | Path) -> str | None:
    """What fails first of tests of a copy, compiled code being kept in a folder; None if they pass."""
    settings = {"NUMBA_CACHE_DIR": str(cache), "PYTHONDONTWRITEBYTECODE": "1"}  # no code outlives its source
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-m", "", *tests]
    try:
        run = subprocess.run(
            command, cwd=copy, env=os.environ | settings, capture_output=True, text=True, timeout=LIMIT_S
        )
    except subprocess.TimeoutExpired:
        return f"no end within {LIMIT_S:g} s"
    if run.returncode == 0:
        return None
    lines = [line for line in run.stdout.splitlines() if line.startswith(("FAILED", "ERROR"))]
    return lines[0] if lines else f"pytest's exit code {run.returncode}"


def verdict(file: Path, old: str, new: str, copy: Path, tests: Path, shared: Path) -> str:
    """What becomes of a fault: `caught`, `SURVIVED` or `not planted`, and by what."""
    likely = sorted(
        str(path) for path in tests.rglob(f"test_{file.stem[:3]}*.py")
    )  # they catch most of them, in seconds
    text = file.read_text(encoding="utf-8")
    if text.count(old) != 1:
        return f"not planted: {old!r} stands there {text.count(old)} times, not once"
    file.write_text(text.replace(old, new), encoding="utf-8")
    try:
        with TemporaryDirectory() as fresh:  # a caller's compiled code holds its callees'
            found = failure(copy, [*likely, str(tests)], fresh if "@compiled" in text else shared)
    finally:
        file.write_text(text, encoding="utf-8")
    return "SURVIVED" if found is None else f"caught: {found}"


def main(words: list[str]) -> int:
    """Plants the faults that have one of the words in file or description, or all."""
    verdicts: list[str] = []
    with TemporaryDirectory() as folder:
        copy, shared = Path(folder) / "project", Path(folder) / "compiled"
        shutil.copytree(ROOT, copy, ignore=LEFT_OUT)
        for tests, faults in MUTANTS.items():
            before = len(verdicts)
            for file, fault, old, new in faults:
                name, start = f"{file}: {fault}", perf_counter()
                if words and not any(word in name for word in words):
                    continue
                if len(verdicts) == before and (found := failure(copy, [tests], shared)) is not None:
                    print(f"without any fault: {found}")
                    return 1
                verdicts.append(verdict(copy / file, old, new, copy, copy / tests, shared))
                print(f"{name}: {verdicts[-1]} ({perf_counter() - start:.0f} s)", flush=True)
    caught = sum(v.startswith("caught") for v in verdicts)
    print(f"{caught} of {len(verdicts)} faults caught")
    return 0 if caught == len(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
