"""What the tests of `design` share: a task, and machines that are built on paper."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from delta_cad.common import worker_process
from tests.optimizer.commands.paper import BRIEF, Idle, build_on_paper


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A task; nothing is compiled for its proofs in another process meanwhile, which takes a second of a processor."""
    monkeypatch.setattr(worker_process, "WorkerProcess", Idle)
    path = tmp_path / "task.toml"
    path.write_text(BRIEF, encoding="utf-8")
    return path


@pytest.fixture
def paper_build(best_masses: dict[str, Any], monkeypatch: pytest.MonkeyPatch) -> None:
    build_on_paper(best_masses, monkeypatch)
    monkeypatch.setattr("optimizer.codesign.run.direct_alternative", lambda *_: "")  # has a test of its own
