"""What test files cost is measured with their child processes, and what they say of it decides their order."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

from tests.benchmarks.processor_cost import DEAR_S, SHOWN, stated_s, table
from tests.committed import ROOT

BURN = "import time; end = time.process_time() + 0.5\nwhile time.process_time() < end: pass"
CONFTEST = "from tests.benchmarks.processor_cost import Costs\n"
CONFTEST += "def pytest_configure(config): config.pluginmanager.register(Costs())\n"


def test_a_docstring_says_what_its_file_costs() -> None:
    assert stated_s("A subject.\n\n60 s of processor: the one whole build.\n") == 60.0
    assert stated_s("A subject of 60 s of processor: none\n\n60 s of processor") == 0.0
    assert stated_s(None) == 0.0


def test_the_table_has_the_dearest_and_all_that_say_something_else() -> None:
    costs = {f"cheap_{k}": 1.0 + 0.1 * k for k in range(20)} | {"known": 60.0, "unknown": DEAR_S + 1.0, "was_dear": 0.2}
    lines = table(costs, {"known": 50.0, "was_dear": 30.0})
    assert [line.split()[2] for line in lines] == [
        *("known", "unknown"),
        *(f"cheap_{k}" for k in range(19, 21 - SHOWN, -1)),
        "was_dear",
    ]
    assert [line.split()[2] for line in lines if "<-" in line] == ["unknown", "was_dear"]
    assert lines[-1].endswith("its docstring says 30 s")


def test_workers_hand_their_costs_over_and_the_dear_files_begin(tmp_path: Path) -> None:
    child = f"import subprocess, sys\ndef test_child(): subprocess.run([sys.executable, '-c', {BURN!r}], check=True)\n"
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_a.py").write_text("def test_nothing(): pass\n")
    (tmp_path / "test_b.py").write_text(f'"""B.\n\n30 s of processor: a child.\n"""\n{child}')
    (tmp_path / "test_c.py").write_text(f'"""C.\n\n60 s of processor: nothing.\n"""\n{BURN}\ndef test_c(): pass\n')
    (tmp_path / "pytest.ini").write_text("[pytest]\n")
    words = ["-m", "pytest", "-v", "-p", "xdist", "-n", "1", "--dist", "loadfile", "--no-loadscope-reorder"]
    words += ["-p", "no:cacheprovider", "-m", "not slow"]
    command = [
        sys.executable,
        *words,
        "-p",
        "no:cacheprovider",
        "-m",
        "not slow",
        f"--rootdir={tmp_path}",
        str(tmp_path),
    ]
    run = subprocess.run(
        command, cwd=ROOT, env=os.environ | {"PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}, capture_output=True, text=True
    )
    assert run.returncode == 0, run.stdout
    clock, total = map(int, re.findall(r"tests: (\d+) s, (\d+) s of processor", run.stdout)[0])
    assert total <= clock + 1  # one worker, and a parent that waits: a worker counted twice is more
    assert re.findall(r"PASSED (test_.)\.py", re.sub(r"\S*/", "", run.stdout)) == ["test_c", "test_b", "test_a"]
    costs = {name: float(cost) for cost, name in re.findall(r"([\d.]+) s  \S*(test_.)\.py", run.stdout)}
    assert costs["test_b"] > 0.4 > costs["test_a"] + costs["test_c"]  # what is imported belongs to no test
    assert "test_c.py  <- its docstring says 60 s" in run.stdout
    assert "3 passed" in run.stdout.splitlines()[-1]
