"""Bores that a shop can make: drills in stock, not too deep, blind threads with run-out, reached by the tool."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from delta_cad import catalogue
from delta_cad.checks.contact.features import features
from delta_cad.checks.dfm.lines import Lines
from delta_cad.checks.dfm.located import ALONG, AXIS_MM, DIAMETER_MM
from delta_cad.common.vectors import cross, cross_length
from delta_cad.dimensions.rules import DRILL_DIAMETERS
from delta_cad.dimensions.tolerances import RUN_OUT_MM
from delta_cad.solids.part import Bore, Part

_THREAD_DIAMETERS = 4.0  # of a thread from one side: machine taps break beyond
_DRILLS_MM = ((3.0, 0.05), (14.0, 0.1), (32.0, 0.25))  # up to a diameter, steps in which drills are made: ISO 235
_MILLED_STEP_MM = 0.1  # of a larger bore, which is milled or turned to a size that a drawing can say
_RING, _RING_SHARE = 8, 0.9  # lines along the tool's outside, and how far out of its radius
_BEFORE_MM = 0.05  # a bore's start, from where a tool's lines go back
_ROUND_RAD = 4.5  # of a bore's wall: less is the bottom of a slot, which is milled from its side
_SIZE_MM = 1e-6


@dataclass(frozen=True)
class Finding:
    """A figure of one feature of a part, beside what a shop makes.

    Attributes:
        part: Part number.
        value: The figure.
        limit: What it may be; 0: it may not be at all.
        where: What it is and where, a few words.
        is_least: Whether the limit is the least.
    """

    part: str
    value: float
    limit: float
    where: str
    is_least: bool = False

    @property
    def share(self) -> float:
        """How much of its limit it takes: above 1 it cannot be made."""
        over, under = (self.limit, self.value) if self.is_least else (self.value, self.limit)
        return over / under if under > 0.0 else np.inf


def at(bore: Bore) -> str:
    """Says which bore."""
    x, y, z = bore.start_mm
    return f"{bore.callout or f'bore {bore.diameter_mm:g}'} at ({x:.1f}, {y:.1f}, {z:.1f})"


def bores(part: Part) -> list[Bore]:
    """The bores that are made in a part: those of a tube or a ball as bought are its maker's."""
    return [] if part.order_code else [bore for hole in part.holes for bore in hole.bores]


def depths(part: Part) -> Iterator[Finding]:
    """Depth of each bore in diameters, and of each thread."""
    for bore in bores(part):
        deep = bore.depth_mm / bore.diameter_mm
        yield Finding(part.number, deep, DRILL_DIAMETERS, f"{at(bore)}: {deep:.1f} diameters deep")
        if bore.thread:
            turns = bore.thread_mm / catalogue.screw(bore.thread).diameter_mm
            yield Finding(part.number, turns, _THREAD_DIAMETERS, f"{at(bore)}: thread of {turns:.1f} diameters")


def run_outs(part: Part) -> Iterator[Finding]:
    """Run-out of each blind thread, from its usable end to the drill's full depth, over what a tap needs."""
    for bore in bores(part):
        if bore.thread and not bore.through:
            needed, there = RUN_OUT_MM[catalogue.screw(bore.thread).pitch_mm], bore.depth_mm - bore.thread_mm
            where = f"{at(bore)}: run-out {there:.2f} mm, {needed:g} needed"
            yield Finding(part.number, there, needed, where, is_least=True)


def odd_sizes(part: Part) -> Iterator[Finding]:
    """Drilled bores of which there is no drill, and milled ones of a size that nobody sets."""
    for bore in bores(part):
        if bore.deviations_um is None and not _in_stock(bore.diameter_mm):
            yield Finding(part.number, bore.diameter_mm, 0.0, f"{at(bore)}: no drill of {bore.diameter_mm:.6g} mm")


def _in_stock(diameter_mm: float) -> bool:
    step = next((step for end, step in _DRILLS_MM if diameter_mm <= end), _MILLED_STEP_MM)
    steps = [step, _MILLED_STEP_MM]
    return any(abs(diameter_mm / one - round(diameter_mm / one)) * one < _SIZE_MM for one in steps)


def unreached(part: Part) -> Iterator[Finding]:
    """Bores to which a straight tool of their diameter does not come, at either end of those that go through."""
    lines = Lines(part.solid)
    for bore in round_bores(part):
        start, along = np.array(bore.start_mm), np.array(bore.direction)
        ends = [(start, -along)] + ([(start + bore.depth_mm * along, along)] if bore.through else [])
        if not any(_comes(lines, point, way, bore.diameter_mm / 2) for point, way in ends):
            yield Finding(part.number, bore.diameter_mm, 0.0, f"{at(bore)}: no tool comes to it")


def round_bores(part: Part) -> list[Bore]:
    """The bores that are drilled or bored, not the bottoms of slots, which are milled from their sides."""
    cylinders = [c for c in features(part.solid).cylinders if c.is_hollow]

    def turn_rad(bore: Bore) -> float:
        start, along = np.array(bore.start_mm), np.array(bore.direction)
        wall = [c for c in cylinders if cross_length(c.direction, along) < ALONG]
        wall = [c for c in wall if cross_length(c.point - start, along) < AXIS_MM]
        return sum(c.turn_rad for c in wall if abs(2 * c.radius_mm - bore.diameter_mm) <= DIAMETER_MM)

    return [bore for bore in bores(part) if turn_rad(bore) >= _ROUND_RAD]


def _comes(lines: Lines, point: np.ndarray, way: np.ndarray, radius_mm: float) -> bool:
    """Whether a cylinder from a point along a way is free, looked at along its outside."""
    across = cross(way, np.eye(3)[int(np.argmin(np.abs(way)))])
    across /= np.linalg.norm(across)
    other = cross(way, across)
    angles = [2 * pi * k / _RING for k in range(_RING)]
    ring = [_RING_SHARE * radius_mm * (cos(a) * across + sin(a) * other) for a in angles]
    return all(lines.is_free(point + _BEFORE_MM * way + off, way) for off in ring)
