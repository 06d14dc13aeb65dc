"""Mass, centre of mass and inertia of every part and every moving body, from the exact solids.

The integrals come from the boundary representation, not from a mesh. A catalogue mass overrides volume times
density; the inertia is then scaled by the same ratio, which keeps the shape of the mass distribution.
"""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import M_PER_MM
from delta_cad.mechanism.placement import LINKS, SIDES
from delta_cad.solids.part import Part

_SCHEMA = "delta-mass-properties/1"


class MassPropertiesError(ValueError):
    """A part has no positive mass."""


@dataclass(frozen=True)
class MassProperties:
    """Mass properties of a rigid body in a stated frame.

    Attributes:
        mass_kg: Mass.
        centre_m: (3,) centre of mass, m.
        inertia_kg_m2: (3, 3) inertia about the centre of mass, axes along the frame, kg m^2. Off-diagonal entries
            are those of the tensor, that is minus the products of inertia.
    """

    mass_kg: float
    centre_m: np.ndarray
    inertia_kg_m2: np.ndarray

    def moved(self, frame: np.ndarray) -> MassProperties:
        """Gives the same body seen from another frame.

        Args:
            frame: (4, 4) transform from the present frame to the new one, translation in mm.
        """
        rotation = frame[:3, :3]
        centre = rotation @ self.centre_m + frame[:3, 3] * M_PER_MM
        return MassProperties(self.mass_kg, centre, rotation @ self.inertia_kg_m2 @ rotation.T)

    def record(self) -> dict[str, Any]:
        """Gives the properties as plain numbers for JSON."""
        return {
            "mass_kg": self.mass_kg,
            "centre_m": self.centre_m.tolist(),
            "inertia_kg_m2": self.inertia_kg_m2.tolist(),
        }


def part_mass_properties(part: Part) -> MassProperties:
    """Integrates the mass properties of one part in its own frame.

    Args:
        part: The part; `mass_g`, where given, overrides volume times density.

    Returns:
        Properties in the part's frame.

    Raises:
        MassPropertiesError: The solid has no positive volume, or the mass is not positive.
    """
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    integrals = GProp_GProps()
    BRepGProp.VolumeProperties_s(part.solid.wrapped, integrals)
    volume_mm3 = integrals.Mass()
    if volume_mm3 <= 0.0:
        raise MassPropertiesError(f"part {part.number} has a volume of {volume_mm3:.6g} mm^3")
    by_volume = volume_mm3 * M_PER_MM**3 * part.material.density_kg_m3
    mass = by_volume if part.mass_g is None else part.mass_g * 1e-3
    if not mass > 0.0:
        raise MassPropertiesError(f"part {part.number} has a mass of {mass:.6g} kg")
    point = integrals.CentreOfMass()
    centre_mm = np.array([point.X(), point.Y(), point.Z()])
    matrix = integrals.MatrixOfInertia()
    inertia_mm5 = np.array([[matrix.Value(row, column) for column in (1, 2, 3)] for row in (1, 2, 3)])
    inertia = inertia_mm5 / volume_mm3 * M_PER_MM**2 * mass
    return MassProperties(mass, centre_mm * M_PER_MM, (inertia + inertia.T) / 2.0)


def combined(bodies: list[MassProperties]) -> MassProperties:
    """Combines rigid bodies, all given in the same frame, into one by the parallel-axis theorem.

    Raises:
        MassPropertiesError: There is no body.
    """
    if not bodies:
        raise MassPropertiesError("no body to combine")
    mass = sum(body.mass_kg for body in bodies)
    centre = sum((body.mass_kg * body.centre_m for body in bodies), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        d = body.centre_m - centre
        inertia += body.inertia_kg_m2 + body.mass_kg * (d @ d * np.eye(3) - np.outer(d, d))
    return MassProperties(mass, centre, inertia)


def link_mass_properties(
    assembly: Assembly, parts: Mapping[str, MassProperties] | None = None
) -> dict[str, MassProperties]:
    """Combines the mass properties of every link that carries parts, each in its link's frame.

    Args:
        assembly: The machine.
        parts: Part number -> properties in the part's frame; integrated where not given.

    A spring across a pair is half carried by either rod, as a point on the rod's axis beside its eye. Rods of a pair
    move alike and the spring keeps its direction (within 1 deg), so that it moves as these points do, but for the
    5.5 mm that its eyes lie aside: 4e-8 kg m^2 about the elbow of a pair's 2e-4.

    Returns:
        Link name -> properties, in the order of `placement.LINKS`, springs on their rods.
    """
    known = parts if parts is not None else {part.number: part_mass_properties(part) for part in assembly.parts}
    carried: dict[str, list[MassProperties]] = {}
    for occurrence in assembly.occurrences:
        own, link = known[occurrence.part.number], occurrence.link
        if not link.startswith("spring"):
            carried.setdefault(link, []).append(own.moved(occurrence.placement))
            continue
        chain, which = (int(word) for word in link.split("_")[1:])
        along = assembly.placement.springs_mm[which][0]
        half = MassProperties(own.mass_kg / 2.0, np.array([along, 0.0, 0.0]) * M_PER_MM, np.zeros((3, 3)))
        for side in SIDES:
            carried.setdefault(f"rod_{chain}_{side}", []).append(half)
    return {link: combined(carried[link]) for link in LINKS if link in carried}


def mass_report(assembly: Assembly) -> dict[str, Any]:
    """Collects all mass properties as plain numbers.

    Returns:
        `parts` by part number (own frame) with volume and whether the mass is from the catalogue; `bodies` by link
        (link frame), springs across a pair halved upon its rods; `assembly`, the whole in the base frame at the home
        position; total and moving mass in kg.
    """
    parts = {part.number: part_mass_properties(part) for part in assembly.parts}
    links = link_mass_properties(assembly, parts)
    frames = assembly.poses(assembly.home_mm)
    machine = combined([parts[o.part.number].moved(frames[o.name]) for o in assembly.occurrences])
    return {
        "schema": _SCHEMA,
        "home_mm": np.asarray(assembly.home_mm, dtype=float).tolist(),
        "total_mass_kg": machine.mass_kg,
        "moving_mass_kg": sum(body.mass_kg for link, body in links.items() if link != "base"),
        "assembly": machine.record(),
        "bodies": {link: body.record() for link, body in links.items()},
        "parts": {
            part.number: parts[part.number].record()
            | {
                "volume_m3": part.solid.Volume() * M_PER_MM**3,
                "mass_source": "volume x density" if part.mass_g is None else "catalogue",
            }
            for part in assembly.parts
        },
    }
