"""The machine that the tests know, its dimensions and solids, builds of it and of `best.json`, made once and shared."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.common import console
from delta_cad.design import Design, load_design
from delta_cad.dimensions import Dimensions, dimensions
from tests.committed import BEST, COMMITTED, Built, Shared
from tests.cost.plugin import Costs

# A shell without job control starts what runs in its background deaf to Ctrl-C, and so all that tests start from there.
signal.signal(signal.SIGINT, signal.default_int_handler)
console.FIRST_S = console.TELL_S = 3600.0  # what else a command says is looked at, however slow the machine is


def pytest_addoption(parser: pytest.Parser) -> None:
    """Adds `--update`."""
    parser.addoption("--update", action="store_true", help="write golden files anew, to be read in the diff")


def pytest_configure(config: pytest.Config) -> None:
    """Measures what each file costs."""
    config.pluginmanager.register(Costs())


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks as slow what `quick(n)` leaves of a test."""
    seen: Counter[str] = Counter()
    for item in items:
        quick = item.get_closest_marker("quick")
        name = item.nodeid.partition("[")[0]
        seen[name] += 1
        if quick and seen[name] > quick.args[0]:
            item.add_marker(pytest.mark.slow)


@pytest.fixture
def golden(request: pytest.FixtureRequest) -> Callable[[Path, list[str]], None]:
    """Compares lines with those of a file, which `--update` writes anew."""

    def compare(path: Path, lines: list[str]) -> None:
        text = "".join(f"{line}\n" for line in lines)
        if request.config.getoption("--update"):
            path.write_text(text, encoding="utf-8")
        assert text == path.read_text(encoding="utf-8"), f"{path.name}: after a change of words run with --update"

    return compare


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
def shared(tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """The folder of all workers of this run."""
    here = tmp_path_factory.getbasetemp()
    return Shared(here.parent if here.name.startswith("popen-gw") else here)


@pytest.fixture(scope="session")
def built(shared: Shared) -> Built:
    """`python -m delta_cad build` on the machine that the tests know, run once even when several workers want it."""
    return _built(shared, BEST)


@pytest.fixture(scope="session")
def committed(shared: Shared) -> Built:
    """The same of `best.json`, data and checks alone; `make slow` has drawings, report and pictures made, too."""
    return _built(shared, COMMITTED, "--no-drawings", "--no-report")


def _built(shared: Shared, design: Path, *options: str) -> Built:
    name = load_design(design).name
    out = shared.folder / f"built-{name}"

    def build() -> tuple[int, str, str]:
        words = ["build", "--design", str(design), "--out", str(out), "--json", *options]
        run = subprocess.run([sys.executable, "-m", "delta_cad", *words], capture_output=True, text=True)
        return run.returncode, run.stdout, run.stderr

    return Built(*shared.once(f"built-{name}", build), out / name)
