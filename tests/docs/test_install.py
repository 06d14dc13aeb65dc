"""What `make build` says while it installs: at once, every few seconds, and all of it where it fails."""

from __future__ import annotations

import sys
from collections import deque
from pathlib import Path

import pytest

from scripts import install


def test_a_silent_step_gives_signs_of_life(capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[int] = []

    def more(lines: deque[str]) -> str:
        seen.append(len(lines))
        return f"sign {len(seen)}"

    code = "import time\nfor _ in range(3): print('quiet', flush=True); time.sleep(0.2)"
    assert install.run("a step", [sys.executable, "-c", code], more, tell_s=0.05) == 0
    reported = capsys.readouterr()
    lines = reported.out.splitlines()
    assert lines[0] == "    0 s  a step"
    assert len(lines) >= 4
    assert all(": sign " in line for line in lines[1:])
    assert ("quiet" in reported.out, reported.err) == (False, "")


def test_a_step_that_fails_tells_what_it_said(capsys: pytest.CaptureFixture[str]) -> None:
    assert install.run("a step", [sys.executable, "-c", "import sys; print('no room'); sys.exit(3)"]) == 3
    assert capsys.readouterr().err == "no room\na step: failed with exit code 3\n"


def test_how_far_pip_is_is_read_off_its_lines(tmp_path: Path) -> None:
    lines = ["Looking in indexes: x", "Collecting cadquery>=2.8 (from delta-haptics)"]
    assert install.pip_at(lines, tmp_path) == "collecting cadquery>=2.8"
    lines.append("  Downloading https://some.where/a/vtk-9.6.2-cp311.whl (120.1 MB)")
    assert install.pip_at(lines, tmp_path) == "downloading vtk-9.6.2-cp311.whl"
    lines.append("Installing collected packages: vtk, shtab, cadquery")
    (tmp_path / "vtk-9.6.2.dist-info").mkdir()
    assert install.pip_at(lines, tmp_path) == "unpacking 3 packages, 1 are there"
    assert install.pip_at([], tmp_path / "none") == ""


def test_an_installation_gives_signs_every_five_seconds_and_a_log_has_a_line_in_ten() -> None:
    from delta_cad.common import console

    assert install.TELL_S <= 5.0
    source = Path(console.__file__).read_text(encoding="utf-8")
    assert "TELL_S = 10.0" in source  # the tests themselves silence it


@pytest.mark.parametrize("words", [[], ["x"], ["x", "y", "z"]])
def test_wrong_usage_ends_with_2(words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert install.main(words) == 2
    assert capsys.readouterr().err.startswith("usage: ")


def test_the_first_command_installs_less_than_the_second() -> None:
    text = (install.ROOT / "Makefile").read_text(encoding="utf-8")
    assert "scripts/install.py $(VENV) cad,optimize\n" in text
    assert "build: $(BUILDS)\n" in text
    for target in ("install", "tests", "slow", "linted", "lint", "docs"):
        assert f"\n{target}: $(STAMP)\n" in text
