"""The page of two machines: one camera, one handle, and what a reader of another machine's build refuses.

25 s of processor: it draws the page of two machines with real meshes in a browser.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.commands.cli import main
from delta_cad.design import Design, design_from_dict, design_hash, design_to_json
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.statics import conditioning
from delta_cad.report.built import Build, StaleBuildError
from delta_cad.report.comparison import changes, pair, signed
from tests.committed import BEST, Built, changed

DRAWN_MS = 120_000  # a picture takes a second where a processor draws it


@pytest.fixture(scope="module")
def other(built: Built, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The build as one of another design of a smaller cube."""
    folder = tmp_path_factory.mktemp("other") / "other"
    shutil.copytree(built.folder, folder)
    design = design_from_dict(changed(name="other", cube__half_side_mm=40.0))
    (folder / "design.json").write_text(design_to_json(design))
    report = folder / "report.html"
    text = report.read_text()
    begin = text.index('id="data">') + len('id="data">')
    end = text.index("</script>", begin)
    scene = json.loads(text[begin:end])
    scene["cube"]["half_mm"] = 40.0
    report.write_text(text[:begin] + json.dumps(scene) + text[end:])
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["input_sha256"] = design_hash(design)
    for name in ("report.html", "design.json"):
        manifest["files"][name] = {"sha256": sha256((folder / name).read_bytes()).hexdigest()}
    (folder / "manifest.json").write_text(json.dumps(manifest))
    return folder


@pytest.fixture(scope="module")
def said() -> list[str]:
    return []


@pytest.fixture(scope="module")
def live(chromium: Any, built: Built, other: Path, said: list[str]) -> Iterator[Any]:
    assert main(["compare", str(built.folder), str(other), "--out", str(other.parent)]) == 0
    page = chromium.new_page(viewport={"width": 1200, "height": 900})
    page.set_default_timeout(DRAWN_MS)
    page.on("console", lambda message: said.append(f"{message.type}: {message.text}"))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: said.append(request.url))
    page.goto((other.parent / f"compare-{built.folder.name}-other.html").as_uri())
    page.wait_for_selector("body[data-ready]")
    yield page
    page.close()


def pictures(live: Any) -> list[np.ndarray]:
    from io import BytesIO

    from PIL import Image

    live.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    shots = (live.locator(f"#view-{side}").screenshot() for side in "ab")
    return [np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=float) for shot in shots]


def arms(shown: np.ndarray) -> np.ndarray:
    """First and last row and column of the orange upper arms, which tell where a machine stands in its picture."""
    orange = (shown[..., 0] > 180) & (shown[..., 1] < 150) & (shown[..., 2] < 90)
    assert orange.mean() > 0.005
    return np.array([[line.min(), line.max()] for line in np.nonzero(orange)])


def position_mm(live: Any) -> list[float]:
    return [float(live.locator(f"#told-{axis}").text_content()) for axis in "xyz"]


def test_both_are_shown_alike(live: Any) -> None:
    """The same solids with the same camera at the same position, to the pixel that the canvases are off its grid."""
    assert live.evaluate("document.body.dataset.ready") == "model"
    assert position_mm(live)[2] == pytest.approx(144.4 - 40.0, abs=0.1)  # in the middle of what both cubes share
    a, b = pictures(live)
    assert len(np.unique(a.reshape(-1, 3), axis=0)) > 500
    assert np.abs(arms(a) - arms(b)).max() <= 1


def test_turning_one_turns_both(live: Any) -> None:
    before = pictures(live)
    box = live.locator("#view-b").bounding_box()
    x, y = box["x"] + 30, box["y"] + box["height"] - 40
    live.mouse.move(x, y)
    live.mouse.down()
    live.mouse.move(x + 90, y - 20, steps=3)
    live.mouse.up()
    a, b = pictures(live)
    assert np.abs(arms(a) - arms(before[0])).max() > 10
    assert np.abs(arms(a) - arms(b)).max() <= 1
    live.click("button[data-view=iso]")


def test_one_handle_moves_both_and_gives_the_figures_of_each(live: Any) -> None:
    before = pictures(live)
    live.evaluate("const e = document.getElementById('pose-z'); e.value = 145; e.dispatchEvent(new Event('input'));")
    for was, now in zip(before, pictures(live), strict=True):
        assert np.abs(was - now).mean() > 1.0
    assert position_mm(live)[2] == pytest.approx(145.0)
    rows = dict(
        live.evaluate(
            "[...document.querySelectorAll('#live tbody tr')].map((r) => [...r.cells].slice(0, 2)"
            ".map((cell) => cell.textContent))"
        )
    )
    m = json.loads(BEST.read_text())["mechanism"]
    names = ("base_radius_mm", "platform_radius_mm", "upper_arm_length_mm", "forearm_length_mm")
    g = DeltaGeometry(*(m[name] / 1000.0 for name in names))
    kappa = float(conditioning(g, np.array([0.0, 0.0, 0.145])))
    assert float(rows["conditioning"]) == pytest.approx(kappa, rel=1e-3)
    assert live.locator("#message-a").text_content() == ""
    assert live.locator("#message-b").text_content() == "outside its cube"  # which ends at 144.4 mm


def test_a_drag_in_one_moves_both(live: Any) -> None:
    live.click("button[data-view=front]")
    box = live.locator("#view-a").bounding_box()
    before = position_mm(live)
    a, _ = pictures(live)
    knob = (a.max(axis=-1) < 60.0) & (np.arange(len(a))[:, None] < len(a) / 2)  # black, and the highest of all
    row = int(np.flatnonzero(knob.any(axis=1))[0]) + 6
    column = int(np.median(np.flatnonzero(knob[row])))
    live.mouse.move(box["x"] + column, box["y"] + row)
    live.mouse.down()
    live.mouse.move(box["x"] + column + 25, box["y"] + row, steps=3)
    live.mouse.up()
    assert position_mm(live)[0] > before[0] + 3.0
    assert position_mm(live)[1:] == pytest.approx(before[1:], abs=0.3)
    live.click("button[data-view=iso]")


def test_it_states_figures_parts_and_cost(live: Any) -> None:
    rows = live.evaluate(
        "[...document.querySelectorAll('#figures tr')].map((r) => [...r.cells].map((c) => c.textContent))"
    )
    table = {row[0]: row for row in rows}
    assert table["cube side"][1:] == ["86.33", "80", "-6.33 (-7.3 %)", "mm"]
    better = live.locator("#figures tr", has_text="cube side").locator("td.holds")
    assert better.all_text_contents() == ["86.33"]
    assert live.locator("#figures tr.same", has_text="rotor's inertia").count() == 1
    assert "parts are the same" in live.locator("#parts").text_content()
    assert live.locator("#cost tbody tr").count() == 5


def test_on_a_phone_nothing_is_wider_and_the_machines_come_first(live: Any) -> None:
    live.set_viewport_size({"width": 390, "height": 844})
    assert live.evaluate("document.documentElement.scrollWidth") <= 390
    box = live.locator("#stage-b").bounding_box()
    assert box["y"] + box["height"] < 844
    for value in live.locator("#figures tr", has_text="cube side").locator("td").all():
        cell = value.bounding_box()
        assert cell["x"] + cell["width"] <= 390  # in sight, without a scroll to the side
    live.set_viewport_size({"width": 1200, "height": 900})


def test_it_said_nothing_and_requested_nothing_else(live: Any, said: list[str]) -> None:
    assert said == [live.url]


def test_a_build_without_a_page_is_compared_without_3d(built: Built, other: Path, chromium: Any) -> None:
    manifest = json.loads((other / "manifest.json").read_text())
    bare = other.parent / "bare"
    shutil.copytree(other, bare)
    del manifest["files"]["report.html"]
    (bare / "manifest.json").write_text(json.dumps(manifest))
    assert main(["compare", str(built.folder), str(bare), "--out", str(other.parent / "out")]) == 0
    page = chromium.new_page()
    page.set_default_timeout(DRAWN_MS)
    page.goto((other.parent / "out" / f"compare-{built.folder.name}-other.html").as_uri())
    page.wait_for_selector("body[data-ready=model]")
    assert "was built without report.html" in page.locator("#message-b").text_content()
    page.close()


def test_of_a_damaged_build_nothing_is_read(best: Design, built: Built, tmp_path: Path) -> None:
    folder = tmp_path / "build"
    folder.mkdir()
    with pytest.raises(StaleBuildError, match="no build in"):
        Build.read(folder)
    for text in (
        "",
        "[]",
        '{"input_sha256": 1}',
        '{"input_sha256": "", "versions": {"delta-haptics": ""}, "files": 3}',
    ):
        (folder / "manifest.json").write_text(text)
        with pytest.raises(StaleBuildError, match=r"manifest\.json cannot be read"):
            Build.read(folder)
    whole = Build.of(best, built.folder)
    with pytest.raises(StaleBuildError, match=r"was built without no\.json"):
        whole.content("no.json")
    shutil.copy(built.folder / "manifest.json", folder)
    copy = Build.of(best, folder)
    with pytest.raises(StaleBuildError, match=r"checks\.json.*cannot be read"):
        copy.json("checks.json")
    (folder / "report.html").write_text("<html>")
    with pytest.raises(StaleBuildError, match="was changed after the build"):
        copy.scene()
    page = Build(folder, "", {"report.html": sha256(b"<html>").hexdigest()})
    with pytest.raises(StaleBuildError, match="is not JSON"):
        page.scene()


@pytest.mark.parametrize(
    ("a", "b", "texts", "difference"),
    [
        (2.0, 3.0, ("2", "3"), "+1 (+50 %)"),
        (2.00000001, 2.0, ("2.00000001", "2"), "-1e-08 (-5e-07 %)"),
        (0.0, 1.5, ("0", "1.5"), "+1.5"),
        (None, 1.5, ("not built", "1.5"), ""),
        ("re30", "re25", ("re30", "re25"), ""),
    ],
)
def test_values_have_as_many_digits_as_tell_them_apart(a: Any, b: Any, texts: tuple[str, str], difference: str) -> None:
    number = isinstance(a, float) and isinstance(b, float)
    row = {"group": "figures", "a": a, "b": b, "difference": b - a if number else None}
    assert pair(row) == texts
    assert signed(row) == difference


def test_a_part_of_another_shape_alone_is_said_so() -> None:
    assert changes({"part_number": "x", "shape": True}) == "shape"
    assert changes({"part_number": "x", "shape": True, "quantity": [1, 2]}) == "quantity 1 -> 2"
    assert changes({"part_number": "x", "shape": False, "standard": [None, "ISO 4762"]}) == "standard none -> ISO 4762"
