"""The gallery's page is what its figures say, and these are of the designs that are committed."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import design_hash, load_design
from scripts import gallery
from tests.committed import ROOT, Built

MACHINES: list[dict[str, Any]] = json.loads((gallery.PLACE / "figures.json").read_text(encoding="utf-8"))


def test_the_page_is_written_from_the_figures() -> None:
    assert (gallery.PLACE / "figures.md").read_text(encoding="utf-8") == gallery.page(MACHINES)


@pytest.mark.parametrize("design", gallery.DESIGNS, ids=lambda path: path.stem)
def test_figures_and_picture_are_of_the_design_that_stands_there(design: Path) -> None:
    (one,) = (one for one in MACHINES if ROOT / one["file"] == design)
    loaded = load_design(design)
    assert one["input_sha256"] == design_hash(loaded)
    assert (one["name"], one["cube_side_mm"]) == (loaded.name, 2.0 * loaded.cube.half_side_mm)
    picture = gallery.PLACE / f"{loaded.name}.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert picture.stat().st_size < 150_000


def test_the_picture_that_moves_is_small_and_goes_along_every_edge() -> None:
    from PIL import Image

    file = gallery.PLACE / f"{MACHINES[0]['name']}.webp"
    assert file.stat().st_size < 600_000
    with Image.open(file) as picture:
        assert (picture.format, picture.size, picture.n_frames) == ("WEBP", gallery.MOVING, 8 * gallery.STEPS)  # pyright: ignore[reportAttributeAccessIssue]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert readme.index(f"](docs/gallery/{file.name})") < readme.index("```")  # no block of code before it


def test_the_committed_machine_has_the_figures_of_its_build(committed: Built) -> None:
    """But for its clearance, which takes a whole build: `make slow` has that of all five."""
    wording = {key: value for key, value in MACHINES[0].items() if key != "clearance_mm"}
    assert_same(gallery.figures(ROOT / "best.json", committed.folder), wording)


@pytest.mark.slow
@pytest.mark.parametrize("design", gallery.DESIGNS, ids=lambda path: path.stem)
def test_each_machine_is_built_by_its_command_and_has_these_figures(design: Path, tmp_path: Path) -> None:
    folder = gallery.built(design, tmp_path)
    (one,) = (one for one in MACHINES if ROOT / one["file"] == design)
    assert_same(gallery.figures(design, folder), one)


def assert_same(found: dict[str, Any], wording: dict[str, Any]) -> None:
    assert found.keys() == wording.keys()
    for key, value in wording.items():
        # kappa and the outline are sampled and polished: another processor's last digits
        assert found[key] == (pytest.approx(value, rel=1e-6) if isinstance(value, float | list) else value), key
