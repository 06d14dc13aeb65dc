"""Identification of the prototype's masses from the published holding torques, and what these leave open.

With the paper's point masses and gravity along -z the torque of joint i is
`g (W (J^T z)_i + E L_A cos theta_i)`, `W = m1 + 3 m3 / 2` on the wrists and `E = (m2 + m3) / 2` on each elbow. The
three masses enter by these two sums alone: moving `dm3` into each forearm, `3 dm3 / 2` out of the platform and `dm3`
out of each upper arm changes no torque at any position. So torques at rest identify two sums, and no third.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import minimize_scalar

from delta_cad.common.units import GRAVITY_M_S2, MM_PER_M
from delta_cad.drive.masses import PointMasses
from delta_cad.mechanism import DeltaGeometry
from haptics.gravity import gravity_torque, published

# Where the origin of the handle's travel is looked for over the base plane; not printed either.
_ORIGIN_MM = (50.0, 100.0)


@dataclass(frozen=True)
class _Identified:
    """Masses fitted to the published torques.

    Attributes:
        at_wrists_kg: W, platform and one and a half forearm pairs.
        at_elbow_kg: E, half an upper arm and half a forearm pair.
        origin_height_m: Height of the origin of the positions over the base plane.
        torques_N_m: (2 positions, 3 chains) fitted.
        published_N_m: (2, 3) printed.
        rms_N_m: Root mean square of their difference.
        spread_N_m: Standard deviation of the three torques at the origin, which symmetry wants equal: the noise.
        rank: Number of combinations of the three masses that the torques determine.
    """

    at_wrists_kg: float
    at_elbow_kg: float
    origin_height_m: float
    torques_N_m: np.ndarray
    published_N_m: np.ndarray
    rms_N_m: float
    spread_N_m: float
    rank: int


def identify() -> _Identified:
    """Least squares of the two mass sums and the origin's height to the six published torques.

    Source:
        [RCIM2018] section on gravity compensation; positions, azimuths and torques in `published`.
    """
    g = DeltaGeometry(**{name: length / MM_PER_M for name, length in published.GRAVITY_LENGTHS_MM.items()})
    torques = np.array(published.GRAVITY_TORQUES_MN_M) / 1000.0

    def columns(height: float) -> np.ndarray:
        """(6, 3) torque per kg of m1, m2 and m3."""
        p = _positions(height)
        unit = [PointMasses(*row) for row in np.eye(3)]
        down = [0.0, 0.0, -GRAVITY_M_S2]
        return np.stack([gravity_torque(g, masses, p, down).ravel() for masses in unit], axis=-1)

    def sums(height: float) -> tuple[np.ndarray, np.ndarray]:
        by_mass = columns(height)
        by_sum = np.stack([by_mass[:, 0], 2.0 * by_mass[:, 1]], axis=-1)  # W alone is m1; E alone is m2 / 2
        return by_sum, np.linalg.lstsq(by_sum, torques.ravel(), rcond=None)[0]

    def misfit(height: float) -> float:
        by_sum, masses = sums(height)
        return float(((by_sum @ masses - torques.ravel()) ** 2).sum())

    low, high = (height / MM_PER_M for height in _ORIGIN_MM)
    best: Any = minimize_scalar(misfit, bounds=(low, high), method="bounded", options={"xatol": 1e-7})
    height = float(best.x)
    by_sum, masses = sums(height)
    fitted = (by_sum @ masses).reshape(torques.shape)
    return _Identified(
        at_wrists_kg=float(masses[0]),
        at_elbow_kg=float(masses[1]),
        origin_height_m=height,
        torques_N_m=fitted,
        published_N_m=torques,
        rms_N_m=float(np.sqrt(((fitted - torques) ** 2).mean())),
        spread_N_m=float(torques[0].std(ddof=1)),
        rank=int(np.linalg.matrix_rank(columns(height))),
    )


def _positions(height: float) -> np.ndarray:
    """(2, 3) the published positions in our frame, whose chain 0 is along x, m."""
    turn = -np.radians(published.GRAVITY_AZIMUTHS_DEG[0])
    c, s = np.cos(turn), np.sin(turn)
    at = np.array(published.GRAVITY_POSITIONS_MM) / MM_PER_M
    return at @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]).T + [0.0, 0.0, height]
