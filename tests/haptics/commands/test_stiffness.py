"""`python -m haptics stiffness`: table, file, exit codes, one-line refusals."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import haptics.loop.stiffness
from delta_cad.common.console import INTERRUPTED
from haptics.commands.cli import main
from haptics.commands.stiffness import NAME
from haptics.loop.choice import BOARD, DAMPED
from haptics.model.hands import HANDS
from haptics.model.plant import Hand
from tests.committed import BEST, Built
from tests.terminal import interrupted


def call(*arguments: object) -> int:
    try:
        return main([str(argument) for argument in arguments])
    except SystemExit as ended:
        return int(ended.code or 0)


@pytest.fixture(scope="module")
def masses(built: Built) -> Path:
    return built.folder / "mass_properties.json"


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> dict[str, float]:
    """The simulation's place taken by limits of the hands, N/m."""
    limits = {"light": 2000.0, "medium": 4400.0, "firm": 9000.0}

    class Bench:
        def __init__(self, _machine: Any, _axis: str, hand: Hand, *_: Any, **__: Any) -> None:
            self.limit = limits[next(name for name, known in HANDS.items() if known == hand)]

        def stands(self, stiffness: float) -> bool:
            return stiffness <= self.limit

    monkeypatch.setattr(haptics.loop.stiffness, "WallBench", Bench)
    return limits


def test_table_and_file(
    masses: Path, tmp_path: Path, quick: dict[str, float], capsys: pytest.CaptureFixture[str]
) -> None:
    assert quick
    assert call(NAME, "--design", BEST, "--mass-properties", masses, "--out", tmp_path / "new") == 0
    reported = capsys.readouterr()
    assert "largest stable wall in the paper loop, N/mm" in reported.out
    assert reported.err == ""
    (file,) = (tmp_path / "new").iterdir()
    assert file.name == "synthesized-stiffness.json"
    facts = json.loads(file.read_text())
    assert facts["axes"]["x"]["simulated_N_per_mm"]["protocol"] == pytest.approx(4.3)
    assert facts["default_wall_oscillates_with"] == []
    board, damped = facts["loops"]  # without and with drives that damp, each with its condition
    assert (board["loop"], damped["loop"]) == (BOARD.label, DAMPED.label)
    assert board["axes"]["x"]["own_N_per_mm"] < 0.1 < 5.0 < damped["axes"]["x"]["own_N_per_mm"]
    assert min(one["axes"][axis]["worst_N_per_mm"] for one in (board, damped) for axis in "xyz") > 5.0
    assert call(NAME, "--design", BEST, "--mass-properties", masses, "--out", tmp_path / "new", "--json") == 0
    assert json.loads(capsys.readouterr().out) == facts


def test_a_default_wall_that_oscillates_is_exit_1_and_says_with_whom(
    masses: Path, tmp_path: Path, quick: dict[str, float], capsys: pytest.CaptureFixture[str]
) -> None:
    quick["light"] = 900.0
    assert call(NAME, "--design", BEST, "--mass-properties", masses, "--out", tmp_path, "--json") == 1
    reported = capsys.readouterr()
    assert reported.err.count("light") == 3
    shaken = json.loads(reported.out)["default_wall_oscillates_with"]
    assert shaken == [{"axis": axis, "hand": "light"} for axis in "xyz"]


def test_options_reach_the_search(
    masses: Path, tmp_path: Path, quick: dict[str, float], capsys: pytest.CaptureFixture[str]
) -> None:
    assert quick
    more = ["--period", 0.5, "--delay", 0.25, "--damping", 7, "--json", "--out", tmp_path]
    assert call(NAME, "--design", BEST, "--mass-properties", masses, *more) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["period_ms"] == 0.5
    assert facts["delay_ms"] == [0.25, 0.25, 0.25]
    assert facts["damping_applied_N_s_per_m"] == 7.0
    more = ["--rate", 4000, "--damping", 1, "--drive-damping", 0.3, "--json", "--out", tmp_path]
    assert call(NAME, "--design", BEST, "--mass-properties", masses, *more) == 0
    chosen, other = json.loads(capsys.readouterr().out)["loops"]
    assert (chosen["rate_Hz"], other["rate_Hz"]) == (4000.0, 4000.0)
    assert chosen["wall_damping_N_s_per_m"] == 1.0
    assert chosen["drive_damping_at_a_wall_share_of_short_circuit"] == 0.3
    assert other["drive_damping_at_a_wall_share_of_short_circuit"] == 0.0


def test_what_the_search_refuses_is_exit_2(
    masses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(*_: Any, **__: Any) -> None:
        raise ValueError("a point of the cube cannot be reached")

    monkeypatch.setattr(haptics.loop.stiffness, "largest_walls", refused)
    assert call(NAME, "--design", BEST, "--mass-properties", masses, "--out", tmp_path / "new") == 2
    assert capsys.readouterr().err.startswith(f"{BEST}: ")
    assert not (tmp_path / "new").exists()


def test_help_is_light() -> None:
    code = "import sys\nfrom haptics.commands.cli import main\n"
    code += "try: main(['stiffness', '--help'])\nexcept SystemExit: pass\n"
    code += "print({'numpy', 'numba', 'scipy'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.rstrip().endswith("set()")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "after_s"),
    [(["stiffness"], 0.5), (["feel"], 2.0), (["simulate", "--scene", "wall"], 1.5), (["firmware"], 0.0)],
    ids=lambda words: words[0] if isinstance(words, list) else "",
)
def test_ctrl_c_at_any_moment_is_one_line_and_leaves_nothing(
    words: list[str], after_s: float, tmp_path: Path, masses: Path
) -> None:
    out = tmp_path / "out"
    command = [sys.executable, "-m", "haptics", *words, "--design", str(BEST), "--mass-properties", str(masses)]
    ended = interrupted([*command, "--out", str(out)], after_s)
    assert (ended.code, ended.said) == (INTERRUPTED, "interrupted; nothing was written\n")
    assert not out.exists() or list(out.iterdir()) == []
