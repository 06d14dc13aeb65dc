"""Template of a panel: both files read back by readers of our own, against the panel's dimensions and its solid."""

from __future__ import annotations

import re
from dataclasses import replace
from math import atan, hypot, pi, sin
from xml.etree import ElementTree

import numpy as np
import pytest

from delta_cad.dimensions.panel import PanelDimensions
from delta_cad.export.shop.template import template_dxf, template_svg
from delta_cad.mechanism.placement import chain_turn
from tests.delta_cad.dimensions.paneled import of_panel
from tests.delta_cad.export.drawings.reading import Entity, entities


def panel() -> PanelDimensions:
    p = of_panel().panel
    assert p is not None
    return p


def values(entity: Entity, code: int) -> list[float]:
    return [float(value) for one, value in entity if one == code]


def enclosed(entity: Entity) -> tuple[float, float]:
    """Area and length of a closed polyline whose pieces bulge."""
    x, y = values(entity, 10), values(entity, 20)
    bulges: list[float] = []
    for code, value in entity:
        if code == 10:
            bulges.append(0.0)
        elif code == 42:
            bulges[-1] = float(value)
    area = length = 0.0
    for k, bulge in enumerate(bulges):
        n = (k + 1) % len(x)
        area += (x[k] * y[n] - x[n] * y[k]) / 2
        chord, angle = hypot(x[n] - x[k], y[n] - y[k]), 4 * atan(bulge)
        if bulge:
            radius = chord / 2 / sin(angle / 2)
            area += radius**2 / 2 * (angle - sin(angle))
            length += radius * angle
        else:
            length += chord
    return area, length


def test_the_dxf_has_opening_and_holes_in_true_size() -> None:
    p = panel()
    read = entities(template_dxf(p))
    of = {(entity[0][1], dict(entity)[8]): entity for entity in read}
    opening = of["LWPOLYLINE", "CUT"]
    assert int(dict(opening)[70]) & 1  # closed
    area, length = enclosed(opening)
    assert area == pytest.approx(p.area_mm2(p.opening_mm))
    assert length == pytest.approx(8 * p.half_mm + 2 * pi * p.opening_mm)
    assert enclosed(of["LWPOLYLINE", "BEZEL"])[0] == pytest.approx(p.area_mm2(p.rim_mm))
    holes = [entity for entity in read if entity[0][1] == "CIRCLE"]
    assert sorted((values(h, 10)[0], values(h, 20)[0]) for h in holes) == sorted(p.screw_places())
    assert {values(hole, 40)[0] for hole in holes} == {1.7}
    assert {dict(hole)[8] for hole in holes} == {"DRILL"}
    assert re.search(r"\$INSUNITS\s+70\s+4\n", template_dxf(p))  # millimetres


def test_an_arrow_tells_which_way_round_the_machine_stands() -> None:
    """The opening looks alike four ways round, the machine under it only one: chain 0 lies along +x."""
    p = panel()
    read = [entity for entity in entities(template_dxf(p)) if dict(entity)[8] == "ARM"]
    shaft, head = (entity for entity in read if entity[0][1] == "LWPOLYLINE")
    assert values(shaft, 20) == [0.0, 0.0]
    assert p.half_mm + p.rim_mm <= values(shaft, 10)[0] < values(shaft, 10)[1] == max(values(head, 10))
    (words,) = (dict(entity)[1] for entity in read if entity[0][1] == "TEXT")
    assert words == "seen from above: an arm of the machine points this way"
    assert re.search(r">seen from above; the arrow:<.*>an arm of the machine points this way<", template_svg(p))
    arm = np.array([1.0, 0.0, 0.0])
    assert chain_turn(of_panel().design.geometry, 0)[:3, :3] @ arm == pytest.approx(
        arm
    )  # an arm's own x points to its elbow


def test_the_dxf_is_the_same_each_time_and_sound() -> None:
    import ezdxf

    p = panel()
    assert template_dxf(p) == template_dxf(p)
    from io import StringIO

    assert ezdxf.read(StringIO(template_dxf(p))).audit().errors == []  # pyright: ignore[reportPrivateImportUsage]


def test_the_svg_prints_in_true_size() -> None:
    p = panel()
    root = ElementTree.fromstring(template_svg(p))
    _, _, width, height = map(float, root.attrib["viewBox"].split())
    assert (root.attrib["width"], root.attrib["height"]) == (f"{width:g}mm", f"{height:g}mm")
    space = "{http://www.w3.org/2000/svg}"
    paths = [node.attrib["d"] for node in root.iter(f"{space}path")]
    corner = re.findall(r"A([\d.]+) [\d.]+ 0 0 0 (-?[\d.]+) (-?[\d.]+)", paths[0])
    assert len(corner) == 4
    assert {float(radius) for radius, _, _ in corner} == {p.opening_mm}
    far = p.half_mm + p.opening_mm
    assert {max(abs(float(x)), abs(float(y))) for _, x, y in corner} == {far}
    holes = [(float(n.attrib["cx"]), -float(n.attrib["cy"])) for n in root.iter(f"{space}circle")]
    assert sorted(holes) == sorted(p.screw_places())
    assert any("h50M" in path for path in paths)  # the bar that a rule is laid on


def test_the_axis_of_a_base_that_is_not_under_the_middle_is_marked() -> None:
    p = replace(panel(), centre_x_mm=11.1)
    lines = [entity for entity in entities(template_dxf(p)) if entity[0][1] == "LWPOLYLINE"]
    middles = [(np.mean(values(one, 10)), np.mean(values(one, 20))) for one in lines if dict(one)[8] == "ARM"]
    assert sum(abs(x + 11.1) < 1e-9 and abs(y) < 1e-9 for x, y in middles) == 2
    assert "axis of the machine's base, 11.1 mm from the opening's middle" in template_svg(p)
    assert "axis of the machine's base" not in template_svg(replace(p, centre_x_mm=0.0))
