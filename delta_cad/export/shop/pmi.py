"""Tolerances of a made part as data in its AP242 file: those of its drawing and the notes of its title block.

Each bore with a fit, deviations of its own or a thread has a diameter on its faces, and so has what else is round and
asked for; lengths and depths lie between planes. Datums and geometric tolerances are those of `drawings.part.zones`.
"""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import cadquery as cq
import numpy as np
from OCP import XCAFDimTolObjects
from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
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
from OCP.StepVisual import StepVisual_DraughtingPreDefinedColour
from OCP.TCollection import TCollection_HAsciiString
from OCP.TDF import TDF_Label, TDF_LabelSequence
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import XCAFDoc_Datum, XCAFDoc_Dimension, XCAFDoc_DocumentTool, XCAFDoc_GeomTolerance

from delta_cad.dimensions.tolerances.general import EDGES, NOTES, REQUIRED
from delta_cad.export.drawings.part.controlled import SAME_MM, Controlled, Length, Round
from delta_cad.export.drawings.part.faces import Face
from delta_cad.export.drawings.part.faces import faces_of as read_faces
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.drawings.part.holes import HoleError
from delta_cad.export.drawings.part.record import Zone
from delta_cad.export.drawings.part.zones import is_wall
from delta_cad.export.shop.annotation import Flags
from delta_cad.solids.boring import faces_of
from delta_cad.solids.part import Bore, Part, Slot

GENERAL = {
    "general tolerances": NOTES[REQUIRED],
    "thread tolerance": "6H, ISO 965-1",
    "surface": "Ra 3.2, machined, unless noted",
    "edges": EDGES,
}
"""What holds for every part where nothing else is said."""
_DIAMETER = "Ø"
_SYMBOLS = {"perpendicularity": "\u22a5", "coaxiality": "\u25ce"}
"""Of ISO 1101, as far as the lettering has them; another zone is named."""
_SHOWN_IN = "blue"  # colour of annotations: seen on light and on dark
_NOT_PLAIN = re.compile(r"[^\x00-\x5b\x5d-\x7f]+")
_GRADE_TOO_HIGH = 2  # by which the kernel's writer states the grade of a fit: IT7 as 9


def notes(part: Part, held: Controlled, general: str = REQUIRED) -> dict[str, str]:
    """Gives the notes of a part: the general ones with their class, its material, its functional edges, its remark."""
    edges = {f"edge {n}": edge.text for n, edge in enumerate(held.edges, start=1)}
    own = {"general tolerances": NOTES[general], "material": part.material.name, **edges, "remark": part.description}
    return GENERAL | own


def toleranced(part: Part) -> list[Bore]:
    """Lists the bores that have a diameter with a tolerance or a thread; made from both sides they count once."""
    found: list[Bore] = []
    for bore in (b for hole in part.holes for b in hole.bores if b.deviations_um is not None or b.thread):
        if not any(_same_wall(bore, other) for other in found):
            found.append(bore)
    return found


def add_tolerances(document: TDocStd_Document, label: TDF_Label, part: Part, held: Controlled) -> None:
    """Adds dimensions, datums and tolerances of a part to a document, before it is transferred."""
    writer = _Writer(document, label, part.solid)
    for bore in toleranced(part):
        faces = faces_of(part.solid, bore)
        if faces:
            writer.diameter(bore, faces)
    read = read_faces(part.solid)
    known = dict(zip(map(id, read), part.solid.Faces(), strict=True))
    try:
        found = features_of(part, read, held)
    except HoleError:  # the check of bores says so
        return

    def shapes(faces: Iterable[Face]) -> list[cq.Face]:
        return [known[id(face)] for face in faces]

    for size in found.sizes:
        if size.tolerance is not None:
            for faces in size.pieces or [size.faces]:
                writer.round(size.tolerance, size.kind, not size.text.split("x ")[-1].startswith("R"), shapes(faces))
    for length in (*held.lengths, *held.depths):
        ends = [shapes(_planes(read, length.axis, at)) for at in (length.start_mm, length.end_mm)]
        if all(ends):
            writer.length(length, ends[0], ends[1])
    for slot in (slot for hole in part.holes for slot in hole.slots):
        walls = [face for face in read if is_wall(face, slot)]
        ends = [[face for face in walls if face is walls[0]], [face for face in walls if face is not walls[0]]]
        if all(ends):
            writer.width(slot, shapes(ends[0]), shapes(ends[1]))
    datums = {datum.letter: shapes(datum.faces) for datum in found.datums}
    for zone in found.zones:
        writer.tolerance(zone, shapes(zone.faces), {letter: datums[letter] for letter in zone.datums})


def _planes(faces: Iterable[Face], axis: int, at_mm: float) -> list[Face]:
    """Planes across an axis of the part at a coordinate."""
    planes = (face for face in faces if face.kind == "plane" and abs(face.axis[axis]) > 1.0 - 1e-9)
    return [face for face in planes if abs(float(face.point[axis]) - at_mm) < SAME_MM]


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
            grade = int(entity.Grade().ToCString()) - _GRADE_TOO_HIGH
            entity.SetGrade(TCollection_HAsciiString(str(grade)))
        if isinstance(entity, StepVisual_DraughtingPreDefinedColour):  # white, as the writer has it
            entity.GetPreDefinedItem().SetName(TCollection_HAsciiString(_SHOWN_IN))


def without_runouts(data: bytes) -> bytes:
    """Takes out of a file the runout zones that the kernel's writer puts beside every round zone, of no tolerance."""
    data = re.sub(rb"#\d+ = RUNOUT_ZONE_DEFINITION\(#\d+,\(\)\);\s*", b"", data)
    angles = re.findall(rb"#\d+ = RUNOUT_ZONE_ORIENTATION\((#\d+)\);", data)
    data = re.sub(rb"#\d+ = RUNOUT_ZONE_ORIENTATION\(#\d+\);\s*", b"", data)
    for angle in angles:
        data = re.sub(rb"\n" + angle + rb" = PLANE_ANGLE_MEASURE_WITH_UNIT\([^;]*;", b"", data)
    return data


def add_notes(model: Any, stated: Mapping[str, str]) -> None:
    """Adds a part's `notes` to a transferred model as user defined attributes of its product."""
    entities = [model.Value(number) for number in range(1, model.NbEntities() + 1)]
    product = next(e for e in entities if isinstance(e, StepBasic_ProductDefinition))
    context = next(e for e in entities if isinstance(e, StepRepr_RepresentationContext))
    definition = StepRepr_CharacterizedDefinition()
    definition.SetValue(product)
    for name, text in stated.items():
        attribute = StepRepr_PropertyDefinition()
        attribute.Init(step_text(name), True, step_text(""), definition)
        general = StepBasic_GeneralProperty()
        general.Init(step_text(""), step_text(name), True, step_text("user defined attribute"))
        association = StepBasic_GeneralPropertyAssociation()
        association.Init(step_text("user defined attribute"), step_text(""), general, attribute)
        item = StepRepr_DescriptiveRepresentationItem()
        item.Init(step_text(name), step_text(text))
        items = StepRepr_HArray1OfRepresentationItem(1, 1)
        items.SetValue(1, item)
        shown = StepRepr_Representation()
        shown.Init(step_text(name), items, context)
        represented, holder = StepRepr_RepresentedDefinition(), StepRepr_PropertyDefinitionRepresentation()
        represented.SetValue(attribute)
        holder.Init(represented, shown)
        for entity in (association, holder):
            model.AddWithRefs(entity)


class _Writer:
    """Adds dimensions and tolerances to one part of a document."""

    def __init__(self, document: TDocStd_Document, label: TDF_Label, solid: cq.Solid) -> None:
        self._shapes = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
        self._tool = XCAFDoc_DocumentTool.DimTolTool_s(document.Main())
        self._part, self._flags = label, Flags(solid)
        self._shown: set[str] = set()  # datums

    def diameter(self, bore: Bore, faces: list[cq.Face]) -> None:
        """Adds the diameter of a bore with its fit, deviations, thread and surface."""
        size = self._size("Diameter", bore.diameter_mm, bore.fit, is_hole=True)
        if bore.deviations_um is not None:
            _deviate(size, bore.deviations_um[0] / 1000.0, bore.deviations_um[1] / 1000.0)
        fit = f"{_DIAMETER}{bore.diameter_mm:g} {bore.fit}".rstrip() + _deviations(bore.deviations_um)
        self._add(size, f"{bore.thread}-6H x {bore.thread_mm:g}" if bore.thread else fit, _remarks(bore), faces)

    def round(self, requested: Round, kind: str, is_diameter: bool, faces: list[cq.Face]) -> None:
        """Adds the diameter or the radius of what is round and no bore, with its fit, deviations, thread, surface."""
        share = 1.0 if is_diameter else 0.5
        name = ("Spherical" if kind == "ball" else "") + ("Diameter" if is_diameter else "Radius")
        size = self._size(name, share * requested.diameter_mm, requested.fit, is_hole=False)
        if requested.deviations_mm is not None:
            _deviate(size, share * requested.deviations_mm[0], share * requested.deviations_mm[1])
        remarks = {"thread": f"{requested.thread}-6g"} if requested.thread else {}
        if requested.surface_um is not None:
            remarks["surface"] = f"Ra {requested.surface_um:g}"
        sign = ("S" if kind == "ball" else "") + (_DIAMETER if is_diameter else "R")
        thousandths = requested.deviations_mm and tuple(1000.0 * share * one for one in requested.deviations_mm)
        text = f"{sign}{share * requested.diameter_mm:g} {requested.fit}".rstrip() + _deviations(thousandths)
        self._add(size, remarks.get("thread", text), remarks, faces)

    def length(self, length: Length, start: list[cq.Face], end: list[cq.Face]) -> None:
        """Adds the distance of two planes."""
        size = XCAFDimTolObjects.XCAFDimTolObjects_DimensionObject()
        size.SetType(XCAFDimTolObjects.XCAFDimTolObjects_DimensionType_Location_LinearDistance)
        size.SetValue(abs(length.end_mm - length.start_mm))
        _deviate(size, *length.deviations_mm)
        self._add(size, f"{abs(length.end_mm - length.start_mm):.6g} {length.text}", {}, start, end)

    def width(self, slot: Slot, first: list[cq.Face], second: list[cq.Face]) -> None:
        """Adds the width of a slot for a pin: the distance of its long sides, with its fit."""
        size = XCAFDimTolObjects.XCAFDimTolObjects_DimensionObject()
        size.SetType(XCAFDimTolObjects.XCAFDimTolObjects_DimensionType_Location_LinearDistance)
        size.SetValue(slot.width_mm)
        _deviate(size, slot.deviations_um[0] / 1000.0, slot.deviations_um[1] / 1000.0)
        text = f"{slot.width_mm:g} {slot.fit}{_deviations(slot.deviations_um)}"
        self._add(size, text, {"fit": slot.fit}, first, second)

    def _size(self, name: str, value_mm: float, fit: str, *, is_hole: bool) -> Any:
        """A size with its fit."""
        size = XCAFDimTolObjects.XCAFDimTolObjects_DimensionObject()
        size.SetType(getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_DimensionType_Size_{name}"))
        size.SetValue(value_mm)
        if fit:
            variance = getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_DimensionFormVariance_{fit[0].upper()}")
            grade = getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_DimensionGrade_IT{fit[1:]}")
            size.SetClassOfTolerance(is_hole, variance, grade)
        return size

    def _add(
        self, size: Any, text: str, remarks: dict[str, str], first: list[cq.Face], second: Sequence[cq.Face] = ()
    ) -> None:
        label = self._tool.AddDimension()
        self._tool.SetDimension(self._labels(first), self._labels(second), label)
        for name, remark in remarks.items():
            size.AddDescription(step_text(remark), step_text(name))
        text = f"{text}, {remarks['surface']}" if "surface" in remarks else text
        self._present(size, text, first[0])
        XCAFDoc_Dimension.Set_s(label).SetObject(size)

    def tolerance(self, requested: Zone, faces: list[cq.Face], datums: dict[str, list[cq.Face]]) -> None:
        """Adds a geometric tolerance to faces, from datums in their order."""
        label = self._tool.AddGeomTolerance()
        self._tool.SetGeomTolerance(self._labels(faces), label)
        zone = XCAFDimTolObjects.XCAFDimTolObjects_GeomToleranceObject()
        zone.SetType(getattr(XCAFDimTolObjects, f"XCAFDimTolObjects_GeomToleranceType_{requested.kind.capitalize()}"))
        if requested.is_round:
            zone.SetTypeOfValue(XCAFDimTolObjects.XCAFDimTolObjects_GeomToleranceTypeValue_Diameter)
        zone.SetValue(requested.value_mm)
        if requested.combined:  # ISO 5458: CZ
            zone.AddModifier(XCAFDimTolObjects.XCAFDimTolObjects_GeomToleranceModif_Common_Zone)
        value = f"{_DIAMETER * requested.is_round}{requested.value_mm:g}{' CZ' * requested.combined}"
        self._present(zone, " ".join([_SYMBOLS.get(requested.kind, requested.kind), value, *datums]), faces[0])
        XCAFDoc_GeomTolerance.Set_s(label).SetObject(zone)
        for position, (name, shown) in enumerate(datums.items(), start=1):
            datum = self._tool.AddDatum()  # every reference wants a label of its own
            self._tool.SetDatum(self._labels(shown), datum)
            record = XCAFDimTolObjects.XCAFDimTolObjects_DatumObject()
            record.SetName(step_text(name))
            record.SetPosition(position)
            if name not in self._shown:
                self._present(record, f"[{name}]", shown[0])
                self._shown.add(name)
            XCAFDoc_Datum.Set_s(datum).SetObject(record)
            self._tool.SetDatumToGeomTol(datum, label)

    def _present(self, record: Any, text: str, face: cq.Face) -> None:
        """Gives a dimension, tolerance or datum lines that viewers show."""
        flag = self._flags.flag(text, face)
        at = gp_Pnt(*flag.at_mm.tolist())
        record.SetPresentation(flag.shape, step_text(text))
        record.SetPlane(gp_Ax2(at, gp_Dir(*flag.normal.tolist()), gp_Dir(*flag.right.tolist())))
        record.SetPointTextAttach(at)

    def _labels(self, faces: Sequence[cq.Face]) -> TDF_LabelSequence:
        found = TDF_LabelSequence()
        for face in faces:
            label = self._shapes.AddSubShape(self._part, face.wrapped)
            if label.IsNull():  # it has one already
                label = TDF_Label()
                self._shapes.FindSubShape(self._part, face.wrapped, label)
            found.Append(label)
        return found


def _deviate(size: Any, lower_mm: float, upper_mm: float) -> None:
    size.SetUpperTolValue(upper_mm)
    size.SetLowerTolValue(-lower_mm)  # the kernel's writer turns its sign


def _deviations(um: Sequence[float] | None) -> str:
    """Lower and upper deviation as they stand behind a size, mm."""
    return (
        "" if um is None else f" {um[1] / 1000.0:+.4g}/{um[0] / 1000.0:+.4g}".replace("+0/", "0/").replace("/+0", "/0")
    )


def _remarks(bore: Bore) -> dict[str, str]:
    """What is told in words beside a diameter."""
    deep = "through" if bore.through else f"{bore.depth_mm:g} deep"
    found = {"callout": bore.callout}
    if bore.thread:
        found["thread"] = f"{bore.thread}-6H x {bore.thread_mm:g}, drill {bore.diameter_mm:g} {deep}"
    if bore.surface_um is not None:
        found["surface"] = f"Ra {bore.surface_um:g}"
    return found


def _same_wall(one: Bore, other: Bore) -> bool:
    """Whether two bores are one, made from either side."""
    a, b, along = np.array(one.start_mm), np.array(other.start_mm), np.array(one.direction)
    if one.diameter_mm != other.diameter_mm or not (one.through and other.through):
        return False
    return float(np.linalg.norm(a + one.depth_mm * along - b)) < 1e-6 or float(np.linalg.norm(a - b)) < 1e-6


def step_text(value: str) -> TCollection_HAsciiString:
    r"""Codes a text as ISO 10303-21 does: `\X2\` or `\X4\` for what is not ASCII, and for a backslash of its own."""

    def coded(found: re.Match[str]) -> str:
        kind, code = ("X2", "utf-16-be") if max(found[0]) <= "\uffff" else ("X4", "utf-32-be")
        return f"\\{kind}\\{found[0].encode(code).hex().upper()}\\X0\\"

    return TCollection_HAsciiString(_NOT_PLAIN.sub(coded, value))
