"""Tension of a capstan's cable by friction along every drum, from the end that is pulled to the one that is anchored.

The cable lies on the sector's rim in two halves, on the pinion in turns, and is free between: two strands. Where it is
on a drum its tension T changes by at most `T mu` a radian (Euler, Eytelwein), and stays as it was laid where less is
needed. Both ends are fixed: the integral of the tension along the cable is the same before and after, whatever slides.

Source: capstan equation; the rest by own derivation. A rim or a pinion counts as rigid, the cable as one spring.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import exp

import numpy as np

FRICTION = (0.12, 0.3)  # wire rope on dry metal, the least and the most of what is measured; from memory: check
_HALVED, _STEPS = 4, 14  # of a range of tensions, for nine digits and more
_LEAST = 1e-9  # share of the mean tension below which a strand is slack


@dataclass(frozen=True)
class Arc:
    """A length of the cable on a drum of a radius, or a straight one behind it, radius 0.

    Attributes:
        length_mm: Of the cable; an array where it differs from pose to pose.
        radius_mm: Of the cable's middle.
    """

    length_mm: np.ndarray
    radius_mm: float = 0.0

    @property
    def angle_rad(self) -> np.ndarray:
        """Angle about the drum; none of a straight length."""
        return self.length_mm / self.radius_mm if self.radius_mm else np.zeros_like(self.length_mm)


@dataclass(frozen=True)
class LaidCable:
    """A cable on its sector and pinion.

    Attributes:
        outer: From the free strand to the end that is pulled.
        pinion: On the pinion.
        inner: From the free strand to the end that is anchored.
        free_mm: Length of either free strand.
    """

    outer: tuple[Arc, ...]
    pinion: Arc
    inner: tuple[Arc, ...]
    free_mm: float

    @property
    def length_mm(self) -> np.ndarray:
        """Length of the cable."""
        laid = sum((arc.length_mm for arc in (*self.outer, self.pinion, *self.inner)), np.zeros(1))
        return laid + 2.0 * self.free_mm

    def grip(self, friction: float) -> float:
        """Gives the most that the tight strand may have over the slack one while the pinion is held."""
        return exp(friction * float(np.max(self.pinion.angle_rad)))

    def pulled(self, pull_N: float, friction: float) -> dict[str, float]:
        """Computes the tension along a slack cable whose outer end is pulled, the pinion free to turn.

        Args:
            pull_N: At the outer end.
            friction: Coefficient of cable and drums.

        Returns:
            Place -> tension, N, from the pulled end on; "mean" is that of the whole cable. As the pinion turns, both
            strands have the same; the turns on it are pulled from either side.
        """
        out, marks = _angles(self.outer), _angles(self.inner)
        strands = pull_N * np.exp(-friction * out[-1])
        half = self.pinion.angle_rad / 2.0
        on_pinion = 2.0 * self.pinion.radius_mm * strands * _rising(-friction, half)
        outer = pull_N * np.exp(-friction * out[-1]) * self._grown(self.outer, friction)
        inner = strands * self._grown(self.inner, -friction)
        total = on_pinion + outer + inner + 2.0 * self.free_mm * strands
        found = {
            "carriage": pull_N,
            "strands": strands,
            "middle of the turns": strands * np.exp(-friction * half),
            "anchor": strands * np.exp(-friction * marks[-1]),
            "mean": total / self.length_mm,
        }
        return {name: float(np.mean(value)) for name, value in found.items()}

    @staticmethod
    def _grown(arcs: tuple[Arc, ...], friction: float) -> np.ndarray:
        """Integral along arcs of a tension that is 1 where they begin and grows with a friction, or falls, mm."""
        found = np.zeros(1)
        for arc, before in zip(arcs, _angles(arcs), strict=False):
            share = np.exp(friction * before)
            found = found + share * (
                arc.radius_mm * _rising(friction, arc.angle_rad) if arc.radius_mm else arc.length_mm
            )
        return found

    def held_N(self, friction: float, outer_tight: bool) -> np.ndarray:
        """Computes the difference of the strands at which the cable slips on a held pinion, for a mean tension of 1 N.

        What was laid with which tension before does not matter for it: the turns slide from end to end.

        Args:
            friction: Coefficient of cable and drums.
            outer_tight: Whether the outer strand is the tight one.
        """
        grip = self.grip(friction)

        def left(slack: np.ndarray) -> np.ndarray:
            turns = self.pinion.radius_mm * slack * _rising(friction, self.pinion.angle_rad) - self.pinion.length_mm
            return turns + self._beyond(slack, grip * slack, friction, outer_tight)

        slack = _solved(left, np.full_like(self.length_mm, _LEAST), np.ones_like(self.length_mm))
        return (grip - 1.0) * slack

    def strands_N(
        self, mean_N: float, difference_N: np.ndarray, friction: float, outer_tight: bool
    ) -> tuple[np.ndarray, np.ndarray]:
        """Computes the tension of both strands while a held pinion holds a difference, after an even tension.

        Args:
            mean_N: Tension of the whole cable before.
            difference_N: Of the strands; beyond what friction holds the pair says by how much more it would take.
            friction: Coefficient of cable and drums.
            outer_tight: Whether the outer strand is the tight one.

        Returns:
            Slack and tight strand.
        """
        more = np.asarray(difference_N, dtype=float) / mean_N

        def left(slack: np.ndarray) -> np.ndarray:
            tight = slack + more
            turns = np.zeros_like(slack)
            for end, sense in ((slack, 1.0), (tight, -1.0)):
                slid = np.minimum(np.abs(np.log(end)) / friction, self.pinion.angle_rad)
                slid = np.where((end - 1.0) * sense < 0.0, slid, 0.0)
                turns = turns + self.pinion.radius_mm * (end * _rising(sense * friction, slid) - slid)
            return turns + self._beyond(slack, tight, friction, outer_tight)

        slack = _solved(left, np.full_like(more, _LEAST), np.ones_like(more))
        return mean_N * slack, mean_N * (slack + more)

    def _beyond(self, slack: np.ndarray, tight: np.ndarray, friction: float, outer_tight: bool) -> np.ndarray:
        """What strands and rims have over a tension of 1 in all of the cable, mm."""
        outer, inner = (tight, slack) if outer_tight else (slack, tight)
        strands = self.free_mm * (slack + tight - 2.0)
        return strands + _slid(self.outer, outer, friction) + _slid(self.inner, inner, friction)


def _angles(arcs: tuple[Arc, ...]) -> list[np.ndarray]:
    """Angle from the free strand to where each arc begins, and to the end."""
    found = [np.zeros(1)]
    for arc in arcs:
        found.append(found[-1] + arc.angle_rad)
    return found


def _rising(friction: float, angle: np.ndarray) -> np.ndarray:
    """Integral of exp(friction x) from 0 to an angle."""
    return np.expm1(friction * angle) / friction


def _slid(arcs: tuple[Arc, ...], end: np.ndarray, friction: float) -> np.ndarray:
    """What arcs have over a tension of 1 where the strand before them has another: they slide as far as it reaches."""
    falls = np.where(end > 1.0, -friction, friction)
    reach = np.abs(np.log(end)) / friction
    found = np.zeros_like(end)
    for arc, before in zip(arcs, _angles(arcs), strict=False):
        tension = end * np.exp(falls * np.minimum(before, reach))  # 1 from where it no longer slides
        if arc.radius_mm:
            over = np.clip(reach - before, 0.0, arc.angle_rad)
            found = found + arc.radius_mm * (tension * np.expm1(falls * over) / falls - over)
        else:
            found = found + arc.length_mm * (tension - 1.0)
    return found


def _solved(left: Callable[[np.ndarray], np.ndarray], low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Solves for the value in a range at which a growing function is 0: halved, then by the Illinois method."""
    below, above = left(low), left(high)
    was_over, middle = np.zeros_like(low, dtype=bool), low
    for step in range(_STEPS):
        rise = above - below
        chord = high - above * (high - low) / np.where(rise > 0.0, rise, np.inf)
        middle = (low + high) / 2.0 if step < _HALVED else np.clip(chord, low, high)
        value = left(middle)
        over = value > 0.0
        if step > _HALVED:  # the value of an end that stays twice counts half
            below = np.where(over & was_over, below / 2.0, below)
            above = np.where(~over & ~was_over, above / 2.0, above)
        low, below = np.where(over, low, middle), np.where(over, below, value)
        high, above = np.where(over, middle, high), np.where(over, value, above)
        was_over = over
    return middle
