"""The feel sheet: summary, answers, page, files, exit codes, and the figures of other devices with their sources."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptics.feel.loops
import haptics.feel.sheet
from delta_cad import catalogue
from delta_cad.common.files import whole_folder
from delta_cad.design import design_from_dict
from delta_cad.drive import drive_torque
from delta_cad.mechanism import SingularError, inverse_kinematics, jacobian
from haptics.commands.cli import main
from haptics.control.controller import FORCE, fresh, tick
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.feel.holds import hold_facts, hold_markdown, holds
from haptics.feel.loop_page import quantum_bound
from haptics.feel.loops import DEFINITIONS, LoopSheet, loop_sheet
from haptics.feel.page import MAPS, feel_facts, feel_markdown, feel_text, map_values, reference_devices
from haptics.feel.sheet import (
    HARD,
    MASS_ERROR,
    RIGID,
    Feel,
    buzzes,
    feel,
    hard,
    joint_drive,
    stays,
)
from haptics.feel.summary import QUANTITIES
from haptics.loop.assumptions import joint_friction
from haptics.loop.choice import BOARD, DAMPED
from haptics.loop.hardware import board_controller
from haptics.loop.noise import NoiseFigures, NoiseRange
from haptics.loop.walls import proven_cap
from haptics.model.ball_joints import ball_friction_N
from haptics.model.hands import CORNERS
from haptics.model.machine import MachineModel
from haptics.model.motor_heat import hold_time, motor_heat
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import VirtualWall
from tests.committed import BEST, Built, changed
from tests.haptics.loop.noise.built import with_structure

DRAWN = (*MAPS, "z_width", "impedance")


@pytest.fixture(scope="module")
def loop(machine: MachineModel) -> LoopSheet:
    """The real one, of fewer hands and rates."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(haptics.feel.loops, "RATES_Hz", (1000.0, 8000.0))
        patch.setattr(haptics.feel.loops, "DAMPINGS", (0.0, 2.0))
        patch.setattr(haptics.feel.loops, "CORNERS", {"10010": CORNERS["10010"]})
        return loop_sheet(machine)


@pytest.fixture(scope="module")
def found(machine: MachineModel, loop: LoopSheet) -> Feel:
    return feel(machine, lambda _machine: loop)


def test_summary_is_of_the_cube(machine: MachineModel, found: Feel) -> None:
    half = machine.design.cube.half_side_mm / 1000.0
    for summary in found.summaries.values():
        low, high = sorted((summary.best[0], summary.worst[0]))
        assert low <= summary.centre * (1.0 + 1e-9)
        assert summary.centre <= high * (1.0 + 1e-9)
        assert (summary.best[0] <= summary.worst[0]) == summary.quantity.small
        for _, place in (summary.best, summary.worst):
            assert np.abs(place - machine.centre).max() <= half * (1.0 + 1e-12)
    assert [summary.quantity for summary in found.summaries.values()] == list(QUANTITIES)
    heaviest, lightest = found.summaries["mass_max"], found.summaries["mass_min"]
    for axis in "xyz":
        assert lightest.best[0] <= found.summaries[f"mass_{axis}"].best[0]
        assert found.summaries[f"mass_{axis}"].worst[0] <= heaviest.worst[0]


def test_the_wall_that_is_reported_is_the_one_that_the_tick_renders(machine: MachineModel, found: Feel) -> None:
    """In the direction in which it renders least, with the cap that `firmware` writes: asked for 1000 N/mm."""
    assert found.slices["wall"].shape == found.positions.shape[:-1]
    assert found.summaries["wall"].worst[0] >= 2000.0
    controller = board_controller(machine, energy=1e3, energy_start=1e3)._replace(walls=proven_cap(machine))
    rng = np.random.default_rng(2)
    places = [(found.summaries["wall"].worst[1], found.summaries["wall"].worst[0])]
    places += [(found.positions[k], found.slices["wall"][k]) for k in ((0, 20, 20), (1, 3, 30), (2, 40, 0))]
    for p, reported in places:
        theta, out, least = inverse_kinematics(machine.geometry, p), np.zeros(3), np.inf
        columns = jacobian(machine.geometry, p)
        worst = np.linalg.eigh(columns @ columns.T)[1][:, 2]
        for normal in [worst, *rng.normal(size=(40, 3))]:
            n = normal / np.linalg.norm(normal)
            memory, wall = fresh(controller), VirtualWall(1e6, p + 1e-4 * n, tuple(n))
            tick(controller, memory, law_table(wall), 0.0, theta, theta, ALL_FRESH, out)
            least = min(least, float(memory.work[FORCE] @ n) / 1e-4)
        assert least == pytest.approx(reported, rel=1e-6)


def test_whether_the_handle_stays(machine: MachineModel, found: Feel) -> None:
    """A joint is held up to its friction: the answer changes where 5 % of the weight's torque crosses it."""
    least, usual = joint_friction(machine).drive[:2]
    gravity = found.summaries["gravity"]
    for missed, short in ((0.99 * least, "Yes."), (1.01 * least, "Unless"), (1.01 * usual, "No.")):
        heavy = replace(gravity, worst=(missed / MASS_ERROR, gravity.worst[1]))
        answer = stays(machine, joint_drive(machine), {"gravity": heavy})
        assert answer.short.startswith(short)
        assert answer.good == (short == "Yes.")
        assert f"{1e3 * missed:.1f} mN m of" in answer.text


@pytest.mark.parametrize(("limit", "good"), [(0.99 * HARD, False), (1.01 * HARD, True), (1.01 * RIGID, True)])
def test_whether_the_wall_is_hard(found: Feel, limit: float, good: bool) -> None:
    """The worst pose decides, and what is rendered there; the answer has the loop's condition, and both walls."""
    wall = found.rendered["board"]
    answer = hard(found.loop, found.rendered | {"board": replace(wall, worst=(limit, wall.worst[1]))})
    assert answer.good == good
    assert answer.short == f"{'Yes' if good else 'No'}, where drives add no damping."
    assert f"{limit / 1e3:.1f} N/mm" in answer.text
    for one in (found.loop.walls, found.loop.other):
        assert one.loop.label in answer.text
        for figure in ("passive", "worst", "nominal"):
            assert f"{getattr(one.worst[1], figure) / 1e3:.1f}" in answer.text


def test_whether_it_buzzes(found: Feel) -> None:
    summaries, loop = found.summaries, found.loop
    steady = buzzes(loop, summaries)  # not at the worst corner, with a structure that resonates in the band
    assert (steady.short, steady.good) == ("Finely, for the most sensitive hands.", False)
    shaken = buzzes(replace(loop, default_wall_stable={**loop.default_wall_stable, ("x", "light"): False}), summaries)
    assert (shaken.short, shaken.good) == ("Yes.", False)
    assert "x with the light hand" in shaken.text
    calm, still = NoiseFigures(0.01, 1e-8, True), NoiseFigures(0.005, 1e-9, True)
    for most, short in ((calm, "No."), (replace(calm, force=0.06), "Yes."), (replace(calm, motion=6e-8), "Finely")):
        reported = buzzes(replace(loop, noise={"centre": NoiseRange(still, most, 1e-5, 0.1)}), summaries)
        assert reported.short.startswith(short)
        assert reported.good == (short == "No.")
        assert ("19.3 bits, or a structure that damps 10 %" in reported.text) == (short == "Finely")
    felt = buzzes(replace(loop, noise={"centre": NoiseRange(still, replace(calm, motion=3e-8), 1e-5, 0.1)}), summaries)
    assert felt.short.startswith("Finely")  # within the limit of this project, above the threshold of a study
    assert "up to 3.0 times" in felt.text
    assert "less than the limit of 0.05 um" in felt.text
    step = found.summaries["position_step"]
    for way, says in ((1e-6, "too little to be felt"), (3e-5, "while moving"), (1e-3, "felt as grain")):
        coarse = summaries | {"position_step": replace(step, worst=(way, step.worst[1]))}
        assert says in buzzes(loop, coarse).text.split("One count")[1]


def test_both_walls_stand_side_by_side_with_their_conditions(found: Feel) -> None:
    page, facts, text = feel_markdown(found), feel_facts(found)["loop"], feel_text(found)
    assert [one["loop"] for one in facts["walls"]] == [BOARD.label, DAMPED.label]
    for one, walls in zip(facts["walls"], (found.loop.walls, found.loop.other), strict=True):
        for axis, wall in walls.axes.items():
            reported = one["axes"][axis]
            assert reported["worst_N_per_mm"] == 1e-3 * wall.worst
            row = "{own_N_per_mm:13.2f}{passive_N_per_mm:10.2f}{worst_N_per_mm:12.2f}".format(**reported)
            assert row in page
            assert row in text
        assert f"{walls.loop.label}: walls at the centre" in text
    board, damped = (one["axes"]["x"] for one in facts["walls"])
    assert board["own_N_per_mm"] < 0.1  # 93 % of what is behind the other is the drives'
    assert damped["own_N_per_mm"] > 5.0
    least = {name: feel_facts(found)["rendered_wall_N_per_mm"][name]["worst"] for name in ("board", "damped")}
    assert least["board"] == pytest.approx(4.0, rel=0.1)  # finding T11
    assert least["damped"] == pytest.approx(2.2, rel=0.1)
    assert set(facts["rates"]) == {"1000_Hz", "8000_Hz"}
    slow, fast = (facts["rates"][rate]["x"] for rate in ("1000_Hz", "8000_Hz"))
    assert fast["worst_N_per_mm"] > 4.0 * slow["worst_N_per_mm"]  # the lags of currents and encoders stay


def test_structure_of_the_build_stands_on_the_page(machine: MachineModel, found: Feel) -> None:
    built = with_structure(machine).structure
    assert built is not None
    behind = feel_markdown(replace(found, machine=replace(machine, structure=built)))
    for definition in DEFINITIONS.values():
        assert definition in behind
    page = feel_markdown(found)
    assert "as a hand meets it" not in page  # without a build there is no structure to be behind
    assert "no structure.json of a build is at hand" in page
    centre, worst = found.summaries["wall"].centre, found.summaries["wall"].worst[0]
    felt = 1e-3 / (1.0 / centre + 1.0 / built.centre), 1e-3 / (1.0 / worst + 1.0 / built.softest)
    assert f"at least {felt[0]:.1f}; {felt[1]:.1f} N/mm" in behind


def test_the_range_of_impedance_is_from_the_mass_to_the_wall(found: Feel) -> None:
    """The free handle is its mass at low frequencies, the wall its stiffness in series with the structure."""
    w = 2.0 * np.pi * found.loop.frequency
    low, slow = (w > 15.0) & (w < 60.0), w < 5.0
    assert set(found.loop.z_width) == {(place, axis) for place in ("centre", "worst corner") for axis in "xz"}
    for axis in "xz":
        one = found.loop.z_width["centre", axis]
        mass = found.summaries[f"mass_{axis}"].centre
        assert one.lower[low] / w[low] == pytest.approx(np.full(low.sum(), mass), rel=0.1)
        series = 1.0 / (1.0 / one.wall + 1.0 / 15e3)
        assert one.upper[slow] * w[slow] == pytest.approx(np.full(slow.sum(), series), rel=0.02)


def test_counts_limit_walls_by_twice_the_friction_over_the_quantum(machine: MachineModel, found: Feel) -> None:
    """2 f_c / quantum by hand where a count moves the handle most: one joint turns alone, drive and ball joints rub."""
    p = found.summaries["position_step"].worst[1]
    lever = max(jacobian(machine.geometry, p).T, key=lambda column: float(np.linalg.norm(column)))
    reach = float(np.linalg.norm(lever))
    rubs = found.drive.coulomb / reach + float(ball_friction_N(machine.design, p, lever / reach))
    bound = quantum_bound(found.summaries)
    # the least friction of the cube is elsewhere, a few per cent less
    assert 0.9 < bound / (2.0 * rubs / (found.drive.count * reach)) <= 1.0 + 1e-9
    assert f"Counts limit no wall up to {1e-3 * bound:.0f} N/mm" in feel_markdown(found)


def test_torque_ripple_at_the_handle_is_that_of_a_joint_s_share(machine: MachineModel, found: Feel) -> None:
    """2 % of the weight's torque at the centre, where the chains are alike: along z three G_z times as much."""
    weight, ripple = found.summaries["gravity"].centre, found.drive.ripple
    assert (ripple, found.drive.cogging) == (0.02, 0.0)
    most = max(np.linalg.norm(np.array(signs) @ np.linalg.inv(jacobian(machine.geometry, machine.centre)))
               for signs in product((-1.0, 1.0), repeat=3))  # fmt: skip
    assert found.summaries["ripple_still"].centre == pytest.approx(ripple * weight * most)
    assert found.summaries["ripple_force"].centre == pytest.approx(ripple * found.drive.continuous * most)


def test_forces_are_held_as_long_as_the_motor_s_data_tell(machine: MachineModel, found: Feel) -> None:
    page, facts = feel_markdown(found), feel_facts(found)["hold"]
    assert facts["definition"][1:] in page
    forces = [found.summaries[name].worst[0] for name in ("force_continuous", "force_peak")]
    assert [found.holds[0].force, found.holds[-1].force] == pytest.approx(forces)
    heat = motor_heat(catalogue.motor.chosen(machine.design.hardware), machine.drive.ratio * machine.drive.efficiency)
    last = facts["forces"][-1]
    assert last["until_limit_s"] == hold_time(heat, found.drive.peak, heat.hottest)
    assert facts["forces"][0]["until_limit_s"] == "for ever"
    for one in found.holds[1:]:
        assert one.derate is not None
        assert one.limit is not None
        assert one.warm is not None
        assert 0.0 < one.derate < one.limit
        assert 0.0 < one.warm < one.limit
    hardware = machine.design.hardware.model_copy(update={"motor": "maxon-ec60flat-625858"})
    unknown = replace(machine, design=machine.design.model_copy(update={"hardware": hardware}))
    rows = holds(unknown, found.drive, machine.centre[None])
    assert {one["until_limit_s"] for one in hold_facts(rows)} == {"unknown"}
    assert "maxon-ec60flat-625858 lacks" in "\n".join(hold_markdown(unknown, rows))


def test_a_plane_of_gains_is_drawn(found: Feel) -> None:
    from haptics.feel.pictures import impedance, z_width

    figure = z_width(found.loop, "device")
    figure.canvas.draw()
    assert len(figure.axes) == 4
    assert figure.axes[0].get_ylabel() == "largest stable stiffness, N/mm"
    (legend,) = figure.legends
    reported = {text.get_text() for text in legend.get_texts()}
    assert {"1 kHz", "8 kHz"} <= reported
    assert sum(one.startswith("passive with any passive hand") for one in reported) == 2  # and whose loop that is
    impedance(found.loop, "device").canvas.draw()


def test_page_and_facts_tell_the_same(found: Feel) -> None:
    page, facts, text = feel_markdown(found), feel_facts(found), feel_text(found)
    json.dumps(facts, allow_nan=False)
    assert len(facts["summary"]) == len(QUANTITIES)
    for summary in found.summaries.values():
        quantity = summary.quantity
        worst = f"{facts['summary'][quantity.key]['worst']:.{quantity.digits}f}"
        row = next(line for line in page.splitlines() if line.startswith(f"| {quantity.label} |"))
        assert row.split("|")[5].strip() == worst
        assert worst in next(line for line in text.splitlines() if line.startswith(quantity.label))
    for answer in found.answers:
        assert f"**{answer.question} {answer.short}** {answer.text}" in page
        assert answer.question in text
    drawn = {line.split("(")[1][:-5] for line in page.splitlines() if line.startswith("![")}
    assert drawn == {*MAPS, "z_width", "impedance"}
    for row in reference_devices():
        assert row.source in page
        assert row.shown in page


def test_the_force_next_to_other_devices_is_what_the_controller_gives(machine: MachineModel, found: Feel) -> None:
    """For a moment the supervisor's limit of this design decides, for ever the motors' heat."""
    from haptics.loop.assumptions import default_controller

    stop = default_controller(machine).limits.torque
    assert found.drive.continuous == machine.drive.continuous_torque_N_m < found.drive.peak
    assert found.drive.peak == stop == 0.8 < found.drive.motor == machine.drive.peak_torque_N_m
    given, motor = found.summaries["force_peak"].worst[0], found.summaries["force_motor"].worst[0]
    assert given < stop / found.drive.motor * motor  # less than in proportion: the weight takes the same from both
    page = feel_markdown(found).splitlines()
    compared = next(line for line in page if line.startswith("| force, peak, N |"))
    assert f"| {given:.1f} likewise, as the controller gives it |" in compared
    own = page[page.index(compared) + 1]
    assert own.startswith(
        f"| the same at the motor's own limit, N | {motor:.1f} likewise, which the controller does not"
    )
    assert own.count("|") == compared.count("|")
    said = f"The controller stops at the design's {stop:g} N m at a joint, so that this device gives {given:.1f} N"
    assert sum(said in line for line in page) == 2
    assert not any(f"{motor:.1f}" in line and line.startswith("| force, peak") for line in page)


def test_motors_below_the_designs_limit_decide(machine: MachineModel, loop: LoopSheet) -> None:
    asking = design_from_dict(changed(requirements__joint_torque_N_m=1.2, requirements__peak_torque_N_m=1.5))
    weak = replace(machine, design=asking, drive=drive_torque(asking))
    drive, motor = joint_drive(weak), machine.drive
    assert (drive.continuous, drive.peak, drive.motor) == (motor.continuous_torque_N_m, *[motor.peak_torque_N_m] * 2)
    page = feel_markdown(feel(weak, lambda _machine: loop))
    assert "The motors' own limit, 1.18 N m at a joint, is no more than the 1.5 N m that the design asks for." in page
    assert "motor's own limit, N |" not in page


def test_maps_are_of_the_slices(found: Feel) -> None:
    quantity = next(q for q in QUANTITIES if q.name == "force_continuous")
    x, y, z, values = map_values(found, quantity)
    assert values.shape == (3, len(y), len(x))
    half, low = found.machine.design.cube.half_side_mm, found.machine.design.cube.bottom_height_mm
    assert z == pytest.approx([low, low + half, low + 2.0 * half])
    assert values[1, len(y) // 2, len(x) // 2] == pytest.approx(found.summaries["force_continuous"].centre, rel=1e-9)
    assert np.abs(values[:, ::-1] - values).max() < 1e-9  # the mechanism is its own mirror image in y


@pytest.fixture(scope="module")
def masses(built: Built) -> Path:
    return built.folder / "mass_properties.json"


@pytest.fixture
def quick(loop: LoopSheet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(haptics.feel.loops, "loop_sheet", lambda *_: loop)


def call(*arguments: object) -> int:
    try:
        return main([str(argument) for argument in arguments])
    except SystemExit as ended:
        return int(ended.code or 0)


@pytest.mark.usefixtures("quick")
def test_files_and_table(
    masses: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert call("feel", "--design", BEST, "--mass-properties", masses, "--out", tmp_path) == 0
    reported = capsys.readouterr()
    assert reported.out.startswith("synthesized: what it will feel like")
    (folder,) = tmp_path.iterdir()
    assert folder.name == "synthesized-feel"
    assert {file.name for file in folder.glob("[!.]*")} == {"feel.md", "feel.json", *(f"{name}.png" for name in DRAWN)}
    for name in DRAWN:
        assert (folder / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    facts = json.loads((folder / "feel.json").read_text())
    assert facts["schema"] == "delta-feel/2"
    (folder / "stray").write_text("of somebody")
    assert call("feel", "--design", BEST, "--mass-properties", masses, "--out", tmp_path, "--json") == 2
    assert "holds stray, which no run wrote here" in capsys.readouterr().err
    (folder / "stray").unlink()
    monkeypatch.setattr("haptics.scenes.pictures.save", lambda *_: None)  # drawn once is enough
    assert call("feel", "--design", BEST, "--mass-properties", masses, "--out", tmp_path, "--json") == 0
    assert json.loads(capsys.readouterr().out) == facts


@pytest.mark.usefixtures("quick")
def test_a_run_that_fails_leaves_the_folder_before(
    masses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with whole_folder(tmp_path / "synthesized-feel") as folder:
        (folder / "feel.md").write_text("before")

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("haptics.scenes.pictures.save", full)
    assert call("feel", "--design", BEST, "--mass-properties", masses, "--out", tmp_path) == 2
    assert [path.name for path in tmp_path.iterdir()] == ["synthesized-feel"]
    assert (tmp_path / "synthesized-feel" / "feel.md").read_text() == "before"


@pytest.mark.usefixtures("quick")
@pytest.mark.slow
def test_exit_1_says_what_is_not_met(
    masses: Path,
    tmp_path: Path,
    loop: LoopSheet,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("haptics.scenes.pictures.save", lambda *_: None)  # the pictures are another test's
    shaken = replace(loop, default_wall_stable={**loop.default_wall_stable, ("x", "light"): False})
    monkeypatch.setattr(haptics.feel.loops, "loop_sheet", lambda *_: shaken)
    assert call("feel", "--design", BEST, "--mass-properties", masses, "--out", tmp_path) == 1
    assert "x with the light hand" in capsys.readouterr().err
    weak = tmp_path / "weak.json"
    weak.write_text(json.dumps(changed(requirements__force_N=9.0, requirements__peak_force_N=9.0)))
    copy = tmp_path / "masses.json"
    known = json.loads(masses.read_text())
    del known["input_sha256"]  # of another design: the masses are the user's word
    copy.write_text(json.dumps(known))
    assert call("feel", "--design", weak, "--mass-properties", copy, "--out", tmp_path) == 1
    assert " 9 N " in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--design", "none.json"], "none.json: "),
        (["--design", BEST, "--mass-properties", "none.json"], "none.json: "),
        ([], "--design"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(
    more: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)  # where no best.json stands
    assert call("feel", *more, "--out", tmp_path / "new") == 2
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    assert message in reported.err
    assert not (tmp_path / "new").exists()


def test_what_the_mechanism_refuses_is_exit_2(
    masses: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(*_: Any, **__: Any) -> None:
        raise SingularError("the three forearms lie in one plane")

    monkeypatch.setattr(haptics.feel.sheet, "feel", refused)
    assert call("feel", "--design", BEST, "--mass-properties", masses, "--out", tmp_path / "new") == 2
    reported = capsys.readouterr()
    assert reported.err.startswith(f"{BEST}: cube: ")
    assert not (tmp_path / "new").exists()
