"""Lengths of a candidate: the largest cube, or the least machine, that its hardware and what is known of it allow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from delta_cad.dimensions.forearm import wrist_radius_min_mm
from delta_cad.mechanism.limits import HandleInertia
from optimizer.codesign.candidate import BASE_ENTRIES
from optimizer.codesign.choice import Choice, motor_of
from optimizer.codesign.lessons import LEAN_DEG, SHOULDER_DEG, Lessons
from optimizer.problem.brief import DesignBrief
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.requirements import Requirements, requirements_from_dict
from optimizer.problem.step import SIDE, step_problem
from optimizer.search import sqp
from optimizer.search.result import Result

WIDE_MM = {
    "upper_arm_length": (30.0, 400.0),
    "forearm_length": (40.0, 800.0),
    "base_radius": (15.0, 200.0),
    "platform_radius": (12.0, 150.0),
    "bottom_height": (5.0, 800.0),
    "half_side": (0.0, 300.0),
}
"""Where lengths are looked for that the brief leaves open."""
FREE_OUTLINE_MM = 2000.0
CUP_MM = 1.7  # of a cup beyond its ball, at least
ROUNDS = 3  # of lengths and the inertia estimated for them
SETTLED = 2e-3  # share of the side that the last round changed
STARTS = 2  # of SQP beside the lengths that are known


def posed(
    brief: DesignBrief, choice: Choice, lessons: Lessons, inertia: HandleInertia, side_mm: float | None = None
) -> Requirements:
    """Poses the lengths of a candidate as requirements of the first edition, whose second step finds the largest cube.

    Args:
        brief: What the customer asks.
        choice: Hardware.
        lessons: What is known of it.
        inertia: Of the machine, estimated.
        side_mm: Side of the cube; None where it is sought.
    """
    task, limits = brief.requirements, brief.limits
    outline = brief.outline_mm or (FREE_OUTLINE_MM, FREE_OUTLINE_MM)
    overhead = lessons.overhead_mm if brief.outline_mm else (0.0, 0.0)
    bounds = {}
    ball = float(choice.entries.get("ball_diameter_mm", BASE_ENTRIES["ball_diameter_mm"]))
    by_parts = {
        "platform_radius": wrist_radius_min_mm(ball / 2 + CUP_MM, choice.width_mm, task.clearance_min_mm),
        "base_radius": choice.base_radius_mm,
    }
    for name in VARIABLES:
        low, high = getattr(brief.bounds_mm, name) or WIDE_MM[name]
        least = max(lessons.least(name), by_parts.get(name, 0.0))
        bounds[name] = [max(low, min(least, high)), high]
    if side_mm is not None:
        bounds["half_side"] = [side_mm / 2.0, side_mm / 2.0]
    elif task.cube_side_mm is not None:
        bounds["half_side"][0] = task.cube_side_mm / 2.0
    low_deg, high_deg = limits.shoulder_deg or SHOULDER_DEG
    asked: dict[str, Any] = {
        "parallelogram_width_mm": choice.width_mm,
        "outline_overhead_mm": list(overhead),
        "kappa_max": min(brief.feel.kappa_max or lessons.kappa_max, lessons.kappa_max),
        "couple_index_min": max(brief.feel.couple_index_min or 0.0, lessons.couple_index_min),
        "lean_max_deg": limits.lean_max_deg or LEAN_DEG,
        "shoulder_deg": [low_deg, high_deg],
        "gravity_torque_N_m": lessons.held_torque_N_m,
    }
    if limits.outline_radius_max_mm is not None:
        asked["outline_radius_max_mm"] = limits.outline_radius_max_mm
    if brief.feel.effective_mass_max_kg is not None:
        asked["effective_mass_max_kg"] = brief.feel.effective_mass_max_kg * lessons.mass_share
    data = {
        "name": brief.name,
        "requirements": {
            "envelope_width_mm": outline[0],
            "envelope_depth_mm": outline[1],
            "force_N": task.force_N,
            "joint_torque_N_m": choice.torque_N_m(motor_of(brief, choice.motor)),
        },
        "bounds_mm": bounds,
        "limits": asked,
        "inertia": {
            "carried_mass_kg": inertia.carried_mass,
            "elbow_mass_kg": inertia.elbow_mass,
            "cross_mass_kg": inertia.cross_mass,
            "joint_inertia_kg_m2": inertia.joint_inertia,
        },
    }
    return requirements_from_dict(data, f"{brief.name} with {choice.motor}")


def best_lengths(
    brief: DesignBrief,
    choice: Choice,
    lessons: Lessons,
    start_mm: Sequence[float] | None = None,
    seed: int = 0,
    rounds: int = ROUNDS,
) -> Result | None:
    """Finds the lengths of the largest cube.

    Args:
        brief: What the customer asks.
        choice: Hardware.
        lessons: What is known of it.
        start_mm: (6) lengths to begin from, in the order of `VARIABLES`; None: points of a hypercube.
        seed: Of these.
        rounds: Of lengths and the inertia estimated for them.

    Returns:
        The second step's result; None where there is none.
    """
    at = start_mm or (lessons.weighed.upper_arm_mm, lessons.weighed.forearm_mm)
    start, previous = start_mm, 0.0
    result: Result | None = None
    for _ in range(rounds):
        inertia = lessons.weighed.inertia(at[0], at[1], choice.ratio)
        problem = step_problem(posed(brief, choice, lessons, inertia), 2)
        best = None
        if start is not None:
            best = sqp.search(problem, problem.scaled(start)[None]).best
        if best is None:
            best = sqp.search(problem, sqp.start_points(problem, seed)[:STARTS]).best
        if best is None:
            return None
        result = Result(problem, "sqp", problem.lengths_mm(best.x), "converged")
        start = at = result.design_mm
        side = 2.0 * result.design_mm[SIDE]
        if abs(side - previous) <= SETTLED * side:
            break
        previous = side
    return result
