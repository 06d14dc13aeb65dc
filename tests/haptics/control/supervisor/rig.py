"""A supervisor with a handle that a test puts where it likes; every tick's output is held to the limits by NumPy."""

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad.design import load_design
from delta_cad.drive.masses import Masses
from delta_cad.mechanism import DeltaGeometry, inverse_kinematics
from haptics.control.pose_margins import pose_margins
from haptics.control.supervisor.limits import SafetyLimits, safety_limits
from haptics.control.supervisor.safety import Supervisor
from haptics.model.motor_heat import Heat
from haptics.model.plant import Plant, plant
from tests.committed import PUBLISHED

DESIGN = load_design(PUBLISHED)
GEOMETRY: DeltaGeometry = DESIGN.geometry
MASSES = Masses(0.07, 0.0013, -0.0003, 1.5e-4, 0.002, 0.0008, 0.0021, 3.2e-4)
PLANT: Plant = plant(GEOMETRY, MASSES)
LIMITS: SafetyLimits = safety_limits(DESIGN)
HOME = np.array([0.0, 0.0, 0.0946])
ZERO = np.zeros(3)
ROUNDING = 1e-12
"""N m: outputs are sums of two torques below 1 N m, so their rounding is below 1e-15."""


def with_limits(limits: SafetyLimits = LIMITS, **changes: float) -> SafetyLimits:
    """Limits with other figures, those of the motor among them."""
    heat = {name: changes.pop(name) for name in Heat._fields if name in changes}
    return limits._replace(**changes, motor=limits.motor._replace(**heat))


class Rig:
    """Drives check and limit as a controller would."""

    def __init__(self, limits: SafetyLimits = LIMITS) -> None:
        self.supervisor = Supervisor(limits)
        self.limits, self.now, self.p = limits, 0.0, HOME.copy()
        self.out = np.zeros(3)
        self.wobble = 0

    def tick(
        self,
        rendered: Any = ZERO,
        gravity: Any = ZERO,
        *,
        dt: float | None = None,
        now: float | None = None,
        theta: Any = None,
        p: Any = None,
        margins: tuple[float, float] | None = None,
    ) -> np.ndarray:
        """One tick; the angles are those of `self.p` unless given."""
        self.now = self.now + (self.limits.period if dt is None else dt) if now is None else now
        place = self.p if p is None else np.asarray(p, dtype=float)
        angles = inverse_kinematics(GEOMETRY, self.p) if theta is None else np.asarray(theta, dtype=float)
        reach, volume = pose_margins(PLANT, place) if margins is None else margins
        self.supervisor.check(self.now, angles, place, reach, volume)
        return self.limited(rendered, gravity)

    def limited(self, rendered: Any = ZERO, gravity: Any = ZERO) -> np.ndarray:
        """The second half of a tick."""
        out = np.full(3, np.nan)
        self.supervisor.limit(np.asarray(rendered, dtype=float), np.asarray(gravity, dtype=float), out)
        assert np.isfinite(out).all()
        assert np.abs(out).max() <= self.limits.torque
        step = (self.limits.slew + self.limits.gravity_slew) * self.limits.period
        assert np.abs(out - self.out).max() <= step + ROUNDING
        self.out = out.copy()
        return out

    def ticks(self, number: int, rendered: Any = ZERO, gravity: Any = ZERO, **more: Any) -> np.ndarray:
        """Many alike; the handle trembles by 20 um, as in a hand, so that its encoders are seen to live."""
        rest = self.p.copy()
        for _ in range(number):
            self.wobble += 1
            self.p = rest + 2e-5 * np.array([np.sin(0.06 * self.wobble), np.cos(0.05 * self.wobble), 0.0])
            self.tick(rendered, gravity, **more)
        self.p = rest
        return self.out

    def glide(self, place: np.ndarray, rendered: Any = ZERO, gravity: Any = ZERO) -> np.ndarray:
        """Goes to a place in a straight line, at half a metre a second and with soft ends."""
        start, way = self.p.copy(), np.asarray(place, dtype=float) - self.p
        number = int(np.linalg.norm(way) / 5e-4) * 2 + 1
        for k in range(number):
            self.p = start + way * (1.0 - np.cos(np.pi * (k + 1) / number)) / 2.0
            self.tick(rendered, gravity)
        return self.out

    def ready(self) -> Rig:
        """Enabled and ramped up."""
        self.tick()
        self.supervisor.enable()
        self.ticks(round(self.limits.ramp / self.limits.period) + 3)
        return self
