"""Tools of bores against closed forms and their records against the tables they come from."""

from __future__ import annotations

from math import pi, radians, tan

import pytest

from delta_cad import catalogue
from delta_cad.solids.boring import Boring, along_y, along_z, axes, between, blind, fitted, sunk, tapped, tool
from delta_cad.solids.primitive import box, cut

SIDE = 20.0


def taken(*bores: object) -> float:
    """What bores take out of a cube that they enter at its faces."""
    cube = box((0, 0, 0), (SIDE, SIDE, SIDE))
    return SIDE**3 - cut(cube, [tool(bore) for bore in bores]).Volume()  # type: ignore[arg-type]


def test_a_drill_has_its_tip_in_every_direction() -> None:
    volume = pi / 4 * 9.0 * 8.0 + pi / 12 * 9.0 * 1.5 / tan(radians(59.0))
    ways = [along_y(3.0, (5, 5), (0, 8)), along_y(3.0, (5, 5), (SIDE, 12)), along_z(3.0, (5, 5), (0, 8))]
    ways += [
        along_z(3.0, (5, 5), (SIDE, 12)),
        between(3.0, (0, 5, 5), (8, 5, 5)),
        between(3.0, (SIDE, 5, 5), (12, 5, 5)),
    ]
    for bore in ways:
        assert taken(blind(bore, 118.0)) == pytest.approx(volume, rel=1e-9)
        assert taken(blind(bore)) == pytest.approx(pi / 4 * 9.0 * 8.0, rel=1e-9)


def test_a_through_bore_goes_through() -> None:
    assert taken(along_z(3.0, (5, 5), (0, SIDE))) == pytest.approx(pi / 4 * 9.0 * SIDE, rel=1e-9)


def test_a_blind_thread_is_drilled_deeper() -> None:
    bore = tapped(along_y(0.0, (5, 5), (0, SIDE)), "M4", 8.0)
    assert (bore.diameter_mm, bore.depth_mm, bore.thread, bore.thread_mm) == (3.3, 10.5, "M4", 8.0)
    assert (bore.through, bore.tip_deg) == (False, 118.0)
    through = tapped(along_y(0.0, (5, 5), (0, SIDE)), "M4")
    drill = catalogue.screw("M4").tap_drill_mm
    assert (through.through, through.depth_mm, through.thread_mm, through.diameter_mm) == (True, SIDE, 12.0, drill)


def test_records_say_how_a_bore_is_made() -> None:
    seat = fitted(blind(along_y(16.0, (5, 5), (0, 5))), "H6")
    assert (seat.fit, seat.deviations_um, seat.surface_um) == ("H6", (0, 11), 0.8)
    assert sunk(along_z(8.0, (0, 0), (0, 4.4))).is_counterbore
    boring = Boring()
    boring.add("nothing", [])
    boring.add("3 H7", [along_y(3.0, (5, 5), (0, 5)), along_y(3.0, (5, 5), (SIDE, 15)), along_y(3.0, (9, 5), (0, 5))])
    (hole,) = boring.holes
    assert (hole.diameter_mm, hole.count, hole.callout, len(hole.bores), len(boring.tools)) == (3.0, 2, "3 H7", 3, 3)
    assert {bore.callout for bore in hole.bores} == {"3 H7"}


def test_bores_on_one_axis_count_once() -> None:
    up, down, adjacent = (along_z(3.0, (x, 0), z) for x, z in ((0, (0, 5)), (0, (9, 5)), (1, (0, 5))))
    assert [axes([up]), axes([up, down]), axes([up, down, adjacent]), axes([up, along_y(3.0, (0, 0), (0, 5))])] == [
        1, 1, 2, 2,
    ]  # fmt: skip
