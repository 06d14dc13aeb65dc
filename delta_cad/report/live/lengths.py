"""A mechanism of chosen lengths: its skeleton, its figures at a position and over its cube. No solids, no server."""

from __future__ import annotations

from dataclasses import dataclass, fields
from itertools import product

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.mechanism import DeltaGeometry, closure_margin
from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.inverse import elbow_positions, joint_angles, rod_lean, wrist_positions
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.statics import conditioning, worst_joint_torque
from delta_cad.report.figures import with_unit

GRID = 9  # positions along an edge of the cube
_ROUNDED = 4  # significant digits of a figure


@dataclass(frozen=True)
class Lengths:
    """What sliders change, mm, as in the design file; where chains 1 and 2 and the cube's middle stand is the design's.

    `side_shift_mm`, `side_cosine` and `centre_x_mm` are those of `DeltaGeometry` and `Cube`.
    """

    base_radius_mm: float
    platform_radius_mm: float
    upper_arm_length_mm: float
    forearm_length_mm: float
    bottom_height_mm: float
    half_side_mm: float
    side_shift_mm: float = 0.0
    side_cosine: float = THREE_FOLD
    centre_x_mm: float = 0.0

    @classmethod
    def of(cls, design: Design) -> Lengths:
        """Gives those of a design."""
        g = design.geometry
        placed = {"side_shift_mm": g.side_shift * MM_PER_M, "side_cosine": g.side_cosine}
        placed["centre_x_mm"] = design.workspace.centre_x * MM_PER_M
        stated = {**vars(design.mechanism), **vars(design.cube), **placed}
        return cls(**{field.name: stated[field.name] for field in fields(cls)})

    @property
    def geometry(self) -> DeltaGeometry:
        """The mechanism, metres."""
        lengths = (self.base_radius_mm, self.platform_radius_mm, self.upper_arm_length_mm, self.forearm_length_mm)
        placed = {"side_shift": self.side_shift_mm / MM_PER_M, "side_cosine": self.side_cosine}
        return DeltaGeometry(*(length / MM_PER_M for length in lengths), **placed)

    @property
    def farthest_mm(self) -> float:
        """Largest base radius."""
        return self.base_radius_mm + max(self.side_shift_mm, 0.0)

    @property
    def centre_mm(self) -> np.ndarray:
        """(3,) centre of the cube."""
        return np.array([self.centre_x_mm, 0.0, self.bottom_height_mm + self.half_side_mm])

    def within(self, p_mm: np.ndarray) -> np.ndarray:
        """Gives the position of the cube that is nearest to one, (3,) mm."""
        return np.clip(p_mm, self.centre_mm - self.half_side_mm, self.centre_mm + self.half_side_mm)

    def reaches(self, p_mm: np.ndarray) -> bool:
        """Decides whether every chain can be closed at positions (..., 3), mm."""
        return bool((closure_margin(self.geometry, np.asarray(p_mm) / MM_PER_M) >= 0.0).all())

    def positions_mm(self) -> np.ndarray:
        """(n, 3) grid over the cube, its corners among them, mm."""
        steps = np.linspace(-self.half_side_mm, self.half_side_mm, GRID)
        return self.centre_mm + np.array(list(product(steps, steps, steps)))

    def cube_edges(self) -> np.ndarray:
        """(12, 2, 3) edges of the cube, mm."""
        corners = [np.array(signs) for signs in product((-1.0, 1.0), repeat=3)]
        pairs = [(a, b) for a in corners for b in corners if (a < b).sum() == 1 and (a != b).sum() == 1]
        return self.centre_mm + self.half_side_mm * np.array(pairs)


def skeleton(lengths: Lengths, width_mm: float, p_mm: np.ndarray) -> dict[str, np.ndarray]:
    """Computes the lines of a mechanism at a position within its reach.

    Args:
        lengths: The mechanism.
        width_mm: Distance of the two rods of a chain.
        p_mm: (3,) platform centre.

    Returns:
        "base", "arms", "rods", "platform" -> (n, 2, 3) ends of its lines, base frame, mm.
    """
    g, p = lengths.geometry, np.asarray(p_mm) / MM_PER_M
    theta = joint_angles(g, p)
    elbows, wrists = MM_PER_M * elbow_positions(g, theta), MM_PER_M * wrist_positions(g, p)
    shoulders = MM_PER_M * g.base_radii[:, None] * g.radial
    side = width_mm / 2.0 * g.tangential
    rods = [(elbows[i] + s * side[i], wrists[i] + s * side[i]) for i in range(3) for s in (-1.0, 1.0)]
    bars = [(at[i] - side[i], at[i] + side[i]) for i in range(3) for at in (elbows, wrists)]
    around = [(k, (k + 1) % 3) for k in range(3)]
    return {
        "base": np.array([(shoulders[a], shoulders[b]) for a, b in around]),
        "arms": np.array([(shoulders[i], elbows[i]) for i in range(3)]),
        "rods": np.array(rods + bars),
        "platform": np.array([(wrists[a], wrists[b]) for a, b in around] + [(w, p * MM_PER_M) for w in wrists]),
    }


@dataclass(frozen=True)
class Reading:
    """A figure as text: at the handle, and its worst over the cube."""

    words: str
    here: str
    worst: str


def readings(lengths: Lengths, force_N: float, inertia: HandleInertia | None, p_mm: np.ndarray) -> list[Reading]:
    """Tells the figures at a position and their worst over the cube; nothing where a chain cannot be closed.

    Args:
        lengths: The mechanism.
        force_N: The force of which the torque is told.
        inertia: What moves, of the design's own machine; None where it is not known yet.
        p_mm: (3,) platform centre.
    """
    g, at, over = lengths.geometry, np.asarray(p_mm) / MM_PER_M, lengths.positions_mm() / MM_PER_M
    if not lengths.reaches(p_mm):
        return []
    whole = lengths.reaches(lengths.positions_mm())

    def reading(words: str, unit: str, values: np.ndarray, all_: np.ndarray) -> Reading:
        here = ", ".join(f"{value:.{_ROUNDED}g}" for value in np.atleast_1d(values))
        worst = with_unit(float(all_.max()), unit, _ROUNDED) if whole else "out of reach"
        return Reading(words, f"{here} {unit}".strip(), worst)

    angles, leans = np.degrees(joint_angles(g, over)), np.degrees(np.abs(rod_lean(g, over)))
    span = f"{angles.min():.{_ROUNDED}g} to {angles.max():.{_ROUNDED}g} deg" if whole else "out of reach"
    here = ", ".join(f"{value:.{_ROUNDED}g}" for value in np.degrees(joint_angles(g, at)))
    torque = f"torque for {force_N:g} N"
    found = [
        reading("conditioning", "", conditioning(g, at), conditioning(g, over)),
        reading(torque, "N m", worst_joint_torque(g, at, force_N), worst_joint_torque(g, over, force_N)),
        reading("lean of the rods", "deg", np.degrees(rod_lean(g, at)), leans),
        Reading("shoulders", f"{here} deg", span),
    ]
    if inertia is not None:
        masses = effective_mass(g, at, inertia), effective_mass(g, over, inertia)
        found.insert(2, reading("effective mass", "kg", *masses))
    return found
