"""The STEP file, read back by two readers that are not the writer's settings: gmsh's own kernel and the XCAF reader."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.export.step import StepError, write_assembly_step, write_part_step
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Part
from tests.delta_cad.export.machine import VOLUMES_MM3, make_assembly, make_parts, translation

VOLUME_RELATIVE = 1e-6
"""What a build promises; the kernel's integrals of these solids are good to 1e-9."""
COLOUR_STEP = 1 / 255 + 1e-9
"""gmsh returns colours as bytes."""
PLACE_MM = 1e-6
"""The file prints 15 digits; a nanometre is far above that and far below any machine."""


def data_lines(path: Path) -> str:
    return re.sub(r"\s*\n\s*", "", path.read_text())


@pytest.fixture(scope="module")
def gmsh_solids(step_file: Path) -> list[dict[str, Any]]:
    import gmsh

    gmsh.initialize(["-noenv"], readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Geometry.OCCImportLabels", 1)
        gmsh.model.add("read")
        volumes = gmsh.model.occ.importShapes(str(step_file))
        gmsh.model.occ.synchronize()
        return [
            {
                "name": gmsh.model.getEntityName(3, tag),
                "colour": gmsh.model.getColor(3, tag)[:3],
                "volume": gmsh.model.occ.getMass(3, tag),
                "centre": np.array(gmsh.model.occ.getCenterOfMass(3, tag)),
            }
            for dimension, tag in volumes
            if dimension == 3
        ]
    finally:
        gmsh.finalize()


def test_gmsh_finds_every_solid_with_its_number_colour_volume_and_place(
    machine: Assembly, gmsh_solids: list[dict[str, Any]]
) -> None:
    numbers = [solid["name"].split("/")[-1] for solid in gmsh_solids]
    assert Counter(numbers) == Counter(o.part.number for o in machine.occurrences)
    parts, poses = {part.number: part for part in machine.parts}, machine.poses(machine.home_mm)
    for number, solid in zip(numbers, gmsh_solids, strict=True):
        assert solid["volume"] == pytest.approx(VOLUMES_MM3[number], rel=VOLUME_RELATIVE)
        colour = np.array(solid["colour"]) / 255
        np.testing.assert_allclose(colour, parts[number].material.colour, atol=COLOUR_STEP)
    centres = {number: np.array(part.solid.Center().toTuple()) for number, part in parts.items()}
    expected = [poses[o.name][:3, :3] @ centres[o.part.number] + poses[o.name][:3, 3] for o in machine.occurrences]
    found = np.array([solid["centre"] for solid in gmsh_solids])
    distances = np.linalg.norm(found[:, None] - np.array(expected)[None], axis=-1)
    assert distances.min(axis=0).max() < PLACE_MM
    assert distances.min(axis=1).max() < PLACE_MM


def read_document(path: Path) -> dict[str, Any]:
    """Tree, names, colours, materials and placements through the XCAF reader."""
    from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label, TDF_LabelSequence
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import (
        XCAFDoc_ColorGen,
        XCAFDoc_ColorSurf,
        XCAFDoc_ColorTool,
        XCAFDoc_DocumentTool,
        XCAFDoc_Material,
        XCAFDoc_ShapeTool,
    )

    document = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    reader = STEPCAFControl_Reader()
    reader.SetMatMode(True)
    assert reader.ReadFile(str(path)).name == "IFSelect_RetDone"
    assert reader.Transfer(document)
    shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    materials = XCAFDoc_DocumentTool.MaterialTool_s(document.Main())

    def name(label: Any) -> str:
        attribute = TDataStd_Name()
        assert label.FindAttribute(TDataStd_Name.GetID_s(), attribute)
        return attribute.Get().ToExtString()

    def labels(fill: Any) -> list[Any]:
        sequence = TDF_LabelSequence()
        fill(sequence)
        return [sequence.Value(k + 1) for k in range(sequence.Length())]

    parts: dict[str, dict[str, Any]] = {}
    for label in labels(shapes.GetShapes):
        if XCAFDoc_ShapeTool.IsSimpleShape_s(label) and shapes.IsTopLevel(label):
            colour = Quantity_Color()
            kinds = (XCAFDoc_ColorGen, XCAFDoc_ColorSurf)
            assert any(XCAFDoc_ColorTool.GetColor_s(label, kind, colour) for kind in kinds), name(label)
            parts[name(label)] = {
                "kind": XCAFDoc_ShapeTool.GetShape_s(label).ShapeType().name,
                "colour": colour.Values(Quantity_TOC_sRGB),
            }
    tree: dict[str, list[tuple[str, str]]] = {}
    (root,) = labels(shapes.GetFreeShapes)

    def components(label: Any) -> list[tuple[str, Any, Any]]:
        found = []
        for child in labels(lambda sequence: XCAFDoc_ShapeTool.GetComponents_s(label, sequence)):
            target = TDF_Label()
            assert XCAFDoc_ShapeTool.GetReferredShape_s(child, target)
            found.append((name(child), target, XCAFDoc_ShapeTool.GetLocation_s(child)))
        return found

    for branch, definition, _ in components(root):
        tree[branch] = [(occurrence, name(part)) for occurrence, part, _ in components(definition)]
    stuff = []
    for label in labels(materials.GetMaterialLabels):
        material = XCAFDoc_Material()
        assert label.FindAttribute(XCAFDoc_Material.GetID_s(), material)
        stuff.append((material.GetName().ToCString(), material.GetDensity()))
    return {"root": name(root), "tree": tree, "parts": parts, "materials": stuff}


@pytest.fixture(scope="module")
def document(step_file: Path) -> dict[str, Any]:
    return read_document(step_file)


def test_the_tree_is_product_links_occurrences_of_single_solids(
    machine: Assembly, step_file: Path, document: dict[str, Any]
) -> None:
    assert document["root"] == machine.name
    expected = {link: sorted((o.name, o.part.number) for o in machine.occurrences if o.link == link) for link in LINKS}
    found = {link: sorted(found) for link, found in document["tree"].items()}
    assert found == {link: there for link, there in expected.items() if there}
    assert {number: part["kind"] for number, part in document["parts"].items()} == {
        part.number: "TopAbs_SOLID" for part in machine.parts
    }
    for part in machine.parts:
        np.testing.assert_allclose(document["parts"][part.number]["colour"], part.material.colour, atol=COLOUR_STEP)
    text = data_lines(step_file)
    assert len(re.findall(r"= MANIFOLD_SOLID_BREP\(", text)) == len(machine.parts)
    products = re.findall(r"= PRODUCT\('([^']*)'", text)
    links = {f"link_{o.link}" for o in machine.occurrences}
    assert sorted(products) == sorted({machine.name, *links, *(part.number for part in machine.parts)})
    assert "LENGTH_UNIT() NAMED_UNIT(*) SI_UNIT(.MILLI.,.METRE.)" in text


def test_materials_carry_density_in_grams_per_cubic_centimetre(
    machine: Assembly, step_file: Path, document: dict[str, Any]
) -> None:
    expected = {(part.material.name, part.material.density_kg_m3 / 1000) for part in machine.parts}
    assert set(document["materials"]) == expected
    text = data_lines(step_file)
    assert text.count("= PROPERTY_DEFINITION('material property','density'") == len(machine.parts)
    units = {}
    for number, unit, exponent in re.findall(r"#(\d+) = DERIVED_UNIT_ELEMENT\(#(\d+),([-0-9.]+)\)", text):
        kind = re.search(rf"#{unit} = \( *(MASS|LENGTH)_UNIT\(\) NAMED_UNIT\(\*\) SI_UNIT\(([^)]*)\)", text)
        assert kind
        units[number] = (kind[1], kind[2], float(exponent))
    assert set(units.values()) == {("MASS", "$,.GRAM.", 1.0), ("LENGTH", ".CENTI.,.METRE.", -3.0)}


@pytest.mark.parametrize(("schema", "words"), [("AP242", "AP242_MANAGED_MODEL_BASED"), ("AP214", "AUTOMOTIVE_DESIGN")])
def test_schema_and_header(machine: Assembly, tmp_path: Path, schema: str, words: str) -> None:
    path = tmp_path / "a.step"
    write_assembly_step(machine, path, schema, "B2")
    header, data = path.read_text().split("DATA;")
    assert words in header
    assert f"{machine.name}, revision B2" in header
    versions = re.findall(r"= PRODUCT_DEFINITION_FORMATION\w*\('([^']*)'", data)
    assert len(versions) > len(machine.parts)
    assert set(versions) == {"B2"}
    for word in (machine.name, "2000-01-01T00:00:00", "delta-haptics"):
        assert f"'{word}'" in header


def test_the_schema_of_one_file_does_not_leak_into_the_next_and_nothing_is_printed(
    machine: Assembly, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    from OCP.Interface import Interface_Static

    write_assembly_step(machine, tmp_path / "a.step", "AP214")
    before = Interface_Static.CVal_s("write.step.schema")
    write_assembly_step(machine, tmp_path / "b.step", "AP242")
    assert Interface_Static.CVal_s("write.step.schema") == before
    assert capfd.readouterr() == ("", "")


def test_a_part_file_stands_at_the_parts_origin(tmp_path: Path) -> None:
    import cadquery as cq

    part = make_parts()["base_plate"]
    moved = replace(part, solid=part.solid.moved(cq.Location(cq.Vector(5.0, 6.0, 7.0))))
    write_part_step(moved, tmp_path / "part.step")
    (solid,) = cq.importers.importStep(str(tmp_path / "part.step")).solids().vals()
    assert solid.Volume() == pytest.approx(VOLUMES_MM3["base_plate"], rel=VOLUME_RELATIVE)
    assert solid.Center().toTuple() == pytest.approx((5.0, 6.0, 11.0), abs=PLACE_MM)
    text = data_lines(tmp_path / "part.step")
    assert re.findall(r"= PRODUCT\('([^']*)'", text) == ["base_plate"]
    assert "NEXT_ASSEMBLY_USAGE_OCCURRENCE" not in text


def refused() -> dict[str, Part | Assembly]:
    """What is said of it -> what cannot be written."""
    import cadquery as cq

    parts, machine = make_parts(), make_assembly()
    compound, first = cq.Compound.makeCompound([parts["platform"].solid]), machine.occurrences[0]
    other = replace(make_parts(arm_hole_mm=5.0)["upper_arm"], number="base_plate")

    def also(**changed: Any) -> Assembly:
        return replace(machine, occurrences=(*machine.occurrences, replace(first, **changed)))

    def alone(frame: np.ndarray) -> Assembly:
        return replace(machine, occurrences=(replace(first, placement=frame),))

    return {
        "platform is not one solid": replace(parts["platform"], solid=compound),  # type: ignore[arg-type]
        "base_plate is not a rotation.*by 0$": alone(np.diag([1.0, 1.0, -1.0, 1.0])),
        "base_plate is not a rotation.*by 2e-06": alone(np.diag([1.0, 1.0, 1.0 + 1e-6, 1.0])),
        "number base_plate": also(name="second", part=other),
        "name base_plate": also(placement=translation(1.0, 0.0, 0.0)),
    }


def test_what_would_be_no_true_file_is_refused(tmp_path: Path) -> None:
    for said, what in refused().items():
        write: Any = write_part_step if isinstance(what, Part) else write_assembly_step
        with pytest.raises(StepError, match=said):
            write(what, tmp_path / "a.step")
    with pytest.raises(StepError, match=r"AP203.*AP242, AP214"):
        write_part_step(make_parts()["platform"], tmp_path / "a.step", "AP203")
    with pytest.raises(StepError, match=r"a.step"):
        write_part_step(make_parts()["platform"], tmp_path / "missing" / "a.step")


def test_an_empty_shape_cannot_be_transferred(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from OCP.STEPCAFControl import STEPCAFControl_Writer

    monkeypatch.setattr(STEPCAFControl_Writer, "Transfer", lambda *_: False)
    with pytest.raises(StepError, match=r"^platform: "):
        write_part_step(make_parts()["platform"], tmp_path / "a.step")


def test_a_setting_that_the_kernel_does_not_know_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("delta_cad.export.step.SCHEMAS", {"AP242": "AP999"})
    with pytest.raises(StepError, match="AP999"):
        write_part_step(make_parts()["platform"], tmp_path / "a.step")
