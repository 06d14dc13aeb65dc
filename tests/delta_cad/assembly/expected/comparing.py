"""Compares a machine with what its design must consist of; every difference is named."""

from __future__ import annotations

from collections import Counter
from fnmatch import fnmatchcase

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.solids.part import Part
from tests.delta_cad.assembly.expected.materials import ExpectedMake, expected_makes
from tests.delta_cad.assembly.expected.parts import expected_parts, expected_supplies

ROUNDING = 1e-9  # of a rotation's products: a few turns one after the other are off by 1e-15, a part stretched so by nm
SHARE = 1e-6  # by which a mass may differ from what is expected: roundings
KG_M3_PER_G_MM3 = 1e6


def part_faults(assembly: Assembly, d: Dimensions) -> list[str]:
    """Names parts that are missing, too many, of another number, on another link, unexpected or not moved rigidly.

    Also a name given twice, a number that two different parts have, which a bill of materials cannot tell apart, and
    what is bought besides in another quantity or by another code.
    """
    unseen = {o.name: o for o in assembly.occurrences}
    counts = Counter(o.name for o in assembly.occurrences)
    faults = [f"{name} is there {count} times" for name, count in counts.items() if count > 1]
    for row in expected_parts(d):
        found = [o for name, o in unseen.items() if fnmatchcase(name, row.names)]
        if len(found) != row.count:
            faults.append(f"there are {len(found)} of {row.count} {row.names}")
        for o in found:
            del unseen[o.name]
            if not fnmatchcase(o.part.number, row.number):
                faults.append(f"{o.name} is a {o.part.number}, expected is {row.number}")
            if o.link != row.link:
                faults.append(f"{o.name} is on {o.link}, expected is {row.link}")
    faults += [f"{name} ({o.part.number}) is not expected" for name, o in unseen.items()]
    faults += [f"{o.name} is {how}" for o in assembly.occurrences if (how := _misplaced(o.placement))]
    first: dict[str, Part] = {}
    for o in assembly.occurrences:
        if first.setdefault(o.part.number, o.part) is not o.part:
            faults.append(f"{o.name} is another part of the number {o.part.number}")
    return faults + _supply_faults(assembly, d)


def _misplaced(frame: np.ndarray) -> str:
    """What a placement does to a part that no motion does; "" for a motion."""
    turn = frame[:3, :3]
    if not np.isfinite(frame).all() or (frame[3] != (0.0, 0.0, 0.0, 1.0)).any():
        return "placed nowhere"
    if np.abs(turn @ turn.T - np.eye(3)).max() > ROUNDING:
        return "stretched by its placement"
    return "" if np.linalg.det(turn) > 0.0 else "mirrored by its placement"


def _supply_faults(assembly: Assembly, d: Dimensions) -> list[str]:
    rows = {row.number: row for row in expected_supplies(d)}
    faults = [f"{s.number} is bought, but not expected" for s in assembly.supplies if s.number not in rows]
    for number, row in rows.items():
        found = [supply for supply in assembly.supplies if supply.number == number]
        if len(found) != 1:
            faults.append(f"{number} is bought in {len(found)} lines")
        for supply in found:
            if supply.quantity != row.quantity:
                faults.append(f"{supply.quantity} {number} are bought, expected are {row.quantity}")
            if not fnmatchcase(supply.order_code, row.order_code):
                faults.append(f"{number} is ordered as {supply.order_code}")
    return faults


def make_faults(assembly: Assembly, d: Dimensions) -> list[str]:
    """Names parts of another material, density, make, order, standard or mass than expected of their number."""
    rows = {row.number: row for row in expected_makes(d)}
    every = {id(o.part): o.part for o in assembly.occurrences}  # two of one number may differ
    return [
        f"{part.number}: {text}"
        for part in every.values()
        for text in (_differences(part, rows[part.number]) if part.number in rows else ["no number of this design"])
    ]


def _differences(part: Part, row: ExpectedMake) -> list[str]:
    material = catalogue.material(row.material)
    volume_g = float(part.solid.Volume()) * material.density_kg_m3 / KG_M3_PER_G_MM3
    mass_g = volume_g if part.mass_g is None else part.mass_g
    least, most = (share * volume_g for share in row.fill) if row.mass_g is None else (row.mass_g, row.mass_g)
    pairs = {
        "material": (part.material.name, material.description),
        "density": (part.material.density_kg_m3, material.density_kg_m3),
        "make": (part.make, row.make),
        "to drawing": (part.to_drawing, row.to_drawing),
        "order code": (part.order_code, row.order_code),
        "standard": (part.standard, row.standard),
        "piece of": (part.piece_of, row.piece_of),
        "mass": (mass_g, min(max(mass_g, least * (1.0 - SHARE)), most * (1.0 + SHARE))),
    }
    return [f"{what} is {found!r}, expected is {want!r}" for what, (found, want) in pairs.items() if found != want]
