"""The figures of many designs compiled: the same numbers as `evaluator.figures`, ten to fifty times as fast.

Importing this module loads numba and, once on a machine, compiles for some seconds. The condition number is that of the
mechanism's kernel; the chains are continued beyond the reach as in the evaluator.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from delta_cad.mechanism.geometry import RADIAL
from delta_cad.mechanism.kernel import _kappa

ROOT_3_4 = float(RADIAL[1, 1])
TINY = float(np.finfo(float).tiny)


def figures_compiled(designs: np.ndarray, points: np.ndarray, conditioning: bool, out: np.ndarray) -> None:
    """Fills the six figures of `evaluator.Figures`.

    Args:
        designs: (D, 6) lengths in the order of `VARIABLES`, m.
        points: (D, K, 3) or (1, K, 3) points in the coordinates of the cube.
        conditioning: Whether `quality` is wanted; ones without.
        out: (6, D, K) filled.
    """
    _fill(np.ascontiguousarray(designs), np.ascontiguousarray(points), bool(conditioning), out)


@njit(inline="always", error_model="numpy")
def _chain(q, t, z, la, lb):
    """w^2 / L_B^2, w / L_B, the unit forearm along the radius and along z, and theta; w as 0 beyond the reach."""
    rho2 = max(q * q + z * z, TINY)
    m = (rho2 + t * t + la * la - lb * lb) / (2.0 * la)
    w2 = rho2 - m * m
    w = math.sqrt(max(w2, 0.0))
    cos, sin = (q * m + z * w) / rho2, (z * m - q * w) / rho2
    return w2 / (lb * lb), w / lb, (q - la * cos) / lb, (z - la * sin) / lb, math.atan2(sin, cos)


@njit(cache=True, error_model="numpy")
def _fill(designs, points, conditioning, out):
    """See `figures_compiled`."""
    for d in range(len(designs)):
        la, lb, height, side = designs[d, 0], designs[d, 1], designs[d, 4], designs[d, 5]
        a = designs[d, 2] - designs[d, 3]
        row = d if len(points) > 1 else 0
        for k in range(points.shape[1]):
            x, y = side * points[row, k, 0], side * points[row, k, 1]
            z = height + side * (1.0 + points[row, k, 2])
            xc, yc, xs, ys = -0.5 * x, -0.5 * y, ROOT_3_4 * x, ROOT_3_4 * y
            t2, t3 = yc - xs, yc + xs
            c1, w1, r1, z1, th1 = _chain(x - a, y, z, la, lb)
            c2, w2, r2, z2, th2 = _chain(xc + ys - a, t2, z, la, lb)
            c3, w3, r3, z3, th3 = _chain(xc - ys - a, t3, z, la, lb)
            t1, t2, t3 = y / lb, t2 / lb, t3 / lb
            x1, y1 = r1, t1
            x2, y2 = -0.5 * r2 - ROOT_3_4 * t2, ROOT_3_4 * r2 - 0.5 * t2
            x3, y3 = -0.5 * r3 + ROOT_3_4 * t3, -ROOT_3_4 * r3 - 0.5 * t3
            fx, fy, fz = y2 * z3 - z2 * y3, z2 * x3 - x2 * z3, x2 * y3 - y2 * x3
            det = x1 * fx + y1 * fy + z1 * fz
            n1 = fx * fx + fy * fy + fz * fz
            fx, fy, fz = y3 * z1 - z3 * y1, z3 * x1 - x3 * z1, x3 * y1 - y3 * x1
            n2 = fx * fx + fy * fy + fz * fz
            fx, fy, fz = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
            n3 = fx * fx + fy * fy + fz * fz
            closure = min(c1, c2, c3)
            out[0, d, k] = closure
            out[1, d, k] = det
            out[2, d, k] = la * max(w1 * math.sqrt(n1), w2 * math.sqrt(n2), w3 * math.sqrt(n3))
            out[4, d, k] = min(th1, th2, th3)
            out[5, d, k] = max(th1, th2, th3)
            if not conditioning:
                out[3, d, k] = 1.0
            elif closure <= 0.0 or det == 0.0:
                out[3, d, k] = min(closure, 0.0)
            else:
                g12 = x1 * x2 + y1 * y2 + z1 * z2
                g13 = x1 * x3 + y1 * y3 + z1 * z3
                g23 = x2 * x3 + y2 * y3 + z2 * z3
                kappa = _kappa(w1, w2, w3, g12, g13, g23, n1, n2, n3, det, 1.0)
                out[3, d, k] = math.copysign(1.0, det) / kappa
