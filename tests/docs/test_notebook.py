"""The notebook runs from its first cell to its last, and is committed without what it printed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from tests.committed import COMMITTED, ROOT, Built
from tests.docs.pages import checkout

NOTEBOOK = ROOT / "examples" / "one_design.ipynb"
LONGEST_S = 600  # of one cell, on a machine however busy


@pytest.fixture
def notebook() -> Any:
    return nbformat.read(NOTEBOOK, as_version=4)


def executed(notebook: Any, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """First name of a cell's code -> what it printed."""
    monkeypatch.setenv("PYTHONPATH", str(ROOT), prepend=":")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    NotebookClient(notebook, timeout=LONGEST_S, resources={"metadata": {"path": str(folder)}}).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    return {
        f"cell {k}": "".join(out.get("text", "") for out in cell.outputs if out.output_type == "stream")
        for k, cell in enumerate(cells)
    }


def light(notebook: Any) -> Any:
    notebook.cells = [cell for cell in notebook.cells if "slow" not in cell.metadata.get("tags", [])]
    return notebook


def test_it_is_committed_without_results(notebook: Any) -> None:
    nbformat.validate(notebook)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(code) == 5
    assert all(cell.outputs == [] and cell.execution_count is None for cell in code)


@pytest.mark.filterwarnings("ignore")  # of the kernel's libraries, which are not ours
def test_it_inspects_proves_and_renders_a_wall(
    notebook: Any, committed: Built, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkout(tmp_path, committed.folder)
    reported = executed(light(notebook), tmp_path, monkeypatch)
    side = 2 * json.loads(COMMITTED.read_text())["cube"]["half_side_mm"]
    assert f"cube side 2 L              {side:.5g} mm" in reported["cell 0"]
    assert "kappa proved" in reported["cell 2"]
    assert "kappa refuted (" in reported["cell 2"]
    depth = float(reported["cell 3"].split()[0])
    (friction,) = (check["value"] for check in committed.record["checks"] if check["name"] == "friction")
    assert (2.0 - friction) / 2.0 < depth < 2.0 / 2.0  # mm: push over stiffness, less what the joints' friction bears


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_its_last_cell_makes_the_solids(
    notebook: Any, committed: Built, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkout(tmp_path, committed.folder)
    assert executed(notebook, tmp_path, monkeypatch)["cell 4"].endswith("failed: []\n")
