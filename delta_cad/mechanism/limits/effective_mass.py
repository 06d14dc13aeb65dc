"""Effective mass: what the handle's inertia is at most, in its heaviest direction, README (37)-(42)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    UP,
    add,
    at,
    constant,
    inverse,
    magnitude,
    multiply,
    put,
    scale,
    subtract,
)
from delta_cad.mechanism.enclosure.interval import Interval
from delta_cad.mechanism.enclosure.slope_pose import SlopePose, Symmetric, centre_of, definite
from delta_cad.mechanism.enclosure.slope_pose import congruent as congruent_slopes
from delta_cad.mechanism.enclosure.slope_pose import eigenvectors as slope_eigenvectors
from delta_cad.mechanism.enclosure.symmetric import NEARLY, above, congruent, eigenvectors
from delta_cad.mechanism.enclosure.table import EXCLUDED, HIGH, INSIDE, LOW, Enclosure, keep, store
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry
from delta_cad.mechanism.inverse import arm_direction, elbow_arm, forearm_vectors
from delta_cad.mechanism.kernel import add_inertia, azimuth, in_base
from delta_cad.mechanism.limits.limit import Field, FigureOfMerit, ThresholdLimit
from delta_cad.mechanism.limits.numbers import Masses

_RANGE = (1e-6, 1e6)
"""kg: keeps every product of the proof far from underflow and overflow."""


@dataclass(frozen=True)
class HandleInertia(Masses):
    """What moves, as the handle's inertia sees it; the same for the three chains.

    Attributes:
        carried_mass: m_p + 3 m_vv: the platform and the rods' share that moves with it, kg.
        elbow_mass: m_uu of both rods of a chain, kg.
        cross_mass: m_uv of both, kg.
        joint_inertia: I: upper arm, rotor and pinion about the joint, kg m^2.
    """

    carried_mass: float
    elbow_mass: float
    cross_mass: float
    joint_inertia: float

    keys: ClassVar = {
        "carried_mass": "carried_mass_kg",
        "elbow_mass": "elbow_mass_kg",
        "cross_mass": "cross_mass_kg",
        "joint_inertia": "joint_inertia_kg_m2",
    }
    signed: ClassVar = ("cross_mass",)


def handle_inertia(g: DeltaGeometry, p: np.ndarray, masses: HandleInertia) -> np.ndarray:
    """Computes the handle's inertia, README (39).

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.
        masses: What moves.

    Returns:
        (..., 3, 3) kg; NaN where a chain is open, infinite or NaN at a fold.
    """
    cos, sin = arm_direction(g, p)
    elbow = -sin[..., None] * g.radial + cos[..., None] * VERTICAL
    at_elbow = masses.elbow_mass + masses.joint_inertia / g.upper_arm_length**2
    with np.errstate(divide="ignore", invalid="ignore"):  # at a fold
        n = forearm_vectors(g, p) / elbow_arm(g, p)[..., None]
        mixed = np.einsum("...ia,...ib->...ab", n, elbow)
        rows = at_elbow * np.einsum("...ia,...ib->...ab", n, n)
        return masses.carried_mass * np.eye(3) + rows + masses.cross_mass * (mixed + np.swapaxes(mixed, -1, -2))


def effective_mass(g: DeltaGeometry, p: np.ndarray, masses: HandleInertia) -> np.ndarray:
    """Computes the largest effective mass over all directions, README (40).

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.
        masses: What moves.

    Returns:
        (...) kg; infinite at a fold, NaN where a chain is open.
    """
    m = handle_inertia(g, p, masses)
    closed = np.isfinite(elbow_arm(g, p)).all(axis=-1)
    finite = np.asarray(np.isfinite(m).all(axis=(-2, -1), keepdims=True))
    largest = np.linalg.eigvalsh(np.where(finite, m, np.eye(3)))[..., 2]
    return np.where(closed, np.where(finite[..., 0, 0], largest, np.inf), np.nan)


@compiled
def _elbow_direction(pose, i):
    """L_A e_i in the base frame: its parts along x, y and z."""
    x, y = forms.along_radius(pose, i, scale(-1.0, at(pose, forms.ELBOW_VERTICAL + i)))
    return x, y, at(pose, forms.ELBOW_RADIAL + i)


@compiled
def _entry(at_elbow, cross, rows, elbows, a, b):
    """Entry (a, b) of M less the carried mass on the diagonal."""
    total = constant(0.0, 0.0)
    for i in range(3):
        na, nb = at(rows, 3 * i + a), at(rows, 3 * i + b)
        ea, eb = at(elbows, 3 * i + a), at(elbows, 3 * i + b)
        total = add(total, multiply(at_elbow, multiply(na, nb)))
        total = add(total, multiply(cross, add(multiply(na, eb), multiply(ea, nb))))
    return total


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes the mass allowed less the largest eigenvalue of M, README (33), (40)."""
    out[row, :] = math.nan
    rows, elbows = work[6:15], work[15:24]
    for i in range(3):
        arm = inverse(at(pose, forms.W + i))
        x, y, z = _elbow_direction(pose, i)
        put(elbows, 3 * i, x)
        put(elbows, 3 * i + 1, y)
        put(elbows, 3 * i + 2, z)
        for axis in range(3):
            put(rows, 3 * i + axis, multiply(at(pose, forms.FOREARM + 3 * i + axis), arm))
    turning = multiply(constant(k[n + 4], 0.0), inverse(at(pose, forms.UPPER_ARM_2)))
    at_elbow = add(constant(k[n + 3], 0.0), turning)
    cross = multiply(constant(k[n + 2], 0.0), inverse(at(pose, forms.UPPER_ARM)))
    a = (
        _entry(at_elbow, cross, rows, elbows, 0, 0),
        _entry(at_elbow, cross, rows, elbows, 1, 1),
        _entry(at_elbow, cross, rows, elbows, 2, 2),
        _entry(at_elbow, cross, rows, elbows, 0, 1),
        _entry(at_elbow, cross, rows, elbows, 0, 2),
        _entry(at_elbow, cross, rows, elbows, 1, 2),
    )
    if not eigenvectors((a[0][0], a[1][0], a[2][0], a[3][0], a[4][0], a[5][0]), work):
        return
    h11, h22, h33 = congruent(a, work, 0, 0), congruent(a, work, 1, 1), congruent(a, work, 2, 2)
    h12, h13, h23 = congruent(a, work, 0, 1), congruent(a, work, 0, 2), congruent(a, work, 1, 2)
    over = above(h11, h22, h33, h12, h13, h23)
    store(out, row, subtract(constant(k[n], k[n + 1]), h11))
    bent = 3.0 * NEARLY * (magnitude(h11) + over)
    out[row, LOW] -= (over + bent) * UP
    out[row, HIGH] += bent


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds that `u . M u` is allowed for the two heaviest directions u at the box's middle, README (42).

    Times `L_A^2 V` with `V = (w_1 w_2 w_3)^2`, so that nothing is divided by w: `(m - m_c) L_A^2 V - sum_i (V / w_i^2)
    [(m_uu L_A^2 + I) (s_i.u)^2 + 2 m_uv L_A (s_i.u) (L_A e_i.u) w_i]` is not negative for a feasible design.
    """
    la, la2 = at(pose, forms.UPPER_ARM), at(pose, forms.UPPER_ARM_2)
    v = (at(pose, forms.W2), at(pose, forms.W2 + 1), at(pose, forms.W2 + 2))
    others = (multiply(v[1], v[2]), multiply(v[0], v[2]), multiply(v[0], v[1]))
    if k[n] + k[n + 1] < 0.0 and k[n + 2] >= 0.0:  # less than what is carried, and all else only adds: n.e = 1
        return EXCLUDED
    if not _directions(pose, k, n, work):
        return count
    allowed = multiply(multiply(constant(k[n], k[n + 1]), la2), multiply(v[0], others[0]))
    at_elbow = add(multiply(constant(k[n + 3], 0.0), la2), constant(k[n + 4], 0.0))
    cross = multiply(constant(k[n + 2], 0.0), la)
    for column in range(2):
        x, y, z = work[3, column], work[4, column], work[5, column]
        f = INSIDE / math.sqrt(x * x + y * y + z * z)  # u is no longer than 1, so that |u|^2 may be left out
        total = allowed
        for i in range(3):
            along = add(
                add(scale(f * x, at(pose, forms.FOREARM + 3 * i)), scale(f * y, at(pose, forms.FOREARM + 3 * i + 1))),
                scale(f * z, at(pose, forms.FOREARM + 3 * i + 2)),
            )
            ex, ey, ez = _elbow_direction(pose, i)
            moved = add(add(scale(f * x, ex), scale(f * y, ey)), scale(f * z, ez))
            square = multiply(at_elbow, multiply(along, along))
            mixed = multiply(scale(2.0, cross), multiply(at(pose, forms.W + i), multiply(along, moved)))
            total = subtract(total, multiply(others[i], add(square, mixed)))
        count = keep(cuts, count, total)
        if count == EXCLUDED:
            return count
    return count


@compiled
def _directions(pose, k, n, work):
    """Fills work[3:6] with the eigenvectors of M at the box's middle, the heaviest first; False where it has none."""
    m, la2 = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), pose[forms.UPPER_ARM_2, 0]
    la = math.sqrt(la2)
    for i in range(3):
        w = pose[forms.W + i, 0]
        if not w > 0.0:
            return False
        s = forms.FOREARM + 3 * i
        row = pose[s, 0] / w, pose[s + 1, 0] / w, pose[s + 2, 0] / w
        turn = azimuth(i, pose[forms.COSINE, 0], pose[forms.SINE, 0])
        x, y = in_base(-pose[forms.ELBOW_VERTICAL + i, 0] / la, 0.0, *turn)
        elbow = x, y, pose[forms.ELBOW_RADIAL + i, 0] / la
        m = add_inertia(m, k[n + 3] + k[n + 4] / la2, k[n + 2], row, elbow)
    return eigenvectors(m, work)


@dataclass(frozen=True)
class EffectiveMass(ThresholdLimit):
    """Largest effective mass at the handle, kg, with what moves."""

    mass_max: float
    inertia: HandleInertia

    name: ClassVar = "effective_mass"
    keys: ClassVar = {"mass_max": "effective_mass_max_kg", "inertia": "inertia"}
    fields_: ClassVar = (
        Field("effective_mass_max_kg", "largest effective mass at the handle, in any direction", gt=0, le=50),
    )
    figures: ClassVar = (
        FigureOfMerit(
            "effective_mass",
            "kg",
            lambda limit, g, p: effective_mass(g, p, limit.inertia)[..., None],
            "mass_max",
            _RANGE,
        ),
    )
    needs: ClassVar = "inertia"
    needed: ClassVar = "the masses of what moves: give mass_properties.json of a build, or state table [inertia]"
    mass_kinds: ClassVar = {"inertia": HandleInertia}
    output_key: ClassVar = "max_effective_mass_kg"
    enclosure: ClassVar = Enclosure(forms.FOREARMS, 5, 1, _enclose, _cut, 2)

    def numbers(self) -> tuple[float, ...]:
        """Gives the mass allowed beside the carried and its error, m_uv, m_uu and I."""
        m = self.inertia
        allowed, error = self.mass_max - m.carried_mass, ROUND * (self.mass_max + m.carried_mass)
        return allowed, error, m.cross_mass, m.elbow_mass, m.joint_inertia

    def _difference(self, pose: SlopePose, exact: Callable[[float], Interval], sense: float) -> Symmetric:
        """M less the mass allowed, times sense."""
        m, found = self.inertia, {}
        at_elbow = exact(m.elbow_mass) + exact(m.joint_inertia) * pose.upper_arm.square().inverse()
        for a in range(3):
            for b in range(a, 3):
                total = None
                for n, e in zip(pose.rows, pose.elbow, strict=True):
                    part = (n[a] * n[b] if a != b else n[a].square()).times(at_elbow)
                    part = part + (n[a] * e[b] + e[a] * n[b]).times(exact(m.cross_mass))
                    total = part if total is None else total + part
                assert total is not None
                if a == b:
                    total = total.plus(exact(m.carried_mass) - exact(self.mass_max))
                found[a, b] = total.times(exact(sense))
        return found

    def _turned(self, pose: SlopePose, exact: Callable[[float], Interval], sense: float) -> tuple[Any, np.ndarray]:
        m = self._difference(pose, exact, sense)
        middle = np.array([[centre_of(m[min(a, b), max(a, b)]) for b in range(3)] for a in range(3)])
        v = slope_eigenvectors(np.moveaxis(middle, -1, 0))
        return congruent_slopes(m, v), v

    def proved_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> np.ndarray:
        """Proves that the mass allowed less M is positive definite, turned by a regular matrix, README (41)."""
        turned, _ = self._turned(pose, exact, -1.0)
        return definite({key: form.box for key, form in turned.items()}, (2, 1, 0))

    def refuted_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> bool:
        """Shows a direction in which M is more than the mass allowed."""
        turned, _ = self._turned(pose, exact, 1.0)
        return bool(turned[2, 2].centre.lo[0] > 0.0)

    def margin(self, f: Any) -> np.ndarray:
        """Computes carried mass / effective mass less its least; the closure where that is negative."""
        return self.search_quantities(f)["mass_ratio"] - self.inertia.carried_mass / self.mass_max

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes carried mass / effective mass; the closure where that is negative."""
        return {"mass_ratio": f.mass_ratio(self.inertia)}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Computes the largest effective mass; infinite at a fold."""
        return self.inertia.carried_mass / least["mass_ratio"] if least["mass_ratio"] > 0.0 else math.inf

    def less_strict_than(self, than: Any) -> bool:
        """Compares the thresholds; with other masses it is about another machine, and so less strict."""
        return self.mass_max > than.mass_max or self.inertia != than.inertia
