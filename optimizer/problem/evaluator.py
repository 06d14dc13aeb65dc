"""Figures of many designs at many points of their cubes: continuous everywhere, without exceptions.

A point is given in the coordinates of its cube, c in [-1, 1]^3, and moves with the design:
`x = L c_x`, `y = L c_y`, `z = H + L (1 + c_z)`. Formulas: delta_cad/mechanism/README.md (1)-(7), (13)-(18).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from importlib.util import find_spec
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism.geometry import RADIAL, SIN_60, TANGENTIAL, VERTICAL
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.couple_index import least_singular_value
from delta_cad.mechanism.limits.friction import HandleFriction, worst_of_rows
from delta_cad.mechanism.limits.position_step import farthest

# Names of the six numbers of a design, in the paper's order L_A, L_B, R, r, H, L.
VARIABLES = (
    "upper_arm_length",
    "forearm_length",
    "base_radius",
    "platform_radius",
    "bottom_height",
    "half_side",
)

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
        designs: (D, 6) the designs, from which further figures are computed when they are needed.
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

    def rods(self) -> Rods:
        """Computes the rods of the chains that the figures are of."""
        return _rods(self.designs, self.points)

    def folds(self) -> np.ndarray:
        """Computes the least cosine (D, K) between a chain's arm and its rods, -1 folded, by the law of cosines."""
        L_A, L_B, R, r, H, L = (self.designs[:, k, None] for k in range(6))
        x, y, z = L * self.points[..., 0], L * self.points[..., 1], H + L * (1.0 + self.points[..., 2])
        a = R - r
        nearest = np.maximum(a * x, SIN_60 * np.abs(a * y) - 0.5 * a * x)  # a times the way towards a chain
        wrist2 = x * x + y * y + z * z + a * a - 2.0 * nearest
        return (wrist2 - L_A * L_A - L_B * L_B) / (2.0 * L_A * L_B)

    def couple_index(self) -> np.ndarray:
        """Computes the couple index (D, K) of the chains as they are continued beyond their reach."""
        if _compiled() is None:
            rods = self.rods()
            return least_singular_value(rods.radial, rods.vertical)
        from optimizer.problem.compiled import couple_index_compiled

        return couple_index_compiled(self.designs, _placed(self.points))

    def ease(self, rubs: HandleFriction) -> np.ndarray:
        """Computes 1 / friction in the direction of most.

        Args:
            rubs: What rubs.

        Returns:
            (D, K) 1 / N, next to nothing at a fold; the closure where that is negative.
        """
        if _compiled() is not None:
            from optimizer.problem.compiled import ease_compiled

            return ease_compiled(self.designs, _placed(self.points), rubs)
        chains, L_A, L_B = _chains(self.designs, self.points), *(self.designs[:, k, None, None] for k in (0, 1))
        rates = chains.forearms / (L_A * np.maximum(chains.arms / L_B, TINY))[..., None]  # of the joints, 1 / m
        return np.where(self.closure < 0.0, self.closure, 1.0 / worst_of_rows(rates, rubs))

    def farthest(self) -> np.ndarray:
        """Computes the determinant times the longest way of the handle for joints that turn by 1 rad, (D, K) m."""
        if _compiled() is not None:
            from optimizer.problem.compiled import farthest_compiled

            return farthest_compiled(self.designs, _placed(self.points))
        chains, L_A, L_B = _chains(self.designs, self.points), *(self.designs[:, k, None, None] for k in (0, 1))
        s = chains.forearms
        faces = np.stack([_cross(s, 1, 2), _cross(s, 2, 0), _cross(s, 0, 1)], axis=-2)
        return farthest((L_A * chains.arms / L_B)[..., None] * faces)

    def lightness(self, inertia: HandleInertia) -> np.ndarray:
        """Computes the carried mass by the effective mass, 1 where nothing else moves.

        Args:
            inertia: What moves.

        Returns:
            (D, K) 0 at a fold; the closure where that is negative.
        """
        if _compiled() is not None:
            from optimizer.problem.compiled import lightness_compiled

            return lightness_compiled(self.designs, _placed(self.points), inertia)
        L_A, L_B = (self.designs[:, k, None] for k in (0, 1))
        chains = _chains(self.designs, self.points)
        n = chains.forearms / np.maximum(chains.arms / L_B[..., None], TINY)[..., None]
        mixed = np.einsum("...ia,...ib->...ab", n, chains.elbows)
        at_elbow = (inertia.elbow_mass + inertia.joint_inertia / L_A**2)[..., None, None]
        moving = at_elbow * np.einsum("...ia,...ib->...ab", n, n)
        moving += inertia.cross_mass * (mixed + np.swapaxes(mixed, -1, -2))
        mass = inertia.carried_mass + np.linalg.eigvalsh(moving)[..., 2]
        return np.where(self.closure < 0.0, self.closure, inertia.carried_mass / mass)


class Rods(NamedTuple):
    """The chains of D designs at K points in their own planes, w as 0 beyond the reach; each (D, K, 3 chains).

    Attributes:
        closure: w^2, m^2.
        arms: w, m.
        radial: Part of the unit vector from elbow to wrist along the radius; no unit vector beyond the reach.
        along: Its part along the shoulder axis.
        vertical: Its part along z.
        cos: Cosine of the shoulder angle.
        sin: Sine of the shoulder angle.
    """

    closure: np.ndarray
    arms: np.ndarray
    radial: np.ndarray
    along: np.ndarray
    vertical: np.ndarray
    cos: np.ndarray
    sin: np.ndarray


class Chains(NamedTuple):
    """The chains of D designs at K points, w as 0 beyond the reach.

    Attributes:
        closure: (D, K, 3) w^2, m^2.
        arms: (D, K, 3) w, m.
        forearms: (D, K, 3, 3) unit vectors from elbow to wrist; shorter or longer beyond the reach.
        elbows: (D, K, 3, 3) unit vectors along which the elbows move.
        cos: (D, K, 3) cosine of the shoulder angle.
        sin: (D, K, 3) sine of the shoulder angle.
    """

    closure: np.ndarray
    arms: np.ndarray
    forearms: np.ndarray
    elbows: np.ndarray
    cos: np.ndarray
    sin: np.ndarray


TINY = 1e-75  # least w / L_B that is divided by: the fourth power of what comes out is still a number


def figures(designs: np.ndarray, points: np.ndarray, conditioning: bool = True, angles: bool = True) -> Figures:
    """Computes the figures of every design at every point, compiled where numba is installed.

    Args:
        designs: (D, 6) lengths in the order of `VARIABLES`, m.
        points: (K, 3) or (D, K, 3) points in the coordinates of the cube, each in [-1, 1].
        conditioning: Whether `quality` is wanted; as dear as the first three together.
        angles: Whether the shoulder angles are wanted; they are the dearest.

    Returns:
        The figures, each (D, K).
    """
    compiled = _compiled()
    if compiled is None:
        return figures_numpy(designs, points, conditioning, angles)
    points = _placed(points)
    out = np.empty((len(designs), 6, points.shape[1]))
    compiled(designs, points, conditioning, angles, out)
    closure, determinant, moment, quality, low, high = np.swapaxes(out, 0, 1)
    return Figures(closure, determinant, moment, quality, low, high, designs, points)


def _placed(points: np.ndarray) -> np.ndarray:
    """Points as (D or 1, K, 3)."""
    return points if points.ndim == 3 else points[None]


@cache
def _compiled() -> Callable[[np.ndarray, np.ndarray, bool, bool, np.ndarray], None] | None:
    if find_spec("numba") is None:  # compiled functions load it when they are called, not when they are imported
        return None
    from optimizer.problem.compiled import figures_compiled

    return figures_compiled


def figures_numpy(designs: np.ndarray, points: np.ndarray, conditioning: bool = True, angles: bool = True) -> Figures:
    """Computes the figures in NumPy: the formulas to read, and what the compiled ones are tested against.

    Args:
        designs: (D, 6) lengths in the order of `VARIABLES`, m.
        points: (K, 3) or (D, K, 3) points in the coordinates of the cube, each in [-1, 1].
        conditioning: Whether `quality` is wanted.
        angles: Whether the shoulder angles are wanted.

    Returns:
        The figures, each (D, K).
    """
    L_A, L_B = designs[:, 0, None, None], designs[:, 1, None, None]
    chains = _chains(designs, points)
    s, w = chains.forearms, chains.arms
    faces = np.stack([_cross(s, 1, 2), _cross(s, 2, 0), _cross(s, 0, 1)], axis=-2)
    determinant = (s[..., 0, :] * faces[..., 0, :]).sum(axis=-1)
    moment = (L_A * w / L_B * np.sqrt((faces * faces).sum(axis=-1))).max(axis=-1)
    closure = (chains.closure / (L_B * L_B)).min(axis=-1)
    theta = np.arctan2(chains.sin, chains.cos) if angles else np.zeros_like(w)
    quality = _quality(s, w / L_B, determinant, closure) if conditioning else np.ones_like(closure)
    return Figures(closure, determinant, moment, quality, theta.min(axis=-1), theta.max(axis=-1), designs, points)


def _rods(designs: np.ndarray, points: np.ndarray) -> Rods:
    """Computes the rods of every design at every point; designs and points are those of `figures`."""
    L_A, L_B, R, r, H, L = (designs[:, k, None] for k in range(6))
    x, y, z = L * points[..., 0], L * points[..., 1], H + L * (1.0 + points[..., 2])
    p = np.stack(np.broadcast_arrays(x, y, z), axis=-1)  # (D, K, 3)
    L_A, L_B, a = L_A[..., None], L_B[..., None], (R - r)[..., None]
    q = p @ RADIAL.T - a  # (D, K, 3 chains)
    t = p @ TANGENTIAL.T
    z = p[..., 2:]
    rho2 = np.maximum(q * q + z * z, np.finfo(float).tiny)
    m = (rho2 + t * t + L_A * L_A - L_B * L_B) / (2.0 * L_A)
    w2 = rho2 - m * m
    w = np.sqrt(np.maximum(w2, 0.0))
    cos, sin = (q * m + z * w) / rho2, (z * m - q * w) / rho2
    return Rods(w2, w, (q - L_A * cos) / L_B, t / L_B, (z - L_A * sin) / L_B, cos, sin)


def _chains(designs: np.ndarray, points: np.ndarray) -> Chains:
    """Computes the chains of every design at every point; designs and points are those of `figures`."""
    w2, w, radial, along, vertical, cos, sin = _rods(designs, points)
    forearms = radial[..., None] * RADIAL + along[..., None] * TANGENTIAL + vertical[..., None] * VERTICAL
    elbows = cos[..., None] * VERTICAL - sin[..., None] * RADIAL
    return Chains(w2, w, forearms, elbows, cos, sin)


def _cross(s: np.ndarray, i: int, j: int) -> np.ndarray:
    u, v = s[..., i, :], s[..., j, :]
    return u[..., [1, 2, 0]] * v[..., [2, 0, 1]] - u[..., [2, 0, 1]] * v[..., [1, 2, 0]]


def _quality(s: np.ndarray, w: np.ndarray, determinant: np.ndarray, closure: np.ndarray) -> np.ndarray:
    """Computes the signed 1 / kappa from the rows s_i / w_i of the inverse Jacobian times w_1 w_2 w_3: no division."""
    others = np.stack([w[..., 1] * w[..., 2], w[..., 2] * w[..., 0], w[..., 0] * w[..., 1]], axis=-1)
    rows = s * others[..., None]
    values = np.linalg.eigvalsh(rows @ np.swapaxes(rows, -1, -2))
    largest = np.where(values[..., 2] > 0.0, values[..., 2], 1.0)
    ratio = np.sqrt(np.maximum(values[..., 0], 0.0) / largest)
    return np.where(closure < 0.0, closure, np.sign(determinant) * ratio)


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

    Args:
        n: Grid points along an edge.

    Returns:
        (K, 3) points in the coordinates of the cube; not writeable.
    """
    points = np.concatenate([half_surface(n), CENTRE])
    points.flags.writeable = False
    return points


def fold_points(designs: np.ndarray) -> np.ndarray:
    """Computes where chain 0 and chain 1, or its mirror, come nearest to their shoulder axes on the bottom face.

    With the surface grid and the centre, these points make the reach of a cube over the base plane exact: a chain is
    too short first in a corner, because what it reaches is convex, and folds first right above its shoulder, at
    u = R - r or as near to that as the cube comes, README (21) of the mechanism.

    Args:
        designs: (D, 6) lengths in the order of `VARIABLES`, m.

    Returns:
        (D, 2, 3) points in the coordinates of each cube.
    """
    a, L = designs[:, 2] - designs[:, 3], designs[:, 5]
    share = np.clip(a / np.where(L > 0.0, L, 1.0), -1.0, 1.0)[:, None, None]
    foot = share * RADIAL[None, :2]
    foot[..., 1] = np.abs(foot[..., 1])
    foot[..., 2] = -1.0
    return foot
