"""Reach: every chain closes, and keeps a distance from its fold."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, TERMS, add, at, constant, scale, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import EXCLUDED, INSIDE, Enclosure, keep, store
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import elbow_arm, reach_excess
from delta_cad.mechanism.limits.limit import FigureOfMerit, PoseLimit


def _elbow_arms(limit: Reach, g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """The elbow arm; where a chain is open, how far it is out of reach, as a negative number."""
    del limit
    w = elbow_arm(g, p)
    return np.where(np.isnan(w), -np.abs(reach_excess(g, p)), w)


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes w_i^2 less its least."""
    least = constant(k[n], k[n + 1])
    for i in range(3):
        store(out, row + i, subtract(at(pose, forms.W2 + i), least))


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds w_i^2 >= 0, and for each chain that it is not too far."""
    for i in range(3):
        count = keep(cuts, count, at(pose, forms.W2 + i))
        if count == EXCLUDED:
            return count
    for i in range(3):
        count = _far(pose, i, cuts, count)
        if count == EXCLUDED:
            return count
    return count


@compiled
def _far(pose, i, cuts, count):
    """Not too far: `L_A + sqrt(L_B^2 - t^2) - rho >= 0` is concave; its tangent at the middle has no error."""
    q, z, t = at(pose, forms.Q + i), at(pose, forms.Z), at(pose, forms.T + i)
    size = math.sqrt(q[0] * q[0] + z[0] * z[0])
    nq, nz = q[0] / size * INSIDE, z[0] / size * INSIDE
    t0 = max(abs(t[0]) - t[TERMS - 1], 0.0)
    lb = at(pose, forms.FOREARM_LENGTH)
    b = max(lb[0], 1.001 * t0)
    f = max(b / math.sqrt(b * b - t0 * t0), 1.0)
    g = math.sqrt(max(f * f - 1.0, 0.0))
    # l <= f L_B - t sqrt(f^2 - 1) for every f >= 1; g's rounding is that of f^2 - 1
    error = ROUND * t0 * (f * f / max(g, 1e-9) + g)
    room = subtract(add(at(pose, forms.UPPER_ARM), scale(f, lb)), constant(t0 * g, error))
    return keep(cuts, count, subtract(room, add(scale(nq, q), scale(nz, z))))


@dataclass(frozen=True)
class Reach(PoseLimit):
    """Smallest elbow arm w of every chain, m: reach, and the distance kept from its fold."""

    elbow_arm_min: float = 0.0

    name: ClassVar = "reach"
    first_step: ClassVar = True
    described: ClassVar = "reach of the whole cube"
    keys: ClassVar = {"elbow_arm_min": "elbow_arm_min_m"}
    figures: ClassVar = (
        FigureOfMerit("reach", "mm", _elbow_arms, "elbow_arm_min", (0.0, 10.0), upper=False, words="elbow arm"),
    )
    always: ClassVar = True
    enclosure: ClassVar = Enclosure(forms.CHAINS, 2, 3, _enclose, _cut, 6)

    def numbers(self) -> tuple[float, ...]:
        """Gives w_min^2 and its error, m^2."""
        return self.elbow_arm_min**2, ROUND * self.elbow_arm_min**2

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes w_i^2 less its least."""
        return [w2.plus(-exact(self.elbow_arm_min).square()) for w2 in pose.w2]

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is required."""
        return f"every elbow arm >= {rounded(self.elbow_arm_min * MM_PER_M, False)} mm"

    def margin(self, f: Any) -> np.ndarray:
        """Computes w^2 / L_B^2."""
        return f.closure
