"""`drawings`: its files, its exit codes, and what a build makes of it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.commands.cli import main
from delta_cad.commands.pipeline import check_drawings
from delta_cad.common.files import whole_folder
from delta_cad.design import Design
from delta_cad.export.drawings import write
from delta_cad.export.drawings.write import Drawn
from tests.committed import BEST


@pytest.fixture
def quick(best_assembly: Assembly, monkeypatch: pytest.MonkeyPatch) -> list[Drawn]:
    """The command with a machine that is there already, and drawings that come to what is put into the list."""
    found: list[Drawn] = []

    def written(_d: Any, _a: Any, _m: Any, folder: Path, _p: Any) -> Drawn:
        (folder / "plate.pdf").write_bytes(b"%PDF")
        return found[0]

    monkeypatch.setattr("delta_cad.assembly.assemble.assemble", lambda *_: best_assembly)
    monkeypatch.setattr("delta_cad.export.mass_properties.mass_report", lambda _: {})
    monkeypatch.setattr(write, "write_drawings", written)
    return found


def test_drawings_land_whole_and_a_fault_ends_with_1(
    quick: list[Drawn], best: Design, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / best.name / "drawings"
    quick.append(Drawn(3))
    assert main(["drawings", "--design", str(BEST), "--out", str(tmp_path)]) == 0
    reported = capsys.readouterr()
    assert (reported.out, reported.err) == (f"3 drawings in {folder}\n", "")
    assert [path.name for path in folder.glob("[!.]*")] == ["plate.pdf"]
    quick[0] = Drawn(3, {"plate": ["plane 3 is told 2 times"]})
    assert main(["drawings", "--design", str(BEST), "--out", str(tmp_path), "--json"]) == 1
    record = json.loads(capsys.readouterr().out)
    assert record["faults"] == {"plate": ["plane 3 is told 2 times"]}
    assert (record["passed"], record["drawings"], record["folder"]) == (False, 3, str(folder))
    assert main(["drawings", "--design", str(BEST), "--out", str(tmp_path)]) == 1
    assert "FAILS plate: plane 3 is told 2 times" in capsys.readouterr().out


@pytest.mark.usefixtures("quick")
def test_what_cannot_be_written_leaves_the_old_drawings(
    best: Design,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with whole_folder(tmp_path / best.name / "drawings") as folder:
        (folder / "old.pdf").write_bytes(b"old")

    def full(*_: Any) -> Drawn:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(write, "write_drawings", full)
    assert main(["drawings", "--design", str(BEST), "--out", str(tmp_path)]) == 2
    reported = capsys.readouterr().err
    assert reported.count("\n") == 1
    assert "No space left on device" in reported
    assert [path.name for path in tmp_path.rglob("*.pdf")] == ["old.pdf"]


def test_the_check_of_a_build_names_the_drawing() -> None:
    good, bad = check_drawings(Drawn(20)), check_drawings(Drawn(20, {"sector": ["a", "b"]}))
    assert (good.name, good.passed, good.value) == ("drawings", True, 0.0)
    assert (bad.passed, bad.value, bad.worst_pair, bad.detail) == (False, 2.0, ("sector",), "sector: a; b")
