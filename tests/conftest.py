"""The committed design, its dimensions and solids, and one real build of it, each made once and shared."""

from __future__ import annotations

import fcntl
import hashlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design, load_design
from delta_cad.dimensions import Dimensions, dimensions
from tests.committed import BEST, Built

ROOT = Path(__file__).parents[1]


def pytest_configure(config: pytest.Config) -> None:
    """Throws away compiled functions when one has changed since: a cached caller keeps its callees' old code."""
    if hasattr(config, "workerinput"):
        return
    sources = sorted(path for name in ("delta_cad", "optimizer", "haptics") for path in (ROOT / name).rglob("*.py"))
    compiled = [text for text in (path.read_bytes() for path in sources) if b"njit" in text]
    digest = hashlib.sha256(b"".join(compiled)).hexdigest()
    stamp = ROOT / ".venv" / ".compiled"
    if not stamp.parent.exists() or (stamp.exists() and stamp.read_text() == digest):
        return
    for name in ("delta_cad", "optimizer", "haptics"):
        for kind in ("*.nbi", "*.nbc"):
            for path in (ROOT / name).rglob(kind):
                path.unlink(missing_ok=True)
    stamp.write_text(digest)


@pytest.fixture(scope="session")
def best() -> Design:
    return load_design(BEST)


@pytest.fixture(scope="session")
def best_dimensions(best: Design) -> Dimensions:
    return dimensions(best)


@pytest.fixture(scope="session")
def best_assembly(best_dimensions: Dimensions) -> Assembly:
    from delta_cad.assembly.assemble import assemble

    return assemble(best_dimensions)


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory, best: Design) -> Built:
    """`python -m delta_cad build` on the committed design, run once even when several workers want it."""
    here = tmp_path_factory.getbasetemp()
    shared = here.parent if here.name.startswith("popen-gw") else here
    with open(shared / "built.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        told = shared / "built.json"
        if not told.exists():
            command = [
                sys.executable,
                "-m",
                "delta_cad",
                "build",
                "--design",
                str(BEST),
                "--out",
                str(shared / "built"),
            ]
            run = subprocess.run([*command, "--json"], capture_output=True, text=True)
            told.write_text(json.dumps([run.returncode, run.stdout, run.stderr]))
    code, stdout, stderr = json.loads(told.read_text())
    return Built(code, stdout, stderr, shared / "built" / best.name)
