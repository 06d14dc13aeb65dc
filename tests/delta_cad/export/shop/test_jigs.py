"""Jigs against the parts that they hold: on their solids, with balls and seats put where a shop puts them."""

from __future__ import annotations

import csv
from math import hypot, radians, sqrt, tan

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import JIG_DEPTH_MM, JIG_MOUTH_MM, LIP_ROOM_MM, deviations_um
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.shop.jigs import JIG, MANDREL, ROD_JIG, SEAT_GAUGE, Jig, gauge_balls_mm, jigs_of
from delta_cad.solids.part import Part
from tests.committed import Built
from tests.delta_cad.export.shop.quoted import check_quotation

NOISE_MM3 = 1e-6


@pytest.fixture(scope="module")
def jigs(best_dimensions: Dimensions) -> dict[str, Jig]:
    return {jig.part.number: jig for jig in jigs_of(best_dimensions)}


def part_of(assembly: Assembly, number: str) -> Part:
    return next(part for part in assembly.parts if part.number == number)


def rests(solid: cq.Solid, centre: tuple[float, float, float], radius: float) -> None:
    """A ball about a point touches a solid and shares nothing with it."""
    ball = cq.Solid.makeSphere(radius - 1e-4, cq.Vector(*centre), angleDegrees1=-90.0)
    assert solid.intersect(ball).Volume() < NOISE_MM3
    assert solid.distance(cq.Vertex.makeVertex(*centre)) == pytest.approx(radius, abs=1e-6)


def test_balls_in_the_rod_jig_are_a_rods_length_apart(jigs: dict[str, Jig], best_dimensions: Dimensions) -> None:
    solid = jigs[ROD_JIG].part.solid
    for x in (0.0, 143.196):
        rests(solid, (x, 0.0, 0.0), best_dimensions.forearm.ball_diameter_mm / 2)


def test_a_rod_lies_in_its_jig_and_meets_the_balls_alone(
    jigs: dict[str, Jig], best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    """Cups, shells, tube and eyes as they are placed about a rod, turned so that both cups open downwards."""
    jig, lip = jigs[ROD_JIG].part.solid, best_dimensions.forearm.lip_mm
    link = next(o.link for o in best_assembly.occurrences if o.name.startswith("rod_tube"))
    lying = [o for o in best_assembly.occurrences if o.link == link and o.part.number.startswith(("rod_", "cup_"))]
    elbow = next(o for o in lying if o.name.startswith("rod_cup") and o.name.endswith("elbow")).placement
    numbers = {o.part.number for o in lying}
    assert {"rod_cup", "cup_shell", "rod_tube", "rod_eye"} <= numbers
    up = np.eye(4)
    up[:3, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]  # a cup's y, away from its mouth, is up
    for one in lying:
        if one.part.number in ("rod_spring", "rod_cord"):
            continue
        at = up @ np.linalg.inv(elbow) @ one.placement
        placed = one.part.solid.moved(cq.Location(cq.Plane(tuple(at[:3, 3]), tuple(at[:3, 0]), tuple(at[:3, 2]))))
        assert jig.intersect(placed).Volume() < NOISE_MM3, one.name
        if one.part.number == "cup_shell":
            assert jig.distance(placed) == pytest.approx(LIP_ROOM_MM, abs=0.011)  # the pad is at a hundredth
            assert placed.BoundingBox().zmin == pytest.approx(lip, abs=1e-4)


def test_a_jigs_depth_and_mouth_move_its_ball_by_less_than_a_lips_room(best_dimensions: Dimensions) -> None:
    """A ball in a cone of 90 degrees: its centre is root 2 radii over the tip, which depth and mouth set."""
    ball = best_dimensions.forearm.ball_diameter_mm / 2

    def over_pad(depth: float, mouth: float) -> float:
        return sqrt(2.0) * ball - (depth + mouth / tan(radians(45.0)))

    depth, mouth = 1.2, ball + 0.15
    low = over_pad(depth + JIG_DEPTH_MM, mouth + JIG_MOUTH_MM / 2)
    assert over_pad(depth, mouth) - low == pytest.approx(JIG_DEPTH_MM + JIG_MOUTH_MM / 2)
    assert over_pad(depth, mouth) - low < LIP_ROOM_MM


def test_gauge_balls_tell_a_seat_at_either_limit(best_dimensions: Dimensions) -> None:
    """A ball that is larger than its seat stands on the rim, off the pole by what shows; a smaller one lies on it."""
    f = best_dimensions.forearm
    goes, not_goes = gauge_balls_mm(best_dimensions)
    assert (goes, not_goes) == pytest.approx((6.010, 6.020))
    assert goes > f.ball_diameter_mm
    rim = hypot(f.seat_diameter_mm / 2, 0.0) ** 2 - f.lip_mm**2
    off = sqrt((not_goes / 2) ** 2 - rim) - f.lip_mm - (not_goes - f.seat_diameter_mm) / 2
    assert off > 0.02  # blue on the rim alone: eight times what the ball is too large by


def test_the_gauges_balls_stand_out_of_its_handle(jigs: dict[str, Jig], best_dimensions: Dimensions) -> None:
    """Each lies in its cone, and the handle ends short of a shell's lip, within the cup's opening."""
    solid = jigs[SEAT_GAUGE].part.solid
    for size, end, sense in zip(gauge_balls_mm(best_dimensions), (60.0, 0.0), (1.0, -1.0), strict=True):
        radius = size / 2
        centre = end + sense * (sqrt(2.0) * radius - 2.8 - 0.2)  # mouth and its wall
        rests(solid, (0.0, 0.0, centre), radius)
        assert sense * (centre - end) > best_dimensions.forearm.lip_mm
    assert solid.isInside(cq.Vector(3.8, 0.0, 53.5))
    assert not solid.isInside(cq.Vector(3.8, 0.0, 6.5))  # the groove marks the end that does not go


def test_the_mandrel_stands_in_both_seats_with_the_cheeks_on(
    jigs: dict[str, Jig], best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    d, mandrel = best_dimensions, jigs[MANDREL]
    assert d.preload is not None
    low = d.layers.bearings_mm[0][0] - d.preload.work_height_mm + 0.5
    frame = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])  # its z is the shoulder's y
    place = cq.Location(cq.Plane((0.0, low, 0.0), tuple(frame[:, 0]), (0.0, 1.0, 0.0)))
    bar = mandrel.part.solid.moved(place)
    held = []
    for number in ("motor_cheek", "encoder_cheek"):
        cheek = part_of(best_assembly, number).solid
        assert cheek.intersect(bar).Volume() < 1e-3
        thick = cq.Solid.makeCylinder(d.bearing.outer_mm / 2 + 0.01, 80.0, cq.Vector(0, -40, 0), cq.Vector(0, 1, 0))
        held.append(cheek.intersect(thick.cut(bar)).Volume())
        assert held[-1] > 0.0  # a skin of 0.01 around it meets the seat's wall
        beyond = bar.BoundingBox()
        box = cheek.BoundingBox()
        assert beyond.ymax > box.ymax or beyond.ymin < box.ymin  # a grip comes out
    lower, upper = deviations_um("h5", d.bearing.outer_mm)
    (size,) = features_of(mandrel.part, faces_of(mandrel.part.solid), mandrel.held).sizes[:1]
    assert size.tolerance is not None
    assert size.tolerance.deviations_mm == (lower / 1000.0, upper / 1000.0)


def test_a_direct_drive_has_no_mandrel(direct_dimensions: Dimensions) -> None:
    assert MANDREL not in {jig.part.number for jig in jigs_of(direct_dimensions)}


def test_a_build_has_files_and_rows_of_its_jigs_and_names_them_in_the_manual(built: Built) -> None:
    names = {ROD_JIG, SEAT_GAUGE, MANDREL}
    files = {path.name for path in (built.folder / "jigs").iterdir()}
    assert files == {f"{name}.{suffix}" for name in names for suffix in ("step", "pdf", "svg", "dxf")}
    with (built.folder / "bom.csv").open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["make_or_buy"] == JIG]
    assert names < {row["part_number"] for row in rows}
    assert all(row["order_code"] for row in rows if row["part_number"] not in names)
    assert names <= {row["part_number"] for row in check_quotation(built.folder)}
    manual = (built.folder / "manual" / "manual.html").read_text(encoding="utf-8")
    assert all(f"jig {name}" in manual for name in names)
