"""Records of parts, each around one valid solid: those we make with their bores, those we buy with their order."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from math import ceil, cos, floor, pi, sin, sqrt
from typing import TypedDict, Unpack

import cadquery as cq

from delta_cad import catalogue
from delta_cad.catalogue import CatalogueRow
from delta_cad.solids.boring import axes
from delta_cad.solids.part import Extent, Hole, Material, Part, Span
from delta_cad.solids.primitive import one_solid


def material(key: str, colour: tuple[float, float, float] | None = None) -> Material:
    """Material of a catalogue id; `colour` shows an anodised or painted part."""
    row = catalogue.material(key)
    return Material(row.description, row.density_kg_m3, colour or row.colour, row.process)


GRAPHITE = (0.22, 0.23, 0.26)  # anodised colours of the parts that a person tells apart in the pictures
ORANGE = (0.85, 0.36, 0.08)
BLUE = (0.16, 0.42, 0.68)


class Order(TypedDict, total=False):
    """The order of a bought part, or of the stock that a part is made from; see `Part`."""

    standard: str
    order_code: str
    source: str


def made_part(
    number: str,
    description: str,
    shape: cq.Shape,
    substance: Material,
    extent_mm: Extent,
    holes: Iterable[Hole] = (),
    **order: Unpack[Order],
) -> Part:
    """Makes the record of a part that is machined or printed.

    Args:
        number: Part number.
        description: One line for the bill of materials.
        shape: Its shape, mm.
        substance: Its material.
        extent_mm: How far it reaches along its axes.
        holes: Its bores; groups of equal diameter are joined, because a bore in a solid is recognised by its diameter.
        order: Order of the stock it is made from, see `ordered`.

    Raises:
        BuildError: The shape is not one valid solid.
    """
    groups: dict[tuple[float, bool], list[Hole]] = {}
    for hole in holes:
        groups.setdefault((round(hole.diameter_mm, 6), hole.is_slot), []).append(hole)
    bores = tuple(map(_joined, groups.values()))
    return Part(number, description, one_solid(shape, number), substance, True, bores, extent_mm=extent_mm, **order)


def bought_part(
    number: str,
    row: CatalogueRow,
    shape: cq.Shape,
    substance: str,
    extent_mm: Extent | None,
    mass_g: float | None = None,
    size: str = "",
    holes: tuple[Hole, ...] = (),
) -> Part:
    """Makes the record of a bought part of its catalogue row.

    Args:
        number: Part number.
        row: Row it is ordered by.
        shape: Its outer shape, mm.
        substance: Id of the material it is mostly made of, for its colour.
        extent_mm: How far it reaches along its axes, as its row says.
        mass_g: Mass as the maker gives it; None: volume times density.
        size: What is added to description and order code, such as " x 8".
        holes: Bores that other parts go by.

    Raises:
        BuildError: The shape is not one valid solid.
    """
    description, solid = row.description + size, one_solid(shape, number)
    order, drawn = ordered(row, size), row.to_drawing
    stuff = material(substance)
    return Part(number, description, solid, stuff, False, holes, mass_g, extent_mm=extent_mm, to_drawing=drawn, **order)


def ordered(row: CatalogueRow, size: str = "") -> Order:
    """Gives standard, order code and source of a catalogue row, and what of the source was verified."""
    code = row.order_code if row.maker == "any" else f"{row.maker} {row.order_code}"
    source = f"{row.source}; verified: {row.verified}"
    return {"standard": row.standard, "order_code": code + size, "source": source}


def round_y(radius: float, y: Span) -> Extent:
    """Reach of a part of revolution about y, of its largest radius."""
    return (-radius, radius), y, (-radius, radius)


def round_z(radius: float, z: Span) -> Extent:
    """Reach of a part of revolution about z, of its largest radius."""
    return (-radius, radius), (-radius, radius), z


def hull_y(circles: Sequence[tuple[float, float, float]], y: Span) -> Extent:
    """Reach of the hull of circles (x, z, radius) in a plane across y."""
    lows, highs = zip(*(((x - r, z - r), (x + r, z + r)) for x, z, r in circles), strict=True)
    (x0, z0), (x1, z1) = (map(min, zip(*lows, strict=True)), map(max, zip(*highs, strict=True)))
    return (x0, x1), y, (z0, z1)


def points_of_arc(radius: float, angles: Span) -> list[tuple[float, float, float]]:
    """(x, z, 0) of an arc's ends about y and of where it crosses an axis, as circles of `hull_y`."""
    quarters = range(ceil(2.0 * angles[0] / pi), floor(2.0 * angles[1] / pi) + 1)
    return [(radius * cos(a), radius * sin(a), 0.0) for a in (*angles, *(k * pi / 2.0 for k in quarters))]


def cut_circle(radius: float, half_slit: float) -> float:
    """How far a circle reaches in a direction in which a slit of half a width is open."""
    return sqrt(radius**2 - half_slit**2)


def _joined(same: list[Hole]) -> Hole:
    callouts = "; ".join(f"{hole.count}x {hole.callout}" for hole in same)
    if len(same) == 1:
        return same[0]
    bores = tuple(bore for hole in same for bore in hole.bores)
    slots = tuple(slot for hole in same for slot in hole.slots)
    count = axes(bores) if bores else sum(hole.count for hole in same)  # those from either side share theirs
    return replace(same[0], count=count, callout=callouts, bores=bores, slots=slots)
