"""The page in a browser: it draws, moves, comes apart and is cut, says nothing wrong and asks nothing elsewhere."""

from __future__ import annotations

import json
from collections.abc import Iterator
from io import BytesIO
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism.statics import conditioning
from tests.committed import Built
from tests.delta_cad.report.reading import Page

PHONE = {"width": 390, "height": 700}
DRAWN_MS = 120_000  # a picture takes a second where a processor draws it


@pytest.fixture(scope="module")
def said() -> list[str]:
    """What the page said and asked for."""
    return []


@pytest.fixture(scope="module")
def live(chromium: Any, built: Built, said: list[str]) -> Iterator[Any]:
    page = chromium.new_page(viewport=PHONE)
    page.set_default_timeout(DRAWN_MS)
    page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: said.append(request.url))
    page.goto((built.folder / "report.html").as_uri())
    page.wait_for_selector("body[data-ready]")
    yield page
    page.close()


def picture(live: Any) -> np.ndarray:
    """What the canvas shows once it is drawn again, as colours of its pixels."""
    from PIL import Image

    live.evaluate("document.getElementById('machine').scrollIntoView()")  # below the row of links, which stays
    live.mouse.move(1, 1)  # no name stands before it
    drawn = int(live.evaluate("document.getElementById('view').dataset.drawn"))
    live.wait_for_function(f"Number(document.getElementById('view').dataset.drawn) >= {drawn}")
    live.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    png = live.locator("#view").screenshot()
    return np.asarray(Image.open(BytesIO(png)).convert("RGB"), dtype=float)


def slide(live: Any, name: str, value: float) -> None:
    live.evaluate(
        "([name, value]) => { const e = document.getElementById(name); e.value = value;"
        " e.dispatchEvent(new Event('input')); e.dispatchEvent(new Event('change')); }",
        [name, value],
    )


def figures(live: Any) -> dict[str, str]:
    rows = live.evaluate(
        "[...document.querySelectorAll('#live tr')].map((r) => [...r.cells].map((c) => c.textContent))"
    )
    return dict(rows)


def test_it_is_ready_and_shows_the_machine(live: Any) -> None:
    assert live.evaluate("document.body.dataset.ready") == "model"
    shown = picture(live)
    assert len(np.unique(shown.reshape(-1, 3), axis=0)) > 500
    orange = (shown[..., 0] > 180) & (shown[..., 1] < 150) & (shown[..., 2] < 90)
    assert orange.mean() > 0.01  # the upper arms


def test_a_slider_moves_the_machine_and_its_figures(live: Any, page: Page) -> None:
    from delta_cad.mechanism import DeltaGeometry

    before, reported = picture(live), figures(live)
    data = page.data()
    m, high = data["mechanism"], data["cube"]["bottom_mm"] + 2.0 * data["cube"]["half_mm"]
    slide(live, "pose-z", high + 50.0)  # the slider ends at the cube's top
    lengths = [m[f"{name}_mm"] / 1000.0 for name in ("base_radius", "platform_radius", "upper_arm", "forearm")]
    kappa = float(conditioning(DeltaGeometry(*lengths), np.array([0.0, 0.0, high / 1000.0])))
    assert float(figures(live)["conditioning"]) == pytest.approx(kappa, rel=1e-3)
    assert figures(live) != reported
    assert np.abs(picture(live) - before).mean() > 1.0
    live.click("#home")
    assert figures(live) == reported
    assert np.abs(picture(live) - before).mean() < 0.5


def test_a_worst_place_is_shown_where_a_check_names_one(live: Any, built: Built) -> None:
    checks = json.loads((built.folder / "checks.json").read_text())["checks"]
    x, y, z = next(check["worst_pose_mm"] for check in checks if check["name"] == "torque with gravity")
    live.locator("#figures tr", has_text="weight together").locator("button").click()
    reported = [float(live.locator(f"#told-{axis}").text_content()) for axis in "xyz"]
    assert reported == pytest.approx([x, y, z], abs=0.0501)
    live.click("#home")


def test_wherever_it_is_moved_it_stays_in_the_picture(live: Any, page: Page) -> None:
    cube = page.data()["cube"]
    live.click("button[data-view=iso]")
    slide(live, "pose-z", cube["bottom_mm"] + 2.0 * cube["half_mm"])
    shown = picture(live)
    rim = np.concatenate([shown[:3].reshape(-1, 3), shown[:, :3].reshape(-1, 3), shown[:, -3:].reshape(-1, 3)])
    assert np.ptp(rim, axis=1).max() < 40.0  # nothing coloured, but the background
    assert rim.min() > 120.0  # nor the black knob
    live.click("#home")


def test_from_above_it_stands_within_the_outline(live: Any) -> None:
    """Nearly parallel, else the arms, which are nearer, would stand out of a rectangle that they keep."""
    live.click("button[data-view=top]")
    shown = picture(live)
    red = (shown[..., 0] > 150) & (shown[..., 1] < 120) & (shown[..., 2] < 110) & (shown[..., 0] - shown[..., 2] > 70)
    arms = (shown[..., 0] > 200) & (shown[..., 2] < 90) & (shown[..., 1] > 80)
    outline = [np.flatnonzero(red.mean(axis=axis) > 0.3) for axis in (0, 1)]
    for axis in (0, 1):
        within = np.flatnonzero(arms.any(axis=axis))
        assert outline[axis].min() - 1 <= within.min()
        assert within.max() <= outline[axis].max() + 1
    live.click("button[data-view=iso]")


def test_it_comes_apart_and_is_cut(live: Any) -> None:
    whole = picture(live)
    slide(live, "apart", 100)
    assert np.abs(picture(live) - whole).mean() > 2.0
    slide(live, "apart", 0)
    live.select_option("#cut", "y")
    cut = picture(live)
    assert np.abs(cut - whole).mean() > 1.0
    assert live.locator("#told-cut").text_content() != ""
    live.select_option("#cut", "")
    assert np.abs(picture(live) - whole).mean() < 0.5


def test_a_part_tells_its_name(live: Any, page: Page) -> None:
    names = page.data()["occurrences"]
    box = live.locator("#view").bounding_box()
    found = ""
    for height in (0.45, 0.6, 0.7, 0.8):
        live.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + height * box["height"])
        if live.locator("#tip").is_visible():
            found = live.locator("#tip b").text_content()
            break
    assert found in names


def test_a_row_of_the_parts_brings_its_part_out(live: Any) -> None:
    whole = picture(live)
    row = live.locator("#bom tr[data-part=knob] td").nth(1)
    row.click()
    shown = picture(live)
    orange = (shown[..., 0] > 200) & (shown[..., 1] < 170) & (shown[..., 2] < 110)
    assert 0.001 < orange.mean() < 0.03  # a ball of 25 mm; the arms, as orange, are faint
    row.click()
    assert np.abs(picture(live) - whole).mean() < 0.5


def test_every_part_has_a_picture_in_its_row_and_what_has_no_solid_none(live: Any, page: Page) -> None:
    shown = live.evaluate(
        "[...document.querySelectorAll('#bom tr[data-part]')].map((row) => { const c = row.querySelector('canvas');"
        " const p = c?.getContext('2d').getImageData(0, 0, c.width, c.height).data.filter((_, k) => k % 4 === 3);"
        " return [row.dataset.part, c ? [c.height, c.width] : null, p ? [...p] : null]; })"
    )
    known = {part["number"] for part in page.data()["parts"]}
    assert {number for number, size, _ in shown if size} == known
    for number, size, alphas in shown:
        if size:
            covered = np.array(alphas).reshape(size) > 128
            spans = [np.ptp(np.nonzero(covered)[k]) / size[k] for k in (0, 1)]
            assert max(spans) > 0.4, number  # a ball takes 0.59 of the height; a cable is thin, and as long as its box
            assert covered.mean() < 0.9, number


def test_maps_are_drawn_and_lead_to_a_place(live: Any, page: Page) -> None:
    """A slice has so many colours as its values take of its scale, which is its own or that of all slices."""
    maps = page.data()["slices"]["maps"]
    assert live.locator("#maps canvas").count() == 5 * len(maps)
    colours = live.evaluate(
        "[...document.querySelectorAll('#maps canvas')].map((c) => new Set(c.getContext('2d')"
        ".getImageData(0, 0, c.width, c.height).data).size)"
    )
    own = [words.startswith("best in") for words in live.locator("#maps .scale span:first-child").all_text_contents()]
    spreads = [np.ptp(slice_) / np.ptp(one["values"]) for one in maps for slice_ in one["values"]]
    wide = [spread >= 0.1 or own[k // 5] for k, spread in enumerate(spreads)]
    assert sum(wide) >= 4 * len(maps)
    assert all(count > (20 if one else 4) for count, one in zip(colours, wide, strict=True))  # 4 are one colour's
    live.locator("#maps canvas").first.click(position={"x": 3, "y": 3})  # the corner itself is rounded off
    half = page.data()["cube"]["half_mm"]
    assert [float(live.locator(f"#told-{axis}").text_content()) for axis in "xy"] == pytest.approx(
        [-half, half], abs=0.1
    )


def test_the_map_of_clearance_names_the_pair(live: Any, page: Page) -> None:
    one = page.data()["slices"]["maps"][-1]
    live.locator("#maps .map").last.locator("canvas").first.hover(position={"x": 8, "y": 8})
    pair = one["names"][one["pairs"][0][-1][0]]  # seen from above: y up
    assert live.locator("#tip span").all_text_contents()[-1] == pair
    assert f"Clearance {one['values'][0][-1][0]:g} mm" in live.locator("#tip b").text_content()


def test_tables_are_filtered(live: Any) -> None:
    live.fill("input[data-table=bom]", "rod_tube")
    shown = live.evaluate("[...document.querySelectorAll('#bom tbody tr')].filter((r) => !r.hidden).length")
    assert shown >= 1
    assert live.locator("#bom tbody tr:visible").first.text_content().find("rod_tube") >= 0
    live.fill("input[data-table=bom]", "")


def test_nothing_is_wider_than_a_phone(live: Any) -> None:
    assert live.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]


def test_the_manual_is_no_wider_than_a_phone(chromium: Any, built: Built) -> None:
    manual = chromium.new_page(viewport=PHONE)
    manual.goto((built.folder / "manual" / "manual.html").as_uri())
    wide = manual.evaluate("document.documentElement.scrollWidth")
    manual.close()
    assert wide <= PHONE["width"]


def test_nothing_is_wider_than_a_page_of_paper(live: Any) -> None:
    """A4 less its margins at 96 dots an inch; what is wider is cut off, or shrinks all else."""
    live.emulate_media(media="print")
    live.set_viewport_size({"width": 688, "height": 1000})
    wide = live.evaluate("document.documentElement.scrollWidth")
    live.emulate_media(media="screen")
    live.set_viewport_size(PHONE)
    assert wide <= 688


def test_drawings_are_linked_from_the_parts_and_lead_there(live: Any, built: Built) -> None:
    links = live.evaluate("[...document.querySelectorAll('#bom td a')].map((a) => a.getAttribute('href'))")
    made = {path.name for path in (built.folder / "drawings").glob("*.pdf")} - {"assembly.pdf"}
    assert {link.removeprefix("drawings/") for link in links} == made


def test_it_said_nothing_and_requested_nothing_else(live: Any, said: list[str], built: Built) -> None:
    assert live.evaluate("document.body.dataset.ready") == "model"
    assert said == [(built.folder / "report.html").as_uri()]
