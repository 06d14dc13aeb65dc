"""Set screws that do not press on their shaft are refused."""

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.engagement import check_contacts, tip_length
from delta_cad.checks.contact.features import features
from tests.delta_cad.checks.machines import at, changed, rod


def test_a_set_screw_that_is_backed_out_is_refused(best_assembly: Assembly) -> None:
    (one,) = [o for o in best_assembly.occurrences if o.name == "set_screw_1_0"]
    result = check_contacts(changed(best_assembly, one.name, placement=one.placement @ at(z=0.1)))
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
