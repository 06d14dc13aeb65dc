"""What a bound takes of an interval of hardware, against machines of the family: never worse, and nothing given away.

Machines are drawn with heavier parts, other ratios, arms, forearms and pinions, their figures by formulas written out
here. Where an interval is one ratio and one arm, parts weigh 0.99 of the known machine's and rods are ends alone, the
two must agree: a bound that lets more through proves less than it says it does, one that lets less through is wrong.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any, cast

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.limits.effective_mass import HandleInertia, effective_mass
from optimizer.codesign.bound import Family, Interval
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import continuous_torque_N_m, to_requirements
from optimizer.problem.brief import DesignBrief, brief_from_dict
from optimizer.problem.requirements import Requirements

ROTORS = {"maxon-re30-310009-500": 3.47e-6, "maxon-re50-370354": 5.6e-5}  # kg m^2, of their rows
MOTOR = "maxon-re30-310009-500"  # 2000 counts a turn, 89.7 mN m for ever, 3 times that for a moment
KNOWN = Corrections(
    replace(reference(), own=True),
    least_mm={"base_radius": 31.0, "platform_radius": 24.0},
    overhead_mm=(10.0, 13.5),
    ball_friction_N=(0.12, 0.18),
    pull_N=20.0,
)
LENGTHS_MM = (91.0, 143.0, 35.0, 26.0, 64.0, 43.0)
RATIOS, ARMS_MM = (4.0, 6.0), (80.0, 100.0)
GEOMETRY, PLACES = (
    DeltaGeometry(0.031, 0.024, 0.091, 0.143),
    [[0.0, 0.0, 0.105], [0.03, -0.02, 0.08], [-0.02, 0.03, 0.13]],
)


@cache
def brief(peak_N: float | None = None) -> DesignBrief:
    requirements = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0, "force_N": 3.0}
    if peak_N is not None:
        requirements["peak_force_N"] = peak_N
    feel = {"kappa_max": 2.27, "effective_mass_max_kg": 0.4, "friction_max_N": 1.0, "position_step_max_mm": 0.1}
    hardware = {"motor": list(ROTORS), "drive": "capstan", "encoder_at": "motor"}
    return brief_from_dict({"name": "b", "requirements": requirements, "feel": feel, "hardware": hardware})


@cache
def family(peak_N: float | None = None) -> Family:
    choice = Selection(MOTOR, "capstan", 4.8, 50.0)
    machine = Candidate(cast(Design, None), choice, LENGTHS_MM, KNOWN, 86.0)
    return Family(brief(peak_N), machine, {(MOTOR, "capstan"): KNOWN})


def inertia(
    ratio: float, arm_mm: float, forearm_mm: float, times: np.ndarray, rotor: float, pinion: float = 0.0
) -> HandleInertia:
    """By hand: half of a rod grows with its length, an arm's inertia with its length to 1.9; see `reference`."""
    platform, arm, elbow, cross, wrist = times * (0.065, 1.85e-4, 0.0038, 0.0014, 0.0038)
    rods = 0.5 + 0.5 * forearm_mm / 143.0
    joint = arm * (arm_mm / 91.0) ** 1.9 + (rotor + pinion) * ratio**2
    return HandleInertia(platform + 3.0 * wrist * rods, elbow * rods, cross * rods, joint)


def relaxed(peak_N: float | None, one: Interval) -> Requirements:
    """As `best_of` poses an interval."""
    made = family(peak_N)
    choice, far, corrections = made._relaxed(one)
    return to_requirements(brief(peak_N), choice, corrections, made._inertia(made._lightest(one), one), far=far)


def figures(given: Requirements) -> dict[str, float]:
    """Figures of which less lets a bound be higher; what should be large has its sign changed."""
    moves, joints, limits = given.inertia, given.joints, given.limits
    assert moves is not None
    assert joints is not None
    assert limits.outline_overhead_mm is not None
    low, high = limits.shoulder_deg or (0.0, 0.0)
    bounds = given.bounds_mm.model_dump(exclude_none=True)
    return {
        **moves.model_dump(),
        **joints.model_dump(),
        "torque": -given.requirements.joint_torque_N_m,
        "gravity": limits.gravity_torque_N_m,
        "along": limits.outline_overhead_mm[0],
        "across": limits.outline_overhead_mm[1],
        "kappa": -(limits.kappa_max or 0.0),
        "couple": limits.couple_index_min or 0.0,
        "lean": -(limits.lean_max_deg or 0.0),
        "low": low,
        "high": -high,
        "mass": -(limits.effective_mass_max_kg or 0.0),
        "friction": -(limits.friction_max_N or 0.0),
        "step": -(limits.position_step_max_mm or 0.0),
        **{f"least {name}": low for name, (low, _) in bounds.items()},
        **{f"most {name}": -high for name, (_, high) in bounds.items()},
    }


def assert_none_better(found: Requirements, one: Interval, rng: np.random.Generator, peak_N: float | None) -> None:
    ratio, arm = rng.uniform(*one.ratios), rng.uniform(*one.arms_mm)
    times = rng.uniform(0.99, 2.0, 5)
    moves = inertia(ratio, arm, rng.uniform(40.0, 300.0), times, ROTORS[one.motor], rng.uniform(0.0, 3e-6))
    weighed = replace(KNOWN.mass_estimate, gravity_torque_N_m=0.036 * rng.uniform(0.99, 2.0))
    ball, longer = rng.uniform(0.99, 2.0), rng.uniform(0.0, 3.0)
    corrections = replace(
        KNOWN,
        mass_estimate=weighed,
        ball_friction_N=(0.12 * ball, 0.18 * ball),
        overhead_mm=(10.0 + longer, 13.5 + longer),
        pull_N=20.0 * rng.uniform(0.5, 1.0),
    )
    choice = Selection(one.motor, "capstan", ratio, 50.0, wider_mm=rng.uniform(0.0, 1.0))
    drawn, bound = figures(to_requirements(brief(peak_N), choice, corrections, moves, far=choice)), figures(found)
    worse = {name for name, value in bound.items() if value > drawn[name] * (1.0 + 1e-12 * np.sign(drawn[name]))}
    assert not worse
    least = found.inertia
    assert least is not None
    own = HandleInertia(*(getattr(least, f"{name}_kg{'_m2' if 'inertia' in name else ''}") for name in vars(moves)))
    assert (effective_mass(GEOMETRY, np.array(PLACES), own) <= effective_mass(GEOMETRY, np.array(PLACES), moves)).all()


# of the other motor nothing is known of how hard its cable may pull
@pytest.mark.parametrize(("motor", "peak_N"), [(MOTOR, None), (MOTOR, 8.0), ("maxon-re50-370354", None)])
def test_no_machine_of_an_interval_is_better_than_what_is_taken_of_it(motor: str, peak_N: float | None) -> None:
    rng = np.random.default_rng(5)
    for ratios, arms in ((RATIOS, ARMS_MM), ((4.7, 4.9), (90.0, 92.0))):
        one = Interval(motor, "capstan", ratios, arms)
        found = relaxed(peak_N, one)
        for _ in range(40):
            assert_none_better(found, one, rng, peak_N)


def test_nothing_is_given_away_where_the_interval_is_one_machine() -> None:
    """RE 30 with encoder at 4.8 : 1, arms of 95 mm: each figure by hand."""
    found = figures(relaxed(None, Interval(MOTOR, "capstan", (4.8, 4.8), (95.0, 95.0))))
    moves = vars(inertia(4.8, 95.0, 0.0, np.full(5, 0.99), 3.47e-6))
    expected: dict[str, Any] = {
        "carried_mass_kg": moves["carried_mass"],
        "elbow_mass_kg": moves["elbow_mass"],
        "cross_mass_kg": moves["cross_mass"],
        "joint_inertia_kg_m2": moves["joint_inertia"],
        "friction_N_m": 0.6 * 4.8 * 0.16 / 3.28 * 0.0897,
        "ball_upright_N": 0.99 * 0.12,
        "ball_level_N": 0.99 * 0.18,
        "encoder_count_deg": 360.0 / 2000.0 / 4.8,
        "torque": -0.4133,  # 4.8 x 0.96 x 0.0897 = 0.41334, in whole tenths of a mN m
        "gravity": 0.99 * 0.036,
        "along": 9.8,
        "across": 13.3,
        "kappa": -2.27,
        "couple": 0.4,
        "lean": -28.0,
        "low": -60.0,
        "high": -65.0,
        "mass": -0.4,
        "friction": -1.0,
        "step": -0.1,
        "least base_radius": 31.0,
        "least platform_radius": 24.0,
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected, rel=1e-12)
    assert moves["carried_mass"] == pytest.approx(0.99 * (0.065 + 3 * 0.0038 / 2))


def test_the_ends_of_an_interval_are_taken_where_each_helps() -> None:
    """Rotor and friction of 4 : 1, torque and encoder of 6 : 1, inertia of the arm of 80 mm."""
    found = figures(relaxed(None, Interval(MOTOR, "capstan", RATIOS, ARMS_MM)))
    assert found["joint_inertia_kg_m2"] == pytest.approx(0.99 * 1.85e-4 * (80.0 / 91.0) ** 1.9 + 16.0 * 3.47e-6)
    assert found["friction_N_m"] == pytest.approx(0.6 * 4.0 * 0.16 / 3.28 * 0.0897)
    assert found["torque"] == pytest.approx(-int(6.0 * 0.96 * 0.0897 * 1e4) / 1e4)
    assert found["encoder_count_deg"] == pytest.approx(360.0 / 2000.0 / 6.0)


def test_a_shaft_bears_a_hundredth_more_of_a_cable_than_was_found() -> None:
    """8 N / 0.99 at the largest sector, 70 mm, for 8 N of peak: of it 3 N beside the weight's share for ever."""
    weak = replace(KNOWN, pull_N=8.0)
    choice = Selection(MOTOR, "capstan", 4.8, 50.0)
    anywhere = brief_from_dict(
        {
            "name": "b",
            "requirements": {"cube_side_mm": 60.0, "force_N": 3.0, "peak_force_N": 8.0},
            "hardware": {"motor": MOTOR, "drive": "capstan"},
        }
    )
    machine = Candidate(cast(Design, None), choice, LENGTHS_MM, weak, 86.0)
    made = Family(anywhere, machine, {(MOTOR, "capstan"): weak})
    near, far, corrections = made._relaxed(Interval(MOTOR, "capstan", (4.8, 4.8), (95.0, 95.0)))
    held, most = 0.99 * 0.036, 0.070 * 8.0 / 0.99
    assert near.ratio == far.ratio == 4.8
    assert continuous_torque_N_m(anywhere, far, corrections) == pytest.approx(held + (most - held) * 3.0 / 8.0)


def test_intervals_hold_every_ratio_and_arm_of_the_family() -> None:
    made, rng = list(family().intervals()), np.random.default_rng(2)
    assert {one.motor for one in made} == set(ROTORS)
    for motor in ROTORS:
        for ratio in (3.0, 12.0, *rng.uniform(3.0, 12.0, 50)):
            within = [one for one in made if one.motor == motor and one.ratios[0] <= ratio <= one.ratios[1]]
            assert within
            assert {one.arms_mm for one in within} == {(30.0, 220.0 / 1.5)}
