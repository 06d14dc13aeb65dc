"""Outcome of a proof: which condition holds in the whole cube, and where one does not; NumPy only."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from delta_cad.mechanism.angles import rod_lean
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import elbow_arm, joint_angles
from delta_cad.mechanism.proof.limits import Limits
from delta_cad.mechanism.statics import conditioning, direct_margin, worst_joint_torque

Verdict = Literal["proved", "refuted", "undecided"]


@dataclass(frozen=True)
class Finding:
    """What became of one condition.

    Attributes:
        condition: Its name, one of `CONDITIONS`.
        verdict: Proved for every point of the cube; refuted at `point`; or undecided, `box` being where it stopped.
        limit: What was allowed, in SI units; the limits' pair for the shoulder.
        point: Point of the cube that breaks the condition for certain, m.
        value: The figure at that point, in plain double arithmetic; the worst chain's.
        box: Lower and upper corner of a box in which the condition could not be decided, m.
    """

    condition: str
    verdict: Verdict
    limit: float | tuple[float, float]
    point: tuple[float, float, float] | None = None
    value: float | None = None
    box: tuple[tuple[float, float, float], tuple[float, float, float]] | None = None


@dataclass(frozen=True)
class Proof:
    """The outcome of a proof.

    Attributes:
        findings: One for each condition that was asked.
        sign: Sign of det S at `reference`; the singularity condition is that it holds in the whole cube.
        reference: Centre of the cube, or a corner where the centre's sign is not certain, m.
        leaves: (n, 6) integers kx, ix, ky, iy, kz, iz: the boxes that cover [-L, L] x [0, L] x [H, z_max], each
            [i, i + 1] / 2^k of every edge. On each of them every condition of verdict proved was proved; complete
            only if there is one.
        boxes: Boxes examined.
        depth: Most halvings, over all edges, of a leaf.
    """

    findings: tuple[Finding, ...]
    sign: float
    reference: tuple[float, float, float]
    leaves: np.ndarray
    boxes: int
    depth: int

    @property
    def verdict(self) -> Verdict:
        """Refuted if any condition is, else undecided if any is, else proved."""
        verdicts = {finding.verdict for finding in self.findings}
        for verdict in ("refuted", "undecided"):
            if verdict in verdicts:
                return verdict
        return "proved"


def limit_of(limits: Limits, condition: str) -> float | tuple[float, float]:
    """The number, or pair, that a condition was given.

    Args:
        limits: The conditions.
        condition: Name of one that is asked.

    Returns:
        SI units; 0 for the determinant's sign.
    """
    if condition == "singularity":
        return 0.0
    field = {"reach": "elbow_arm_min", "torque": "torque_max", "kappa": "kappa_max", "lean": "lean_max"}
    value = getattr(limits, field.get(condition, condition))
    return (float(value[0]), float(value[1])) if condition == "shoulder" else float(value)


def figure(g: DeltaGeometry, limits: Limits, sign: float, condition: str, point: np.ndarray) -> float:
    """The worst chain's figure that a condition limits, in plain double arithmetic.

    Args:
        g: The mechanism.
        limits: The conditions.
        sign: Of det S at the reference point.
        condition: Name of the condition.
        point: (3,) position, m.

    Returns:
        SI units; the determinant of unit forearms times the sign; NaN where a chain is open.
    """
    if condition == "reach":
        return float(elbow_arm(g, point).min())
    if condition == "singularity":
        return float(sign * direct_margin(g, point))
    if condition == "torque":
        return float(worst_joint_torque(g, point, limits.force or 0.0).max())
    if condition == "kappa":
        return float(conditioning(g, point))
    if condition == "lean":
        return float(np.abs(rod_lean(g, point)).max())
    low, high = limits.shoulder or (0.0, 0.0)
    theta = joint_angles(g, point)
    return float(theta[np.argmax(np.maximum(low - theta, theta - high))])
