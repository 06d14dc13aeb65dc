"""Kinematics of a delta whose bars begin and end in collars beside the joints' axes, sampled, without any proof.

In the plane in which an upper arm turns, elbow and wrist are `d + e` farther apart than the ends of the bars: with v
the wrist's distance from that plane and b the bars' length they are `rho = d + e + sqrt(b^2 - v^2)` apart in it, so
that a chain closes as one without collars whose forearm is `sqrt(rho^2 + v^2)` long. The bars push along themselves.
With collars of 0 all is as in `delta_cad.mechanism`.

Source: R. E. Stamper, A Three Degree of Freedom Parallel Manipulator with Only Translational Degrees of Freedom,
thesis, University of Maryland, 1997: the manipulator that libnifalcon computes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import kernel
from delta_cad.mechanism.errors import UnreachableError
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry, chain_coordinates
from delta_cad.mechanism.inverse import forearm_determinant


class _Pose(NamedTuple):
    """Angles and bars at positions; NaN where a chain cannot be closed.

    Attributes:
        theta: (..., 3 chains) rad.
        bars: (..., 3 chains, 3) from the elbow's end of the bars to the wrist's, m.
        lever: (..., 3 chains) component of a bar along the elbow's direction of motion times L_A, m^2.
        elbow: (..., 3 chains) angle between upper arm and the line from elbow to wrist, 0 stretched, rad.
        lean: (..., 3 chains) of the bars out of their chain's plane, rad.
    """

    theta: np.ndarray
    bars: np.ndarray
    lever: np.ndarray
    elbow: np.ndarray
    lean: np.ndarray


@dataclass(frozen=True)
class CollaredDelta:
    """A delta with collars.

    Attributes:
        geometry: Its lengths; the forearm's is that of the bars.
        collars: d + e, m.
    """

    geometry: DeltaGeometry
    collars: float

    def pose(self, p: np.ndarray) -> _Pose:
        """Computes angles and bars at positions (..., 3) in m, elbows outwards."""
        g, (q, t, z) = self.geometry, chain_coordinates(self.geometry, p)
        left = g.forearm_length**2 - t * t
        bar = np.sqrt(np.where(left >= 0.0, left, np.nan))  # in the arm's plane
        apart = self.collars + bar
        rho2, m, w2 = kernel.chain_closure.py_func(q, t, z, g.upper_arm_length, np.hypot(apart, t))
        w = np.sqrt(np.where(w2 >= 0.0, w2, np.nan))
        cos, sin = kernel.arm.py_func(q, z, np.where(rho2 > 0.0, rho2, np.nan), m, w)
        share = bar / np.where(apart > 0.0, apart, np.nan)
        out, up = share * (q - g.upper_arm_length * cos), share * (z - g.upper_arm_length * sin)
        bars = out[..., None] * g.radial + t[..., None] * g.tangential + up[..., None] * VERTICAL
        along = (out * cos + up * sin) / share
        elbow = np.arccos(np.clip(along / np.hypot(apart, t), -1.0, 1.0))
        return _Pose(np.arctan2(sin, cos), bars, share * w * g.upper_arm_length, elbow, np.arctan2(t, bar))

    def jacobian(self, p: np.ndarray) -> np.ndarray:
        """Computes (..., 3 axes, 3 chains) m/rad, `v = J theta_dot`; NaN where a chain cannot be closed."""
        pose = self.pose(p)
        rows = pose.bars / np.where(pose.lever == 0.0, np.nan, pose.lever)[..., None]
        closed = np.asarray(np.isfinite(rows).all(axis=(-2, -1)) & (forearm_determinant(pose.bars) != 0.0))
        found = np.linalg.inv(np.where(closed[..., None, None], rows, np.eye(3)))
        return np.where(closed[..., None, None], found, np.nan)

    def conditioning(self, p: np.ndarray) -> np.ndarray:
        """Computes (...) condition number of the Jacobian."""
        values = self.singular_values(p)
        return values[..., 0] / values[..., 2]

    def singular_values(self, p: np.ndarray) -> np.ndarray:
        """Computes (..., 3) singular values of the Jacobian, descending, m/rad."""
        found = self.jacobian(p)
        closed = np.asarray(np.isfinite(found).all(axis=(-2, -1)))
        values = np.linalg.svd(np.where(closed[..., None, None], found, np.eye(3)), compute_uv=False)
        return np.where(closed[..., None], values, np.nan)

    def worst_torque(self, p: np.ndarray, force: float) -> np.ndarray:
        """Computes (..., 3 chains) largest torque over all directions of a force, N m."""
        return force * np.linalg.norm(self.jacobian(p), axis=-2)

    def in_reach(self, p: np.ndarray) -> np.ndarray:
        """Decides (...) whether each position is reached in the machine's own assembly, platform above the elbows."""
        margins = self.margins(p)
        return (p[..., 2] > 0.0) & (margins[0] > 0.0) & (margins[1] > 0.0)

    def margins(self, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Computes (...) least lever of a chain, m^2, and determinant of the bars' directions: positive in reach."""
        pose = self.pose(p)
        return pose.lever.min(axis=-1), forearm_determinant(pose.bars) / self.geometry.forearm_length**3

    def require(self, p: np.ndarray) -> None:
        """Refuses positions (n, 3) of which one is not reached.

        Raises:
            UnreachableError: The message names the position.
        """
        bad = p[~self.in_reach(p)]
        if len(bad):
            x, y, z = bad[0] * MM_PER_M
            raise UnreachableError(
                f"position ({x:.3f}, {y:.3f}, {z:.3f}) mm is not reached with elbows outwards and the platform above "
                "them; make the cube smaller or move it"
            )
