"""Eyes and plates that are turned, slid, missing or filled are named."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from tests.delta_cad.assembly.expected.anchors import anchor_faults, expected_anchors
from tests.delta_cad.checks.machines import at, changed

EYE = "rod_eye_1_0_0"
ABOUT_X = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


def faults_moved(a: Assembly, d: Dimensions, name: str, by: np.ndarray) -> list[str]:
    (one,) = [o for o in a.occurrences if o.name == name]
    return anchor_faults(changed(a, name, placement=one.placement @ by), d)


def test_the_eyes_of_a_spring_are_level(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """On rods that are parallel: from one eye to the other the spring lies along the shoulder's axis."""
    assert anchor_faults(best_assembly, best_dimensions) == []
    anchors = expected_anchors(best_dimensions)
    assert [anchor.name for anchor in anchors].count("base_plate") == 6
    points = {one.name: np.array(one.point_mm) for one in anchors if one.name.startswith("rod_eye")}
    assert len(points) == 12
    for k in range(2):
        across = points[f"rod_eye_0_0_{k}"] - points[f"rod_eye_0_1_{k}"]
        assert across[0] == across[2] == 0.0


@pytest.mark.parametrize(
    "by",
    [ABOUT_X, ABOUT_X @ ABOUT_X, at(15.0), at(0.2), at(y=-0.2)],
    ids=["quarter", "half", "slid", "a little", "off"],
)
def test_an_eye_off_its_spring_is_named(best_assembly: Assembly, best_dimensions: Dimensions, by: np.ndarray) -> None:
    (fault,) = faults_moved(best_assembly, best_dimensions, EYE, by)
    assert fault.startswith(EYE)


@pytest.mark.parametrize("name", ["base_plate", "platform"])
def test_a_plate_whose_bores_are_elsewhere_is_named(
    best_assembly: Assembly, best_dimensions: Dimensions, name: str
) -> None:
    faults = faults_moved(best_assembly, best_dimensions, name, at(0.25))
    assert faults
    assert all(fault.startswith(name) for fault in faults)


def test_an_eye_that_is_missing_or_filled_is_named(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    rest = tuple(o for o in best_assembly.occurrences if o.name != EYE)
    tube = next(o.part for o in best_assembly.occurrences if o.name == "handle_stem")
    for a in (replace(best_assembly, occurrences=rest), changed(best_assembly, EYE, part=tube)):
        (fault,) = anchor_faults(a, best_dimensions)
        assert "inf mm off" in fault
