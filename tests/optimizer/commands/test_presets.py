"""Every preset that `init` writes is a machine that `design` builds, as a newcomer types it.

1300 s of processor: five searches, each to its end.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from optimizer.commands.init import PRESETS

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("preset", PRESETS)
def test_a_preset_is_built_and_passes_every_check(preset: str, tmp_path: Path) -> None:
    def run(*words: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "optimizer", *words]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert run("init", preset).returncode == 0
    ended = run("design", f"{preset}.toml", "--minutes", "30")
    assert ended.returncode == 0, ended.stdout[-2000:]
    assert ended.stdout.startswith("built: ")
    assert (tmp_path / "out" / preset / "report.html").is_file()
