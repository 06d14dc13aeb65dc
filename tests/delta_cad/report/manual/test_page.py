"""The manual's page and pictures, of a machine of blocks and of the one real build."""

from __future__ import annotations

import base64
import io
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import image

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.order.record import Bring
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.common.worker_process import WorkerProcessError
from delta_cad.dimensions import Dimensions
from delta_cad.export.drawings.paper.lettering import _file
from delta_cad.export.mass_properties import mass_report
from delta_cad.export.views.scene import PictureError
from delta_cad.report.manual.page import page as write_page
from delta_cad.report.manual.page import write_manual, written
from delta_cad.report.manual.pictures import ACCENTS, ARROW, SIZE
from tests.committed import Built
from tests.delta_cad.checks.contact.order.blocks import DOWN, on_base, pin, plate, step, whole

Picture = np.ndarray
SRC = re.compile(r'<img src="([^"]*)"')


def pictures(text: str) -> list[Picture]:
    """(height, width, 3) of each picture of a page, 0 to 1; every one is in the page itself."""
    found = []
    for source in SRC.findall(text):
        assert source.startswith("data:image/png;base64,")
        found.append(image.imread(io.BytesIO(base64.b64decode(source.partition(",")[2])))[..., :3])
    return found


def like(picture: Picture, colour: tuple[float, float, float]) -> int:
    """Pixels of about a colour's hue: as light and shade leave it."""
    shade = picture / (np.linalg.norm(picture, axis=-1, keepdims=True) + 1e-9)
    hue = np.array(colour) / np.linalg.norm(colour)
    return int((shade @ hue > 0.995).sum())


@pytest.fixture(scope="module")
def blocks() -> Assembly:
    a = on_base(plate(), pin())
    return replace(a, order=whole(step(Bring(("plate",))), step(Bring(("pin",), DOWN))))


@pytest.fixture(scope="module")
def page(blocks: Assembly, best_dimensions: Dimensions, tmp_path_factory: pytest.TempPathFactory) -> str:
    folder = tmp_path_factory.mktemp("build")
    masses = mass_report(blocks)
    path = write_manual(best_dimensions, blocks.without_solids(), MeshLibrary(blocks.parts), masses, folder)
    assert path == folder / "manual" / "manual.html"
    assert [one.name for one in folder.rglob("*") if one.is_file()] == ["manual.html"]
    return path.read_text(encoding="utf-8")


def test_a_picture_has_what_comes_in_in_colour_and_the_rest_in_grey(page: str) -> None:
    first, second = pictures(page)
    assert first.shape == second.shape == (SIZE[1], SIZE[0], 3)
    assert like(first, ACCENTS[0]) > 20_000  # the plate, which is all there is
    assert 500 < like(second, ACCENTS[0]) < like(first, ACCENTS[0]) / 2  # the pin, drawn out of it
    assert like(first, ARROW) < 20
    assert like(second, ARROW) > 60


def test_a_pin_is_drawn_above_the_plate_that_it_comes_down_into(page: str) -> None:
    _, second = pictures(page)
    shade = second / (np.linalg.norm(second, axis=-1, keepdims=True) + 1e-9)
    rows = np.flatnonzero((shade @ (np.array(ACCENTS[0]) / np.linalg.norm(ACCENTS[0])) > 0.995).any(axis=1))
    grey = (np.ptp(second, axis=-1) < 0.04) & (second.max(axis=-1) < 0.75)
    assert rows.mean() < np.flatnonzero(grey.any(axis=1)).mean()  # counted from above


def test_the_page_asks_nothing_of_any_other_place_and_escapes_names(
    blocks: Assembly, best_dimensions: Dimensions, tmp_path: Path, page: str
) -> None:
    assert not re.search(r'(src|href)="(?!data:|#)', page)
    assert "default-src 'none'" in page
    evil = replace(blocks, name="<script>alert(1)</script>")
    text = write_manual(best_dimensions, evil, MeshLibrary(evil.parts), mass_report(evil), tmp_path).read_text(
        encoding="utf-8"
    )
    assert "<script" not in text
    assert "&lt;script&gt;" in text


def test_the_page_carries_the_letters_that_not_every_browser_has(
    blocks: Assembly, best_dimensions: Dimensions, chromium: Any
) -> None:
    """Read from its faces, and seen in a browser: as much ink as the same letters have by the whole face itself."""
    from fontTools.ttLib import TTFont
    from PIL import Image, ImageDraw, ImageFont

    text = "球形 강철 ąč стальной"
    written = write_page(best_dimensions, replace(blocks, name=text), [], {})
    faces = re.findall(r'font-family: "Lettering\d"; src: url\("data:font/ttf;base64,([^"]*)"\)', written)
    letters = {code for data in faces for code in TTFont(io.BytesIO(base64.b64decode(data))).getBestCmap()}
    assert {ord(letter) for letter in text if letter != " "} <= letters
    assert len(letters) < 60
    viewer = chromium.new_page()
    viewer.set_content(written)
    viewer.evaluate("document.fonts.ready")
    shot = viewer.locator("h1").first
    shot.evaluate(
        "one => { one.textContent = '球形'; one.style = 'font-size: 60px; font-weight: 400; display: inline' }"
    )
    viewer.wait_for_timeout(500)
    seen = Image.open(io.BytesIO(shot.screenshot())).convert("L").point(lambda value: 255 * (value < 128))
    viewer.close()
    own = Image.new("L", (400, 200))
    ImageDraw.Draw(own).text((20, 20), "球形", 255, ImageFont.truetype(str(_file(1)), 60))
    assert sum(seen.histogram()[128:]) == pytest.approx(sum(own.histogram()[128:]), rel=0.1)


class Ended:
    """A process that is gone."""

    def receive(self) -> None:
        raise WorkerProcessError("page: ended by signal 9")


def test_a_process_that_ended_early_is_told_as_what_it_drew() -> None:
    with pytest.raises(PictureError, match="ended by signal 9"):
        written(Ended())  # type: ignore[arg-type]


def test_the_build_has_its_manual_with_a_picture_a_step(built: Built, best_assembly: Assembly) -> None:
    text = (built.folder / "manual" / "manual.html").read_text(encoding="utf-8")
    shown = pictures(text)
    first = {unit.kind: len(unit.steps) for unit in reversed(best_assembly.order)}
    assert len(shown) == sum(first.values())
    assert len({picture.tobytes() for picture in shown}) == len(shown)
    assert 'href="manual/manual.html"' in (built.folder / "report.html").read_text(encoding="utf-8")
    checks = {check["name"]: check for check in built.record["checks"]}
    assert (checks["assembly order"]["passed"], checks["assembly order"]["value"]) == (True, 0.0)
    assert checks["assembly keys"]["value"] >= checks["assembly keys"]["limit"] - 1e-9
