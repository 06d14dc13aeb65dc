"""What must close, turn and be reached: the arm's clamps, the cable's tension screws, the handle's stem."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.solids.part import Occurrence, Part
from delta_cad.solids.primitive import bore_z, box, cylinder
from tests.delta_cad.solids.measured import axis_distance, cylinders, one_axis, placed

AXIS_MM = 1e-6  # the kernel's own tolerance of coincidence is 1e-7
NOISE_MM3 = 1e-9  # a boolean of parts that do not meet gives no solid at all


def part(assembly: Assembly, number: str) -> Part:
    (found,) = [p for p in assembly.parts if p.number == number]
    return found


def occurrence(assembly: Assembly, name: str) -> Occurrence:
    (found,) = [o for o in assembly.occurrences if o.name == name]
    return found


def test_the_elbow_clamp_is_two_jaws_that_can_close(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """Beyond the root of the slit nothing joins the upper half to the lower one, not even past the cross-bar."""
    arm, a = part(best_assembly, "upper_arm").solid, best_dimensions.arm
    root = a.elbow_slit_x_mm + 1.25  # the slit begins in a bore of 2.5 mm
    jaws = arm.intersect(box((root, -50.0, -50.0), (200.0, 50.0, 50.0))).Solids()
    assert len(jaws) == 2
    low, high = sorted(jaw.BoundingBox().zmin for jaw in jaws)
    assert low < -a.beam_root_radius_mm / 2
    assert high == pytest.approx(0.5, abs=AXIS_MM)  # half of the 1 mm slit
    # through the boss there is the slit and no more: a sheet of its width goes in from the end
    sheet = box((root, -50.0, -0.5 + AXIS_MM), (200.0, 50.0, 0.5 - AXIS_MM))
    assert arm.intersect(sheet).Volume() < NOISE_MM3
    # 1 mm before the slit's bore the arm is whole
    assert len(arm.intersect(box((-50.0, -50.0, -50.0), (root - 3.5, 50.0, 50.0))).Solids()) == 1


def test_the_shoulder_clamp_s_head_has_a_flat_open_seat(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    arm, a = part(best_assembly, "upper_arm").solid, best_dimensions.arm
    screw = catalogue.screw("M3")
    z = a.shoulder_clamp_z_mm
    whole = 3 * a.flange_radius_mm
    # from the seat outwards head and key find no metal, nor does a cutter that comes from above
    way_in = cylinder(screw.head_diameter_mm, (-8.0 - AXIS_MM, 0, z), (-whole, 0, z))
    assert arm.intersect(way_in).Volume() < NOISE_MM3
    cutter = box((-whole, -50.0, z - screw.counterbore_diameter_mm / 2 + AXIS_MM), (-8.0 - AXIS_MM, 50.0, whole))
    assert arm.intersect(cutter).Volume() < NOISE_MM3
    # and the head bears on the seat all around its hole
    ring = cylinder(screw.head_diameter_mm, (-8.0, 0, z), (-7.9, 0, z))
    hole = cylinder(screw.clearance_hole_mm, (-8.1, 0, z), (-7.8, 0, z))
    assert screw.head_diameter_mm / 2 <= best_dimensions.layers.arm_mm[1]
    bearing = ring.cut(hole)
    assert arm.intersect(bearing).Volume() == pytest.approx(bearing.Volume(), rel=1e-6)


@pytest.mark.parametrize("chain", range(3))
@pytest.mark.parametrize("end", range(2))
def test_nut_and_sleeve_are_coaxial_with_the_tension_screw_and_in_order(
    best_assembly: Assembly, best_dimensions: Dimensions, chain: int, end: int
) -> None:
    c = best_dimensions.capstan
    assert c is not None
    drill = catalogue.hex_screw("M2.5").tap_drill_mm
    at = {kind: occurrence(best_assembly, f"{kind}_{chain}_{end}") for kind in ("tension_screw", "lock_nut")}
    at["crimp_sleeve"] = occurrence(best_assembly, f"crimp_sleeve_{chain}_{end}")
    assert {o.link for o in at.values()} == {f"upper_arm_{chain}"}
    solids = {kind: placed(o.part.solid, o.placement) for kind, o in at.items()}
    screw = one_axis(solids["tension_screw"], 0.8, concave=True)
    for kind, diameter in (("lock_nut", drill), ("crimp_sleeve", best_dimensions.cable.diameter_mm)):
        distance, sine = axis_distance(one_axis(solids[kind], diameter, concave=True), screw)
        assert distance < AXIS_MM
        assert sine < 1e-12
    threads = cylinders(part(best_assembly, "sector").solid, drill, concave=True)
    assert min(max(axis_distance(thread, screw)) for thread in threads) < AXIS_MM
    # the screw's axis is the tangent of the cable's circle: at one end of the rim, at the other of the nose,
    # which the cable goes round by a quarter turn
    angle = c.rim_angles_rad[end] - (0.0 if end else pi / 2)
    circle = c.pitch_radius_mm if end else 5.0 + c.cable_diameter_mm / 2
    middle = np.zeros(3)
    if not end:
        middle = (c.rim_radius_mm - 5.0) * np.array([cos(angle + pi / 2), 0.0, sin(angle + pi / 2)])
    middle[1] = screw[0][1]
    assert np.linalg.norm(np.cross(screw[0] - middle, screw[1])) == pytest.approx(circle, abs=AXIS_MM)
    # along it, from the lug outwards: nut on the lug, room, head, sleeve on the head, the cable's end
    sense = 1.0 if end else -1.0
    outwards = sense * np.array([-sin(angle), 0.0, cos(angle)])
    start = middle + circle * np.array([cos(angle), 0.0, sin(angle)])
    assert np.linalg.norm(np.cross(start - screw[0], screw[1])) < AXIS_MM

    def along(kind: str) -> tuple[float, float]:
        ends = [float((np.array(v.toTuple()) - start) @ outwards) for v in solids[kind].Vertices()]
        return min(ends), max(ends)

    nut, sleeve, bolt = along("lock_nut"), along("crimp_sleeve"), along("tension_screw")
    assert nut == pytest.approx((6.0, 7.6), abs=AXIS_MM)  # on the lug, which is 6 mm long
    head = catalogue.hex_screw("M2.5").head_height_mm
    assert bolt == pytest.approx((0.0, 8.0 + head), abs=AXIS_MM)
    assert nut[1] < bolt[1] - head
    assert sleeve == pytest.approx((8.0 + head, 11.0 + head), abs=AXIS_MM)
    cable = placed(part(best_assembly, "capstan_cable").solid, np.eye(4))
    ends = np.array([v.toTuple() for v in cable.Vertices()]) - start
    ends = ends[np.linalg.norm(np.cross(ends, outwards), axis=1) < 1.0]  # of this end: those beside the screw's axis
    reach = (ends @ outwards).max()
    assert reach == pytest.approx(sleeve[1], abs=AXIS_MM)
    for a, b in (("lock_nut", "tension_screw"), ("crimp_sleeve", "tension_screw"), ("lock_nut", "crimp_sleeve")):
        assert solids[a].intersect(solids[b]).Volume() < NOISE_MM3


def test_both_hexagons_turn_within_the_sector_s_thickness(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """Flats lie along the sector's faces; turned, the corners come no nearer to the motor cheek than 1 mm."""
    y0, y1 = best_dimensions.layers.sector_mm
    for name in ("tension_screw_0_0", "tension_screw_0_1", "lock_nut_0_0", "lock_nut_0_1"):
        o = occurrence(best_assembly, name)
        seen = placed(o.part.solid, o.placement).BoundingBox()
        assert y0 < seen.ymin < seen.ymax < y1
    corner = catalogue.hex_screw("M2.5").across_flats_mm / sqrt(3)
    assert best_dimensions.layers.motor_cheek_mm[0] - (y0 + y1) / 2 - corner >= 1.0


def test_the_cable_passes_the_screw_and_the_sleeve_does_not(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    bore = cylinders(part(best_assembly, "tension_screw").solid, 0.8, concave=True)
    assert len(bore) == 1
    assert best_dimensions.cable.diameter_mm < 0.8
    sleeve = part(best_assembly, "crimp_sleeve").solid.BoundingBox()
    assert sleeve.xmax - sleeve.xmin > 0.8 + 0.5  # bears on the head around the bore
    assert sleeve.xmax - sleeve.xmin < catalogue.hex_screw("M2.5").across_flats_mm


def test_the_stem_has_flats_for_a_spanner(best_assembly: Assembly) -> None:
    """8 mm across and 6 mm high from z = 2: a gauge of that width goes over it there, and nowhere else."""
    stem = part(best_assembly, "handle_stem").solid
    for low, high, over in ((2.0, 8.0, True), (0.5, 1.5, False), (8.5, 9.5, False)):
        gauge = bore_z(40.0, (0.0, 0.0), (low + AXIS_MM, high - AXIS_MM)).cut(
            box((-4.0 - AXIS_MM, -30.0, low - 1.0), (4.0 + AXIS_MM, 30.0, high + 1.0))
        )
        assert (gauge.intersect(stem).Volume() < NOISE_MM3) is over
