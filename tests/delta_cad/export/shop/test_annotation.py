"""Annotations that viewers show: one for each tolerance of a file, read back by the kernel, clear of the part."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.export.drawings.part.controlled import controlled
from delta_cad.export.drawings.sheet_io.lettering import width_of
from delta_cad.export.shop.annotation import Flags, outlines
from delta_cad.export.step import write_part_step
from tests.delta_cad.export.shop.reading import entities, of_kind
from tests.delta_cad.export.shop.test_pmi import read

PARTS = ("foot_block", "motor_cheek", "cross_bar", "cup_shell")


@pytest.fixture(scope="module", params=PARTS)
def file(
    request: pytest.FixtureRequest,
    best_assembly: Assembly,
    best_dimensions: Dimensions,
    tmp_path_factory: pytest.TempPathFactory,
) -> Path:
    part = next(part for part in best_assembly.parts if part.number == request.param)
    path = tmp_path_factory.mktemp("shown") / f"{part.number}.step"
    write_part_step(part, path, held=controlled(best_dimensions).get(part.number))
    return path


def shown_in(path: Path) -> list[Any]:
    """What the kernel's reader shows of each dimension and tolerance of a file."""
    from OCP.TDF import TDF_LabelSequence
    from OCP.XCAFDoc import XCAFDoc_Dimension, XCAFDoc_GeomTolerance

    document, tool = read(path)
    assert document is not None  # its labels live as long as it does
    sizes, zones = TDF_LabelSequence(), TDF_LabelSequence()
    tool.GetDimensionLabels(sizes)
    tool.GetGeomToleranceLabels(zones)
    found = [XCAFDoc_Dimension.Set_s(sizes.Value(k)).GetObject() for k in range(1, sizes.Length() + 1)]
    found += [XCAFDoc_GeomTolerance.Set_s(zones.Value(k)).GetObject() for k in range(1, zones.Length() + 1)]
    return [one.GetPresentation() for one in found]


def test_every_tolerance_and_datum_is_shown_once(file: Path) -> None:
    found = entities(file)
    occurrences = of_kind(found, "TESSELLATED_ANNOTATION_OCCURRENCE")
    sizes = sum(len(of_kind(found, kind)) for kind in ("DIMENSIONAL_SIZE", "DIMENSIONAL_LOCATION"))
    zones = file.read_text().count("GEOMETRIC_TOLERANCE_WITH_DATUM_REFERENCE((")
    letters = set(of_kind(found, "DATUM"))
    assert sizes > 0
    assert len(occurrences) == sizes + zones + len(letters)
    assert len(of_kind(found, "ANNOTATION_PLANE")) == len(occurrences)
    linked = "".join(of_kind(found, "DRAUGHTING_MODEL_ITEM_ASSOCIATION"))
    assert linked.count("PMI representation to presentation link") >= sizes + zones
    assert "('white')" not in file.read_text()


@pytest.mark.parametrize(
    ("up", "right", "letters"),
    [
        ((0, 0, 1), (1, 0, 0), (0, 0, 1)),
        ((0, 0, -1), (1, 0, 0), (0, 0, 1)),
        ((0, 1, 0), (1, 0, 0), (0, 1, 0)),
        ((0, -1, 0), (1, 0, 0), (0, 1, 0)),
        ((1, 0, 0), (0, 1, 0), (-1, 0, 0)),
        ((-1, 0, 0), (0, 1, 0), (-1, 0, 0)),
    ],
)
def test_no_text_is_upside_down_or_mirrored(
    up: tuple[float, ...], right: tuple[float, ...], letters: tuple[float, ...]
) -> None:
    """An L over each side of a cube: its stem and its foot lie as they are written, seen along the stated normal."""
    cube = cq.Workplane().box(20, 20, 20).val()
    assert isinstance(cube, cq.Solid)
    face = max(cube.Faces(), key=lambda one: float(np.dot(one.Center().toTuple(), up)))
    flag = Flags(cube).flag("L", face)
    assert flag.right == pytest.approx(right)
    assert flag.normal == pytest.approx(np.cross(right, letters))
    lines = cq.Shape.cast(flag.shape).Edges()[1:]  # without the leader
    points = np.array([p.toTuple() for line in lines for p in line.positions(np.linspace(0.0, 1.0, 200))]) - flag.at_mm
    along, over = points @ right, points @ letters
    assert min(along.min(), over.min()) > -1e-6
    high = over > 0.8 * over.max()
    assert along[high].max() < 0.5 * along.max()  # nothing right above an L's foot


def test_a_size_is_shown_with_its_fit_and_surface(file: Path) -> None:
    """Not the surface alone: what is shown begins with the size."""
    from OCP.TDF import TDF_LabelSequence
    from OCP.XCAFDoc import XCAFDoc_Dimension

    document, tool = read(file)
    assert document is not None
    sizes = TDF_LabelSequence()
    tool.GetDimensionLabels(sizes)
    names = []
    for k in range(1, sizes.Length() + 1):
        name = XCAFDoc_Dimension.Set_s(sizes.Value(k)).GetObject().GetPresentationName()
        names.append("" if name is None else name.ToCString())
    assert names
    assert not [name for name in names if name.startswith("Ra ")]
    if file.stem == "motor_cheek":
        assert sum("16 H7" in name and name.endswith("Ra 1.6") for name in names) == 1


def test_the_kernel_reads_lines_outside_the_part(file: Path) -> None:
    box, shown = cq.importers.importStep(str(file)).val().BoundingBox(), shown_in(file)
    assert shown
    for shape in shown:
        assert not shape.IsNull()
        lines = cq.Shape.cast(shape).BoundingBox()
        beyond = (
            box.xmin - lines.xmin, lines.xmax - box.xmax, box.ymin - lines.ymin, lines.ymax - box.ymax,
            box.zmin - lines.zmin, lines.zmax - box.zmax,
        )  # fmt: skip
        assert max(beyond) > 0.5


def test_the_same_part_has_the_same_bytes(best_assembly: Assembly, best_dimensions: Dimensions, tmp_path: Path) -> None:
    part = next(part for part in best_assembly.parts if part.number == "cross_bar")
    for name in ("one", "other"):
        write_part_step(part, tmp_path / name, held=controlled(best_dimensions)["cross_bar"])
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()


def test_letters_are_closed_as_high_and_as_wide_as_those_of_drawings() -> None:
    lines = outlines("HH", 2.5)
    assert len(lines) == 2
    assert all(line[0] == line[-1] for line in lines)
    points = np.concatenate([np.array(line) for line in lines])
    assert np.ptp(points[:, 1]) == pytest.approx(2.5)
    pitch = np.array(lines[1])[:, 0].min() - np.array(lines[0])[:, 0].min()
    assert pitch == pytest.approx(width_of("H", 2.5))
    assert [len(outlines(letter, 2.5)) for letter in ("8", "0", "±", " ", "2")] == [3, 2, 2, 0, 1]


def test_flags_of_one_side_stand_one_over_the_other_and_read_from_outside() -> None:
    solid = cq.Workplane().box(40.0, 30.0, 10.0).faces(">Z").workplane().hole(6.0).solids().val()
    assert isinstance(solid, cq.Solid)
    flags = Flags(solid)
    top = max(solid.Faces(), key=lambda face: face.Center().z)
    bore = next(face for face in solid.Faces() if face.geomType() == "CYLINDER")
    first, second = flags.flag("A", top), flags.flag("Ø6 H7", bore)
    assert 5.0 < first.at_mm[2] < second.at_mm[2] - 1.0
    assert float(first.right @ first.normal) == pytest.approx(0.0, abs=1e-12)
    assert np.cross(first.normal, first.right) == pytest.approx([0.0, 0.0, 1.0])  # letters stand upright on the face
