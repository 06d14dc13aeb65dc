"""Threads that a tap cuts without bulging or breaking the adjacent wall."""

from __future__ import annotations

from collections.abc import Iterator
from math import cos, pi, sin

import numpy as np

from delta_cad import catalogue
from delta_cad.checks.dfm.bores import Finding, at, bores
from delta_cad.checks.dfm.lines import Lines
from delta_cad.checks.dfm.walls import ACROSS, INTO_MM
from delta_cad.common.vectors import cross
from delta_cad.dimensions.rules import THREAD_WALL_MM
from delta_cad.solids.part import Bore, Part

RING, STATIONS = 24, 7  # directions about a thread's axis, places along it


def thread_walls(part: Part) -> Iterator[Finding]:
    """The thinnest wall next to each thread: from its outer diameter straight to the face that ends the material."""
    lines = Lines(part.solid)
    for bore in (bore for bore in bores(part) if bore.thread):
        wall = min(_ends(lines, bore), default=np.inf) - catalogue.screw(bore.thread).diameter_mm / 2
        if np.isfinite(wall):
            where = f"{part.number}: {wall:.2f} mm beside {at(bore)}"
            yield Finding(part.number, round(wall, 3), THREAD_WALL_MM, where, is_least=True)


def _ends(lines: Lines, bore: Bore) -> Iterator[float]:
    """How far from a thread's axis the material around it ends in a face across the way out, mm."""
    start, along = np.array(bore.start_mm), np.array(bore.direction)
    across = cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    across /= np.linalg.norm(across)
    aside = cross(along, across)
    begin = bore.diameter_mm / 2 + INTO_MM
    for deep in (np.arange(STATIONS) + 0.5) / STATIONS * bore.thread_mm:
        for angle in 2 * pi * np.arange(RING) / RING:
            way = cos(angle) * across + sin(angle) * aside
            hit = lines.first(start + deep * along + begin * way, way)
            if hit is not None and hit[1] @ way > ACROSS:
                yield begin + hit[0]
