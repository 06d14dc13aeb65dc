"""The drawings of a machine, checked and written: in a build, part drawings come from a second process."""

from __future__ import annotations

import pickle
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import G_PER_KG
from delta_cad.design import design_hash
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.general import NOTES, PRINTED_MM, REQUIRED
from delta_cad.dimensions.tolerances.machine import general_class
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.drawings.assembly_sheet import assembly_drawing, balloon_faults, placed_items
from delta_cad.export.drawings.checker import drawing_faults, sheet_faults
from delta_cad.export.drawings.drive_sheet import drive_page
from delta_cad.export.drawings.layout import LayoutError, laid_out
from delta_cad.export.drawings.notes import named, notes_of, ordered_as
from delta_cad.export.drawings.part.controlled import Controlled, controlled
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.drawings.part.holes import HoleError
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.dxf import dxf_text
from delta_cad.export.drawings.sheet_io.lettering import missing, missing_note
from delta_cad.export.drawings.sheet_io.pdf import pdf_bytes
from delta_cad.export.drawings.sheet_io.sheet import Drawing
from delta_cad.export.drawings.sheet_io.svg import svg_text
from delta_cad.export.drawings.spring_sheet import spring_drawing
from delta_cad.export.drawings.title import UNDATED, Titles, grams
from delta_cad.export.drawings.views.choice import ViewError, views_of
from delta_cad.export.drawings.views.marks import RoomError
from delta_cad.solids.part import Part, boundary, location_of

FOLDER = "drawings"
LOADS = ("ezdxf", "fontTools.subset")
_UNDRAWN = (HoleError, ViewError, LayoutError, RoomError)
"""What keeps a single part from being drawn."""


@dataclass
class Drawn:
    """What came of the drawings.

    Attributes:
        count: How many there are.
        faults: What is wrong with them, by the part's number.
        missing: Letters that they show by a substitute, such as "U+1F600".
    """

    count: int = 0
    faults: dict[str, list[str]] = field(default_factory=dict)
    missing: set[str] = field(default_factory=set)

    def __add__(self, other: Drawn) -> Drawn:
        """Gives what came of both."""
        return Drawn(self.count + other.count, self.faults | other.faults, self.missing | other.missing)


def results(order: tuple[Dimensions, Assembly, Mapping[str, Any], Path]) -> Iterator[Drawn]:
    """Writes the drawings of a machine's parts into a folder, for `WorkerProcess`.

    Yields:
        What came of them.
    """
    d, assembly, masses, folder = order
    yield _write_part_drawings(d, assembly, masses, folder / FOLDER, lambda _: None)


def write_drawings(
    d: Dimensions,
    assembly: Assembly,
    masses: Mapping[str, Any],
    folder: Path,
    progress: Callable[[str], None] = lambda _: None,
) -> Drawn:
    """Draws every made part and the assembly and writes them: `<part>.pdf`, `.svg`, `.dxf` and `assembly.pdf`.

    Args:
        d: The machine's dimensions.
        assembly: The machine.
        masses: Its mass report.
        folder: Where to, made if it is not there.
        progress: Takes the name of what is being drawn.

    Returns:
        What came of them; a part that cannot be drawn has no files and a fault that says why.

    Raises:
        OSError: They cannot be written.
    """
    order = d, assembly, masses, folder, progress
    return _write_part_drawings(*order) + write_whole_drawing(*order)


def _write_part_drawings(
    d: Dimensions, assembly: Assembly, masses: Mapping[str, Any], folder: Path, progress: Callable[[str], None]
) -> Drawn:
    """Draws every made part; arguments and result as of `write_drawings`."""
    assembly = _handed_over(assembly)
    folder.mkdir(exist_ok=True)
    held, unit, drawn = controlled(d), _masses(masses), Drawn()
    count, general = Counter(one.part.number for one in assembly.occurrences), NOTES[general_class(d)]
    for part in assembly.parts:
        if part.is_drawn:
            progress(f"drawing {part.number}")
            mass = grams(unit[part.number] * G_PER_KG)
            titles = titles_of(d, part, count[part.number], mass, general)
            if part.to_drawing and (sheet := spring_drawing(d, part, titles)) is not None:
                drawn += _written(sheet, [f for one in sheet.sheets for f in sheet_faults(one)], folder)
            else:
                drawn += write_part_drawing(part, held.get(part.number, Controlled()), titles, folder)
    return drawn


def write_whole_drawing(
    d: Dimensions, assembly: Assembly, masses: Mapping[str, Any], folder: Path, progress: Callable[[str], None]
) -> Drawn:
    """Draws the assembly; arguments and result as of `write_drawings`."""
    assembly = _handed_over(assembly)
    folder.mkdir(exist_ok=True)
    rows = bill_of_materials(assembly, _masses(masses))
    section = drive_page(d, assembly)
    whole = assembly_drawing(assembly, rows, _whole_titles(d, assembly, masses), progress, [section])
    (folder / f"{whole.name}.pdf").write_bytes(pdf_bytes(whole))
    faults = balloon_faults(whole, placed_items(assembly, rows), rows)
    return _drawn(whole, faults + [fault for sheet in whole.sheets for fault in sheet_faults(sheet)])


def write_part_drawing(part: Part, held: Controlled, titles: Titles, folder: Path) -> Drawn:
    """Draws one part and writes its three files into a folder; what cannot be drawn is a fault that says why."""
    try:
        drawing, features = part_drawing(part, held, titles)
    except _UNDRAWN as error:
        return Drawn(faults={part.number: [str(error)]})
    return _written(drawing, drawing_faults(drawing, part, features), folder)


def _written(drawing: Drawing, faults: list[str], folder: Path) -> Drawn:
    """Writes the three files of a part's drawing."""
    (folder / f"{drawing.name}.pdf").write_bytes(pdf_bytes(drawing))
    (folder / f"{drawing.name}.svg").write_text(svg_text(drawing), encoding="utf-8")
    (folder / f"{drawing.name}.dxf").write_text(dxf_text(drawing), encoding="utf-8", newline="\n")
    return _drawn(drawing, faults)


class _Pickler(pickle.Pickler):
    """Pickles solids by their first boundary, so that results do not depend on which checks ran before."""

    def reducer_override(self, one: Any) -> Any:
        import cadquery as cq  # loads the CAD kernel

        return (_solid_of, (type(one), boundary(one))) if isinstance(one, cq.Shape) else NotImplemented


def _solid_of(kind: type[Any], content: bytes) -> Any:
    solid = object.__new__(kind)
    solid.__setstate__((BytesIO(content), False))
    return solid


def _handed_over(assembly: Assembly) -> Assembly:
    """The machine as another process gets it: last bits count."""
    stream = BytesIO()
    _Pickler(stream).dump(assembly)
    handed: Assembly = pickle.loads(stream.getvalue())
    return handed


def _masses(masses: Mapping[str, Any]) -> dict[str, float]:
    """Mass of one of each part by its number, kg."""
    return {number: body["mass_kg"] for number, body in masses["parts"].items()}


def _drawn(drawing: Drawing, faults: list[str]) -> Drawn:
    lacking = missing(text.text for sheet in drawing.sheets for text in sheet.texts)
    return Drawn(1, {drawing.name: faults} if faults else {}, set(lacking))


def part_drawing(part: Part, held: Controlled, titles: Titles) -> tuple[Drawing, Features]:
    """Draws one part.

    Returns:
        The drawing, and what it had to tell.

    Raises:
        HoleError: The declared bores are not in the solid.
        ViewError, LayoutError, RoomError: It cannot be drawn.
    """
    features = features_of(part, faces_of(part.solid), held)
    views = views_of(part, features, held.groove_mm)
    notes = notes_of(part, features, views[0].frame, held)
    if note := missing_note((*asdict(titles).values(), *(text for _, text in notes))):
        notes.append(("", f"{note}."))
    sheets = laid_out(views, features, held, titles, notes)
    sections = tuple(view.cut for view in views if view.cut is not None)
    return Drawing(part.number, f"{part.number}: {titles.description}", tuple(sheets), sections), features


def titles_of(d: Dimensions, part: Part, quantity: int, mass_g: str, tolerance: str = NOTES[REQUIRED]) -> Titles:
    """Gives the title block of a made part: how many a machine has, what one weighs, the general tolerances."""
    box = part.solid.BoundingBox(1e-4)
    printed = {"tolerance": f"printed {PRINTED_MM}", "surface": "as printed", "edges": "as printed, without strings"}
    return Titles(
        number=part.number,
        description=named(part.description)[0],
        material=ordered_as(part),
        quantity=str(quantity),
        mass=f"{mass_g} g",
        size=_size((box.xlen, box.ylen, box.zlen)),
        machine=_machine(d),
        revision=d.design.drawn_revision,
        date=_date(d),
        **(printed if part.material.process else {"tolerance": tolerance}),
    )


def _whole_titles(d: Dimensions, assembly: Assembly, masses: Mapping[str, Any]) -> Titles:
    import cadquery as cq

    poses = assembly.poses(assembly.home_mm)
    corners = []
    for one in assembly.occurrences:
        box = one.part.solid.moved(cq.Location(location_of(poses[one.name]))).BoundingBox(1e-3)
        corners += [(box.xmin, box.ymin, box.zmin), (box.xmax, box.ymax, box.zmax)]
    size = np.ptp(np.array(corners), axis=0)
    mass = f"{masses['total_mass_kg']:.3g} kg"
    text = f"Assembly of {assembly.name}, arms at equal angles"
    size_mm, kind = _size(size), "Assembly drawing"
    order = "assembly", text, "see the item list", "1", mass, size_mm, _machine(d), d.design.drawn_revision
    return Titles(*order, kind=kind, date=_date(d))


def _size(lengths: Iterable[float]) -> str:
    """Three lengths, mm, as a title block has them."""
    return " x ".join(f"{round(float(length), 2):g}" for length in lengths) + " mm"


def _machine(d: Dimensions) -> str:
    return f"{d.design.name}, design {design_hash(d.design)[:12]}"


def _date(d: Dimensions) -> str:
    """The date that a design's provenance has; the clock's would make every build another one."""
    date = d.design.provenance.get("date")
    return date if isinstance(date, str) else UNDATED
