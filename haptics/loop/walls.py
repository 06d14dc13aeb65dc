"""Four definitions of the largest wall stiffness, with different guarantees, and the formula behind them.

- own: passive by the device's own damping alone, B = 0: whatever passive hand, exact (`passivity.strain`). It belongs
  to the device and its drives.
- passive: the same with the loop's damping B.
- worst: stable with each hand of the set and with none, with B.
- nominal: stable with the nominal hand, with B.

Behind all of them stands one formula, `b + B >= K (T / 2 + delay + lag)` with the device's friction b at the handle:
what a sample costs is half a period, the delay and the lag. Hands help, or take little. A rendered wall is capped at
`STABILITY_MARGIN` of the worst of the cases at its pose.

Source:
    Vibration modes and a free handle as the worst case: I. Diaz, J. J. Gil, IEEE Trans. Robotics 26(1), 2010 (first
    page opened). The filter's corner: V. Chawda, O. Celik, M. K. O'Malley, A method for selecting velocity filter
    cut-off frequency, 2014 (first page opened). Z-width and own damping: J. E. Colgate with J. M. Brown 1994 and with
    G. G. Schenkel 1997 (not opened).

`search` finds the largest stable wall by the paper's protocol and a bisection, whatever says whether one is stable.
`proven_cap` tries the closed form by which a tick caps its walls against the eigenvalues of the device over the cube:
the form knows friction, delay and damping; cable, structure, filter and the coupling of the axes are in the
eigenvalues. Where a device bears less than the form says, all its walls are scaled down by one figure before its
controller is written. Importing this module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from haptics.control.wall_cap import MAX_DAMPING_RATIO, STABILITY_MARGIN, WallCap
from haptics.loop.choice import BOARD, LoopChoice
from haptics.loop.discrete import bisect, limits, scanned
from haptics.loop.hardware import LOSS, real_plant, stiff_plant, wall_cap
from haptics.loop.linear import LinearLoop, linearise, structure_at
from haptics.loop.passivity import Handle, handle, strain
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand
from haptics.rendering.laws.virtual_wall import VirtualWall

NOBODY = "nobody"
# Softest and stiffest wall that is looked at, N/m; points of the scan, rounds of the bisections, and the ratio of the
# ends that these leave, 1.0005: a bit above it, so that rounding adds no round.
SOFTEST, STIFFEST, POINTS, ROUNDS = 10.0, 300e3, 40, 9
_BRACKET = (STIFFEST / SOFTEST) ** (1.01 * 0.5**ROUNDS / (POINTS - 1))


@dataclass(frozen=True)
class StiffnessLimits:
    """Largest walls across one direction at a pose, N/m.

    Attributes:
        own: Passive by the device's own damping, B = 0.
        passive: Passive with the loop's damping B.
        worst: Stable with every hand.
        worst_hand: With whom that is; "nobody" for a handle let go of.
        nominal: Stable with the nominal hand.
        friction: b, viscous friction of the device along the direction, N s/m.
        formula: `(b + B) / (T / 2 + delay + lag)`.
    """

    own: float
    passive: float
    worst: float
    worst_hand: str
    nominal: float
    friction: float
    formula: float


class WallStability(LinearLoop):
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
        super().__init__(
            machine, loop, linearise(par, at, None if rigid else structure_at(machine, at, LOSS[place])), delay
        )
        self.normal, self.damping = np.asarray(normal, dtype=float), loop.damping
        self.friction = self.here.effective_friction(self.normal)

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
        passive = scanned(
            lambda k: float(strain(at, self.estimator, k, damping).max()) <= 1.0,
            np.geomspace(SOFTEST, STIFFEST, POINTS).tolist(),
            _BRACKET,
        )
        return min(passive, self.stable(FREE, damping)) if passive > 0.0 else 0.0

    def walls(self, hands: Mapping[str, Hand] = HANDS, nominal: str = "medium") -> StiffnessLimits:
        """All four, with a set of hands by name, and nobody."""
        at = self.at_handle()
        by_hand = {name: self.stable(hand) for name, hand in {NOBODY: FREE, **hands}.items()}
        worst = min(by_hand, key=lambda name: by_hand[name])
        return StiffnessLimits(
            own=self.passive(0.0, at),
            passive=self.passive(self.damping, at),
            worst=by_hand[worst],
            worst_hand=worst,
            nominal=by_hand[nominal],
            friction=self.friction,
            formula=self.formula,
        )


def computed_wall(machine: MachineModel, p: ArrayLike, normal: ArrayLike, loop: LoopChoice = BOARD) -> float:
    """Largest wall that is stable let go of with the least friction and the largest delay, N/m: what is capped from."""
    late = loop.delays[2] * loop.period
    return WallStability(machine, loop, p, normal, place=0, delay=late).stable(FREE)


def centre_and_corners(machine: MachineModel) -> list[np.ndarray]:
    """The poses (3,) of a cube at which stability over the whole cube is tested, m."""
    corners = (machine.centre + machine.half_side * np.array(signs) for signs in product((-1.0, 1.0), repeat=3))
    return [machine.centre, *corners]


def capped(machine: MachineModel, wall: VirtualWall, p: ArrayLike, loop: LoopChoice = BOARD) -> VirtualWall:
    """The wall rendered at a pose: at most `STABILITY_MARGIN` of the stable one, with at least the loop's damping.

    Args:
        machine: The device.
        wall: As asked.
        p: (3,) where it is touched, m.
        loop: The loop.
    """
    normal = np.asarray(wall.normal, dtype=float)
    normal = normal / np.linalg.norm(normal)
    most = STABILITY_MARGIN * computed_wall(machine, p, normal, loop)
    return replace(
        wall,
        stiffness=min(wall.stiffness, most),
        damping=max(wall.damping, loop.damping),
        blend=min(wall.blend, loop.blend),
    )


# The paper's protocol, N/m: K_e starts at 1.1 N/mm and grows by 0.2 N/mm until the user feels oscillation.
START, STEP = 1100.0, 200.0
Predicate = Callable[[float], bool]  # Stiffness (N/m) -> whether the wall is stable


@dataclass(frozen=True)
class WallSearch:
    """Largest stable stiffness of a wall (the Z-width of one axis), as a search brackets it.

    Attributes:
        protocol: Last stable stiffness of the paper's steps, N/m; None if the first one oscillates.
        bisection: Largest stable stiffness to the tolerance, N/m.
        history: Each stiffness tried (N/m) with its answer, in order.
        ceiling_reached: It never oscillated up to the ceiling; both values are then lower bounds.
    """

    protocol: float | None
    bisection: float
    history: tuple[tuple[float, bool], ...]
    ceiling_reached: bool


def search(
    stable: Predicate, *, start: float = START, step: float = STEP, ceiling: float = 20e3, tolerance: float = 10.0
) -> WallSearch:
    """Largest stable stiffness by the paper's protocol, then by bisection within its last step.

    Args:
        stable: Called once for each stiffness, N/m.
        start: First stiffness, N/m.
        step: N/m.
        ceiling: Stiffness at which the search ends, N/m.
        tolerance: Tolerance of the bisection, N/m.

    Returns:
        Both values and the history. If the first stiffness oscillates already, the bisection is between 0 and it.

    Raises:
        ValueError: A parameter is not positive, or the ceiling lies below the start.
    """
    for name, value in (("start", start), ("step", step), ("tolerance", tolerance)):
        if not (math.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r} N/m; it must be finite and positive")
    if not (math.isfinite(ceiling) and ceiling >= start):
        raise ValueError(f"ceiling is {ceiling!r} N/m; it must be finite and at least the start, {start:g} N/m")
    history: list[tuple[float, bool]] = []

    def ask(stiffness: float) -> bool:
        answer = bool(stable(stiffness))
        history.append((stiffness, answer))
        return answer

    protocol: float | None = None
    for i in range(math.floor((ceiling - start) / step + 1e-9) + 1):  # the ceiling itself belongs to it
        stiffness = start + i * step
        if not ask(stiffness):
            break
        protocol = stiffness
    else:
        assert protocol is not None
        return WallSearch(protocol, protocol, tuple(history), ceiling_reached=True)
    low, _ = bisect(ask, protocol or 0.0, stiffness, width=tolerance)
    return WallSearch(protocol, low, tuple(history), ceiling_reached=False)


# Shares of the closed form that are tried, the largest first; then the same with a half of the damping that a wall may
# ask for, and so on: drives that add no damping bear less of it on a large device. None of them: the loop is refused.
_SCALES = (*(0.02 * k for k in range(50, 35, -1)), 0.7, 0.6, 0.5)
_LAST_SCALES = (0.4, 0.3, 0.2, 0.1)
_HEAVY = (1.0, 0.5, 0.25, 0.125, 0.0625)
_PARTS = (0.05, 0.3, 0.6, 0.85, 1.0)  # Walls tried at a pose, as shares of the stiffest: a softer one must stand, too
_NORMALS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
_STRONG = 1e3  # A damping beyond all caps, N s/m


def closed_form(cap: WallCap, jacobian: np.ndarray, normal: np.ndarray, damping: float = 0.0) -> tuple[float, float]:
    """Stiffness (N/m) and damping (N s/m) that are stable across a direction, as `wall_cap.stable_wall` has them."""
    q = float(np.square(jacobian.T @ normal).sum())
    kept = min(max(damping, cap.damping), MAX_DAMPING_RATIO * cap.inertia / (q * cap.late))
    return cap.share * (cap.friction / q + kept) / cap.cost, kept


def rendered(cap: WallCap, jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The wall that a tick renders at most, across the direction in which it renders least.

    The closed form falls with `|J^T n|^2`, whose largest value is an eigenvalue of `J J^T`.

    Args:
        cap: What the loop bears.
        jacobian: (..., 3, 3) J, m/rad.

    Returns:
        Stiffness (...) N/m, damping (...) N s/m, and normal (..., 3).
    """
    values, vectors = np.linalg.eigh(jacobian @ np.swapaxes(jacobian, -1, -2))
    q = values[..., 2]
    damping = np.minimum(cap.damping, MAX_DAMPING_RATIO * cap.inertia / (q * cap.late))
    return cap.share * (cap.friction / q + damping) / cap.cost, damping, vectors[..., 2]


def proven_cap(machine: MachineModel, loop: LoopChoice = BOARD) -> WallCap:
    """The cap of a loop, scaled so that every wall it lets through at full scale is stable let go of.

    Tried are the centre and the corners of the cube, three normals, least friction, largest delay, with the loop's
    damping and with the largest that is stable; what is rendered is `STABILITY_MARGIN` of it.

    Returns:
        The cap, its share times `STABILITY_MARGIN`, its inertia as far as the damping that a wall asks for is stable.

    Raises:
        ValueError: Even a tenth of the closed form is unstable somewhere.
    """
    tried = [
        WallStability(machine, loop, pose, normal, place=0, delay=loop.delays[2] * loop.period)
        for pose, normal in product(centre_and_corners(machine), _NORMALS)
    ]
    whole = wall_cap(machine, loop, 1.0)
    for heavy, scale in (*product(_HEAVY, _SCALES), *product(_HEAVY[-1:], _LAST_SCALES)):
        cap = whole._replace(share=scale, inertia=heavy * whole.inertia)
        if all(_stands(at, cap) for at in tried):
            return cap._replace(share=STABILITY_MARGIN * scale)
    raise ValueError(
        f"a loop of {1.0 / loop.period:g} Hz bears no wall at some pose, not even {_LAST_SCALES[-1]:g} of its form"
    )


def _stands(at: WallStability, cap: WallCap) -> bool:
    """Whether the walls that a cap lets through are stable with nobody at the handle."""
    loop = at.here.joint_loop(at.normal, FREE, at.timing, at.estimator, at_motor=at.at_motor)
    for required in (0.0, _STRONG):
        stiffness, damping = closed_form(cap, at.here.jacobian, at.normal, required)
        if any(loop.radius(part * stiffness, damping) >= 1.0 for part in _PARTS):
            return False
    return True
