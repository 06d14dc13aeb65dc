"""Cheeks of narrow foot blocks: what their screws take out of them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.solids.brackets import BLOCK_SCREW, cheek_screw_sink_mm, make_encoder_cheek, make_motor_cheek
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
