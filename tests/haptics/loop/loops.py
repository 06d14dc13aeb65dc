"""A linear device seen along one axis, and what a range of gains looks like."""

from __future__ import annotations

import numpy as np

from haptics.loop.discrete import LinearEstimator, SampledLoop, StableGains, Timing, axis, sampled_loop
from haptics.loop.linear import Linearised
from haptics.model.plant import Hand


def axis_loop(
    here: Linearised, normal: np.ndarray | list[float], hand: Hand, timing: Timing, estimator: LinearEstimator
) -> SampledLoop:
    """A wall seen along its normal alone, with the effective mass and friction; gains in N/m and N s/m."""
    return sampled_loop(axis(here.effective_mass(normal), here.effective_friction(normal), hand), timing, estimator)


def monotone(found: StableGains) -> bool:
    """Whether it is stable up to one gain and nowhere above it (as far as the scan sees)."""
    return not found.intervals or (len(found.intervals) == 1 and found.intervals[0][0] == 0.0)
