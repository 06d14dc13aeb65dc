"""Limits on every position of the cube, proved; the figure of each is its worst over the whole cube."""

from __future__ import annotations

import numpy as np

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.limits.limit import DEGREE
from delta_cad.mechanism.proof.judgement import Judgement, judge

_DIGITS = 12  # of an angle in degrees: again the one stated, which the proof takes two doubles more strictly


def check_ranges(geometry: DeltaGeometry, limits: CheckLimits) -> list[CheckResult]:
    """Judges every figure that the limits bound.

    Returns:
        One for each figure, in the order of the registry; reach alone where it fails, for nothing else has a meaning.
    """
    return [_result(judgement, geometry) for judgement in judge(geometry, limits.workspace, limits.pose)]


def _result(judged: Judgement, geometry: DeltaGeometry) -> CheckResult:
    """The worst chain's figure against its threshold, in people's unit."""
    limit, figure, position = judged.limit, judged.figure, np.array(judged.position)
    x, y, z = (position * MM_PER_M).tolist()
    chains = figure.values(limit, geometry, position)
    pair = () if len(chains) == 1 else (f"chain_{np.argmax(chains) if figure.upper else np.argmin(chains)}",)
    detail = f"{figure.words}, {judged.verdict} over the whole cube; the value is the worst that was found"
    if judged.box is not None:
        ends = ("({:.4f}, {:.4f}, {:.4f})".format(*(MM_PER_M * v for v in end)) for end in judged.box)
        detail += f"; the proof cannot decide at {' to '.join(dict.fromkeys(ends))} mm, where it is at the limit"
    allowed = limit.bound(figure) * figure.scale
    if figure.scale == DEGREE:
        allowed = float(f"{allowed:.{_DIGITS}g}")
    name = (figure.name or limit.name).replace("_", " ")
    value = judged.value * figure.scale
    return CheckResult(name, judged.verdict == "proved", value, allowed, figure.unit, (x, y, z), pair, detail)
