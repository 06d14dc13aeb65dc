"""Cheeks of narrow foot blocks and threads of wide ones: what their screws take out of them."""

from __future__ import annotations

from dataclasses import replace
from math import cos, sin

import cadquery as cq
import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.checks.dfm.bores import depths
from delta_cad.checks.solidity import solid_faults
from delta_cad.design import design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.rules import DRILL_DIAMETERS
from delta_cad.solids.brackets import (
    BLOCK_SCREW,
    cheek_screw_sink_mm,
    make_encoder_cheek,
    make_foot_block,
    make_motor_cheek,
)
from delta_cad.solids.primitive import encloses_its_volume, hull_along_y
from tests.committed import changed
from tests.delta_cad.assembly.test_assemble import DIRECT, variant
from tests.delta_cad.solids.measured import cylinders


@pytest.fixture(scope="module")
def narrow() -> Dimensions:
    """A direct drive's foot block 10 mm wide, between cheeks of 9.5 and 6.5 mm: the heads are sunk on either side."""
    d = variant(**DIRECT, motor="maxon-ec60flat-625858")
    thick = (d.layers.encoder_cheek_mm[0] - 0.5, d.layers.encoder_cheek_mm[1])
    head = (thick[0], d.layers.encoder_head_mm[1])
    return replace(d, layers=replace(d.layers, encoder_cheek_mm=thick, encoder_head_mm=head))


@pytest.mark.parametrize("make", [make_motor_cheek, make_encoder_cheek])
def test_heads_that_are_sunk_have_their_counterbores(narrow: Dimensions, make) -> None:
    layers = narrow.layers
    inside, outside = layers.motor_cheek_mm if make is make_motor_cheek else layers.encoder_cheek_mm[::-1]
    sink = cheek_screw_sink_mm(narrow, abs(outside - inside))
    assert sink > 0.0
    part, wide = make(narrow), catalogue.screw(BLOCK_SCREW).counterbore_diameter_mm
    bores = cylinders(part.solid, wide, concave=True)
    assert len(bores) == 2
    assert (
        sum(hole.count for hole in part.holes if hole.callout == f"counterbore {sink:g} deep from the outer side") == 2
    )


def test_a_stop_pin_has_metal_all_around_it() -> None:
    """Beside a flat motor of 43 mm the upper pin stands at the pad's rim, 22 mm from the shoulder."""
    lengths = {"base_radius": 29.0, "platform_radius": 21.304, "upper_arm_length": 53.18, "forearm_length": 81.399}
    data = {
        "schema": "delta-design/1",
        "name": "flat",
        "mechanism": {"parallelogram_width_mm": 50.0} | {f"{name}_mm": length for name, length in lengths.items()},
        "cube": {"bottom_height_mm": 49.953, "half_side_mm": 20.0},
        "requirements": {
            "envelope_width_mm": 190.0,
            "envelope_depth_mm": 170.0,
            "force_N": 1.0,
            "joint_torque_N_m": 0.128,
            "peak_torque_N_m": 0.1344,
        },
        "hardware": {
            "motor": "maxon-ec45flat-411812",
            "drive": "direct",
            "arm_thickness_mm": 8.0,
            "ball_diameter_mm": 6.0,
            "platform_thickness_mm": 10.0,
        },
    }
    d = dimensions(design_from_dict(data))
    cheek, middle = make_motor_cheek(d).solid, sum(d.layers.motor_cheek_mm) / 2.0
    for u, height in d.bracket.stop_pins_mm:
        x, z = u - d.bracket.shoulder_u_mm, height
        for angle in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False).tolist():
            point = cq.Vector(x + 3.4 * cos(angle), middle, z + 3.4 * sin(angle))
            assert cheek.isInside(point), (u, height, angle)


@pytest.mark.parametrize("radius_mm", [35.9, 36.0, 36.7, 37.9, 38.0])
def test_a_cheek_is_one_sound_solid_where_the_kernel_stumbles(radius_mm: float) -> None:
    """Its outline ends in an arc of 0.03 mm that is chamfered, or its head nearly meets the leg's chamfer."""
    d, near = (dimensions(design_from_dict(changed(hardware__sector_radius_mm=r))) for r in (radius_mm, 37.0))
    cheek, like = make_encoder_cheek(d).solid, make_encoder_cheek(near).solid
    assert cheek.isValid()
    assert not solid_faults(cheek)
    assert cheek.Volume() == pytest.approx(like.Volume(), rel=0.05)


@pytest.mark.parametrize(
    ("base", "arm", "forearm", "bottom", "share"),
    [
        (53.5, 148.026, 282.59, 153.765, 1.0377),
        *((base, 146.633, 275.715, 148.144, 1.0535) for base in (53.0, 53.037, 53.045, 53.0499, 53.05, 53.1)),
    ],
)
def test_a_tall_cheek_at_which_the_kernel_stumbles_is_sound(
    base: float, arm: float, forearm: float, bottom: float, share: float
) -> None:
    """Beside an arc of 0.04 mm a chamfer of 0.5 mm comes to thirty times the body, and is called valid; where leg and
    head touch from within faces are lost, of which some bodies count as valid, too. The shares were sampled at eight
    million points, by the rules of `test_sampled`, to 0.04 %.
    """
    lengths = {"base_radius": base, "platform_radius": 18.879, "upper_arm_length": arm, "forearm_length": forearm}
    data = {
        "schema": "delta-design/1",
        "name": "tall",
        "mechanism": {"parallelogram_width_mm": 41.6} | {f"{name}_mm": length for name, length in lengths.items()},
        "cube": {"bottom_height_mm": bottom, "half_side_mm": 75.0},
        "requirements": {
            "envelope_width_mm": 380.0,
            "envelope_depth_mm": 347.0,
            "force_N": 10.0,
            "joint_torque_N_m": 2.1695,
            "clearance_min_mm": 2.0,
        },
        "hardware": {
            "motor": "maxon-re50-370354",
            "capstan_ratio": 5.58,
            "sector_radius_mm": 50.2,
            "cable": "steel-0.8-7x19",
            "encoder": "mt6835-board",
            "magnet": "ndfeb-6x2.5-diametric",
            "tube": "cfrp-5x3",
            "arm_thickness_mm": 5.0,
            "platform_thickness_mm": 13.5,
            "ball_diameter_mm": 6.0,
        },
    }
    d = dimensions(design_from_dict(data))
    cheek, (outside, inside) = make_encoder_cheek(d).solid, d.layers.encoder_cheek_mm
    assert not solid_faults(cheek)
    drawn = hull_along_y([d.bracket.leg_circle_mm, *d.bracket.foot_circles_mm], (outside, inside)).Volume()
    assert encloses_its_volume(cheek)
    assert cheek.Volume() / drawn == pytest.approx(share, rel=2e-3)


def test_a_block_too_wide_to_drill_through_is_drilled_from_both_sides(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    for more in (0.0, 10.0):
        inside, outside = d.layers.motor_cheek_mm
        wide = replace(d, layers=replace(d.layers, motor_cheek_mm=(inside + more, outside + more)))
        block = make_foot_block(wide)
        threads = [bore for hole in block.holes for bore in hole.bores if bore.thread == BLOCK_SCREW]
        assert len(threads) == 4
        assert [bore.through for bore in threads] == [not more] * 4
        assert max(finding.value for finding in depths(block)) <= DRILL_DIAMETERS
        assert block.solid.isValid()
