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

MOST_PAGES = 8  # of A4
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


def position_mm(live: Any) -> list[float]:
    """Where the page says that the handle is, mm."""
    return [float(live.locator(f"#told-{axis}").text_content()) for axis in "xyz"]


def knob(live: Any) -> tuple[float, float]:
    """Where on the screen the handle's middle is, from the front: that of the cube, whose blue edges are seen."""
    live.click("#home")
    live.click("button[data-view=front]")
    box = live.locator("#view").bounding_box()
    left, right, top, bottom = cube_edges(live)
    return box["x"] + (left + right) / 2.0, box["y"] + (top + bottom) / 2.0


def cube_edges(live: Any) -> tuple[int, int, int, int]:
    """First and last column and row of the picture that an edge of the cube runs along."""
    shown = picture(live)
    blue = shown[..., 2] - shown[..., 0] > 40.0  # the platform too, which is within
    columns, rows = (np.flatnonzero(blue.mean(axis=axis) > 0.12) for axis in (0, 1))
    return columns.min(), columns.max(), rows.min(), rows.max()


def pull(live: Any, start: tuple[float, float], *way: tuple[float, float]) -> None:
    """Presses there, moves by each of a number of ways, and lets go."""
    live.mouse.move(*start)
    live.mouse.down()
    for dx, dy in way:
        live.mouse.move(start[0] + dx, start[1] + dy, steps=3)
    live.mouse.up()


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
    assert position_mm(live) == pytest.approx([x, y, z], abs=0.0501)
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


def test_the_handle_is_dragged_in_the_plane_of_the_screen(live: Any, page: Page) -> None:
    """From the front: right is x, up is z, and the cube's edges give the scale."""
    start, (x, y, z), half = knob(live), position_mm(live), page.data()["cube"]["half_mm"]
    left, right, _, _ = cube_edges(live)
    mm_px = 2.0 * half / (right - left)
    before, figures_before = picture(live), figures(live)
    pull(live, start, (20, -15))
    assert position_mm(live) == pytest.approx([x + 20 * mm_px, y, z + 15 * mm_px], abs=0.06 * half)
    assert [float(live.input_value(f"#pose-{axis}")) for axis in "xyz"] == pytest.approx(position_mm(live), abs=0.0501)
    assert figures(live) != figures_before
    assert np.abs(picture(live) - before).mean() > 1.0
    assert live.locator("#tip").is_hidden()
    live.click("#home")


def test_a_drag_ends_at_the_cube_or_where_the_machine_ends(live: Any, page: Page) -> None:
    """Closure, stops and lean of the place that is reached by the mechanism's own Python."""
    from delta_cad.mechanism import DeltaGeometry, inverse_kinematics, rod_lean

    data = page.data()
    m, cube = data["mechanism"], data["cube"]
    start, high = knob(live), cube["bottom_mm"] + 2.0 * cube["half_mm"]
    pull(live, start, (150, -250))
    assert position_mm(live) == pytest.approx([cube["centre_x_mm"] + cube["half_mm"], 0.0, high], abs=0.06)
    start = knob(live)
    live.uncheck("#keep")
    pull(live, start, (150, -250))
    x, y, z = position_mm(live)
    assert "outside the cube" in figures(live)
    assert z > high + 1.0 or x > cube["half_mm"] + 1.0
    lengths = [m[f"{name}_mm"] / 1000.0 for name in ("base_radius", "platform_radius", "upper_arm", "forearm")]
    g, p = DeltaGeometry(*lengths), np.array([x, y, z]) / 1000.0
    theta, lean = inverse_kinematics(g, p), np.abs(rod_lean(g, p))
    low, up = m["shoulder_rad"]
    rooms = [*(up - theta), *(theta - low), *(m["lean_rad"] - lean)]
    assert -0.01 < min(rooms) < 0.01  # rad: at a stop or a joint's largest lean, to the 0.05 mm that are shown
    live.check("#keep")
    assert position_mm(live) == pytest.approx([cube["centre_x_mm"] + cube["half_mm"], y, high], abs=0.06)
    live.click("#home")


def test_off_the_handle_a_drag_turns_the_view(live: Any) -> None:
    start, before = knob(live), position_mm(live)
    shown = picture(live)
    pull(live, (start[0] - 120, start[1] + 10), (60, 0))
    assert position_mm(live) == before
    assert np.abs(picture(live) - shown).mean() > 1.0
    live.click("button[data-view=iso]")


def test_a_finger_drags_the_handle(live: Any) -> None:
    x, y = knob(live)
    before = position_mm(live)
    touch = live.context.new_cdp_session(live)
    for kind, points in (
        ("touchStart", [(x, y)]),
        *(("touchMove", [(x + 4 * k, y - 4 * k)]) for k in range(1, 8)),
        ("touchEnd", []),
    ):
        touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": a, "y": b} for a, b in points]})
    touch.detach()
    now = position_mm(live)
    assert now[0] > before[0] + 2.0
    assert now[1] == pytest.approx(before[1], abs=0.2)
    assert now[2] > before[2] + 2.0
    live.click("#home")
    live.click("button[data-view=iso]")


def test_on_a_phone_the_machine_comes_first(live: Any) -> None:
    tops = live.evaluate(
        "['#stage', '.cards', '.downloads', '#figures'].map((one) => document.querySelector(one)"
        ".getBoundingClientRect().top + window.scrollY)"
    )
    assert tops == sorted(tops)
    assert tops[0] < PHONE["height"] / 2


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


def test_a_figure_has_one_colour_scale_over_all_its_slices(live: Any, page: Page) -> None:
    """The colour of every corner of every slice against matplotlib's viridis, at the value's share of all slices."""
    from matplotlib import colormaps

    maps = page.data()["slices"]["maps"]
    assert live.locator("#maps canvas").count() == 5 * len(maps)
    assert live.input_value("#scales") == "one"
    corners = np.array(
        live.evaluate(
            "[...document.querySelectorAll('#maps canvas')].map((c) => { const [w, h] = [c.width, c.height];"
            " const all = c.getContext('2d').getImageData(0, 0, w, h).data; const at = (x, y) => 4 * (y * w + x);"
            " return [at(0, h - 1), at(w - 1, 0)].map((k) => [...all.slice(k, k + 3)]); })"
        )
    ).reshape(len(maps), 5, 2, 3)
    ends = live.locator("#maps .scale").all_inner_texts()
    for one, found, words in zip(maps, corners, ends, strict=True):
        values = np.array(one["values"])
        low, high = values.min(), values.max()
        good, bad = (low, high) if one["upper"] else (high, low)
        assert [float(v) for v in words.split()] == pytest.approx([good, bad], rel=5e-3)
        share = 8.0 * (values[:, [0, -1], [0, -1]] - good) / (bad - good)
        step = np.minimum(np.floor(share), 7.0)
        lower, upper = (255.0 * colormaps["viridis"](k / 8.0)[..., :3] for k in (step, step + 1.0))
        expected = lower + (share - step)[..., None] * (upper - lower)
        assert np.abs(found - expected).max() < 4.0, one["name"]  # of 255: its table has 256 rows, ours 9 whole ones
    live.select_option("#scales", "each")
    assert set(live.locator("#maps .scale span:first-child").all_text_contents()) == {"best in the slice"}
    live.select_option("#scales", "one")


def test_a_place_on_a_map_is_shown(live: Any, page: Page) -> None:
    live.locator("#maps canvas").first.click(position={"x": 3, "y": 3})  # the corner itself is rounded off
    half = page.data()["cube"]["half_mm"]
    assert position_mm(live)[:2] == pytest.approx([-half, half], abs=0.1)
    live.click("#home")


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
    assert live.locator("nav").bounding_box()["height"] < 50.0  # one line, of which the end is off the screen


def test_the_manual_is_no_wider_than_a_phone(chromium: Any, built: Built) -> None:
    manual = chromium.new_page(viewport=PHONE)
    manual.goto((built.folder / "manual" / "manual.html").as_uri())
    wide = manual.evaluate("document.documentElement.scrollWidth")
    manual.close()
    assert wide <= PHONE["width"]


# Numbers of what is visible that stand in more than one line.
BROKEN = r"""() => {
  const broken = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walk.nextNode(); node; node = walk.nextNode()) {
    if (!node.parentElement.checkVisibility() || node.parentElement.closest("script")) continue;
    for (const found of node.data.matchAll(/(?<![\w.])[-+−]?\d[\d.,]*\d(?!\w)/g)) {
      const range = document.createRange();
      range.setStart(node, found.index);
      range.setEnd(node, found.index + found[0].length);
      const lines = new Set([...range.getClientRects()].map((box) => Math.round(box.top)));
      if (lines.size > 1) broken.push(found[0]);
    }
  }
  return broken;
}"""


def test_on_paper_nothing_is_wider_than_a_page_and_no_number_is_broken(live: Any) -> None:
    """A4 less its margins at 96 dots an inch; what is wider is cut off, or shrinks all else."""
    live.emulate_media(media="print")
    live.set_viewport_size({"width": 710, "height": 1000})
    wide, broken = live.evaluate("document.documentElement.scrollWidth"), live.evaluate(BROKEN)
    live.emulate_media(media="screen")
    live.set_viewport_size(PHONE)
    assert wide <= 710
    assert broken == []


def test_it_prints_on_few_pages_with_checks_summed_up(live: Any, page: Page, built: Built) -> None:
    import pypdfium2

    live.emulate_media(media="null")
    document = pypdfium2.PdfDocument(live.pdf(prefer_css_page_size=True))
    text = " ".join(document[k].get_textpage().get_text_range() for k in range(len(document)))
    assert len(document) <= MOST_PAGES
    checks = json.loads((built.folder / "checks.json").read_text())["checks"]
    count = sum(check["name"].startswith("structure ") for check in checks)
    assert " ".join(page.one("verdict").text.split()[:2]) in text
    assert f"{count} of {count} hold" in text
    assert "structure shoulder bearing life" not in text  # one of them, folded


def test_a_kind_of_checks_opens_and_is_searched(live: Any) -> None:
    strength = live.locator("#every details", has_text="structure shoulder bearing life")
    row = strength.locator("tr", has_text="structure shoulder bearing life").first
    assert not row.is_visible()
    strength.locator("summary").click()
    assert row.is_visible()
    strength.locator("summary").click()
    live.fill("input[data-table=every]", "bearing life")
    assert row.is_visible()
    assert live.locator("#every details:visible").count() == 1
    live.fill("input[data-table=every]", "")
    assert live.locator("#every details[open]").count() == 0


def test_drawings_are_linked_from_the_parts_and_lead_there(live: Any, built: Built) -> None:
    links = live.evaluate("[...document.querySelectorAll('#bom td a')].map((a) => a.getAttribute('href'))")
    made = {path.name for path in (built.folder / "drawings").glob("*.pdf")} - {"assembly.pdf"}
    assert {link.removeprefix("drawings/") for link in links} == made


def test_it_said_nothing_and_requested_nothing_else(live: Any, said: list[str], built: Built) -> None:
    assert live.evaluate("document.body.dataset.ready") == "model"
    assert said == [(built.folder / "report.html").as_uri()]
