"""What must close, slide and be reached: a direct drive's clamp, the cable's ends and carriage, the handle's stem."""

from __future__ import annotations

from math import cos, pi, sin

import cadquery as cq
import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.cable_setting import cable_setting
from delta_cad.solids.primitive import bore_z, box, cylinder
from delta_cad.solids.upper_arm import make_upper_arm
from tests.delta_cad.dimensions.edited import edited
from tests.delta_cad.solids.measured import axis_distance, cylinders, occurrence, one_axis, part, placed

AXIS_MM = 1e-6  # the kernel's own tolerance of coincidence is 1e-7
NOISE_MM3 = 1e-9  # a boolean of parts that do not meet gives no solid at all


@pytest.fixture(scope="module")
def direct() -> Dimensions:
    """A design whose arms are clamped on their motors' shafts."""
    return edited(drive="direct", motor="maxon-ec60flat-625858")


def test_the_clamp_of_a_direct_drive_has_a_flat_open_seat_for_its_head(direct: Dimensions) -> None:
    arm, a = make_upper_arm(direct).solid, direct.arm
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
    assert screw.head_diameter_mm / 2 <= direct.layers.arm_mm[1]
    bearing = ring.cut(hole)
    assert arm.intersect(bearing).Volume() == pytest.approx(bearing.Volume(), rel=1e-6)


@pytest.mark.parametrize("chain", range(3))
def test_the_cable_s_ends_lie_in_line_with_what_holds_them(
    best_assembly: Assembly, best_dimensions: Dimensions, chain: int
) -> None:
    """Along the rim's tangent into the carriage; along the nose's after a quarter turn, through the anchor's wall."""
    c = best_dimensions.capstan
    assert c is not None
    for end in range(2):
        sleeve = occurrence(best_assembly, f"crimp_sleeve_{chain}_{end}")
        side = ("inner", "outer")[end]
        rope = occurrence(best_assembly, f"capstan_cable_{chain}_{side}_end")
        assert sleeve.link == rope.link == f"upper_arm_{chain}"
        seen = placed(sleeve.part.solid, sleeve.placement)
        axis = one_axis(seen, 0.6, concave=True)
        angle = c.rim_angles_rad[end] - (0.0 if end else pi / 2)
        sense = 1.0 if end else -1.0
        circle = c.pitch_radius_mm if end else 5.0 + c.cable_diameter_mm / 2
        middle = np.zeros(3) if end else (c.rim_radius_mm - 5.0) * np.array([-sin(angle), 0.0, cos(angle)])
        outwards = sense * np.array([-sin(angle), 0.0, cos(angle)])
        leaves = middle + circle * np.array([cos(angle), 0.0, sin(angle)])
        y0, y1 = best_dimensions.layers.sector_mm
        leaves[1] = (y0 + y1) / 2 + (-c.run.made_lug_mm if end else c.run.made_lug_mm)
        assert np.linalg.norm(np.cross(axis[0] - leaves, axis[1])) < AXIS_MM
        assert np.linalg.norm(np.cross(axis[1], outwards)) < 1e-12
        ends = sorted(float((np.array(v.toTuple()) - leaves) @ outwards) for v in seen.Vertices())
        begins = 6.0 if not end else 1.2 + 6.0 - 3.0  # behind the wall; the carriage holds it in a counterbore
        assert (ends[0], ends[-1]) == pytest.approx((begins, begins + 3.0), abs=AXIS_MM)
        cable = placed(rope.part.solid, rope.placement)
        reach = max(float((np.array(v.toTuple()) - leaves) @ outwards) for v in cable.Vertices())
        assert reach == pytest.approx(ends[-1], abs=AXIS_MM)


def test_the_carriage_is_guided_and_has_its_travel(best_assembly: Assembly) -> None:
    """It slides 3.5 mm outwards in its pocket without touching, and no further; turned by 4 deg it does not fit."""
    block, pocket = occurrence(best_assembly, "tension_carriage_0"), part(best_assembly, "sector").solid

    def inside(along: float, turned: float = 0.0) -> float:
        """Volume that carriage and sector share, the carriage moved along the cable and turned about it, mm^3."""
        moved = block.part.solid.rotate(cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), turned)
        moved = placed(moved.translate(cq.Vector(0.0, 0.0, along)), block.placement)
        return sum(s.Volume() for s in pocket.intersect(moved).Solids())

    assert inside(0.0) == inside(3.5 - AXIS_MM) == 0.0
    assert inside(3.6) > 1.0
    assert inside(0.0, 4.0) > 0.01


def test_the_cable_goes_in_with_its_sleeves_crimped(best_assembly: Assembly) -> None:
    """Carriage, sleeve and cable slide into the pocket from the arm's side, the inner end from the motor's."""
    sector = occurrence(best_assembly, "sector_0").part.solid
    for side, names in (
        (-1.0, ("tension_carriage_0", "crimp_sleeve_0_1", "capstan_cable_0_outer_end")),
        (1.0, ("crimp_sleeve_0_0",)),
    ):
        for name in names:
            o = occurrence(best_assembly, name)
            for out in (0.5, 1.5, 3.0, 6.0):
                moved = placed(o.part.solid, o.placement).translate(cq.Vector(0.0, side * out, 0.0))
                assert sector.intersect(moved).Volume() < NOISE_MM3, (name, out)
    carriage = occurrence(best_assembly, "tension_carriage_0")
    block = placed(carriage.part.solid, carriage.placement)
    sleeve = occurrence(best_assembly, "crimp_sleeve_0_1")
    for out in (0.5, 1.5, 4.0):
        moved = placed(sleeve.part.solid, sleeve.placement).translate(cq.Vector(0.0, -out, 0.0))
        assert block.intersect(moved).Volume() < NOISE_MM3


def test_a_cutter_goes_round_the_pocket_and_leaves_its_walls(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    """Walls of 1 mm or more on all sides, and material in all four corners where a cutter of 3 mm does not come."""
    d = best_dimensions
    carriage, sector = occurrence(best_assembly, "tension_carriage_0"), part(best_assembly, "sector").solid
    room = placed(cq.Solid.makeBox(10.2, 5.0, 9.7, cq.Vector(-7.6, -2.5, -0.2)), carriage.placement)
    y1 = d.layers.sector_mm[1]
    for x in (-7.6, 2.6):
        for z in (-0.2, 9.5):
            low = cq.Vector(x - 0.4 * (x > 0.0), -2.45, z - 0.4 * (z > 0.0))
            corner = placed(cq.Solid.makeBox(0.4, 4.9, 0.4, low), carriage.placement)
            assert sector.intersect(corner).Volume() == pytest.approx(corner.Volume(), rel=1e-6)
    assert sector.intersect(room).Volume() < 4 * (1.0 - pi / 4) * 1.6**2 * 5.1
    walls = {  # low and high corners of what must be full, in the carriage's frame
        "front, beside the slot": ((-7.5, -2.4, -1.15), (-0.6, 2.4, -0.25)),
        "end, beside the screw": ((-1.5, -2.4, 9.55), (2.5, 2.4, 12.4)),
        "outside": ((2.65, -2.4, 0.0), (4.15, 2.4, 9.0)),
        "inside": ((-9.15, -2.4, 0.0), (-7.65, 2.4, 9.0)),
        "bottom": ((-7.0, 2.65, 1.5), (2.0, y1 - d.capstan.end_y_mm[1] - 0.05, 8.0)),  # type: ignore[union-attr]
    }
    for name, (low, high) in walls.items():
        wall = placed(box(low, high), carriage.placement)
        assert sector.intersect(wall).Volume() == pytest.approx(wall.Volume(), rel=1e-6), name


def test_a_cable_of_any_allowed_length_is_tensioned(best_dimensions: Dimensions) -> None:
    """The shortest goes on; the longest, stretched by its pretension and settled, is tight within the travel."""
    d, c = best_dimensions, best_dimensions.capstan
    assert c is not None
    length, tolerance = c.bench_mm
    assert tolerance >= 0.5
    assert length - tolerance >= c.cable_length_mm
    setting = cable_setting(d)
    assert setting is not None
    new = 0.9 * 57.3e3 * pi / 4 * d.cable.diameter_mm**2  # by the handbook, before it has settled
    tight = (length + tolerance) * (1.0 + setting.tension_N / new + 0.001)
    assert tight - c.cable_length_mm <= 3.5
    assert tight - c.cable_length_mm > 2.0  # no more is given away than a tenth of a millimetre or two


def test_the_tension_screw_pulls_the_carriage_towards_its_wall(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    screw, block = (occurrence(best_assembly, f"{name}_0") for name in ("tension_screw", "tension_carriage"))
    drill = catalogue.screw("M3").tap_drill_mm
    thread = one_axis(placed(block.part.solid, block.placement), drill, concave=True)
    shank = one_axis(placed(screw.part.solid, screw.placement), drill - 0.04, concave=False)
    assert max(axis_distance(thread, shank)) < AXIS_MM
    wall = cylinders(part(best_assembly, "sector").solid, catalogue.screw("M3").clearance_hole_mm, concave=True)
    assert min(max(axis_distance(hole, shank)) for hole in wall) < AXIS_MM
    bore = catalogue.screw("M3").clearance_hole_mm / 2
    assert best_dimensions.cable.diameter_mm / 2 < 5.0 - bore  # the cable passes beside the screw


def test_the_groove_s_hand_is_that_of_the_drawn_turns(best_assembly: Assembly) -> None:
    """Seen along the axis the turns go on as they turn: with the fingers of the right hand along them, or not."""
    turns = part(best_assembly, "capstan_cable_turns").solid
    rings = [np.array(face.Center().toTuple()) for face in turns.Faces() if face.geomType() == "TORUS"]
    order = np.argsort([ring[1] for ring in rings])
    angles = np.unwrap([np.arctan2(rings[k][2], rings[k][0]) for k in order])
    turned = float(angles[-1] - angles[0])  # from x to z as y grows; x, z, y is a left-handed frame
    assert ("left-hand" in part(best_assembly, "pinion").description) == (turned > 0.0)


def test_the_stem_has_flats_for_a_spanner(best_assembly: Assembly) -> None:
    """8 mm across and 6 mm high from z = 2: a gauge of that width goes over it there, and nowhere else."""
    stem = part(best_assembly, "handle_stem").solid
    for low, high, over in ((2.0, 8.0, True), (0.5, 1.5, False), (8.5, 9.5, False)):
        gauge = bore_z(40.0, (0.0, 0.0), (low + AXIS_MM, high - AXIS_MM)).cut(
            box((-4.0 - AXIS_MM, -30.0, low - 1.0), (4.0 + AXIS_MM, 30.0, high + 1.0))
        )
        assert (gauge.intersect(stem).Volume() < NOISE_MM3) is over
