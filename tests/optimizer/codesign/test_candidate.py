"""Candidates before any solid of them is made."""

from __future__ import annotations

from dataclasses import replace

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design
from delta_cad.export.mass_properties import mass_report
from optimizer.codesign.candidate import hung, weighed_of
from optimizer.codesign.lessons import Lessons, reference


def test_gravity_is_known_at_least_before_anything_is_weighed(best: Design, best_assembly: Assembly) -> None:
    """Of masses of another machine too little is learnt, of more nothing; no more than solids tell, nor much less."""
    solid = weighed_of(best, mass_report(best_assembly)).gravity_torque_N_m
    light, heavy = (Lessons(replace(reference(), gravity_torque_N_m=share * solid)) for share in (0.5, 1.0))
    learnt = hung(best, light)
    assert learnt.weighed == replace(light.weighed, gravity_torque_N_m=learnt.weighed.gravity_torque_N_m)
    assert 0.75 * solid < learnt.weighed.gravity_torque_N_m < solid
    assert hung(best, learnt) is learnt
    assert hung(best, heavy) is heavy
