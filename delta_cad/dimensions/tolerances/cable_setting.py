"""How a cable's tension is set by hand: a pull at the arm under which it just slips on its held pinion.

Nothing shows the tension itself: the strands are too short to sound, the turn of the screw stretches what lies on the
drums in a measure that friction decides, and what is pulled at the carriage reaches the anchor with half of it or less.
What counts is what the cable holds. The pinion is held by a key in one of its set screws, a spring balance pulls the
arm: below the lower reading it must stand, before the upper one it must creep. The lower reading proves, whatever the
friction is, what the cable holds; the upper one bounds its tension, most of all where friction is least.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from math import ceil, cos, radians, sin, tanh, tau

import numpy as np

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.bracket import key_rad
from delta_cad.dimensions.capstan import ROPE_FACTOR, TENSION_SCREW, CapstanDimensions
from delta_cad.drive import drive_torque
from delta_cad.drive.laid_cable import FRICTION

_BALANCES_N, _DIVISIONS = (5.0, 10.0, 20.0, 50.0, 100.0, 200.0), 100  # scales of spring balances, and their divisions
_OFF_SHARE = 0.015  # of its scale: a hundredth that the balance is off, and half a division that it is read to
_ASKEW_RAD = radians(10.0)  # by which a hand pulls aside of what is square to the arm
_WINDOW = 0.15  # of the lower reading, between both, at least; and what a step of the screw changes
_CREEP_RAD = radians(6.0)  # that are left of the stroke where the arm creeps
HOOK_MM, _PAST_MM = 12.0, 2.0  # radius that a balance takes with its loop of cord, and how far that passes the foot
_ANGLES = 49  # of the arm between its stops
_FRICTIONS = np.linspace(*FRICTION, 5)
STROKES = 50  # after which a rope has settled; from memory: tension it until it stays
_SCREW_RAD = radians(15.0)  # to which a hand turns the tension screw


@dataclass(frozen=True)
class CableSetting:
    """The pull that sets a cable, and what follows from it.

    Attributes:
        capstan: That the cable lies on.
        screw: Number of the set screw whose key holds the pinion.
        arm_rad: Angle of the arm from the middle of its stroke at which it is pulled.
        rises: Whether the pull raises the arm; then the outer strand is the tight one.
        lever_mm: From the shoulder to where the balance hooks in.
        pull_N: At which the arm must stand, and before which it must creep.
        balance_N: Scale of the balance.
        step_rad: By which the tension screw is turned between two pulls.
        step_N: By how much that changes the pull, least and most: by the softest rope and the least friction, and else.
        needed_N: Difference of the strands that the drive may ask for at the cable.
    """

    capstan: CapstanDimensions
    screw: int
    arm_rad: float
    rises: bool
    lever_mm: float
    pull_N: tuple[float, float]
    balance_N: float
    step_rad: float
    step_N: tuple[float, float]
    needed_N: float

    @property
    def off_N(self) -> float:
        """How far a reading of the balance may be off."""
        return _OFF_SHARE * self.balance_N

    @property
    def lever(self) -> float:
        """Difference of the strands for a pull of 1 N that is square to the arm."""
        return self.lever_mm / self.capstan.pitch_radius_mm

    @property
    def proven_N(self) -> float:
        """Difference of the strands that the cable holds for certain where the arm is pulled."""
        return (self.pull_N[0] - self.off_N) * cos(_ASKEW_RAD) * self.lever

    @property
    def slips_N(self) -> float:
        """Difference at which it slips there at the latest."""
        return (self.pull_N[1] + self.off_N) * self.lever

    @property
    def tension_N(self) -> float:
        """Most tension of either strand at rest: half of what both have together while the cable slips.

        While it slips the strands have `D / tanh(mu wrap / 2)` together, D their difference; released, they have less.
        """
        return self.slips_N / tanh(FRICTION[0] * self.capstan.run.wrap_rad / 2.0) / 2.0

    @property
    def tight_N(self) -> float:
        """Most tension of the tight strand while the arm is pulled."""
        return self.tension_N + self.slips_N / 2.0

    def held_N(self, turned_rad: np.ndarray) -> np.ndarray:
        """Computes what the cable holds for certain at angles of the arm, either strand the tight one, any friction.

        Args:
            turned_rad: From the middle of the stroke.
        """
        grid, share = _least_held(self.capstan, self.arm_rad, self.rises)
        return self.proven_N * np.interp(turned_rad, grid, share)

    def strands_N(self, turned_rad: np.ndarray, difference_N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Computes the tension of both strands, of the tightest setting, that one taken as tight which gives more.

        Args:
            turned_rad: Angles of the arm from the middle of its stroke, (...).
            difference_N: Of the strands, (...).

        Returns:
            Slack and tight strand.
        """
        laid, more = self.capstan.laid(turned_rad.ravel()), difference_N.ravel()
        either = [laid.strands_N(self.tension_N, more, FRICTION[0], outer)[0] for outer in (True, False)]
        slack = np.maximum(*either).reshape(difference_N.shape)
        return slack, slack + difference_N


@cache
def _held(c: CapstanDimensions) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the arm from stop to stop, and what is held there for 1 N, (angles, tight strand, friction)."""
    angles = np.linspace(-c.run.stroke_rad / 2.0, c.run.stroke_rad / 2.0, _ANGLES)
    laid = c.laid(angles)
    held = [[laid.held_N(friction, outer) for friction in _FRICTIONS.tolist()] for outer in (True, False)]
    return angles, np.moveaxis(np.array(held), -1, 0)


@cache
def _least_held(c: CapstanDimensions, arm_rad: float, rises: bool) -> tuple[np.ndarray, np.ndarray]:
    """Angles of the arm, and the least that is held there of what is held where it is pulled."""
    angles, held = _held(c)
    at = [float(np.interp(arm_rad, angles, held[:, 0 if rises else 1, k])) for k in range(len(_FRICTIONS))]
    return angles, (held / at).min(axis=(1, 2))


def cable_setting(d: Dimensions) -> CableSetting | None:
    """Chooses how a machine's cables are set: where the arm is pulled, which way, and by what; None without a cable.

    The pinion is held by a key in one of its set screws, so that the arm stands where one faces the key. Of these
    places and of both ways of pulling it takes the one that needs least.
    """
    c, report = d.capstan, drive_torque(d.design)
    if c is None:
        return None
    needed = report.controlled_torque_N_m / report.efficiency * MM_PER_M / c.pitch_radius_mm
    places = [(k, at, way) for k, at in _faced_rad(d, c) for way in (True, False) if _has_room(d, c, at, way)]
    screw, at, rises = max(places or [(0, 0.0, True)], key=lambda one: float(_least_held(c, *one[1:])[1].min()))
    lever_mm = d.arm.length_mm
    least = needed / float(_least_held(c, at, rises)[1].min()) * c.pitch_radius_mm / lever_mm / cos(_ASKEW_RAD)
    stretch = _SCREW_RAD / tau * catalogue.screw(TENSION_SCREW).pitch_mm / float(c.laid(np.zeros(1)).length_mm[0])
    laid = c.laid(np.array([at]))
    for_1_N = [float(laid.held_N(friction, rises)[0]) * c.pitch_radius_mm / lever_mm for friction in FRICTION]
    step = min(d.cable.stiffness_N) * stretch * min(for_1_N), max(d.cable.stiffness_N) * stretch * max(for_1_N)
    window = max(_WINDOW * least, step[1])
    scale = next((one for one in _BALANCES_N if least + window < one * (1.0 - 3.0 * _OFF_SHARE)), _BALANCES_N[-1])
    low, high = (
        round(ceil((one + _OFF_SHARE * scale) / scale * _DIVISIONS - 1e-9) * scale / _DIVISIONS, 6)
        for one in (least, least + window)
    )
    return CableSetting(c, screw, at, rises, lever_mm, (low, high), scale, _SCREW_RAD, step, needed)


def bench_pull_N(d: Dimensions) -> int:
    """Gives what a crimped cable is pulled by on the bench, what it may bear in tens, N."""
    return 10 * ceil(d.cable.breaking_load_N / ROPE_FACTOR / 10)


def _faced_rad(d: Dimensions, c: CapstanDimensions) -> list[tuple[int, float]]:
    """Set screws, by number, and angles of the arm from the middle of its stroke at which they face their key."""
    low, high = d.stops_rad
    key, found = key_rad(c, d.bracket, d.motor), list[tuple[int, float]]()
    for k, screw in enumerate(d.set_screws_rad):
        first = (screw - key) / c.ratio
        turns = np.arange(-ceil(c.ratio) - 1, ceil(c.ratio) + 2) * tau / c.ratio
        found += [(k, float(at) - (low + high) / 2.0) for at in first + turns if low < at < high]
    return found


def _has_room(d: Dimensions, c: CapstanDimensions, at_rad: float, rises: bool) -> bool:
    """Whether the arm may creep from an angle before it meets its stop, the balance outside of the foot."""
    left = c.run.stroke_rad / 2.0 - (at_rad if rises else -at_rad)
    angle, b = sum(d.stops_rad) / 2.0 + at_rad, d.bracket
    down = (d.arm.length_mm * sin(angle) - b.base_top_mm) / cos(angle)  # to the foot's lower face
    passes = d.arm.length_mm * cos(angle) + down * sin(angle) + b.shoulder_u_mm
    return left > _CREEP_RAD and (rises or (passes - b.foot_u_mm[1]) * cos(angle) > HOOK_MM + _PAST_MM)
