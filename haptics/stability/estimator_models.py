"""Velocity estimators as linear filters: the form in which stability and passivity of a loop take them.

This module is light; the estimators themselves (`haptics.control.filters`) are only loaded by who makes models of them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from haptics.control.filters import Estimator

# Response to a constant position, as a share of the largest coefficient, up to which rounding explains it.
SETTLED = 1e-9


@dataclass(frozen=True)
class LinearEstimator:
    """A linear filter from sampled positions to a velocity.

    `v_k = sum_i numerator[i] x_(k-i) - sum_(j >= 1) denominator[j] v_(k-j)`.

    Attributes:
        name: Name in reports.
        numerator: 1/s, from the newest sample back.
        denominator: Dimensionless, its first is 1.

    Raises:
        ValueError: A coefficient is not finite, the first of the denominator is not 1, or a handle that stands still
            would have a velocity.
    """

    name: str
    numerator: tuple[float, ...]
    denominator: tuple[float, ...] = (1.0,)

    def __post_init__(self) -> None:
        if not self.numerator or not all(math.isfinite(c) for c in (*self.numerator, *self.denominator)):
            raise ValueError(f"estimator {self.name}: its coefficients must be finite")
        if not self.denominator or self.denominator[0] != 1.0:
            raise ValueError(f"estimator {self.name}: the first coefficient of the denominator must be 1")
        if abs(sum(self.numerator)) > SETTLED * max(abs(c) for c in self.numerator):
            raise ValueError(f"estimator {self.name}: a handle that stands still would have a velocity")

    def response(self, z: np.ndarray) -> np.ndarray:
        """Transfer function at points of the complex plane.

        Args:
            z: (...) complex.

        Returns:
            (...) complex, 1/s.
        """
        back = 1.0 / np.asarray(z, dtype=complex)
        top = np.polynomial.polynomial.polyval(back, np.array(self.numerator))
        return top / np.polynomial.polynomial.polyval(back, np.array(self.denominator))

    def realisation(self) -> tuple[np.ndarray, np.ndarray, float]:
        """State space `w+ = A w + b x`, `v = w[0] + d x` (transposed direct form).

        Returns:
            A (n, n), b (n,) in 1/s, d in 1/s; n may be 0.
        """
        n = max(len(self.numerator), len(self.denominator)) - 1
        top, bottom = np.zeros(n + 1), np.zeros(n + 1)
        top[: len(self.numerator)] = self.numerator
        bottom[: len(self.denominator)] = self.denominator
        step = np.eye(n, k=1)
        step[:, :1] -= bottom[1:, None]
        return step, top[1:] - bottom[1:] * top[0], float(top[0])


def linear_models(estimator: Estimator) -> tuple[LinearEstimator, ...]:
    """Linear filter that an estimator of the controller is equivalent to.

    Args:
        estimator: Estimator of `haptics.control.filters`.

    Returns:
        One model of a difference or a low-pass. Of an adaptive window (FOAW) one for each window that it may hold: 1,
        2, 4, ... periods and its longest; a result for it is the interval over these. A window that changes while the
        handle oscillates is no linear filter, and is left to the simulated loop.
    """
    from haptics.control.filters import FOAW_BEST, FOAW_END, LOW_PASS, transfer

    def model(name: str, window: int | None) -> LinearEstimator:
        top, bottom = transfer(estimator, window)
        return LinearEstimator(name, tuple(top.tolist()), tuple(bottom.tolist()))

    if estimator.kind not in (FOAW_END, FOAW_BEST):
        return (model("low-pass" if estimator.kind == LOW_PASS else "difference", None),)
    fit = "best" if estimator.kind == FOAW_BEST else "end"
    windows = sorted({2**k for k in range(estimator.window.bit_length())} | {estimator.window})
    return tuple(model(f"{fit} fit over {window}", window) for window in windows)
