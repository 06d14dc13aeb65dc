"""The supply chain: each pin has hashes, each package its licence, and what a start compares with is what is pinned."""

from __future__ import annotations

import hashlib
import json
import re
import sys
from pathlib import Path

import pytest

from delta_cad.common import versions
from scripts import install, pins

TEXT = pins.CONSTRAINTS.read_text(encoding="utf-8")


def test_each_pin_has_a_hash_and_names_the_extras_that_need_it() -> None:
    users = pins.needed_by()
    blocks = install.BLOCK.findall(TEXT)
    assert len(blocks) == len(pins.pins(TEXT)) > 150
    for extras, pin in blocks:
        (name,) = pins.pins(pin)
        assert extras.split(", ") == users[name], name
        assert re.fullmatch(r"[^\n]*==\S+( \\\n    --hash=sha256:[0-9a-f]{64})+\n", pin), name
    assert set(users) == set(pins.pins(TEXT))  # nothing that an extra needs is unpinned


def test_an_extra_installs_what_it_needs_and_no_more() -> None:
    chosen = pins.pins(install.needed(TEXT, ["cad", "optimize"]))
    assert {"numpy", "shtab", "cadquery", "pymoo", "setuptools"} <= set(chosen)
    assert not {"gmsh", "sphinx", "mujoco", "viser"} & set(chosen)
    everything = re.search(r"^EVERYTHING := (\S+)", (pins.ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    assert everything is not None
    assert pins.pins(install.needed(TEXT, everything[1].split(","))) == pins.pins(TEXT)


def test_an_unknown_extra_is_refused_and_nothing_made(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert install.main([str(tmp_path / "venv"), "cad,cats"]) == 2
    assert "cats" in capsys.readouterr().err
    assert not (tmp_path / "venv").exists()


def test_licences_and_tested_versions_are_those_of_the_pinned_packages() -> None:
    assert pins.LICENCES.read_text(encoding="utf-8") == pins.third_party()
    source = pins.TESTED.read_text(encoding="utf-8")
    assert source == pins.tested(source)
    assert "not stated" not in pins.third_party()
    from delta_cad.common.numba_code import SERIES

    assert f"{versions.TESTED['numba']}.".startswith(SERIES)


def test_the_library_of_the_report_is_the_one_whose_hash_is_stated() -> None:
    stated = json.loads(pins.VENDORED.read_text(encoding="utf-8"))
    assert hashlib.sha256(pins.VENDORED.with_name("three.js").read_bytes()).hexdigest() == stated["sha256"]


@pytest.mark.parametrize(
    ("folder", "named"),
    [
        ("numba-0.70.0.dist-info", "numba 0.70.0"),
        ("python_fcl-0.8.dist-info", "python-fcl 0.8"),
        ("numba-{}.9.dist-info", ""),  # a correction of the tested series
        ("unheard_of-1.0.dist-info", ""),
    ],
)
def test_a_version_outside_the_tested_ones_is_named_in_one_line(
    folder: str, named: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / folder.format(".".join(versions.series(versions.TESTED["numba"])))).mkdir()
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    found = versions.difference()
    assert (named in found, bool(found), "\n" in found) == (True, bool(named), False)


def test_a_command_says_so_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from delta_cad.commands.cli import main

    (tmp_path / "numpy-9.0.0.dist-info").mkdir()
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    assert main(["schema"]) == 0
    printed = capsys.readouterr()
    assert "numpy 9.0.0" in printed.err
    assert printed.out
