"""Requirements in another unit or with a near miss of a name: refused at once, with what to write."""

from __future__ import annotations

from typing import Any

import pytest

from optimizer.problem.brief import brief_from_dict
from optimizer.problem.quantity import KINDS
from optimizer.problem.requirements import RequirementsError, requirements_from_dict
from optimizer.problem.validation import unit_of
from tests.optimizer.tasks import task

OUTLINE = {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}
WRITTEN = [
    # table, field, what is written, the unit that it is in, what to write
    ("requirements", "envelope_width_mm", 0.27, "m", 270.0),
    ("requirements", "envelope_depth_mm", 22, "cm", 220.0),
    ("requirements", "cube_side_mm", 0.075, "m", 75.0),
    ("requirements", "force_N", 3000, "mN", 3.0),
    ("requirements", "joint_torque_N_m", 400, "mN m", 0.4),
    ("feel", "effective_mass_max_kg", 400, "g", 0.4),
    ("feel", "friction_max_N", 700, "mN", 0.7),
    ("feel", "stiffness_min_N_mm", 8000, "N/m", 8.0),
    ("feel", "position_step_max_mm", 50, "um", 0.05),
]


def refusal(data: dict[str, Any]) -> RequirementsError:
    with pytest.raises(RequirementsError) as caught:
        brief_from_dict({"name": "x", "requirements": OUTLINE} | data)
    return caught.value


@pytest.mark.parametrize(("table", "field", "value", "unit", "meant"), WRITTEN)
def test_a_number_in_another_unit_is_refused_with_the_number_to_write(
    table: str, field: str, value: float, unit: str, meant: float
) -> None:
    data = {"requirements": OUTLINE | ({field: value} if table == "requirements" else {})}
    error = refusal(data if table == "requirements" else data | {table: {field: value}})
    assert error.field == f"{table}.{field}"
    assert error.allowed.endswith(f"; if {unit} were meant write {meant:g}")
    assert float(KINDS[unit_of(table, field)][1][unit]) * value == pytest.approx(meant)
    given = {"requirements": OUTLINE | {"cube_side_mm": 75.0}}
    given[table] = given.get(table, {}) | {field: meant}
    assert getattr(getattr(brief_from_dict({"name": "x"} | given), table), field) == meant


def test_a_number_that_no_unit_explains_has_its_bounds_alone() -> None:
    assert "meant" not in refusal({"feel": {"effective_mass_max_kg": -1}}).allowed
    assert "meant" not in refusal({"feel": {"kappa_max": 0.5}}).allowed


def test_the_first_edition_is_held_to_the_same_units() -> None:
    data = task().model_dump(mode="json", exclude_none=True)
    data["requirements"] |= {"envelope_width_mm": 0.27}
    with pytest.raises(RequirementsError, match="if m were meant write 270"):
        requirements_from_dict(data)


@pytest.mark.parametrize(
    ("data", "meant"),
    [
        ({"hardware": {"motor": "maxon-ec45"}}, "maxon-ec45flat-411812"),
        ({"hardware": {"motor": "ec60-flat-408057"}}, "maxon-ec60flat-408057"),
        ({"feel": {"efective_mass_kg": 0.4}}, "effective_mass_max_kg"),
        ({"requirements": OUTLINE | {"kappa": 2.2}}, "feel.kappa_max"),
        ({"requirements": OUTLINE | {"envelope_hight_mm": 200}}, "height_max_mm"),  # not a width
        ({"requirements": OUTLINE | {"colour_of_the_knob": 200}}, ""),
    ],
)
def test_a_near_miss_names_what_is_close_and_nothing_else(data: dict[str, Any], meant: str) -> None:
    allowed = refusal(data).allowed
    assert (f"did you mean {meant}?" in allowed) == bool(meant)
    assert ("did you mean" in allowed) == bool(meant)
