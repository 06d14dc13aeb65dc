"""Template of the dashboard's opening and holes in true size: DXF for cutting, SVG for printing on paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import pi, tan
from pathlib import Path
from typing import Any

from delta_cad import catalogue
from delta_cad.dimensions.panel import SCREW, TEMPLATE, PanelDimensions
from delta_cad.export.drawings.sheet_io.dxf import r2010_text

_BULGE = tan(pi / 8.0)  # of a quarter of a circle: the tangent of a fourth of its angle
_MARGIN_MM = 10.0
_BAR_MM = 50.0  # printed beside it: who lays a rule on it sees whether the printer scaled
_FONT = 'font-size="3.5" text-anchor="middle" font-family="sans-serif"'
_LAYERS = {
    "CUT": 1,
    "DRILL": 5,
    "BEZEL": 8,
    "ARM": 3,
}  # with their colours; the latter two are for the eye
_ARM_WORDS = "an arm of the machine points this way"  # chain 0 along +x: the square itself looks alike four ways round
_ARROW_MM, _HEAD_MM = 8.0, 2.0
_LETTER_MM = 2.5


def write_template(p: PanelDimensions, folder: Path) -> None:
    """Writes both files of a panel into a folder."""
    (folder / f"{TEMPLATE}.dxf").write_text(template_dxf(p), encoding="utf-8", newline="\n")
    (folder / f"{TEMPLATE}.svg").write_text(template_svg(p), encoding="utf-8")


def add_layers(document: Any, layers: Mapping[str, int]) -> None:
    """Adds layers with their colours to a document of `r2010_text`."""
    for name, colour in layers.items():
        document.layers.add(name, color=colour)


def add_loop(
    space: Any, vertices: Sequence[tuple[float, float, float]], circle: tuple[float, float, float] | None, layer: str
) -> None:
    """Adds a closed line to be cut: a circle, its centre and radius, or else (x, y, bulge) where each piece begins."""
    if circle is not None:
        space.add_circle(circle[:2], circle[2], dxfattribs={"layer": layer})
    else:
        space.add_lwpolyline(vertices, format="xyb", close=True, dxfattribs={"layer": layer})


def _corners(half_mm: float, corner_mm: float) -> list[tuple[float, float, float]]:
    """Gives a square with round corners as a closed polyline, counter-clockwise: (x, y, bulge) where each piece begins.

    Args:
        half_mm: Of the square that the corners' centres span.
        corner_mm: Their radius.
    """
    far = half_mm + corner_mm
    points = [(half_mm, -far), (far, -half_mm), (far, half_mm), (half_mm, far)]
    points += [(-x, -y) for x, y in points]
    return [(x, y, _BULGE if k % 2 == 0 else 0.0) for k, (x, y) in enumerate(points)]


def _axis_words(p: PanelDimensions) -> str:
    return f"axis of the machine's base, {abs(p.centre_x_mm):g} mm from the opening's middle"


def template_dxf(p: PanelDimensions) -> str:
    """Gives the text of the DXF R2010, the same each time: the opening closed on CUT, the holes on DRILL."""

    def draw(document: Any) -> None:
        add_layers(document, _LAYERS)
        space = document.modelspace()
        for layer, corner in (("CUT", p.opening_mm), ("BEZEL", p.rim_mm)):
            add_loop(space, _corners(p.half_mm, corner), None, layer)
        tip = p.half_mm + p.rim_mm + _ARROW_MM
        head = [(tip - _HEAD_MM, _HEAD_MM / 2), (tip, 0.0), (tip - _HEAD_MM, -_HEAD_MM / 2)]
        space.add_lwpolyline([(tip - _ARROW_MM, 0.0), (tip, 0.0)], dxfattribs={"layer": "ARM"})
        space.add_lwpolyline(head, dxfattribs={"layer": "ARM"})
        words = space.add_text(f"seen from above: {_ARM_WORDS}", height=_LETTER_MM, dxfattribs={"layer": "ARM"})
        words.set_placement((tip + _HEAD_MM, -_LETTER_MM / 2))
        radius = catalogue.screw(SCREW).clearance_hole_mm / 2
        for at in p.screw_places():
            add_loop(space, (), (*at, radius), "DRILL")
        if p.centre_x_mm:  # both strokes of the cross on the base's axis
            for x, y in ((_HEAD_MM, 0.0), (0.0, _HEAD_MM)):
                ends = [(-p.centre_x_mm - x, -y), (-p.centre_x_mm + x, y)]
                space.add_lwpolyline(ends, dxfattribs={"layer": "ARM"})
            named = space.add_text(_axis_words(p), height=_LETTER_MM, dxfattribs={"layer": "ARM"})
            named.set_placement((-p.centre_x_mm - _HEAD_MM, -3 * _LETTER_MM))

    return r2010_text(draw)


def template_svg(p: PanelDimensions) -> str:
    """Gives the text of the SVG, in millimetres, seen from above: opening, bezel's rim, holes, a bar to measure."""
    far = p.half_mm + p.rim_mm + _MARGIN_MM
    below = far + (3.5 if p.centre_x_mm else 3.0) * _MARGIN_MM
    size = f'width="{2 * far:g}mm" height="{far + below:g}mm" viewBox="{-far:g} {-far:g} {2 * far:g} {far + below:g}"'
    radius, half = catalogue.screw(SCREW).clearance_hole_mm / 2, _BAR_MM / 2
    drawn = [f'<path d="{_path(p, p.opening_mm)}"/>', f'<path d="{_path(p, p.rim_mm)}" stroke-dasharray="3 2"/>']
    for x, y in p.screw_places():
        drawn.append(f'<circle cx="{x:g}" cy="{-y:g}" r="{radius:g}"/>')
        drawn.append(f'<path d="M{x - 3:g} {-y:g}h6M{x:g} {-y - 3:g}v6"/>')
    drawn.append('<path d="M-4 0h8M0 -4v8"/>')
    if p.centre_x_mm:
        x, across = -p.centre_x_mm - _HEAD_MM, 2 * _HEAD_MM
        slanted = f"M{x:g} {-_HEAD_MM:g}l{across:g} {across:g}m0 {-across:g}l{-across:g} {across:g}"
        drawn.append(f'<path d="{slanted}"/>')
    drawn.append(
        f'<path d="M{far - _MARGIN_MM:g} 0h{_ARROW_MM:g}m{-_HEAD_MM:g} {-_HEAD_MM / 2:g}l{_HEAD_MM:g} {_HEAD_MM / 2:g}'
        f'l{-_HEAD_MM:g} {_HEAD_MM / 2:g}"/>'
    )
    bar, side = far + _MARGIN_MM / 2, 2 * (p.half_mm + p.opening_mm)
    drawn.append(f'<path d="M{-half:g} {bar - 2:g}v4M{-half:g} {bar:g}h{_BAR_MM:g}M{half:g} {bar - 2:g}v4"/>')
    words = (
        f"{_BAR_MM:g} mm if printed in true size",
        "seen from above; the arrow:",
        _ARM_WORDS,
        f"opening {side:g} x {side:g}, corners R{p.opening_mm:g}; {len(p.screw_places())} holes {2 * radius:g}; mm",
        *([f"slanted cross: {_axis_words(p)}"] if p.centre_x_mm else []),
    )
    texts = "".join(f'<text x="0" y="{bar + 6 + 5 * k:g}" {_FONT}>{line}</text>' for k, line in enumerate(words))
    lines = "".join(drawn)
    body = f'<g fill="none" stroke="black" stroke-width="0.2">{lines}</g>{texts}'
    return f'<svg xmlns="http://www.w3.org/2000/svg" {size}>{body}</svg>\n'


def _path(p: PanelDimensions, corner_mm: float) -> str:
    """The same outline as a path of SVG, whose y points down."""
    points = _corners(p.half_mm, corner_mm)
    path = f"M{points[0][0]:g} {-points[0][1]:g}"
    for (_, _, bulge), (x, y, _) in zip(points, [*points[1:], points[0]], strict=True):
        arc = f"A{corner_mm:g} {corner_mm:g} 0 0 0 " if bulge else "L"
        path += f"{arc}{x:g} {-y:g}"
    return f"{path}Z"
