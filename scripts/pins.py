"""Writes what the supply chain is checked by: hashes in constraints.txt, licences in THIRD-PARTY.md, tested versions.

    .venv/bin/python scripts/pins.py            licences and tested versions, from the metadata of what is installed
    .venv/bin/python scripts/pins.py --hashes   constraints.txt first: the hash of each file of each pinned version

To change a version: edit its pin, run with `--hashes`, run `make install`, run again. Each pin names in the line above
it the extras that need it, so that `scripts/install.py` can choose before anything is installed.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
import tomllib
import venv
from collections.abc import Callable, Iterable
from importlib import metadata
from pathlib import Path

from packaging.markers import default_environment
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[1]
CONSTRAINTS, LICENCES = ROOT / "constraints.txt", ROOT / "THIRD-PARTY.md"
TESTED = ROOT / "delta_cad" / "common" / "versions.py"
CORE, BUILD = "core", "build"
HEAD = """\
# Exact versions that were tested together on Python 3.11, with the hashes of their files; made by scripts/pins.py.
# All of them: pip install --require-hashes --no-deps -r constraints.txt
"""
PIN = re.compile(r"^([A-Za-z0-9._-]+)==(\S+)", re.MULTILINE)
FACE = ROOT / "delta_cad" / "export" / "drawings" / "sheet_io" / "faces" / "README.md"
VENDORED = ROOT / "delta_cad" / "report" / "vendor" / "three.json"


def extras() -> dict[str, list[str]]:
    """Reads pyproject.toml.

    Returns:
        Extra -> requirements of its own; `CORE` and `BUILD` for those of the package and of its build.
    """
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = data["project"]
    return {CORE: project["dependencies"], BUILD: data["build-system"]["requires"], **project["optional-dependencies"]}


def pins(text: str) -> dict[str, str]:
    """Reads the pinned versions of a constraints file: canonical name -> version."""
    return {canonicalize_name(name): version for name, version in PIN.findall(text)}


def needed_by(requires: Callable[[str], Iterable[str]] | None = None) -> dict[str, list[str]]:
    """Finds which extras need which packages, directly or through others, on this kind of machine.

    Args:
        requires: Requirements of a package by its name; None reads the metadata of what is installed.

    Returns:
        Canonical name -> extras in pyproject's order.

    Raises:
        importlib.metadata.PackageNotFoundError: A package is needed and not installed.
    """
    requires = requires or (lambda name: metadata.requires(name) or ())
    found: dict[str, list[str]] = {}
    for extra, own in extras().items():
        open_ends, seen = [Requirement(line) for line in own], set[tuple[str, str]]()
        while open_ends:
            one = open_ends.pop()
            name = canonicalize_name(one.name)
            for wanted in ("", *one.extras):
                if (name, wanted) in seen:
                    continue
                seen.add((name, wanted))
                found.setdefault(name, [])
                if extra not in found[name]:
                    found[name].append(extra)
                for line in requires(name):
                    below = Requirement(line)
                    environment = {**default_environment(), "extra": wanted}
                    if below.marker is None or below.marker.evaluate(environment):
                        open_ends.append(below)
    return found


def licence(name: str) -> str:
    """Reads the licence that a package states: its SPDX expression, else its classifiers, else its short text."""
    data = metadata.metadata(name)
    if expression := data.get("License-Expression"):
        return expression
    classified = [line.rsplit(" :: ", 1)[-1] for line in data.get_all("Classifier") or () if "License ::" in line]
    text = " ".join((data.get("License") or "").split())
    named = [line for line in classified if line not in ("OSI Approved", "OSI Approved :: Other")]
    if "Permission is hereby granted, free of charge, to any person" in text:  # its whole text in place of its name
        text = "MIT"
    return " OR ".join(named) or text[:80] or "not stated"


def third_party() -> str:
    """Writes THIRD-PARTY.md from constraints.txt and the metadata of what is installed."""
    versions, users = pins(CONSTRAINTS.read_text(encoding="utf-8")), needed_by()
    vendored = json.loads(VENDORED.read_text(encoding="utf-8"))
    face = re.search(r"`(\S+\.ttf)`, version (\S+?):.*?SHA-256: `(\w+)`", FACE.read_text(encoding="utf-8"), re.DOTALL)
    assert face is not None
    rows = [
        f"| {name} | {version} | {licence(name)} | {', '.join(users.get(name, ())) or 'nothing'} |"
        for name, version in sorted(versions.items())
    ]
    return "\n".join(
        [
            "# Third-party software",
            "",
            "Made by `scripts/pins.py` from the metadata of the pinned versions; `tests/docs/test_pins.py` compares.",
            "The last column names the extras of `pyproject.toml` that install a package, directly or through another:",
            "`core` is always installed, `build` builds the package, users run nothing of `test` and `docs`. A package",
            "may contain libraries under further licences: its own licence files list them.",
            "",
            "Parts of this repository:",
            "",
            f"- `delta_cad/report/vendor/three.js`: {vendored['package']} {vendored['version']}, "
            f"{vendored['license']}, sha256 `{vendored['sha256']}`",
            f"- `delta_cad/export/drawings/sheet_io/faces/{face[1]}`: version {face[2]}, Apache-2.0, "
            f"sha256 `{face[3]}`",
            "",
            "| package | version | licence | needed by |",
            "| --- | --- | --- | --- |",
            *rows,
            "",
        ]
    )


def tested(source: str) -> str:
    """Writes the versions that a start compares with, of all packages that pyproject.toml names for users.

    Args:
        source: Text of `TESTED`.
    """
    versions = pins(CONSTRAINTS.read_text(encoding="utf-8"))
    for_users = {extra: own for extra, own in extras().items() if extra not in (BUILD, "docs", "test")}
    names = sorted({canonicalize_name(Requirement(line).name) for own in for_users.values() for line in own})
    table = "".join(f'    "{name}": "{versions[name]}",\n' for name in names)
    return re.sub(r"^TESTED = \{[^}]*\}", f"TESTED = {{\n{table}}}", source, flags=re.MULTILINE)


def hashed(text: str) -> str:
    """Writes constraints.txt anew: the same pins, their extras, and the hashes that the package index states.

    Args:
        text: Of a constraints file, with hashes or without.

    Raises:
        subprocess.CalledProcessError: A pinned version is not to be had.
    """
    users = needed_by()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        venv.create(place / "venv", with_pip=True)
        subprocess.run([place / "venv/bin/pip", "install", "--quiet", "uv"], check=True)
        bare = "".join(f"{name}=={version}\n" for name, version in sorted(pins(text).items()))
        (place / "pins.in").write_text(bare, encoding="utf-8")
        options = ["--universal", "--generate-hashes", "--no-deps", "--no-header", "--no-annotate"]
        # the oldest Python of the series that all pinned versions take
        command = [place / "venv/bin/uv", "pip", "compile", *options, "--python-version", "3.11.7", place / "pins.in"]
        made = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    return HEAD + PIN.sub(lambda one: f"# {', '.join(users.get(canonicalize_name(one[1]), ()))}\n{one[0]}", made)


def main(words: list[str]) -> int:
    """Writes the files; returns the exit code."""
    if words not in ([], ["--hashes"]):
        print("usage: .venv/bin/python scripts/pins.py [--hashes]", file=sys.stderr)
        return 2
    if words:
        CONSTRAINTS.write_text(hashed(CONSTRAINTS.read_text(encoding="utf-8")), encoding="utf-8")
    LICENCES.write_text(third_party(), encoding="utf-8")
    TESTED.write_text(tested(TESTED.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
