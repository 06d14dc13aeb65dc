"""Each rule of a shop on small parts that just keep it and that just break it, and on the machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import cos, pi, sin

import cadquery as cq
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.dfm.check import RULES, check_dfm
from delta_cad.checks.report import CheckResult
from delta_cad.solids.boring import along_y, along_z, between, blind, group, sunk, tapped, tool
from delta_cad.solids.making import made_part, material
from delta_cad.solids.part import Bore, Part
from delta_cad.solids.primitive import bore_z, box, closed_corners, cut, fuse, round_inside


def part(solid: cq.Shape, *bores: Bore) -> Part:
    """A part that declares bores, which its solid has."""
    holes = [group(f"bore {k}", [bore]) for k, bore in enumerate(bores)]
    return made_part("block", "block", solid, material("aluminium-6082"), (None, None, None), holes)


def bored(*bores: Bore, size: tuple[float, float, float] = (60.0, 40.0, 40.0)) -> Part:
    """A block with bores."""
    return part(cut(box((0, 0, 0), size), [tool(bore) for bore in bores]), *bores)


def pocketed(radius: float, deep: float) -> Part:
    """A block with a pocket of 20 by 12 mm from above."""
    pocket = cq.Workplane("XY").box(20, 12, 2 * deep)
    pocket = pocket.edges("|Z").fillet(radius) if radius else pocket
    return part(box((-30, -20, -40), (30, 20, 0)).cut(pocket.val()))  # type: ignore[arg-type]


def slotted(wide: float) -> Part:
    """A block with a T-slot along y: a groove that is wider below."""
    neck = box((-2, -30, -4), (2, 30, 1))
    return part(box((-20, -20, -40), (20, 20, 0)).cut(neck, box((-wide, -18, -8), (wide, 18, -4))))


def around(count: int) -> Part:
    """A hub with radial bores and one across them all, each asking for a clamping of its own unless it turns."""
    ways = [(cos(2 * pi * k / 9), sin(2 * pi * k / 9), 0.4 * (k - 2)) for k in range(count)]
    hub = cq.Solid.makeSphere(20.0, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), -90, 90, 360)
    bores = [
        blind(between(3.0, tuple(20.0 * v / norm for v in way), (0.0, 0.0, 0.0)))
        for way in ways
        for norm in [sum(v * v for v in way) ** 0.5]
    ]
    bores = [replace(bore, depth_mm=8.0) for bore in bores]
    return part(cut(hub, [tool(bore) for bore in bores]), *bores)


def result(one: Part, name: str) -> CheckResult:
    (found,) = [r for r in check_dfm([one]) if r.name == name]
    return found


def thread(deep: float) -> Bore:
    """M4 x 8 drilled to a depth."""
    return replace(tapped(along_z(0.0, (20, 20), (40, 0)), "M4", 8.0), depth_mm=deep)


def thread_at(x: float) -> Bore:
    """M4 x 8 so far from a side: its outer diameter is 2 mm nearer."""
    return tapped(along_z(0.0, (x, 20), (40, 0)), "M4", 8.0)


KEPT_AND_BROKEN: dict[str, tuple[Callable[[], Part], Callable[[], Part]]] = {
    "dfm corners": (lambda: pocketed(1.5, 6.0), lambda: pocketed(0.0, 6.0)),
    "dfm corner radii": (lambda: pocketed(1.5, 14.9), lambda: pocketed(1.5, 15.1)),
    "dfm walls": (
        lambda: bored(along_z(6.0, (20, 20), (0, 40)), along_z(6.0, (26.6, 20), (0, 40))),
        lambda: bored(along_z(6.0, (20, 20), (0, 40)), along_z(6.0, (26.4, 20), (0, 40))),
    ),
    "dfm thread walls": (lambda: bored(thread_at(2.81)), lambda: bored(thread_at(2.79))),
    "dfm bore depth": (
        lambda: bored(blind(along_z(3.0, (20, 20), (40, 10.1)), 118.0)),
        lambda: bored(blind(along_z(3.0, (20, 20), (40, 9.9)), 118.0)),
    ),
    "dfm run-out": (lambda: bored(thread(10.5)), lambda: bored(thread(10.3))),
    "dfm sizes": (
        lambda: bored(along_z(3.3, (20, 20), (0, 30))),
        lambda: bored(along_z(3.3123, (20, 20), (0, 30))),
    ),
    "dfm reach": (
        lambda: part(
            cut(
                fuse(box((0, 0, 0), (60, 40, 10)), box((30, 0, 0), (40, 40, 30))),
                [tool(along_z(4.0, (20, 20), (10, 0)))],
            ),
            along_z(4.0, (20, 20), (10, 0)),
        ),
        lambda: part(
            cut(
                fuse(box((0, 0, 0), (60, 40, 10)), box((0, 0, 20), (60, 40, 30)), box((0, 0, 0), (5, 40, 30))),
                [bore_z(4.0, (20, 20), (4, 10))],
            ),
            blind(along_z(4.0, (20, 20), (10, 4))),
        ),
    ),
    "dfm undercuts": (lambda: slotted(2.0), lambda: slotted(8.0)),
    "dfm setups": (lambda: around(4), lambda: around(6)),
}


@pytest.mark.parametrize("name", KEPT_AND_BROKEN)
def test_a_rule_is_kept_up_to_its_limit_and_broken_beyond(name: str) -> None:
    kept, broken = (result(make(), name) for make in KEPT_AND_BROKEN[name])
    assert kept.passed
    assert not broken.passed
    assert broken.worst_pair == ("block",)
    assert "fail: " in broken.detail
    assert broken.limit is not None


def test_there_is_a_part_for_every_rule() -> None:
    assert set(KEPT_AND_BROKEN) == {rule.name for rule in RULES}


def test_a_corner_shorter_than_what_a_cutter_may_leave_is_none() -> None:
    """Where two roundings nearly meet the kernel leaves an edge of some micrometres."""
    assert result(pocketed(0.0, 0.04), "dfm corners").passed
    assert not result(pocketed(0.0, 0.06), "dfm corners").passed


def test_figures_are_those_of_the_drawing() -> None:
    walls = result(KEPT_AND_BROKEN["dfm walls"][0](), "dfm walls")
    assert (walls.value, walls.limit, walls.unit) == (pytest.approx(0.6, abs=0.003), 0.5, "mm")
    radii = result(pocketed(2.0, 8.0), "dfm corner radii")
    assert (radii.value, radii.limit) == (pytest.approx(2.0), 5.0)
    deep = result(bored(blind(along_z(3.0, (20, 20), (40, 25)), 118.0)), "dfm bore depth")
    assert (deep.value, deep.limit) == (pytest.approx(5.0), 10.0)
    long = result(bored(tapped(along_z(0.0, (20, 20), (40, 0)), "M4", 18.0)), "dfm bore depth")
    assert (long.value, long.limit, long.passed) == (pytest.approx(4.5), 4.0, False)
    out = result(bored(thread(10.5)), "dfm run-out")
    assert (out.value, out.limit) == (pytest.approx(2.5), 2.4)
    six = result(
        bored(*(along_z(3.0, (x, 5), (0, 40)) for x in (5, 15)), along_y(3.0, (30, 20), (0, 40))), "dfm setups"
    )
    assert six.value == 1.0  # the block turns about x


def test_a_counterbored_and_a_fitted_bore_are_no_fault() -> None:
    head = sunk(along_z(8.0, (20, 20), (40, 35.6)))
    rest = along_z(4.5, (20, 20), (35.6, 0))
    assert all(r.passed for r in check_dfm([bored(head, rest)]))


def test_a_bought_part_is_not_looked_at() -> None:
    assert all(r.passed for r in check_dfm([replace(pocketed(0.0, 6.0), make=False)]))


def test_corners_are_rounded_where_a_cutter_needs_it() -> None:
    """An L and a pocket: the former's corner is open to two sides, the latter's to none."""
    angle = fuse(box((0, 0, 0), (20, 6, 10)), box((0, 0, 0), (6, 20, 10)))
    assert round_inside("L", angle, (0.0, 0.0, 1.0)).Volume() == pytest.approx(angle.Volume())
    pocket = box((0, 0, 0), (40, 40, 10)).cut(box((10, 10, 4), (30, 30, 11)))
    rounded = round_inside("pocket", pocket, (0.0, 0.0, 1.0))
    assert rounded.Volume() - pocket.Volume() == pytest.approx(4 * (1 - pi / 4) * 1.6**2 * 6.0, rel=1e-9)
    small = box((0, 0, 0), (40, 40, 10)).cut(box((10, 10, 4), (12.5, 30, 11)))  # no room for 1.6 on either side
    assert closed_corners(small)
    assert closed_corners(round_inside("slit", small, (0.0, 0.0, 1.0))) == []


def test_the_machine_can_be_made(best_assembly: Assembly) -> None:
    results = check_dfm(best_assembly.parts)
    assert [r.name for r in results if not r.passed] == []
    assert {r.detail.rsplit("; ", 1)[1] for r in results} == {"17 parts"}
    (platform,) = [part for part in best_assembly.parts if part.number == "platform"]
    assert not all(corner.is_straight for corner in closed_corners(platform.solid))  # some a ball cutter makes
