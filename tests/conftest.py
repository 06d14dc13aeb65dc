"""The machine that the tests know, its dimensions, solids and build, and `best.json` weighed, made once and shared."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.common import console
from delta_cad.common.options import CACHE_OFF
from delta_cad.design import Design, design_from_dict, design_hash, load_design
from delta_cad.dimensions import Dimensions, dimensions
from tests.benchmarks.processor_cost import Costs
from tests.committed import BEST, COMMITTED, ROOT, Built, Shared
from tests.designs import placed

# A shell without job control starts what runs in its background deaf to Ctrl-C, and so all that tests start from there.
signal.signal(signal.SIGINT, signal.default_int_handler)
os.environ[CACHE_OFF] = "1"  # tests plant faults in code, of which a result that is kept knows nothing
console.FIRST_S = console.TELL_S = 3600.0  # what else a command says is looked at, however slow the machine is
console._durations = lambda: Path(os.devnull)  # a test's works are no basis of a user's estimates


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
def best_masses(best_assembly: Assembly) -> dict[str, Any]:
    """Masses of its solids, as a build writes them."""
    from delta_cad.export.mass_properties import mass_report

    return mass_report(best_assembly)


@pytest.fixture(scope="session")
def placed_dimensions() -> Dimensions:
    """A machine whose chains do not stand three-fold symmetrically."""
    return dimensions(design_from_dict(placed()))


@pytest.fixture(scope="session")
def placed_assembly(placed_dimensions: Dimensions) -> Assembly:
    """Its parts, placed."""
    from delta_cad.assembly.assemble import assemble

    return assemble(placed_dimensions)


@pytest.fixture(scope="session")
def direct_dimensions() -> Dimensions:
    return dimensions(load_design(ROOT / "docs" / "gallery" / "direct-83.json"))


@pytest.fixture(scope="session")
def direct_assembly(direct_dimensions: Dimensions) -> Assembly:
    """A machine whose arms are clamped on their motors' shafts."""
    from delta_cad.assembly.assemble import assemble

    return assemble(direct_dimensions)


@pytest.fixture(scope="session")
def shared(tmp_path_factory: pytest.TempPathFactory) -> Shared:
    """The folder of all workers of this run."""
    here = tmp_path_factory.getbasetemp()
    return Shared(here.parent if here.name.startswith("popen-gw") else here)


@pytest.fixture(scope="session")
def built(shared: Shared) -> Built:
    """`python -m delta_cad build` on the machine that the tests know, run once even when several workers want it."""
    name = load_design(BEST).name
    out = shared.folder / f"built-{name}"

    def build() -> tuple[int, str, str]:
        words = ["build", "--design", str(BEST), "--out", str(out), "--json"]
        run = subprocess.run([sys.executable, "-m", "delta_cad", *words], capture_output=True, text=True)
        return run.returncode, run.stdout, run.stderr

    return Built(*shared.once(f"built-{name}", build), out / name)


@pytest.fixture(scope="session")
def committed(shared: Shared) -> Built:
    """`best.json` made solid and weighed, its bill, masses and the checks of these: `make slow` builds it whole."""
    design = load_design(COMMITTED)
    folder = shared.folder / "weighed" / design.name

    def weigh() -> tuple[int, str, str]:
        from delta_cad.commands.pipeline import Outcome, check_weighed, cost_of, make_machine
        from delta_cad.common.files import write_record
        from delta_cad.export.bom import bill_of_materials, write_bom
        from delta_cad.structure.report import structure_record, structure_report

        machine = make_machine(design)
        cost, masses = cost_of(machine), machine.masses | {"input_sha256": design_hash(design)}
        outcome = Outcome(design, check_weighed(machine), masses, folder, (), cost.total_EUR())
        folder.mkdir(parents=True)
        unit_kg = {number: body["mass_kg"] for number, body in masses["parts"].items()}
        write_bom(bill_of_materials(machine.assembly, unit_kg, cost), folder)
        (folder / "mass_properties.json").write_text(json.dumps(masses))
        d = machine.dimensions
        structure = structure_record(d, structure_report(d, masses["bodies"])) | {"input_sha256": design_hash(design)}
        (folder / "structure.json").write_text(json.dumps(structure))
        (folder / "checks.json").write_text(json.dumps(outcome.record()))
        write_record(folder)
        return int(not outcome.passed), json.dumps(outcome.record()), ""

    return Built(*shared.once("weighed", weigh), folder)
