"""`design` from the command line, with the search and the build put in place: what it writes, says and returns.

When its time ends, or Ctrl-C comes: its verdict, what stands, and the command that goes on.

14 s of processor: masses, costs and certificate of the committed machine are computed.
"""

from __future__ import annotations

import json
import os
import shutil
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import sleep
from typing import Any, cast

import pytest

from delta_cad.checks.clearance.clearance import MeshClearance
from delta_cad.checks.range.feel import poor_figures
from delta_cad.checks.report import CheckResult
from delta_cad.commands import pipeline
from delta_cad.commands.pipeline import BuiltMachine, Moved, Outcome
from delta_cad.common import worker_process
from delta_cad.common.worker_process import WorkerProcess
from delta_cad.design import Design, load_design
from delta_cad.dimensions import dimensions
from optimizer.certify.certificate import verify
from optimizer.certify.file import read_certificate
from optimizer.codesign import candidate, relaxation, report
from optimizer.codesign.bound import Bound, Family
from optimizer.codesign.candidate import Candidate, Start
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.relaxation import Relaxation, costs
from optimizer.codesign.report import certificate_of, results_of
from optimizer.codesign.run import GRACE_S, HURRIED, NO_BOUND
from optimizer.codesign.search import Search
from optimizer.commands import design as command
from optimizer.search.clock import OutOfTimeError
from tests.committed import BEST
from tests.delta_cad.report.reading import Page
from tests.optimizer.commands.paper import BRIEF, CHOICE, LENGTHS, bound_of, call, finds, interrupt


@pytest.mark.usefixtures("paper_build")
def test_what_was_found_stands_in_its_folder(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """What limits cost, results and certificate are those of the committed machine."""
    monkeypatch.setattr(worker_process, "WorkerProcess", WorkerProcess)
    monkeypatch.setattr("optimizer.codesign.relaxation.costs", costs)
    monkeypatch.setattr(report, "results_of", results_of)
    monkeypatch.setattr(report, "certificate_of", certificate_of)
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--minutes", "12", "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["cube_side_mm"] == pytest.approx(86.33, abs=0.01)
    assert reported["outline_mm"] == [247.9, 219.5]
    assert (reported["verdict"], reported["passed"]) == ("built", True)
    assert reported["binding"] == ["requirements.envelope_depth_mm", "feel.kappa_max"]  # limits of the file alone
    assert 3.0 <= reported["force_N"] < reported["peak_force_N"]
    assert reported["friction_max_N"] > 0.0  # though no limit is set
    folder = Path(reported["folder"])
    design = load_design(folder / "design.json")
    assert design.provenance is not None
    assert design.provenance["command"] == "python -m optimizer design task.toml --seed 0 --minutes 12"
    certificate = read_certificate(folder / "certificate.json")
    assert "holding_torque" in verify(certificate, design).proved
    text = (folder / "design.md").read_text(encoding="utf-8")
    for words in ("86.33 mm", "maxon-re30-310007 at 4.8:1", "the wrists were too close", "too weak"):
        assert words in text
    assert "- effective mass 0.46 kg\n" in text
    assert "requirements.envelope_depth_mm = 225 instead of 220" in text
    assert "feel.kappa_max" in text
    assert "- condition number 2.27, at most 2.27 set\n" in text
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

    monkeypatch.setattr(candidate, "solid", lambda *_: machine)
    monkeypatch.setattr(pipeline, "check_moving", lambda *_: Moved([], clearance))
    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(relaxation, "minimal_relaxations", lambda _: [])
    monkeypatch.setattr(Search, "best", best)
    call(file, "--out", tmp_path / "out")
    assert given["clearance"] is clearance
    assert given["made"].dimensions.design is given["stated"]  # which says where it comes from
    assert given["stated"].provenance["program"] == "optimizer design"


def test_what_fails_its_checks_keeps_its_design_file(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch, left=["maxon-re30-310009 capstan"])

    def build(design: Design, out: Path, *_: object, adjacent: Callable[[Path, Outcome], str], **_k: object) -> Outcome:
        folder = out / f"{design.name}.rejected"
        folder.mkdir(parents=True)
        outcome = Outcome(design, [CheckResult("clearance", False, 1.2, 2.0, "mm")], {}, folder, ())
        adjacent(folder, outcome)
        return outcome

    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(relaxation, "minimal_relaxations", lambda _: [])
    assert call(file, "--out", tmp_path / "out") == 4
    assert capsys.readouterr().out.startswith("not found in time: ")
    folder = tmp_path / "out" / "synthesized.rejected"
    assert load_design(folder / "design.json").cube.half_side_mm == pytest.approx(43.165, abs=0.01)
    assert [one.name for one in folder.iterdir()] == ["design.json"]


@pytest.mark.usefixtures("paper_build")
def test_stopped_by_hand_the_best_machine_stays(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch, interrupt)
    out = tmp_path / "out"
    assert call(file, "--out", out) == 4
    said = capsys.readouterr().out.splitlines()
    assert said[0].startswith("stopped: ")
    assert said[1] == f"python -m optimizer design {file} --out {out} --resume"
    assert said[-2:] == [f"files in {out / 'synthesized'}", f"open {out / 'synthesized' / 'report.html'}"]
    assert (tmp_path / "out/synthesized/design.json").exists()


@pytest.mark.usefixtures("paper_build")
@pytest.mark.parametrize(("number", "listens"), [(signal.SIGINT, True), (signal.SIGINT, False), (signal.SIGTERM, True)])
def test_stopped_while_the_bound_is_searched_the_machine_is_written(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, number: int, listens: bool
) -> None:
    def bounded(family: Family, side_mm: float, stop: Callable[[], bool], *_: object) -> Bound:
        os.kill(os.getpid(), number)
        while not (listens and stop()):
            sleep(0.01)
        return bound_of(family, 1.2, side_mm)

    finds(monkeypatch)
    monkeypatch.setattr("optimizer.codesign.bound.bounded", bounded)
    assert call(file, "--out", tmp_path / "out", "--json") == 4
    assert json.loads(capsys.readouterr().out)["verdict"] == "stopped"
    folder = tmp_path / "out/synthesized"
    assert (folder / "design.json").exists()
    assert ("It is proved that no machine" in (folder / "design.md").read_text(encoding="utf-8")) is listens


@pytest.mark.usefixtures("paper_build")
def test_a_bound_that_says_nothing_is_not_reported(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "optimizer.codesign.bound.bounded", lambda family, side, *_: bound_of(family, 600.0 / side, side)
    )
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--json") == 0
    for page in ("design.md", "design.html"):
        text = (tmp_path / "out/synthesized" / page).read_text(encoding="utf-8")
        assert "600.00" not in text
        assert NO_BOUND in text


def test_stopped_before_a_machine_there_is_none(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def best(_: Search) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Search, "best", best)
    assert call(file, "--out", tmp_path / "out", "--seed", "3", "--minutes", "2.5", "--json") == 4
    said = capsys.readouterr()
    reported = json.loads(said.out)
    assert (reported["verdict"], reported["passed"], reported["cube_side_mm"]) == ("stopped", False, None)
    assert "contradiction" not in reported
    again = f"python -m optimizer design {file} --out {tmp_path / 'out'} --seed 3 --minutes 2.5 --json --resume"
    assert said.err.splitlines()[-1] == again
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["synthesized.design.jsonl"]


def test_what_cannot_be_is_reported_with_every_reason(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def best(search: Search) -> None:
        search.log.no_progress |= {"a capstan": "too weak", "b direct": "too wide"}

    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(relaxation, "minimal_relaxations", lambda _: [])
    assert call(file, "--out", tmp_path / "out", "--json") == 1
    said = capsys.readouterr()
    reported = json.loads(said.out)
    assert (reported["verdict"], reported["passed"], reported["nearest"]) == ("infeasible", False, None)
    assert reported["contradiction"] == ["a capstan: too weak", "b direct: too wide"]
    first = next(line for line in said.err.splitlines() if line.startswith("infeasible: task.toml: "))
    assert "none of 2 motors and drives has a machine; no proof, as lengths are local optima" in first
    assert said.err.count("too ") == 2


@pytest.mark.usefixtures("paper_build")
@pytest.mark.parametrize("stated", [True, False])
def test_a_machine_that_is_worse_than_a_default_that_was_left_out_is_poor(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, stated: bool
) -> None:
    """Its 0.76 kg are more than 3 N move well; where the file sets a limit, they are what the user wants."""
    monkeypatch.setattr(pipeline, "poor_figures", poor_figures)
    finds(monkeypatch, required={"effective_mass_max_kg": 0.8, "friction_max_N": 3.0} if stated else {})
    assert call(file, "--out", tmp_path / "out") == 0
    first = capsys.readouterr().out.splitlines()[0]
    assert first.startswith("built: holds, but poor as a haptic device: ") is not stated
    assert ("effective mass 0.76 kg, at most 0.6" in first) is not stated
    assert ("continuous force" in first) is stated


@pytest.mark.usefixtures("paper_build")
def test_of_what_cannot_be_the_limits_are_reported_and_the_nearest_machine_is_built(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """A first change that is not enough is followed by a larger one, which knows why; another change does not."""
    required: list[tuple[float, float | None]] = []
    key, known = (CHOICE.motor, CHOICE.drive), Corrections(reference(), elbow_angle_deg=30.0)
    begun, other = (Corrections(reference(), elbow_angle_deg=20.0), Corrections(reference(), elbow_angle_deg=10.0))

    def minimal_relaxations(search: Search) -> list[Relaxation]:
        wide = search.brief.requirements.model_copy(update={"force_N": 2.0})
        return [
            Relaxation(
                ("requirements.force_N",),
                (3.0,),
                (2.0,),
                search.brief.model_copy(update={"requirements": wide}),
                Start(CHOICE, LENGTHS, replace(begun, why=("of a trial",))),
            ),
            Relaxation(
                ("feel.kappa_max",),
                (2.27,),
                (2.4,),
                search.brief.model_copy(update={"feel": search.brief.feel.model_copy(update={"kappa_max": 2.4})}),
                Start(CHOICE, LENGTHS, other),
            ),
        ]

    def built(search: Search, choice: Selection, _: float, start: tuple[float, ...]) -> None:
        required.append((search.brief.requirements.force_N, search.brief.feel.kappa_max))
        assert (choice, start) == (CHOICE, LENGTHS)
        if len(required) == 1:
            assert search.corrections == {key: begun}
            search.corrections[key] = known
        elif len(required) == 2:
            assert search.corrections == {key: other}
        else:
            assert search.corrections[key] is known
            search.built_candidate = Candidate(load_design(BEST), CHOICE, LENGTHS, Corrections(reference()), 86.33)
            search.build(search.built_candidate.design.model_copy(update={"name": search.brief.name}))

    monkeypatch.setattr(Search, "best", lambda search: search.log.no_progress.update({"a capstan": "too weak"}))
    monkeypatch.setattr(
        Search,
        "refined",
        lambda _, choice: Candidate(load_design(BEST), choice, LENGTHS, Corrections(reference()), 0.0),
    )
    monkeypatch.setattr(Search, "built", built)
    monkeypatch.setattr(relaxation, "minimal_relaxations", minimal_relaxations)
    assert call(file, "--out", tmp_path / "out", "--json") == 1
    said = capsys.readouterr()
    reported = json.loads(said.out)
    assert reported["verdict"] == "infeasible"
    assert reported["contradiction"] == [
        "requirements.force_N = 2 instead of 3",
        "feel.kappa_max = 2.4 instead of 2.27",
    ]
    assert reported["nearest"]["folder"] == str(folder := tmp_path / "out/synthesized-nearest")
    assert f"the nearest machine stands in {folder}, with requirements.force_N = 1.786 instead of 3" in said.err
    assert required == [(2.0, 2.27), (3.0, 2.4), (pytest.approx(2.0 / 1.12), 2.27)]
    assert not list((tmp_path / "out").glob("*.jsonl"))


@pytest.mark.parametrize("stopped", [True, False])
def test_the_verdict_is_printed_before_the_nearest_machine_is_searched(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, stopped: bool
) -> None:
    """Ctrl-C then ends what comes after it, and the verdict stays."""
    said = list[str]()

    def minimal_relaxations(_: Search) -> list[Relaxation]:
        said.extend(capsys.readouterr().out.splitlines())
        if stopped:
            raise KeyboardInterrupt
        return []

    monkeypatch.setattr(Search, "best", lambda search: search.log.impossible.append("force_N must be at most 20 N"))
    monkeypatch.setattr(relaxation, "minimal_relaxations", minimal_relaxations)
    assert call(file, "--out", tmp_path / "out") == 1
    assert said[0] == "infeasible: task.toml: force_N must be at most 20 N"
    known = "not possible as stated; looking for limits whose change makes one possible"
    assert said[1:] == [known]
    after = capsys.readouterr().out.splitlines()
    last = f"design {file} --out {tmp_path / 'out'} --resume" if stopped else "up to a factor of 10 was enough"
    assert [line.endswith(last) for line in after] == [True]
    assert bool(list((tmp_path / "out").glob("*.jsonl"))) is stopped


def test_where_no_eased_task_has_a_machine_it_is_said_how_far_limits_were_eased(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def minimal_relaxations(search: Search) -> list[Relaxation]:
        eased = search.brief.with_values({"requirements.force_N": 2.0})
        start = Start(CHOICE, LENGTHS, Corrections(reference()))
        return [Relaxation(("requirements.force_N",), (3.0,), (2.0,), eased, start)]

    forces = list[float]()
    monkeypatch.setattr(Search, "best", lambda search: search.log.no_progress.update({"a capstan": "too weak"}))
    monkeypatch.setattr(Search, "built", lambda search, *_: forces.append(search.brief.requirements.force_N))
    monkeypatch.setattr(relaxation, "minimal_relaxations", minimal_relaxations)
    assert call(file, "--out", tmp_path / "out") == 1
    said = "no machine passed every check with requirements.force_N changed up to 1.5 times further"
    assert capsys.readouterr().out.splitlines()[-1] == said
    assert min(forces) == pytest.approx(2.0 / 1.5)


@pytest.mark.usefixtures("paper_build")
def test_an_interrupted_run_goes_on_from_its_journal(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    finds(monkeypatch, interrupt)
    assert call(file, "--out", tmp_path / "out") == 4
    kept = (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8")
    capsys.readouterr()
    finds(monkeypatch)
    monkeypatch.setattr(pipeline, "build", lambda *_: pytest.fail("it stands already"))
    assert call(file, "--out", tmp_path / "out", "--resume", "--json") == 0
    assert json.loads(capsys.readouterr().out)["cube_side_mm"] == pytest.approx(86.33, abs=0.01)
    assert (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8") == kept
    assert not list((tmp_path / "out").glob("*.jsonl"))


def test_bad_input_is_reported_before_anything_begins(tmp_path: Path, capsys) -> None:
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


@pytest.mark.parametrize("end", ["time", "stopped", "gave up"])
def test_what_a_search_did_not_settle_is_not_infeasible(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, end: str
) -> None:
    """The time ends, Ctrl-C comes or a candidate is left that the search cannot mend: none shows that there is none."""

    def best(search: Search) -> None:
        search.log.no_progress["a capstan"] = "too weak"
        if end == "gave up":
            search.log.inconclusive.add("a capstan")
            return
        search.log.left = ["b direct"]
        raise OutOfTimeError if end == "time" else KeyboardInterrupt

    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(relaxation, "minimal_relaxations", lambda _: [])
    assert call(file, "--out", tmp_path / "out") == 4
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("stopped: " if end == "stopped" else "not found in time: ")
    assert ("a capstan" if end == "gave up" else "b direct") in lines[0]
    assert lines[1].endswith("--seed 1" if end == "gave up" else "--resume")
    assert bool(list((tmp_path / "out").glob("*.jsonl"))) == (end != "gave up")


@pytest.mark.usefixtures("paper_build")
def test_a_machine_that_stands_when_the_time_ends_is_built_and_what_was_left_is_named(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def ends() -> None:
        raise OutOfTimeError

    finds(monkeypatch, ends, left=["b direct"])
    assert call(file, "--out", tmp_path / "out") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("built: ")
    assert lines[1].endswith("--resume")
    assert "b direct" in lines[2]


@pytest.mark.usefixtures("paper_build")
def test_a_run_whose_time_is_over_can_be_gone_on_with_and_its_remarks_are_gone(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """In no time the machine is built as it was known, without a bound; with time its bound is proved."""
    monkeypatch.setattr("optimizer.codesign.bound.bounded", lambda family, side, *_: bound_of(family, 9.0, side))
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--minutes", "1e-9", "--json") == 0
    assert list((tmp_path / "out").glob("*.jsonl"))
    text = (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8")
    assert HURRIED in text
    assert NO_BOUND in text
    monkeypatch.setattr("optimizer.codesign.bound.bounded", lambda family, side, *_: bound_of(family, 1.01, side))
    shutil.rmtree(tmp_path / "out/synthesized")
    assert call(file, "--out", tmp_path / "out", "--resume", "--json") == 0
    text = (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8")
    assert HURRIED not in text
    assert NO_BOUND not in text
    capsys.readouterr()


def test_a_build_that_goes_on_beyond_its_time_is_ended_and_leaves_nothing(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """Of two minutes it may take 20 s more, on the clock of the search."""
    seconds = [0.0]

    def build(_design: Design, _out: Path, progress: Callable[[str], None], **_: object) -> Outcome:
        for seconds[0] in (119.0, 121.0, 139.0, 141.0):
            progress("solids")
        raise AssertionError

    finds(monkeypatch, left=["a capstan"])
    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(command, "_clock", lambda: lambda: seconds[0])
    assert call(file, "--out", tmp_path / "out", "--minutes", "2") == 4
    assert capsys.readouterr().out.startswith("not found in time: task.toml: not fully searched: a capstan\n")
    assert seconds == [141.0]


@pytest.mark.usefixtures("paper_build")
def test_a_bound_leaves_the_time_that_the_end_of_a_build_took_before(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """Of five minutes: of the first build nothing is known; it takes 7 s after its bound, which the second leaves."""
    seconds, stops, written = [200.0], list[list[bool]](), report.DesignReport.write

    def bounded(family: Family, side_mm: float, stop: Callable[[], bool], *_: object) -> Bound:
        looks = []
        for seconds[0] in (292.0, 294.0, 299.0, 301.0):
            looks.append(stop())
        stops.append(looks)
        return bound_of(family, 1.01, side_mm)

    def write(*given: Any) -> None:
        written(*given)
        seconds[0] += 7.0

    monkeypatch.setattr(report.DesignReport, "write", write)
    monkeypatch.setattr("optimizer.codesign.bound.bounded", bounded)
    monkeypatch.setattr(command, "_clock", lambda: lambda: seconds[0])
    finds(monkeypatch, times=2)
    assert call(file, "--out", tmp_path / "out", "--minutes", "5") == 0
    assert stops == [[False, False, False, True], [False, True, True, True]]
    capsys.readouterr()


@pytest.mark.usefixtures("paper_build")
def test_a_build_whose_bound_was_searched_is_ended_whatever_the_time(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """What is left are its last files, which take no longer than those of any other."""
    seconds, paper = [0.0], pipeline.build

    def build(design: Design, out: Path, progress: Callable[[str], None], **given: Any) -> Outcome:
        outcome = paper(design, out, progress, **given)
        seconds[0] = 120.0 + GRACE_S + 1.0
        progress("manifest")
        return outcome

    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(command, "_clock", lambda: lambda: seconds[0])
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--minutes", "2") == 0
    assert capsys.readouterr().out.startswith("built: ")
