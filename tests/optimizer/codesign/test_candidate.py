"""Closed forms of a candidate: why it is refused and how far that asks the search to go; gravity before solids."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import dimensions
from delta_cad.drive.masses import Masses
from delta_cad.structure.hardware.refusals import least_outline_mm
from optimizer.codesign.candidate import mass_estimate_of, with_gravity_torque
from optimizer.codesign.corrections import Corrections, MassEstimate, reference
from optimizer.codesign.estimates import Estimate, estimates
from tests.committed import changed


def estimated(design: Design) -> dict[tuple[str, str], Estimate]:
    return {one.reason.key: one for one in estimates(design)}


def test_a_thickness_is_estimated_at_what_the_bar_in_it_needs() -> None:
    """By hand: 1 mm around a bar of 8 mm."""
    one = estimated(design_from_dict(changed(hardware__platform_thickness_mm=9.0)))["platform", "wrist boss"]
    assert (one.field, one.value, one.bound) == ("hardware.platform_thickness_mm", 9.0, 10.0)


def test_an_outline_is_estimated_at_what_elbows_and_motors_take_to_a_tenth(best: Design) -> None:
    tight = design_from_dict(changed(requirements__envelope_width_mm=230.0, requirements__envelope_depth_mm=220.0))
    one, size = estimated(tight)["assembly", "envelope width"], float(least_outline_mm(dimensions(best)).max())
    assert one.field == "requirements.envelope_width_mm"
    assert one.bound is not None
    assert size <= one.bound <= size + 0.1


def test_loads_alone_tell_what_is_carried_of_them() -> None:
    found = estimates(design_from_dict(changed(requirements__peak_force_N=12.0, hardware__platform_thickness_mm=11.0)))
    margins = {one.reason.key: one.reason.margin for one in found}
    assert ("cable's slip", "load") in margins
    for (_, feature), margin in margins.items():
        assert (margin is not None) == (feature == "load")
        assert margin is None or 0.0 < margin < 1.0


WEIGHED = MassEstimate(
    Masses(
        platform=0.06,
        arm_along=0.0,
        arm_across=0.0,
        arm_inertia=2e-4,
        rod_elbow=0.004,
        rod_cross=0.002,
        rod_wrist=0.003,
        rotor_inertia=8e-5,
    ),
    gravity_torque_N_m=0.03,
    upper_arm_mm=80.0,
    forearm_mm=120.0,
    ratio=4.0,
)


def test_gravity_is_known_at_least_before_anything_is_weighed(best: Design, best_masses: dict[str, Any]) -> None:
    """Of masses of another machine too little is learnt, of more nothing; no more than solids tell, nor much less."""
    solid = mass_estimate_of(best, best_masses).gravity_torque_N_m
    light, heavy = (Corrections(replace(reference(), gravity_torque_N_m=share * solid)) for share in (0.5, 1.0))
    learnt = with_gravity_torque(best, light)
    assert learnt.mass_estimate == replace(
        light.mass_estimate, gravity_torque_N_m=learnt.mass_estimate.gravity_torque_N_m
    )
    assert 0.75 * solid < learnt.mass_estimate.gravity_torque_N_m < solid
    assert with_gravity_torque(best, learnt) is learnt
    assert with_gravity_torque(best, heavy) is heavy


def test_a_rotor_is_felt_by_the_square_of_its_ratio() -> None:
    """8e-5 kg m^2 at 4:1 are 5e-6 at the motor and 1.8e-4 at 6:1, 2e-5 at 2:1; the arm's 2e-4 stay."""
    for ratio, rotor in ((4.0, 8e-5), (6.0, 1.8e-4), (2.0, 2e-5)):
        assert WEIGHED.inertia(80.0, 120.0, ratio).joint_inertia == pytest.approx(2e-4 + rotor, rel=1e-12)


def test_half_of_a_rod_grows_with_its_length() -> None:
    """Rods of 180 instead of 120 mm have 1 - 0.5 + 0.5 * 1.5 = 1.25 of the mass: 0.06 + 3 * 0.00375 kg are carried."""
    longer = WEIGHED.inertia(80.0, 180.0, 4.0)
    assert longer.carried_mass == pytest.approx(0.07125, rel=1e-12)
    assert longer.elbow_mass == pytest.approx(0.005, rel=1e-12)
    assert longer.cross_mass == pytest.approx(0.0025, rel=1e-12)


def test_an_arm_twice_as_long_has_3_7_times_the_inertia() -> None:
    """2^1.9 = 3.7321; without a rotor."""
    bare = replace(WEIGHED, masses=replace(WEIGHED.masses, rotor_inertia=0.0))
    assert bare.inertia(160.0, 120.0, 4.0).joint_inertia == pytest.approx(7.4643e-4, rel=1e-4)
