"""STEP files: the assembly as a tree of named, coloured, instanced parts with material, and each part alone.

Written through XCAF. The tree is product -> one sub-assembly per link -> occurrences of parts; each part is one
product definition however often it is placed. The kernel's parameters are global: they are put back after each file.
"""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.export.fingerprint import canonical
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Part

if TYPE_CHECKING:
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document

SCHEMAS = {"AP242": "AP242DIS", "AP214": "AP214IS"}
"""Schemas on offer and the kernel's names for them."""
TIME_STAMP = "2000-01-01T00:00:00"
"""Time stamp when the caller gives none: the same input then gives the same header."""
ORGANISATION = "delta-haptics"
ORIGINATING_SYSTEM = "delta-haptics"
RIGID_TOLERANCE = 1e-9
"""Largest deviation of R R^T from the identity: rounding of a few products of unit matrices (1e-15 each), with room."""

KG_M3_TO_STEP_DENSITY = 1e-3
"""The kernel's writer states densities in g/cm^3."""


class StepError(ValueError):
    """A STEP file cannot be written from what was given."""


def write_assembly_step(
    assembly: Assembly,
    path: Path,
    schema: str = "AP242",
    *,
    author: str = "",
    time_stamp: str = TIME_STAMP,
) -> None:
    """Writes the whole machine in its home position.

    Args:
        assembly: The machine.
        path: File to write.
        schema: "AP242" or "AP214".
        author: Who answers for the design, for the header.
        time_stamp: ISO 8601 time for the header; fixed unless given.

    Raises:
        StepError: The schema is unknown, a placement is not rigid, a part is not one solid, two parts share a
            number or two occurrences a name, or the kernel refuses to write.
    """
    _check_names(assembly)
    document, shapes = _document()
    definitions = {part.number: _define(document, part) for part in assembly.parts}
    links = assembly.placement(assembly.home_mm)
    root = shapes.NewShape()
    _name(root, assembly.name)
    for link in sorted({o.link for o in assembly.occurrences}, key=LINKS.index):
        branch = shapes.NewShape()
        _name(branch, f"link_{link}")
        for occurrence in assembly.occurrences:
            if occurrence.link == link:
                place = _location(occurrence.placement, occurrence.name)
                _name(shapes.AddComponent(branch, definitions[occurrence.part.number], place), occurrence.name)
        _name(shapes.AddComponent(root, branch, _location(links[link], link)), link)
    shapes.UpdateAssemblies()
    _write(document, path, schema, assembly.name, author, time_stamp)
    path.write_bytes(canonical(path.read_bytes()))  # the kernel orders colours by where they lie in memory


def write_part_step(
    part: Part, path: Path, schema: str = "AP242", *, author: str = "", time_stamp: str = TIME_STAMP
) -> None:
    """Writes one part at its own origin, with its number, colour and material.

    Args:
        part: The part.
        path: File to write.
        schema: "AP242" or "AP214".
        author: Who answers for the design, for the header.
        time_stamp: ISO 8601 time for the header; fixed unless given.

    Raises:
        StepError: The schema is unknown, the part is not one solid, or the kernel refuses to write.
    """
    document, _ = _document()
    _define(document, part)
    _write(document, path, schema, part.number, author, time_stamp)


def _check_names(assembly: Assembly) -> None:
    """Refuses what would silently merge two things into one in the file."""
    kinds: dict[str, Part] = {}
    seen: set[str] = set()
    for occurrence in assembly.occurrences:
        if kinds.setdefault(occurrence.part.number, occurrence.part) is not occurrence.part:
            raise StepError(f"two different parts share the number {occurrence.part.number}")
        if occurrence.name in seen:
            raise StepError(f"two occurrences share the name {occurrence.name}")
        seen.add(occurrence.name)


def _document() -> tuple[TDocStd_Document, Any]:
    """An empty XCAF document in millimetres and its shape tool."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDocStd import TDocStd_Document
    from OCP.XCAFApp import XCAFApp_Application
    from OCP.XCAFDoc import XCAFDoc_DocumentTool

    format_name = TCollection_ExtendedString("MDTV-XCAF")
    document = TDocStd_Document(format_name)
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)
    return document, XCAFDoc_DocumentTool.ShapeTool_s(document.Main())


def _define(document: TDocStd_Document, part: Part) -> TDF_Label:
    """Adds the product definition of a part: one solid, number, colour, material and density."""
    from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
    from OCP.TCollection import TCollection_HAsciiString
    from OCP.XCAFDoc import XCAFDoc_ColorGen, XCAFDoc_DocumentTool

    main = document.Main()
    label = XCAFDoc_DocumentTool.ShapeTool_s(main).AddShape(_one_solid(part), False)
    _name(label, part.number)
    colour = Quantity_Color(*part.material.colour, Quantity_TOC_sRGB)
    XCAFDoc_DocumentTool.ColorTool_s(main).SetColor(label, colour, XCAFDoc_ColorGen)
    XCAFDoc_DocumentTool.MaterialTool_s(main).SetMaterial(
        label,
        TCollection_HAsciiString(part.material.name),
        TCollection_HAsciiString(part.material.name),
        part.material.density_kg_m3 * KG_M3_TO_STEP_DENSITY,
        TCollection_HAsciiString("density measure"),
        TCollection_HAsciiString("POSITIVE_RATIO_MEASURE"),
    )
    return label


def _one_solid(part: Part) -> Any:
    """The part's solid with any location of its own baked in (a located shape would become an instance)."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
    from OCP.TopAbs import TopAbs_SOLID
    from OCP.TopLoc import TopLoc_Location

    shape = part.solid.wrapped
    if shape.ShapeType() != TopAbs_SOLID:
        raise StepError(f"part {part.number} is not one solid but a {part.solid.ShapeType()}")
    location = shape.Location()
    if location.IsIdentity():
        return shape
    bare = shape.Located(TopLoc_Location())
    return BRepBuilderAPI_Transform(bare, location.Transformation(), True).Shape()


def _location(frame: np.ndarray, name: str) -> Any:
    """TopLoc location of a (4, 4) rigid transform in mm."""
    from OCP.gp import gp_Trsf
    from OCP.TopLoc import TopLoc_Location

    rotation = frame[:3, :3]
    skew = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skew > RIGID_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise StepError(f"placement of {name} is not a rotation: R R^T is off the identity by {skew:.3g}")
    transform = gp_Trsf()
    transform.SetValues(*(float(value) for value in np.asarray(frame, dtype=float)[:3].ravel()))
    return TopLoc_Location(transform)


def _name(label: TDF_Label, name: str) -> None:
    """Names a definition or an occurrence."""
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name

    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))


def _write(document: TDocStd_Document, path: Path, schema: str, title: str, author: str, time_stamp: str) -> None:
    """Transfers a document, fills the header and writes the file."""
    from OCP.IFSelect import IFSelect_RetDone
    from OCP.STEPCAFControl import STEPCAFControl_Writer
    from OCP.STEPControl import STEPControl_AsIs

    if schema not in SCHEMAS:
        raise StepError(f"schema {schema!r} is not one of {', '.join(SCHEMAS)}")
    with _quiet_kernel(), _settings({"write.step.schema": SCHEMAS[schema], "write.step.unit": "MM"}):
        writer = STEPCAFControl_Writer()
        if not writer.Transfer(document, STEPControl_AsIs):
            raise StepError(f"{title}: the shapes could not be transferred to STEP")
        _mend_density_units(writer.ChangeWriter().Model(False))
        _fill_header(writer.ChangeWriter().Model(False), title, author, time_stamp)
        if writer.Write(str(path)) != IFSelect_RetDone:
            raise StepError(f"{title}: {path} could not be written")


@contextmanager
def _settings(values: dict[str, str]) -> Iterator[None]:
    """Sets the kernel's global parameters for the time of one file.

    The controller must exist first: before that a parameter is accepted and ignored.
    """
    from OCP.Interface import Interface_Static
    from OCP.STEPCAFControl import STEPCAFControl_Controller

    STEPCAFControl_Controller.Init_s()
    before = {name: Interface_Static.CVal_s(name) for name in values}
    try:
        for name, value in values.items():
            if not Interface_Static.SetCVal_s(name, value):
                raise StepError(f"the kernel does not know {name} = {value}")
        yield
    finally:
        for name, value in before.items():
            Interface_Static.SetCVal_s(name, value)


def _mend_density_units(model: Any) -> None:
    """Makes the unit of density g/cm^3.

    The kernel writes the factors of the derived unit with the exponents 3 and 2, that is g^3 cm^2.
    """
    from OCP.StepBasic import StepBasic_DerivedUnitElement, StepBasic_SiUnitAndLengthUnit

    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepBasic_DerivedUnitElement):
            entity.SetExponent(-3.0 if isinstance(entity.Unit(), StepBasic_SiUnitAndLengthUnit) else 1.0)


def _fill_header(model: Any, title: str, author: str, time_stamp: str) -> None:
    """Header section: name, time, author, organisation, system."""
    from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
    from OCP.TCollection import TCollection_HAsciiString

    header = APIHeaderSection_MakeHeader(model)
    header.SetName(TCollection_HAsciiString(title))
    header.SetTimeStamp(TCollection_HAsciiString(time_stamp))
    header.SetAuthorValue(1, TCollection_HAsciiString(author))
    header.SetOrganizationValue(1, TCollection_HAsciiString(ORGANISATION))
    header.SetOriginatingSystem(TCollection_HAsciiString(ORIGINATING_SYSTEM))


@contextmanager
def _quiet_kernel() -> Iterator[None]:
    """Keeps the kernel's transfer statistics off the terminal."""
    from OCP.Message import Message

    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)
