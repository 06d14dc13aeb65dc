"""What the tests of `design` share: a task, and machines that are built on paper."""

from __future__ import annotations

from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from tests.optimizer.commands.paper import BRIEF, build_on_paper


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "task.toml"
    path.write_text(BRIEF, encoding="utf-8")
    return path


@pytest.fixture
def paper_build(best_assembly: Assembly, monkeypatch: pytest.MonkeyPatch) -> None:
    build_on_paper(best_assembly, monkeypatch)
