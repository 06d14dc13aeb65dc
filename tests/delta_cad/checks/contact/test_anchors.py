"""Eyes that are turned, slid or missing are refused, and set screws that do not press on their shaft."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.anchors import check_anchors
from delta_cad.checks.contact.engagement import check_contacts, tip_length
from delta_cad.checks.contact.features import features
from tests.delta_cad.checks.machines import at, changed, machine, rod

EYE = "rod_eye_1_0_0"
ABOUT_X = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=float)


def moved(a: Assembly, name: str, by: np.ndarray) -> Assembly:
    (one,) = [o for o in a.occurrences if o.name == name]
    return changed(a, name, placement=one.placement @ by)


def test_the_eyes_of_the_machine_lie_on_the_lines_of_their_springs(best_assembly: Assembly) -> None:
    result = check_anchors(best_assembly)
    assert result.passed, result.detail
    assert result.value == pytest.approx(0.0, abs=1e-9)
    assert Counter(anchor.name for anchor in best_assembly.anchors)["base_plate"] == 6
    # a spring's two eyes are level, on rods that are parallel: from one to the other it lies along the shoulder's axis
    points = {one.name: np.array(one.point_mm) for one in best_assembly.anchors if one.name.startswith("rod_eye")}
    assert len(points) == 12
    for k in range(2):
        across = points[f"rod_eye_0_0_{k}"] - points[f"rod_eye_0_1_{k}"]
        assert across[0] == across[2] == 0.0


@pytest.mark.parametrize(
    "by",
    [ABOUT_X, ABOUT_X @ ABOUT_X, at(15.0), at(0.2), at(y=-0.2)],
    ids=["quarter", "half", "slid", "a little", "off"],
)
def test_an_eye_off_its_spring_is_refused(best_assembly: Assembly, by: np.ndarray) -> None:
    result = check_anchors(moved(best_assembly, EYE, by))
    assert not result.passed
    assert result.worst_pair == (EYE,)
    assert EYE in result.detail


@pytest.mark.parametrize("name", ["base_plate", "platform"])
def test_a_plate_whose_bores_are_elsewhere_is_refused(best_assembly: Assembly, name: str) -> None:
    result = check_anchors(moved(best_assembly, name, at(0.25)))
    assert not result.passed
    assert result.worst_pair == (name,)


def test_an_eye_that_is_missing_or_filled_is_refused(best_assembly: Assembly) -> None:
    rest = tuple(o for o in best_assembly.occurrences if o.name != EYE)
    (one,) = [o for o in best_assembly.occurrences if o.name == EYE]
    tube = next(o.part for o in best_assembly.occurrences if o.name == "handle_stem")
    for a in (replace(best_assembly, occurrences=rest), changed(best_assembly, one.name, part=tube)):
        result = check_anchors(a)
        assert (result.passed, result.value) == (False, None)
        assert "has no bore" in result.detail


def test_a_machine_that_states_no_place_is_refused() -> None:
    assert check_anchors(machine()).passed
    assert not check_anchors(replace(machine(), anchors=())).passed


def test_a_set_screw_that_is_backed_out_is_refused(best_assembly: Assembly) -> None:
    result = check_contacts(moved(best_assembly, "set_screw_1_0", at(z=0.1)))
    assert not result.passed
    assert result.worst_pair == ("set_screw_1_0", "motor_1")


def test_a_tip_lies_along_its_shaft_where_it_touches_it() -> None:
    shaft, screw = features(rod(2.0, (0, 0, 0), (10, 0, 0))), features(rod(1.0, (0, 0, 0), (0, 0, 4)))

    def found(x: float, y: float, z: float) -> float:
        return tip_length(screw, shaft, at(x, y, z), 0.02)

    assert found(5.0, 0.0, 2.0) == pytest.approx(2.0)
    assert found(5.0, 0.0, 2.01) == pytest.approx(2.0)
    assert found(5.0, 0.6, 2.0) == pytest.approx(1.6)  # beside the middle: a chord
    assert found(9.5, 0.0, 2.0) == pytest.approx(1.5)  # over the shaft's end
    assert found(5.0, 0.0, 2.03) == found(5.0, 1.1, 2.0) == found(5.0, 0.0, 1.9) == 0.0
    assert found(5.0, 0.0, -2.0) == 0.0  # from the wrong side
