"""`design` from the command line, with the search and the build put in place: what it writes, says and returns."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import sleep
from typing import Any, cast

import pytest

from delta_cad.checks.clearance.clearance import MeshClearance
from delta_cad.checks.report import CheckResult
from delta_cad.commands import pipeline
from delta_cad.commands.pipeline import BuiltMachine, Moved, Outcome
from delta_cad.common.ours import write_record
from delta_cad.design import Design, design_hash, load_design
from delta_cad.dimensions import dimensions
from optimizer.certify.certificate import verify
from optimizer.certify.file import read_certificate
from optimizer.codesign import candidate, nearest
from optimizer.codesign.bound import Bound, Family
from optimizer.codesign.candidate import Candidate, Start
from optimizer.codesign.choice import Choice
from optimizer.codesign.lessons import Lessons, reference
from optimizer.codesign.nearest import Relief
from optimizer.codesign.search import Search
from optimizer.commands import cli
from optimizer.commands import design as command
from tests.committed import BEST, Built
from tests.delta_cad.report.reading import Page

BRIEF = """
name = "synthesized"
[requirements]
envelope_width_mm = 270
envelope_depth_mm = 220
[feel]
kappa_max = 2.27
[hardware]
motor = "maxon-re30-310007"
drive = "capstan"
"""
LENGTHS = (91.0, 143.196, 31.0, 24.0, 64.37, 43.165)
CHOICE = Choice("maxon-re30-310007", "capstan", 4.8, 54.0)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "task.toml"
    path.write_text(BRIEF, encoding="utf-8")
    return path


def call(*words: str | Path) -> int:
    return cli.main(["design", *map(str, words)])


@pytest.fixture
def paper_build(built: Built, monkeypatch: pytest.MonkeyPatch) -> None:
    """The one real build stands for what is built."""

    def build(design: Design, out: Path, *_: object, beside: Callable[[Path, Outcome], None], **_k: object) -> Outcome:
        folder = out / design.name
        folder.mkdir(parents=True)
        checks = [
            CheckResult("kappa", True, 2.2699, 2.27, ""),
            CheckResult("effective mass", True, 0.46, None, "kg"),
            CheckResult("envelope width", True, 247.9, 270.0, "mm"),
            CheckResult("envelope depth", True, 219.5, 220.0, "mm"),
        ]
        masses = json.loads((built.folder / "mass_properties.json").read_text(encoding="utf-8"))
        masses["input_sha256"] = design_hash(design)
        (folder / "mass_properties.json").write_text(json.dumps(masses), encoding="utf-8")
        outcome = Outcome(design, checks, masses, folder, ())
        beside(folder, outcome)
        write_record(folder)
        return outcome

    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(command, "BOUND_S", 0.0)


def finds(monkeypatch: pytest.MonkeyPatch, then: Callable[[], None] = lambda: None) -> None:
    """Lets the search build the committed machine, and do something afterwards."""

    def best(search: Search) -> Any:
        search.lessons[CHOICE.motor, CHOICE.drive] = Lessons(reference(), why=("the wrists were too close",))
        search.standing = Candidate(load_design(BEST), CHOICE, LENGTHS, Lessons(reference()), 86.33)
        search.tried.stuck["faulhaber-3257g024cr capstan"] = "too weak"
        outcome = search.build(search.standing.design)
        then()
        return search.standing, outcome

    monkeypatch.setattr(Search, "best", best)


@pytest.mark.usefixtures("paper_build")
def test_what_was_found_stands_in_its_folder(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--json") == 0
    told = json.loads(capsys.readouterr().out)
    assert told["cube_side_mm"] == pytest.approx(86.33, abs=0.01)
    assert told["outline_mm"] == [247.9, 219.5]
    assert told["binding"] == ["kappa", "envelope depth"]
    folder = Path(told["folder"])
    design = load_design(folder / "design.json")
    assert design.provenance is not None
    assert design.provenance["command"] == "python -m optimizer design task.toml --seed 0"
    certificate = read_certificate(folder / "certificate.json")
    assert "holding_torque" in verify(certificate, design).proved
    text = (folder / "design.md").read_text(encoding="utf-8")
    for words in ("86.33 mm", "maxon-re30-310007 at 4.8:1", "the wrists were too close", "too weak"):
        assert words in text
    assert "- effective mass: 0.46 kg\n" in text
    assert "requirements.envelope_depth_mm = 225 instead of 220" in text
    assert "feel.kappa_max" in text
    assert "- kappa: 2.27, 2.27 asked" in text
    page = Page((folder / "design.html").read_text(encoding="utf-8"))
    assert page.all("circle", **{"class": "passed"})[0].text.startswith("maxon-re30-310007 capstan at 4.8:1")
    assert "the wrists were too close" in page.one("learnt").text
    assert any(row[0] == "requirements.envelope_depth_mm" for row in page.rows("costs"))


def test_a_build_takes_over_the_machine_whose_moving_parts_were_looked_at(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    design, clearance, given = load_design(BEST), MeshClearance([], []), dict[str, Any]()
    machine = BuiltMachine(dimensions(design), *(cast(Any, None),) * 3)

    def build(
        stated: Design, out: Path, *_: object, made: BuiltMachine, clearance: MeshClearance, **_k: object
    ) -> Outcome:
        given.update(stated=stated, made=made, clearance=clearance)
        return Outcome(stated, [CheckResult("clearance", False, 1.2, 2.0, "mm")], {}, out, ())

    def best(search: Search) -> None:
        search.moving(design)
        search.build(design)

    monkeypatch.setattr(candidate, "solid", lambda _: machine)
    monkeypatch.setattr(pipeline, "check_moving", lambda *_: Moved([], clearance))
    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(nearest, "reliefs", lambda _: [])
    monkeypatch.setattr(Search, "best", best)
    call(file, "--out", tmp_path / "out")
    assert given["clearance"] is clearance
    assert given["made"].dimensions.design is given["stated"]  # which says where it comes from
    assert given["stated"].provenance["program"] == "optimizer design"


def test_what_fails_its_checks_keeps_its_design_file(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch)

    def build(design: Design, out: Path, *_: object, beside: Callable[[Path, Outcome], None], **_k: object) -> Outcome:
        folder = out / f"{design.name}.rejected"
        folder.mkdir(parents=True)
        outcome = Outcome(design, [CheckResult("clearance", False, 1.2, 2.0, "mm")], {}, folder, ())
        beside(folder, outcome)
        return outcome

    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(nearest, "reliefs", lambda _: [])
    assert call(file, "--out", tmp_path / "out") == 1
    assert "no machine does all that is asked" in capsys.readouterr().err
    folder = tmp_path / "out" / "synthesized.rejected"
    assert load_design(folder / "design.json").cube.half_side_mm == pytest.approx(43.165, abs=0.01)
    assert [one.name for one in folder.iterdir()] == ["design.json"]


def interrupt() -> None:
    raise KeyboardInterrupt


@pytest.mark.usefixtures("paper_build")
def test_stopped_by_hand_the_best_machine_stays(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch, interrupt)
    assert call(file, "--out", tmp_path / "out") == 130
    said = capsys.readouterr()
    assert "the best machine so far stands in" in said.err
    assert (tmp_path / "out/synthesized/design.json").exists()


@pytest.mark.usefixtures("paper_build")
@pytest.mark.parametrize("listens", [True, False])
def test_stopped_while_the_bound_is_sought_the_machine_is_written(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, listens: bool
) -> None:
    def bounded(family: Family, side_mm: float, stop: Callable[[], bool], *_: object) -> Bound:
        os.kill(os.getpid(), signal.SIGINT)
        while not (listens and stop()):
            sleep(0.01)
        return Bound(1.2 * side_mm, 0.2, 1, family.kind, family.described())

    finds(monkeypatch)
    monkeypatch.setattr("optimizer.codesign.bound.bounded", bounded)
    monkeypatch.setattr(command, "BOUND_S", 60.0)
    assert call(file, "--out", tmp_path / "out") == 130
    assert "the best machine so far stands in" in capsys.readouterr().err
    folder = tmp_path / "out/synthesized"
    assert (folder / "design.json").exists()
    assert ("It is proved that no machine" in (folder / "design.md").read_text(encoding="utf-8")) is listens


@pytest.mark.usefixtures("paper_build")
def test_a_bound_that_says_nothing_is_not_told(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def bounded(family: Family, side_mm: float, *_: object) -> Bound:
        return Bound(600.0, 600.0 / side_mm - 1.0, 18, family.kind, family.described())

    finds(monkeypatch)
    monkeypatch.setattr("optimizer.codesign.bound.bounded", bounded)
    assert call(file, "--out", tmp_path / "out", "--json") == 0
    for page in ("design.md", "design.html"):
        text = (tmp_path / "out/synthesized" / page).read_text(encoding="utf-8")
        assert "600.00" not in text
        assert command.NO_BOUND in text


def test_stopped_before_a_machine_there_is_none(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def best(_: Search) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "best", best)
    assert call(file, "--out", tmp_path / "out") == 130
    said = capsys.readouterr().err
    assert "no machine was finished" in said
    assert "--resume" in said
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["synthesized.design.jsonl"]


def test_what_cannot_be_is_told_with_every_reason(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def best(search: Search) -> None:
        search.tried.stuck |= {"a capstan": "too weak", "b direct": "too wide"}

    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(nearest, "reliefs", lambda _: [])
    assert call(file, "--out", tmp_path / "out", "--json") == 1
    said = capsys.readouterr()
    assert json.loads(said.out)["contradiction"] == ["a capstan: too weak", "b direct: too wide"]
    assert said.err.count("too ") == 2


@pytest.mark.usefixtures("paper_build")
def test_of_what_cannot_be_the_limits_are_told_and_the_nearest_machine_is_built(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """A first change that is not enough is followed by a larger one, which knows why; another change does not."""
    asked: list[tuple[float, float | None]] = []
    key, known = (CHOICE.motor, CHOICE.drive), Lessons(reference(), elbow_angle_deg=30.0)
    begun, other = Lessons(reference(), elbow_angle_deg=20.0), Lessons(reference(), elbow_angle_deg=10.0)

    def reliefs(search: Search) -> list[Relief]:
        wide = search.brief.requirements.model_copy(update={"force_N": 2.0})
        return [
            Relief(
                ("requirements.force_N",),
                (3.0,),
                (2.0,),
                search.brief.model_copy(update={"requirements": wide}),
                Start(CHOICE, LENGTHS, replace(begun, why=("of a trial",))),
            ),
            Relief(
                ("feel.kappa_max",),
                (2.27,),
                (2.4,),
                search.brief.model_copy(update={"feel": search.brief.feel.model_copy(update={"kappa_max": 2.4})}),
                Start(CHOICE, LENGTHS, other),
            ),
        ]

    def built(search: Search, choice: Choice, _: float, start: tuple[float, ...]) -> None:
        asked.append((search.brief.requirements.force_N, search.brief.feel.kappa_max))
        assert (choice, start) == (CHOICE, LENGTHS)
        if len(asked) == 1:
            assert search.lessons == {key: begun}
            search.lessons[key] = known
        elif len(asked) == 2:
            assert search.lessons == {key: other}
        else:
            assert search.lessons[key] is known
            search.standing = Candidate(load_design(BEST), CHOICE, LENGTHS, Lessons(reference()), 86.33)
            search.build(search.standing.design.model_copy(update={"name": search.brief.name}))

    monkeypatch.setattr(Search, "best", lambda _: None)
    monkeypatch.setattr(
        Search, "refined", lambda _, choice: Candidate(load_design(BEST), choice, LENGTHS, Lessons(reference()), 0.0)
    )
    monkeypatch.setattr(Search, "built", built)
    monkeypatch.setattr(nearest, "reliefs", reliefs)
    assert call(file, "--out", tmp_path / "out", "--json") == 1
    said = capsys.readouterr()
    told = json.loads(said.out)
    assert told["contradiction"] == ["requirements.force_N = 2 instead of 3", "feel.kappa_max = 2.4 instead of 2.27"]
    assert told["nearest"]["folder"] == str(tmp_path / "out/synthesized-nearest")
    assert "the nearest machine stands in" in said.err
    assert asked == [(2.0, 2.27), (3.0, 2.4), (pytest.approx(2.0 / 1.12), 2.27)]
    assert not list((tmp_path / "out").glob("*.jsonl"))


@pytest.mark.usefixtures("paper_build")
def test_an_interrupted_run_goes_on_from_its_journal(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch, interrupt)
    assert call(file, "--out", tmp_path / "out") == 130
    kept = (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8")
    capsys.readouterr()
    finds(monkeypatch)
    monkeypatch.setattr(pipeline, "build", lambda *_: pytest.fail("it stands already"))
    assert call(file, "--out", tmp_path / "out", "--resume", "--json") == 0
    assert json.loads(capsys.readouterr().out)["cube_side_mm"] == pytest.approx(86.33, abs=0.01)
    assert (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8") == kept
    assert not list((tmp_path / "out").glob("*.jsonl"))


@pytest.mark.usefixtures("paper_build")
def test_a_run_whose_time_is_over_can_be_gone_on_with(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--minutes", "1e-9", "--json") == 0
    assert list((tmp_path / "out").glob("*.jsonl"))
    capsys.readouterr()


def test_bad_input_is_told_before_anything_begins(tmp_path: Path, capsys) -> None:
    wrong = tmp_path / "wrong.toml"
    wrong.write_text('name = "x"\n[requirements]\nforce_N = -1\n[hardware]\nmotor = "none"\n', encoding="utf-8")
    assert call(wrong, "--out", tmp_path / "out") == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) >= 2
    assert any("force_N = -1" in line for line in lines)
    good = tmp_path / "good.toml"
    good.write_text(BRIEF, encoding="utf-8")
    in_the_way = tmp_path / "file"
    in_the_way.write_text("", encoding="utf-8")
    assert call(good, "--out", in_the_way) == 2
    with pytest.raises(SystemExit) as ended:
        call(good, "--minutes", "0")
    assert ended.value.code == 2
