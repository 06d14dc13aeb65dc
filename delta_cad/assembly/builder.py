"""The builder of a machine: parts made once and placed, each with its connections and its path of insertion.

A connection is stated where the part is put that holds, guides or carries another: by it the contact is checked, by its
links the fit of two that move against one another, and the order of assembly takes the path in from the same statement.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi
from typing import Literal

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.machine import PathSegment
from delta_cad.common.memoize import cached, cached_by_reads
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import DOWEL_MM
from delta_cad.dimensions.rules import require
from delta_cad.mechanism.placement import frames
from delta_cad.solids import bought_parts
from delta_cad.solids.part import Contact, Fit, Occurrence, Part, Removal, ToolAccess

_ROUNDING_MM = 1e-9  # sums of a few lengths of 10 mm
_CONTACT_MM3 = 0.01  # common volume of two faces that touch: the kernel's noise, not a fit
NEXT_TO_MM = 0.8  # least gap of what turns beside a cheek: 1 mm by design less play and the meshes' deviation
FIT_MM = 0.02  # radius: H7 and h6 up to 18 mm leave 0.015
GLUE_MM = 0.06  # radius: the widest bond, of the magnet
SEATED_MM = 0.02  # along a normal: what a shim cannot enter
THREAD_MM = bought_parts.CORE_PLAY_MM  # radius, threads being drawn as their cores
CABLE_OFF_MM = 0.03  # the cable's line is drawn through points on its path
CHAMFERS_MM = 1.2  # of both ends of a bore or a shaft together: a bore's length is asked but for them
SHARE = 0.6  # of a flat face, beside edges, slits and the bores of screws
Progress = Callable[[str], None]
InsertionPath = tuple[PathSegment, ...]
"""How a part comes to its seat, in its own frame or that of another."""


def straight(x: float, y: float, z: float) -> InsertionPath:
    """Gives the path along one direction, from outside to the seat."""
    return (PathSegment((x, y, z)),)


IN, OUT = straight(0.0, 1.0, 0.0), straight(0.0, -1.0, 0.0)  # along the shoulder's axis, towards the motor, and away
UP, DOWN = straight(0.0, 0.0, 1.0), straight(0.0, 0.0, -1.0)
DRIVEN = DOWN  # a screw or a pin along its own axis


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """(4, 4) translation."""
    moved = np.eye(4)
    moved[:3, 3] = (x, y, z)
    return moved


HALF_TURN = np.diag([-1.0, -1.0, 1.0, 1.0])  # about z
UPRIGHT = np.array([[0.0, 0, 1, 0], [0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1]])  # x down: rods pass beside the board


def pointing(direction: Sequence[float], x: float = 0.0, y: float = 0.0, z: float = 0.0) -> np.ndarray:
    """(4, 4) frame at a point whose z axis is the direction: how screws, dowels and sleeves are placed."""
    axis = np.asarray(direction, dtype=float)
    axis = axis / np.linalg.norm(axis)
    aside = np.cross([0.0, 1.0, 0.0] if abs(axis[1]) < 0.9 else [1.0, 0.0, 0.0], axis)
    first = aside / np.linalg.norm(aside)
    return frames(first, np.cross(axis, first), np.array([x, y, z]))


def longest(size: str, available_mm: float) -> float:
    """Longest stock length of a cap screw, such as "M3", that fits from under its head to the end of the thread, mm.

    Raises:
        DimensionError: The shortest one is longer.
    """
    return _longest(catalogue.screw(size).lengths_mm, available_mm, f"screw_{size}", " under the head")


def longest_dowel(key: str, available_mm: float) -> float:
    """Longest stock length of a dowel, such as "3", that does not exceed the depth of its bores together, mm.

    Raises:
        DimensionError: The shortest one is longer.
    """
    return _longest(catalogue.dowel(key).lengths_mm, available_mm, f"dowel_{key}")


def longest_set_screw(size: str, available_mm: float) -> float:
    """Longest stock length of a set screw that stays below the surface, mm.

    Raises:
        DimensionError: The shortest one is longer.
    """
    return _longest(catalogue.set_screw(size).lengths_mm, available_mm, f"set_screw_{size}")


def _longest(lengths_mm: tuple[float, ...], available_mm: float, part: str, where: str = "") -> float:
    fitting = [length for length in lengths_mm if length <= available_mm + _ROUNDING_MM]
    shortest = f"{available_mm:.2f} mm are available{where}; the shortest has {min(lengths_mm):g} mm"
    require(bool(fitting), part, "length", shortest)
    return max(fitting)


@dataclass(frozen=True)
class Connection:
    """How a part that is put holds, guides or stands on another one; see `Contact` for what is checked of it.

    Attributes:
        to: Occurrence name of the other.
        reason: What it is for, a few words.
        kind: As in `Contact`.
        least: Least engaged length, mm, or area, mm^2.
        gap_mm: Largest gap, mm.
        guides: Whether it is a seat of a joint, where the two are on different links.
    """

    to: str
    reason: str
    kind: Literal["cylinder", "plane", "ball", "cable", "tip", "end"]
    least: float
    gap_mm: float
    guides: bool = True


def pressed(to: str, length_mm: float, reason: str, gap_mm: float = FIT_MM) -> Connection:
    """States a pin, a shaft or a ring in a bore of another part: pressed, sliding or clamped, by the gap of radii."""
    return Connection(to, reason, "cylinder", length_mm, gap_mm)


def bonded(to: str, length_mm: float, reason: str, glue_mm: float) -> Connection:
    """States a part bonded in a bore of another, `glue_mm` of adhesive around it; a tenth more is its tolerance."""
    return Connection(to, reason, "cylinder", length_mm, 1.1 * glue_mm)


def bolted(to: str, length_mm: float, reason: str) -> Connection:
    """States a thread in another part, over the length that is engaged."""
    return Connection(to, reason, "cylinder", length_mm, THREAD_MM)


def seated(to: str, area_mm2: float, reason: str, gap_mm: float = SEATED_MM, guides: bool = True) -> Connection:
    """States a flat face upon that of another part; of what is drawn of both, `SHARE` must meet."""
    return Connection(to, reason, "plane", SHARE * area_mm2, gap_mm, guides)


def wound(to: str, length_mm: float, reason: str, gap_mm: float = CABLE_OFF_MM, guides: bool = True) -> Connection:
    """States a cable on round faces of another part, or in its sleeve."""
    return Connection(to, reason, "cable", length_mm, gap_mm, guides)


def ring(outer_mm: float, inner_mm: float) -> float:
    """Area between two diameters, mm^2."""
    return pi / 4 * (outer_mm**2 - inner_mm**2)


class AssemblyBuilder:
    """Collects the occurrences of a machine with their connections; makes each part once.

    Attributes:
        occurrences: What was put, in this order.
        connections: What each holds, guides or stands on, by its name.
        fits: Pairs that are closer than others by design, beside those of connections.
        reached: Screws that a key reaches in the finished machine.
        removals: Parts that come off it, each in a straight line.
        paths: Occurrence name -> the path to its seat, and the occurrence in whose frame it is stated; "" for its own.
    """

    def __init__(self, d: Dimensions, progress: Progress) -> None:
        self.d = d
        self.occurrences: list[Occurrence] = []
        self.connections: list[tuple[str, Connection]] = []
        self.fits: list[Fit] = []
        self.reached: list[ToolAccess] = []
        self.removals: list[Removal] = []
        self.paths: dict[str, tuple[InsertionPath, str]] = {}
        self._progress = progress
        self._parts: dict[str, Part] = {}

    def once(self, key: str, make: Callable[..., Part], *of: object) -> Part:
        """Makes the part of a key, on first use, by a function of these arguments alone."""
        named = f"{make.__module__}.{make.__qualname__}", of
        return self._once(key, lambda: cached("part", named, lambda: make(*of)))

    def made(self, make: Callable[..., Part], number: str = "", *others: object) -> Part:
        """Makes the part that a function `make_<number>` makes of the dimensions, and of `others`."""
        return self._once(number or make.__name__.removeprefix("make_"), lambda: cached_by_reads(make, self.d, *others))

    def _once(self, key: str, make: Callable[[], Part]) -> Part:
        if key not in self._parts:
            self._progress(key)
            self._parts[key] = make()
        return self._parts[key]

    def screw(self, size: str, length: float) -> Part:
        """Gives the cap screw of a size and a length."""
        return self.cap_screw(catalogue.screw(size), length)

    def cap_screw(self, row: catalogue.Screw, length: float) -> Part:
        """Gives the cap screw of a row of the catalogue and a length."""
        return self.once(f"screw_{row.id}x{length:g}", bought_parts.make_cap_screw, row, length)

    def dowel(self, key: str, length: float) -> Part:
        """Gives the dowel of a diameter and a length."""
        return self.once(f"dowel_{key}x{length:g}", bought_parts.make_dowel, key, length)

    def put(
        self,
        name: str,
        part: Part,
        link: str,
        placement: np.ndarray,
        *connections: Connection,
        path: InsertionPath = (),
        frame: str = "",
    ) -> str:
        """Places a part on a link in its frame there, with what it is connected to and how it comes in.

        Args:
            name: Of the occurrence.
            part: The part.
            link: Name of the rigid body.
            placement: (4, 4) part's frame to the link's, mm.
            connections: To other occurrences, placed before or later.
            path: To its seat; none for what is laid by hand.
            frame: Occurrence in whose frame the path is stated; "" for its own.
        """
        self.occurrences.append(Occurrence(name, part, link, placement))
        self.paths[name] = path, frame
        self.connect(name, *connections)
        return name

    def connect(self, name: str, *connections: Connection) -> None:
        """States what a part, put before or later, is connected to."""
        self.connections += [(name, one) for one in connections]

    def pin(
        self, name: str, length_mm: float, link: str, placement: np.ndarray, *parts: str, path: InsertionPath = DRIVEN
    ) -> None:
        """Places a dowel that locates parts on one another, engaged by its diameter in either."""
        key = f"{DOWEL_MM:g}"
        held = (pressed(part, DOWEL_MM, "dowel, engaged by its diameter") for part in parts)
        self.put(name, self.dowel(key, longest_dowel(key, length_mm)), link, placement, *held, path=path)

    def touch(self, a: str, b: str, reason: str, guides: bool = True, overlap_mm3: float = _CONTACT_MM3) -> None:
        """Notes two parts on different links that touch by design, but hold nothing."""
        self.fits.append(Fit(a, b, "contact", overlap_mm3=overlap_mm3, reason=reason, guides=guides))

    def piece(self, a: str, b: str) -> None:
        """Notes two pieces that one part is drawn in."""
        self.fits.append(Fit(a, b, "piece", reason="one part, drawn in pieces"))

    def gap(self, a: str, b: str, gap_mm: float, reason: str, gap_max_mm: float | None = None) -> None:
        """Notes two parts on different links that come closer than others by design."""
        self.fits.append(Fit(a, b, "running gap", gap_mm=gap_mm, reason=reason, gap_max_mm=gap_max_mm))

    def contacts(self) -> tuple[Contact, ...]:
        """Lists what the checks find of every connection on the solids."""
        return tuple(Contact(a, c.to, c.kind, c.least, c.gap_mm, c.reason) for a, c in self.connections)

    def all_fits(self) -> tuple[Fit, ...]:
        """Lists the fits, with them those of connections across links: of each pair the first."""
        links = {o.name: o.link for o in self.occurrences}
        found = {frozenset((fit.a, fit.b)): fit for fit in self.fits}
        for a, c in self.connections:
            if links[a] != links[c.to]:
                fit = Fit(a, c.to, "contact", overlap_mm3=_CONTACT_MM3, reason=c.reason, guides=c.guides)
                found.setdefault(frozenset((a, c.to)), fit)
        return tuple(found.values())
