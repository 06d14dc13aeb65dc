"""Parts that are no single sound solid, or have the wrong bores, are refused."""

from collections.abc import Callable
from dataclasses import replace

import cadquery as cq
import pytest

from delta_cad import catalogue
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.solidity import bore_counts, check_solidity
from delta_cad.dimensions import Dimensions
from delta_cad.solids.bought_parts import make_encoder_board, make_foot
from delta_cad.solids.capstan import make_sector
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.platform import make_knob
from tests.delta_cad.checks.machines import STEEL, box, part, parts, rod


def checked(p: Part):
    (result,) = check_solidity([p], MeshLibrary([p], 0.1, 0.5))
    return result


def raw(shape: cq.Shape) -> Part:
    return Part("raw", "raw", shape, STEEL, True)  # type: ignore[arg-type]


@pytest.mark.parametrize("number", parts())
def test_sound_parts_pass(number: str) -> None:
    result = checked(parts()[number])
    assert result.passed, result.detail
    assert result.value is not None
    assert result.limit is not None
    assert result.value < result.limit


def test_open_shell_is_refused() -> None:
    faces = box((0, 0, 0), (1, 2, 3)).Faces()[1:]
    shell = cq.Shell.makeShell(faces)
    open_solid = cq.Solid.makeSolid(shell)
    result = checked(raw(open_solid))
    assert (result.passed, result.value) == (False, None)


def test_bare_shell_is_refused() -> None:
    result = checked(raw(box((0, 0, 0), (1, 2, 3)).Shells()[0]))
    assert (result.passed, result.value) == (False, None)


def test_two_solids_in_a_part_are_refused() -> None:
    two = cq.Compound.makeCompound([box((0, 0, 0), (1, 1, 1)), box((5, 0, 0), (6, 1, 1))])
    result = checked(raw(two))
    assert not result.passed
    assert "2 solids" in result.detail


def test_a_compound_of_one_solid_is_refused() -> None:
    result = checked(raw(cq.Compound.makeCompound([box((0, 0, 0), (1, 1, 1))])))
    assert not result.passed


def test_inside_out_solid_is_refused() -> None:
    solid = cq.Solid(box((0, 0, 0), (1, 2, 3)).wrapped.Reversed())
    result = checked(raw(solid))
    assert not result.passed
    assert result.value is None


def test_a_mesh_that_does_not_hold_the_volume_is_refused() -> None:
    p = part("cylinder", rod(8, (0, 0, 0), (0, 0, 20)))
    library = MeshLibrary([p], 2.0, 1.5)
    coarse = library["cylinder"]
    library._meshes["cylinder"] = replace(coarse, deviation_mm=1e-3, layer_mm3=None)
    (result,) = check_solidity([p], library)
    assert not result.passed
    assert result.value is not None
    assert result.limit is not None
    assert result.value > result.limit


@pytest.mark.parametrize(("radius", "wording"), [(15.0, "mm^3"), (1.5, "no points on 1 cylinders, the first of 3 mm")])
def test_a_mesh_without_a_bore_of_its_plate_is_refused(radius: float, wording: str) -> None:
    plain = rod(130, (0, 0, 0), (0, 0, 8))
    p = part("plate", plain.cut(rod(radius, (50, 0, -1), (50, 0, 9))), (Hole(2.0 * radius, 1, "through"),))
    library = MeshLibrary([p])
    (good,) = check_solidity([p], library)
    assert good.passed
    assert good.limit is not None
    assert good.limit < 0.004 * p.solid.Volume()
    filled = MeshLibrary([part("plate", plain)])["plate"]
    library._meshes["plate"] = filled
    (bad,) = check_solidity([p], library)
    assert not bad.passed
    assert wording in bad.detail


def test_a_leaking_mesh_is_refused() -> None:
    p = part("cylinder", rod(8, (0, 0, 0), (0, 0, 20)))
    library = MeshLibrary([p], 0.1, 0.5)
    library._meshes["cylinder"] = replace(library["cylinder"], faces=library["cylinder"].faces[1:])
    (result,) = check_solidity([p], library)
    assert not result.passed
    assert "watertight" in result.detail


@pytest.mark.parametrize("count", [3, 5])
def test_wrong_hole_count_is_refused(count: int) -> None:
    result = checked(replace(parts()["base_plate"], holes=(Hole(2.5, count, "M3"),)))
    assert not result.passed
    assert "4 bores of 2.5 mm" in result.detail


def test_bores_that_are_not_declared_are_refused() -> None:
    result = checked(replace(parts()["base_plate"], holes=()))
    assert not result.passed
    assert "not declared: 4 of 2.5 mm" in result.detail


def test_the_inside_of_a_rim_is_no_bore_and_a_split_one_is() -> None:
    ring = rod(20, (0, 0, 0), (0, 0, 5)).cut(rod(16, (0, 0, -1), (0, 0, 6)))
    rim = ring.cut(box((-30, -30, -1), (30, -6, 6)))  # 221 degrees are left
    assert bore_counts(rim) == {32.0: 1}
    assert checked(part("rim", rim)).passed
    webbed = rim.fuse(rod(17, (0, 0, 2), (0, 0, 3)).cut(box((-30, -30, -1), (30, -6, 6))))
    assert checked(part("rim", webbed)).passed  # its inside on either side of the web goes no farther round
    split = ring.cut(box((-2, -30, -1), (2, 0, 6)))
    result = checked(part("split", split))
    assert not result.passed
    assert "not declared: 1 of 32 mm" in result.detail


def test_a_closed_void_is_refused() -> None:
    result = checked(part("hollow", box((0, 0, 0), (10, 10, 10)).cut(box((4, 4, 4), (6, 6, 6)))))
    assert (result.passed, result.value) == (False, None)
    assert "1 closed voids" in result.detail


def test_bores_are_counted_by_axis_not_by_face() -> None:
    plate = box((0, 0, 0), (40, 20, 6))
    split = plate.cut(rod(2, (10, 10, -1), (10, 10, 7))).cut(box((4, 9.5, -1), (16, 10.5, 7)))  # one bore, two faces
    # two more: in line through two walls (one axis), and a blind one from the side; a boss and a fillet are no bores
    walls = split.cut(rod(1.5, (30, -1, 3), (30, 21, 3))).cut(box((25, 5, -1), (35, 15, 7)))
    blind = walls.cut(rod(1.0, (-1, 4, 3), (5, 4, 3))).fuse(rod(2.5, (20, 4, 5), (20, 4, 10)))
    assert bore_counts(blind) == {2.0: 1, 3.0: 1, 4.0: 1}


def test_concave_fillets_are_no_bores() -> None:
    angle = cq.Workplane().box(20, 20, 20).cut(cq.Workplane().box(20, 20, 20).translate((5, 5, 0))).edges("|Z")
    filleted = angle.edges(cq.NearestToPointSelector((-5, -5, 0))).fillet(2).val()
    assert bore_counts(filleted) == {}


@pytest.mark.parametrize(
    ("family", "make"),
    [("foot", make_foot), ("knob", make_knob), ("encoder", make_encoder_board)],
)
def test_every_bought_part_of_the_catalogue_is_sound_and_declares_its_bores(
    family: str, make: Callable[[Dimensions], Part], best_dimensions: Dimensions
) -> None:
    """Rows that the committed machine does not use, too: a foot with a hole had none declared."""
    rows = catalogue.family(family)
    for row in rows.values():
        assert checked(make(replace(best_dimensions, **{family: row}))).passed, row.id


def test_a_sector_that_is_shorter_anywhere_is_refused(best_dimensions: Dimensions) -> None:
    """One without the outermost 0.2 mm of its lug passed: along two axes it declared nothing."""
    sector = make_sector(best_dimensions)
    assert checked(sector).passed
    bounds = sector.solid.BoundingBox()
    for axis, (low, high) in (("x", (bounds.xmin, bounds.xmax)), ("z", (bounds.zmin, bounds.zmax))):
        for start, end in ((low - 1.0, low + 0.2), (high - 0.2, high + 1.0)):
            first, last = [-100.0] * 3, [100.0] * 3
            first["xyz".index(axis)], last["xyz".index(axis)] = start, end
            shorter = sector.solid.cut(box((first[0], first[1], first[2]), (last[0], last[1], last[2])))
            found = checked(replace(sector, solid=max(shorter.Solids(), key=cq.Shape.Volume)))
            assert f"it reaches along {axis} from " in found.detail
