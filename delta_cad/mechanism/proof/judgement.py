"""The verdict on each figure over a cube: what the proof decides, with the worst value that is known.

`inspect`, `check` and `build` judge a machine here; `certify` asks `prove` itself, whose verdict this is.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Literal

import numpy as np

from delta_cad.mechanism.errors import UnreachableError
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits import POSE_LIMITS, FigureOfMerit, Limits, PoseLimit
from delta_cad.mechanism.proof.extremes import WorstFigure, worst_figures, worst_of
from delta_cad.mechanism.proof.findings import Box, Verdict
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import Cube, CubeSearch


@dataclass(frozen=True)
class Judgement:
    """One figure over a cube, judged.

    Attributes:
        limit: Limit that bounds the figure, or only measures it.
        figure: The figure.
        value: Its worst value, SI units: the polished extreme, or what the proof found beyond it; never beyond a
            threshold that is proved. Infinite where the cube holds a direct singularity.
        position: Where that is, m.
        verdict: Of the proof; "searched" where nothing was proved and the search found nothing beyond the threshold;
            None where nothing bounds the figure.
        box: Lower and upper corner of a box in which the proof could not decide, m.
    """

    limit: PoseLimit
    figure: FigureOfMerit
    value: float
    position: tuple[float, float, float]
    verdict: Verdict | Literal["searched"] | None
    box: Box | None = None

    @property
    def holds(self) -> bool | None:
        """Whether the threshold is kept, as far as the verdict tells; None where there is none."""
        return None if self.verdict is None else self.verdict in ("proved", "searched")


def can_prove() -> bool:
    """Tells whether numba is installed, which compiles the proof."""
    return find_spec("numba") is not None


def judge(
    g: DeltaGeometry, cube: Cube, limits: Limits, others: Iterable[PoseLimit] = (), proof: bool = True
) -> list[Judgement]:
    """Judges limits over a cube, and measures others.

    Args:
        g: The mechanism.
        cube: The cube.
        limits: The limits that count.
        others: Limits whose figures are only measured.
        proof: Whether to prove; otherwise what the search finds decides.

    Returns:
        One for each figure, in the order of the registry; of reach alone where the cube is not proved to be within
        reach, because the other figures mean nothing where a chain is open.
    """
    measured = sorted((*limits, *others), key=lambda limit: POSE_LIMITS.index(type(limit)))  # reach is the first
    try:
        found = worst_figures(g, cube, measured)
    except UnreachableError:
        reach, figure = measured[0], measured[0].figures[0]
        found = [WorstFigure(reach, figure, *worst_of(CubeSearch(cube), g, reach, figure))]
    judged: list[Judgement] = []
    for one in found:
        if one.limit in limits.each:
            judged.append(_judged(g, cube, one, Limits.of(measured[0], one.limit.only(one.figure)), proof))
        else:
            judged.append(Judgement(*one, verdict=None))
        if one.limit.always and not judged[-1].holds:
            return judged[-1:]
    return judged


def _judged(g: DeltaGeometry, cube: Cube, worst: WorstFigure, limits: Limits, proof: bool) -> Judgement:
    """Judges one figure by the proof of its limit, in which no other figure is bounded but that of reach."""
    limit, figure, value, position = worst
    bound = limit.bound(figure)
    if not proof:
        kept = figure.stricter(value, bound) == value and not (limit.strict and value == bound)
        return Judgement(limit, figure, value, position, "searched" if kept else "refuted")
    finding = next(f for f in prove(g, cube, limits).findings if f.condition == limit.name)
    if finding.point is not None:
        there = float(figure.worst(limit, g, np.array(finding.point)))
        if there > value if figure.upper else there < value:
            value, position = there, finding.point
    if finding.verdict == "proved":
        value = figure.stricter(value, bound)
    return Judgement(limit, figure, value, position, finding.verdict, finding.box)
