"""What tests ask of any one limit that is proven over a cube, and where they ask it."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal

import numpy as np

from delta_cad.mechanism import Cube, DeltaGeometry, closure_margin
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.limits import Limits
from delta_cad.mechanism.limits.limit import PoseLimit
from delta_cad.mechanism.proof.findings import Finding
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from delta_cad.mechanism.proof.prove import prove
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins


def bounds(g: DeltaGeometry, limit: PoseLimit, box: np.ndarray) -> tuple[float, float]:
    """Lower and upper bound of a limit's first margin over a box: centre, half sides, tolerance, m."""
    pose, work, out = room()
    margins(box, numbers(g, Limits.of(limit)), BITS[type(limit)], pose, work, out)
    row = FIRST[type(limit)]
    return out[row, LOW], out[row, HIGH]


def exact(g: DeltaGeometry, limit: PoseLimit, point: np.ndarray) -> Decimal | None:
    """The one margin of a limit in 50 digits; None where a chain is open."""
    (value,) = exact_margins(g, Limits.of(limit), tuple(map(float, point)))[type(limit)]
    return value


def poses(rng: np.random.Generator, n: int, least_w2: float = 1e-5) -> Iterator[tuple[DeltaGeometry, np.ndarray]]:
    """n mechanisms and positions at which all chains are closed by a margin, m^2."""
    while n:
        g = DeltaGeometry(*rng.uniform([0.01, 0.01, 0.04, 0.05], [0.08, 0.08, 0.1, 0.2]))
        p = rng.uniform([-0.05, -0.05, 0.01], [0.05, 0.05, 0.2])
        if (closure_margin(g, p) > least_w2).all():
            n -= 1
            yield g, p


def verdict(g: DeltaGeometry, cube: Cube, limit: PoseLimit) -> Finding:
    """What the proof of a cube says of a limit."""
    (finding,) = (f for f in prove(g, cube, Limits.of(limit)).findings if f.condition == limit.name)
    return finding


def leaves(cube: Cube, cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lower and upper corners of the boxes that cover half the cube, as a proof tells them."""
    origin = np.array([-cube.half_side, 0.0, cube.bottom_height])
    edges = np.array([2.0 * cube.half_side, cube.half_side, 2.0 * cube.half_side])
    size = edges / 2.0 ** cells[:, ::2]
    low = origin + cells[:, 1::2] * size
    return low, np.minimum(low + size, cube.upper)
