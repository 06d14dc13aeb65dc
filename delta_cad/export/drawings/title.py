"""Frame, title block, notes and tables of a sheet, after ISO 5457 and ISO 7200; sizes after ISO 8015."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from importlib import metadata

from delta_cad.dimensions.tolerances.general import EDGES, NOTES, REQUIRED
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.lettering import LINE, fitted, width_of, wrapped
from delta_cad.export.drawings.sheet_io.sheet import Arc, Box, Item, Sheet, Stroke, Text
from delta_cad.export.drawings.views.block import Block
from delta_cad.export.drawings.views.lines import boxed, lines_of_group, set_line
from delta_cad.export.drawings.views.marks import LETTER_MM, number

_SHEETS = {"A4": (297.0, 210.0), "A3": (420.0, 297.0)}
_LEFT_MM, _EDGE_MM = 20.0, 10.0  # margins: for filing, and on the other sides
TITLE_MM = (180.0, 48.0)
_LABEL_MM, _SMALL_MM = 1.6, 2.0
_SURFACE = "Ra 3.2 where none is stated"
_SIZES = "ISO 8015"
CREATOR = f"delta-haptics, delta_cad {metadata.version('delta-haptics')}"
UNDATED = "none, see design"
"""Date of a drawing whose design has none: no file of a build has the time at which it was made."""
FIELDS = (
    "Part number",
    "Description",
    "Document type",
    "Material",
    "Tolerances",
    "Sheet",
    "Revision",
    "Created by",
    "Date",
)
"""Labels of what every title block has a text under, ISO 7200, and of what a shop asks there."""
SIGNED = "Approved by"
"""Label of the one field that is left empty: a person signs in it."""


@dataclass(frozen=True)
class Titles:
    """What the title block says: texts as printed; `sheet` and `scale` come from the layout."""

    number: str
    description: str
    material: str
    quantity: str
    mass: str
    size: str
    machine: str
    revision: str
    surface: str = _SURFACE
    tolerance: str = NOTES[REQUIRED]
    edges: str = EDGES
    kind: str = "Part drawing"
    created: str = CREATOR
    date: str = UNDATED


def grams(mass_g: float) -> str:
    """Writes a mass in grams with three figures, none of them as a power of ten; "-" for what has none of its own."""
    return f"{float(f'{mass_g:.3g}'):g}" if mass_g > 0.0 else "-"


def inner(size: str) -> Box:
    """Gives the box inside of a sheet's frame, mm."""
    width, height = _SHEETS[size]
    return _LEFT_MM, _EDGE_MM, width - _EDGE_MM, height - _EDGE_MM


def title_box(size: str) -> Box:
    """Gives the box of the title block, in the frame's lower right corner, mm."""
    _, low, right, _ = inner(size)
    return right - TITLE_MM[0], low, right, low + TITLE_MM[1]


def framed(size: str, scale: str, page: str, titles: Titles) -> Sheet:
    """Makes an empty sheet, "A4" or "A3", with frame and title block; scale such as "2:1", page such as "1 / 2"."""
    width, height = _SHEETS[size]
    box = inner(size)
    sheet = Sheet(width, height, [_rectangle("frame", box)])
    for mark in ((width / 2, 5.0, width / 2, box[1]), (width / 2, height - 5.0, width / 2, box[3])):
        sheet.items.append(Stroke("frame", ((mark[0], mark[1]), (mark[2], mark[3]))))
    sheet.add(_title_block(title_box(size), size, scale, page, titles))
    sheet.frames["title block"] = title_box(size)
    return sheet


def _rectangle(layer: str, box: Box) -> Stroke:
    x0, y0, x1, y1 = box
    return Stroke(layer, ((x0, y0), (x1, y0), (x1, y1), (x0, y1)), closed=True)


def _title_block(box: Box, size: str, scale: str, page: str, t: Titles) -> list[Item]:
    rows: list[tuple[float, list[tuple[float, str, str]]]] = [
        (
            14.0,
            [(45.0, "Part number", t.number), (105.0, "Description", t.description), (30.0, "Document type", t.kind)],
        ),
        (
            9.0,
            [
                (85.0, "Material", t.material),
                (35.0, "Quantity per machine", t.quantity),
                (60.0, "Overall size", t.size),
            ],
        ),
        (
            9.0,
            [(55.0, "Tolerances", f"{_SIZES}, {t.tolerance}"), (55.0, "Surface", t.surface), (70.0, "Edges", t.edges)],
        ),
        (
            8.0,
            [
                (30.0, "Scale", scale),
                (20.0, "Size", size),
                (20.0, "Sheet", page),
                (30.0, "Mass", t.mass),
                (25.0, "Dimensions", "mm"),
                (25.0, "Revision", t.revision),
                (30.0, "First angle", ""),
            ],
        ),
        (
            8.0,
            [
                (72.0, "Machine", t.machine),
                (48.0, "Created by", t.created),
                (30.0, "Date", t.date),
                (30.0, SIGNED, ""),
            ],
        ),
    ]
    items: list[Item] = [_rectangle("frame", box)]
    top = box[3]
    for height, cells in rows:
        left = box[0]
        for width, label, value in cells:
            items.append(_rectangle("table", (left, top - height, left + width, top)))
            items.append(Text((left + 1.0, top - _LABEL_MM - 0.8), _LABEL_MM, label))
            items += _fitted(value, left + 1.0, top - _LABEL_MM - 1.6, width - 2.0, height - _LABEL_MM - 2.2)
            left += width
        top -= height
    items += _projection_symbol(box[2] - 15.0, box[1] + 8.0 + 3.2)
    return items


def _fitted(value: str, left: float, top: float, width: float, height: float) -> list[Item]:
    """A text in a cell: as large as it fits, in lines."""
    for letter in (3.5, LETTER_MM, _SMALL_MM, 1.8, 1.6, 1.4):
        lines = wrapped(value, letter, width)
        pitch = letter * (LINE if len(lines) > 1 else 1.0) * 0.94
        if pitch * len(lines) <= height and all(width_of(line, letter) <= width for line in lines):
            break
    else:
        lines = fitted(value, letter, width, max(int(height / pitch), 1))
    return [Text((left, top - letter - n * pitch), letter, line) for n, line in enumerate(lines) if line]


def _projection_symbol(x: float, y: float) -> list[Item]:
    """The truncated cone of first angle projection, ISO 5456-2."""
    return [
        Stroke("table", ((x - 6.0, y - 1.0), (x - 6.0, y + 1.0), (x, y + 2.0), (x, y - 2.0)), closed=True),
        Arc("table", (x + 5.0, y), 2.0),
        Arc("table", (x + 5.0, y), 1.0),
        Stroke("centre", ((x - 7.5, y), (x + 8.0, y))),
        Stroke("centre", ((x + 5.0, y - 2.8), (x + 5.0, y + 2.8))),
    ]


def notes_items(notes: Sequence[tuple[str, str]], width: float) -> list[Item]:
    """Sets notes one below another from (0, 0) down: key that each tells, and text."""
    items: list[Item] = [Text((0.0, -LETTER_MM), LETTER_MM, "Notes")]
    y = -LETTER_MM * LINE
    for n, (key, text) in enumerate(notes, 1):
        for k, line in enumerate(wrapped(text, _SMALL_MM, width - 5.0)):
            y -= _SMALL_MM * LINE
            if k == 0:
                items.append(Text((0.0, y), _SMALL_MM, f"{n}"))
            items.append(Text((5.0, y), _SMALL_MM, line, states=(key,) if k == 0 and key else ()))
    return items


def hole_table(blocks: Sequence[Block], features: Features) -> list[Item]:
    """Sets a table of tagged holes from (0, 0) down: tag, coordinates, callout of the group beside its first rows."""
    columns = (10.0, 19.0, 19.0, 78.0)
    pitch = 4.4
    edges = [0.0]
    for column in columns:
        edges.append(edges[-1] + column)
    items: list[Item] = []
    y = 0.0

    def cell(column: int, text: str, reported: tuple[str, ...] = (), exact: bool = False) -> None:
        letters = Text((edges[column] + 1.0, y - pitch + 1.1), LETTER_MM, text, states=reported)
        items.extend([letters, boxed(letters)] if exact else [letters])

    for k, name in enumerate(("Hole", "X right", "Y up", "Each")):
        cell(k, name)
    y -= pitch
    lines = [y]
    for block in blocks:
        for group, tagged in block.tables:
            said = lines_of_group(group, features, columns[3] - 2.0)
            for n in range(max(len(said), len(tagged))):
                if n < len(tagged):
                    one = tagged[n]
                    cell(0, one.tag, one.states)
                    for k in (0, 1):
                        cell(k + 1, number(one.at[k]), one.reported[k], one.exact[k])
                if n < len(said):
                    items += set_line(said[n], (edges[3] + 1.0, y - pitch + 1.1))
                y -= pitch
            lines.append(y)
    items += [Stroke("table", ((0.0, line), (edges[-1], line))) for line in (0.0, *lines)]
    items += [Stroke("table", ((edge, 0.0), (edge, y))) for edge in edges]
    return items
