"""What closed forms take a machine to weigh: no more than its solids do, and loads and torques that count it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.mechanism import worst_joint_torque
from delta_cad.solids.forearm import make_cross_bar
from delta_cad.solids.platform import make_platform
from delta_cad.structure.hardware.mass_lower_bound import mass_lower_bound
from delta_cad.structure.hardware.refusals import HEAVIER, LEARNT, refusals
from delta_cad.structure.loads import sampled_mm
from delta_cad.structure.modes import moving
from tests.committed import changed
from tests.delta_cad.structure.hardware.broken import ended, enough

TORQUE = "requirements.joint_torque_N_m"


def test_solids_weigh_no_less_and_little_more(best_masses: dict[str, Any], best_dimensions: Dimensions) -> None:
    least = mass_lower_bound(best_dimensions)
    whole = moving(best_masses["bodies"], best_dimensions.design.geometry.forearm_length)
    along = [body.mass_kg * body.centre_mm[0] for body in (least.arm, whole.arm)]
    across = [body.mass_kg * body.centre_mm[2] for body in (least.arm, whole.arm)]
    assert least.platform.mass_kg < whole.platform.mass_kg < 1.06 * least.platform.mass_kg
    assert least.rod_kg < whole.rod_kg < 1.06 * least.rod_kg
    assert along[0] < along[1] < HEAVIER * along[0]
    assert across[0] == pytest.approx(across[1], abs=0.05 * along[1])
    assert least.platform.centre_mm[2] == pytest.approx(whole.platform.centre_mm[2], rel=0.15)


def test_a_platform_of_uneven_wrists_weighs_aside_of_the_axis() -> None:
    """Its solid, cross-bars and balls: the moment about the axis within a tenth, that of even wrists none."""
    places = {"mechanism__azimuths_deg": [0.0, 124.0, -124.0], "mechanism__platform_radius_mm": 30.0}
    d = dimensions(
        design_from_dict(changed(**places, mechanism__base_radius_mm=40.0, requirements__envelope_width_mm=900.0))
    )
    density = catalogue.material("aluminium-7075").density_kg_m3 / MM_PER_M**3
    plate, bar = make_platform(d).solid, make_cross_bar(d).solid
    wrists = 30.0 * (1.0 + 2.0 * np.cos(np.radians(124.0)))
    moment = (
        density * (plate.Volume() * plate.Center().x + bar.Volume() * wrists) + 2e-3 * d.forearm.ball.mass_g * wrists
    )
    least = mass_lower_bound(d).platform
    assert moment < -0.03
    assert least.mass_kg * least.centre_mm[0] == pytest.approx(moment, rel=0.1)
    assert mass_lower_bound(dimensions(light(0.4))).platform.centre_mm[0] == 0.0


def light(torque: float) -> Design:
    return design_from_dict(changed(requirements__joint_torque_N_m=torque))


def test_a_torque_that_the_weight_exceeds_is_refused() -> None:
    """3 N alone take 0.353 N m: 0.36 would do if nothing had a weight."""
    design = light(0.36)
    pushed = worst_joint_torque(design.geometry, sampled_mm(design.workspace) / MM_PER_M, 3.0)
    assert pushed.max() < 0.36
    assert refusals(design, LEARNT) == ()
    (reason,) = refusals(design)
    assert (reason.part, reason.feature, reason.field) == ("drive", "torque with gravity", TORQUE)
    least = enough(ended(design)["drive, torque with gravity"], TORQUE)
    assert 0.36 < least < 0.42
    assert refusals(light(least)) == ()
    assert refusals(light(least - 1e-4)) != ()


def test_a_machine_on_its_side_weighs_as_much() -> None:
    level, tilted = ((0.0, 0.0, -9.81), (9.81, 0.0, 0.0))
    bounds = []
    for gravity in (level, tilted):
        heavy = changed(requirements__joint_torque_N_m=0.36, requirements__gravity_m_s2=gravity)
        bounds.append(enough(ended(design_from_dict(heavy))["drive, torque with gravity"], "requirements.force_N"))
    assert bounds[0] != pytest.approx(bounds[1], rel=1e-3)
    assert np.all(np.array(bounds) < 3.0)


def test_no_more_torque_is_proposed_than_the_drive_gives() -> None:
    heavy = changed(requirements__force_N=5.0, requirements__peak_force_N=8.0)
    (reason,) = (one for one in refusals(design_from_dict(heavy)) if one.feature == "torque with gravity")
    assert [way.fields for way in reason.ways] == [("mechanism.upper_arm_length_mm",), ("requirements.force_N",)]


def test_a_load_that_the_weight_makes_too_large_is_refused() -> None:
    """A base that is wider turns the load of a ball joint to 86.8 of 86 degrees by solids, 85.3 without a weight."""
    design = design_from_dict(
        changed(
            hardware__cable="steel-0.8-7x19",
            mechanism__base_radius_mm=35.0,
            requirements__envelope_depth_mm=232.0,
            requirements__peak_force_N=5.7,
        )
    )
    assert refusals(design, LEARNT) == ()
    (reason,) = refusals(design)
    assert (reason.part, reason.field) == ("ball joint", "requirements.peak_force_N")
    assert 5.4 < enough(ended(design)["ball joint, load"], "requirements.peak_force_N") < 5.5
