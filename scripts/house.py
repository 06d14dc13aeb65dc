"""Prints how large the house is: lines, public names and modules that only one other imports. A report, not a gate.

python3 scripts/house.py [FOLDER]     of the checkout in FOLDER; default: of the current folder
"""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("delta_cad", "optimizer", "haptics")
SOURCES = {".py", ".c", ".h", ".cpp", ".hpp", ".j2"}


def lines(folder: Path) -> int:
    """Counts the lines of the Python and C sources below a folder."""
    files = (path for path in folder.rglob("*") if path.suffix in SOURCES and path.is_file())
    return sum(path.read_bytes().count(b"\n") for path in files)


def public_names(tree: ast.Module) -> tuple[list[str], list[str]]:
    """Lists functions, classes and constants of a module whose name has no leading underscore.

    Returns:
        Those that have a statement of their own, and those that share one as `A, B = 1, 2`.
    """
    own, shared = list[str](), list[str]()
    for node in tree.body:
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            own.append(node.name)
        elif isinstance(node, ast.Assign | ast.AnnAssign):
            for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
                names = [name.id for name in ast.walk(target) if isinstance(name, ast.Name)]
                (own if isinstance(target, ast.Name) else shared).extend(names)
    return [name for name in own if name[0] != "_"], [name for name in shared if name[0] != "_"]


def imports(tree: ast.Module, known: set[str]) -> Iterator[str]:
    """Gives the modules among the known that a module imports anywhere, in its functions too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom):
            inner = (f"{node.module}.{alias.name}" for alias in node.names)
            yield from {name if name in known else str(node.module) for name in inner} & known


def report(root: Path) -> dict[str, int]:
    """Measures a checkout.

    Args:
        root: Its folder.

    Returns:
        Quantity -> value.
    """
    files = {
        ".".join(path.relative_to(root).with_suffix("").parts): path
        for package in PACKAGES
        for path in sorted((root / package).rglob("*.py"))
    }
    trees = {name: ast.parse(path.read_text(encoding="utf-8")) for name, path in files.items()}
    rooms = {name for name in trees if not name.endswith(("__init__", "__main__"))}
    importers = Counter(used for tree in trees.values() for used in set(imports(tree, rooms)))
    names = [public_names(tree) for tree in trees.values()]
    return {
        **{f"lines of {name}": lines(root / name) for name in (*PACKAGES, "tests")},
        "public names": sum(len(own) for own, _ in names),
        "public names that share a statement": sum(len(shared) for _, shared in names),
        "modules": len(rooms),
        "modules that one module imports": sum(count == 1 for count in importers.values()),
    }


def main(words: list[str]) -> int:
    """Prints the table; returns the exit code."""
    for name, value in report(Path(words[0] if words else ".")).items():
        print(f"{name:36} {value:7,}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
