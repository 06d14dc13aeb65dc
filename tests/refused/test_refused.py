"""What readers and commands refuse, as data: the inputs of `*.toml`, each by the field that it names.

What is said of each stands in `*.txt`; after a change of words run `pytest tests/refused --update` and read the diff.
"""

from __future__ import annotations

import csv
import json
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.catalogue import FAMILIES, CatalogueError, own_parts
from delta_cad.catalogue.reader import optional_columns, read_family
from delta_cad.commands.cli import main as delta_cad
from delta_cad.common.refusal import MOST_LINE
from delta_cad.design import Design, DesignError, design_from_dict, design_schema, load_design
from haptics.commands.cli import main as haptics
from tests.committed import BEST
from tests.delta_cad.design.json_schema import violations
from tests.designs import MISSING, Marked, changed
from tests.optimizer.certify.designs import masses

HERE = Path(__file__).parent
DESIGNS, PARTS, COMMANDS = (
    tomllib.loads((HERE / f"{name}.toml").read_text(encoding="utf-8")) for name in ("design", "catalogue", "commands")
)
SPECIAL = {"<missing>": MISSING, "<null>": None, "<no JSON>": Marked("a time")}
Golden = Callable[[Path, list[str]], None]


def design_changes() -> Iterator[tuple[str, Any, str]]:
    """Field to change, value and field that is named, of each change of a design that is refused."""
    for path, value, *named in DESIGNS["changes"]:
        special = SPECIAL.get(value, value) if isinstance(value, str) else value
        yield path, special, named[0] if named else path


def refused(read: Callable[..., object], *arguments: object, about: object) -> DesignError | CatalogueError:
    """What a reader refuses with; in one printable line of bounded length."""
    try:
        read(*arguments)
    except (DesignError, CatalogueError) as error:
        found = error
    else:
        raise AssertionError(f"nothing is refused: {about}")
    assert str(found).isprintable()
    assert len(str(found)) < MOST_LINE
    return found


def test_a_bad_field_of_a_design_is_named(golden: Golden) -> None:
    lines = []
    for path, value, named in design_changes():
        error = refused(design_from_dict, changed(path, value), "best.json", about=(path, value))
        assert isinstance(error, DesignError)
        assert (error.file, error.field) == ("best.json", named), (path, value)
        assert error.allowed
        lines.append(str(error))
    golden(HERE / "design.txt", lines)


def test_the_schema_of_a_design_refuses_what_a_field_alone_is_refused_for() -> None:
    schema, fields = design_schema(), DESIGNS["changes"].index(["name", "x\n"])
    for path, value, _ in list(design_changes())[:fields]:
        if "provenance" not in path and "Infinity" not in json.dumps(value, default=str) and value == value:
            assert violations(schema, changed(path, value), schema), (path, value)


def test_a_bad_design_file_is_refused_by_its_field(tmp_path: Path, golden: Golden) -> None:
    path, lines = tmp_path / "design.json", []
    for text, named in DESIGNS["files"]:
        path.write_text(text, encoding="utf-8")
        error = refused(load_design, path, about=text)
        assert isinstance(error, DesignError)
        assert (error.file, error.field) == ("design.json", named), text
        lines.append(str(error))
    golden(HERE / "design_files.txt", lines)


def cells_of(name: str, changes: dict[str, str], *, own: bool) -> dict[str, str]:
    """The first row of a family with some cells changed, `x1000` meaning a multiple."""
    family = FAMILIES[name]
    row = next(iter(family.rows.values()))
    columns = set(family.columns) - (optional_columns(family.record) if own else set())
    cells = {column: getattr(row, column) for column in family.columns if column in columns or column in changes}
    cells = {key: ";".join(map(str, v)) if isinstance(v, tuple) else "" if v is None else v for key, v in cells.items()}
    for column, text in (({"id": "mine"} if own else {}) | changes).items():
        value = getattr(row, column, None)
        multiple = text.startswith("x") and isinstance(value, int | float)
        cells[column] = type(value)(value * float(text[1:])) if multiple and value is not None else text
    return {column: str(value) for column, value in cells.items()}


@pytest.mark.parametrize("own", [False, True], ids=["project_own", "own"])
def test_a_row_of_the_catalogue_that_cannot_be_true_is_refused_by_its_column(
    own: bool, tmp_path: Path, golden: Golden
) -> None:
    lines = []
    for name, changes, *named in PARTS["own" if own else "ours"]:
        path = tmp_path / f"{name}.csv"
        with path.open("w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, list(cells := cells_of(name, changes, own=own)))
            writer.writeheader()
            writer.writerow(cells)
        text = str(
            refused(own_parts, tmp_path, about=changes)
            if own
            else refused(read_family, path, FAMILIES[name].record, about=changes)
        )
        assert text.startswith(f"{name}.csv"), text
        # a size in another unit shows in the density, too
        unit = any(cell.startswith("x") for cell in changes.values())
        assert all(column in text for column in named or changes) or (unit and "mass_g over" in text), (text, changes)
        lines.append(text)
        path.unlink()
    golden(HERE / f"catalogue_{'own' if own else 'ours'}.txt", lines)


@pytest.mark.parametrize("program", [delta_cad, haptics], ids=["delta_cad", "haptics"])
def test_a_command_refuses_bad_input_in_one_line(
    program: Callable[[list[str]], int],
    request: pytest.FixtureRequest,
    best: Design,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    golden: Golden,
) -> None:
    weights = masses(tmp_path, best, 1e-5)
    here = tmp_path / "here"  # where no best.json stands
    here.mkdir()
    (here / "FILE").write_text("a file")
    monkeypatch.chdir(here)
    name, lines = request.node.callspec.id, []
    for text, named in COMMANDS[name]:
        words = text.replace("DESIGN", str(BEST)).replace("MASSES", str(weights)).split()
        try:
            code = program(words)
        except SystemExit as ended:
            code = ended.code
        reported = capsys.readouterr()
        assert (code, reported.out, reported.err.count("\n")) == (2, "", 1), (text, reported)
        assert named in reported.err, (text, reported)
        assert "Traceback" not in reported.err
        assert [path.name for path in here.iterdir()] == ["FILE"], text
        line = reported.err.replace(str(BEST), "DESIGN").replace(str(weights), "MASSES").rstrip("\n")
        lines.append(f"{text}: {line}")
    golden(HERE / f"commands_{name}.txt", lines)


def test_every_family_that_a_design_chooses_from_has_a_row_that_is_refused() -> None:
    assert {name for name, *_ in PARTS["own"]} >= set(catalogue.CHOSEN) - {"tube"}
