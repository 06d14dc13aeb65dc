"""What a shop asks: each file and field that the page names is in the build, and says what the page says."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path
from typing import Any

import pypdfium2
import pytest

from delta_cad.commands.cli import main
from delta_cad.design import load_design
from tests.committed import COMMITTED, ROOT, Built
from tests.delta_cad.export.drawings.reading import svg_symbols

PAGE = ROOT / "docs" / "how-to" / "shop.md"
ROW = re.compile(r"^\| (?P<question>[^|]+) \| `(?P<file>[^`]+)` \| `(?P<told>[^`]+)` \|$")
LEAST = 50


def rows() -> list[tuple[str, str, str]]:
    """Question, file and what stands there, of each row of the page's tables."""
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")]
    lines = [line for line in lines if not line.startswith("| question |")]
    found = [ROW.match(line) for line in lines]
    assert all(found), [line for line, match in zip(lines, found, strict=True) if match is None]
    return [(match["question"], match["file"], match["told"]) for match in found if match is not None]


def keys(value: Any) -> set[str]:
    """All keys and texts of a JSON value."""
    if isinstance(value, dict):
        return set(value) | {key for one in value.values() for key in keys(one)}
    if isinstance(value, list):
        return {key for one in value for key in keys(one)}
    return {value} if isinstance(value, str) else set()


def says(path: Path, wording: str) -> bool:
    """Whether a file says something, read as its kind is."""
    if path.suffix == ".pdf":
        with pypdfium2.PdfDocument(path) as read:
            words = " ".join(" ".join(page.get_textpage().get_text_range() for page in read).split())
        return wording in words
    if path.suffix == ".svg":
        return wording in svg_symbols(path)
    if path.suffix == ".csv":
        with path.open(encoding="utf-8", newline="") as file:
            table = list(csv.DictReader(file))
        return any(row.get(wording) for row in table)
    if path.suffix == ".json":
        return wording in keys(json.loads(path.read_text(encoding="utf-8")))
    return wording in path.read_text(encoding="utf-8")


def missing(folder: Path) -> list[tuple[str, str]]:
    """Answers of the page that a build has not where the page says."""
    return [(file, wording) for _, file, wording in rows() if not says(folder / file, wording)]


def test_each_question_is_there_once() -> None:
    questions = [question for question, _, _ in rows()]
    assert len(set(questions)) == len(questions) >= LEAST


def test_each_answer_stands_where_the_page_says(built: Built) -> None:
    assert missing(built.folder) == []


@pytest.mark.slow
def test_the_machine_that_the_page_names_has_each_answer_and_drawings_without_a_fault(tmp_path: Path) -> None:
    assert main(["build", "--design", str(COMMITTED), "--out", str(tmp_path), "--no-report"]) == 0
    assert missing(tmp_path / load_design(COMMITTED).name) == []


@pytest.mark.parametrize(
    ("file", "wording"),
    [
        ("drawings/pinion.pdf", "right-hand helical groove"),
        ("drawings/motor_cheek.svg", "position Ø0.04 A B C"),
        ("holes.csv", "colour"),
        ("checks.json", "dfm colours"),
        ("parts/pinion.step", "POSITION_TOLERANCE"),
    ],
)
def test_what_does_not_stand_there_is_noticed(built: Built, file: str, wording: str) -> None:
    assert not says(built.folder / file, wording)
