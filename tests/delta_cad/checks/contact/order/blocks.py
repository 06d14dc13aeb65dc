"""Small machines of blocks and pins with an order of assembly, to be spoiled by the tests."""

from __future__ import annotations

import cadquery as cq

from delta_cad.assembly.machine import Assembly, Insertion, PathSegment, Step, Unit
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.order.check import check_order
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Occurrence, Part
from tests.delta_cad.checks.machines import LIMITS, at, box, part, placement, rod

DOWN, UP, ALONG = (PathSegment((0.0, 0.0, -1.0)),), (PathSegment((0.0, 0.0, 1.0)),), (PathSegment((1.0, 0.0, 0.0)),)


def on_base(*parts: Part, lifted: dict[str, float] | None = None, order: tuple[Unit, ...] = ()) -> Assembly:
    """Parts on the base as they are drawn, or so much higher, each called as its number."""
    found = (Occurrence(p.number, p, "base", at(0.0, 0.0, (lifted or {}).get(p.number, 0.0))) for p in parts)
    return Assembly("blocks", tuple(found), (), (), placement(), LIMITS.centre_mm, order=order)


def checked(a: Assembly) -> dict[str, CheckResult]:
    return {r.name: r for r in check_order(a, LIMITS, MeshLibrary(a.parts))}


def whole(*steps: Step) -> tuple[Unit, ...]:
    return (Unit("machine", "machine", "Machine", steps),)


def step(*brings: Insertion, tightened: tuple[str, ...] = (), supplies: tuple[str, ...] = ()) -> Step:
    return Step("a step", ("It is done.",), brings, tightened, supplies=supplies)


def plate() -> Part:
    """30 x 30 x 10 with a through bore of 6 mm."""
    return part("plate", box((-15, -15, 0), (15, 15, 10)).cut(rod(3, (0, 0, -1), (0, 0, 11))))


def pin(length: float = 20.0) -> Part:
    """A pin that fills the bore, from its lower end upwards."""
    return part("pin", rod(3, (0, 0, 0), (0, 0, length)))


def lid(height: float = 30.0) -> Part:
    """A plate of 2 mm over all."""
    return part("lid", box((-15, -15, height), (15, 15, height + 2)))


def case() -> Part:
    """A closed box with a hollow of 10 mm."""
    shell: cq.Shape = box((-10, -10, -10), (10, 10, 10)).cut(box((-5, -5, -5), (5, 5, 5)))
    return part("case", shell)


def hooked() -> Part:
    """A block with a slot that goes down 12 mm, then along x to its side."""
    block = box((-15, -15, 0), (15, 15, 30)).cut(box((-3, -3, 10), (3, 3, 31)))
    return part("hooked", block.cut(box((-3, -3, 10), (12, 3, 16))))
