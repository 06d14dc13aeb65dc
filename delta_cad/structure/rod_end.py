"""What a rod's metal end adds to the flexibility of its ball joint along the rod, and what its springs do to it."""

from __future__ import annotations

from math import pi

import numpy as np

from delta_cad.dimensions.forearm import GUSSET, LINER_GLUE_MM, ForearmDimensions

SLICES = 40  # from the ball's centre to the tube: within 2 % of ever finer ones
_LINES = 200  # on which a section is summed, along and across
# What finite elements find beyond a bar whose sections stay plane: the cup is as high as it is long, so that its top,
# where the ball presses, shears against its sides. Of balls of 6 and 8 mm; see the tests.
_DEEP = 3.0


def section(f: ForearmDimensions, x_mm: float) -> tuple[float, float, float]:
    """Computes a cross-section of a rod's end, square to the rod.

    Args:
        f: The rods.
        x_mm: From the ball's centre along the rod, before the spigot.

    Returns:
        area: mm^2.
        aside: Of its middle from the rod's axis, mm.
        second: Second moment about its middle, against bending towards the pole, mm^4.
    """
    rod, outer, inner = f.tube_outer_mm / 2, f.cup_radius_mm, f.liner_radius_mm + LINER_GLUE_MM
    y = np.linspace(-rod, outer, _LINES)[:, None]
    z = np.linspace(-outer, outer, _LINES)
    along, across = (share * outer for share in GUSSET)
    slope = (across - rod) / (f.shoulder_mm - 1.0 - along)
    top = across - slope * max(x_mm - along, 0.0)
    above, off = y > f.lip_mm, x_mm**2 + y**2 + z**2
    gusset = above & (np.abs(z) < rod) & (y < top) & (x_mm < f.shoulder_mm - 1.0)
    stem = (np.abs(y) < rod) & (np.abs(z) < rod) & (x_mm > f.stem_mm)
    metal = (((off < outer**2) & above) | gusset | stem) & (off > inner**2)
    cell = float((y[1, 0] - y[0, 0]) * (z[1] - z[0]))
    heights = np.broadcast_to(y, metal.shape)[metal]
    return cell * len(heights), float(heights.mean()), cell * float(((heights - heights.mean()) ** 2).sum())


def end_mm_N(f: ForearmDimensions, youngs_N_mm2: float) -> float:
    """Computes how far a rod's metal end gives along the rod for 1 N, from the ball's centre to the tube, mm/N.

    The force runs along the rod's axis, past the middle of the cup and its gusset, which lie aside of it and bend.

    Args:
        f: The rods.
        youngs_N_mm2: Of the metal.

    Source:
        Bar under an eccentric force, sum of `(1 / A + e^2 / I) dx / E` (Timoshenko and Gere, Mechanics of Materials),
        times `_DEEP`; the spigot's first diameter, before the bond takes the force over.
    """
    step = f.shoulder_mm / SLICES
    total = 0.0
    for k in range(SLICES):
        area, aside, second = section(f, (k + 0.5) * step)
        total += step * (1.0 / area + aside**2 / second)
    spigot = pi / 4.0 * f.spigot_diameter_mm**2
    return (_DEEP * total + f.spigot_diameter_mm / spigot) / youngs_N_mm2


def spigot_bending_N_mm2(f: ForearmDimensions, rod_N: np.ndarray) -> np.ndarray:
    """Computes the largest stress in a rod's spigot where it leaves the end: the springs' preload bends it for ever.

    Args:
        f: The rods.
        rod_N: (...) force of the rod.

    Returns:
        (...) `32 P x / (pi d^3) + 4 F / (pi d^2)`, N/mm^2, x from the ball to the tube.
    """
    d = f.spigot_diameter_mm
    bending = 32.0 * _spigot_moment_N_mm(f) / (pi * d**3)
    return bending + 4.0 * np.abs(rod_N) / (pi * d**2)


def _spigot_moment_N_mm(f: ForearmDimensions) -> float:
    """Computes the moment that the springs' preload puts into a rod where its tube begins, N mm."""
    return f.joint.pressed_max_N * f.shoulder_mm


def bond_tilt_N_mm2(f: ForearmDimensions, rod_N: np.ndarray) -> np.ndarray:
    """Computes the largest stress in the bond of a spigot: the preload's moment tilts it, the rod's force shears it.

    Args:
        f: The rods.
        rod_N: (...) force of the rod.

    Returns:
        (...) N/mm^2, `6 M / (d b^2)` across and F / (pi d b) along the bond of length b, as squares.
    """
    d, b = f.spigot_diameter_mm, f.spigot_length_mm
    across = 6.0 * _spigot_moment_N_mm(f) / (d * b**2)
    return np.hypot(across, rod_N / (pi * d * b))


def contact_N_mm2(f: ForearmDimensions, load_N: np.ndarray) -> np.ndarray:
    """Computes the largest pressure upon the plastic of a cup, (...) N/mm^2, for what presses the ball in it, (...) N.

    Source:
        Hertz with the largest clearance, as in `joint_dimensions`: `(6 P E*^2 / (pi^3 R_e^2))^(1/3)`.
    """
    j = f.joint
    effective = j.ball_radius_mm * (j.ball_radius_mm + j.clearance_mm) / j.clearance_mm
    return np.cbrt(6.0 * np.abs(load_N) * j.pair_N_mm2**2 / (pi**3 * effective**2))


def joint_N_mm(f: ForearmDimensions, youngs_N_mm2: float) -> float:
    """Computes the stiffness of a ball joint with its rod's end, along the rod at rest, either way.

    Args:
        f: The rods.
        youngs_N_mm2: Of the metal of a rod's end.

    Returns:
        N/mm.
    """
    return 1.0 / (1.0 / f.joint.stiffness_radial_N_mm + end_mm_N(f, youngs_N_mm2))
