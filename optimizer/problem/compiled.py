"""The figures of `evaluator` at many points of many designs, compiled: some hundred times as fast as NumPy.

The condition number is that of the mechanism's kernel; the chains are continued beyond the reach as in the evaluator.
The loops have no branches, so that the processor takes several points at a time. The first call loads numba and, once
on a machine, compiles for some seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from delta_cad.common.jit import compiled, inlined, unrolled_dispatch
from delta_cad.mechanism.kernel import (
    add_inertia,
    arm,
    azimuth,
    chain_closure,
    in_base,
    kappa,
    largest_eigenvalue,
    wrist,
)
from delta_cad.mechanism.limits.couple_index import least_of

TINY = float(np.finfo(float).tiny)
_FOLD = 1e-75
"""Least w / L_B that is divided by: the fourth power of what comes out is still a number."""
_SENSES = ((1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0))
"""Senses in which the second and the third joint turn where the first turns forwards."""


def figures_compiled(
    designs: np.ndarray, points: np.ndarray, conditioning: bool, angles: bool, out: np.ndarray
) -> None:
    """Fills the six figures of `evaluator.Figures`.

    Args:
        designs: (D, 9) in the order of `VARIABLES`, SI units.
        points: (D, K, 3) or (1, K, 3) points in the coordinates of the cube.
        conditioning: Whether `quality` is wanted; ones without.
        angles: Whether the shoulder angles are wanted; zeros without.
        out: (D, 6, K) filled.
    """
    if not conditioning:
        out[:, 3] = 1.0
    if not angles:
        out[:, 4:] = 0.0
    places = np.ascontiguousarray(points.transpose(0, 2, 1))
    _fill(np.ascontiguousarray(designs), places, conditioning, angles, out)


def filled(fill: Callable[..., None], designs: np.ndarray, points: np.ndarray, *numbers: float) -> np.ndarray:
    """Computes a figure by one of the functions below that fill it.

    Args:
        fill: One that takes designs, coordinates of points, some numbers and the room for the figure.
        designs: (D, 9) in the order of `VARIABLES`, SI units.
        points: (D, K, 3) or (1, K, 3) points in the coordinates of the cube.
        *numbers: Those that it takes, SI units.

    Returns:
        (D, K).
    """
    out = np.empty((len(designs), points.shape[1]))
    fill(np.ascontiguousarray(designs), np.ascontiguousarray(points.transpose(0, 2, 1)), *numbers, out)
    return out


@inlined
def _chain(x, y, z, a, c, s, la, lb):
    """Computes of a chain w^2 / L_B^2, w / L_B, cosine and sine of the shoulder angle, and the forearm by L_B.

    That is in the base frame, and before that along the chain's radius. Beyond the reach w is 0.
    """
    q, t = wrist(x, y, a, c, s)
    rho2, m, w2 = chain_closure(q, t, z, la, lb)
    w = math.sqrt(w2 if w2 > 0.0 else 0.0)
    cos, sin = arm(q, z, rho2 if rho2 > TINY else TINY, m, w)
    radial = (q - la * cos) / lb
    sx, sy = in_base(radial, t / lb, c, s)
    return w2 / (lb * lb), w / lb, cos, sin, radial, sx, sy, (z - la * sin) / lb


@inlined
def _design(design):
    """Gives of a design L_A, L_B, H, L, the cube's offset, and a of chain 0 and of the others, c and s of chain 1."""
    c, a = design[7], design[2] - design[3]
    other = design[2] + design[6] - design[3]
    return design[0], design[1], design[4], design[5], design[8], (a, other, c, math.sqrt((1.0 - c) * (1.0 + c)))


@inlined
def _chains(x, y, z, placed, la, lb):
    """The same as `_chain` of the three chains; `placed` is the last of `_design`."""
    a, other, c, s = placed
    return (
        _chain(x, y, z, a, 1.0, 0.0, la, lb),
        _chain(x, y, z, other, c, s, la, lb),
        _chain(x, y, z, other, c, -s, la, lb),
    )


@inlined
def _closure(one, two, three):
    """Computes the smallest w^2 / L_B^2."""
    closure = one[0] if one[0] < two[0] else two[0]
    return closure if closure < three[0] else three[0]


@inlined
def _face(one, other):
    """Computes the cross product of two chains' forearms."""
    return (
        one[6] * other[7] - one[7] * other[6],
        one[7] * other[5] - one[5] * other[7],
        one[5] * other[6] - one[6] * other[5],
    )


@inlined
def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def _point(one, two, three):
    """Computes closure, determinant, moment / L_A, elbow arms, products and squares of the forearms at a point."""
    s1, s2, s3 = one[5:], two[5:], three[5:]
    face = _face(two, three)
    det, n1 = _dot(s1, face), _dot(face, face)
    face = _face(three, one)
    n2 = _dot(face, face)
    face = _face(one, two)
    n3 = _dot(face, face)
    w1, w2, w3 = one[1], two[1], three[1]
    m1, m2, m3 = w1 * math.sqrt(n1), w2 * math.sqrt(n2), w3 * math.sqrt(n3)
    moment = m1 if m1 > m2 else m2
    moment = moment if moment > m3 else m3
    closure = _closure(one, two, three)
    return closure, det, moment, w1, w2, w3, _dot(s1, s2), _dot(s1, s3), _dot(s2, s3), n1, n2, n3


@compiled
def _fill(designs, places, conditioning, angles, out):
    """Fills closure, determinant and moment, and what is wanted beside them."""
    for d in range(len(designs)):
        la, lb, height, side, offset, placed = _design(designs[d])
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        closures, determinants, moments, qualities = out[d, 0], out[d, 1], out[d, 2], out[d, 3]
        if conditioning:
            for k in range(len(px)):
                one, two, three = _chains(
                    offset + side * px[k], side * py[k], height + side * (1.0 + pz[k]), placed, la, lb
                )
                closure, det, moment, w1, w2, w3, g12, g13, g23, n1, n2, n3 = _point(one, two, three)
                closures[k], determinants[k], moments[k] = closure, det, la * moment
                inverse = 1.0 / kappa(w1, w2, w3, g12, g13, g23, n1, n2, n3, det, 1.0)
                inverse = inverse if det > 0.0 else -inverse
                beyond = closure if closure < 0.0 else 0.0
                qualities[k] = beyond if closure <= 0.0 or det == 0.0 else inverse
        else:
            for k in range(len(px)):
                one, two, three = _chains(
                    offset + side * px[k], side * py[k], height + side * (1.0 + pz[k]), placed, la, lb
                )
                figures = _point(one, two, three)
                closures[k], determinants[k], moments[k] = figures[0], figures[1], la * figures[2]
        if angles:
            for k in range(len(px)):
                one, two, three = _chains(
                    offset + side * px[k], side * py[k], height + side * (1.0 + pz[k]), placed, la, lb
                )
                th1, th2, th3 = math.atan2(one[3], one[2]), math.atan2(two[3], two[2]), math.atan2(three[3], three[2])
                out[d, 4, k] = min(th1, th2, th3)
                out[d, 5, k] = max(th1, th2, th3)


# A loop over the points of designs, as `_fill` has it; {0} is the figure of a point, {1} the numbers it takes.
_LOOP = """for d in range(len(designs)):
        la, lb, height, side, offset, placed = design(designs[d])
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        for k in range(len(px)):
            x, y, z = offset + side * px[k], side * py[k], height + side * (1.0 + pz[k])
            one, two, three = chains(x, y, z, placed, la, lb)
            out[d, k] = {0}(one, two, three, la, placed{1})"""


def _of_points(figure: Any, *numbers: str) -> Any:
    """Compiles (designs, places, numbers, out), which fills a figure of points, for `filled`."""
    given = "".join(f", {number}" for number in numbers)
    return unrolled_dispatch(f"designs, places{given}, out", [(figure, given)], _LOOP, chains=_chains, design=_design)


@inlined
def _couple_index(one, two, three, la, placed):  # noqa: ARG001
    return least_of(one[4], two[4], three[4], one[7], two[7], three[7], placed[2], placed[3])


@inlined
def _row(chain, la):
    """Computes the row of a chain's inverse Jacobian, for elbow arms of at least `_FOLD`."""
    lever = la * max(chain[1], _FOLD)
    return chain[5] / lever, chain[6] / lever, chain[7] / lever


@inlined
def _mass_ratio(one, two, three, la, placed, carried, elbow_mass, cross, joint_inertia):
    """Computes the carried mass by the effective mass."""
    m, turning = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), elbow_mass + joint_inertia / (la * la)
    for i, chain in ((0, one), (1, two), (2, three)):
        m = add_inertia(
            m, turning, cross, _row(chain, 1.0), (*in_base(-chain[3], 0.0, *azimuth(i, placed[2], placed[3])), chain[2])
        )
    size = max(abs(m[0]), abs(m[1]), abs(m[2]))  # powers of what is huge at a fold are no numbers
    size = size if size > TINY else 1.0
    largest, _ = largest_eigenvalue(m[0] / size, m[1] / size, m[2] / size, m[3] / size, m[4] / size, m[5] / size)
    closure = _closure(one, two, three)
    return closure if closure < 0.0 else carried / (carried + size * largest)


@inlined
def _added(a, b, c, second, third):
    """Computes a sum of three vectors, two of which have a sign."""
    return (
        a[0] + second * b[0] + third * c[0],
        a[1] + second * b[1] + third * c[1],
        a[2] + second * b[2] + third * c[2],
    )


@inlined
def _inverse_friction(one, two, three, la, placed, drive, upright, level):  # noqa: ARG001
    """Computes 1 / friction."""
    a, b, c, most = _row(one, la), _row(two, la), _row(three, la), 0.0
    for second, third in _SENSES:
        x, y, z = _added(a, b, c, second, third)
        wide, high = drive * math.sqrt(x * x + y * y) + level, drive * abs(z) + upright
        most = max(most, wide * wide + high * high)
    closure = _closure(one, two, three)
    return closure if closure < 0.0 else 1.0 / math.sqrt(most)


@inlined
def _move(chain, one, other, la):
    """Computes the determinant times the handle's way for a turn of 1 rad of a chain's joint."""
    lever, (x, y, z) = la * chain[1], _face(one, other)
    return lever * x, lever * y, lever * z


@inlined
def _scaled_step(one, two, three, la, placed):  # noqa: ARG001
    """Computes the determinant times the longest way of the handle."""
    a, b, c, most = _move(one, two, three, la), _move(two, three, one, la), _move(three, one, two, la), 0.0
    for second, third in _SENSES:
        way = _added(a, b, c, second, third)
        most = max(most, _dot(way, way))
    return math.sqrt(most)


fill_couple_index = _of_points(_couple_index)
fill_mass_ratio = _of_points(_mass_ratio, "carried", "elbow_mass", "cross", "joint_inertia")
fill_inverse_friction = _of_points(_inverse_friction, "drive", "upright", "level")
fill_scaled_step = _of_points(_scaled_step)
