"""What a refusal says: one printable line, however long or strange the file's keys and values."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path

import pytest

from delta_cad.common.refusal import (
    LONGEST,
    MOST_LINE,
    RefusedError,
    as_cell,
    not_finite,
    not_installed,
    printable,
    short,
)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("one  line\nof \t two\u2028and three", "one line of two and three"),
        ("\x1b[31mred\x07", r"\x1b[31mred\x07"),
        ("a\u202eb\u200bc\x9bd", r"a\u202eb\u200bc\x9bd"),
        ("\ud800 \udcff", r"\ud800 \udcff"),
        ("\U000e0041 'it's' \\ ü µ", r"\U000e0041 'it's' " + "\\ ü µ"),
        ("", ""),
    ],
)
def test_text_of_anybody_is_one_printable_line(text: str, shown: str) -> None:
    assert printable(text) == shown


@pytest.mark.parametrize("long", ["x" * 100_000, "a b " * 25_000, "\x1b" * 100_000, "漢" * 4001])
def test_a_message_has_a_bounded_length_and_keeps_its_ends(long: str) -> None:
    line = printable(f"d.json: name = {long}: must be short")
    assert line.startswith("d.json: name = ")
    assert line.endswith("must be short")
    assert LONGEST <= len(line) <= MOST_LINE
    assert all(len(word) <= LONGEST for word in line.split())
    for most in (LONGEST, MOST_LINE):
        word = ("ab " * most)[:most].strip()
        assert printable(word) == word


@pytest.mark.parametrize("text", ["=1", "+1", "-1", "@a", "\t=1", "\r=1"])
def test_a_cell_that_a_spreadsheet_would_compute_is_text(text: str) -> None:
    assert as_cell(text) == f"'{text}"
    assert [as_cell(value) for value in ("a=1", "", -1.5, None)] == ["a=1", "", -1.5, None]


def test_a_refusal_names_file_field_value_and_what_is_allowed() -> None:
    assert str(RefusedError("a.json", "b.c", "3", "must be 4")) == "a.json: b.c = 3: must be 4"
    assert str(RefusedError("a.json", "", "", "is missing")) == "a.json: is missing"
    assert str(RefusedError("\x1b.json", "\x07", "3", "\u202e")) == r"\x1b.json: \x07 = 3: \u202e"
    strange = RefusedError("a.json", "x" * 1_000_000, short("y" * 1_000_000), "must be 4")
    assert len(str(strange)) < 300


def test_a_value_is_reported_in_short() -> None:
    assert short([1.5, None]) == "[1.5, null]"
    assert len(short("a" * 100)) == 60
    assert short(16**5000) == "too long to tell"
    nested: list[object] = []
    for _ in range(100_000):
        nested = [nested]
    assert short(nested) == "too long to tell"


def test_the_first_number_that_is_not_finite_is_named() -> None:
    assert not_finite({"a": [1.0, 2, "inf", None]}) is None
    assert not_finite(-math.inf) == ("", -math.inf)
    assert not_finite({"a": {"b": [0.0, (1.0, math.inf)]}, "c": math.nan}) == ("a.b[1][1]", math.inf)
    assert not_finite({"a": [2**63, 10**400]}) == ("a[1]", 10**400)
    assert not_finite({"long" * 500_000: [0.0] * 500_000}) is None  # a path for each would be a terabyte


ROOT = Path(__file__).parents[3]
INSTALLS = re.compile(r"""pip install\s+['"]?(?![.'"])""")


def test_no_index_is_advised_which_could_serve_a_stranger_s_package() -> None:
    """Every `pip install` that a user reads starts from the checkout; its extra is one that this project has."""
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    files = [p for name in ("delta_cad", "optimizer", "haptics", "docs") for p in (ROOT / name).rglob("*.[pm][yd]")]
    assert len(files) > 200
    for path in [*files, ROOT / "README.md", ROOT / "CONTRIBUTING.md"]:
        text = path.read_text(encoding="utf-8").replace("'.[{extra}]'", "'.[cad]'")
        assert not INSTALLS.findall(text), path
        for given in re.findall(r"not_installed\([^()]*(?:\([^()]*\))*[^()]*, \"([a-z,]+)\"\)", text):
            assert set(given.split(",")) <= set(extras), path
    assert "'.[cad]'" in not_installed("cadquery", "cad")
