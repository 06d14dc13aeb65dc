"""Hardware that cannot do: each reason against its bound, the cases of the first hard look, all of them at once.

15 s of processor: refusals in closed form of some fifty designs.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from delta_cad import catalogue
from delta_cad.commands.cli import main
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, DesignError, design_from_dict, load_design
from delta_cad.dimensions import Reason, dimensions
from delta_cad.dimensions.rules import ceil_sig
from delta_cad.dimensions.tolerances.machine import machine_chains
from delta_cad.mechanism.limits.couple_index import couple_index
from delta_cad.structure.hardware.refusals import least_outline_mm, refusals
from delta_cad.structure.hardware.thresholds import refused
from delta_cad.structure.loads import sampled_mm
from tests.committed import ROOT, changed
from tests.delta_cad.structure.hardware.broken import ended, enough
from tests.designs import below_elbows


def machine(**changes: Any) -> Design:
    return design_from_dict(changed(**changes))


def reasons(**changes: Any) -> dict[str, Reason]:
    """Every reason against a machine by part and feature."""
    return {f"{reason.part}, {reason.feature}": reason for reason in refusals(machine(**changes))}


def test_the_committed_machine_is_not_refused(best: Design) -> None:
    assert refusals(best) == ()


def test_of_a_platform_below_its_elbows_nothing_else_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Room for springs and motors of a machine that cannot be put together so sent the reader elsewhere."""
    (reason,) = refusals(design_from_dict(below_elbows()))
    assert reason.field == "cube.bottom_height_mm"
    path = tmp_path / "hanging.json"
    path.write_text(json.dumps(below_elbows()))
    for command in ("check", "build", "drawings", "view"):
        assert main([command, "--design", str(path)]) == 2
        reported = capsys.readouterr()
        assert reported.out == ""
        lines = reported.err.splitlines()
        assert lines[0].startswith("hanging.json: cube, assembly mode: det S > 0, ")
        assert len(lines) == (2 if command in ("check", "build") else 1)  # the other names --suggest


def test_a_cube_where_rods_let_the_platform_turn_is_refused_with_the_height_that_is_free_of_it() -> None:
    """A wide base over short rods; the couples' index is 0 where their determinant changes its sign, and not above."""
    lengths = {"base_radius": 85.69, "platform_radius": 36.12, "upper_arm_length": 64.8, "forearm_length": 102.975}
    wide: dict[str, Any] = {f"mechanism__{name}_mm": value for name, value in lengths.items()}
    wide |= {"cube__half_side_mm": 30.0, "requirements__envelope_width_mm": 900.0}

    def least(bottom_mm: float) -> float:
        design = machine(**wide, cube__bottom_height_mm=bottom_mm)
        positions = sampled_mm(design.workspace, 17) / MM_PER_M
        return float(couple_index(design.geometry, positions).min())

    reason = reasons(**wide, cube__bottom_height_mm=47.848)["platform, turning"]
    assert reason.field == "cube.bottom_height_mm"
    low = machine(**wide, cube__bottom_height_mm=47.848)
    turning = next(one for one in refused(low) if one.reason.key == reason.key)  # the others' thresholds are not asked
    bound = enough(turning, "cube.bottom_height_mm")
    assert least(47.848) < 0.01 < 0.05 < least(bound + 5.0)
    near, far = (least(bound + above) for above in (1.0, 3.0))  # it grows evenly there: from 0 at the bound
    assert 2.0 * near / (far - near) == pytest.approx(1.0, abs=0.1)
    assert "platform, turning" not in reasons(**wide, cube__bottom_height_mm=bound)
    assert "platform, turning" in reasons(**wide, cube__bottom_height_mm=bound - 0.01)


# The hardware that no build of the first year could do with: what is changed, and what is said; nothing: it is built.
CASES: dict[str, tuple[dict[str, Any], set[str]]] = {
    "cable of 0.8 mm": (
        {
            "hardware__cable": "steel-0.8-7x19",
            "mechanism__base_radius_mm": 35.0,
            "requirements__peak_force_N": 5.3,  # weight leaves 5.47
            "requirements__envelope_depth_mm": 232.0,
        },
        set(),
    ),
    "cable of 0.8 mm on the committed base": ({"hardware__cable": "steel-0.8-7x19"}, set()),
    "cable of 0.8 mm, closer": (
        {"hardware__cable": "steel-0.8-7x19", "mechanism__base_radius_mm": 29.0},
        {"mechanism.base_radius_mm"},  # its wider pinion pushes the motors inwards, and they the legs outwards
    ),
    "ratio 5": ({"hardware__capstan_ratio": 5.0}, set()),
    "ratio 5, closer": (
        {"hardware__capstan_ratio": 5.0, "mechanism__base_radius_mm": 29.0},
        {"mechanism.base_radius_mm"},
    ),
    "ratio 12": (
        {"hardware__capstan_ratio": 11.5},
        {"hardware.capstan_ratio", "hardware.sector_radius_mm"},
    ),
    "ratio 3": ({"hardware__capstan_ratio": 3.0}, {"hardware.capstan_ratio"}),
    "small device": (
        {
            "mechanism": {
                "base_radius_mm": 20.0,
                "platform_radius_mm": 14.0,
                "upper_arm_length_mm": 45.0,
                "forearm_length_mm": 70.0,
                "parallelogram_width_mm": 30.0,
            },
            "cube": {"bottom_height_mm": 35.0, "half_side_mm": 15.0},
        },
        {
            "mechanism.upper_arm_length_mm",
            "mechanism.platform_radius_mm",
            "mechanism.parallelogram_width_mm",
        },
    ),
    "30 N": (
        {"requirements__force_N": 30.0, "requirements__peak_force_N": 30.0, "requirements__joint_torque_N_m": 3.9},
        {"hardware.capstan_ratio", "mechanism.base_radius_mm"},
    ),
    "12 N at once": (
        {"requirements__peak_force_N": 12.0},
        {"requirements.peak_force_N", "requirements.peak_torque_N_m"},
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_the_cases_of_the_hard_look_are_built_or_refused_with_the_field_to_change(name: str) -> None:
    changes, fields = CASES[name]
    changes = dict(changes)
    if name == "30 N":
        changes["requirements__peak_torque_N_m"] = 7.8
    if name == "small device":
        changes["requirements__shoulder_min_deg"] = None
    start = process_time()
    found = refusals(machine(**changes))
    assert process_time() - start < 3.0  # a third of it here; the bound is for a machine that is shared
    blamed = {reason.field for reason in found}
    assert fields <= blamed if fields else blamed == set(), found
    assert all(reason.field for reason in found)


@pytest.mark.parametrize("motor", ["maxon-re25-118752", "maxon-ec45flat-411812"])
def test_a_motor_that_is_for_no_capstan_is_refused_with_those_that_are(motor: str) -> None:
    """Their rows say why: a collar that holds no set screw, screws that no key reaches."""
    with pytest.raises(
        DesignError, match=rf"^design: hardware\.motor = .*{motor}.* must be one of maxon-re30-310007, "
    ):
        machine(hardware__motor=motor)
    assert "partly: for no " in catalogue.motor(motor).verified


# By hand: RE 30's 88.2 mN m and 0.96 of efficiency, for 0.6 N m; Euler's rule at the tension for the motor's own peak.
LEAST: list[tuple[dict[str, Any], str, str, float]] = [
    (
        {"requirements__joint_torque_N_m": 0.6, "requirements__peak_torque_N_m": 0.8},
        "drive, continuous torque",
        "hardware.capstan_ratio",
        0.6 / (0.96 * catalogue.motor("maxon-re30-310007").nominal_torque_N_m),
    ),
    (
        {"hardware__platform_thickness_mm": 9.0},
        "platform, wrist boss",
        "hardware.platform_thickness_mm",
        10.0,  # 1 mm around a bar of 8 mm
    ),
    (
        {"hardware__capstan_ratio": 11.5},
        "pinion, wall",
        "hardware.capstan_ratio",
        38.7 / (2.5 + 0.75 + 0.27),  # shaft, wall, half a cable
    ),
]


@pytest.mark.parametrize(("changes", "name", "field", "bound"), LEAST)
def test_the_threshold_is_the_border_by_hand(changes: dict[str, Any], name: str, field: str, bound: float) -> None:
    found = enough(ended(machine(**changes))[name], field)
    assert found == pytest.approx(bound, rel=1e-3)
    assert (found >= bound - 1e-9) == (bound > changes.get(field.replace(".", "__"), 0.0))


def test_a_cable_is_tensioned_for_what_the_motor_gives_which_asking_for_more_does_not_change() -> None:
    """The motor gives 1.2 of 1.9 N m at its peak: its ratio, not a torque that is asked for already."""
    found = reasons(requirements__peak_torque_N_m=1.9, requirements__peak_force_N=12.0)
    torque, slip = found["drive, peak torque"], found["cable's slip, load"]
    assert slip.field == torque.field == "hardware.capstan_ratio"


def test_every_reason_is_reported_at_once() -> None:
    """Six faults of one design, of plates, balls, widths, motor and drive."""
    found = refusals(
        machine(
            hardware__capstan_ratio=9.0,
            hardware__platform_thickness_mm=8.0,
            hardware__ball_diameter_mm=9.0,
            hardware__base_plate_thickness_mm=4.5,
            hardware__motor="faulhaber-3257g024cr",
            requirements__joint_torque_N_m=0.7,
        )
    )
    assert {reason.field for reason in found} >= {
        "hardware.capstan_ratio",
        "hardware.platform_thickness_mm",
        "hardware.ball_diameter_mm",
        "hardware.base_plate_thickness_mm",
        "hardware.sector_radius_mm",
    }
    assert all("\n" not in str(reason) for reason in found)


def test_an_outline_that_elbows_and_motors_exceed_is_refused_at_what_they_take(best: Design) -> None:
    """The committed machine sweeps 219.5 x 247.9 mm: its rods reach farther along y than elbows and motors do."""
    size = least_outline_mm(dimensions(best))
    assert size == pytest.approx([219.5, 247.9], rel=0.07)
    assert (size <= [219.6, 247.9]).all()
    tight = {"requirements__envelope_width_mm": 230.0, "requirements__envelope_depth_mm": 215.0}
    found = {reason.feature: reason for reason in refusals(machine(**tight))}
    assert f"over {ceil_sig(size.max())} mm" in found["envelope width"].message
    swapped = {"requirements__envelope_width_mm": 220.0, "requirements__envelope_depth_mm": 270.0}
    assert refusals(machine(**swapped)) == ()  # it is turned by 90 degrees


def test_a_shaft_too_short_for_its_pinion_asks_for_a_motor_that_has_a_longer_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    rows = catalogue.motor.rows
    short = replace(rows["maxon-re30-310009"], shaft_length_mm=8.0)
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", {**rows, "maxon-re30-310009": short})
    (one,) = (r for r in refused(machine(hardware__motor="maxon-re30-310009")) if r.reason.key == ("pinion", "bore"))
    (motors,) = (t.enough["hardware.motor"] for t in one.thresholds)
    assert isinstance(motors, tuple)
    assert {rows[str(key)].shaft_length_mm > 8.0 for key in motors} == {True}


# What docs/best.md says that the committed machine bears of the figures that no source confirms: family, row, column,
# the least and the most that it bears, and beyond those, where the page names a limit.
BEARS: list[tuple[str, str, str, tuple[float, ...], tuple[float, ...]]] = [
    ("motor", "maxon-re30-310007", "length_mm", (60.0, 69.0), (70.0,)),
    ("motor", "maxon-re30-310007", "shaft_diameter_mm", (4.0, 7.0), ()),
    ("motor", "maxon-re30-310007", "shaft_length_mm", (15.0, 17.0), (10.0, 18.0)),
    ("motor", "maxon-re30-310007", "pilot_diameter_mm", (10.0, 16.0), ()),
    ("motor", "maxon-re30-310007", "pilot_height_mm", (1.0, 5.5), (6.0,)),
    ("motor", "maxon-re30-310007", "mount_count", (2, 6), ()),
    ("tube", "cfrp-5x3", "outer_mm", (5.2,), ()),
    ("tube", "cfrp-5x3", "inner_mm", (2.5, 3.2), ()),
    ("foot", "foot-m4-stud-15x8", "height_mm", (5.0, 15.0), ()),
    ("knob", "din319-25", "thread_depth_mm", (7.0, 13.0), ()),
    ("knob", "din319-25", "height_mm", (21.0, 24.5), (25.0,)),
]


@pytest.mark.parametrize(("family", "key", "column", "bears", "beyond"), BEARS)
def test_the_committed_best_bears_what_its_page_says_of_unconfirmed_figures(
    family: str,
    key: str,
    column: str,
    bears: tuple[float, ...],
    beyond: tuple[float, ...],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    design, rows = load_design(ROOT / "best.json"), getattr(catalogue, family)

    def off(value: float) -> list[str]:
        with monkeypatch.context() as patch:
            patch.setitem(rows.__dict__, "rows", rows.rows | {key: replace(rows(key), **{column: value})})
            if found := refusals(design):
                return list(map(str, found))
            return [chain.name for chain in machine_chains(dimensions(design)) if not chain.holds]

    assert [off(value) for value in bears] == [[]] * len(bears)
    assert all(off(value) for value in beyond)
