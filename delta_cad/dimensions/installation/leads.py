"""The leads of a motor: each leaves its back along the axis and bends inwards beside it, its end free.

Inwards, and level: an outline's rectangle has the motors' backs at its edge, and a bend down would stand out there.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, radians, sin

from delta_cad import catalogue
from delta_cad.design import Design

LEAD_MM = 2.3  # outside diameter of a silicone lead of 0.5 mm^2; makers' tables: 2.1 to 2.3; from memory
LEAD_G_M = 9.0  # 4.5 of copper, the rest silicone
BEND = 3.0  # least inner radius, in diameters, of a flexible lead that is laid once: DIN VDE 0298-3; from memory
PLUG_MM = 3.0  # straight behind the motor: a push-on plug, or solder under its sleeve
TAIL_MM = 5.0  # straight after the bend
APART_MM = 5.0  # of neighbouring leads
SQUARE_DEG = (0.0, 30.0, 60.0, 90.0)  # of a bend, where it is square to a side of the outline: chains are 120 deg apart
COUNTS = {"brushed": 2, "brushless": 3}  # those of sensors are thinner, and are not drawn


@dataclass(frozen=True)
class LeadDimensions:
    """Leads of one motor.

    Attributes:
        diameter_mm: Of a lead.
        bend_mm: Radius of its middle line.
        across_mm: Where they leave the motor's back, across its axis and upright.
    """

    diameter_mm: float
    bend_mm: float
    across_mm: tuple[float, ...]

    @property
    def behind_mm(self) -> float:
        """How far they reach behind the motor's back."""
        return PLUG_MM + self.bend_mm + self.diameter_mm / 2.0

    @property
    def outside_mm(self) -> list[tuple[float, float]]:
        """Where, seen from above, a lead stands out farthest in any direction of the outline: outwards, behind."""
        outer, turns = self.bend_mm + self.diameter_mm / 2.0, [radians(angle) for angle in SQUARE_DEG]
        bend = [(outer * cos(turn) - self.bend_mm, outer * sin(turn) + PLUG_MM) for turn in turns]
        return [*bend, (-self.bend_mm - TAIL_MM, self.behind_mm)]

    @property
    def length_mm(self) -> float:
        """Length of what is drawn of one."""
        return PLUG_MM + pi / 2.0 * self.bend_mm + TAIL_MM


def lead_dimensions(design: Design, motor: catalogue.Motor) -> LeadDimensions | None:
    """Dimensions the leads behind a motor; None where the design draws none.

    Args:
        design: The design.
        motor: Its motor.
    """
    if design.hardware.leads != "bent":
        return None
    count = COUNTS[motor.commutation]
    across = tuple(APART_MM * (k - (count - 1) / 2.0) for k in range(count))
    return LeadDimensions(LEAD_MM, (BEND + 0.5) * LEAD_MM, across)
