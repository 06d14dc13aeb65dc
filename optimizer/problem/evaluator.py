"""Figures of many designs at many points of their cubes: continuous everywhere, without exceptions.

A point is given in the coordinates of its cube, c in [-1, 1]^3, and moves with the design:
`x = x_c + L c_x`, `y = L c_y`, `z = H + L (1 + c_z)`. Formulas: delta_cad/mechanism/README.md (1)-(7), (13)-(18).
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.friction import HandleFriction
from optimizer.problem.compiled import (
    figures_compiled,
    fill_couple_index,
    fill_inverse_friction,
    fill_mass_ratio,
    fill_scaled_step,
    filled,
)
from optimizer.problem.variables import completed

# (1, 3) the cube's centre: a determinant of another sign there than on the surface hides a singularity.
CENTRE = np.zeros((1, 3))


class Figures(NamedTuple):
    """Figures of D designs at K points each; every array is (D, K).

    Where a chain cannot be closed, its w is taken as 0 and the forearm as what is left, so that all figures continue.

    Attributes:
        closure: Smallest w_i^2 / L_B^2 of the chains; negative where one cannot be closed.
        determinant: det S / L_B^3, positive with the platform above the elbows.
        moment: Largest torque arm of the chains times |det S| / L_B^3, m: torque = force moment / |determinant|.
        quality: 1 / kappa with the sign of the determinant; 0 on both singularities, the closure where negative.
        shoulder_min: Smallest shoulder angle of the chains, rad.
        shoulder_max: Largest shoulder angle of the chains, rad.
        designs: (D, 9) the designs, from which further figures are computed when they are needed.
        points: (K, 3) or (D, K, 3) likewise.

    What was not wanted holds a constant: 1 as `quality`, 0 as angles.
    """

    closure: np.ndarray
    determinant: np.ndarray
    moment: np.ndarray
    quality: np.ndarray
    shoulder_min: np.ndarray
    shoulder_max: np.ndarray
    designs: np.ndarray
    points: np.ndarray

    def folds(self) -> np.ndarray:
        """Computes the least cosine (D, K) between a chain's arm and its rods, -1 folded, by the law of cosines."""
        L_A, L_B, _, _, H, L, _, _, offset = (self.designs[:, k, None] for k in range(9))
        x, y, z = offset + L * self.points[..., 0], L * self.points[..., 1], H + L * (1.0 + self.points[..., 2])
        a, other, c, s = (part[:, None] for part in _placement(self.designs))
        square, towards = x * x + y * y + z * z, s * np.abs(other * y) + c * other * x  # the nearer of chains 1 and 2
        wrist2 = np.minimum(square + a * a - 2.0 * (a * x), square + other * other - 2.0 * towards)
        return (wrist2 - L_A * L_A - L_B * L_B) / (2.0 * L_A * L_B)

    def couple_index(self) -> np.ndarray:
        """Computes the couple index (D, K) of the chains as they are continued beyond their reach."""
        return filled(fill_couple_index, self.designs, _placed(self.points))

    def inverse_friction(self, sources: HandleFriction) -> np.ndarray:
        """Computes 1 / friction in the direction of most.

        Args:
            sources: Friction of drives and ball joints.

        Returns:
            (D, K) 1 / N, next to nothing at a fold; the closure where that is negative.
        """
        return filled(fill_inverse_friction, self.designs, _placed(self.points), *sources)

    def scaled_step(self) -> np.ndarray:
        """Computes the determinant times the longest way of the handle for joints that turn by 1 rad, (D, K) m."""
        return filled(fill_scaled_step, self.designs, _placed(self.points))

    def mass_ratio(self, inertia: HandleInertia) -> np.ndarray:
        """Computes the carried mass by the effective mass, 1 where nothing else moves.

        Returns:
            (D, K) 0 at a fold; the closure where that is negative.
        """
        masses = inertia.carried_mass, inertia.elbow_mass, inertia.cross_mass, inertia.joint_inertia
        return filled(fill_mass_ratio, self.designs, _placed(self.points), *masses)


def figures(designs: np.ndarray, points: np.ndarray, conditioning: bool = True, angles: bool = True) -> Figures:
    """Computes the figures of every design at every point.

    Args:
        designs: (D, 9) in the order of `VARIABLES`, SI units; or (D, 6), three-fold symmetric.
        points: (K, 3) or (D, K, 3) points in the coordinates of the cube, each in [-1, 1].
        conditioning: Whether `quality` is wanted; as dear as the first three together.
        angles: Whether the shoulder angles are wanted; they are the dearest.

    Returns:
        The figures, each (D, K).
    """
    points, designs = _placed(points), completed(designs)
    out = np.empty((len(designs), 6, points.shape[1]))
    figures_compiled(designs, points, conditioning, angles, out)
    closure, determinant, moment, quality, low, high = np.swapaxes(out, 0, 1)
    return Figures(closure, determinant, moment, quality, low, high, designs, points)


def _placed(points: np.ndarray) -> np.ndarray:
    """Points as (D or 1, K, 3)."""
    return points if points.ndim == 3 else points[None]


@lru_cache(maxsize=16)
def half_surface(n: int) -> np.ndarray:
    """Gives an even grid on the faces of the cube with y >= 0; the mechanism mirrors the other half.

    Args:
        n: Points along an edge, at least 2.

    Returns:
        (K, 3) points in the coordinates of the cube; not writeable.
    """
    line = np.linspace(-1.0, 1.0, n)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    grid = grid[(np.abs(grid) == 1.0).any(axis=-1) & (grid[:, 1] >= 0.0)]
    grid.flags.writeable = False
    return grid


@lru_cache(maxsize=16)
def shared_points(n: int) -> np.ndarray:
    """Gives the surface grid and the centre, which every design shares.

    Returns:
        (K, 3) points in the coordinates of the cube; not writeable.
    """
    points = np.concatenate([half_surface(n), CENTRE])
    points.flags.writeable = False
    return points


def _placement(designs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Computes R - r of chain 0 and of the others, and cosine and sine of the azimuth of chain 1, each (D,)."""
    R, r, shift, c = designs[:, 2], designs[:, 3], designs[:, 6], designs[:, 7]
    return R - r, R + shift - r, c, np.sqrt((1.0 - c) * (1.0 + c))


def fold_points(designs: np.ndarray) -> np.ndarray:
    """Computes where chain 0 and chain 1, or its mirror, come nearest to their shoulder axes on the bottom face.

    With the surface grid and the centre, these points make the reach of a cube over the base plane exact: a chain is
    too short first in a corner, because what it reaches is convex, and folds first right above its shoulder, at
    u = R_i - r or as near to that as the cube comes, README (21) of the mechanism.

    Args:
        designs: (D, 9) in the order of `VARIABLES`, SI units; or (D, 6), three-fold symmetric.

    Returns:
        (D, 2, 3) points in the coordinates of each cube.
    """
    designs = completed(designs)
    a, other, c, s = _placement(designs)
    L = np.where(designs[:, 5] > 0.0, designs[:, 5], 1.0)
    middle = designs[:, 8] / L
    most = 1.0 + np.abs(middle)
    near, far = np.clip(a / L, -most, most), np.clip(other / L, -most, most)
    foot = np.full((len(designs), 2, 3), -1.0)
    foot[:, 0, 0], foot[:, 0, 1] = near - middle, 0.0
    foot[:, 1, 0], foot[:, 1, 1] = far * c - middle, np.abs(far * s)
    return np.clip(foot, -1.0, 1.0)
