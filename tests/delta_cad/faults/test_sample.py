"""A sample of the planted faults, all that can be done to the shoulder's shaft; all of all parts by `make faults`."""

import pytest

from tests.delta_cad.faults.misses import excuse
from tests.delta_cad.faults.planting import faults, sound
from tests.delta_cad.faults.refusing import Refusing


@pytest.mark.slow
def test_whatever_is_wrong_with_a_shaft_is_refused() -> None:
    refusing = Refusing(sound())
    seen = 0
    for fault in faults(("shoulder_shaft",), others=False):
        if excuse(fault.name) is None:  # what is missed goes through every check, which takes 40 s
            assert refusing.first_refusal(fault.assembly) is not None, fault.name
            seen += 1
    assert seen >= 12


def test_only_named_faults_are_excused() -> None:
    assert excuse("base_dowel_0_1: shifted by 0.5 mm along z") is not None
    assert excuse("base_dowel_0_1: shifted by 0.5 mm along x") is None
