"""A drawing as SVG in true size: one group per layer, text as text, fitted to its width with any font of the reader."""

from __future__ import annotations

from math import cos, radians, sin
from xml.sax.saxutils import escape

from delta_cad.common.refusal import printable
from delta_cad.export.drawings.sheet_io.lettering import FAMILIES, em_mm, face_rules, shown
from delta_cad.export.drawings.sheet_io.sheet import (
    LAYERS,
    Annotation,
    Arc,
    Area,
    Drawing,
    Primitive,
    Stroke,
    Text,
    in_a_row,
    primitives,
)


def svg_text(drawing: Drawing) -> str:
    """Gives the file's text; several sheets stand side by side."""
    sheet = in_a_row(drawing)
    width, height = f"{sheet.width:g}", f"{sheet.height:g}"
    out = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" '
        f'viewBox="0 0 {width} {height}">',
        f"<title>{escape(printable(drawing.title))}</title>",
        *([f"<style>{rules}</style>"] if (rules := face_rules(text.text for text in sheet.texts)) else ()),
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    plain = [item for item in sheet.items if not isinstance(item, Annotation) or item.measure]
    for layer in LAYERS:
        out += _layer(layer, list(primitives(plain)), sheet.height, f'id="{layer}"')
    for symbol in sheet.symbols:  # each a group of its own, with what it says
        out.append(f'<g class="symbol"><desc>{escape(symbol.name)}</desc>')
        for layer in LAYERS:
            if any(not isinstance(item, Text) and item.layer == layer for item in symbol.items):
                out += _layer(layer, list(symbol.items), sheet.height)
        out.append("</g>")
    out.append(f'<g id="lettering" font-family="{FAMILIES}" fill="black">')
    for text in sheet.texts:
        x, y = text.at[0], sheet.height - text.at[1]
        turn = f' transform="rotate(-90 {x:.3f} {y:.3f})"' if text.upright else ""
        out.append(
            f'<text x="{x:.3f}" y="{y:.3f}" font-size="{em_mm(text.height):.3f}" textLength="{text.length:.3f}" '
            f'lengthAdjust="spacingAndGlyphs"{turn}>{escape(shown(text.text))}</text>'
        )
    return "\n".join([*out, "</g>", "</svg>"]) + "\n"


def _layer(layer: str, items: list[Primitive], height: float, name: str = "") -> list[str]:
    """What lies on a layer, in a group with its pen."""
    pen = LAYERS[layer]
    dashes = f' stroke-dasharray="{" ".join(f"{dash:g}" for dash in pen.dashes)}"' if pen.dashes else ""
    head = (
        f'<g {name} fill="none" stroke="black" stroke-width="{pen.width_mm:g}" stroke-linecap="round" '
        f'stroke-linejoin="round"{dashes}>'
    ).replace("  ", " ")
    drawn = [_drawn(item, height) for item in items if not isinstance(item, Text) and item.layer == layer]
    return [head, *drawn, "</g>"]


def _drawn(item: Stroke | Arc | Area, height: float) -> str:
    if isinstance(item, Arc):
        (x, y), r = item.centre, item.radius
        if item.whole:
            return f'<circle cx="{x:.3f}" cy="{height - y:.3f}" r="{r:.3f}"/>'
        (ax, ay), (bx, by) = (
            (x + r * cos(radians(angle)), height - y - r * sin(radians(angle))) for angle in (item.start, item.end)
        )
        large = int(item.end - item.start > 180.0)
        return f'<path d="M{ax:.3f} {ay:.3f}A{r:.3f} {r:.3f} 0 {large} 0 {bx:.3f} {by:.3f}"/>'
    points = " ".join(f"{x:.3f},{height - y:.3f}" for x, y in item.points)
    if isinstance(item, Area):
        return f'<polygon points="{points}" fill="black" stroke="none"/>'
    return f'<{"polygon" if item.closed else "polyline"} points="{points}"/>'
