"""Any text in any field or column that a person writes: read and shown in one line, or refused in one."""

from __future__ import annotations

import csv
import json
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.catalogue import CHOSEN, CatalogueError
from delta_cad.catalogue.reader import columns_of, read_family
from delta_cad.catalogue.row import MOST_LETTERS
from delta_cad.common.refusal import MOST_LINE, visible
from delta_cad.design import DesignError, design_from_dict, design_hash, design_to_dict, design_to_json, load_design
from optimizer.problem.brief import brief_from_dict, load_brief
from optimizer.problem.validation import RequirementsError
from tests.committed import BEST, ROOT

ISSUED = [
    "球形 \U0001f600 \u202e",
    "=1+1",
    "a\x00b\x1b[2J",
    "\ud7ff\ue000\ufeff",
    "x" * 100_000,
    "a b " * 50_000,
    "",
    "\n\r\t",
]
ANY = st.one_of(st.sampled_from(ISSUED), st.text(max_size=40))
FREE = {"description", "order_code", "maker", "source"}  # columns that say nothing to this program
SOME = settings(max_examples=15, deadline=None)
COLUMNS = [
    (name, column)
    for name, family in CHOSEN.items()
    for column, field in columns_of(family.record).items()
    if field.annotation is str
]


def refusal(read: Callable[[], Any], file: str) -> str | None:
    """What a reader refuses with, in one line that begins with the file; None where it takes what it gets."""
    try:
        read()
    except (CatalogueError, DesignError, RequirementsError) as error:
        lines = getattr(error, "lines", (str(error),))
    else:
        return None
    assert all(line.startswith(file) and line.isprintable() and len(line) <= MOST_LINE for line in lines)
    return lines[0]


@pytest.mark.parametrize(("name", "column"), COLUMNS)
def test_a_column_of_own_parts_is_read_in_one_line_or_refused_in_one(name: str, column: str) -> None:
    family = CHOSEN[name]
    row = asdict(next(iter(family.rows.values())))
    own = {key: "" if value is None else _cell(value) for key, value in row.items()}

    @SOME
    @given(ANY)
    def check(text: str) -> None:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f"{name}.csv"
            with path.open("w", encoding="utf-8", newline="") as file:
                writer = csv.DictWriter(file, list(own))
                writer.writeheader()
                writer.writerow(own | {"id": "own", column: text})
            if refusal(lambda: read_family(path, family.record, own=True), path.name):
                assert column not in FREE or len(visible(text)) > MOST_LETTERS
                return
            (row,) = read_family(path, family.record, own=True).values()
        shown = getattr(row, column)
        assert shown.isprintable()
        assert len(shown) <= MOST_LETTERS
        if text.strip():
            assert shown == visible(text)

    check()


def _cell(value: Any) -> str:
    return ";".join(map(str, value)) if isinstance(value, tuple) else str(value)


def strings(data: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where plain data holds text."""
    for key, value in data.items() if isinstance(data, dict) else enumerate(data):
        if isinstance(value, str):
            yield (*at, key)
        elif isinstance(value, dict | list):
            yield from strings(value, (*at, key))


def replaced(data: Any, at: tuple[Any, ...], value: Any) -> Any:
    """Plain data with another value at a place."""
    copy = json.loads(json.dumps(data))
    inside = copy
    for key in at[:-1]:
        inside = inside[key]
    inside[at[-1]] = value
    return copy


DESIGN = design_to_dict(load_design(BEST)) | {"provenance": {"note": "a", "list": ["b", {"c": "d"}]}}


@pytest.mark.parametrize("at", [*strings(DESIGN), ("hardware", "catalogue")], ids=str)
def test_a_text_of_a_design_is_taken_as_it_is_or_refused_in_one_line(at: tuple[Any, ...]) -> None:
    @SOME
    @given(ANY)
    def check(text: str) -> None:
        if refusal(lambda: design_from_dict(replaced(DESIGN, at, text), "d.json"), "d.json: "):
            assert "provenance" not in at
            return
        design = design_from_dict(replaced(DESIGN, at, text), "d.json")
        assert design_from_dict(json.loads(design_to_json(design))) == design
        assert len(design_hash(design)) == 64

    check()


BRIEF = {
    "name": "a",
    "requirements": {"envelope_width_mm": "270 mm", "envelope_depth_mm": 220, "force_N": 3},
    "feel": {"kappa_max": 2.27},
    "hardware": {"motor": ["maxon-re30-310007"], "drive": ["capstan"]},
    "goal": {"maximize": "cube_side"},
}


@pytest.mark.parametrize("at", list(strings(BRIEF)), ids=str)
def test_a_text_of_requirements_is_taken_or_refused_in_one_line_each(at: tuple[Any, ...]) -> None:
    @SOME
    @given(ANY)
    def check(text: str) -> None:
        refusal(lambda: brief_from_dict(replaced(BRIEF, at, text), "r.toml"), "r.toml: ")

    check()


def test_a_brief_that_no_text_spoils_is_one() -> None:
    assert load_brief(ROOT / "joystick.toml").name == "dashboard-joystick"
    assert brief_from_dict(BRIEF, "r.toml").name == "a"


@pytest.mark.parametrize("key", ["x" * 100_000, "a b " * 25_000, "\u202e\x1b[2J"])
def test_a_key_that_is_not_known_is_refused_in_one_line(key: str) -> None:
    assert refusal(lambda: design_from_dict(DESIGN | {key: key}, "d.json"), "d.json: ")
