"""The house's own rules: no circles between modules, files that can be overlooked, pages that name what is there."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.committed import ROOT

PACKAGES = ("delta_cad", "optimizer", "haptics")
MOST_ENTRIES, MOST_LINES = 14, 600
DOORS = {"__init__.py", "__main__.py"}  # of a folder, no rooms of it
MADE = ("out/",)  # what commands write stands in no checkout
SKIPPED = {".venv", "out", "build", "node_modules"}


def modules(package: str) -> dict[str, Path]:
    """Dotted name -> file of every module of a package."""
    files = (path.relative_to(ROOT) for path in (ROOT / package).rglob("*.py"))
    return {".".join(path.with_suffix("").parts).removesuffix(".__init__"): path for path in files}


def imported(path: Path, known: dict[str, Path]) -> set[str]:
    """Modules among the known that a file imports outside its functions, those for type checkers included."""
    found: set[str] = set()
    work: list[ast.AST] = [ast.parse((ROOT / path).read_text(encoding="utf-8"))]
    while work:
        node = work.pop()
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda):
            continue
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports by its full name"
            # `from a import b` needs the module a.b where there is one, else a
            inner = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in known else str(node.module) for name in inner}
        work.extend(ast.iter_child_nodes(node))
    return found & known.keys()


def circle(graph: dict[str, set[str]]) -> list[str]:
    """One circle of a graph, or nothing."""
    done: set[str] = set()
    for start in graph:
        trail: list[str] = []
        stack = [(start, iter(sorted(graph[start])))]
        while stack:
            node, rest = stack[-1]
            if node not in trail:
                trail.append(node)
            below = next((name for name in rest if name not in done), None)
            if below is None:
                done.add(node)
                trail.pop()
                stack.pop()
            elif below in trail:
                return [*trail[trail.index(below) :], below]
            else:
                stack.append((below, iter(sorted(graph[below]))))
    return []


def test_a_circle_is_found() -> None:
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}) == ["b", "c", "b"]
    assert circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}) == []
    assert circle({"a": {"a"}}) == ["a", "a"]


@pytest.mark.parametrize("package", PACKAGES)
def test_no_modules_import_each_other_in_a_circle(package: str) -> None:
    known = modules(package)
    assert len(known) > 20
    assert " -> ".join(circle({name: imported(path, known) for name, path in known.items()})) == ""


@pytest.mark.parametrize("top", [*PACKAGES, "tests"])
def test_folders_and_files_can_be_overlooked(top: str) -> None:
    files = [path for path in (ROOT / top).rglob("*") if path.is_file() and path.parent.name != "__pycache__"]
    entries: dict[Path, set[str]] = {}
    for path in files:
        for folder in (path.parent, *path.parent.parents):
            if folder.is_relative_to(ROOT / top):
                entries.setdefault(folder, set()).add(path.relative_to(folder).parts[0])
    entries = {folder: names - DOORS for folder, names in entries.items()}
    crowded = {str(folder.relative_to(ROOT)): len(one) for folder, one in entries.items() if len(one) > MOST_ENTRIES}
    long = {
        str(path.relative_to(ROOT)): count
        for path in (ROOT / top).rglob("*.py")
        if (count := len(path.read_text(encoding="utf-8").splitlines())) > MOST_LINES
    }
    assert (crowded, long) == ({}, {})


def pages() -> list[Path]:
    """Every Markdown page of the checkout, hidden folders and what commands write left out."""
    found = (path.relative_to(ROOT) for path in ROOT.rglob("*.md"))
    return sorted(path for path in found if not any(part in SKIPPED or part.startswith(".") for part in path.parts))


def named_paths(text: str) -> Iterator[str]:
    """What a page has in backquotes that looks like a path of the project: with a slash, a folder or a source file."""
    for name in re.findall(r"`([\w.*-]+/[\w./*-]*)`", text):
        known = name.endswith("/") or name.split("/")[0] in {path.name for path in ROOT.iterdir()}
        source = Path(name).suffix in (".py", ".md", ".csv", ".toml", ".json", ".sh", ".c", ".h")
        if (known or source) and not name.startswith(MADE):
            yield name


def test_what_looks_like_a_path_is_seen() -> None:
    text = "`delta_cad/masses.py`, `solids/`, `delta-design/1`, `mass_properties.json`, `out/bench.md`, `a/b.csv`"
    assert list(named_paths(text)) == ["delta_cad/masses.py", "solids/", "a/b.csv"]


def test_paths_that_pages_name_are_there() -> None:
    assert len(pages()) >= 7
    missing = []
    for page in pages():
        homes = [ROOT, ROOT / page.parent, *(ROOT / package for package in PACKAGES)]
        for name in named_paths((ROOT / page).read_text(encoding="utf-8")):
            if not any(any(home.glob(name)) for home in homes):
                missing.append(f"{page}: {name}")
    assert missing == []


RETIRED = "## Retired words"


def retired_words() -> set[str]:
    """The left column of the last table of docs/glossary.md."""
    table = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8").split(RETIRED)[1]
    rows = re.findall(r"^\| ([a-z, ]+) \| .+ \|$", table, re.MULTILINE)[1:]
    return {word for row in rows for word in row.split(", ")}


def named(tree: ast.AST) -> Iterator[str]:
    """The names that a module gives: functions, classes, parameters, variables, fields."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            yield node.name
        elif isinstance(node, ast.arg):
            yield node.arg
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id


def words(name: str) -> set[str]:
    """The words of an identifier in snake or camel case."""
    return set(re.sub(r"([a-z])([A-Z])", r"\1_\2", name).lower().split("_"))


def test_no_new_name_has_a_retired_word() -> None:
    retired = retired_words()
    assert {"told", "asked", "beside"} <= retired
    assert words("isTold_here") & retired == {"told"}
    found = {
        name
        for top in (*PACKAGES, "tests")
        for path in (ROOT / top).rglob("*.py")
        for name in (path.stem, *named(ast.parse(path.read_text(encoding="utf-8"))))
        if words(name) & retired
    }
    assert sorted(found) == []
