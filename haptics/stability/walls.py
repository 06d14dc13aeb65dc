"""Four answers to "how stiff a wall", which promise different things, and the formula behind them.

- own: passive by the device's own damping alone, B = 0: whatever passive hand, exact (`port.strain`). It belongs to the
  device and its drives.
- passive: the same with the loop's damping B.
- worst: stable with each hand of the set and with none, with B.
- nominal: stable with the nominal hand, with B.

Behind all of them stands one formula, `b + B >= K (T / 2 + delay + lag)` with the device's friction b at the handle:
what a sample costs is half a period, the delay and the lag. Hands help, or take little. A rendered wall is capped at
`SHARE` of the worst of the cases at its pose.

Source:
    Vibration modes and a free handle as the worst case: I. Diaz, J. J. Gil, IEEE Trans. Robotics 26(1), 2010 (first
    page opened). The filter's corner: V. Chawda, O. Celik, M. K. O'Malley, A method for selecting velocity filter
    cut-off frequency, 2014 (first page opened). Z-width and own damping: J. E. Colgate with J. M. Brown 1994 and with
    G. G. Schenkel 1997 (not opened).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from haptics.control.filters import low_pass
from haptics.control.wall_cap import SHARE
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand
from haptics.rendering.laws.virtual_wall import VirtualWall
from haptics.simulation.hardware import LOSS, reading_age, real_plant, sensor_errors, stiff_plant
from haptics.simulation.loops import BOARD, LoopChoice
from haptics.stability.discrete import Timing, limits
from haptics.stability.estimator_models import LinearEstimator, linear_models
from haptics.stability.linear import Linearised, linearise, structure_at
from haptics.stability.port import Handle, handle, strain

NOBODY = "nobody"
# Softest and stiffest wall that is looked at, N/m; points of the scan and rounds of the bisections, which leave 0.1 %.
SOFTEST, STIFFEST, POINTS, ROUNDS = 10.0, 300e3, 40, 9


@dataclass(frozen=True)
class Walls:
    """Largest walls across one direction at a pose, N/m.

    Attributes:
        own: Passive by the device's own damping, B = 0.
        passive: Passive with the loop's damping B.
        worst: Stable with every hand.
        worst_hand: With whom that is; "nobody" for a handle let go of.
        nominal: Stable with the nominal hand.
        by_hand: Of each hand, N/m.
        friction: b, viscous friction of the device along the direction, N s/m.
        formula: `(b + B) / (T / 2 + delay + lag)`.
    """

    own: float
    passive: float
    worst: float
    worst_hand: str
    nominal: float
    by_hand: Mapping[str, float]
    friction: float
    formula: float


class WallAt:
    """A wall across a direction, at a pose of a device in a loop.

    Args:
        machine: The device.
        loop: The loop.
        p: (3,) pose, m; the cube's centre if left out.
        normal: (3,) unit normal of the wall.
        place: Of friction in its range: 0 least, 1 nominal, 2 largest.
        delay: From reading to torque, s; the loop's nominal one if left out. The age of a reading comes on top.
        rigid: Whether cable and structure are left out.

    Raises:
        ValueError: The pose is out of reach or singular, or the normal no unit vector.
    """

    def __init__(
        self,
        machine: MachineModel,
        loop: LoopChoice = BOARD,
        p: ArrayLike | None = None,
        normal: ArrayLike = (1.0, 0.0, 0.0),
        *,
        place: int = 1,
        delay: float | None = None,
        rigid: bool = False,
    ) -> None:
        at = machine.centre if p is None else p
        par = (stiff_plant if rigid else real_plant)(machine, loop, place).in_contact
        self.here: Linearised = linearise(par, at, None if rigid else structure_at(machine, at, LOSS[place]))
        self.normal, self.damping = np.asarray(normal, dtype=float), loop.damping
        self.friction = self.here.effective_friction(self.normal)
        late = (loop.delay if delay is None else delay) + reading_age(machine, loop)
        self.timing = Timing(loop.period, late, loop.current_lag)
        self.at_motor = bool(sensor_errors(machine, loop).at_motor)
        self.estimator: LinearEstimator
        (self.estimator,) = linear_models(low_pass(loop.period, loop.corner))

    @property
    def formula(self) -> float:
        """`(b + B) / (T / 2 + delay + lag)`, N/m."""
        cost = self.timing.period / 2.0 + self.timing.delay + self.timing.current_lag
        return (self.friction + self.damping) / cost

    def stable(self, hand: Hand, damping: float | None = None) -> float:
        """Largest wall that is stable with a hand, N/m: eigenvalues of the whole device."""
        loop = self.here.joint_loop(self.normal, hand, self.timing, self.estimator, at_motor=self.at_motor)
        b = self.damping if damping is None else damping
        return limits(lambda k: loop.radius(k, b), SOFTEST, STIFFEST, POINTS, ROUNDS).value

    def at_handle(self) -> Handle:
        """The device at its handle, without a hand."""
        body, place = self.here.body(FREE)
        ports = self.here.ports(self.normal[:, None], len(body.mass), self.at_motor)
        return handle(body, ports, self.normal @ place, self.timing)

    def passive(self, damping: float = 0.0, at: Handle | None = None) -> float:
        """Largest wall that is passive with any passive hand and stable with none, N/m, exact for the sampled loop."""
        at = self.at_handle() if at is None else at
        passive = _largest(lambda k: float(strain(at, self.estimator, k, damping).max()) <= 1.0)
        return min(passive, self.stable(FREE, damping)) if passive > 0.0 else 0.0

    def walls(self, hands: Mapping[str, Hand] = HANDS, nominal: str = "medium") -> Walls:
        """All four, with a set of hands by name, and nobody."""
        at = self.at_handle()
        by_hand = {name: self.stable(hand) for name, hand in {NOBODY: FREE, **hands}.items()}
        worst = min(by_hand, key=lambda name: by_hand[name])
        return Walls(
            own=self.passive(0.0, at),
            passive=self.passive(self.damping, at),
            worst=by_hand[worst],
            worst_hand=worst,
            nominal=by_hand[nominal],
            by_hand=by_hand,
            friction=self.friction,
            formula=self.formula,
        )


def _largest(holds) -> float:
    """Largest stiffness up to which something holds, N/m: scanned upwards, then bisected."""
    grid = np.geomspace(SOFTEST, STIFFEST, POINTS)
    low = 0.0
    for stiffness in grid.tolist():
        if not holds(stiffness):
            break
        low = stiffness
    else:
        return STIFFEST
    high = stiffness
    for _ in range(ROUNDS if low > 0.0 else 0):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def computed_wall(machine: MachineModel, p: ArrayLike, normal: ArrayLike, loop: LoopChoice = BOARD) -> float:
    """Largest wall that is stable let go of with the least friction and the largest delay, N/m: what is capped from."""
    late = loop.delays[2] * loop.period
    return WallAt(machine, loop, p, normal, place=0, delay=late).stable(FREE)


def centre_and_corners(machine: MachineModel) -> list[np.ndarray]:
    """The poses (3,) of a cube at which what stands everywhere in it is tried, m."""
    corners = (machine.centre + machine.half_side * np.array(signs) for signs in product((-1.0, 1.0), repeat=3))
    return [machine.centre, *corners]


def capped(machine: MachineModel, wall: VirtualWall, p: ArrayLike, loop: LoopChoice = BOARD) -> VirtualWall:
    """The wall as it is rendered at a pose: at most `SHARE` of what is computed, with at least the loop's damping.

    Args:
        machine: The device.
        wall: As asked.
        p: (3,) where it is touched, m.
        loop: The loop.
    """
    normal = np.asarray(wall.normal, dtype=float)
    normal = normal / np.linalg.norm(normal)
    most = SHARE * computed_wall(machine, p, normal, loop)
    return replace(
        wall,
        stiffness=min(wall.stiffness, most),
        damping=max(wall.damping, loop.damping),
        blend=min(wall.blend, loop.blend),
    )
