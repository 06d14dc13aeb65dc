"""The committed design, its dimensions and solids, and one real build of it, each made once and shared."""

from __future__ import annotations

import fcntl
import json
import signal
import subprocess
import sys

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.common import console
from delta_cad.design import Design, load_design
from delta_cad.dimensions import Dimensions, dimensions
from tests.committed import BEST, Built

# A shell without job control starts what runs in its background deaf to Ctrl-C, and so all that tests start from there.
signal.signal(signal.SIGINT, signal.default_int_handler)
console.TELL_S = 3600.0  # what else a command says is looked at, however slow the machine is


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
