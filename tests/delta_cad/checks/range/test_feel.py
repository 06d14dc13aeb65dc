"""Figures of feel over a cube, against a grid over it, and those worse than a default that a design leaves out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.checks.range import feel
from delta_cad.checks.range.feel import feel_figures, poor_figures, poor_verdict
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import masses_from_dict
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.statics import singular_values

VALUES = {"effective_mass_max_kg": 0.5, "friction_max_N": 0.5, "couple_index_min": 0.5, "kappa_max": 2.0}


def test_the_worst_over_the_cube_is_no_better_than_on_a_grid(best: Design, best_masses: dict[str, Any]) -> None:
    values = feel_figures(best, best_masses)
    cube, axis = best.cube, np.linspace(-1.0, 1.0, 15)
    p = np.stack(np.meshgrid(axis, axis, axis), -1).reshape(-1, 3) * cube.half_side_mm
    p = (p + np.array([0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm])) / MM_PER_M
    inertia = masses_from_dict(best_masses, best.geometry.forearm_length, drive_torque(best)).handle_inertia
    s = singular_values(best.geometry, p)
    on_grid = {
        "effective_mass_max_kg": float(effective_mass(best.geometry, p, inertia).max()),
        "kappa_max": float((s.max(axis=-1) / s.min(axis=-1)).max()),
    }
    for key, worst in on_grid.items():
        assert worst <= values[key] * (1.0 + 1e-9)
        assert values[key] == pytest.approx(worst, rel=2e-3)


@pytest.mark.parametrize(
    ("value", "stated", "poor"),
    [(0.604, None, ["effective mass 0.604 kg, at most 0.6"]), (0.602, None, []), (0.604, 1.0, [])],
)
def test_poor_is_what_is_worse_than_a_default_that_was_left_out(
    value: float, stated: float | None, poor: list[str], best: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At 3 N a fifth of a kilogram for each newton; 0.602 kg are 0.6 with the digits that are printed."""
    required = {"force_N": 3.0, "effective_mass_max_kg": stated, "friction_max_N": None, "couple_index_min": None}
    design = best.model_copy(update={"requirements": best.requirements.model_copy(update=required)})

    def found(**values: float) -> list[str]:
        monkeypatch.setattr(feel, "feel_figures", lambda *_: VALUES | values)
        return poor_figures(design, dict[str, Any]())

    assert found(effective_mass_max_kg=value) == poor
    assert found(couple_index_min=0.399) == []
    assert found(couple_index_min=0.39) == ["couple index 0.39, at least 0.4"]
    assert poor_verdict(poor).endswith(poor[0]) if poor else poor_verdict(poor) == ""
