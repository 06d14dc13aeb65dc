"""Sections, bars and bearings against textbooks' values and limits."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.structure import section
from delta_cad.structure.beam import Beam, BeamSlice, flexibility, flexibility_by_kind, tapered
from delta_cad.structure.bearing import (
    BallBearing,
    approach_mm,
    axial_stiffness_N_mm,
    ball_bearing,
    dynamic_equivalent_N,
    life_hours,
    radial_stiffness_N_mm,
    static_equivalent_N,
)
from delta_cad.structure.table import outline_width_mm

E, G = 70e3, 27e3


@pytest.mark.parametrize(
    ("sides", "share"),
    [(1.0, 0.1406), (2.0, 0.229), (5.0, 0.291), (10.0, 0.312)],  # Timoshenko and Goodier, table of k1 in J = k1 a b^3
)
def test_a_rectangles_torsion_is_the_textbooks(sides: float, share: float) -> None:
    for b, h in ((3.0, 3.0 * sides), (3.0 * sides, 3.0)):
        assert section.rectangle_torsion_mm4(b, h) == pytest.approx(share * 3.0 * sides * 27.0, rel=0.005)


def test_sections_agree_where_they_meet() -> None:
    assert section.ring(10.0, 0.0).about_y_mm4 == section.circle(10.0).about_y_mm4
    # a thin square tube: 15 x 15 x 1.5 has J 3690 mm^4
    tube = section.box(15.0, 15.0, 1.5)
    assert tube.torsion_mm4 == pytest.approx(3690.0, rel=1e-3)
    assert tube.about_y_mm4 == pytest.approx((15.0**4 - 12.0**4) / 12.0)


def test_two_ribs_are_a_frame() -> None:
    frame, plate = section.ribs(10.0, 3.0, 6.0, 1e9), section.rectangle(10.0, 3.0)
    assert frame.about_y_mm4 == plate.about_y_mm4
    assert frame.torsion_mm4 == pytest.approx(2 * section.rectangle_torsion_mm4(5.0, 3.0))  # a window without end
    window = section.ribs(10.0, 3.0, 6.0, 12.0)
    assert window.about_z_mm4 == pytest.approx(3.0 * (16.0**3 - 6.0**3) / 12.0)
    # one end turned by phi, the ribs clamped in both ends: the torque of two beams of 12 E I / l^3 each
    young, shear, turn = 2.6, 1.0, 1e-3
    force = 12 * young * (5.0 * 27.0 / 12.0) / 12.0**3 * turn * 11.0 / 2
    saint_venant = shear * 2 * section.rectangle_torsion_mm4(5.0, 3.0) * turn / 12.0
    assert shear * window.torsion_mm4 * turn / 12.0 == pytest.approx(force * 11.0 + saint_venant)
    # both shifted aside by d, besides the plate's own shear
    alone = 1.0 / (1.0 / window.shear_y_mm2 - 1.0 / (30.0 * 5 / 6))
    shift = 2 * 12 * young * (3.0 * 125.0 / 12.0) / 12.0**3
    assert shear * alone / 12.0 == pytest.approx(shift)


def test_a_cantilever_gives_as_the_formulas_say() -> None:
    s, length = section.rectangle(6.0, 10.0), 50.0
    c = flexibility(Beam((BeamSlice(length, s, E, G),)))
    shear = length / (G * s.shear_z_mm2)
    assert c[0, 0] == pytest.approx(length / (E * s.area_mm2))
    assert c[2, 2] == pytest.approx(length**3 / (3 * E * s.about_y_mm4) + shear)
    assert c[1, 1] == pytest.approx(length**3 / (3 * E * s.about_z_mm4) + shear)
    assert c[3, 3] == pytest.approx(length / (G * s.torsion_mm4))
    # a force up turns the tip about -y, a force along +y about +z
    assert c[4, 2] == pytest.approx(-(length**2) / (2 * E * s.about_y_mm4))
    assert c[5, 1] == pytest.approx(length**2 / (2 * E * s.about_z_mm4))
    np.testing.assert_allclose(c, c.T, atol=1e-18)


def test_slices_change_nothing_and_a_taper_converges() -> None:
    s = section.circle(5.0)
    one = flexibility(Beam((BeamSlice(30.0, s, E, G),)))
    np.testing.assert_allclose(flexibility(Beam(tapered(0.0, 30.0, lambda _: s, E, G))), one, rtol=1e-12, atol=1e-18)
    # a plate b wide whose height falls linearly to nothing at a force: u = 6 F L^3 / (E b h^3), closed form
    # of a triangular profile in plan: constant thickness t, width w at the root to 0: L^3 / (2 E I_root)
    wedge = tapered(0.0, 60.0, lambda x: section.rectangle(20.0 * (1 - x / 60.0), 3.0), E, 1e12)
    expected = 60.0**3 / (2 * E * 20.0 * 27.0 / 12.0)
    assert flexibility(Beam(wedge))[2, 2] == pytest.approx(expected, rel=1e-3)


def test_kinds_add_up_and_the_factor_counts() -> None:
    bar = Beam((BeamSlice(20.0, section.box(10.0, 12.0, 1.0), E, G),), factor=1.4)
    kinds = flexibility_by_kind(bar)
    np.testing.assert_allclose(kinds.sum(axis=0), flexibility(bar))
    np.testing.assert_allclose(flexibility(bar), 1.4 * flexibility(Beam(bar.slices)))
    assert kinds[3, 3, 3] == flexibility(bar)[3, 3]


def test_a_hull_is_as_wide_as_its_tangents() -> None:
    circles = [(0.0, 0.0, 5.0), (0.0, -20.0, 10.0)]
    assert outline_width_mm(circles, -10.0) == pytest.approx(
        15.0 / sqrt(1 - 0.25**2), rel=1e-3
    )  # directions by 0.25 deg
    assert outline_width_mm(circles, -20.0) == pytest.approx(20.0, rel=1e-5)
    square = [(x, z, 0.0) for x in (-3.0, 3.0) for z in (-1.0, 1.0)]
    assert outline_width_mm(square, 0.2) == pytest.approx(6.0, rel=1e-5)


def test_the_balls_of_known_bearings() -> None:
    row = catalogue.bearing("688")
    assert ball_bearing(row) == BallBearing(2.0, 9, row.static_load_N, row.dynamic_load_N)
    large = ball_bearing(catalogue.bearing("608"))  # 7 balls of 3.97 mm
    assert large.balls in (6, 7)
    assert large.ball_mm == pytest.approx(3.97, rel=0.12)


def test_bearings_give_as_palmgren_says() -> None:
    bearing = BallBearing(2.0, 10, 550.0, 1330.0)
    assert approach_mm(15.0, 2.0) == pytest.approx(4.36e-4 * 112.5 ** (1 / 3))
    for load, expected in ((1.0, 7e3), (30.0, 21e3)):  # a study's 7 and 21 kN/mm
        slope = radial_stiffness_N_mm(bearing, load)
        step = 1e-4 * load
        moved = approach_mm(5 * (load + step) / 10, 2.0) - approach_mm(5 * (load - step) / 10, 2.0)
        assert slope == pytest.approx(2 * step / moved, rel=1e-6)
        assert slope == pytest.approx(expected, rel=0.03)
    assert axial_stiffness_N_mm(bearing, 10.0) == pytest.approx(2.3e3, rel=0.03)


def test_a_bearings_life_is_that_of_its_turns() -> None:
    bearing = BallBearing(2.0, 10, 550.0, 1000.0)
    # a tenth of C: 1e9 turns; a stroke of half a turn, there and back once a second: a turn a second
    assert life_hours(bearing, 100.0, pi, 1.0) == pytest.approx(1e9 / 3600.0)
    assert life_hours(bearing, 200.0, pi, 1.0) == pytest.approx(1e9 / 8 / 3600.0)
    assert life_hours(bearing, 100.0, pi / 2, 2.0) == pytest.approx(1e9 / 3600.0)
    assert static_equivalent_N(10.0, 1.0) == 10.0
    assert static_equivalent_N(10.0, 20.0) == 16.0
    assert dynamic_equivalent_N(10.0, 0.0) == 10.0
    assert dynamic_equivalent_N(10.0, 10.0) == pytest.approx(28.6)


def test_a_stepped_plate_lies_between_its_thick_and_its_thin_one() -> None:
    thick, thin = section.rectangle(7.0, 42.0), section.rectangle(3.75, 42.0)
    some = section.stepped_plate(7.0, 42.0, 3.25, 33.0)
    assert thin.about_z_mm4 < some.about_z_mm4 < thick.about_z_mm4
    assert some.about_z_mm4 == pytest.approx((9.0 * 7.0**3 + 33.0 * 3.75**3) / 12.0)
    assert some.area_mm2 == pytest.approx(9.0 * 7.0 + 33.0 * 3.75)
    assert section.stepped_plate(7.0, 42.0, 3.25, 0.0).about_z_mm4 == pytest.approx(thick.about_z_mm4)
    assert section.stepped_plate(7.0, 42.0, 3.25, 42.0).about_z_mm4 == pytest.approx(thin.about_z_mm4)
