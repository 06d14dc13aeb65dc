"""Outcome of a proof: which limit holds in the whole cube, and where one does not; NumPy only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Verdict = Literal["proved", "refuted", "undecided"]
Box = tuple[tuple[float, float, float], tuple[float, float, float]]
"""Lower and upper corner, m."""


@dataclass(frozen=True)
class Finding:
    """Outcome of the proof of one condition.

    Attributes:
        condition: Its name, the name of a limit.
        verdict: Proved for every point of the cube; refuted at `point`; or undecided, `box` being where it stopped.
        limit: Threshold of the condition, in SI units; the limits' pair for the shoulder.
        point: Point of the cube that breaks the condition for certain, m.
        value: The figure at that point, in plain double arithmetic; the worst chain's.
        box: Lower and upper corner of a box in which the condition could not be decided, m.
    """

    condition: str
    verdict: Verdict
    limit: float | tuple[float, ...]
    point: tuple[float, float, float] | None = None
    value: float | None = None
    box: Box | None = None


@dataclass(frozen=True)
class Proof:
    """The outcome of a proof.

    Attributes:
        findings: One for each condition.
        leaves: (n, 6) integers kx, ix, ky, iy, kz, iz: the boxes that cover [x_min, x_max] x [0, L] x [H, z_max], each
            [i, i + 1] / 2^k of every edge. On each of them every condition of verdict proved was proved; complete
            only if there is one.
        boxes: Boxes examined.
    """

    findings: tuple[Finding, ...]
    leaves: np.ndarray
    boxes: int

    @property
    def verdict(self) -> Verdict:
        """Refuted if any condition is, else undecided if any is, else proved."""
        verdicts = {finding.verdict for finding in self.findings}
        for verdict in ("refuted", "undecided"):
            if verdict in verdicts:
                return verdict
        return "proved"
