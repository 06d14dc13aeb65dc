"""Numbers of the report: rounded to the side on which they still are true."""

from __future__ import annotations

import pytest

from delta_cad.design import load_design
from optimizer.certify.certificate import limits_of
from optimizer.certify.report import rounded
from tests.committed import BEST


@pytest.mark.parametrize("degrees", [*range(1, 90), 65.5, 27.1])
def test_a_limit_in_degrees_is_reported_as_it_was_given(degrees: float) -> None:
    """It is rounded to its strict side in radians by two doubles at least: never to more than was given."""
    design = load_design(BEST)
    required = design.requirements.model_copy(update={"lean_max_deg": degrees, "shoulder_min_deg": -degrees})
    limits = limits_of(design.model_copy(update={"requirements": required}), None)
    (lean,), (shoulder_min, _) = (limits[name].figures for name in ("lean", "shoulder"))
    assert rounded(limits["lean"].bound(lean) * lean.scale, True) == f"{degrees:g}"
    assert rounded(limits["shoulder"].bound(shoulder_min) * shoulder_min.scale, False) == f"{-degrees:g}"


def test_rounding_keeps_a_bound_true() -> None:
    for x in (2.2676939276602437, 0.1, 54.909705274, -39.24005, 1e-7, 123456.5):
        assert float(rounded(x, True)) >= x >= float(rounded(x, False))
    assert rounded(2.2676931, True) == "2.2677"
    assert rounded(0.8, True) == rounded(0.8, False) == "0.8"
    assert rounded(2.2676931, False) == "2.26769"
