"""Printed parts in the structural model: limits, symmetry, and closed forms by hand."""

from __future__ import annotations

import json
from dataclasses import replace
from math import pi

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.design import design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.sizes import growth
from delta_cad.structure.beam import Beam, flexibility
from delta_cad.structure.beam_model import beam_model
from delta_cad.structure.compliance import _to_motor_cheek, compliance, softest
from delta_cad.structure.report import stiffness
from delta_cad.structure.strength import allowables, clamping_N, screw_N
from tests.committed import ROOT

MAKER = "docs/gallery/maker-60.json"


def machine(name: str = MAKER, **hardware: object) -> Dimensions:
    data = json.loads((ROOT / name).read_text(encoding="utf-8"))
    data["hardware"] |= hardware
    return dimensions(design_from_dict(data))


def test_a_machine_of_the_same_lengths_is_softer_printed_than_cut() -> None:
    printed = stiffness(machine(), 3).least_N_mm
    cut = stiffness(machine(process="machined", arm_thickness_mm=13.0), 3).least_N_mm
    assert printed < cut
    assert stiffness(machine(processes={"upper_arm": "machined"}, arm_thickness_mm=14.5), 3).least_N_mm > printed


def test_second_moments_grow_by_the_ratio_of_the_moduli() -> None:
    d = machine()
    metal, print_ = catalogue.material("aluminium-7075"), catalogue.material("petg-fdm")
    assert print_.creep_modulus_Pa is not None
    harder = json.loads((ROOT / MAKER).read_text(encoding="utf-8"))
    harder["requirements"]["stiffness_min_N_mm"] = 100.0  # so that neither is at its least
    design = design_from_dict(harder)
    ratio = metal.youngs_modulus_Pa / print_.creep_modulus_Pa
    assert growth(design, "upper_arm") == pytest.approx(ratio * growth(design), rel=1e-12)
    assert growth(d.design, "upper_arm") > growth(d.design)


@pytest.mark.parametrize("angle", [-0.7, 0.0, 1.1])
def test_a_wrench_on_the_hub_does_the_same_work_at_the_cheek(angle: float) -> None:
    """A rigid motion of the cheek, told in its axes, moves the hub as rotation and lever say: the transpose."""
    along, turned = 23.0, np.array([np.cos(angle), np.sin(angle)])
    to_cheek = _to_motor_cheek(turned, along)
    moved, tilt = (
        np.array([0.3, -0.2, 0.5]),
        np.array([0.01, 0.02, -0.03]),
    )  # of the cheek, (up, along the axis, inwards)
    up, axis, inwards = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0]), np.array([-1.0, 0.0, 0.0])
    frame = np.stack([up, axis, inwards])  # rows in the chain's (u, t, z)
    shift, spin = frame.T @ moved, frame.T @ tilt
    hub = shift + np.cross(spin, -along * axis)
    arm = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    found = to_cheek.T @ np.concatenate([moved, tilt])
    assert found == pytest.approx(np.concatenate([arm @ hub, arm @ spin]), abs=1e-12)


def test_a_cheek_ten_thousand_times_stiffer_gives_nothing() -> None:
    table = beam_model(machine())
    assert table.motor_cheek is not None
    slices = table.motor_cheek.slices
    moduli = [{"youngs_N_mm2": 1e4 * one.youngs_N_mm2, "shear_N_mm2": 1e4 * one.shear_N_mm2} for one in slices]
    stiff = Beam(tuple(replace(one, **stiffer) for one, stiffer in zip(slices, moduli, strict=True)))
    at = np.array([[0.0, 0.0, 100.0]])
    rigid, held, own = (
        float(softest(compliance(replace(table, motor_cheek=cheek), at).at_knob()).stiffness_N_mm[0])
        for cheek in (None, stiff, table.motor_cheek)
    )
    assert held == pytest.approx(rigid, rel=1e-3)
    assert own < rigid
    assert np.all(np.linalg.eigvalsh(flexibility(table.motor_cheek)) > 0.0)


def test_a_cut_cheek_of_a_direct_drive_counts_as_rigid_and_gives_two_percent() -> None:
    d = machine("docs/gallery/direct-83.json")
    assert beam_model(d).motor_cheek is None


def test_plastic_bears_a_quarter_of_its_layers_strength_under_a_head_and_around_an_insert() -> None:
    d, row, insert = machine(), catalogue.screw("M3"), catalogue.insert("M3x5.7")
    lasting = 25.0 / 4.0  # N/mm^2
    under = lasting * pi / 4.0 * (row.head_diameter_mm**2 - row.clearance_hole_mm**2)
    around = lasting / np.sqrt(3.0) * pi * insert.outer_mm * insert.length_mm
    assert clamping_N(d, row, "motor_cheek") == pytest.approx(under, rel=1e-3)
    assert clamping_N(d, row, "", "foot_block") == pytest.approx(around, rel=1e-3)
    assert clamping_N(d, row, "motor_cheek", "foot_block") == pytest.approx(min(under, around), rel=1e-3)
    assert clamping_N(d, row) == screw_N(row)
    cut = machine("docs/gallery/direct-83.json")
    assert clamping_N(cut, row, "motor_cheek", "foot_block") == screw_N(row)


def test_a_printed_arms_limits_are_by_hand() -> None:
    d = machine()
    h, thick, high = allowables(d), d.layers.arm_mm[1] - d.layers.arm_mm[0], 2.0 * d.arm.beam_root_radius_mm
    assert h.arm_1_mm3 == pytest.approx((6.0 / (high * thick**2), 6.0 / (thick * high**2)))
    assert h.arm_N_mm2 == pytest.approx(6.25)
    assert h.spoke_N_mm2 == pytest.approx(6.25)
    assert h.spoke_1_mm3 == pytest.approx(6.0 / (2.0 * d.platform.hub_radius_mm * d.platform.plate_mm**2))
    force = clamping_N(d, catalogue.screw("M3"), "upper_arm", "upper_arm")
    assert h.grip_N_mm == pytest.approx(0.25 * force * d.motor.shaft_diameter_mm)
    cut = allowables(machine("docs/gallery/direct-83.json"))
    assert (cut.arm_1_mm3, cut.grip_N_mm, cut.spoke_1_mm3) == (None, None, None)
