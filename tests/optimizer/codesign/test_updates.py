"""What refusals and failed checks teach: bounds, other parts, or that nothing will do."""

from __future__ import annotations

from dataclasses import replace
from math import inf, sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.checks.report import CheckResult
from delta_cad.design import load_design
from delta_cad.dimensions import DimensionError, Reason, dimensions
from delta_cad.dimensions.rules import HEIGHT
from delta_cad.mechanism import Cube, DeltaGeometry
from delta_cad.mechanism.limits import ElbowAngle, Outline
from delta_cad.mechanism.workspace import CubeSearch
from delta_cad.solids.primitive import BuildError
from delta_cad.structure.hardware.refusals import refusals
from delta_cad.structure.hardware.thresholds import changed
from optimizer.codesign import candidate as candidates
from optimizer.codesign.candidate import Candidate, design_for
from optimizer.codesign.corrections import FARTHEST, KNOB_MM, NARROWER, SHOULDER_DEG, WIDER, Corrections, reference
from optimizer.codesign.estimates import ELBOW_FIELD, SWING_FIELD, Estimate, estimates
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import to_requirements
from optimizer.codesign.updates import (
    COUPLE_MOST,
    KERNEL_TRIES,
    LEVER_EXPONENT,
    LEVER_STEPS,
    UNFOLDED,
    NoProgressError,
    from_cable_pull,
    from_checks,
    from_kernel,
    from_refusals,
    from_stiffness,
    too_soft,
    with_least_radius,
    with_outline,
    with_room,
)
from optimizer.problem.brief import DesignBrief, brief_from_dict
from tests.committed import BEST, ROOT

CHOICE = Selection("maxon-re30-310007", "capstan", 4.8, 54.0)
KNOWN = Corrections(reference())
LENGTHS = (91.0, 143.0, 31.0, 24.0, 64.0, 42.0)
WIDTH_MM, DEPTH_MM = 54.0 / 2 + sqrt(3.0) * 122.0, 54.0 * sqrt(3.0) / 4 + 1.5 * 122.0  # eq. (1)


def brief(**hardware: object) -> DesignBrief:
    room = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}
    return brief_from_dict({"name": "b", "requirements": room, "hardware": hardware})


def estimate(part: str, feature: str, message: str, *of: Any, margin: float | None = None, **named: Any) -> Estimate:
    return Estimate(Reason(part, feature, message, margin=margin), *of, **named)


def candidate() -> Candidate:
    return Candidate(load_design(Path(BEST)), CHOICE, LENGTHS, KNOWN, 84.0)


def elbow_deg(g: DeltaGeometry, cube: Cube) -> float:
    least = CubeSearch(cube)(lambda p: ElbowAngle.figures[0].worst(ElbowAngle(0.0), g, p), 1.0)
    return float(np.degrees(least.value))


def failed(name: str, value: float | None, limit: float | None, unit: str = "", *pair: str) -> CheckResult:
    return CheckResult(name, False, value, limit, unit, worst_pair=pair)


def test_a_panel_of_the_brief_is_the_designs_in_the_units_that_it_was_given_in() -> None:
    room = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}
    given = brief_from_dict({"name": "b", "requirements": room, "panel": {"thickness_mm": "0.3 cm"}})
    design = design_for(given, CHOICE, LENGTHS, KNOWN)
    assert design.panel is not None
    assert (design.panel.thickness_mm, design.panel.limit_mm) == (3.0, 3.0)
    assert design_for(brief(), CHOICE, LENGTHS, KNOWN).panel is None


def test_a_design_has_its_wires_within_the_outline_unless_the_brief_leaves_them_out() -> None:
    assert design_for(brief(), CHOICE, LENGTHS, KNOWN).hardware.leads == "bent"
    assert design_for(brief(leads="none"), CHOICE, LENGTHS, KNOWN).hardware.leads == "none"


@pytest.mark.parametrize("peak_N", [None, 6.0, 30.0])
def test_the_peak_that_a_design_states_is_no_more_than_its_motor_gives(
    peak_N: float | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of an own motor of which no peak is told it is what it gives for ever."""
    row = catalogue.family("motor")[CHOICE.motor]
    row = replace(row, peak_torque_N_m=row.nominal_torque_N_m)
    monkeypatch.setattr(candidates, "motor_of", lambda *_: row)
    given = brief()
    given = given.model_copy(update={"requirements": given.requirements.model_copy(update={"peak_force_N": peak_N})})
    requested = design_for(given, CHOICE, LENGTHS, KNOWN).requirements
    assert requested.peak_torque_N_m is not None
    assert requested.joint_torque_N_m <= requested.peak_torque_N_m <= CHOICE.peak_torque_N_m(row)


def test_sizes_that_the_brief_states_are_those_of_the_design() -> None:
    stated = {"ball_diameter_mm": 8.0, "arm_thickness_mm": 9.0, "sector_radius_mm": 38.7}
    made = design_for(brief(**stated), CHOICE, LENGTHS, KNOWN).hardware
    assert {name: getattr(made, name) for name in stated} == stated
    left = design_for(brief(), CHOICE.with_entry("arm_thickness_mm", 7.6), LENGTHS, KNOWN).hardware
    assert (left.ball_diameter_mm, left.arm_thickness_mm) == (6.0, 7.6)


def test_a_part_is_chosen_among_those_that_the_brief_names() -> None:
    several = brief(cable=["steel-0.54-7x7", "steel-0.54-7x19"])
    assert design_for(several, CHOICE, LENGTHS, KNOWN).hardware.cable == "steel-0.54-7x7"
    other = CHOICE.with_entry("cable", "steel-0.54-7x19")
    assert design_for(several, other, LENGTHS, KNOWN).hardware.cable == "steel-0.54-7x19"


@pytest.mark.parametrize(
    ("field", "bound", "length"),
    [
        ("mechanism.base_radius_mm", 33.321, "base_radius"),
        ("mechanism.platform_radius_mm", 25.0, "platform_radius"),
        ("cube.bottom_height_mm", 70.01, "bottom_height"),
    ],
)
def test_a_bound_that_a_refusal_names_is_kept(field: str, bound: float, length: str) -> None:
    reason = estimate("part", "feature", "why", field, 0.9 * bound, bound)
    choice, corrections = from_refusals(brief(), CHOICE, KNOWN, [reason])
    assert choice == CHOICE
    assert bound <= corrections.least(length) < bound + 0.1
    assert corrections.why[-1] == "part, feature: why"


def test_a_bound_far_away_is_approached() -> None:
    far = estimate("encoder_cheek", "leg", "why", "mechanism.base_radius_mm", 30.0, 90.0)
    assert from_refusals(brief(), CHOICE, KNOWN, [far])[1].least("base_radius") == 37.5


def test_a_short_arm_that_turns_down_onto_its_cheek_gets_longer_and_by_more_each_time() -> None:
    close = failed("clearance", 1.0, 2.0, "mm", "motor_cheek_0", "upper_arm_0")
    first = from_checks(candidate(), KNOWN, [close])
    assert first.least("upper_arm_length") == LENGTHS[0] + 2.0
    assert from_checks(candidate(), first, [close]).least("upper_arm_length") == LENGTHS[0] + 4.0


def test_a_size_grows_and_one_that_is_stated_does_not() -> None:
    reason = estimate("upper_arm", "bore", "why", "hardware.arm_thickness_mm", 6.0, 7.55)
    choice, _ = from_refusals(brief(), CHOICE, KNOWN, [reason])
    assert choice.entries == {"arm_thickness_mm": 7.6}
    less = estimate("cable", "travel", "why", "hardware.sector_radius_mm", 112.0, 95.29)
    assert from_refusals(brief(), CHOICE, KNOWN, [less])[0].entries == {"sector_radius_mm": 95.2}
    with pytest.raises(NoProgressError, match="upper_arm, bore: why"):
        from_refusals(brief(arm_thickness_mm=6.0), CHOICE, KNOWN, [reason])


def test_another_part_is_the_next_that_may_be_used() -> None:
    reason = estimate("joint", "tube", "too slender", "hardware.tube", "cfrp-5x3")
    allowed = brief(tube=["cfrp-5x3", "cfrp-6x4"])
    choice, _ = from_refusals(allowed, CHOICE, KNOWN, [reason])
    assert choice.entries == {"tube": "cfrp-6x4"}
    with pytest.raises(NoProgressError):
        from_refusals(allowed, choice, KNOWN, [reason])


def test_widths_are_taken_to_the_side_that_is_required() -> None:
    for bound, width in ((57.43, 57.5), (48.19, 48.1)):
        reason = estimate("rod_spring", "length", "why", "mechanism.parallelogram_width_mm", 54.0, bound)
        assert from_refusals(brief(), CHOICE, KNOWN, [reason])[0].width_mm == width


@pytest.mark.parametrize(("stated", "least"), [(None, 0.4), (0.3, 0.3), (0.5, 0.5)])
def test_loads_that_no_part_bears_ask_for_more_hold(stated: float | None, least: float) -> None:
    weak = estimate("structure", "ball joint", "why", "requirements.peak_force_N", 6.0)
    _, corrections = from_refusals(brief().with_values({"feel.couple_index_min": stated}), CHOICE, KNOWN, [weak])
    assert corrections.couple_index_min == pytest.approx(least + 0.03)
    held = replace(KNOWN, couple_index_min=COUPLE_MOST)
    with pytest.raises(NoProgressError, match="ball joint"):
        from_refusals(brief(), CHOICE, held, [weak])


def test_behind_a_panel_the_worst_load_asks_for_more_hold_for_each_mm_of_the_knobs_lever() -> None:
    room = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}
    behind = brief_from_dict({"name": "b", "requirements": room, "panel": {}})
    loads = [
        estimate("structure", a, "why", "requirements.force_N", 4.0, margin=m) for a, m in (("a", 0.8), ("b", 0.9))
    ]
    _, corrections = from_refusals(behind, CHOICE, KNOWN, loads, (*LENGTHS[:5], 27.5))
    per_mm = 0.4 / (55.0 + KNOB_MM)
    assert corrections.couple_per_mm == pytest.approx(per_mm * 0.8**-LEVER_EXPONENT)
    assert corrections.couple_index_min == KNOWN.couple_index_min
    nothing = [estimate("structure", "a", "why", "requirements.force_N", 4.0, margin=1e-9)]
    assert from_refusals(behind, CHOICE, KNOWN, nothing, (*LENGTHS[:5], 27.5))[1].couple_per_mm == pytest.approx(
        per_mm * LEVER_STEPS[1]
    )
    design = design_for(behind, CHOICE, LENGTHS, KNOWN)
    soft = from_stiffness(corrections, 9.0, 10.0, design)  # twice the lever is a fourth of the stiffness
    assert soft.couple_per_mm == pytest.approx(corrections.couple_per_mm * 0.9 ** (-LEVER_EXPONENT / 2.0))
    made = replace(candidate(), design=design, corrections=replace(KNOWN, couple_per_mm=0.006))
    after = from_checks(made, corrections, [failed("structure rod", 1.1, 1.0)])
    assert after.couple_per_mm == pytest.approx(0.006 * LEVER_STEPS[0])


def test_an_outline_smaller_than_was_thought_is_learnt_of_a_machine_that_passes() -> None:
    sizes = [("envelope depth", 216.0), ("envelope width", 244.0)]
    found = with_outline(candidate(), KNOWN, [CheckResult(name, True, mm, 300.0, "mm") for name, mm in sizes])
    assert found.overhead_mm == pytest.approx((244.05 - WIDTH_MM, 216.05 - DEPTH_MM))
    assert found.overhead_mm[1] < KNOWN.overhead_mm[1]
    assert with_outline(candidate(), found, [CheckResult("envelope width", False, None, 300.0, "mm")]) is found


@pytest.mark.parametrize(("field", "k"), [("envelope_width_mm", 0), ("envelope_depth_mm", 1)])
def test_an_outline_refused_in_closed_form_leaves_more_room_and_asks_for_no_more_hold(field: str, k: int) -> None:
    requested = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}[field]
    out = estimate("assembly", "envelope", "elbows reach so far", f"requirements.{field}", requested, requested + 0.2)
    _, corrections = from_refusals(brief(), CHOICE, KNOWN, [out])
    assert corrections.overhead_mm[k] == pytest.approx(KNOWN.overhead_mm[k] + 0.25)
    assert corrections.overhead_mm[1 - k] == KNOWN.overhead_mm[1 - k]
    assert corrections.couple_index_min == KNOWN.couple_index_min


def test_a_height_refused_in_closed_form_is_learnt_of_the_machine_itself() -> None:
    own = load_design(BEST)
    height, cube = dimensions(own).height_mm, own.cube
    most = height - 12.0
    low = own.model_copy(update={"requirements": own.requirements.model_copy(update={"height_max_mm": most})})
    (out,) = estimates(low)
    assert (out.field, out.value) == (HEIGHT, most)
    _, corrections = from_refusals(brief(), CHOICE, KNOWN, [out])
    # twelve millimetres that the lengths were not asked to keep
    assert corrections.height_beyond_mm == pytest.approx(12.0, abs=0.11)
    assert corrections.height_beyond_mm >= 12.0
    top = cube.bottom_height_mm + 2.0 * cube.half_side_mm
    known = replace(KNOWN, height_beyond_mm=height - top)
    posed = to_requirements(
        brief_from_dict({"name": "b", "requirements": {"cube_side_mm": 60.0, "height_max_mm": 250.0}}),
        CHOICE,
        known,
        KNOWN.mass_estimate.inertia(*LENGTHS[:2], 4.8),
    )
    assert posed.requirements.height_max_mm == 250.0
    assert posed.limits.height_beyond_mm == pytest.approx(height - top)


def test_an_outline_that_is_free_grows_by_whole_millimetres() -> None:
    free = brief_from_dict({"name": "b", "requirements": {"cube_side_mm": 60.0}})
    out = estimate("assembly", "envelope", "elbows reach so far", "requirements.envelope_depth_mm", 243.0, 243.01)
    _, corrections = from_refusals(free, CHOICE, KNOWN, [out])
    assert corrections.overhead_mm[1] == KNOWN.overhead_mm[1] + 1.0


def test_each_failed_check_moves_what_it_is_about() -> None:
    def learnt(*results: CheckResult) -> Corrections:
        return from_checks(candidate(), KNOWN, results)

    assert learnt() == KNOWN
    deep = learnt(CheckResult("envelope width", True, 245.0, 270.0, "mm"), failed("envelope depth", 221.3, 220.0, "mm"))
    assert deep.overhead_mm == pytest.approx((245.05 - WIDTH_MM, 221.35 - DEPTH_MM))
    heavy = learnt(failed("effective mass", 0.42, 0.4, "kg"))
    assert heavy.mass_share == pytest.approx(KNOWN.mass_share * 0.998 * 0.4 / 0.42)
    undecided = learnt(failed("effective mass", 0.4, 0.4, "kg"))
    assert undecided.mass_share == pytest.approx(KNOWN.mass_share * 0.998)
    held = learnt(failed("torque with gravity", 0.4, 0.39, "N m"))
    assert held.held_torque_N_m == pytest.approx(KNOWN.held_torque_N_m + 0.0104)
    wrists = learnt(failed("clearance", 1.7, 2.0, "mm", "rod_cup_0_1_wrist", "rod_cup_1_0_wrist"))
    assert wrists.least("platform_radius") == 24.5
    rods = learnt(failed("clearance proof", None, 2.0, "mm", "rod_tube_0_0", "rod_tube_2_1"))
    assert rods.least_mm == wrists.least_mm
    board = learnt(failed("clearance", 1.0, 2.0, "mm", "motor_0", "encoder_board_1"))
    assert board.least("base_radius") == 32.0
    unfolded = learnt(failed("clearance proof", None, 2.0, "mm", "motor_cheek_0", "rod_tube_0_1"))
    d = candidate().design
    place = Cube(d.cube.bottom_height_mm / 1000.0, d.cube.half_side_mm / 1000.0)
    assert unfolded.elbow_angle_deg == pytest.approx(elbow_deg(d.geometry, place) + 2.0, abs=1e-6)
    assert unfolded.least_mm == KNOWN.least_mm
    solid = learnt(failed("overlap on one link", 156.0, 0.01, "mm^3", "motor_0", "encoder_board_1"))
    assert solid.least("base_radius") == 31.5


def test_a_step_is_doubled_where_it_did_not_part_the_same_two_parts() -> None:
    one = failed("clearance proof", None, 2.0, "mm", "upper_arm_0", "rod_tube_0_0")
    other = failed("clearance proof", None, 2.0, "mm", "upper_arm_1", "rod_eye_1_1_0")
    first = from_checks(candidate(), KNOWN, [one])
    angles = [from_checks(candidate(), first, [two]).elbow_angle_deg for two in (other, one)]
    assert [angle - candidate().elbow_deg for angle in angles] == pytest.approx([2.0, 4.0])
    cheek = failed("clearance proof", None, 2.0, "mm", "motor_cheek_0", "rod_tube_0_1")  # which ends as rods' text does
    rods, first = (replace(one, worst_pair=("rod_tube_0_0", "rod_tube_2_1")), from_checks(candidate(), KNOWN, [cheek]))
    assert from_checks(candidate(), first, [rods]).least("platform_radius") == 24.5
    steps = [from_checks(candidate(), KNOWN, [replace(one, value=mm)]).elbow_angle_deg for mm in (1.5, 1.9, 1.99)]
    assert [angle - candidate().elbow_deg for angle in steps] == pytest.approx([2.0, 0.13 / 0.08, 0.5])


@pytest.mark.parametrize(
    ("result", "wording"),
    [
        (
            failed("clearance", 1.8765432, 2.0, "mm", "rod_tube_0_0", "rod_tube_2_1"),
            "clearance: 1.877 mm, limit 2 mm, rod tube",
        ),
        (
            failed("clearance proof", None, 2.0, "mm", "rod_tube_0_0", "rod_tube_2_1"),
            "clearance proof: not proved, limit 2 mm, rod tube",
        ),
        (failed("effective mass", None, None), "effective mass: not proved"),
    ],
)
def test_a_lesson_is_reported_in_figures_of_people(result: CheckResult, wording: str) -> None:
    assert from_checks(candidate(), KNOWN, [result]).why[-1] == wording


def test_rods_that_fold_onto_a_motor_are_required_to_unfold() -> None:
    angle = (ELBOW_FIELD, 33.31)  # which more lengths than the height in the field may give
    reason = estimate("rod_tube", "beside the drive", "why", "cube.bottom_height_mm", 57.0, 65.0, angle=angle)
    long = KNOWN.raised("upper_arm_length", 80.0, "").raised("base_radius", 30.0, "")
    _, corrections = from_refusals(brief(), CHOICE, long, [reason])
    assert corrections.elbow_angle_deg == pytest.approx(33.4)
    assert corrections.least("upper_arm_length") == pytest.approx(80.0 * UNFOLDED)  # asked anew
    assert corrections.least("base_radius") == 30.0
    assert KNOWN.with_raised_limits((0.45, 0.0, 30.0)).raised_limits == (0.45, 0.0, 30.0)
    assert corrections.with_raised_limits((0.0, 0.0, 30.0)).raised_limits == corrections.raised_limits
    assert corrections.couple_index_min == KNOWN.couple_index_min


def test_an_arm_that_swings_too_low_gets_longer_where_the_outline_holds_that_and_else_swings_less() -> None:
    """WorkerProcess the base radius that is asked for at the same time."""
    angle, field = (SWING_FIELD, -41.27), "mechanism.upper_arm_length_mm"
    boss = estimate("upper_arm", "beside its cheeks", "why", field, 60.0, 71.0, angle=angle)
    radius = estimate("foot_block", "place", "why", "mechanism.base_radius_mm", 20.0, 29.0)
    reach = Outline(270.0, 220.0, CHOICE.width_mm, KNOWN.overhead_mm).reach_max_mm
    long = replace(boss, bound=reach - 28.5)  # it alone would do
    _, longer = from_refusals(brief(), CHOICE, KNOWN, [boss, radius])
    assert longer.least("upper_arm_length") == 71.0
    assert longer.shoulder_low_deg == KNOWN.shoulder_low_deg == -90.0
    _, less = from_refusals(brief(), CHOICE, KNOWN, [long, radius])
    assert less.least("upper_arm_length") == 0.0
    assert less.shoulder_low_deg == pytest.approx(-41.2)
    assert less.least("base_radius") > 20.0
    _, again = from_refusals(brief(), CHOICE, less, [replace(long, angle=(SWING_FIELD, -45.0)), radius])
    assert again.shoulder_low_deg == less.shoulder_low_deg
    low, high = to_requirements(
        brief(), CHOICE, less, less.mass_estimate.inertia(90.0, 140.0, 1.0)
    ).limits.shoulder_deg or (0.0, 0.0)
    assert low == pytest.approx(-41.2, abs=0.01)
    assert high == pytest.approx(SHOULDER_DEG[1], abs=0.01)


def test_where_the_kernel_makes_no_solid_chains_stand_a_little_farther_out_three_times_at_most() -> None:
    lengths, corrections = (90.0, 140.0, 30.0, 20.0, 70.0, 40.0), Corrections(reference())
    error = BuildError("encoder_cheek", "body", "the solid is not valid")
    for _ in range(KERNEL_TRIES):
        corrections = from_kernel(corrections, lengths, error)
        assert lengths[2] < corrections.least("base_radius") < lengths[2] + 0.5
        lengths = (*lengths[:2], corrections.least("base_radius"), *lengths[3:])
    with pytest.raises(NoProgressError, match="encoder_cheek: body cannot be built"):
        from_kernel(corrections, lengths, error)
    narrow = (*lengths[:2], lengths[2] - 0.1, *lengths[3:])  # no room for what was asked
    with pytest.raises(NoProgressError, match="not valid"):
        from_kernel(Corrections(reference()).raised("base_radius", lengths[2], "kernel"), narrow, error)
    stock = DimensionError([Reason("rod_tube", "stock", "no tube is so long")])
    with pytest.raises(NoProgressError, match="no tube is so long"):
        from_kernel(Corrections(reference()), lengths, stock)


def test_a_solid_that_a_build_refuses_is_tried_a_little_farther_out() -> None:
    made, corrections = candidate(), KNOWN
    wrong = replace(failed("solid encoder_cheek", 9.0, 1.0), detail="its mesh is not watertight")
    other = replace(wrong, name="solid motor_cheek")
    for _ in range(KERNEL_TRIES):
        corrections = from_checks(made, corrections, [wrong, other])
        assert corrections.least("base_radius") > made.lengths_mm[2]
        made = replace(made, lengths_mm=(*LENGTHS[:2], corrections.least("base_radius"), *LENGTHS[3:]))
    assert made.lengths_mm[2] < LENGTHS[2] + 0.5
    with pytest.raises(NoProgressError, match="solid encoder_cheek: its mesh is not watertight"):
        from_checks(made, corrections, [wrong])


def test_a_check_that_teaches_nothing_ends_the_choice() -> None:
    with pytest.raises(NoProgressError, match="parts attached"):
        from_checks(candidate(), KNOWN, [failed("parts attached", 1.0, 0.0)])


def test_the_committed_machine_is_stiff_enough_and_a_softer_knob_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    design = load_design(Path(BEST))
    assert too_soft(design) is None
    knob = SimpleNamespace(least_N_mm=14.5)
    monkeypatch.setattr("delta_cad.structure.report.stiffness", lambda _: knob)
    assert too_soft(design) == (14.5, 15.0)
    unasked = design.requirements.model_copy(update={"stiffness_min_N_mm": None})
    assert too_soft(design.model_copy(update={"requirements": unasked})) is None


def test_what_gravity_takes_of_a_joint_goes_with_the_arms_beyond_those_that_were_weighed() -> None:
    own = replace(KNOWN, mass_estimate=replace(KNOWN.mass_estimate, own=True))
    assert own.at_arm_length(91.0 * 1.019) is own
    assert KNOWN.at_arm_length(182.0) is KNOWN  # of another machine nothing is known
    assert own.at_arm_length(182.0).mass_estimate == replace(
        own.mass_estimate, gravity_torque_N_m=pytest.approx(0.036 * 2.0**1.4)
    )
    assert own.at_arm_length(45.5).held_torque_N_m == pytest.approx(0.036 / 2.0**1.4 + own.torque_margin_N_m)


def test_what_a_motors_shaft_bears_of_a_cable_is_learnt_as_a_force_at_the_sector() -> None:
    corrections = from_cable_pull(KNOWN, candidate().design, 0.96, 1.25)
    sector = candidate().design.hardware.sector_radius_mm
    assert corrections.pull_N == pytest.approx(0.998 * 0.96 / 1.25 / (sector / 1e3))
    assert corrections.with_shares_of(KNOWN).pull_N == KNOWN.pull_N == inf


def test_a_plate_whose_feet_stand_out_says_nothing_of_arms() -> None:
    wide = estimate("base_plate", "envelope depth", "far out", "requirements.envelope_depth_mm", 220.0, 230.0)
    with pytest.raises(NoProgressError, match="far out"):
        from_refusals(brief(), CHOICE, KNOWN, [wide])


def test_feet_that_tip_end_the_search_of_a_choice_whatever_else_is_refused() -> None:
    tips = estimate("base_plate", "standing", "2.6 N tip it", "hardware.mounting", "feet", None)
    longer = estimate("upper_arm", "length", "too short", "mechanism.upper_arm_length_mm", 90.0, 95.0)
    with pytest.raises(NoProgressError, match=r"2\.6 N tip it"):
        from_refusals(brief(), CHOICE, KNOWN, [longer, tips])


def test_chains_in_the_way_of_a_key_are_set_apart() -> None:
    one = candidate()
    width = one.choice.width_mm
    for check, value, unit, more in (("tool access", 0.0, "deg", 1.0), ("chains apart", 2.5, "mm", 2.5)):
        limit = 60.0 if unit == "deg" else 0.0
        corrections = from_checks(one, KNOWN, [failed(check, value, limit, unit, "motor_screw_0_2")])
        assert corrections.least_radius_mm(width) == pytest.approx(LENGTHS[2] + more)
        assert corrections.least_radius_mm(width + 6.0) == pytest.approx(LENGTHS[2] + more - 6.0 * WIDER)
        assert corrections.least_radius_mm(width - 6.0) == pytest.approx(LENGTHS[2] + more + 6.0 * NARROWER)


@pytest.mark.parametrize(
    ("short_mm", "more_mm"),
    [((6.0, 2.0), 4.0), ((2.0, 2.0), 2.0 * FARTHEST), ((0.3, 0.5), 0.5)],
    ids=["where the line through both ends", "it has no end", "too little to measure"],
)
def test_what_keys_lack_again_is_extrapolated(short_mm: tuple[float, float], more_mm: float) -> None:
    first = KNOWN.with_chains_apart(54.0, 31.0, short_mm[0], "")
    assert first.least_radius_mm(54.0) == pytest.approx(31.0 + short_mm[0])
    # 8 mm more met 4 mm of it: the 2 mm that are left take 4
    assert first.with_chains_apart(54.0, 39.0, short_mm[1], "").least_radius_mm(54.0) == pytest.approx(39.0 + more_mm)


def test_what_keys_lack_the_more_the_longer_the_radius_is_not_extrapolated() -> None:
    """At 47 mm of width 1.25 mm of 31.5 and 3.5 mm of 33.25, by solids; at 50 mm 30.87 are enough."""
    first = KNOWN.with_chains_apart(47.0, 31.5, 1.25, "")
    again = first.with_chains_apart(47.0, 33.25, 3.5, "")
    assert again.least_radius_mm(47.0) == pytest.approx(36.75)
    assert again.least_radius_mm(50.0) == pytest.approx(36.75 - 3.0 * WIDER)


def test_room_that_keys_leave_is_learnt_where_the_base_radius_was_made_for_them() -> None:
    one = candidate()
    radius, width = one.lengths_mm[2], one.choice.width_mm
    left = CheckResult("chains apart", True, -1.25, 0.0, "mm")
    interferences = KNOWN.with_chains_apart(width + 2.0, radius - 2.0 * NARROWER - 1.0, 1.0, "of another width")
    assert interferences.least_radius_mm(width) == pytest.approx(radius)
    closer, reserve = with_room(one, interferences, [left])
    assert reserve == 1.25
    assert closer.least_radius_mm(width) == pytest.approx(radius - 1.25)
    for known, found in (
        (KNOWN, left),
        (interferences, replace(left, value=0.0)),
        (interferences.raised("base_radius", radius, ""), left),
    ):
        assert with_room(one, known, [found]) == (known, 0.0)


def test_the_least_base_radius_that_closed_forms_ask_for_is_a_lesson_for_other_machines() -> None:
    design = load_design(Path(BEST))
    m, cube = design.mechanism, design.cube
    lengths = (m.upper_arm_length_mm, m.forearm_length_mm, m.base_radius_mm, m.platform_radius_mm)
    lengths = (*lengths, cube.bottom_height_mm, cube.half_side_mm)
    one = Candidate(design, Selection("maxon-re30-310007", "capstan", 4.86, 50.0), lengths, KNOWN, 83.1)
    least = with_least_radius(one, replace(KNOWN, least_mm={})).least_radius_mm(50.0)

    def requested(radius_mm: float) -> bool:
        moved = design.model_copy(update={"mechanism": m.model_copy(update={"base_radius_mm": radius_mm})})
        return any(reason.field == "mechanism.base_radius_mm" for reason in refusals(moved))

    assert least < m.base_radius_mm
    assert not requested(least + 0.06)
    assert requested(least)
    wider = design.model_copy(update={"mechanism": m.model_copy(update={"base_radius_mm": m.base_radius_mm + 5.0})})
    assert with_least_radius(replace(one, design=wider), KNOWN) is KNOWN  # they ask for nothing so far out


def test_a_platform_that_is_too_thin_becomes_thicker_though_a_thicker_one_meets_its_hub() -> None:
    small = {"hardware.platform_thickness_mm": 10.0, "mechanism.platform_radius_mm": 15.0}
    design = changed(load_design(ROOT / "docs" / "gallery" / "desk-150.json"), small)
    assert design is not None
    found = {one.reason.key: (one.field, one.bound) for one in estimates(design) if one.part == "platform"}
    assert found["platform", "wrist boss"] == ("hardware.platform_thickness_mm", 13.5)
    field, bound = found["platform", "hub"]
    assert field == "mechanism.platform_radius_mm"
    assert bound is not None
    assert 18.0 <= bound < 25.0


def test_a_platform_whose_hub_fits_only_while_it_is_too_thin_becomes_thicker() -> None:
    small = {"hardware.platform_thickness_mm": 10.0, "mechanism.platform_radius_mm": 18.5}
    design = changed(load_design(ROOT / "docs" / "gallery" / "desk-150.json"), small)
    assert design is not None
    found = {one.reason.key: (one.field, one.bound) for one in estimates(design) if one.part == "platform"}
    assert ("platform", "hub") not in found
    assert found["platform", "wrist boss"] == ("hardware.platform_thickness_mm", 13.5)
