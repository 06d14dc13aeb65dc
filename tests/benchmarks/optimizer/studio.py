"""The studio in a browser: answers a second while a slider moves, and how long after its rest a cube is proved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from statistics import median
from tempfile import TemporaryDirectory
from time import process_time, sleep
from typing import Any

from optimizer.studio.document import Document
from optimizer.studio.model import Solver, certify, hardware_of
from optimizer.studio.setting import Task
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT

SUBJECT = "studio"
MOVES, SECONDS, REST_S = 30, 1.0, 2.0
HANGS_MS = 20_000
ANSWERS, CERTIFIED_S, WARM_S = 10.0, 0.5, 0.1  # the budget's
MOVE = """async ([to, seconds]) => {
  const range = document.getElementById("knob-requirements.envelope_width_mm");
  const [from, began, before] = [Number(range.value), performance.now(), studio.answers.length];
  for (;;) {
    const share = Math.min(1, (performance.now() - began) / (1e3 * seconds));
    range.value = from + (to - from) * share;
    range.dispatchEvent(new Event("input"));
    if (share === 1) break;
    await new Promise((done) => setTimeout(done, 16));
  }
  const answers = (studio.answers.length - before) / seconds;
  const rested = performance.now();
  range.dispatchEvent(new Event("change"));
  const shown = document.body.dataset;
  const proved = () => shown.state === "proved" && Number(shown.seq) === studio.state().seq;
  while (!proved() && performance.now() - rested < HANGS_MS) await new Promise((done) => setTimeout(done, 4));
  return [answers, (performance.now() - rested) / 1e3];
}""".replace("HANGS_MS", str(HANGS_MS))


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    return [*_alone(say), *_in_a_browser(say)]


def _alone(say: Callable[[str], None]) -> list[Figure]:
    """Processor time of an answer, and of settling and proving one, without a page."""
    say("answers without a page")
    document = Document.read(ROOT / "joystick.toml")
    choice, solver = hardware_of(document.brief())[0], Solver()
    moving, resting, held = list[float](), list[float](), 0
    settled = solver.settle(Task(document.brief(), choice))
    assert settled is not None
    certify(settled)  # compiles
    for number in range(MOVES):
        task = Task(document.brief({"requirements.envelope_width_mm": 250.0 + (37 * number) % 40}), choice)
        before = process_time()
        assert solver.move(task) is not None
        between = process_time()
        found = solver.settle(task)
        assert found is not None
        held += certify(found).holds
        moving.append(between - before)
        resting.append(process_time() - between)
    note = "processor time; the outline's width jumps by up to 40 mm"
    return [
        of_repeats(SUBJECT, "warm lengths for a moved slider", moving, "s", WARM_S, note=note),
        Figure(SUBJECT, "settled lengths that are proved at the first try", held / MOVES, "", note="else once more"),
        of_repeats(SUBJECT, "lengths settled and proved", resting, "s", CERTIFIED_S, note=note),
    ]


def _in_a_browser(say: Callable[[str], None]) -> list[Figure]:
    from delta_cad.report.live.door import Door
    from optimizer.studio.server import PROTOCOL, StudioServer
    from optimizer.studio.session import Session
    from tests.delta_cad.report.conftest import GRAPHICS, headless
    from tests.delta_cad.report.live.test_page import free_port

    say("answers in a browser")
    with TemporaryDirectory() as folder, headless(*GRAPHICS) as browser:
        path = ROOT / "joystick.toml"
        door = Door("127.0.0.1", free_port(), say, PROTOCOL)
        session: Session
        server = StudioServer(door, lambda: Path(folder), lambda: session.hello(), lambda *one: session.receive(*one))
        session = Session(Document.read(path), path, Path(folder), server.send)
        server.begin()
        session.begin()
        try:
            page: Any = browser.new_page(viewport={"width": 1440, "height": 900})
            page.set_default_timeout(10 * HANGS_MS)
            page.goto(door.url)
            while (
                page.evaluate("document.body.dataset.state") != "proved"
            ):  # its policy lets no text be evaluated there
                sleep(REST_S / 10)
            sleep(REST_S)
            moves = []
            for number in range(MOVES):
                moves.append(page.evaluate(MOVE, [250 + (37 * number) % 40, SECONDS]))
                sleep(REST_S / 10)
        finally:
            server.close()
            session.close()
    say(f"median {median(rate for rate, _ in moves):.1f} answers a second")
    note = f"{MOVES} moves of the outline's width, {SECONDS:g} s each; pictures drawn by the processor"
    return [
        of_repeats(SUBJECT, "answers a second", [rate for rate, _ in moves], "1/s", ANSWERS, at_most=False, note=note),
        of_repeats(SUBJECT, "rest to a proved cube", [rested for _, rested in moves], "s", CERTIFIED_S, note=note),
    ]
