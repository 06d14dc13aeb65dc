"""Requirements that no machine meets, whatever its hardware: shown by proof before any hardware is searched.

The best of all hardware that may be used is taken at once: the largest torque, the least rotor, friction, count and
base radius, no weight and no outline beyond eq. (1). What the lengths cannot do with that, no machine does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from delta_cad import catalogue
from delta_cad.mechanism.limits import HandleInertia
from optimizer.codesign.bound import STARTS, Kind, allowed_drives, kept_limits
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection, drives, motor_of, ratios_of
from optimizer.codesign.lengths import to_requirements
from optimizer.globalopt.optimum import none_feasible
from optimizer.problem.brief import DesignBrief
from optimizer.problem.step import SIDE, Problem, step_problem
from optimizer.search import sqp

BOXES = 8_000  # of designs in one proof, a second at most
HALVINGS = 3  # of the interval between a value that is excluded and one that is not
WIDER = 1.5  # factor by which an outline that is too small is widened at most
LEAST_SIDE_MM = 10.0  # of a cube, where none is asked
NEXT_TO_NONE_KG = 1e-6


def excluded(brief: DesignBrief, stop: Callable[[], bool] = bool) -> str:
    """Finds out whether the cube and the outline that are asked exclude one another, with a bound on the cube, or else
    on the outline.

    Args:
        brief: The requirements.
        stop: True ends a proof without a result.

    Returns:
        Fields, values, the bound and the machines that it holds for; "" where nothing is excluded, or the outline is
        free.
    """
    if brief.outline_mm is None or not _none(brief, stop):
        return ""
    task = brief.requirements

    def widened(factor: float) -> DesignBrief:
        width, depth = (factor * side for side in brief.outline_mm or ())
        return _with(brief, envelope_width_mm=width, envelope_depth_mm=depth)

    none = f"with less, it is proved, there is no machine with {kind(brief).words}"
    if (side := task.cube_side_mm) is not None and (found := _largest_mm(brief)) > 0.0:
        bound = _edge(side, found, lambda cube: _none(_with(brief, cube_side_mm=cube), stop))
        none = none.replace("less", "more", 1)
        return f"requirements.cube_side_mm = {side:g}: must be < {bound:.4g} mm in this outline: {none}"
    factor = _edge(1.0, WIDER, lambda factor: _none(widened(factor), stop))
    asked, least = (" and ".join(f"{one:.4g}" for one in widened(by).outline_mm or ()) for by in (1.0, factor))
    return f"requirements.envelope_width_mm and envelope_depth_mm = {asked}: must be > {least} mm: {none}"


def _edge(excluded_at: float, able: float, none: Callable[[float], bool]) -> float:
    """Comes closer from a value that is excluded to one that is not, and gives the last that is excluded."""
    for _ in range(HALVINGS):
        middle = math.sqrt(excluded_at * able)
        excluded_at, able = (middle, able) if none(middle) else (excluded_at, middle)
    return excluded_at


def _with(brief: DesignBrief, **changed: float) -> DesignBrief:
    return brief.model_copy(update={"requirements": brief.requirements.model_copy(update=changed)})


def _largest_mm(brief: DesignBrief) -> float:
    """The largest cube that a search finds with the best of all hardware, mm; 0 where it finds none."""
    problem = relaxed(
        brief.model_copy(update={"requirements": brief.requirements.model_copy(update={"cube_side_mm": None})})
    )
    best = sqp.search(problem, sqp.start_points(problem, 0, STARTS)).best
    return 0.0 if best is None else 2.0 * problem.lengths_mm(best.x)[SIDE]


def _none(brief: DesignBrief, stop: Callable[[], bool]) -> bool:
    return none_feasible(relaxed(brief), BOXES, stop)


def kind(brief: DesignBrief) -> Kind:
    """Describes the machines that are excluded."""
    wider = brief.limits.parallelogram_width_mm is None
    return Kind(_width_mm(brief), allowed_drives(brief), kept_limits(brief), wider)


def _width_mm(brief: DesignBrief) -> float:
    """The least width of a parallelogram: a spring is between its rods."""
    stated = brief.limits.parallelogram_width_mm
    return stated or min(row.free_length_mm for row in catalogue.tension_spring.rows.values())


def relaxed(brief: DesignBrief) -> Problem:
    """Poses the lengths of a machine of the best of all hardware that may be used.

    Args:
        brief: The requirements.

    Returns:
        Step 2 of a problem whose feasible lengths contain those of every machine that meets the requirements.
    """
    light = Corrections(
        replace(reference(), gravity_torque_N_m=0.0),
        overhead_mm=(0.0, 0.0),
        mass_share=1.0,
        friction_share=1.0,
        step_share=1.0,
        ball_friction_N=(0.0, 0.0),
        spare_torque_N_m=0.0,
    )
    each = []
    for motor, drive in drives(brief):
        low, high = ratios_of(brief) if drive == "capstan" else (1.0, 1.0)
        near, far = (Selection(motor, drive, ratio, _width_mm(brief)) for ratio in (low, high))
        inertia = HandleInertia(NEXT_TO_NONE_KG, 0.0, 0.0, motor_of(brief, motor).rotor_inertia_kg_m2 * low**2)
        each.append(to_requirements(brief, near, light, inertia, far=far))
    first = each[0]
    assert first.inertia is not None
    joints = [one.joints for one in each if one.joints is not None]
    least = {name: min(getattr(one, name) for one in joints) for name in ("friction_N_m", "encoder_count_deg")}
    rotor = min(one.inertia.joint_inertia_kg_m2 for one in each if one.inertia is not None)
    best = first.model_copy(
        update={
            "requirements": max((one.requirements for one in each), key=lambda task: task.joint_torque_N_m),
            "inertia": first.inertia.model_copy(update={"joint_inertia_kg_m2": rotor}),
            "joints": joints[0].model_copy(update=least),
            "bounds_mm": min((one.bounds_mm for one in each), key=lambda bounds: bounds.base_radius[0]),
        }
    )
    problem = step_problem(best, 2)
    side = max(problem.lower[SIDE], LEAST_SIDE_MM / 2.0)
    return replace(problem, lower=(*problem.lower[:SIDE], min(side, problem.upper[SIDE])))
