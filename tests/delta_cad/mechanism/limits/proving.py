"""What tests ask of any one limit that is proven over a cube, and where they ask it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np

from delta_cad.mechanism import Cube, DeltaGeometry, closure_margin
from delta_cad.mechanism.limits import (
    POSE_LIMITS,
    FigureOfMerit,
    HandleFriction,
    HandleInertia,
    HeldMasses,
    Limits,
    PoseLimit,
)
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.proof.findings import Finding
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import CubeSearch
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED

VALUES: dict[str, Any] = {
    "force_N": 3.0,
    "inertia": HandleInertia(0.06, 0.01, 0.004, 2e-4),
    "held_masses": HeldMasses(0.5, 1.0, -9.8, 0.08, 0.003, -4e-4, 4e-5, 3e-6),
    "friction": HandleFriction(0.012, 0.05, 0.08),
    "encoder_count": 3.8e-4,
}
"""What limits need of a machine, beside its lengths."""
CUBE = Cube(BOTTOM, HALF)
FIGURES = [(kind, figure) for kind in POSE_LIMITS for figure in kind.figures]
BOUNDED = [(kind, figure) for kind, figure in FIGURES if figure.threshold]


def stated(kind: type[PoseLimit], figure: FigureOfMerit, machine: Mapping[str, Any], threshold: float) -> PoseLimit:
    """A limit on one figure."""
    limit = kind.measured(machine)
    assert limit is not None
    return limit.with_bound(figure, min(max(threshold, figure.range[0]), figure.range[1]))


def moved(figure: FigureOfMerit, value: float, share: float) -> float:
    """A threshold laxer than a value by a share of it, or by so many SI units; stricter for a negative share."""
    return value + (share if figure.upper else -share) * (abs(value) if figure.relative else 1.0)


@cache
def extremes(g: DeltaGeometry = PUBLISHED, cube: Cube = CUBE, n: int = 41) -> dict[FigureOfMerit, float]:
    """The worst of every figure that a search of a cube finds.

    Raises:
        UnreachableError: A chain cannot be closed in a point of the cube.
    """
    search = CubeSearch(cube, n)
    search.singularity(g)
    return {figure: worst_of(search, g, kind.measured(VALUES), figure).value for kind, figure in FIGURES}


def around(found: Mapping[FigureOfMerit, float], share: float, *names: str) -> Limits:
    """Limits, all or some by name, that are laxer than the worst figures by a share or an amount, see `moved`."""
    every = []
    for kind in POSE_LIMITS:
        limit = kind.measured(VALUES)
        for figure in kind.figures:
            if figure.threshold and kind.name in (names or (kind.name,)):
                limit = limit.with_bound(figure, max(moved(figure, found[figure], share), figure.range[0]))
        every.append(limit if kind.name in (*(names or (kind.name,)), "assembly_mode") else None)
    return Limits.of(*every)


def poses(
    rng: np.random.Generator, n: int, least_w2: float = 1e-5, placed: bool = False
) -> Iterator[tuple[DeltaGeometry, np.ndarray]]:
    """n mechanisms and positions at which all chains are closed by a margin, m^2; placed anywhere or symmetric."""
    while n:
        g = DeltaGeometry(*rng.uniform([0.01, 0.01, 0.04, 0.05], [0.08, 0.08, 0.1, 0.2]))
        if placed:
            g = replace(g, side_shift=rng.uniform(0.01, 0.08) - g.base_radius, side_cosine=rng.uniform(-0.86, 0.5))
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
    origin = np.array([cube.centre_x - cube.half_side, 0.0, cube.bottom_height])
    edges = np.array([2.0 * cube.half_side, cube.half_side, 2.0 * cube.half_side])
    size = edges / 2.0 ** cells[:, ::2]
    low = origin + cells[:, 1::2] * size
    return low, np.minimum(low + size, cube.upper)
