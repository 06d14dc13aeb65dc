"""Second proof of each condition over given boxes, in interval slopes and NumPy; what `verify` believes.

Formulas are numbered as in the mechanism's README. Where the prover takes polynomials and bounds eigenvalues, this
takes quotients, cross products and the definiteness of two matrices.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.proof.limits import Limits, cosine_sine
from optimizer.certify.interval import Interval, Slopes, coordinates, exactly

BATCH = 1_000
"""Boxes at a time: small enough to stay in the processor's cache."""
FINEST = 45
"""Halvings of a box after which it is not tried again: its edges are then 2^-15 of what they were."""
_ROOT_3_4 = float(np.sqrt(0.75))
Vector = tuple[Slopes, Slopes, Slopes]


@dataclass(frozen=True)
class Pose:
    """The mechanism over boxes; chains are the tuples' index.

    Attributes:
        q: Radial coordinate of the wrist, m.
        t: Coordinate along the shoulder axis, m.
        z: Height, m.
        w2: Closure margin, m^2.
        arm: Elbow arm w, m; NaN unless w^2 is positive throughout.
        forearm: Components of s in the base frame, m.
        cos: Of the shoulder angle.
        sin: Of the shoulder angle.
    """

    q: Vector
    t: Vector
    z: Slopes
    w2: Vector
    arm: Vector
    forearm: tuple[Vector, Vector, Vector]
    cos: Vector
    sin: Vector


def pose(g: DeltaGeometry, lower: np.ndarray, upper: np.ndarray) -> Pose:
    """Encloses the mechanism over boxes, README (1)-(6).

    Args:
        g: The mechanism.
        lower: (n, 3) lower corners, m.
        upper: (n, 3) upper corners, m.

    Returns:
        The enclosure.
    """
    x, y, z = coordinates(lower, upper)
    a = exactly(g.base_radius) - exactly(g.platform_radius)
    la, lb = exactly(g.upper_arm_length), exactly(g.forearm_length)
    constant, double = la.square() - lb.square(), (la + la).inverse()
    root = Interval(np.nextafter(np.float64(_ROOT_3_4), 0.0), np.nextafter(np.float64(_ROOT_3_4), 1.0))
    half = exactly(-0.5)
    chains = []
    for c, s in ((exactly(1.0), exactly(0.0)), (half, root), (half, -root)):
        q, t = (x.times(c) + y.times(s)).plus(-a), y.times(c) - x.times(s)
        rho2 = q.square() + z.square()
        m = (rho2 + t.square()).plus(constant).times(double)
        w2 = rho2 - m.square()
        w, inverse = w2.root(), rho2.inverse()
        cos, sin = (q * m + z * w) * inverse, (z * m - q * w) * inverse
        radial, height = q - cos.times(la), z - sin.times(la)
        forearm = (radial.times(c) - t.times(s), radial.times(s) + t.times(c), height)
        chains.append((q, t, w2, w, forearm, cos, sin))
    q, t, w2, w, forearm, cos, sin = (tuple(column) for column in zip(*chains, strict=True))
    return Pose(q, t, z, w2, w, forearm, cos, sin)


def _cross(a: Vector, b: Vector) -> Vector:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _dot(a: Vector, b: Vector) -> Slopes:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _norm2(a: Vector) -> Slopes:
    return a[0].square() + a[1].square() + a[2].square()


def linear_margins(g: DeltaGeometry, limits: Limits, sign: float, p: Pose, condition: str) -> list[Slopes]:
    """Margins of every condition but kappa, not negative where it holds.

    Args:
        g: The mechanism.
        limits: The conditions.
        sign: Of det S at the reference point.
        p: The mechanism over boxes.
        condition: Name of the condition.

    Returns:
        One margin, or one a chain.
    """
    if condition == "reach":
        return [w2.plus(-exactly(limits.elbow_arm_min).square()) for w2 in p.w2]
    if condition == "lean":
        _, sine = cosine_sine(limits.lean_max or 0.0, limits.lean_max or 0.0)
        allowed = _wide(sine) * exactly(g.forearm_length)
        return [t.times(exactly(side)).plus(allowed) for t in p.t for side in (1.0, -1.0)]
    if condition == "shoulder":
        low, high = limits.shoulder or (0.0, 0.0)
        (c, s), (least, _) = cosine_sine(low, high), cosine_sine(high, -low)
        return [
            (cos.times(_wide(c)) + sin.times(_wide(s))).plus(-_wide(least))
            for cos, sin in zip(p.cos, p.sin, strict=True)
        ]
    det = _dot(p.forearm[0], _cross(p.forearm[1], p.forearm[2]))
    if condition == "singularity":
        return [det.times(exactly(sign))]
    allowed = exactly(limits.torque_max or 0.0) * (exactly(limits.force or 0.0) * exactly(g.upper_arm_length)).inverse()
    out = []
    for i in range(3):
        face = _norm2(_cross(p.forearm[i - 2], p.forearm[i - 1]))
        out.append(det.square().times(allowed.square()) - p.w2[i] * face)
    return out


def _wide(x: float) -> Interval:
    """A number that was rounded once to x, at most 1 in size."""
    return exactly(x) + Interval(np.array(-(2.0**-53)), np.array(2.0**-53))


def proves(g: DeltaGeometry, limits: Limits, sign: float, p: Pose, condition: str) -> np.ndarray:
    """Whether a condition is proved over each box.

    Args:
        g: The mechanism.
        limits: The conditions.
        sign: Of det S at the reference point.
        p: The mechanism over n boxes.
        condition: Name of the condition.

    Returns:
        (n,) truth.
    """
    if condition == "kappa":
        return _kappa_proves(p, exactly(limits.kappa_max or 0.0).square())
    found = [margin.box.lo for margin in linear_margins(g, limits, sign, p, condition)]
    # reach may be met exactly; the determinant may not be zero
    return np.all([low > 0.0 if condition == "singularity" else low >= 0.0 for low in found], axis=0)


def breaks(g: DeltaGeometry, limits: Limits, sign: float, point: np.ndarray, condition: str) -> bool:
    """Whether a position breaks a condition for certain.

    Args:
        g: The mechanism.
        limits: The conditions.
        sign: Of det S at the reference point.
        point: (3,) position, m.
        condition: Name of the condition.

    Returns:
        Truth only if the condition is broken in exact arithmetic.
    """
    p = pose(g, point[None], point[None])
    if condition == "kappa":
        rows, v = _rows(p)
        small, large = (_column_quotient(rows, v, k) for k in (0, 2))
        return bool((large - exactly(limits.kappa_max or 0.0).square() * small).lo[0] > 0.0)
    return any(bool(m.centre.hi[0] < 0.0) for m in linear_margins(g, limits, sign, p, condition))


def _rows(p: Pose) -> tuple[list[Vector], np.ndarray]:
    """Rows n_i = s_i / w_i, and the eigenvectors (n, 3, 3) of their Gram matrix at the centres, ascending."""
    rows: list[Vector] = []
    for forearm, arm in zip(p.forearm, p.arm, strict=True):
        inverse = arm.inverse()
        rows.append((forearm[0] * inverse, forearm[1] * inverse, forearm[2] * inverse))
    middle = np.array([[0.5 * (v.centre.lo + v.centre.hi) for v in row] for row in rows])  # (chain, axis, n)
    gram = np.einsum("ian,jan->nij", middle, middle)
    return rows, np.linalg.eigh(np.where(np.isfinite(gram), gram, np.eye(3)))[1]


def _turned(rows: list[Vector], v: np.ndarray, k: int) -> Vector:
    """Column k of V^T applied to the rows: a vector of slope forms."""
    w = [exactly(v[:, i, k]) for i in range(3)]
    x, y, z = (rows[0][a].times(w[0]) + rows[1][a].times(w[1]) + rows[2][a].times(w[2]) for a in range(3))
    return x, y, z


def _column_quotient(rows: list[Vector], v: np.ndarray, k: int) -> Interval:
    """Rayleigh's quotient of the Gram matrix for column k of V, at the centres."""
    total = exactly(v[:, :, k].T).square().total()
    return _norm2(_turned(rows, v, k)).centre * total.inverse()


def _kappa_proves(p: Pose, square: Interval) -> np.ndarray:
    """Whether all eigenvalues of the Gram matrix A lie within [mu, K^2 mu] for a linear function mu of the position.

    A - mu and K^2 mu - A are positive definite if V^T (.) V is, for whatever regular V.
    """
    rows, v = _rows(p)
    turned = [_turned(rows, v, k) for k in range(3)]
    weights = {(k, m): (exactly(v[:, :, k].T) * exactly(v[:, :, m].T)).total() for k in range(3) for m in range(k, 3)}
    b = {(k, m): _dot(turned[k], turned[m]) if k < m else _norm2(turned[k]) for k, m in weights}
    share = 0.5 / float(square.hi)
    centre = 0.5 * _middle(b[0, 0].centre) + share * _middle(b[2, 2].centre)
    slope = 0.5 * _middle(b[0, 0].slope) + share * _middle(b[2, 2].slope)
    step = p.z.step
    range_ = exactly(centre) + (exactly(slope) * step).total()
    mu = Slopes(exactly(centre), range_, exactly(slope), step)
    above = {key: (form - mu.times(weights[key])).box for key, form in b.items()}
    below = {key: (mu.times(weights[key] * square) - form).box for key, form in b.items()}
    return _definite(above, (2, 1, 0)) & _definite(below, (0, 1, 2))


def _middle(x: Interval) -> np.ndarray:
    return 0.5 * (x.lo + x.hi)


def _definite(m: dict[tuple[int, int], Interval], order: tuple[int, int, int]) -> np.ndarray:
    """Whether symmetric matrices are positive definite: Gauss's pivots in an order, the smallest last."""
    i, j, k = order

    def at(a: int, b: int) -> Interval:
        return m[min(a, b), max(a, b)]

    first = at(i, i).inverse()
    second = at(j, j) - at(i, j).square() * first
    mixed = at(j, k) - at(i, j) * at(i, k) * first
    third = at(k, k) - at(i, k).square() * first - mixed.square() * second.inverse()
    return (at(i, i).lo > 0.0) & (second.lo > 0.0) & (third.lo > 0.0)


@dataclass(frozen=True)
class Unproved:
    """A box in which a condition could not be proved a second time.

    Attributes:
        condition: Its name.
        lower: Lower corner, m.
        upper: Upper corner, m.
    """

    condition: str
    lower: tuple[float, ...]
    upper: tuple[float, ...]


def replay(
    g: DeltaGeometry,
    limits: Limits,
    sign: float,
    conditions: tuple[str, ...],
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    max_boxes: int = 2_000_000,
    progress: Callable[[int, float], None] | None = None,
) -> tuple[int, Unproved | None]:
    """Proves conditions over boxes, halving a box where this arithmetic is too coarse for it.

    Args:
        g: The mechanism.
        limits: The conditions' numbers.
        sign: Of det S at the reference point.
        conditions: Names of those to prove.
        lower: (n, 3) lower corners, m.
        upper: (n, 3) upper corners, m.
        max_boxes: Boxes after which the replay gives up.
        progress: Called with the boxes examined and the share of the given ones that is done.

    Returns:
        Boxes examined, and the first that could not be proved, if any.
    """
    examined = 0
    for start in range(0, len(lower), BATCH):
        low, high = lower[start : start + BATCH], upper[start : start + BATCH]
        open_ = np.ones((len(low), len(conditions)), dtype=bool)
        depth = np.zeros(len(low), dtype=int)
        while len(low):
            now = slice(max(0, len(low) - BATCH), None)  # the last ones first, so that the list stays short
            p = pose(g, low[now], high[now])
            examined += len(low[now])
            still = open_[now].copy()
            for n, condition in enumerate(conditions):
                if still[:, n].any():
                    still[:, n] &= ~proves(g, limits, sign, p, condition)
            failed = still.any(axis=1)
            stuck = failed & ((depth[now] >= FINEST) | (examined >= max_boxes))
            if stuck.any():
                k = int(np.argmax(stuck))
                name = conditions[int(np.argmax(still[k]))]
                return examined, Unproved(name, tuple(low[now][k].tolist()), tuple(high[now][k].tolist()))
            parts = _halved(low[now][failed], high[now][failed])
            low, high = (np.concatenate([kept[: now.start], new]) for kept, new in zip((low, high), parts, strict=True))
            open_ = np.concatenate([open_[: now.start], still[failed], still[failed]])
            depth = np.concatenate([depth[: now.start], depth[now][failed] + 1, depth[now][failed] + 1])
        if progress is not None:
            progress(examined, min(1.0, (start + BATCH) / len(lower)))
    return examined, None


def _halved(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both halves of boxes, (2 n, 3) lower and upper corners: first all near ones, then all far ones."""
    rows, axis = np.arange(len(lower)), np.argmax(upper - lower, axis=1)
    middle = 0.5 * (lower[rows, axis] + upper[rows, axis])
    near, far = upper.copy(), lower.copy()
    near[rows, axis] = middle
    far[rows, axis] = middle
    return np.concatenate([lower, far]), np.concatenate([near, upper])
