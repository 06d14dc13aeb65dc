"""STEP files: the assembly as a tree of named, coloured, instanced parts with material, and each part alone.

Written through XCAF. The tree is product -> one sub-assembly per link -> occurrences of parts; each part is one
product definition however often it is placed. The kernel's parameters are global: they are put back after each file.
"""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from OCP.APIHeaderSection import APIHeaderSection_MakeHeader
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.IFSelect import IFSelect_RetDone
from OCP.Interface import Interface_Static
from OCP.Message import Message
from OCP.Quantity import Quantity_Color, Quantity_TOC_sRGB
from OCP.StepBasic import (
    StepBasic_DerivedUnitElement,
    StepBasic_ProductDefinitionFormation,
    StepBasic_SiUnitAndLengthUnit,
)
from OCP.STEPCAFControl import STEPCAFControl_Controller, STEPCAFControl_Writer
from OCP.STEPControl import STEPControl_AsIs
from OCP.TCollection import TCollection_ExtendedString, TCollection_HAsciiString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.TopAbs import TopAbs_SOLID
from OCP.TopLoc import TopLoc_Location
from OCP.XCAFApp import XCAFApp_Application
from OCP.XCAFDoc import XCAFDoc_ColorGen, XCAFDoc_DocumentTool

from delta_cad.assembly.machine import Assembly
from delta_cad.design.record import FIRST_REVISION
from delta_cad.dimensions.tolerances.general import REQUIRED
from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.fingerprint import canonical
from delta_cad.export.shop.pmi import add_notes, add_tolerances, mend_tolerances, notes, step_text, without_runouts
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Part, location_of

SCHEMAS = {"AP242": "AP242DIS", "AP214": "AP214IS"}  # Schemas on offer and the kernel's names for them.
_TIME_STAMP = "2000-01-01T00:00:00"  # the same input gives the same header
_ORIGIN = "delta-haptics"  # organisation and originating system
# Largest deviation of R R^T from the identity: rounding of a few products of unit matrices (1e-15 each), with room.
_RIGID_TOLERANCE = 1e-9

END = b"END-ISO-10303-21;"  # of every whole STEP file
BLOCK = 2**20  # bytes, more than any file system has left in the block that it gave last

_KG_M3_TO_STEP_DENSITY = 1e-3  # The kernel's writer states densities in g/cm^3.


class StepError(ValueError):
    """A STEP file cannot be written from what was given."""


def write_assembly_step(assembly: Assembly, path: Path, schema: str = "AP242", revision: str = FIRST_REVISION) -> str:
    """Writes the whole machine of a revision in its home position; the schema is "AP242" or "AP214".

    Returns:
        The content fingerprint of the file.

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
    _write(document, path, schema, assembly.name, revision)
    data, fingerprint = canonical(path.read_bytes())  # the kernel orders colours by where they lie in memory
    path.write_bytes(data)
    return fingerprint


def write_part_step(
    part: Part,
    path: Path,
    schema: str = "AP242",
    general: str = REQUIRED,
    held: Controlled | None = None,
    revision: str = FIRST_REVISION,
) -> None:
    """Writes one part at its own origin, with its number, colour and material; schemas as for the assembly.

    In AP242 a part that is made has its tolerances as data, see `pmi`: what is `held` closer, and the class `general`
    where nothing is stated.

    Raises:
        StepError: The schema is unknown, the part is not one solid, or the kernel refuses to write.
    """
    document, _ = _document()
    label, held = _define(document, part), held or Controlled()
    if schema == "AP242" and part.is_drawn:
        add_tolerances(document, label, part, held)
    _write(document, path, schema, part.number, revision, notes(part, held, general) if part.is_drawn else None)
    path.write_bytes(without_runouts(path.read_bytes()))


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
    document = TDocStd_Document(TCollection_ExtendedString("MDTV-XCAF"))
    XCAFApp_Application.GetApplication_s().InitDocument(document)
    XCAFDoc_DocumentTool.SetLengthUnit_s(document, 1e-3)
    return document, XCAFDoc_DocumentTool.ShapeTool_s(document.Main())


def _define(document: TDocStd_Document, part: Part) -> TDF_Label:
    """Adds the product definition of a part: one solid, number, colour, material and density."""
    main = document.Main()
    label = XCAFDoc_DocumentTool.ShapeTool_s(main).AddShape(_one_solid(part), False)
    _name(label, part.number)
    colour = Quantity_Color(*part.material.colour, Quantity_TOC_sRGB)
    XCAFDoc_DocumentTool.ColorTool_s(main).SetColor(label, colour, XCAFDoc_ColorGen)
    XCAFDoc_DocumentTool.MaterialTool_s(main).SetMaterial(
        label,
        step_text(part.material.name),
        step_text(part.material.name),
        part.material.density_kg_m3 * _KG_M3_TO_STEP_DENSITY,
        TCollection_HAsciiString("density measure"),
        TCollection_HAsciiString("POSITIVE_RATIO_MEASURE"),
    )
    return label


def _one_solid(part: Part) -> Any:
    """The part's solid with any location of its own baked in (a located shape would become an instance)."""
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
    rotation = frame[:3, :3]
    skew = float(np.abs(rotation @ rotation.T - np.eye(3)).max())
    if skew > _RIGID_TOLERANCE or np.linalg.det(rotation) < 0.0:
        raise StepError(f"placement of {name} is not a rotation: R R^T is off the identity by {skew:.3g}")
    return location_of(frame)


def _name(label: TDF_Label, name: str) -> None:
    """Names a definition or an occurrence."""
    TDataStd_Name.Set_s(label, TCollection_ExtendedString(name, True))


def _write(
    document: TDocStd_Document,
    path: Path,
    schema: str,
    title: str,
    revision: str,
    noted: Mapping[str, str] | None = None,
) -> None:
    """Transfers a document, adds the notes of a part, fills the header and writes the file."""
    if schema not in SCHEMAS:
        raise StepError(f"schema {schema!r} is not one of {', '.join(SCHEMAS)}")
    with _quiet_kernel(), _settings({"write.step.schema": SCHEMAS[schema], "write.step.unit": "MM"}):
        writer = STEPCAFControl_Writer()
        writer.SetDimTolMode(noted is not None)
        if not writer.Transfer(document, STEPControl_AsIs):
            raise StepError(f"{title}: the shapes could not be transferred to STEP")
        _mend_density_units(writer.ChangeWriter().Model(False))
        if schema == "AP242" and noted is not None:
            mend_tolerances(writer.ChangeWriter().Model(False))
            add_notes(writer.ChangeWriter().Model(False), noted)
        _state_revision(writer.ChangeWriter().Model(False), revision)
        _fill_header(writer.ChangeWriter().Model(False), title, revision)
        if writer.Write(str(path)) == IFSelect_RetDone and path.read_bytes().rstrip().endswith(END):
            return
        if path.exists():  # the kernel gives no reason; if it is a full disk, this does
            path.write_bytes(bytes(path.stat().st_size + BLOCK))
        raise StepError(f"{title}: {path} could not be written")


@contextmanager
def _settings(values: dict[str, str]) -> Iterator[None]:
    """Sets the kernel's global parameters for the time of one file.

    The controller must exist first: before that a parameter is accepted and ignored.
    """
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
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepBasic_DerivedUnitElement):
            entity.SetExponent(-3.0 if isinstance(entity.Unit(), StepBasic_SiUnitAndLengthUnit) else 1.0)


def _state_revision(model: Any, revision: str) -> None:
    """Gives every product its version."""
    for number in range(1, model.NbEntities() + 1):
        entity = model.Value(number)
        if isinstance(entity, StepBasic_ProductDefinitionFormation):
            entity.SetId(step_text(revision))


def _fill_header(model: Any, title: str, revision: str) -> None:
    """Header section: name, revision, time, organisation, system; no author, whom a design does not name."""
    header = APIHeaderSection_MakeHeader(model)
    header.SetName(TCollection_HAsciiString(title))
    header.SetDescriptionValue(1, TCollection_HAsciiString(f"{title}, revision {revision}"))
    header.SetTimeStamp(TCollection_HAsciiString(_TIME_STAMP))
    header.SetAuthorValue(1, TCollection_HAsciiString(""))
    header.SetOrganizationValue(1, TCollection_HAsciiString(_ORIGIN))
    header.SetOriginatingSystem(TCollection_HAsciiString(_ORIGIN))


@contextmanager
def _quiet_kernel() -> Iterator[None]:
    """Keeps the kernel's transfer statistics off the terminal."""
    messenger = Message.DefaultMessenger_s()
    printers = list(messenger.Printers())
    for printer in printers:
        messenger.RemovePrinter(printer)
    try:
        yield
    finally:
        for printer in printers:
            messenger.AddPrinter(printer)
