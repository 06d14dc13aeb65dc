"""What is asked of every point of a cube, and sines and cosines of its angles to the last bit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal, localcontext

from delta_cad.mechanism.errors import GeometryError

CONDITIONS = ("reach", "singularity", "torque", "kappa", "shoulder", "lean")
"""Names of the conditions, in the order in which they are tested and reported."""

FORCE_OR_TORQUE = (1e-6, 1e6)
"""N or N m: keeps every product of the proof far from underflow and overflow."""


@dataclass(frozen=True)
class Limits:
    """Conditions on every point of a cube; None, or False, leaves one out. Reach is always asked: the others need it.

    Attributes:
        elbow_arm_min: Smallest elbow arm w of every chain, m: reach, and the distance kept from its fold.
        singularity: Whether det S must keep one sign, that of the cube's centre.
        force: Force on the handle, N; goes with torque.
        torque_max: Largest torque of every joint over all directions of the force, N m.
        kappa_max: Largest condition number of the Jacobian.
        shoulder: Smallest and largest shoulder angle, rad, within [-pi, pi].
        lean_max: Largest lean of a rod out of its chain's plane either way, rad.

    Raises:
        GeometryError: A number is not finite, out of its range, or one of force and torque_max is missing.
    """

    elbow_arm_min: float = 0.0
    singularity: bool = True
    force: float | None = None
    torque_max: float | None = None
    kappa_max: float | None = None
    shoulder: tuple[float, float] | None = None
    lean_max: float | None = None

    def __post_init__(self) -> None:
        _require("elbow_arm_min", self.elbow_arm_min, 0.0 <= self.elbow_arm_min < math.inf, "at least 0 m and finite")
        if (self.force is None) != (self.torque_max is None):
            raise GeometryError("force and torque_max belong together; one of them is missing")
        if self.force is not None and self.torque_max is not None:
            low, high = FORCE_OR_TORQUE
            _require("force", self.force, low <= self.force <= high, "within 1e-6 and 1e6 N")
            _require("torque_max", self.torque_max, low <= self.torque_max <= high, "within 1e-6 and 1e6 N m")
        if self.kappa_max is not None:
            _require("kappa_max", self.kappa_max, 1.0 <= self.kappa_max <= 1e6, "within 1 and 1e6")
        if self.shoulder is not None:
            low, high = self.shoulder
            _require("shoulder", self.shoulder, -math.pi <= low < high <= math.pi, "rising, within -pi and pi rad")
        if self.lean_max is not None:
            _require("lean_max", self.lean_max, 0.0 < self.lean_max < math.pi / 2.0, "within 0 and pi/2 rad")

    @property
    def asked(self) -> tuple[str, ...]:
        """Names of the conditions that are not left out."""
        on = {
            "reach": True,
            "singularity": self.singularity,
            "torque": self.torque_max is not None,
            "kappa": self.kappa_max is not None,
            "shoulder": self.shoulder is not None,
            "lean": self.lean_max is not None,
        }
        return tuple(name for name in CONDITIONS if on[name])


def _require(name: str, value: object, holds: bool, allowed: str) -> None:
    if not holds:
        raise GeometryError(f"{name} is {value!r}; it must be {allowed}")


def cosine_sine(*terms: float) -> tuple[float, float]:
    """Cosine and sine of half the sum of some doubles, each the double nearest to the true value.

    The libraries' own functions promise no error bound; this is Taylor's series in 60 decimal digits.

    Args:
        terms: Angles whose halved sum, at most 4 in size, is the argument, rad.

    Returns:
        cos, sin: within 2^-53 of the true value.
    """
    with localcontext() as context:
        context.prec = 60
        x = sum((Decimal(t) for t in terms), Decimal(0)) / 2
        sums, term, k = [Decimal(1), Decimal(0)], Decimal(1), 0
        while abs(term) > Decimal("1e-50"):  # |x| <= 4: the terms fall from the fifth on
            k += 1
            term = term * x / k
            sums[k % 2] += -term if k % 4 >= 2 else term
            if term == 0:
                break
        return float(sums[0]), float(sums[1])
