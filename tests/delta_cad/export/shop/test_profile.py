"""Profiles of plate parts, read back by ezdxf, against the solids: rays, extents, and the volume that is milled off.

30 s of processor: the solids of three machines, and rays through them as the oracle of every profile.
"""

from __future__ import annotations

from dataclasses import replace
from io import StringIO
from math import pi
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.faces import solid_faces
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.dfm.lines import Lines
from delta_cad.common.memoize import memoize
from delta_cad.dimensions.tolerances import SLOT_CUTTER_MM
from delta_cad.export.shop.profile import LAYERS, Profile, profile_of, write_profiles
from delta_cad.solids.making import material
from delta_cad.solids.part import Part

PLATES = {"base_plate", "motor_cheek", "encoder_cheek", "foot_block", "upper_arm"}
ALSO = {"sector", "panel", "bezel"}  # of machines that have them
_NEAR_MM = 0.02  # of an edge, where a ray may go either way
_FLAT_MM = 1e-3  # sagitta of a polygon in place of an arc


def part_of(assembly: Assembly, number: str) -> Part:
    return next(part for part in assembly.parts if part.number == number)


_found = memoize(profile_of)


def profile(part: Part) -> Profile:
    found = _found(part)
    assert found is not None
    return found


def read(text: str) -> list[Any]:
    import ezdxf

    document = ezdxf.read(StringIO(text))  # pyright: ignore[reportPrivateImportUsage]
    assert document.audit().errors == []
    assert document.units == 4  # millimetres
    return list(document.modelspace())


def polygon(entity: Any) -> np.ndarray:
    """(n, 2) corners of a closed line, its arcs in short pieces."""
    if entity.dxftype() == "CIRCLE":
        return np.array([(p.x, p.y) for p in entity.flattening(_FLAT_MM)])[:-1]
    corners: list[tuple[float, float]] = []
    for piece in entity.virtual_entities():
        arc = piece.dxftype() == "ARC"
        points = [(p.x, p.y) for p in (piece.flattening(_FLAT_MM) if arc else (piece.dxf.start, piece.dxf.end))]
        if corners and np.hypot(*np.subtract(points[-1], corners[-1])) < np.hypot(*np.subtract(points[0], corners[-1])):
            points.reverse()  # an arc of the format turns anticlockwise, whichever way its polyline goes
        corners += points
    return np.array([corner for k, corner in enumerate(corners) if corner != corners[k - 1]])


def area(corners: np.ndarray) -> float:
    x, y = corners.T
    return abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0


def extents(loops: list[np.ndarray]) -> np.ndarray:
    points = np.concatenate(loops)
    return np.array([points.min(axis=0), points.max(axis=0)])


def inside(corners: np.ndarray, point: np.ndarray) -> bool:
    a, b = corners, np.roll(corners, -1, axis=0)
    cross = (a[:, 1] > point[1]) != (b[:, 1] > point[1])
    at = a[cross, 0] + (point[1] - a[cross, 1]) / (b[cross, 1] - a[cross, 1]) * (b[cross, 0] - a[cross, 0])
    return bool((at > point[0]).sum() % 2)


def distance(corners: np.ndarray, point: np.ndarray) -> float:
    a, along = corners, np.roll(corners, -1, axis=0) - corners
    share = np.clip(((point - a) * along).sum(axis=1) / (along**2).sum(axis=1), 0.0, 1.0)
    return float(np.linalg.norm(a + share[:, None] * along - point, axis=1).min())


def sunk_mm3(part: Part, axis: int) -> float:
    """Volume of counterbores, blind bores with their tips, and cross bores, as declared: what is milled of a blank."""
    bores = [bore for hole in part.holes for bore in hole.bores]
    along = [bore for bore in bores if abs(bore.direction[axis]) > 0.999]
    through = {place(bore, axis): bore.diameter_mm for bore in along if bore.through}
    found, crossing = 0.0, dict[Any, float]()
    for bore in bores:
        tip = bore.diameter_mm / 2.0 / np.tan(np.radians(bore.tip_deg / 2.0)) / 3.0 if bore.tip_deg else 0.0
        if bore in along:
            hollow = through.get(place(bore, axis), 0.0)
            if not bore.through:
                found += pi / 4.0 * (bore.diameter_mm**2 - hollow**2) * (bore.depth_mm + tip)
        else:
            across = int(np.argmax(np.abs(bore.direction)))
            one = bore.start_mm if not bore.through else np.delete(bore.start_mm, across)  # from both sides
            volume = pi / 4.0 * bore.diameter_mm**2 * (bore.depth_mm + tip)
            crossing[tuple(np.round(one, 3))] = volume
    slots = [slot for hole in part.holes for slot in hole.slots]
    found += sum((s.width_mm * s.long_mm - (4.0 - pi) * (SLOT_CUTTER_MM / 2) ** 2) * s.depth_mm for s in slots)
    return found + sum(crossing.values())


def place(bore: Any, axis: int) -> tuple[float, ...]:
    return tuple(np.round(np.delete(bore.start_mm, axis), 3))


def bevels_mm3(part: Part, axis: int) -> float:
    """Volume of broken edges at 45 deg, straight and around, from the area of what is left and its height."""
    found = 0.0
    for face in solid_faces(part.solid):
        straight = face.kind == "plane" and abs(abs(float(face.direction[axis])) - 0.5**0.5) < 1e-6
        if straight or (face.kind == "cone" and not face.is_hollow):
            box = face.face.BoundingBox(1e-4)
            found += face.area_mm2 * [box.xlen, box.ylen, box.zlen][axis] / 8.0**0.5
    return found


@pytest.fixture(params=["best", "direct", "placed"])
def assembly(
    request: pytest.FixtureRequest, best_assembly: Assembly, direct_assembly: Assembly, placed_assembly: Assembly
) -> Assembly:
    return {"best": best_assembly, "direct": direct_assembly, "placed": placed_assembly}[request.param]


def test_plate_parts_are_found_by_their_solids(assembly: Assembly) -> None:
    found = {part.number for part in assembly.parts if part.make and _found(part) is not None}
    assert found == PLATES | (ALSO & {part.number for part in assembly.parts})


def test_a_ray_through_the_plate_meets_the_part_where_the_profile_has_metal(assembly: Assembly) -> None:
    random = np.random.default_rng(44)
    for part in (part for part in assembly.parts if part.number in PLATES | ALSO):
        found = profile(part)
        finished = replace(found, openings=tuple(replace(one, stock_mm=0.0) for one in found.openings))
        loops = [polygon(entity) for entity in read(finished.dxf())]
        low, high = extents(loops)
        lines, way = Lines(part.solid), np.eye(3)[found.axis]
        looked = 0
        for point in random.uniform(low - 1.0, high + 1.0, (100, 2)):
            if min(distance(loop, point) for loop in loops) > _NEAR_MM:
                metal = sum(inside(loop, point) for loop in loops) == 1
                start = np.insert(point, found.axis, -300.0)
                assert metal == (not lines.is_free(start, way)), (part.number, point)
                looked += 1
        assert looked > 80


def test_extents_and_layers_are_those_of_the_part(assembly: Assembly) -> None:
    for part in (part for part in assembly.parts if part.number in PLATES):
        found, box = profile(part), part.solid.BoundingBox(1e-4)
        entities = read(found.dxf())
        assert {entity.dxftype() for entity in entities} <= {"CIRCLE", "LWPOLYLINE"}
        assert all(entity.dxftype() == "CIRCLE" or entity.closed for entity in entities)
        assert [entity.dxf.layer for entity in entities].count("OUTLINE") == 1
        assert {entity.dxf.layer for entity in entities} <= set(LAYERS)
        (outline,) = (polygon(entity) for entity in entities if entity.dxf.layer == "OUTLINE")
        sizes = np.delete([box.xlen, box.ylen, box.zlen], found.axis)
        assert np.ptp(extents([outline]), axis=0) == pytest.approx(sizes, abs=2e-3)
        assert found.thickness_mm == pytest.approx([box.xlen, box.ylen, box.zlen][found.axis])
        own = area(outline) - sum(area(polygon(one)) for one in entities if one.dxf.layer != "OUTLINE")
        whole = [2.0 * one.circle[2] for one in found.openings if one.circle and one.layer == "PILOT" and one.stock_mm]
        stock = sum(pi / 4.0 * (d**2 - (d - (0.5 if d <= 6.0 else 1.0)) ** 2) for d in whole)
        assert own == pytest.approx(found.area_mm2 + stock, rel=1e-4)


@pytest.mark.parametrize("number", ["base_plate", "foot_block"])
def test_what_a_blank_has_over_the_part_is_what_is_bored_and_bevelled(best_assembly: Assembly, number: str) -> None:
    part = part_of(best_assembly, number)
    found = profile(part)
    over = found.area_mm2 * found.thickness_mm - float(part.solid.Volume())
    sunk = sunk_mm3(part, found.axis) + bevels_mm3(part, found.axis)
    assert sunk > 100.0
    assert over == pytest.approx(sunk, rel=0.01)  # at corners two bevels share a piece


@pytest.mark.parametrize("number", ["foot_block", "motor_cheek"])
def test_threads_and_fits_are_marked_for_finishing_and_fits_have_stock(best_assembly: Assembly, number: str) -> None:
    part = part_of(best_assembly, number)
    circles = [entity for entity in read(profile(part).dxf()) if entity.dxftype() == "CIRCLE"]
    pilots = sorted(round(2 * c.dxf.radius, 3) for c in circles if c.dxf.layer == "PILOT")
    axis = profile(part).axis
    along = [b for hole in part.holes for b in hole.bores if b.through and abs(b.direction[axis]) > 0.999]
    later = [bore for bore in along if bore.thread or bore.deviations_um]
    by_hand = {"foot_block": [3.3, 3.3], "motor_cheek": [2.5, 2.5, 3.5, 14.0]}  # 3 H7 twice, 4 H7 and 15 H7
    assert pilots == by_hand[number]
    cut = {round(2 * c.dxf.radius, 3) for c in circles if c.dxf.layer == "HOLES"}
    assert cut == {bore.diameter_mm for bore in along} - {bore.diameter_mm for bore in later}


def test_what_is_turned_rounded_thick_or_small_has_none(best_assembly: Assembly) -> None:
    plate = part_of(best_assembly, "foot_block")
    box = cq.Workplane().box(60.0, 50.0, 10.0).val()

    def is_plate(solid: Any) -> bool:
        return profile_of(replace(plate, solid=solid, holes=(), order_code="")) is not None

    assert is_plate(box)
    assert is_plate(cq.Workplane().circle(40.0).extrude(8.0).val())
    assert not is_plate(cq.Workplane().circle(20.0).extrude(8.0).val())  # off a bar
    assert not is_plate(cq.Workplane().box(60.0, 50.0, 40.0).val())  # a block
    assert not is_plate(cq.Workplane().box(60.0, 10.0, 8.0).val())  # falls through the table
    roll = cq.Workplane("XZ").circle(5.0).extrude(25.0, both=True).translate((30.0, 0.0, 0.0))
    assert not is_plate(cq.Workplane().box(60.0, 50.0, 10.0).union(roll).val())  # no wall at its end
    assert profile_of(replace(plate, order_code="plate as bought")) is None


def test_a_side_bulge_between_walls_is_no_plate_and_a_cross_bore_in_a_wall_hides_nothing(
    best_assembly: Assembly,
) -> None:
    plate = part_of(best_assembly, "foot_block")
    box = cq.Workplane().box(60.0, 50.0, 10.0)
    ball = cq.Workplane().sphere(4.0).translate((30.0, 0.0, 0.0))
    assert profile_of(replace(plate, solid=box.union(ball).val(), holes=())) is None
    bored = box.faces(">X").workplane().hole(6.0)
    assert profile(replace(plate, solid=bored.val(), holes=())).area_mm2 == pytest.approx(3000.0)
    pocket = box.faces(">Z").workplane().rect(30.0, 20.0).cutBlind(-4.0)
    assert profile(replace(plate, solid=pocket.val(), holes=())).area_mm2 == pytest.approx(3000.0)
    window = profile(replace(plate, solid=box.cut(cq.Workplane().box(30.0, 20.0, 20.0)).val(), holes=()))
    assert window.area_mm2 == pytest.approx(2400.0)
    assert [one.layer for one in window.openings] == ["HOLES"]


def test_a_printed_plate_has_none(best_assembly: Assembly, tmp_path: Any) -> None:
    printed = replace(part_of(best_assembly, "base_plate"), material=material("petg-fdm"))
    write_profiles([printed], tmp_path / "profiles")
    assert not (tmp_path / "profiles").exists()


def test_files_are_named_after_their_parts_and_the_same_each_time(best_assembly: Assembly, tmp_path: Any) -> None:
    parts = [part_of(best_assembly, number) for number in ("foot_block", "handle_stem", "cross_bar")]
    write_profiles(parts[1:], tmp_path / "none")
    assert not (tmp_path / "none").exists()
    write_profiles(parts, tmp_path / "profiles")
    (file,) = (tmp_path / "profiles").iterdir()
    assert file.name == "foot_block.profile.dxf"
    assert file.read_text(encoding="utf-8") == profile(parts[0]).dxf()
