"""Results of a machine beside set limits; heights and forces by other means."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.holding import holding_torque, moving_bodies
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.export.mass_properties import mass_report
from delta_cad.mechanism.statics import worst_joint_torque
from optimizer.codesign.report import FIGURES, binding, force_N, height_mm, results_of, set_limits
from optimizer.problem.brief import DesignBrief, brief_from_dict


def brief(**tables: dict[str, Any]) -> DesignBrief:
    asked = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0} | tables.pop("requirements", {})
    return brief_from_dict({"name": "b", "requirements": asked, **tables})


def test_a_height_is_that_of_the_solids_with_the_handle_at_the_top(
    best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    cube = best_dimensions.design.cube
    top = np.array([0.0, 0.0, cube.bottom_height_mm + 2.0 * cube.half_side_mm])
    ends = []
    for occurrence in best_assembly.occurrences:
        if not occurrence.name.startswith(("foot", "knob", "base_plate")):
            continue
        box, pose = occurrence.part.solid.BoundingBox(), best_assembly.poses(top)[occurrence.name]
        assert pose[2, 2] == pytest.approx(1.0)  # upright
        ends += [box.zmin + pose[2, 3], box.zmax + pose[2, 3]]
    assert height_mm(best_dimensions) == pytest.approx(max(ends) - min(ends), abs=1e-3)


def test_a_force_takes_all_of_the_torque_beside_the_weight_somewhere_and_no_more_anywhere(
    best: Design, best_assembly: Assembly
) -> None:
    """Against torques on a grid over the cube, by the weight of all bodies and the worst direction of a force."""
    masses = mass_report(best_assembly)
    torque = best.requirements.joint_torque_N_m
    force = force_N(best, masses, torque)
    axis = np.linspace(-1.0, 1.0, 21) * best.cube.half_side_mm
    middle = best.cube.bottom_height_mm + best.cube.half_side_mm
    p = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3) + np.array([0.0, 0.0, middle])
    weight = np.abs(holding_torque(best_assembly, moving_bodies(masses), p, np.array(best.requirements.gravity_m_s2)))
    per_N = worst_joint_torque(best.geometry, p / MM_PER_M, 1.0)
    on_grid = float(np.min((torque - weight) / per_N))
    assert force <= on_grid
    assert force == pytest.approx(on_grid, rel=2e-3)
    assert force_N(best, masses, 1e-6) == 0.0


def test_all_that_is_always_told_is_known_of_a_machine_without_limits(best: Design, best_assembly: Assembly) -> None:
    bare = best.requirements.model_copy(
        update=dict.fromkeys(("effective_mass_max_kg", "friction_max_N", "stiffness_min_N_mm", "peak_force_N"))
    )
    outcome = SimpleNamespace(
        design=best.model_copy(update={"requirements": bare}),
        masses=mass_report(best_assembly),
        results=[CheckResult("kappa", True, 2.5, None, "")],
    )
    values = results_of(cast(Any, outcome))
    limits = best.requirements.model_dump()
    assert {one.key for one in FIGURES if one.head} <= set(values)
    assert values["kappa_max"] == 2.5  # a check's figure is that of the check
    assert limits["force_N"] <= values["force_N"] < values["peak_force_N"]
    for key in ("effective_mass_max_kg", "friction_max_N"):
        assert 0.0 < values[key] <= (limits[key] or 2.0)


def test_what_binds_are_limits_that_the_file_sets() -> None:
    """0.69 N of friction bind where 0.695 are set; not where nothing is; 2 mm of clearance are a default."""
    values = {"friction_max_N": 0.69, "force_N": 3.0, "clearance_mm": 2.0, "kappa_max": 2.27}
    task = brief(feel={"friction_max_N": 0.695, "kappa_max": 3.0})
    assert [one.figure.field for one in binding(task, values)] == ["feel.friction_max_N"]
    assert [one.figure.field for one in set_limits(task, values)] == ["feel.kappa_max", "feel.friction_max_N"][::-1]
    assert binding(brief(), values) == []
    task = brief(requirements={"force_N": 3.0, "clearance_min_mm": 1.0})
    assert [one.figure.field for one in binding(task, values)] == ["requirements.force_N"]


def test_a_limit_of_the_first_edition_is_set_where_a_brief_has_it() -> None:
    task = brief(limits={"kappa_max": 2.28})
    assert [one.figure.field for one in binding(task, {"kappa_max": 2.27})] == ["feel.kappa_max"]


def test_every_limit_of_a_figure_is_a_field_of_the_requirements_and_of_one_figure() -> None:
    fields = [one.field for one in FIGURES if one.field]
    assert len(set(fields)) == len(fields)
    for name in fields:
        brief().value(name)  # a field of the requirements
