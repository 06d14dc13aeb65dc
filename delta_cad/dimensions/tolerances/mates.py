"""Whether the holes of two parts, each within its zone, let their pins and screws in: worst case and statistical.

In the plane across the pins, one part lies on the other by its locators: a pin in a round hole of either part, which
has no play, and a pin in a slot, which holds the turn; or a bore on a pilot, or nothing, and then the turn is free.
With e_k by how much the holes of place k are apart, of length r_k at most (half of both zones), d_k the way from the
first locator to it, w the normal of the slot and z the axis of the pins, the turn is w . (e_1 - e_0) / (w . (z x d_1)),
and along a direction n the misfit of place k is linear in all e:

    m_k(n) = n . e_k - (n - c w) . e_0 - c w . e_1,    c = n . (z x d_k) / (w . (z x d_1))

Its largest value is the sum of the lengths of these coefficients times r, the worst case; the root of the sum of
squares is that of 99.73 % of machines, r being three standard deviations along any direction.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import floor

import numpy as np

_DIRECTIONS = 720  # of misfits that are looked at: half a degree
_ZONE_STEP_MM = 0.05  # to which zones of screws are rounded down
_ROUNDING_MM = 1e-9
_LEAST_ARM = 1e-6  # of a slot's normal across the way to it: below, it does not hold the turn

Point = tuple[float, float]


@dataclass(frozen=True)
class Place:
    """Where a pin, a screw or a pilot joins two parts, in the plane across it.

    Attributes:
        name: Of the pin.
        at_mm: Where it is drawn.
        off_mm: By how much the axes of both its holes may be apart, each in its zone: half of both zones.
        play_mm: Least radial play of the pin in both holes together; 0 of one that is pressed in.
        along: Unit vector along its slot; None: round holes.
        slack_mm: Least way of the pin from the slot's middle to either end.
    """

    name: str
    at_mm: Point
    off_mm: float
    play_mm: float = 0.0
    along: Point | None = None
    slack_mm: float = 0.0


@dataclass(frozen=True)
class Locators:
    """What holds one part in its place on the other.

    Attributes:
        first: Pin in round holes, or pilot.
        slot: Pin in a slot, which holds the turn; None: the turn is free.
    """

    first: Place
    slot: Place | None = None

    @property
    def hold(self) -> bool:
        """Whether the slot, if there is one, holds the turn: it does not where it runs across the line of both pins."""
        return self.slot is None or abs(self._arm_mm) >= _LEAST_ARM

    @property
    def _arm_mm(self) -> float:
        """Way to the slot's pin that its turn moves across the slot."""
        assert self.slot is not None
        return float(self._normal @ _turned(np.subtract(self.slot.at_mm, self.first.at_mm)))

    @property
    def _normal(self) -> np.ndarray:
        """(2,) unit vector across the slot."""
        assert self.slot is not None
        return _turned(np.array(self.slot.along))

    def coefficients(self, at_mm: Point, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Gives how a part's shift at a point along directions depends on its locators' holes.

        Args:
            at_mm: The point.
            along: (n, 2) unit vectors.

        Returns:
            (n, 2) factors of e_0 and of e_1 in `along . shift`; the latter 0 where the turn is free.
        """
        if self.slot is None:
            return along, np.zeros_like(along)
        if not self.hold:
            raise ValueError(f"the slot of {self.slot.name} does not hold the turn about {self.first.name}")
        share = (along @ _turned(np.subtract(at_mm, self.first.at_mm)) / self._arm_mm)[:, None] * self._normal
        return along - share, share

    def shift_mm(self, at_mm: Point, along: np.ndarray | None = None) -> float:
        """Computes the largest shift of a part at a point, along directions or any, worst case, mm."""
        first, slot = self.coefficients(at_mm, _ways() if along is None else along)
        return float((self._lengths(first) * self.first.off_mm + self._lengths(slot) * self._slot_off_mm).max())

    @property
    def _slot_off_mm(self) -> float:
        return 0.0 if self.slot is None else self.slot.off_mm

    @staticmethod
    def _lengths(rows: np.ndarray) -> np.ndarray:
        return np.hypot(rows[:, 0], rows[:, 1])


def clearances_mm(place: Place, located: Locators | None) -> tuple[float, float]:
    """Computes what play is left at a place, mm: worst case, and of 99.73 % of machines; negative: it does not go in.

    Args:
        place: The place; the slot of the locators itself counts along it, the first locator has none.
        located: What holds the part; None: nothing but these screws, the part being shifted as suits them.
    """
    along = _ways() if place.along is None else np.array([place.along, [-v for v in place.along]])
    play = place.play_mm if place.along is None else place.slack_mm
    own = np.full(len(along), place.off_mm)
    if located is None:
        return play - place.off_mm, play - place.off_mm
    first, slot = located.coefficients(place.at_mm, along)
    if place is located.slot:  # its own holes are those that turn the part
        slot, own = slot - along, np.zeros(len(along))
    lengths = [np.hypot(rows[:, 0], rows[:, 1]) for rows in (first, slot)]
    offs = [located.first.off_mm, 0.0 if located.slot is None else located.slot.off_mm]
    parts = np.array([own, *(one * off for one, off in zip(lengths, offs, strict=True))])
    return play - float(parts.sum(axis=0).max()), play - float(np.sqrt((parts**2).sum(axis=0)).max())


def screw_zone_mm(hole_mm: float, thread_mm: float, located_mm: float = 0.0, other_mm: float | None = None) -> float:
    """Computes the zone that a screw's clearance hole bears: the formula of fixed fasteners.

    The zones of hole and thread together are the play of diameter, less twice what the parts' locators take:
    H = F + T_1 + T_2 (ASME Y14.5, appendix B.4).

    Args:
        hole_mm: Least diameter of the clearance hole.
        thread_mm: Of the screw.
        located_mm: By how much the parts may be shifted there by what locates them.
        other_mm: Zone of the other of both; None: both have the same.

    Returns:
        Diameter of the zone: the next below in steps of 0.05 mm, and no less than one; the check of the mates tells
        what is left.
    """
    both = hole_mm - thread_mm - 2.0 * located_mm
    zone = both / 2.0 if other_mm is None else both - other_mm
    return round(_ZONE_STEP_MM * max(floor((zone - _ROUNDING_MM) / _ZONE_STEP_MM), 1), 3)


def pair(first_mm: Point, second_mm: Point, off_mm: float) -> Locators:
    """Makes the locators of two pins, the second in a slot along the line of both."""
    way = np.subtract(second_mm, first_mm)
    x, y = (float(v) for v in way / np.hypot(*way))
    return Locators(Place("pin", first_mm, off_mm), Place("pin in its slot", second_mm, off_mm, along=(x, y)))


def _turned(vector: np.ndarray) -> np.ndarray:
    """Turns a vector of the plane by a quarter."""
    return np.array([-vector[1], vector[0]])


def _ways() -> np.ndarray:
    angles = 2.0 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    return np.column_stack([np.cos(angles), np.sin(angles)])
