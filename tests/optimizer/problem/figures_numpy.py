"""The figures of `optimizer.problem.evaluator` in NumPy: the formulas to read, and the oracle of the compiled ones."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from delta_cad.mechanism.geometry import VERTICAL
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.friction import HandleFriction, worst_of_rows
from delta_cad.mechanism.limits.position_step import longest_sum
from optimizer.problem.evaluator import Figures
from optimizer.problem.variables import completed

TINY = 1e-75  # least w / L_B that is divided by


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
        outward: (D, 1, 3 chains, 3) unit vectors along the radii.
        sideways: (D, 1, 3 chains, 3) unit vectors along the shoulder axes.
    """

    closure: np.ndarray
    arms: np.ndarray
    radial: np.ndarray
    along: np.ndarray
    vertical: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    outward: np.ndarray
    sideways: np.ndarray

    @property
    def forearms(self) -> np.ndarray:
        """(D, K, 3, 3) unit vectors from elbow to wrist; shorter or longer beyond the reach."""
        flat = self.radial[..., None] * self.outward + self.along[..., None] * self.sideways
        return flat + self.vertical[..., None] * VERTICAL

    @property
    def elbows(self) -> np.ndarray:
        """(D, K, 3, 3) unit vectors along which the elbows move."""
        return self.cos[..., None] * VERTICAL - self.sin[..., None] * self.outward


class NumpyFigures(Figures):
    """The same figures; those that are computed when they are needed in NumPy, too."""

    def couple_index(self) -> np.ndarray:
        found = rods(self.designs, self.points)
        couples = found.vertical[..., None] * found.outward - found.radial[..., None] * VERTICAL  # t x s
        return np.linalg.svd(couples, compute_uv=False)[..., 2]

    def inverse_friction(self, sources: HandleFriction) -> np.ndarray:
        found, L_A, L_B = rods(self.designs, self.points), *(self.designs[:, k, None, None] for k in (0, 1))
        rates = found.forearms / (L_A * np.maximum(found.arms / L_B, TINY))[..., None]  # of the joints, 1 / m
        return np.where(self.closure < 0.0, self.closure, 1.0 / worst_of_rows(rates, sources))

    def scaled_step(self) -> np.ndarray:
        found, L_A, L_B = rods(self.designs, self.points), *(self.designs[:, k, None, None] for k in (0, 1))
        return longest_sum((L_A * found.arms / L_B)[..., None] * _faces(found.forearms))

    def mass_ratio(self, inertia: HandleInertia) -> np.ndarray:
        L_A, L_B = (self.designs[:, k, None] for k in (0, 1))
        found = rods(self.designs, self.points)
        n = found.forearms / np.maximum(found.arms / L_B[..., None], TINY)[..., None]
        mixed = np.einsum("...ia,...ib->...ab", n, found.elbows)
        at_elbow = (inertia.elbow_mass + inertia.joint_inertia / L_A**2)[..., None, None]
        moving = at_elbow * np.einsum("...ia,...ib->...ab", n, n)
        moving += inertia.cross_mass * (mixed + np.swapaxes(mixed, -1, -2))
        mass = inertia.carried_mass + np.linalg.eigvalsh(moving)[..., 2]
        return np.where(self.closure < 0.0, self.closure, inertia.carried_mass / mass)


def figures_numpy(designs: np.ndarray, points: np.ndarray, conditioning: bool = True, angles: bool = True) -> Figures:
    """Computes the figures in NumPy; arguments and result as `evaluator.figures`."""
    designs = completed(designs)
    L_A, L_B = designs[:, 0, None, None], designs[:, 1, None, None]
    found = rods(designs, points)
    s, w = found.forearms, found.arms
    faces = _faces(s)
    determinant = (s[..., 0, :] * faces[..., 0, :]).sum(axis=-1)
    moment = (L_A * w / L_B * np.sqrt((faces * faces).sum(axis=-1))).max(axis=-1)
    closure = (found.closure / (L_B * L_B)).min(axis=-1)
    theta = np.arctan2(found.sin, found.cos) if angles else np.zeros_like(w)
    quality = _quality(s, w / L_B, determinant, closure) if conditioning else np.ones_like(closure)
    return NumpyFigures(closure, determinant, moment, quality, theta.min(-1), theta.max(-1), designs, points)


def rods(designs: np.ndarray, points: np.ndarray) -> Rods:
    """Computes the rods of every design at every point; designs and points are those of `figures`."""
    L_A, L_B, R, r, H, L, shift, c, middle = (designs[:, k, None] for k in range(9))
    x, y, z = middle + L * points[..., 0], L * points[..., 1], H + L * (1.0 + points[..., 2])
    p = np.stack(np.broadcast_arrays(x, y, z), axis=-1)  # (D, K, 3)
    azimuth = np.arccos(c) * [0.0, 1.0, -1.0]  # (D, 3 chains)
    azimuth = np.where(c == -0.5, np.array([0.0, 2.0, -2.0]) * np.pi / 3.0, azimuth)
    outward = np.stack([np.cos(azimuth), np.sin(azimuth), np.zeros_like(azimuth)], axis=-1)[:, None]
    sideways = np.cross(VERTICAL, outward)
    L_A, L_B, a = L_A[..., None], L_B[..., None], (R - r + shift * [0.0, 1.0, 1.0])[:, None]
    q = (p[..., None, :] * outward).sum(axis=-1) - a  # (D, K, 3 chains)
    t = (p[..., None, :] * sideways).sum(axis=-1)
    z = p[..., 2:]
    rho2 = np.maximum(q * q + z * z, np.finfo(float).tiny)
    m = (rho2 + t * t + L_A * L_A - L_B * L_B) / (2.0 * L_A)
    w2 = rho2 - m * m
    w = np.sqrt(np.maximum(w2, 0.0))
    cos, sin = (q * m + z * w) / rho2, (z * m - q * w) / rho2
    return Rods(w2, w, (q - L_A * cos) / L_B, t / L_B, (z - L_A * sin) / L_B, cos, sin, outward, sideways)


def _faces(s: np.ndarray) -> np.ndarray:
    """The cross products of each two of three vectors, (..., 3, 3)."""
    return np.stack([np.cross(s[..., i, :], s[..., j, :]) for i, j in ((1, 2), (2, 0), (0, 1))], axis=-2)


def _quality(s: np.ndarray, w: np.ndarray, determinant: np.ndarray, closure: np.ndarray) -> np.ndarray:
    """The signed 1 / kappa from the rows s_i / w_i of the inverse Jacobian times w_1 w_2 w_3: no division."""
    others = np.stack([w[..., 1] * w[..., 2], w[..., 2] * w[..., 0], w[..., 0] * w[..., 1]], axis=-1)
    rows = s * others[..., None]
    values = np.linalg.eigvalsh(rows @ np.swapaxes(rows, -1, -2))
    largest = np.where(values[..., 2] > 0.0, values[..., 2], 1.0)
    ratio = np.sqrt(np.maximum(values[..., 0], 0.0) / largest)
    return np.where(closure < 0.0, closure, np.sign(determinant) * ratio)
