"""A sample of the planted faults, all that can be done to the shoulder's shaft; all of all parts by `make faults`."""

from dataclasses import replace

import numpy as np
import pytest

from tests.delta_cad.checks.faults.misses import excuse
from tests.delta_cad.checks.faults.planting import faults, sound
from tests.delta_cad.checks.faults.refusing import Refusing, only_of
from tests.delta_cad.checks.machines import check_clearance


@pytest.mark.slow
def test_whatever_is_wrong_with_a_shaft_is_refused() -> None:
    refusing = Refusing(sound())
    seen = 0
    for fault in faults(("shoulder_shaft",), others=False):
        if excuse(fault.name) is None:  # what is missed goes through every check, which takes 40 s
            assert refusing.first_refusal(fault.assembly) is not None, fault.name
            seen += 1
    assert seen >= 12


@pytest.mark.slow
def test_what_a_fault_leaves_as_it_was_is_not_looked_at_again_and_the_verdict_is_the_same() -> None:
    """A motor 15 mm too high, of which only pairs that it is in are held apart: the same pair is refused as of all."""
    refusing, up = Refusing(sound()), np.eye(4)
    up[2, 3] = 15.0
    moved = tuple(replace(o, placement=up @ o.placement) if o.name == "motor_1" else o for o in sound().occurrences)
    wrong = replace(sound(), occurrences=moved)
    whole, *_ = check_clearance(wrong, refusing.limits, refusing.meshes)
    with only_of({"motor_1"}, ()):
        part, *_ = check_clearance(wrong, refusing.limits, refusing.meshes)
    assert not whole.passed
    assert (part.passed, part.worst_pair, part.value) == (whole.passed, whole.worst_pair, whole.value)


def test_only_named_faults_are_excused() -> None:
    assert excuse("base_dowel_0_1: shifted by 0.5 mm along z") is not None
    assert excuse("base_dowel_0_1: shifted by 0.5 mm along x") is None
    sawn = "shoulder_shaft: sawn half through at 0.5 of y"
    assert (excuse(sawn), excuse(sawn, "synthesized")) == (None, None)
    assert excuse(sawn, "direct-83") is not None


@pytest.mark.slow
def test_a_spring_off_its_place_shares_more_with_its_eyes_than_its_loops_do() -> None:
    refusing = Refusing(sound())
    (shifted,) = (f for f in faults(("rod_spring",), others=False) if f.name.endswith("shifted by 0.5 mm along x"))
    assert "overlap of contacts" in str(refusing.first_refusal(shifted.assembly))
