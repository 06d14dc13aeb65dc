"""The worst figure of every limit over a cube: searched, not proved; where a proof of its bound begins."""

from __future__ import annotations

import math
from typing import NamedTuple

from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits import POSE_LIMITS, FigureOfMerit, PoseLimit, Values
from delta_cad.mechanism.workspace import Cube, CubeSearch, Extreme


class WorstFigure(NamedTuple):
    """The worst value of one figure over a cube.

    Attributes:
        limit: Limit that measures the figure; it bounds nothing.
        figure: The figure.
        value: SI units; infinite where the cube holds a direct singularity.
        position: Place of the worst value, m.
    """

    limit: PoseLimit
    figure: FigureOfMerit
    value: float
    position: tuple[float, float, float]


def worst_figures(g: DeltaGeometry, cube: Cube, values: Values) -> list[WorstFigure]:
    """Searches the cube for the worst of every figure that a limit can bound.

    Args:
        g: The mechanism.
        cube: The cube.
        values: Fields of a requirements file, and what else is known: a limit whose numbers are missing is left out.

    Returns:
        One for each figure, in the order of the registry.

    Raises:
        UnreachableError: A chain cannot be closed in a point of the cube; the message names chain and point.
    """
    search = CubeSearch(cube)
    _, crossing = search.singularity(g)
    figures: list[WorstFigure] = []
    for kind in POSE_LIMITS:
        limit = kind.measured(values)
        if limit is None:
            continue
        for figure in kind.figures:
            if crossing is not None and kind.infinite_at_singularity:
                worst = Extreme(math.inf, crossing)
            else:
                worst = search(lambda p, f=figure, k=limit: f.worst(k, g, p), -1.0 if figure.upper else +1.0)
            figures.append(WorstFigure(limit, figure, worst.value, worst.position))
    return figures
