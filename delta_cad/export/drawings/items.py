"""The item list of the assembly drawing: the bill of materials, a row a line, in the order of its balloons."""

from __future__ import annotations

from collections.abc import Sequence

from delta_cad.export.bom import BomRow
from delta_cad.export.drawings.part.holes import lettered
from delta_cad.export.drawings.sheet_io.lettering import LINE, fitted, missing_note
from delta_cad.export.drawings.sheet_io.sheet import Box, Item, Stroke, Text
from delta_cad.export.drawings.title import grams, inner, title_box

_SIZE = "A3"
COLUMNS: tuple[tuple[str, float], ...] = (
    ("Item", 11.0),
    ("Qty", 10.0),
    ("Part number", 44.0),
    ("Description", 158.0),
    ("Material, or standard and order code", 106.0),
    ("Mass g", 16.0),
    ("Made", 14.0),
)
_TEXT_MM = 2.0
_ROW_MM = _TEXT_MM * LINE
_MOST_LINES = 8  # of a cell
_PADDING_MM = 0.9  # of a row, besides its lines: some fifty items fit on a sheet


def item_lists(rows: Sequence[BomRow]) -> list[tuple[str, list[Item], dict[str, Box]]]:
    """Sets the item list on as many sheets as it needs: scale, items and frames of each."""
    area, title = inner(_SIZE), title_box(_SIZE)
    left, top, bottom = area[0] + 8.0, area[3] - 4.0, title[3] + 2.0
    edges = [left]
    for _, width in COLUMNS:
        edges.append(edges[-1] + width)
    pages: list[tuple[str, list[Item], dict[str, Box]]] = []
    items: list[Item] = []
    y = top

    def close() -> None:
        items.extend(Stroke("table", ((edge, top), (edge, y))) for edge in edges)
        pages.append(("-", list(items), {"item list": (left, y, edges[-1], top)}))
        items.clear()

    for row in (None, *rows):
        cells = _cells(row)
        lines = max(len(cell) for cell in cells)
        if y - lines * _ROW_MM - _PADDING_MM < bottom:
            close()
            y = top
        if y == top:
            items.append(Stroke("table", ((left, y), (edges[-1], y))))
        for k, cell in enumerate(cells):
            reported = (f"row {row.item}",) if row is not None and k == 0 else ()
            for n, line in enumerate(cell):
                at = edges[k] + 1.0, y - _PADDING_MM / 2.0 - n * _ROW_MM - 2.0 * 1.2
                items.append(Text(at, 2.0, line, states=reported))
        y -= lines * _ROW_MM + _PADDING_MM
        items.append(Stroke("table", ((left, y), (edges[-1], y))))
    if note := missing_note(line for row in rows for cell in _cells(row) for line in cell):
        if y - _ROW_MM - _PADDING_MM < bottom:
            close()
            y = top
        items.append(Text((left, y - _PADDING_MM - _TEXT_MM), _TEXT_MM, f"{note}."))
    close()
    return pages


def _cells(row: BomRow | None) -> list[list[str]]:
    """The lines of each cell of a row; of the head for None."""
    if row is None:
        return [[name] for name, _ in COLUMNS]
    bought = row.make_or_buy == "buy"
    codes = [row.order_code] if row.standard in row.order_code else [row.standard, row.order_code]
    what = ", ".join(filter(None, codes)) if bought else row.material
    texts = [str(row.item), str(row.quantity), row.part_number, row.description, what or row.material]
    texts += [grams(row.unit_mass_g), row.make_or_buy]
    return [fitted(lettered(text), _TEXT_MM, COLUMNS[k][1] - 2.0, _MOST_LINES) for k, text in enumerate(texts)]
