"""Independent oracles: the paper's equations in the paper's own form, and hypothesis' mechanisms and positions.

Nothing here calls the package's formulas; only the record `DeltaGeometry` is used.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from delta_cad.mechanism import DeltaGeometry

EPS = np.finfo(float).eps
PUBLISHED = DeltaGeometry(base_radius=0.040, platform_radius=0.030, upper_arm_length=0.082, forearm_length=0.112079)
BOTTOM, HALF = 0.057112, 0.0375  # the published cube with L = 37.5 mm, m
TABLES = json.loads((Path(__file__).parents[2] / "references" / "rcim2018.json").read_text())
PROPERTY = settings(deadline=None, derandomize=True, max_examples=150)


def rotation(degrees: float) -> np.ndarray:
    """(3, 3) rotation about z."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def paper_residual(g: DeltaGeometry, theta: np.ndarray, p: np.ndarray) -> np.ndarray:
    """(3,) left minus right side of [RCIM2018] eq. (1), m^2."""
    x, y, z = p
    out = np.empty(3)
    for i, degrees in enumerate((0.0, 120.0, 240.0)):
        phi = np.radians(degrees)
        reach = g.base_radius - g.platform_radius + g.upper_arm_length * np.cos(theta[i])
        out[i] = (reach * np.cos(phi) - x) ** 2 + (reach * np.sin(phi) - y) ** 2
        out[i] += (z - g.upper_arm_length * np.sin(theta[i])) ** 2 - g.forearm_length**2
    return out


def paper_abc(g: DeltaGeometry, p: np.ndarray, i: int) -> tuple[float, float, float]:
    """Coefficients of A cos th + B sin th + C = 0, [RCIM2018] eqs. (2)-(5)."""
    x, y, z = p
    phi = np.radians(120.0 * i)
    u = x * np.cos(phi) + y * np.sin(phi)
    la, lb, a = g.upper_arm_length, g.forearm_length, g.base_radius - g.platform_radius
    return 2 * la * (a - u), -2 * la * z, la**2 - lb**2 + a**2 + x**2 + y**2 + z**2 - 2 * a * u


def paper_h(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """(3,) h_i of [RCIM2018] eqs. (6)-(7), m^4; the chain closes where it is not positive."""
    return np.array([c * c - a * a - b * b for a, b, c in (paper_abc(g, p, i) for i in range(3))])


def paper_angles(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """(3 chains, 2 roots) both shoulder angles by the half-angle tangent, the outward elbow first (z > 0)."""
    roots = np.empty((3, 2))
    for i in range(3):
        a, b, c = paper_abc(g, p, i)
        root = np.sqrt(max(b * b + a * a - c * c, 0.0))
        pair = [2.0 * np.arctan2(-b + sign * root, c - a) for sign in (1.0, -1.0)]
        roots[i] = sorted(pair, key=lambda theta: -np.cos(theta))
    return roots


@st.composite
def mechanisms(draw: st.DrawFn) -> DeltaGeometry:
    """Mechanisms of a joystick's size with every proportion that could matter."""
    return DeltaGeometry(
        base_radius=draw(st.floats(0.01, 0.08)),
        platform_radius=draw(st.floats(0.01, 0.08)),
        upper_arm_length=draw(st.floats(0.04, 0.10)),
        forearm_length=draw(st.floats(0.05, 0.20)),
    )


@st.composite
def placed_mechanisms(draw: st.DrawFn) -> DeltaGeometry:
    """The same with chains 1 and 2 anywhere, in mirror symmetry."""
    g = draw(mechanisms())
    shift, cosine = draw(st.floats(0.01, 0.08)) - g.base_radius, draw(st.floats(-0.86, 0.5))
    return replace(g, side_shift=shift, side_cosine=cosine)


def points(reach: float = 0.06, top: float = 0.2) -> st.SearchStrategy[np.ndarray]:
    """Positions above the base plane."""
    side = st.floats(-reach, reach)
    return st.tuples(side, side, st.floats(0.02, top)).map(np.array)


def edge_of_reach(g: DeltaGeometry, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """Last position on the way out at which the paper's h says that all chains close."""
    for _ in range(60):
        middle = (inside + outside) / 2.0
        if (paper_h(g, middle) <= 0.0).all():
            inside = middle
        else:
            outside = middle
    return inside
