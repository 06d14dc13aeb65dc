"""Corrections of the closed-form model for one hardware selection, from refusals, solids and checks (space mapping)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from math import inf
from typing import Any, NamedTuple

import numpy as np

from delta_cad.drive.masses import Masses
from delta_cad.mechanism.limits import HandleInertia
from delta_cad.mechanism.limits.lengths.wrist_clearance import between_neighbours

_ARM_EXPONENT = (
    1.9  # inertia of an arm with its sector goes so with its length: 1.8 to 2.1 from 72 to 120 mm, by solids
)
_GRAVITY_EXPONENT = 1.4  # what gravity takes of a joint likewise: 1.2 to 1.5 from 124 to 172 mm
WEIGHED_AGAIN = 0.02  # share by which a length may have changed since a machine was weighed
ROD_SHARE = 0.5  # of a rod's mass that grows with its length: the rest are its ends
COUPLE_MOST = 0.75  # that is asked for at most: more costs nearly all of the cube
KAPPA_MAX = 2.5  # default largest condition number: of a handle that feels alike in all directions
LEAN_DEG = 28.0  # of rods, where none is asked: what the ball joints are made for
SHOULDER_DEG = (-60.0, 65.0)  # where none is asked: arms stay off the base, and off their neighbours
NARROWER, WIDER = 0.6, 1.5  # of a base radius for one of width: keys ask for 43, 40, 37 mm beside 38, 42, 46 mm, say
FARTHEST = 3.0  # times what a base radius lacks that it is made longer by
_LACKED_MM = 1.0  # of a base radius, that is more than what the measuring of it leaves open
TORQUE_MARGIN, TORQUE_MARGIN_N_M = 1e-3, 4e-4  # of a joint's torque, and the least
_RADIUS_STEP_MM, _ARM_STEP_MM = 0.5, 2.0
_ELBOW = ("upper_arm", "cross_bar")  # what an arm has at its elbow
KNOB_MM = 45.0  # of a knob over the wrists, behind a panel, beyond the cube's side: about, for what is learnt mends it


@dataclass(frozen=True)
class MassEstimate:
    """Masses of the solids of one machine, with the lengths and the ratio that they scale with.

    Attributes:
        masses: Of its solids.
        gravity_torque_N_m: The most that gravity takes of a joint beside the force, anywhere in its cube.
        upper_arm_mm: L_A.
        forearm_mm: L_B.
        ratio: Of its drive.
        own: Whether it has the motor and the parts of the choice that it stands for.
    """

    masses: Masses
    gravity_torque_N_m: float
    upper_arm_mm: float
    forearm_mm: float
    ratio: float
    own: bool = False

    def inertia(self, upper_arm_mm: float, forearm_mm: float, ratio: float) -> HandleInertia:
        """Estimates the inertia at the handle of a machine not far from this one."""
        m = self.masses
        arm = m.arm_inertia * (upper_arm_mm / self.upper_arm_mm) ** _ARM_EXPONENT
        rotor = m.rotor_inertia * (ratio / self.ratio) ** 2
        rods = 1.0 - ROD_SHARE + ROD_SHARE * forearm_mm / self.forearm_mm
        carried = m.platform + 3.0 * m.rod_wrist * rods
        return HandleInertia(carried, m.rod_elbow * rods, m.rod_cross * rods, arm + rotor)

    def is_of(self, upper_arm_mm: float, forearm_mm: float, ratio: float) -> bool:
        """Whether it is that of a machine so near that another weighing would change nothing."""
        pairs = (self.upper_arm_mm, upper_arm_mm), (self.forearm_mm, forearm_mm), (self.ratio, ratio)
        return self.own and all(abs(a - b) <= WEIGHED_AGAIN * b for a, b in pairs)


def reference() -> MassEstimate:
    """Gives initial masses, of a machine of 86 mm and 3 N, rounded.

    They are a place to begin: where no machine is found, hardware without lengths is searched once more from
    `weightless` parts.
    """
    masses = Masses(
        platform=0.065,
        arm_along=0.0022,
        arm_across=-0.0004,
        arm_inertia=1.85e-4,
        rod_elbow=0.0038,
        rod_cross=0.0014,
        rod_wrist=0.0038,
        rotor_inertia=8e-5,
    )
    return MassEstimate(masses, gravity_torque_N_m=0.036, upper_arm_mm=91.0, forearm_mm=143.0, ratio=4.8)


class _ChainInterference(NamedTuple):
    """Interference between neighbouring chains, found in one machine.

    Attributes:
        width_mm: Its parallelograms'.
        radius_mm: Its base radius.
        short_mm: What that lacked.
        least_mm: Base radius that is asked for since.
    """

    width_mm: float
    radius_mm: float
    short_mm: float
    least_mm: float


_TURNS = np.linspace(0.0, np.pi / 2.0, 7)
_DIRECTIONS = np.stack([np.cos(_TURNS), np.sin(_TURNS)], axis=1)


@dataclass(frozen=True)
class ChainReach:
    """How far a chain reaches, seen from above, as the dimensions of one machine have it, mm.

    Attributes:
        elbow_mm: Circles round an elbow's axis: along it from the chain's plane, and radius.
        drive_mm: Points of its drive: out from the shoulder, and along the shoulder axis.
        base_radius_mm: R of chain 0, at which the points of the drive hold.
        per_mm: How much farther along the axis they lie for each mm less of it: sectors pass under the platform.
        nearest_mm: By how much they come nearer at most where it is larger.
        beyond_mm: What a machine takes beyond all of this, along y and along x.
    """

    elbow_mm: tuple[tuple[float, float], ...]
    drive_mm: tuple[tuple[float, float], ...] = ()
    base_radius_mm: float = 0.0
    per_mm: float = 0.0
    nearest_mm: float = 0.0
    beyond_mm: tuple[float, float] = (0.0, 0.0)

    def longest_mm(self, base_radius_mm: float) -> np.ndarray:
        """How far the drive reaches in directions from out of the shoulder to along its axis, (n) mm."""
        points = np.array(self.drive_mm) + np.array([0.0, self.farther_mm(np.array(base_radius_mm))])
        return np.max(_DIRECTIONS @ points.T, axis=1)

    def farther_mm(self, base_radius_mm: np.ndarray) -> np.ndarray:
        """How much farther along the axis the drive lies at other base radii (n), mm."""
        return np.maximum(self.per_mm * (self.base_radius_mm - base_radius_mm), -self.nearest_mm)


_RAISED = "couple_index_min", "couple_per_mm", "elbow_angle_deg"
RaisedLimits = tuple[float, float, float]
"""Couple index, the same for each mm of a lever, angle at the elbow, deg."""


_NEXT_TO_NOTHING = 1e-6  # share of masses: an inertia is not 0


@dataclass(frozen=True)
class Corrections:
    """Bounds for the lengths of the next candidate.

    Attributes:
        mass_estimate: Of the last machine that was made solid.
        least_mm: Length (as `[bounds_mm]` names it), or pair of chains -> the least that hardware lets pass. Radii
            and pairs of a placed machine are `as_symmetric` tells them.
        interferences: Machines whose chains were in the way of one another.
        overhead_mm: What the machine takes beyond eq. (1) of its outline, along y and along x.
        reach: Of a chain of a placed machine; None: its bar, and the overhead of a symmetric machine beyond it.
        height_beyond_mm: What parts take of the height of a machine beyond its cube's top over the shoulder axes.
        couple_index_min: Least rotational stiffness index that its parts need.
        couple_per_mm: The same for each mm of a knob's lever behind a panel, which the cube's side goes into; 0 where
            there is no panel.
        side_most_mm: Largest side of the cube to ask for.
        elbow_angle_deg: Least angle between upper arm and rods to ask for.
        shoulder_low_deg: Least angle of an upper arm, 0 is level.
        pull_N: Most torque of a joint at any moment over its sector's radius: beyond, the cable pulls too hard at the
            motor's shaft.
        mass_share: Share of the effective mass allowed that is asked for: what solids weigh more than was estimated.
        friction_share: The same of the friction.
        step_share: The same of the position step.
        ball_friction_N: What the ball joints rub with at the knob, for a motion along z, and square to it.
        torque_margin_N_m: Left of a joint's torque beside the force and the weight.
        why: What each was taught by, a line each.
    """

    mass_estimate: MassEstimate
    least_mm: Mapping[str, float] = field(default_factory=dict)
    interferences: tuple[_ChainInterference, ...] = ()
    overhead_mm: tuple[float, float] = (10.0, 13.5)
    reach: ChainReach | None = None
    height_beyond_mm: float = 0.0
    couple_index_min: float = 0.0
    couple_per_mm: float = 0.0
    side_most_mm: float = inf
    elbow_angle_deg: float = 0.0
    shoulder_low_deg: float = -90.0
    pull_N: float = inf
    mass_share: float = 0.998
    friction_share: float = 0.998
    step_share: float = 0.998
    ball_friction_N: tuple[float, float] = (0.12, 0.18)
    torque_margin_N_m: float = TORQUE_MARGIN_N_M
    why: tuple[str, ...] = ()

    def weightless(self) -> Corrections:
        """The same with masses of next to nothing, the rotor's kept, no friction of ball joints, and the outline of
        eq. (1): an optimistic place to begin.
        """
        m = self.mass_estimate.masses
        least = {f.name: _NEXT_TO_NOTHING * getattr(m, f.name) for f in fields(m) if f.name != "rotor_inertia"}
        estimate = replace(self.mass_estimate, masses=replace(m, **least), gravity_torque_N_m=0.0)
        return replace(self, mass_estimate=estimate, overhead_mm=(0.0, 0.0), ball_friction_N=(0.0, 0.0))

    def least(self, length: str) -> float:
        """The least of a length, mm; 0 where nothing is known."""
        return self.least_mm.get(length, 0.0)

    def least_radius_mm(self, width_mm: float) -> float:
        """The least base radius beside a parallelogram's width: less, by `NARROWER` and `WIDER`, than it may be.

        Of a width of which a machine was looked at, the last one tells.
        """
        own = [one for one in self.interferences if one.width_mm == width_mm]
        known = (
            one.least_mm + (NARROWER if width_mm < one.width_mm else WIDER) * (one.width_mm - width_mm)
            for one in own[-1:] or self.interferences
        )
        return max((self.least("base_radius"), *known))

    def with_chains_apart(self, width_mm: float, base_radius_mm: float, short_mm: float, why: str) -> Corrections:
        """The same with chains that are farther apart.

        What they need grows with the base radius, as the other lengths follow it: where another machine of the same
        width showed what it needs, the radius is gone to at which the line through both needs no more.

        Args:
            width_mm: A parallelogram's width.
            base_radius_mm: Of a machine whose chains are in the way of one another.
            short_mm: What its base radius lacks; less than 0: what it leaves.
            why: The check or refusal that showed it.
        """
        more = short_mm
        before = next((one for one in reversed(self.interferences) if one.width_mm == width_mm), None)
        grows = (
            before is not None and short_mm >= before.short_mm + _LACKED_MM
        )  # a longer one is of no use: another width
        if (
            before is not None
            and not grows
            and base_radius_mm > before.radius_mm
            and min(short_mm, before.short_mm) >= _LACKED_MM
        ):
            slope = 1.0 + (short_mm - before.short_mm) / (base_radius_mm - before.radius_mm)
            more = max(more, short_mm / max(1.0 - slope, 1.0 / FARTHEST))
        found = _ChainInterference(width_mm, base_radius_mm, short_mm, base_radius_mm + more)
        return self.updated(why, interferences=(*self.interferences, found))

    def beyond_mm(self, placed: bool) -> tuple[float, float]:
        """What a machine takes beyond eq. (1), or beyond what its placed chains reach, along y and along x, mm."""
        return self.overhead_mm if self.reach is None or not placed else self.reach.beyond_mm

    def with_beyond(self, placed: bool, beyond_mm: tuple[float, float], why: str) -> Corrections:
        """The same with other values of `beyond_mm`."""
        if self.reach is None or not placed:
            return self.updated(why, overhead_mm=beyond_mm)
        return self.updated(why, reach=replace(self.reach, beyond_mm=beyond_mm))

    @property
    def held_torque_N_m(self) -> float:
        """What of a joint's torque is not for the force."""
        return self.mass_estimate.gravity_torque_N_m + self.torque_margin_N_m

    def at_arm_length(self, upper_arm_mm: float) -> Corrections:
        """The same with what gravity takes of a joint where arms are not so long as those that were weighed."""
        share = upper_arm_mm / self.mass_estimate.upper_arm_mm
        if not self.mass_estimate.own or abs(share - 1.0) <= WEIGHED_AGAIN:
            return self
        torque = self.mass_estimate.gravity_torque_N_m * share**_GRAVITY_EXPONENT
        return replace(self, mass_estimate=replace(self.mass_estimate, gravity_torque_N_m=torque))

    @property
    def raised_limits(self) -> RaisedLimits:
        """What closed forms asked of the limits in `_RAISED`."""
        return self.couple_index_min, self.couple_per_mm, self.elbow_angle_deg

    def with_raised_limits(self, least: RaisedLimits) -> Corrections:
        """The same with at least these required values."""
        return replace(self, **dict(zip(_RAISED, map(max, self.raised_limits, least), strict=True)))

    def raised(self, length: str, least_mm: float, why: str) -> Corrections:
        """The same with a length that is at least so much."""
        return self.updated(why, least_mm={**self.least_mm, length: max(least_mm, self.least(length))})

    def with_shares_of(self, other: Corrections) -> Corrections:
        """The same with outline and masses, and the room left for them, of another."""
        names = (
            "mass_estimate",
            "interferences",
            "overhead_mm",
            "reach",
            "height_beyond_mm",
            "mass_share",
            "friction_share",
            "step_share",
            "ball_friction_N",
            "torque_margin_N_m",
            "pull_N",
        )
        return replace(self, **{name: getattr(other, name) for name in names})

    def updated(self, reason: str, **changes: Any) -> Corrections:
        """The same with other bounds, and why."""
        return replace(self, **changes, why=(*self.why, reason))


def _chains(pair: Sequence[str]) -> set[str]:
    """Gives the chains of parts, by their names; "" of a part of the base or the platform."""
    return {next((word for word in name.split("_") if word.isdigit()), "") for name in pair}


def _one_chain(pair: Sequence[str]) -> bool:
    """Decides whether parts are of one chain."""
    return len(_chains(pair)) == 1


def folds(pair: Sequence[str]) -> bool:
    """Decides whether rods came too close to their own arm, its motor or what holds it, by the names of both parts."""
    return _one_chain(pair) and any(name.startswith("rod") for name in pair) and not any("wrist" in n for n in pair)


SECTORS = "sectors"  # what swings inwards beside what stands of a neighbour
_NEIGHBOUR = 0.25  # share of the neighbour's base radius in their room: 0.2 to 0.3 of designs of 26 to 42 mm
SIDE_PAIR, REAR_PAIR = "side_pair", "rear_pair"  # chain 0 with one of its neighbours, and chains 1 and 2


def as_symmetric(rows: np.ndarray, width_mm: float) -> dict[str, tuple[np.ndarray, ...]]:
    """Tells how far out chains stand and how far apart neighbours are by the radii of a three-fold symmetric machine.

    Neighbours are as far apart as the nearest ends of their bars, L_c along the shoulder axis, and square to the plane
    half-way between both azimuths: of chains 0 and 1 that is so at the mean of their base radii.

    Args:
        rows: (9, ...) in the order of `VARIABLES`, mm.
        width_mm: L_c.

    Returns:
        "shoulders": R_0 and R_1; `SECTORS`: base radii at which a symmetric machine's sectors have as much room beside
        what stands of a neighbour; `SIDE_PAIR`, `REAR_PAIR`: base radius at which neighbours of a symmetric machine are
        as far apart; "wrists": platform radius at which they are as far apart as those of either pair.
    """
    base, platform, (shift, cosine) = rows[2], rows[3], rows[6:8]
    factors = between_neighbours(cosine)

    def alike(radius: np.ndarray, by_radius: np.ndarray, by_width: np.ndarray) -> np.ndarray:
        return (by_radius * radius + (0.5 - by_width) * width_mm) / np.sqrt(3.0)

    means = base + shift / 2.0, base + shift
    side, rear = (alike(mean, *factor) for mean, factor in zip(means, factors, strict=True))
    wrists = tuple(alike(platform, *factor) for factor in factors)
    return {
        "shoulders": (base, base + shift),
        SECTORS: (base + _NEIGHBOUR * shift, base + (1.0 - _NEIGHBOUR) * shift),
        SIDE_PAIR: (side,),
        REAR_PAIR: (rear,),
        "wrists": wrists,
    }


def placed_sides(rows: np.ndarray, width_mm: float, reach: ChainReach | None) -> np.ndarray:
    """Computes the lengths of a placed machine along y and along x: between level elbows, and its drives.

    Args:
        rows: (9, ...) in the order of `VARIABLES`, mm.
        width_mm: L_c, the length of a bar.
        reach: Of a chain; None: the ends of its bar.

    Returns:
        (2, n, ...) along y and along x, each from an elbow or a drive on one side to one on the other, mm; the largest
        is the length of the machine.
    """
    arm, base, (shift, cosine) = rows[0], rows[2], rows[6:8]
    sine = np.sqrt((1.0 - cosine) * (1.0 + cosine))
    c = np.stack([np.ones_like(cosine), cosine, cosine])[:, None]  # (chains, 1, ...)
    s = np.stack([np.zeros_like(sine), sine, -sine])[:, None]
    stand = np.stack([base, base + shift, base + shift])[:, None]
    if reach is None:
        reach = ChainReach(((-width_mm / 2.0, 0.0), (width_mm / 2.0, 0.0)))

    def column(values: Sequence[float]) -> np.ndarray:
        return np.reshape(values, (-1, *[1] * np.ndim(arm)))

    def ends(out: np.ndarray, along: np.ndarray, radius: np.ndarray) -> tuple[np.ndarray, ...]:
        """How far circles of all chains reach along y, -y, x and -x; (...) each, of (k, ...) circles."""
        level = stand + out
        x, y = c * level - s * along, s * level + c * along
        return tuple(one.max(axis=(0, 1)) for one in (radius + y, radius - y, radius + x, radius - x))

    kinds = [ends(arm, *map(column, zip(*reach.elbow_mm, strict=True)))]
    if reach.drive_mm:
        out, along = map(column, zip(*reach.drive_mm, strict=True))
        kinds.append(ends(out, along + reach.farther_mm(base), column([0.0])))
    return np.array([[one[k] + other[k + 1] for one in kinds for other in kinds] for k in (0, 2)])


def apart_by(pair: Sequence[str], placed: bool = False) -> tuple[str, float]:
    """Gives the length that brings two parts of a machine farther apart, and a step of it, mm.

    Args:
        pair: Names of both parts.
        placed: Whether the chains are placed: then two of them go apart by themselves.
    """
    of_rods = pair and all(name.startswith("rod_") for name in pair)
    if any("wrist" in name for name in pair) or (of_rods and not _one_chain(pair)):  # nearest where they meet
        return "platform_radius", _RADIUS_STEP_MM
    if _one_chain(pair) and any("cheek" in name for name in pair) and any(name.startswith(_ELBOW) for name in pair):
        return "upper_arm_length", _ARM_STEP_MM  # the wide end of a short arm, turned down onto what holds it
    if placed and len(chains := _chains(pair) - {""}) > 1:
        return SIDE_PAIR if "0" in chains else REAR_PAIR, _RADIUS_STEP_MM
    return "base_radius", _RADIUS_STEP_MM
