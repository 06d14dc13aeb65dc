"""The list of holes: every bore of a machine where it lies in its part, and what a file of it says."""

from __future__ import annotations

import csv
import re
from collections import Counter
from pathlib import Path

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.export.shop.holes import HoleRow, hole_list, write_holes


@pytest.fixture(scope="module")
def rows(best_assembly: Assembly) -> list[HoleRow]:
    return hole_list(best_assembly)


def only(rows: list[HoleRow], part: str, says: str) -> list[HoleRow]:
    return [row for row in rows if row.part == part and says in row.callout]


def test_every_bore_has_its_row(rows: list[HoleRow], best_assembly: Assembly) -> None:
    made = [part for part in best_assembly.parts if part.make or part.number in ("encoder_board", "crimp_sleeve")]
    bores = Counter(
        {part.number: n for part in made if (n := sum(len(h.bores) or len(h.slots) or 1 for h in part.holes))}
    )
    assert Counter(row.part for row in rows) == bores
    names = [(row.part, row.hole) for row in rows]
    assert all(re.fullmatch(r"#\d+(\.\d+)?", name) for _, name in names)  # a drawing's tags are letters: "B1"
    assert len(set(names)) == len(names)
    assert [row.callout for row in rows if row.x_mm is None] == [
        hole.callout for part in made for hole in part.holes if hole.is_slot and not hole.slots
    ]


def test_threads_fits_and_ends_are_reported(rows: list[HoleRow]) -> None:
    board = only(rows, "encoder_cheek", "encoder board")
    assert {(r.thread, r.thread_depth_mm, r.depth_mm, r.diameter_mm, r.end) for r in board} == {
        ("M2.5", 8.0, 10.0, 2.05, "118")
    }
    (end,) = only(rows, "shoulder_shaft", "clamps")
    assert (end.thread, end.thread_depth_mm, end.depth_mm, end.end) == ("M4", 8.0, 10.5, "118")
    (seat,) = only(rows, "encoder_cheek", "bearing slides")
    assert (seat.fit, seat.lower_um, seat.upper_um, seat.surface_ra_um, seat.end) == ("H6", 0, 11, 0.8, "flat")
    assert seat.direction_y == -1.0
    (shoulder,) = only(rows, "sector", "on the shoulder shaft")
    assert (shoulder.fit, shoulder.lower_um, shoulder.upper_um, shoulder.end) == ("G7", 5, 20, "through")
    dowels = only(rows, "foot_block", "3 H7")
    assert sorted((r.direction_y, r.direction_z, r.depth_mm) for r in dowels) == [
        (-1.0, 0.0, 5.0), (-1.0, 0.0, 5.0), (0.0, 1.0, 6.0), (0.0, 1.0, 6.0), (1.0, 0.0, 5.0), (1.0, 0.0, 5.0),
    ]  # fmt: skip
    slots = [row for row in dowels if "slot" in row.callout]
    assert [(r.direction_y, r.direction_z, r.fit, r.upper_um) for r in slots] == [(0, 1, "H7", 10), (-1, 0, "H7", 10)]
    blind = [row for row in rows if row.thread and row.end != "through"]
    assert blind
    for row in blind:
        assert (row.depth_mm or 0.0) - (row.thread_depth_mm or 0.0) >= 1.6  # DIN 76-1, short, of the finest
        assert row.end == "118"


def test_the_file_reads_back(rows: list[HoleRow], tmp_path: Path) -> None:
    write_holes(rows, tmp_path / "holes.csv")
    with (tmp_path / "holes.csv").open(newline="") as file:
        read = list(csv.DictReader(file))
    assert list(read[0])[:9] == [
        "part", "hole", "x_mm", "y_mm", "z_mm", "direction_x", "direction_y", "direction_z", "diameter_mm",
    ]  # fmt: skip
    assert len(read) == len(rows)
    for text, row in zip(read, rows, strict=True):
        assert text["callout"] == row.callout
        assert (float(text["x_mm"]) if text["x_mm"] else None) == row.x_mm
        assert "-0.0" not in text.values()
