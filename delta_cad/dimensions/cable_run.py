"""The cable between sector and pinion, developed into a plane: one straight line at every angle of the arm.

Each strand leaves the pinion along the groove's own helix. The sector's lugs are set outwards by as much as the strand
climbs on its way, so that the fleet angle is zero everywhere and the cable's length does not change. Both take-offs
walk along the pinion the same way as it turns, a constant distance apart.

Source: developed geometry of crossed internal tangents; grooves of a lathe's pitch just over the cable's diameter.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, atan, atan2, hypot, pi, sqrt, tan, tau

_GROOVE_PITCHES_MM = (0.5, 0.6, 0.7, 0.75, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0)  # what lathes cut
_PITCH_PER_DIAMETER = 1.25  # least pitch: neighbouring turns keep a quarter of a diameter
FLEET_LIMIT_RAD = 0.0436  # 2.5 deg: beyond, a cable climbs out of a flat groove


def groove_pitch_mm(cable_mm: float) -> float:
    """Gives the smallest pitch of a lathe that keeps neighbouring turns of a cable apart, mm."""
    least = _PITCH_PER_DIAMETER * cable_mm
    return next((pitch for pitch in _GROOVE_PITCHES_MM if pitch >= least), least)


@dataclass(frozen=True)
class CableRun:
    """Cable between a sector and a pinion that turn against one another; lengths in mm, angles in rad.

    Attributes:
        sector_mm: Radius of the cable's middle on the sector.
        pinion_mm: Radius of the cable's middle on the pinion.
        gap_mm: Distance of the two pitch circles.
        pitch_mm: Pitch of the pinion's groove.
        turns: Turns on the pinion, counted from a take-off round to the line of centres, whole.
        stroke_rad: Angle of the arm from stop to stop.
        beyond_rad: Angle on the sector from the tangent point to the rim's end, at the stop.
    """

    sector_mm: float
    pinion_mm: float
    gap_mm: float
    pitch_mm: float
    turns: int
    stroke_rad: float
    beyond_rad: float

    @property
    def centre_distance_mm(self) -> float:
        """Distance of the axes."""
        return self.sector_mm + self.pinion_mm + self.gap_mm

    @property
    def tangent_rad(self) -> float:
        """Angle of the tangent points from the line of centres, either side, on both circles."""
        return acos((self.sector_mm + self.pinion_mm) / self.centre_distance_mm)

    @property
    def free_mm(self) -> float:
        """Length of a strand between its tangent points."""
        return sqrt(self.gap_mm**2 + 2.0 * self.gap_mm * (self.sector_mm + self.pinion_mm))

    @property
    def lead_rad(self) -> float:
        """Angle of the groove's helix from the plane across the axes."""
        return atan2(self.pitch_mm, tau * self.pinion_mm)

    @property
    def climb(self) -> float:
        """Way along the axes per length of cable in the plane across them."""
        return self.pitch_mm / (tau * self.pinion_mm)

    @property
    def spread_mm(self) -> float:
        """Distance of the two take-offs along the pinion."""
        return self.pitch_mm * (self.turns - self.tangent_rad / pi)

    @property
    def wrap_rad(self) -> float:
        """Angle of the cable round the pinion: the far side of the line of centres, and all whole turns."""
        return tau * self.turns - 2.0 * self.tangent_rad

    @property
    def walk_mm(self) -> float:
        """Way of both take-offs along the pinion from stop to stop."""
        return self.climb * self.sector_mm * self.stroke_rad

    @property
    def middle_mm(self) -> float:
        """Length from the rim's end to the pinion's tangent point in the middle of the stroke."""
        return self.sector_mm * (self.stroke_rad / 2 + self.beyond_rad) + self.free_mm

    @property
    def shortest_mm(self) -> float:
        """The same length at the stop where it is least."""
        return self.sector_mm * self.beyond_rad + self.free_mm

    @property
    def lug_mm(self) -> float:
        """Offset of the rim's ends from the sector's middle plane, one to either side."""
        return self.spread_mm / 2 + self.middle_mm * self.climb

    @property
    def made_lug_mm(self) -> float:
        """The same as it is made, in whole tenths: what it is off turns a strand by 0.2 deg at most."""
        return round(self.lug_mm, 1)

    @property
    def grooved_mm(self) -> float:
        """Width of the pinion's groove: the turns, their walk and one pitch at either end."""
        return self.spread_mm + self.walk_mm + 2 * self.pitch_mm

    def take_off_mm(self, turned_rad: float) -> tuple[float, float]:
        """Gives where both strands leave the pinion along its axis, from the middle plane, mm.

        Args:
            turned_rad: Angle of the arm from the middle of its stroke.

        Returns:
            Of the strand that grows longer as the angle grows, and of the other.
        """
        walked = self.climb * self.sector_mm * turned_rad
        return self.spread_mm / 2 - walked, -self.spread_mm / 2 - walked

    def fleet_rad(self, turned_rad: float, lugs_mm: tuple[float, float]) -> tuple[float, float]:
        """Computes the angle between each strand and the groove's helix.

        Args:
            turned_rad: Angle of the arm from the middle of its stroke.
            lugs_mm: Offsets of the rim's ends from the middle plane as they are, of the same two strands.
        """
        reach = self.sector_mm * turned_rad
        found = []
        for take_off, lug, length in zip(
            self.take_off_mm(turned_rad), lugs_mm, (self.middle_mm + reach, self.middle_mm - reach), strict=True
        ):
            found.append(atan(abs(lug - take_off) / length) - self.lead_rad)
        return found[0], found[1]

    def lug_tolerance_mm(self) -> float:
        """Computes by how much a lug may be off before a strand leaves the plane across the axes by the limit."""
        return self.shortest_mm * (tan(FLEET_LIMIT_RAD) - self.climb)

    def stiffness_N_mm(self, EA_N: float, turned_rad: float, anchors_mm: float = 0.0) -> float:
        """Computes the stiffness at the sector's pitch circle, both strands together, the pinion held.

        Args:
            EA_N: Tension of the cable per strain.
            turned_rad: Angle of the arm from the middle of its stroke.
            anchors_mm: Length of cable beyond the rim's end on either side.
        """
        reach = self.sector_mm * turned_rad
        lengths = self.middle_mm + reach + anchors_mm, self.middle_mm - reach + anchors_mm
        return EA_N * sum(1.0 / length for length in lengths)

    def length_mm(self) -> float:
        """Computes the length of the cable from rim's end to rim's end; the same at every angle."""
        return hypot(1.0, self.climb) * (2.0 * self.middle_mm + self.wrap_rad * self.pinion_mm)
