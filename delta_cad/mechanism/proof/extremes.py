"""The worst figure of every limit over a cube: searched, not proved; where a proof of its bound begins."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits import FigureOfMerit, PoseLimit
from delta_cad.mechanism.workspace import Cube, CubeSearch, Extreme


class WorstFigure(NamedTuple):
    """The worst value of one figure over a cube.

    Attributes:
        limit: Limit that measures the figure, whatever it bounds.
        figure: The figure.
        value: SI units; infinite where the cube holds a direct singularity.
        position: Place of the worst value, m.
    """

    limit: PoseLimit
    figure: FigureOfMerit
    value: float
    position: tuple[float, float, float]


def worst_figures(g: DeltaGeometry, cube: Cube, limits: Iterable[PoseLimit]) -> list[WorstFigure]:
    """Searches the cube for the worst of every figure of some limits.

    Args:
        g: The mechanism.
        cube: The cube.
        limits: The limits, such as `Limits.measured` gives; their thresholds do not count.

    Returns:
        One for each figure, in the order given.

    Raises:
        UnreachableError: A chain cannot be closed in a point of the cube; the message names chain and point.
    """
    search = CubeSearch(cube)
    _, crossing = search.singularity(g)
    figures: list[WorstFigure] = []
    for limit in limits:
        for figure in limit.figures:
            if crossing is not None and limit.infinite_at_singularity:
                worst = Extreme(math.inf, crossing)
            else:
                worst = worst_of(search, g, limit, figure)
            figures.append(WorstFigure(limit, figure, worst.value, worst.position))
    return figures


def worst_of(search: CubeSearch, g: DeltaGeometry, limit: PoseLimit, figure: FigureOfMerit) -> Extreme:
    """Searches a cube for the worst of one figure, SI units; NaN, where a chain is open, counts as none."""
    return search(lambda p: figure.worst(limit, g, p), -1.0 if figure.upper else +1.0)
