"""Figures of files by hand: masses of supplies, speed and torque of a joint, what turns with it."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.mass_properties import mass_report
from delta_cad.export.robot import Robot, sdf, urdf
from delta_cad.solids.part import Supply
from tests.delta_cad.export.machine import unit_masses


@pytest.fixture(scope="module")
def robot(machine: Assembly, best: Design) -> Robot:
    """RE 30 at 4.8 : 1 on simple solids."""
    return Robot(machine, mass_report(machine)["bodies"], drive_torque(best), (-1.1, 1.0), (0.012, 3e-4))


def test_supplies_weigh_what_one_weighs_times_their_number(machine: Assembly) -> None:
    grease = Supply("grease", "Grease", 3, "PTFE grease", 2.5, "", "", "")
    rows = bill_of_materials(replace(machine, supplies=(grease,)), unit_masses(machine))
    assert (rows[-1].item, rows[-1].quantity, rows[-1].unit_mass_g, rows[-1].total_mass_g) == (7, 3, 2.5, 7.5)
    assert rows[-1].make_or_buy == "buy"


def test_a_shoulder_is_as_many_times_slower_as_it_is_stronger(robot: Robot) -> None:
    """900 rad/s of an idle motor at 4.8 : 1; the torque is what the controller lets it give."""
    tree = ET.fromstring(urdf(robot))
    shoulders = [one for one in tree.iter("joint") if one.find("dynamics") is not None]
    assert len(shoulders) == 3
    for joint in shoulders:
        limit = joint.find("limit")
        assert limit is not None
        assert {key: float(value) for key, value in limit.items()} == pytest.approx(
            {"lower": -1.1, "upper": 1.0, "effort": 0.8, "velocity": 900.0 / 4.8}
        )
    assert {float(one.text or 0) for one in tree.iter("mechanicalReduction")} == {4.8}


def test_rotor_and_pinion_turn_by_the_square_of_the_ratio(robot: Robot) -> None:
    pinion = {"inertia_kg_m2": [[1.0, 0.0, 0.0], [0.0, 2e-7, 0.0], [0.0, 0.0, 1.0]]}
    turning = 4.8**2 * (3.33e-6 + 2e-7)
    for text in (urdf, sdf):
        told = text(replace(robot, bodies={**robot.bodies, "pinion_0": pinion}))
        (said,) = (line for line in told.splitlines() if "rotor and pinion add" in line)
        assert float(said.split("rotor and pinion add ")[1].split()[0]) == pytest.approx(turning)
