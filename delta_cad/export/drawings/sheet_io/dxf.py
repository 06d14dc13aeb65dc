"""A drawing as DXF R2010 in true size, mm: one DXF layer per layer, arcs as arcs, texts fitted to their widths.

A dimension is a DIMENSION: what it measures, between which points, and as its block the lines and texts of the sheet,
so that it looks the same wherever it is opened. Its style has the view's scale, by which a reader measures it again.
Signs are written by their codes in DXF, not as letters: readers do not agree on the encoding of a file.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from io import StringIO
from math import atan2, degrees, hypot
from typing import Any

from delta_cad.export.drawings.sheet_io.lettering import NARROW, shown
from delta_cad.export.drawings.sheet_io.sheet import (
    LAYERS,
    Annotation,
    Arc,
    Area,
    Drawing,
    Measure,
    Point,
    Primitive,
    Sheet,
    Stroke,
    Text,
    in_a_row,
    mapped_primitive,
    primitives,
)

_NOT_ASCII = re.compile(r"[^\x00-\x7f]")
CODE = re.compile(r"%(?=%)|\\(?=[UuMm]\+)|\^")  # a space after which makes it a sign again
_SIGNS = {"Ø": "%%c", "±": "%%p", "°": "%%d"}  # any other letter by its number
_MILLIMETRES = 4  # $INSUNITS
_STYLE = "LETTERING"
_DECIMALS = 6
_OWN_BLOCK = 32  # beside the kind: nobody else refers to its block
_KINDS = {
    "right": (6 | 64 | _OWN_BLOCK, ("defpoint", "defpoint2", "defpoint3")),
    "up": (6 | _OWN_BLOCK, ("defpoint", "defpoint2", "defpoint3")),
    "diameter": (3 | _OWN_BLOCK, ("defpoint", "defpoint4")),
    "radius": (4 | _OWN_BLOCK, ("defpoint", "defpoint4")),
    "length": (0 | _OWN_BLOCK, ("defpoint2", "defpoint3")),
}
"""What is measured -> type of a DIMENSION, and which of its points those of a measure are."""
_FACE_FILE = "DejaVuSans.ttf"


def r2010_text(draw: Callable[[Any], None]) -> str:
    """Gives the text of a DXF R2010 in millimetres, the same each time."""
    import ezdxf
    from ezdxf.filemanagement import new

    options: Any = ezdxf.options  # pyright: ignore[reportPrivateImportUsage]  # by its documented name
    fixed = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True  # without times and random numbers
    try:
        document: Any = new("R2010", units=_MILLIMETRES)
        draw(document)
        for kind in sorted({entity.dxftype() for entity in document.entitydb.values()}):
            document.classes.add_class(kind)  # in the order of a set else, which is another in each process
        out = StringIO()
        document.write(out)
    finally:
        options.write_fixed_meta_data_for_testing = fixed
    return out.getvalue()


def dxf_text(drawing: Drawing) -> str:
    """Gives the file's text, the same each time; several sheets stand side by side."""
    sheet = in_a_row(drawing)

    def draw(document: Any) -> None:
        _set_up(document, sheet)
        space = document.modelspace()
        for item in sheet.items:
            if isinstance(item, Annotation) and item.measure is not None:
                _dimension(document, item, item.measure)
            else:
                for leaf in primitives((item,)):
                    _draw(space, _rounded(leaf))

    text = r2010_text(draw)
    return _NOT_ASCII.sub(lambda match: _SIGNS.get(match[0], f"\\U+{ord(match[0]):04X}"), text)


def _set_up(document: Any, sheet: Sheet) -> None:
    document.styles.add(_STYLE, font=_FACE_FILE).dxf.width = NARROW
    for name, pen in LAYERS.items():
        kind = "CONTINUOUS"
        if pen.dashes:
            kind = name.upper()
            lengths = [dash if k % 2 == 0 else -dash for k, dash in enumerate(pen.dashes)]
            document.linetypes.add(kind, [sum(pen.dashes), *lengths], description=name)
        document.layers.add(name, linetype=kind, lineweight=round(100 * pen.width_mm))
    document.header["$LIMMAX"] = (sheet.width, sheet.height)
    document.header["$EXTMAX"] = (sheet.width, sheet.height, 0.0)
    document.header["$EXTMIN"] = (0.0, 0.0, 0.0)


def _rounded(item: Primitive) -> Primitive:
    """The same to a millionth of a millimetre: what lies below depends on how a solid came here."""
    item = mapped_primitive(item, _near)
    if isinstance(item, Arc):
        radius, start, end = (round(value, _DECIMALS) for value in (item.radius, item.start, item.end))
        return replace(item, radius=radius, start=start, end=end)
    return item


def _near(point: Point) -> Point:
    return round(point[0], _DECIMALS) + 0.0, round(point[1], _DECIMALS) + 0.0


def _dimension(document: Any, mark: Annotation, measure: Measure) -> None:
    """A DIMENSION with its own block."""
    kind, where = _KINDS[measure.kind]
    points = {name: (*_near(point), 0.0) for name, point in zip(where, measure.points, strict=True)}
    first, last = measure.points[0], measure.points[1]
    if measure.kind in ("right", "up"):
        length = abs(last[measure.kind == "up"] - first[measure.kind == "up"])
    else:
        length = hypot(last[0] - first[0], last[1] - first[1])
    factor = round(measure.value_mm / length, _DECIMALS) if length > 1e-9 else 1.0
    style = f"SCALE_{factor:g}".replace(".", "_")
    if style not in document.dimstyles:
        document.dimstyles.new(style, dxfattribs={"dimlfac": factor, "dimtxsty": _STYLE})
    block = document.blocks.new_anonymous_block(type_char="D")
    for item in mark.items:
        _draw(block, _rounded(item))
    text = next(item for item in mark.items if isinstance(item, Text))
    middle = (text.box[0] + text.box[2]) / 2, (text.box[1] + text.box[3]) / 2
    if measure.kind == "length":  # its line runs through the text's side, its ends square to what is measured
        points["defpoint"] = points["defpoint3"]
    look = {
        "layer": "dimension",
        "dimstyle": style,
        "geometry": block.name,
        "dimtype": kind,
        "text_midpoint": (*_near(middle), 0.0),
        "text": measure.text,
        "actual_measurement": round(measure.value_mm, _DECIMALS),
        "angle": round(degrees(atan2(last[1] - first[1], last[0] - first[0])), _DECIMALS),
        **points,
    }
    if measure.kind != "length":
        del look["angle"]
    document.modelspace().new_entity("DIMENSION", look)


def _coded(text: str) -> str:
    """A text with what DXF reads as a code broken up; a caret is one where a space follows it."""
    return CODE.sub(r"\g<0> ", shown(text)).replace("^", "^ ")


def _draw(space: Any, item: Stroke | Arc | Area | Text) -> None:
    from ezdxf.enums import TextEntityAlignment

    if isinstance(item, Text):
        look = {"layer": "text", "style": _STYLE}
        text = space.add_text(
            _coded(item.text), height=item.height, rotation=90.0 if item.upright else 0.0, dxfattribs=look
        )
        text.set_placement(item.at, _near(item.end), align=TextEntityAlignment.FIT)
        return
    look = {"layer": item.layer}
    if isinstance(item, Arc):
        if item.whole:
            space.add_circle(item.centre, item.radius, dxfattribs=look)
        else:
            space.add_arc(item.centre, item.radius, item.start, item.end, dxfattribs=look)
    elif isinstance(item, Area):
        corners = [*item.points, item.points[-1]][:4]
        space.add_solid([corners[0], corners[1], corners[3], corners[2]], dxfattribs=look)
    elif len(item.points) == 2 and not item.closed:
        space.add_line(*item.points, dxfattribs=look)
    else:
        space.add_lwpolyline(item.points, close=item.closed, dxfattribs=look)
