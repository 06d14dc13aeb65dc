"""The figures of `evaluator` at many points of many designs, compiled: some hundred times as fast as NumPy.

The condition number is that of the mechanism's kernel; the chains are continued beyond the reach as in the evaluator.
The loops have no branches, so that the processor takes several points at a time. The first call loads numba and, once
on a machine, compiles for some seconds.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from delta_cad.common.jit import compiled, inlined
from delta_cad.mechanism.geometry import SIN_60
from delta_cad.mechanism.kernel import chain_closure, kappa, largest_eigenvalue
from delta_cad.mechanism.limits.couple_index import least_of

TINY = float(np.finfo(float).tiny)
FOLD = 1e-75
"""Least w / L_B that is divided by: the fourth power of what comes out is still a number."""


def figures_compiled(
    designs: np.ndarray, points: np.ndarray, conditioning: bool, angles: bool, out: np.ndarray
) -> None:
    """Fills the six figures of `evaluator.Figures`.

    Args:
        designs: (D, 6) lengths in the order of `VARIABLES`, m.
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
        designs: (D, 6) lengths in the order of `VARIABLES`, m.
        points: (D, K, 3) or (1, K, 3) points in the coordinates of the cube.
        *numbers: Those that it takes, SI units.

    Returns:
        (D, K).
    """
    out = np.empty((len(designs), points.shape[1]))
    fill(np.ascontiguousarray(designs), np.ascontiguousarray(points.transpose(0, 2, 1)), *numbers, out)
    return out


@inlined
def _closed(q, t, z, la, lb):
    """Closes a chain in its own plane: w^2, w, cosine and sine of the shoulder angle; w is 0 beyond the reach."""
    rho2, m, w2, _ = chain_closure(q, t, z, la, lb)
    rho2 = rho2 if rho2 > TINY else TINY
    w = math.sqrt(w2 if w2 > 0.0 else 0.0)
    return w2, w, (q * m + z * w) / rho2, (z * m - q * w) / rho2


@inlined
def _chain(q, t, z, la, lb):
    """Computes w^2 / L_B^2, w / L_B and the unit forearm along the radius and along z."""
    w2, w, cos, sin = _closed(q, t, z, la, lb)
    return w2 / (lb * lb), w / lb, (q - la * cos) / lb, (z - la * sin) / lb


@inlined
def _angle(q, t, z, la, lb):
    """Computes the shoulder angle."""
    _, _, cos, sin = _closed(q, t, z, la, lb)
    return math.atan2(sin, cos)


@inlined
def _point(x, y, z, a, la, lb):
    """Computes closure, determinant, moment / L_A, elbow arms, products and squares of the forearms at a point."""
    xc, yc, xs, ys = -0.5 * x, -0.5 * y, SIN_60 * x, SIN_60 * y
    t2, t3 = yc - xs, yc + xs
    c1, w1, r1, z1 = _chain(x - a, y, z, la, lb)
    c2, w2, r2, z2 = _chain(xc + ys - a, t2, z, la, lb)
    c3, w3, r3, z3 = _chain(xc - ys - a, t3, z, la, lb)
    t1, t2, t3 = y / lb, t2 / lb, t3 / lb
    x1, y1 = r1, t1
    x2, y2 = -0.5 * r2 - SIN_60 * t2, SIN_60 * r2 - 0.5 * t2
    x3, y3 = -0.5 * r3 + SIN_60 * t3, -SIN_60 * r3 - 0.5 * t3
    fx, fy, fz = y2 * z3 - z2 * y3, z2 * x3 - x2 * z3, x2 * y3 - y2 * x3
    det = x1 * fx + y1 * fy + z1 * fz
    n1 = fx * fx + fy * fy + fz * fz
    fx, fy, fz = y3 * z1 - z3 * y1, z3 * x1 - x3 * z1, x3 * y1 - y3 * x1
    n2 = fx * fx + fy * fy + fz * fz
    fx, fy, fz = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
    n3 = fx * fx + fy * fy + fz * fz
    closure = c1 if c1 < c2 else c2
    closure = closure if closure < c3 else c3
    m1, m2, m3 = w1 * math.sqrt(n1), w2 * math.sqrt(n2), w3 * math.sqrt(n3)
    moment = m1 if m1 > m2 else m2
    moment = moment if moment > m3 else m3
    g12 = x1 * x2 + y1 * y2 + z1 * z2
    g13 = x1 * x3 + y1 * y3 + z1 * z3
    g23 = x2 * x3 + y2 * y3 + z2 * z3
    return closure, det, moment, w1, w2, w3, g12, g13, g23, n1, n2, n3


@compiled
def _fill(designs, places, conditioning, angles, out):
    """Fills closure, determinant and moment, and what is wanted beside them."""
    for d in range(len(designs)):
        la, lb, height, side = designs[d, 0], designs[d, 1], designs[d, 4], designs[d, 5]
        a = designs[d, 2] - designs[d, 3]
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        closures, determinants, moments, qualities = out[d, 0], out[d, 1], out[d, 2], out[d, 3]
        if conditioning:
            for k in range(len(px)):
                closure, det, moment, w1, w2, w3, g12, g13, g23, n1, n2, n3 = _point(
                    side * px[k], side * py[k], height + side * (1.0 + pz[k]), a, la, lb
                )
                closures[k], determinants[k], moments[k] = closure, det, la * moment
                inverse = 1.0 / kappa(w1, w2, w3, g12, g13, g23, n1, n2, n3, det, 1.0)
                inverse = inverse if det > 0.0 else -inverse
                beyond = closure if closure < 0.0 else 0.0
                qualities[k] = beyond if closure <= 0.0 or det == 0.0 else inverse
        else:
            for k in range(len(px)):
                figures = _point(side * px[k], side * py[k], height + side * (1.0 + pz[k]), a, la, lb)
                closures[k], determinants[k], moments[k] = figures[0], figures[1], la * figures[2]
        if angles:
            for k in range(len(px)):
                x, y, z = side * px[k], side * py[k], height + side * (1.0 + pz[k])
                xc, yc, xs, ys = -0.5 * x, -0.5 * y, SIN_60 * x, SIN_60 * y
                th1 = _angle(x - a, y, z, la, lb)
                th2 = _angle(xc + ys - a, yc - xs, z, la, lb)
                th3 = _angle(xc - ys - a, yc + xs, z, la, lb)
                out[d, 4, k] = min(th1, th2, th3)
                out[d, 5, k] = max(th1, th2, th3)


@compiled
def fill_couple_index(designs, places, out):
    """Fills the couple index."""
    for d in range(len(designs)):
        la, lb, height, side = designs[d, 0], designs[d, 1], designs[d, 4], designs[d, 5]
        a = designs[d, 2] - designs[d, 3]
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        for k in range(len(px)):
            x, y, z = side * px[k], side * py[k], height + side * (1.0 + pz[k])
            xc, yc, xs, ys = -0.5 * x, -0.5 * y, SIN_60 * x, SIN_60 * y
            _, _, r1, v1 = _chain(x - a, y, z, la, lb)
            _, _, r2, v2 = _chain(xc + ys - a, yc - xs, z, la, lb)
            _, _, r3, v3 = _chain(xc - ys - a, yc + xs, z, la, lb)
            out[d, k] = least_of(r1, r2, r3, v1, v2, v3)


@inlined
def _forearm(i, q, t, z, la, lb):
    """Computes of a chain w^2 / L_B^2, w / L_B, the unit forearm, and the unit vector along which its elbow moves."""
    w2, w, cos, sin = _closed(q, t, z, la, lb)
    r, along, v = (q - la * cos) / lb, t / lb, (z - la * sin) / lb
    turn = 0.0 if i == 0 else (SIN_60 if i == 1 else -SIN_60)
    part = 1.0 if i == 0 else -0.5
    x, y = part * r - turn * along, turn * r + part * along
    return w2 / (lb * lb), w / lb, x, y, v, -part * sin, -turn * sin, cos


@inlined
def _forearms(x, y, z, a, la, lb):
    """The same of the three chains."""
    xc, yc, xs, ys = -0.5 * x, -0.5 * y, SIN_60 * x, SIN_60 * y
    return (
        _forearm(0, x - a, y, z, la, lb),
        _forearm(1, xc + ys - a, yc - xs, z, la, lb),
        _forearm(2, xc - ys - a, yc + xs, z, la, lb),
    )


@inlined
def _entry(at_elbow, cross, n, e, m, f):
    """Computes what a chain adds to an entry of the inertia, from two components of its row and of its elbow's way."""
    return at_elbow * n * m + cross * (n * f + m * e)


@compiled
def fill_lightness(designs, places, carried, elbow_mass, cross, joint_inertia, out):
    """Fills the carried mass by the effective mass."""
    for d in range(len(designs)):
        la, lb, height, side = designs[d, 0], designs[d, 1], designs[d, 4], designs[d, 5]
        a, at_elbow = designs[d, 2] - designs[d, 3], elbow_mass + joint_inertia / (la * la)
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        for k in range(len(px)):
            chains = _forearms(side * px[k], side * py[k], height + side * (1.0 + pz[k]), a, la, lb)
            closure = min(chains[0][0], chains[1][0], chains[2][0])
            m00 = m11 = m22 = m01 = m02 = m12 = 0.0
            for _, arm, x, y, z, ex, ey, ez in chains:
                arm = arm if arm > FOLD else FOLD
                x, y, z = x / arm, y / arm, z / arm
                m00 += _entry(at_elbow, cross, x, ex, x, ex)
                m11 += _entry(at_elbow, cross, y, ey, y, ey)
                m22 += _entry(at_elbow, cross, z, ez, z, ez)
                m01 += _entry(at_elbow, cross, x, ex, y, ey)
                m02 += _entry(at_elbow, cross, x, ex, z, ez)
                m12 += _entry(at_elbow, cross, y, ey, z, ez)
            size = max(abs(m00), abs(m11), abs(m22))  # powers of what is huge at a fold are no numbers
            size = size if size > TINY else 1.0
            largest, _ = largest_eigenvalue(m00 / size, m11 / size, m22 / size, m01 / size, m02 / size, m12 / size)
            out[d, k] = closure if closure < 0.0 else carried / (carried + size * largest)


@inlined
def _square(drive, upright, level, x, y, z):
    """Computes the square of what rubs in one sense of the joints, of the sum of their rates."""
    wide = drive * math.sqrt(x * x + y * y) + level
    high = drive * abs(z) + upright
    return wide * wide + high * high


@compiled
def fill_ease(designs, places, drive, upright, level, out):
    """Fills 1 / friction."""
    for d in range(len(designs)):
        la, lb, height, side = designs[d, 0], designs[d, 1], designs[d, 4], designs[d, 5]
        a = designs[d, 2] - designs[d, 3]
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        for k in range(len(px)):
            one, two, three = _forearms(side * px[k], side * py[k], height + side * (1.0 + pz[k]), a, la, lb)
            closure = min(one[0], two[0], three[0])
            w1, w2, w3 = la * max(one[1], FOLD), la * max(two[1], FOLD), la * max(three[1], FOLD)
            x1, y1, z1 = one[2] / w1, one[3] / w1, one[4] / w1
            x2, y2, z2 = two[2] / w2, two[3] / w2, two[4] / w2
            x3, y3, z3 = three[2] / w3, three[3] / w3, three[4] / w3
            most = max(
                _square(drive, upright, level, x1 + x2 + x3, y1 + y2 + y3, z1 + z2 + z3),
                _square(drive, upright, level, x1 + x2 - x3, y1 + y2 - y3, z1 + z2 - z3),
                _square(drive, upright, level, x1 - x2 + x3, y1 - y2 + y3, z1 - z2 + z3),
                _square(drive, upright, level, x1 - x2 - x3, y1 - y2 - y3, z1 - z2 - z3),
            )
            out[d, k] = closure if closure < 0.0 else 1.0 / math.sqrt(most)


@inlined
def _face(lever, one, other):
    """Computes the cross product of two chains' forearms, times a lever."""
    _, _, x, y, z, _, _, _ = one
    _, _, u, v, w, _, _, _ = other
    return lever * (y * w - z * v), lever * (z * u - x * w), lever * (x * v - y * u)


@compiled
def fill_farthest(designs, places, out):
    """Fills the determinant times the longest way of the handle."""
    for d in range(len(designs)):
        la, lb, height, side = designs[d, 0], designs[d, 1], designs[d, 4], designs[d, 5]
        a = designs[d, 2] - designs[d, 3]
        row = d if len(places) > 1 else 0
        px, py, pz = places[row, 0], places[row, 1], places[row, 2]
        for k in range(len(px)):
            one, two, three = _forearms(side * px[k], side * py[k], height + side * (1.0 + pz[k]), a, la, lb)
            x1, y1, z1 = _face(la * one[1], two, three)
            x2, y2, z2 = _face(la * two[1], three, one)
            x3, y3, z3 = _face(la * three[1], one, two)
            most = max(
                (x1 + x2 + x3) ** 2 + (y1 + y2 + y3) ** 2 + (z1 + z2 + z3) ** 2,
                (x1 + x2 - x3) ** 2 + (y1 + y2 - y3) ** 2 + (z1 + z2 - z3) ** 2,
                (x1 - x2 + x3) ** 2 + (y1 - y2 + y3) ** 2 + (z1 - z2 + z3) ** 2,
                (x1 - x2 - x3) ** 2 + (y1 - y2 - y3) ** 2 + (z1 - z2 - z3) ** 2,
            )
            out[d, k] = math.sqrt(most)
