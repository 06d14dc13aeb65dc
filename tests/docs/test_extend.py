"""The examples of CONTRIBUTING.md: each diff of docs/extend applies, touches at most three files, its test passes."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.committed import ROOT

EXAMPLES = sorted((ROOT / "docs" / "extend").glob("*.diff"))
# Of an example whose test is its line in a table of tests, what reads the table; of the part what a build makes of it.
READERS = {
    "limit": ["tests/delta_cad/mechanism/limits", "-k", "elbow_height"],
    "part": [
        "tests/delta_cad/assembly/expected/test_parts.py::test_parts_and_bill_of_materials_are_as_expected",
        "tests/delta_cad/commands/test_built.py::test_the_committed_design_builds_and_all_its_checks_hold",
        "tests/delta_cad/export/drawings/test_built.py::test_every_made_part_has_its_files_and_the_check_holds",
    ],
}


def files(diff: Path) -> list[str]:
    """The files that a diff changes or adds."""
    return re.findall(r"^\+\+\+ b/(.+)$", diff.read_text(encoding="utf-8"), re.MULTILINE)


def git_apply(diff: Path, folder: Path) -> None:
    process = subprocess.run(["git", "apply", "-"], input=diff.read_bytes(), cwd=folder, capture_output=True)
    assert process.returncode == 0, process.stderr.decode()


def test_the_page_links_every_example() -> None:
    page = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert {path.stem for path in EXAMPLES} >= {"check", "command", "law", "limit", "part", "row"}
    assert [path.name for path in EXAMPLES if f"docs/extend/{path.name}" not in page] == []


@pytest.mark.parametrize("diff", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_applies_and_touches_at_most_three_files(diff: Path, tmp_path: Path) -> None:
    changed = files(diff)
    assert 0 < len(changed) <= 3
    for name in changed:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        if (ROOT / name).exists():
            shutil.copy(ROOT / name, tmp_path / name)
    git_apply(diff, tmp_path)
    for name in changed:
        assert (tmp_path / name).read_bytes() != b""


@pytest.mark.slow
@pytest.mark.parametrize("diff", EXAMPLES, ids=lambda path: path.stem)
def test_the_test_of_an_example_passes(diff: Path, tmp_path: Path) -> None:
    for name in ("delta_cad", "optimizer", "haptics", "tests", "docs", "examples", "scripts"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path in ROOT.iterdir():
        if path.is_file():
            shutil.copy(path, tmp_path)
    git_apply(diff, tmp_path)
    tests = [name for name in files(diff) if Path(name).name.startswith("test_")]
    tests = tests or READERS.get(diff.stem, ["tests/delta_cad/catalogue"])
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:xdist", *tests]
    process = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert process.returncode == 0, process.stdout[-3000:]
