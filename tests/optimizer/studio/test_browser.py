"""The page in a browser: a slider is answered and proved, the machine is drawn, nothing goes wrong or elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.report.live.door import Door
from optimizer.studio.building import Progress
from optimizer.studio.document import Document
from optimizer.studio.server import PROTOCOL, StudioServer
from optimizer.studio.session import Session
from tests.delta_cad.report.conftest import GRAPHICS, headless
from tests.delta_cad.report.live.test_page import free_port
from tests.optimizer.studio.tasks import JOYSTICK, until

pytestmark = pytest.mark.slow  # a minute where a processor draws the pictures
DRAWN_MS = 120_000  # the page lets no text be evaluated as a script: what is waited for is looked at from here
PHONE, DESK = {"width": 390, "height": 844}, {"width": 1440, "height": 900}
MOVES = """async (to) => {
  const range = document.getElementById("knob-requirements.envelope_width_mm");
  const from = Number(range.value);
  for (let k = 1; k <= 20; k++) {
    range.value = from + ((to - from) * k) / 20;
    range.dispatchEvent(new Event("input"));
    await new Promise((done) => setTimeout(done, 30));
  }
  range.dispatchEvent(new Event("change"));
  return studio.state().seq;
}"""


LINKED = """
  window.linked = 0;
  const link = WebGL2RenderingContext.prototype.linkProgram;
  WebGL2RenderingContext.prototype.linkProgram = function (...given) {
    window.linked += 1;
    return link.apply(this, given);
  };
"""


@pytest.fixture(scope="module")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[str, Path, Callable[[dict[str, Any]], None]]]:
    folder = tmp_path_factory.mktemp("studio")
    path = folder / "joystick.toml"
    path.write_text(JOYSTICK.read_text(encoding="utf-8"), encoding="utf-8")
    door = Door("127.0.0.1", free_port(), print, PROTOCOL)
    server = StudioServer(
        door, lambda: folder / "none", lambda: session.hello(), lambda *given: session.receive(*given)
    )
    session = Session(Document.read(path), path, folder / "out", server.send)
    server.begin()
    session.begin()
    try:
        yield door.url, path, server.send
    finally:
        server.close()
        session.close()


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with headless(*GRAPHICS) as found:
        yield found


@pytest.fixture
def live(browser: Any, studio: tuple[str, Path, Any]) -> Iterator[tuple[Any, list[str]]]:
    url, *_ = studio
    said: list[str] = []
    page = browser.new_page(viewport=DESK)
    page.set_default_timeout(DRAWN_MS)
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.on("request", lambda request: None if request.url.startswith((url, "data:")) else said.append(request.url))
    page.add_init_script(LINKED)
    page.goto(url)
    until(lambda: page.evaluate("document.body.dataset.state === 'proved'"))
    yield page, said
    page.close()


def test_a_slider_is_answered_while_it_moves_and_proved_at_rest(live: tuple[Any, list[str]]) -> None:
    page, said = live
    before = float(page.evaluate("document.body.dataset.side"))
    seq = page.evaluate(MOVES, 250)
    until(
        lambda: page.evaluate(
            f"document.body.dataset.state === 'proved' && Number(document.body.dataset.seq) === {seq}"
        )
    )
    assert float(page.evaluate("document.body.dataset.side")) < before - 2.0
    assert page.locator("#verdict").text_content() == "proved over the whole cube"
    assert page.evaluate("studio.answers.filter((one) => one.state === 'about').length") >= 1
    assert page.locator("#binding .bind").count() >= 2
    until(lambda: page.evaluate("document.getElementById('sliders').textContent.includes('mm of cube')"))
    page.click("#reset")
    assert said == []


def test_the_machine_is_drawn_at_once(live: tuple[Any, list[str]]) -> None:
    from PIL import Image

    page, said = live
    until(lambda: page.evaluate("Number(document.getElementById('view').dataset.drawn) >= 1"))
    shown = np.asarray(Image.open(BytesIO(page.locator("#view").screenshot())).convert("RGB"), dtype=float)
    orange = (shown[..., 0] > 170) & (shown[..., 1] < 160) & (shown[..., 2] < 100)
    assert orange.mean() > 0.003  # the upper arms
    assert said == []


def test_no_answer_compiles_a_shader(live: tuple[Any, list[str]]) -> None:
    page, said = live

    def linked_after_a_move(to_mm: float) -> int:
        drawn = page.evaluate("Number(document.getElementById('view').dataset.drawn)")
        page.evaluate(MOVES, to_mm)
        until(lambda: page.evaluate("Number(document.getElementById('view').dataset.drawn)") >= drawn + 2)
        return page.evaluate("window.linked")

    first = linked_after_a_move(262)  # all that an answer draws was drawn
    assert first > 0
    assert linked_after_a_move(256) == first
    page.click("#reset")
    assert said == []


def test_bad_input_is_said_and_nothing_is_lost(live: tuple[Any, list[str]]) -> None:
    page, said = live
    before = page.evaluate("JSON.stringify(studio.state().state.values)")
    page.evaluate(
        "() => { const e = document.getElementById('knob-requirements.peak_force_N'); e.value = 1;"
        " e.dispatchEvent(new Event('change')); }"
    )
    page.wait_for_selector("#said.error:not([hidden])")
    assert "peak_force_N" in page.locator("#said").text_content()
    assert page.evaluate("JSON.stringify(studio.state().state.values)") == before
    assert page.locator("#knob-requirements\\.peak_force_N").input_value() == "8"
    assert said == []


def test_save_writes_the_file(live: tuple[Any, list[str]], studio: tuple[str, Path, Any]) -> None:
    page, said = live
    page.evaluate(MOVES, 262)
    until(lambda: page.evaluate("document.getElementById('saved').textContent === 'not saved'"))
    page.click("#save")
    until(lambda: page.evaluate("document.getElementById('saved').textContent === 'saved'"))
    assert "envelope_width_mm = 262\n" in studio[1].read_text(encoding="utf-8")
    assert said == []


def test_nothing_is_wider_than_a_phone(live: tuple[Any, list[str]]) -> None:
    page, said = live
    page.set_viewport_size(PHONE)
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    box = page.locator("#view").bounding_box()
    assert box["y"] < 300.0  # the machine is seen first
    assert box["height"] > 300.0
    page.evaluate("window.scrollTo(0, 1500)")
    assert 0.0 <= page.locator("#headline").bounding_box()["y"] < 10.0  # the answer stays beside the sliders
    assert said == []


def test_a_build_shows_its_step_how_far_it_is_and_the_verdict(
    live: tuple[Any, list[str]], studio: tuple[str, Path, Any]
) -> None:
    page, said = live
    progress = Progress("running", now="5.03:1", at={"step": 3, "of": 4, "name": "lengths", "best": "80 mm of cube"})
    for verdict, left_s, width in (("", {}, ""), ("", {"done": 1, "total": 2}, "62.5%"), ("infeasible: x", {}, "")):
        progress.verdict = verdict
        studio[2]({"type": "build", **progress.record(), "at": progress.at | left_s})
        until(lambda: page.locator("#build-now").text_content() == (verdict or "step 3 of 4, lengths"))  # noqa: B023
        assert page.locator("#build-doing").text_content() == "best so far 80 mm of cube · 5.03:1"
        until(lambda: page.evaluate("document.querySelector('#bar span').style.width") == width)  # noqa: B023
    studio[2]({"type": "build", **Progress("built", facts={"cube_side_mm": 80.0, "motor": "m", "ratio": 5.0}).record()})
    until(lambda: page.locator("#build-now").text_content() == "cube 80.00 mm, m at 5:1, all checks pass")
    assert said == []
