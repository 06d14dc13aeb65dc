"""A drawing as DXF R2010 in its true size, millimetres: a layer a layer, arcs as arcs, texts kept to their widths."""

from __future__ import annotations

from dataclasses import replace
from io import StringIO
from typing import Any

from delta_cad.export.drawings.paper.lettering import NARROW
from delta_cad.export.drawings.paper.sheet import LAYERS, Arc, Area, Drawing, Item, Point, Sheet, Stroke, Text, in_a_row

MILLIMETRES = 4  # $INSUNITS
STYLE = "LETTERING"
DECIMALS = 6
FACE_FILE = "DejaVuSans.ttf"


def dxf_text(drawing: Drawing) -> str:
    """Gives the file's text, the same each time; several sheets stand side by side."""
    sheet = in_a_row(drawing)
    import ezdxf
    from ezdxf.filemanagement import new

    options: Any = ezdxf.options  # pyright: ignore[reportPrivateImportUsage]  # by its documented name
    fixed = options.write_fixed_meta_data_for_testing
    options.write_fixed_meta_data_for_testing = True  # without times and random numbers
    try:
        document: Any = new("R2010", units=MILLIMETRES)
        _set_up(document, sheet)
        space = document.modelspace()
        for item in sheet.items:
            _draw(space, _rounded(item))
        for kind in sorted({entity.dxftype() for entity in document.entitydb.values()}):
            document.classes.add_class(kind)  # in the order of a set else, which is another in each process
        out = StringIO()
        document.write(out)
    finally:
        options.write_fixed_meta_data_for_testing = fixed
    return out.getvalue()


def _set_up(document: Any, sheet: Sheet) -> None:
    document.styles.add(STYLE, font=FACE_FILE).dxf.width = NARROW
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


def _rounded(item: Item) -> Item:
    """The same to a millionth of a millimetre: what lies below depends on how a solid came here."""
    if isinstance(item, Text):
        return replace(item, at=_near(item.at))
    if isinstance(item, Arc):
        centre, radius = _near(item.centre), round(item.radius, DECIMALS)
        return replace(
            item, centre=centre, radius=radius, start=round(item.start, DECIMALS), end=round(item.end, DECIMALS)
        )
    return replace(item, points=tuple(_near(point) for point in item.points))


def _near(point: Point) -> Point:
    return round(point[0], DECIMALS) + 0.0, round(point[1], DECIMALS) + 0.0


def _draw(space: Any, item: Stroke | Arc | Area | Text) -> None:
    from ezdxf.enums import TextEntityAlignment

    if isinstance(item, Text):
        look = {"layer": "text", "style": STYLE}
        text = space.add_text(item.text, height=item.height, rotation=90.0 if item.upright else 0.0, dxfattribs=look)
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
