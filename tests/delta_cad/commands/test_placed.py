"""What `inspect` says of chains that are placed for a rectangle."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np
import pytest

from delta_cad.commands.inspection import _smallest, dimension_rows, reach_rows
from delta_cad.design import Design, design_from_dict
from delta_cad.mechanism import joint_angles
from tests.designs import minimal, placed

OWN = {
    "base radius R of chain 0": 30.8,
    "base radius R of chains 1 and 2": 38.45,
    "azimuth of chains 1 and 2, either way": 116.3,
    "cube's middle from the base's axis, towards arm 0": 11.1,
}


@pytest.fixture(scope="module")
def design() -> Design:
    return design_from_dict(placed())


def test_where_chains_and_cube_stand_is_shown(design: Design) -> None:
    rows = {row.quantity: row for row in dimension_rows(design)}
    for words, value in OWN.items():
        assert rows[words].value == pytest.approx(value)
        assert rows[words].unit == ("deg" if "azimuth" in words else "mm")
    even = {row.quantity for row in dimension_rows(design_from_dict(minimal()))}
    assert "base radius R" in even
    assert not even & set(OWN)


def test_the_outline_is_that_of_elbows_in_the_plane(design: Design) -> None:
    ends = []
    for degree, radius in ((0.0, 30.8), (116.3, 38.45), (-116.3, 38.45)):
        c, s = cos(radians(degree)), sin(radians(degree))
        ends += [((radius + 94.4) * c - t * s, (radius + 94.4) * s + t * c) for t in (-25.0, 25.0)]
    sizes = sorted(np.ptp(ends, axis=0), reverse=True)
    rows = {row.quantity: row.value for row in dimension_rows(design)}
    assert [rows["longer side"], rows["shorter side"]] == pytest.approx(sizes, abs=1e-9)


def test_heights_over_the_axis_are_those_where_the_first_chain_folds_or_stretches(design: Design) -> None:
    low, high = (float(row.value) for row in reach_rows(design))
    for height, inwards in ((low, 1.0), (high, -1.0)):
        inside, outside = (np.array([0.0, 0.0, (height + way * inwards * 1e-4) / 1000.0]) for way in (1.0, -1.0))
        assert np.isfinite(joint_angles(design.geometry, inside)).all()
        assert np.isnan(joint_angles(design.geometry, outside)).any()


def test_the_least_base_is_that_of_chain_0(design: Design) -> None:
    rows = {row.quantity: float(row.value) for row in _smallest(design)}
    assert rows["platform radius r, for the wrists"] < 22.55
    assert 20.0 < rows["base radius R, for the sectors"] < 30.8
