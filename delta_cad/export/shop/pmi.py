"""Tolerances of a made part as data in its AP242 file: fits, threads, places of bores, and the notes of a title block.

Each bore with a fit, deviations of its own or a thread has a diameter on its faces. The largest plane face across the
largest fitted bore is datum A, that bore datum B and square to A; the other fitted bores have their place from A and B.
"""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

import re
from typing import Any

import cadquery as cq
import numpy as np
from OCP import XCAFDimTolObjects
from OCP.StepBasic import (
    StepBasic_GeneralProperty,
    StepBasic_GeneralPropertyAssociation,
    StepBasic_ProductDefinition,
)
from OCP.StepRepr import (
    StepRepr_CharacterizedDefinition,
    StepRepr_DescriptiveRepresentationItem,
    StepRepr_HArray1OfRepresentationItem,
    StepRepr_PropertyDefinition,
    StepRepr_PropertyDefinitionRepresentation,
    StepRepr_Representation,
    StepRepr_RepresentationContext,
    StepRepr_RepresentedDefinition,
)
from OCP.StepShape import StepShape_LimitsAndFits, StepShape_ToleranceValue
from OCP.TCollection import TCollection_HAsciiString
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import XCAFDoc_Datum, XCAFDoc_Dimension, XCAFDoc_DocumentTool, XCAFDoc_GeomTolerance

from delta_cad.dimensions.tolerances import PLACE_MM, SQUARE_MM
from delta_cad.dimensions.tolerances.general import ASKED, NOTES
from delta_cad.solids.boring import faces_of
from delta_cad.solids.part import Bore, Part

GENERAL = {
    "general tolerances": NOTES[ASKED],
    "thread tolerance": "6H, ISO 965-1",
    "surface": "Ra 3.2, machined, unless noted",
    "edges": "outer edges broken 0.2 +-0.1; inner edges up to R1.5 as the cutter leaves them (ISO 13715)",
}
"""What holds for every part where nothing else is said."""
GRADE_TOO_HIGH = 2  # by which the kernel's writer states the grade of a fit: IT7 as 9


def notes(part: Part, general: str = ASKED) -> dict[str, str]:
    """Gives the notes of a part: the general ones with their class, its material, and what its description says."""
    return {**GENERAL, "general tolerances": NOTES[general], "material": part.material.name, "remark": part.description}


def toleranced(part: Part) -> list[Bore]:
    """Lists the bores that have a diameter with a tolerance or a thread; made from both sides they count once."""
    found: list[Bore] = []
    for bore in (b for hole in part.holes for b in hole.bores if b.deviations_um is not None or b.thread):
        if not any(_same_wall(bore, other) for other in found):
            found.append(bore)
    return found


def add_tolerances(document: TDocStd_Document, label: TDF_Label, part: Part) -> None:
    """Adds dimensions, datums and tolerances of a part to a document, before it is transferred.

    Args:
        document: Of the part.
        label: The part's.
        part: With its solid as it was added.
    """
    writer = _Writer(document, label)
    for bore in toleranced(part):
        faces = faces_of(part.solid, bore)
        if faces:
            writer.diameter(bore, faces)
    fitted = [bore for bore in toleranced(part) if bore.deviations_um is not None]
    fitted.sort(key=lambda bore: (not bore.fit, -bore.diameter_mm))
    base = _across(part.solid, fitted[0]) if fitted else None
    if base is None:
        return
    first = faces_of(part.solid, fitted[0])
    writer.tolerance("Perpendicularity", SQUARE_MM, first, {"A": [base]})
    for bore in fitted[1:]:
        writer.tolerance("Position", PLACE_MM, faces_of(part.solid, bore), {"A": [base], "B": first})


def mend_tolerances(model: Any) -> None:
    """Makes the grades of fits those that were set, and the measures of deviations lengths.

    The kernel's writer states deviations without their type, `MEASURE_WITH_UNIT(0.015, ...)`.
    """
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepShape_ToleranceValue):
            for end in (entity.LowerBound(), entity.UpperBound()):
                end.ValueComponentMember().SetName("LENGTH_MEASURE")
        if isinstance(entity, StepShape_LimitsAndFits):
            grade = int(entity.Grade().ToCString()) - GRADE_TOO_HIGH
            entity.SetGrade(TCollection_HAsciiString(str(grade)))


def without_runouts(data: bytes) -> bytes:
    """Takes out of a file the runout zones that the kernel's writer puts beside every round zone, of no tolerance."""
    data = re.sub(rb"#\d+ = RUNOUT_ZONE_DEFINITION\(#\d+,\(\)\);\s*", b"", data)
    angles = re.findall(rb"#\d+ = RUNOUT_ZONE_ORIENTATION\((#\d+)\);", data)
    data = re.sub(rb"#\d+ = RUNOUT_ZONE_ORIENTATION\(#\d+\);\s*", b"", data)
    for angle in angles:
        data = re.sub(rb"\n" + angle + rb" = PLANE_ANGLE_MEASURE_WITH_UNIT\([^;]*;", b"", data)
    return data


def add_notes(model: Any, part: Part, general: str = ASKED) -> None:
    """Adds a part's notes to a transferred model as user defined attributes of its product."""
    entities = [model.Value(number) for number in range(1, model.NbEntities() + 1)]
    product = next(e for e in entities if isinstance(e, StepBasic_ProductDefinition))
    context = next(e for e in entities if isinstance(e, StepRepr_RepresentationContext))
    for name, text in notes(part, general).items():
        definition = StepRepr_CharacterizedDefinition()
        definition.SetValue(product)
        stated = StepRepr_PropertyDefinition()
        stated.Init(_text(name), True, _text(""), definition)
        general = StepBasic_GeneralProperty()
        general.Init(_text(""), _text(name), True, _text("user defined attribute"))
        association = StepBasic_GeneralPropertyAssociation()
        association.Init(_text("user defined attribute"), _text(""), general, stated)
        item = StepRepr_DescriptiveRepresentationItem()
        item.Init(_text(name), _text(text))
        items = StepRepr_HArray1OfRepresentationItem(1, 1)
        items.SetValue(1, item)
        shown = StepRepr_Representation()
        shown.Init(_text(name), items, context)
        represented, holder = StepRepr_RepresentedDefinition(), StepRepr_PropertyDefinitionRepresentation()
        represented.SetValue(stated)
        holder.Init(represented, shown)
        for entity in (association, holder):
            model.AddWithRefs(entity)


class _Writer:
    """Adds dimensions and tolerances to one part of a document."""

    def __init__(self, document: TDocStd_Document, label: TDF_Label) -> None:
        self._shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self._tool = XCAFDoc_DocumentTool.DimTolTool_s(document.Main())
        self._part = label

    def diameter(self, bore: Bore, faces: list[cq.Face]) -> None:
        """Adds the diameter of a bore with its fit, deviations, thread and surface."""
        label = self._tool.AddDimension()
        self._tool.SetDimension(self._labels(faces), TDF_LabelSequence(), label)
        size = XCAFDimTolObjects.XCAFDimTolObjects_DimensionObject()
        size.SetType(XCAFDimTolObjects.XCAFDimTolObjects_DimensionType_Size_Diameter)
        size.SetValue(bore.diameter_mm)
        if bore.fit:
            variance = getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_DimensionFormVariance_{bore.fit[0]}")
            grade = getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_DimensionGrade_IT{bore.fit[1:]}")
            size.SetClassOfTolerance(True, variance, grade)
        if bore.deviations_um is not None:
            lower, upper = (um / 1000.0 for um in bore.deviations_um)
            size.SetUpperTolValue(upper)
            size.SetLowerTolValue(-lower)  # the kernel's writer turns its sign
        for name, text in _remarks(bore).items():
            size.AddDescription(_text(text), _text(name))
        XCAFDoc_Dimension.Set_s(label).SetObject(size)

    def tolerance(self, kind: str, value_mm: float, faces: list[cq.Face], datums: dict[str, list[cq.Face]]) -> None:
        """Adds a tolerance of a diametral zone to faces, from datums in their order."""
        label = self._tool.AddGeomTolerance()
        self._tool.SetGeomTolerance(self._labels(faces), label)
        zone = XCAFDimTolObjects.XCAFDimTolObjects_GeomToleranceObject()
        zone.SetType(getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_GeomToleranceType_{kind}"))
        zone.SetTypeOfValue(XCAFDimTolObjects.XCAFDimTolObjects_GeomToleranceTypeValue_Diameter)
        zone.SetValue(value_mm)
        XCAFDoc_GeomTolerance.Set_s(label).SetObject(zone)
        for position, (name, shown) in enumerate(datums.items(), start=1):
            datum = self._tool.AddDatum()  # every reference wants a label of its own
            self._tool.SetDatum(self._labels(shown), datum)
            record = XCAFDimTolObjects.XCAFDimTolObjects_DatumObject()
            record.SetName(_text(name))
            record.SetPosition(position)
            XCAFDoc_Datum.Set_s(datum).SetObject(record)
            self._tool.SetDatumToGeomTol(datum, label)

    def _labels(self, faces: list[cq.Face]) -> TDF_LabelSequence:
        found = TDF_LabelSequence()
        for face in faces:
            label = self._shapes.AddSubShape(self._part, face.wrapped)
            if label.IsNull():  # it has one already
                label = TDF_Label()
                self._shapes.FindSubShape(self._part, face.wrapped, label)
            found.Append(label)
        return found


def _remarks(bore: Bore) -> dict[str, str]:
    """What is told in words beside a diameter."""
    deep = "through" if bore.through else f"{bore.depth_mm:g} deep"
    found = {"callout": bore.callout}
    if bore.thread:
        found["thread"] = f"{bore.thread}-6H x {bore.thread_mm:g}, drill {bore.diameter_mm:g} {deep}"
    if bore.surface_um is not None:
        found["surface"] = f"Ra {bore.surface_um:g}"
    return found


def _across(solid: cq.Shape, bore: Bore) -> cq.Face | None:
    """The largest plane face of a solid square to a bore."""
    way = np.array(bore.direction)
    square = [
        face
        for face in solid.Faces()
        if face.geomType() == "PLANE" and abs(abs(float(np.array(face.normalAt().toTuple()) @ way)) - 1.0) < 1e-9
    ]
    return max(square, key=lambda face: round(face.Area(), 6)) if square else None


def _same_wall(one: Bore, other: Bore) -> bool:
    """Whether two bores are one, made from either side."""
    a, b, along = np.array(one.start_mm), np.array(other.start_mm), np.array(one.direction)
    if one.diameter_mm != other.diameter_mm or not (one.through and other.through):
        return False
    return float(np.linalg.norm(a + one.depth_mm * along - b)) < 1e-6 or float(np.linalg.norm(a - b)) < 1e-6


def _text(value: str) -> TCollection_HAsciiString:
    return TCollection_HAsciiString(value)
