"""`python -m tests.mutants [WORD ...]`: plants each fault, or those with a word in it, and prints the share caught.

Faults are planted in copies of the project, one a core. The tests of a fault run in a fork of a process that has loaded
what they share, so that the cheap ones take a second. Exit code 1 if a fault survives or cannot be planted, or if tests
fail without any.
"""

from __future__ import annotations

import os
import select
import shutil
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import NamedTuple

import pytest

from tests.committed import ROOT
from tests.mutants.mutants import MUTANTS

CORES = 2
LIMIT_S = 1200.0
"""Of one run of tests: several times a room's own; a fault that makes a search endless is caught by it."""
LEFT_OUT = shutil.ignore_patterns(".*", "out", "*.egg-info")  # compiled Python goes along
NO_TEST = "no test was collected"
PROJECT = ("delta_cad", "optimizer", "haptics", "tests")
SHARED = ("numpy", "pydantic", "scipy.optimize", "scipy.spatial.transform")


class Fault(NamedTuple):
    """A line that is wrong, and the tests, files or a room's folder, that should notice."""

    tests: tuple[str, ...]
    file: str
    what: str
    old: str
    new: str

    @property
    def name(self) -> str:
        """File and what is wrong."""
        return f"{self.file}: {self.what}"


FAULTS = tuple(Fault(tuple(tests.split()), *fault) for tests, faults in MUTANTS.items() for fault in faults)


class _First:
    """A plugin of pytest that keeps the first test that fails."""

    def __init__(self) -> None:
        self.failed = ""

    def pytest_runtest_logreport(self, report: pytest.TestReport) -> None:
        if report.failed:
            self.failed = self.failed or report.nodeid

    def pytest_collectreport(self, report: pytest.CollectReport) -> None:
        if report.failed:
            self.failed = self.failed or f"{report.nodeid}, which cannot be imported"


def _tested(copy: Path, tests: Sequence[str]) -> str:
    """Runs tests of a copy in this process, a fork of its own; what fails first, "" if nothing does."""
    os.setsid()
    os.chdir(copy)
    silent = os.open(os.devnull, os.O_RDWR)
    for stream in range(3):
        os.dup2(silent, stream)
    for name in [name for name in sys.modules if name.partition(".")[0] in PROJECT]:
        del sys.modules[name]
    sys.path.insert(0, str(copy))
    sys.dont_write_bytecode = True  # no code outlives its source
    os.environ |= {"PYTHONDONTWRITEBYTECODE": "1", "NUMBA_CACHE_DIR": str(copy.parent / "compiled")}
    every = ["-m", ""] if any((copy / test).is_dir() for test in tests) else []
    first = _First()
    words = ["-x", "-q", "--tb=no", "-p", "no:cacheprovider", "-p", "no:xdist", *every, *tests]
    code = pytest.main(words, plugins=[first])
    if code == pytest.ExitCode.NO_TESTS_COLLECTED:
        return NO_TEST
    return first.failed or ("" if code == pytest.ExitCode.OK else f"pytest's exit code {int(code)}")


def failure(copy: Path, tests: Sequence[str]) -> str:
    """What fails first of tests of a copy; "" if they pass."""
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        try:  # whatever happens, the fork ends here
            os.close(reading)
            os.write(writing, _caught(copy, tests).encode()[:4000])
        finally:
            os._exit(0)
    os.close(writing)
    try:
        ready, _, _ = select.select([reading], [], [], LIMIT_S)
        return os.read(reading, 4000).decode() if ready else f"no end within {LIMIT_S:g} s"
    finally:
        os.close(reading)
        with suppress(ProcessLookupError):
            os.killpg(child, signal.SIGKILL)
        os.waitpid(child, 0)


def _caught(copy: Path, tests: Sequence[str]) -> str:
    try:
        return _tested(copy, tests)
    except BaseException as error:
        return repr(error)


def _likely(copy: Path, fault: Fault) -> list[str]:
    """Those of a room's tests that are named after the fault's file: they catch most of them, in seconds."""
    stem = Path(fault.file).stem[:3]
    return sorted(str(path) for test in fault.tests for path in (copy / test).rglob(f"test_{stem}*.py"))


def _verdict(copy: Path, fault: Fault) -> str:
    """What becomes of a fault: `caught`, `SURVIVED` or `not planted`, and by what."""
    file = copy / fault.file
    text = file.read_text(encoding="utf-8")
    if text.count(fault.old) != 1:
        return f"not planted: {fault.old!r} stands there {text.count(fault.old)} times, not once"
    file.write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    try:
        for tests in (_likely(copy, fault), fault.tests):
            found = failure(copy, tests) if tests else ""
            if found not in ("", NO_TEST):
                return f"caught: {found}"
        return "SURVIVED"
    finally:
        shutil.copy2(ROOT / fault.file, file)  # with its date, by which compiled Python is known


_COPY = Path()


def _begin(copies: Sequence[Path], number) -> None:  # type: ignore[no-untyped-def]
    """Gives this worker a copy of its own, and loads what all tests share."""
    global _COPY
    signal.signal(signal.SIGTERM, lambda *_: sys.exit())  # so that no tests go on without it
    with number:
        _COPY = copies[number.value]
        number.value += 1
    for name in SHARED:
        __import__(name)


def _sound(test: str) -> tuple[str, str]:
    return test, failure(_COPY, [test])


def _planted(fault: Fault) -> tuple[str, str, float]:
    start = perf_counter()
    return fault.name, _verdict(_COPY, fault), perf_counter() - start


def main(words: list[str]) -> int:
    """Plants the faults that have one of the words in file or description, or all."""
    chosen = [fault for fault in FAULTS if not words or any(word in fault.name for word in words)]
    verdicts: list[str] = []
    with TemporaryDirectory() as folder:
        copies = [Path(folder) / str(k) / "project" for k in range(CORES)]
        for copy in copies:
            shutil.copytree(ROOT, copy, ignore=LEFT_OUT)
        context = get_context("fork")
        with context.Pool(CORES, _begin, (copies, context.Value("i", 0))) as pool:
            sound = pool.map(_sound, sorted({test for fault in chosen for test in fault.tests}), chunksize=1)
            if failing := [f"without any fault: {test}: {found}" for test, found in sound if found]:
                print("\n".join(failing))
                return 1
            for name, verdict, seconds in pool.imap_unordered(_planted, chosen):
                verdicts.append(verdict)
                print(f"{name}: {verdict} ({seconds:.0f} s)", flush=True)
    caught = sum(v.startswith("caught") for v in verdicts)
    print(f"{caught} of {len(verdicts)} faults caught")
    return 0 if caught == len(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
