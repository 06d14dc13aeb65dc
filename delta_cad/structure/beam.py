"""Flexibility of a straight bar of any sections, clamped at its root and loaded at its tip."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from delta_cad.structure.section import Section

SLICES = 64  # of a tapered bar; the sum over slices is second order: below 1e-3 of a flexibility


@dataclass(frozen=True)
class BeamSlice:
    """A short piece of a bar with one section.

    Attributes:
        length_mm: Along the bar.
        section: Its cross-section.
        youngs_N_mm2: E.
        shear_N_mm2: G.
    """

    length_mm: float
    section: Section
    youngs_N_mm2: float
    shear_N_mm2: float


@dataclass(frozen=True)
class Beam:
    """A straight bar from its clamped root to its tip, x along it.

    Attributes:
        slices: From root to tip.
        factor: What a solid model adds to all of its flexibility: 1 for slender bars.
    """

    slices: tuple[BeamSlice, ...]
    factor: float = 1.0

    @property
    def length_mm(self) -> float:
        """Length from root to tip."""
        return sum(piece.length_mm for piece in self.slices)


def tapered(
    root_mm: float, tip_mm: float, section: Callable[[float], Section], youngs_N_mm2: float, shear_N_mm2: float
) -> tuple[BeamSlice, ...]:
    """Cuts a bar into slices.

    Args:
        root_mm: Where it begins.
        tip_mm: Where it ends.
        section: Place between these -> cross-section.
        youngs_N_mm2: E.
        shear_N_mm2: G.
    """
    step = (tip_mm - root_mm) / SLICES
    places = (root_mm + (k + 0.5) * step for k in range(SLICES))
    return tuple(BeamSlice(step, section(x), youngs_N_mm2, shear_N_mm2) for x in places)


def flexibility_by_kind(beam: Beam) -> np.ndarray:
    """Computes the tip's flexibility for each of the six ways in which a bar gives.

    Args:
        beam: The bar.

    Returns:
        (6, 6, 6): kind, axial, shear y, shear z, torsion, bending y, bending z; then motion (3 displacements, 3 turns)
        of the tip by the wrench (3 forces, 3 moments) on it, axes of the bar; mm/N, rad/N, rad/(N mm). The sum over
        kinds is the flexibility.

    Source:
        Unit load method (Timoshenko and Gere, Mechanics of Materials; Timoshenko's shear): at the distance d before
        the tip the section bears the force F and the moment M + d x cross F.
    """
    found = np.zeros((6, 6, 6))
    beyond = 0.0
    for piece in reversed(beam.slices):
        s, e, g = piece.section, piece.youngs_N_mm2, piece.shear_N_mm2
        rigidity = np.array(
            [
                e * s.area_mm2,
                g * s.shear_y_mm2,
                g * s.shear_z_mm2,
                g * s.torsion_mm4,
                e * s.about_y_mm4,
                e * s.about_z_mm4,
            ]
        )
        low, high = beyond, beyond + piece.length_mm
        # what a section bears is at most linear in d: Simpson's rule is exact in a slice
        for d, weight in ((low, 1 / 6), ((low + high) / 2, 4 / 6), (high, 1 / 6)):
            carried = np.eye(6)
            carried[4, 2], carried[5, 1] = -d, d
            found += weight * piece.length_mm * carried[:, :, None] * carried[:, None, :] / rigidity[:, None, None]
        beyond = high
    return beam.factor * found


def flexibility(beam: Beam) -> np.ndarray:
    """Computes the flexibility of a bar's tip, (6, 6), see `flexibility_by_kind`."""
    return flexibility_by_kind(beam).sum(axis=0)
