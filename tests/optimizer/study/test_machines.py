"""The front of machines: figures against other ways to compute them, what beats what, what is written."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.commands import pipeline
from delta_cad.common.console import ProgressLine
from delta_cad.common.files import require_room, whole_folder
from delta_cad.design import NAME_LONGEST, Design, design_hash, load_design
from delta_cad.mechanism.limits.effective_mass import effective_mass
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.search import Search
from optimizer.commands import cli
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.study.machines import (
    AXES,
    PAGE,
    Figures,
    MachinePoint,
    build_front,
    design_files,
    existing_builds,
    figures_of,
    front,
    machines_page,
    marked,
    record,
)
from tests.committed import BEST
from tests.delta_cad.report.reading import Page

CHOICE = Selection("maxon-re30-310007", "capstan", 4.8, 54.0)
LENGTHS = (91.0, 143.196, 31.0, 24.0, 64.37, 43.165)
FIGURES = Figures(80.0, (270.0, 220.0), 0.3, 0.6, 20.0, 2.2)


@pytest.fixture(scope="module")
def best() -> Design:
    return load_design(BEST)


def point(**changes: float) -> MachinePoint:
    return MachinePoint("asked", None, CHOICE, load_design(BEST), replace(FIGURES, **changes))


def test_figures_are_those_of_the_handle_over_the_cube(best: Design) -> None:
    candidate = Candidate(best, CHOICE, LENGTHS, Corrections(reference()), 86.33)
    found = figures_of(best, candidate, (0.1, 0.15))
    inertia = reference().inertia(91.0, 143.196, 4.8)
    axis = np.linspace(-43.165e-3, 43.165e-3, 31)
    x, y, z = np.meshgrid(axis, axis, axis + 64.37e-3 + 43.165e-3, indexing="ij")
    sampled = effective_mass(best.geometry, np.stack([x, y, z], axis=-1).reshape(-1, 3), inertia).max()
    assert sampled <= found.effective_mass_kg * (1.0 + 1e-9)
    assert found.effective_mass_kg == pytest.approx(sampled, rel=2e-3)
    assert found.kappa == pytest.approx(2.27, abs=1e-3)  # which the committed design is certified with
    assert found.cube_side_mm == 86.33
    assert found.outline_mm == (270.0, 220.0)
    assert found.stiffness_N_mm > 15.0


def test_a_machine_that_another_beats_is_not_on_the_front() -> None:
    points = [point(), point(cube_side_mm=79.0), point(cube_side_mm=79.0, friction_N=0.5), point(kappa=2.1)]
    assert [one.on_front for one in marked(points)] == [False, False, True, True]
    equal = marked([point(), point()])
    assert [one.on_front for one in equal] == [True, True]


Traced = tuple[list[MachinePoint], list[DesignBrief]]


def traced(best: Design, name: str) -> Traced:
    """A front whose candidates are given: less mass costs cube, and below 0.2 kg there is none."""
    required = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}
    task = brief_from_dict({"name": name, "requirements": required, "feel": {"effective_mass_max_kg": 0.4}})
    seen: list[DesignBrief] = []

    def candidate(side: float) -> Candidate:
        cube = best.cube.model_copy(update={"half_side_mm": side / 2.0})
        return Candidate(best.model_copy(update={"cube": cube}), CHOICE, LENGTHS, Corrections(reference()), side)

    def fixed_point(search: Search, *_: object, **__: object) -> Candidate | None:
        seen.append(search.brief)
        most = search.brief.feel.effective_mass_max_kg
        return None if most < 0.2 else candidate(70.0 + 10.0 * most)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Search, "fixed_point", fixed_point)
        patch.setattr(Search, "ranked", lambda _: [(80.0, CHOICE)])
        patch.setattr(Search, "refined", lambda _, __: candidate(80.0))
        search = Search(task, lambda _: None, lambda _: [], reference())  # type: ignore[arg-type,return-value]
        search.corrections[CHOICE.motor, CHOICE.drive] = Corrections(reference())
        points: list[MachinePoint] = []
        front(search, points)
    return marked(points), seen


@pytest.fixture(scope="module")
def trace(best: Design) -> Traced:
    """That front, of a brief "b"."""
    return traced(best, "b")


def test_a_front_that_is_cut_off_leaves_the_points_it_has(
    monkeypatch: pytest.MonkeyPatch, trace: Traced, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    known, _ = trace
    task = tmp_path / "b.toml"
    task.write_text('name = "b"\n[requirements]\nenvelope_width_mm = 270\nenvelope_depth_mm = 220\n', encoding="utf-8")

    def cut_off(_: Search, points: list[MachinePoint]) -> None:
        points += known[:2]
        raise KeyboardInterrupt

    monkeypatch.setattr("optimizer.study.machines.front", cut_off)
    assert cli.main(["front", str(task), "--machines", "--out", str(tmp_path)]) == 130
    assert capsys.readouterr().err.endswith(f"interrupted; 2 machines stand in {tmp_path}/b-machines\n")
    assert len(json.loads((tmp_path / "b-machines" / "machines.json").read_text())["points"]) == 2
    assert cli.main(["front", str(task), "--machines", "--resume"]) == 2


def test_each_limit_is_moved_by_itself_until_there_is_no_machine(trace: Traced) -> None:
    points, seen = trace
    moved = [one for one in points if one.axis == "effective_mass"]
    (required,) = [one for one in points if one.axis == "asked"]
    assert moved
    limits = [one.limit for one in moved]
    factors = next(axis for axis in AXES if axis.name == "effective_mass").factors
    expected = [required.figures.effective_mass_kg * factor for factor in factors]
    assert limits == pytest.approx([limit for limit in expected if limit >= 0.2])
    for one in seen:  # one limit alone differs from what was asked
        rest = [one.feel.effective_mass_max_kg != 0.4, one.feel.friction_max_N is not None]
        rest += [one.feel.stiffness_min_N_mm is not None, one.requirements.envelope_width_mm != 270.0]
        assert sum(rest) == 1
        assert (one.requirements.envelope_width_mm == 270.0) == (one.requirements.envelope_depth_mm == 220.0)


def test_every_point_has_a_design_file_that_its_line_builds(trace: Traced, tmp_path: Path) -> None:
    points, _ = trace
    files, text = design_files(points), machines_page(points, "b", "out/b-machines", {})
    assert len(files) == len(points)
    for (name, content), reported in zip(files.items(), record(points, "b")["points"], strict=True):
        (tmp_path / name).write_text(content, encoding="utf-8")
        assert load_design(tmp_path / name).cube.half_side_mm == pytest.approx(reported["cube_side_mm"] / 2.0)
        assert text.count(f"build --design out/b-machines/designs/{name}</code>") == 1
        assert reported["design"] == f"designs/{name}"
    assert json.loads(json.dumps(record(points, "b")))["schema"] == "delta-machines/1"
    assert len({load_design(tmp_path / name).name for name in files}) == len(files)  # each is built into its own folder


def test_the_design_of_a_long_name_can_be_read_back(
    monkeypatch: pytest.MonkeyPatch, best: Design, tmp_path: Path
) -> None:
    monkeypatch.setattr("optimizer.study.machines.AXES", AXES[:1])
    points, _ = traced(best, "b" * NAME_LONGEST)
    for name, text in design_files(points).items():
        (tmp_path / name).write_text(text, encoding="utf-8")
        assert load_design(tmp_path / name).name.startswith("bbb")


def test_each_point_of_the_page_opens_its_machine(trace: Traced, tmp_path: Path) -> None:
    """What stands of the very same design is opened, and told to fail where it does; else its line with the command."""
    points, _ = trace
    designs = {point.name: point.design for point in points}
    passes, fails, other = list(designs)[:3]
    for number, folder, failed in ((passes, "", []), (fails, ".rejected", ["clearance"]), (other, "", [])):
        place = tmp_path / f"{designs[number].name}{folder}"
        place.mkdir()
        (place / "report.html").touch()
        reported = {"input_sha256": "of another" if number == other else design_hash(designs[number]), "failed": failed}
        (place / "checks.json").write_text(json.dumps(reported), encoding="utf-8")
    built = existing_builds(designs, tmp_path)
    assert set(built) == {passes, fails}
    read = Page(machines_page(points, "b", "out/b-machines", built))
    links = [link.attributes["href"] for link in read.all("a")][2:]  # after those to the sections
    place = {passes: f"../{designs[passes].name}/report.html", fails: f"../{designs[fails].name}.rejected/report.html"}
    assert links[: 4 * len(points)] == [place.get(point.name, f"#{point.name}") for point in points] * 4
    rows = {row.attributes["id"]: row.text for row in read.all("tr") if "id" in row.attributes}
    assert set(rows) == set(designs)
    assert "passes every check" in rows[passes]
    assert "fails clearance" in rows[fails]
    assert f"build --design out/b-machines/designs/{other}.json" in rows[other]
    assert read.all("script") == []


@pytest.mark.parametrize(
    "content", ["[]", "{}", "1", "", '{"input_sha256": "HASH"}', '{"input_sha256": "HASH", "failed": 1}']
)
def test_checks_that_are_none_of_a_build_are_no_machine(best: Design, tmp_path: Path, content: str) -> None:
    place = tmp_path / best.name
    place.mkdir()
    (place / "report.html").touch()
    (place / "checks.json").write_text(content.replace("HASH", design_hash(best)), encoding="utf-8")
    assert existing_builds({"one": best}, tmp_path) == {}


def test_what_none_beats_is_built_once_and_linked(
    monkeypatch: pytest.MonkeyPatch, trace: Traced, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    points, _ = trace
    points = [replace(one, on_front=number < 3) for number, one in enumerate(points)]
    with whole_folder(tmp_path / "b-machines") as folder:
        (folder / PAGE).write_text("before its machines stand")
    on_front = [point.design for point in points[:3]]
    made: list[str] = []

    def build(design: Design, out: Path, _: object) -> None:
        made.append(design.name)
        if len(made) == 1:
            raise RuntimeError("no such solid")
        place = out / design.name
        place.mkdir()
        (place / "report.html").touch()
        reported = {"input_sha256": design_hash(design), "failed": []}
        (place / "checks.json").write_text(json.dumps(reported), encoding="utf-8")

    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr("delta_cad.commands.machine.geometry_errors", lambda: (RuntimeError,))
    for _ in range(2):  # the second finds all but the one that could not be made
        with ProgressLine() as line:
            build_front(points, "b", tmp_path, line)
    assert made == [*(one.name for one in on_front), on_front[0].name]
    require_room(tmp_path / "b-machines", folder=True)  # for the next front: the page is still ours
    assert "no such solid" in capsys.readouterr().err
    rows = {
        row.attributes["id"]: row.text
        for row in Page((tmp_path / "b-machines" / PAGE).read_text()).all("tr")
        if "id" in row.attributes
    }
    assert sum("passes every check" in text for text in rows.values()) == len(on_front)
