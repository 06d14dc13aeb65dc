"""A session: only the newest setting is solved, what is proved is said so, saving and refusing lose nothing."""

from __future__ import annotations

import tomllib
from pathlib import Path
from threading import Event, Thread

import pytest

from optimizer.codesign.candidate import first_corrections
from optimizer.codesign.lengths import CONVERGED
from optimizer.studio import background, knobs, model
from optimizer.studio.background import AbandonedError, Background, StoppedError
from optimizer.studio.knobs import legal
from optimizer.studio.session import Newest
from tests.optimizer.studio.tasks import joystick, session, until
from tests.terminal import HANGS_S


def test_of_what_comes_faster_than_it_is_taken_only_the_newest_is() -> None:
    place = Newest[int]()
    for number in range(100):
        place.put(number)
    assert (place.take(0.0), place.take(0.0)) == (99, None)
    taken: list[int | None] = []
    waiting = Thread(target=lambda: taken.append(place.take()))
    waiting.start()
    place.put(7)
    waiting.join(HANGS_S)
    assert taken == [7]
    ended = Thread(target=lambda: taken.append(place.take()))
    ended.start()
    place.close()
    ended.join(HANGS_S)
    assert taken == [7, None]


def test_a_slider_is_answered_about_and_proved_once_it_rests(tmp_path: Path) -> None:
    with session(tmp_path) as (one, kept):
        one.begin()
        until(lambda: kept.of("answer", state="proved"))
        for number in range(1, 41):
            values = {knobs.WIDTH: 270.0 - 0.5 * number}
            one.receive({"type": "set", "seq": number, "values": values, "rest": number == 40}, "me")
        (proved,) = until(lambda: kept.of("answer", by=["me", 40], state="proved"))[:1]
        answered = [message["by"][1] for message in kept.of("answer") if message["by"][0] == "me"]
        assert answered == sorted(answered)  # never an older one after a newer
        assert len(set(answered)) < 40  # what was overtaken was not solved
        details = until(lambda: kept.of("details", by=["me", 40]))[0]
        assert details["prices"][knobs.WIDTH]["gain"] > 0.0
    task = joystick(placed=True, requirements__envelope_width_mm=250.0)
    cold = model.cold(model.Task(task.brief, one.hardware[0]), one._solver.corrections(task))
    assert cold is not None
    assert proved["side_mm"] == pytest.approx(cold.side_mm, rel=2.0 * CONVERGED)
    assert proved["took_ms"] > 0.0
    assert {piece["link"] for piece in proved["body"]} >= {"base", "platform", "upper_arm_0"}


def test_proved_is_only_what_the_proof_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(model, "certify", lambda _: model.Proved(False, ("kappa",), 1))
    with session(tmp_path) as (one, kept):
        one.begin()
        opened = until(lambda: kept.of("answer", state="open"))[0]
        assert opened["open"] == ["condition number"]
        assert kept.of("answer", state="proved") == []


def test_what_no_machine_meets_is_said_and_the_page_goes_on(tmp_path: Path) -> None:
    with session(tmp_path) as (one, kept):
        one.begin()
        until(lambda: kept.of("answer", state="proved"))
        one.receive({"type": "set", "seq": 1, "values": {knobs.MASS: 0.1}, "rest": True}, "me")
        until(lambda: kept.of("nothing", by=["me", 1], state="none"))
        one.receive({"type": "set", "seq": 2, "values": {knobs.MASS: 0.4}, "rest": True}, "me")
        until(lambda: kept.of("answer", by=["me", 2], state="proved"))


def test_a_limit_that_would_be_enough_is_the_least_of_those_tried() -> None:
    task = joystick(feel__effective_mass_max_kg=0.1)
    known = model.Solver().corrections(task)
    value = background.relief(lambda: None, task, knobs.MASS, 1, known)
    assert value is not None
    assert 0.1 < value <= 0.4
    enough = joystick(feel__effective_mass_max_kg=value)
    assert model.cold(enough, known) is not None
    assert model.cold(joystick(feel__effective_mass_max_kg=value / 1.5), known) is None
    assert background.relief(lambda: None, task, knobs.FORCE, -1, known) is None


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ({"values": {knobs.FORCE: 15.0}}, "peak_force_N"),
        ({"values": {knobs.KAPPA: "wide"}}, "condition number"),
        ({"values": {"requirements.name": 3.0}}, "no slider"),
        ({"values": {knobs.WIDTH: None}}, "outline width"),
        ({"hardware": {"motor": "none"}}, "motor"),
        ({"hardware": {"ratio": float("nan")}}, "ratio"),
    ],
)
def test_what_is_wrong_is_said_and_changes_nothing(tmp_path: Path, message: dict, words: str) -> None:
    with session(tmp_path) as (one, kept):
        before = one.setting
        one.receive({"type": "set", "seq": 1, **message}, "me")
        (said,) = kept.of("say", kind="error")
        assert words in said["text"]
        assert one.setting == before


@pytest.mark.parametrize("message", [{}, {"type": "quit"}, {"type": "set"}, {"type": "set", "seq": 1, "values": 3}])
def test_what_is_no_message_is_refused(tmp_path: Path, message: dict) -> None:
    with session(tmp_path) as (one, _), pytest.raises(ValueError, match="no"):
        one.receive(message, "me")


def test_values_stay_within_their_sliders(tmp_path: Path) -> None:
    with session(tmp_path) as (one, _):
        assert legal(one.knobs, {knobs.WIDTH: 1e6, knobs.MASS: None}) == {knobs.WIDTH: 600.0, knobs.MASS: None}


def test_saving_writes_what_was_set_and_keeps_what_others_wrote(tmp_path: Path) -> None:
    with session(tmp_path) as (one, kept):
        values = {knobs.FORCE: 2.5, knobs.FRICTION: None}
        one.receive({"type": "set", "seq": 1, "values": values, "hardware": {"ratio": 5.0, "placed": False}}, "me")
        assert kept.of("state")[-1]["saved"] is False
        one.receive({"type": "save"}, "me")
        text = (tmp_path / "req.toml").read_text(encoding="utf-8")
        data = tomllib.loads(text)
        assert (data["requirements"]["force_N"], data["hardware"]["capstan_ratio"]) == (2.5, 5.0)
        assert (data["placement"], "friction_max_N" in data["feel"]) == ("symmetric", False)
        assert "# for ever, beside the weight" in text
        assert kept.of("state")[-1]["saved"] is True
        (tmp_path / "req.toml").write_text(text + "# by another hand\n", encoding="utf-8")
        one.receive({"type": "set", "seq": 2, "values": {knobs.FORCE: 2.0}}, "me")
        one.receive({"type": "save"}, "me")
        assert (tmp_path / "req.toml").read_text(encoding="utf-8").endswith("# by another hand\n")
        assert tomllib.loads((tmp_path / "req-2.toml").read_text(encoding="utf-8"))["requirements"]["force_N"] == 2.0
        assert "req-2.toml" in kept.of("say", kind="saved")[-1]["text"]


def test_a_viewer_that_comes_later_gets_all_that_is_known(tmp_path: Path) -> None:
    with session(tmp_path) as (one, kept):
        one.begin()
        until(lambda: kept.of("details"))
        kinds = {message["type"] for message in one.hello()}
        assert {"hello", "state", "answer", "details", "build"} <= kinds


def test_the_other_core_drops_a_piece_that_is_not_wanted_and_ends() -> None:
    other, ended, failed = Background(), Event(), list[BaseException]()
    task = joystick()
    known, found = first_corrections(task.brief, task.choice), model.Solver().settle(task)
    assert found is not None
    assert other.compute(background.cold, task, known).side_mm == pytest.approx(found.side_mm, rel=1e-3)

    def long() -> None:
        try:
            other.compute(background.parts, found)
        except BaseException as error:
            failed.append(error)
        ended.set()

    Thread(target=long, daemon=True).start()
    until(lambda: other._number == 2)
    other.abandon()
    assert ended.wait(HANGS_S)
    assert isinstance(failed[0], AbandonedError)
    other.close()
    with pytest.raises(StoppedError):
        other.compute(background.cold, task, known)
