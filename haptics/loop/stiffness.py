"""Largest stable wall along each axis: of the simulated loop, of the linear loop, and the passive one.

Three answers to one question, kept apart:

- the simulation (`wall_trial`): friction that sticks, counts, saturation, leaving the wall. The nominal case by the
  paper's protocol and a bisection; its range by searches that begin at the linear limit of the extreme cases;
- the linear loop of the whole device (`linear_limits`), over the same range;
- the passivity verdict (`passivity`), which asks for all passive hands instead of three.

The range is hands x friction of the joints x delay, at its ends. In it the case that is extreme in the linear model is
searched first. Each other case whose linear limit is within `RIVAL` times of it is then tried once at that value,
and takes its place if it answers worse (or better, at the upper end). Cases farther off are not simulated.
Nothing here is fitted to what the paper measured. Importing this module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

from delta_cad.common.units import MM_PER_M
from haptics.gravity.published import STIFFNESS_N_PER_MM
from haptics.loop.assumptions import CURRENT_LAG, DELAY, default_estimator, joint_friction, nominal_plant
from haptics.loop.discrete import DampingCap, LinearEstimator, Timing, bisect, damping_cap, linear_model
from haptics.loop.linear import linearise
from haptics.loop.passivity import Verdict, verdict
from haptics.loop.wall_trial import LEVELS, PERIOD, Level, WallBench
from haptics.loop.walls import START, Predicate, WallSearch, search
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand
from haptics.rendering.laws.virtual_wall import AXES

NOMINAL_HAND = "medium"
# Steps of the plant in a period: half a period's delay needs an even number. At 40 % of the time of 10 substeps; over
# the places of the encoders' counts the nominal limit of another hand lay at 7.9 to 8.4 N/mm with 4, at 7.9 to 8.6
# with 20.
SUBSTEPS = 4
# Softest and stiffest wall that is tried, N/m. Into the stiffest 3 N lean by 0.06 mm, two counts of an encoder of 14
# bits on an arm of 80 mm: what happens beyond is not the wall.
FLOOR, CEILING = 50.0, 50e3
TOLERANCE = 0.05  # Relative tolerance of the ends of the range; the assumptions behind them are not known better
NOMINAL_TOLERANCE = 25.0  # Tolerance of the nominal bisection, N/m: an eighth of the paper's step
PLACES = 3  # Places of the encoders' counts with each of which the default wall must stand: one could be lucky
# Factor between trials while no change is bracketed; ratio of linear limits up to which a case is tried: that
# cases farther apart keep their order in the simulation is taken for granted, not shown.
_STRIDE, RIVAL = 1.5, 3.0


@dataclass(frozen=True)
class Corner:
    """A case of what is not known.

    Attributes:
        hand: Name of the hand.
        friction: Place in the range of the joints' friction.
        delay: From reading to torque, s.
    """

    hand: str
    friction: Level
    delay: float

    def __str__(self) -> str:
        return f"{self.hand} hand, {self.friction} friction, delay {self.delay * 1e3:.3g} ms"


@dataclass(frozen=True)
class End:
    """One end of a range.

    Attributes:
        stiffness: Largest stable one of the case, N/m; 0 where the softest wall tried oscillates.
        corner: The case.
        open: It is stable up to `CEILING`: the limit lies above.
    """

    stiffness: float
    corner: Corner
    open: bool = False


@dataclass(frozen=True)
class Range:
    """Largest stable stiffness over all cases.

    Attributes:
        lowest: Smallest value.
        highest: Largest value.
    """

    lowest: End
    highest: End


@dataclass(frozen=True)
class AxisWall:
    """Stable walls across an axis: nominal, over the assumptions, and linear.

    Attributes:
        axis: "x", "y" or "z"; the handle meets the wall in its positive direction, at the cube's centre.
        nominal: The simulated search with the nominal case.
        corner: The nominal case.
        linear_nominal: Linear limit of that case, N/m.
        simulated: Range of the simulation.
        linear: Range of the linear loop.
        published: What [RCIM2018] measured on its prototype, N/m.
        steady: Hand -> whether the default wall stands in the simulation, friction and delay nominal, wherever the
            encoders' counts lie (`PLACES`).
        default_verdict: Verdict on the default wall, friction and delay nominal.
        limit_verdict: Verdict on the stiffest wall of the nominal simulated search; None where there is none.
        trials: Simulated pushes.
    """

    axis: str
    nominal: WallSearch
    corner: Corner
    linear_nominal: float
    simulated: Range
    linear: Range
    published: float
    steady: Mapping[str, bool]
    default_verdict: Verdict
    limit_verdict: Verdict | None
    trials: int


@dataclass(frozen=True)
class Stiffness:
    """Stable walls of a device, axis by axis.

    Attributes:
        axes: x, y, z.
        period: s.
        delays: Least, nominal, largest, s.
        damping: Damping of the wall as requested, N s/m.
        cap: What the loop bears of it.
    """

    axes: tuple[AxisWall, ...]
    period: float
    delays: tuple[float, float, float]
    damping: float
    cap: DampingCap

    @property
    def unstable_cases(self) -> list[tuple[str, str]]:
        """Axis and hand with which the default wall does not stand."""
        return [(wall.axis, hand) for wall in self.axes for hand, stands in wall.steady.items() if not stands]


# Axis, case and place of the encoders' counts (a seed) -> whether a wall of a stiffness stands.
@dataclass(frozen=True)
class WallLoop:
    """The sampled loop whose walls are searched, and the hands that push against them.

    Attributes:
        machine: The device.
        damping: Damping of the wall as applied, N s/m.
        period: s.
        delays: Least, nominal, largest, s.
        estimator: Linear model of the velocity estimator.
        hands: The set, by name.
    """

    machine: MachineModel
    damping: float
    period: float
    delays: tuple[float, float, float]
    estimator: LinearEstimator
    hands: Mapping[str, Hand]


_Ask = Callable[[str, Corner, int], Predicate]


def largest_walls(
    machine: MachineModel,
    *,
    damping: float = 0.0,
    period: float = PERIOD,
    delay: float | None = None,
    axes: Sequence[str] = ("x", "y", "z"),
    hands: Mapping[str, Hand] = HANDS,
    ask: _Ask | None = None,
    say: Callable[[str], None] = lambda _: None,
) -> Stiffness:
    """Largest stable walls across axes through the cube's centre.

    Args:
        machine: The device.
        damping: Damping of the wall as requested, N s/m; applied as far as `damping_cap` allows.
        period: Period of the loop, s.
        delay: From reading to torque, s; None for the range of `assumptions.DELAY`.
        axes: Axes across which the walls stand.
        hands: The set, by name.
        ask: Answers whether a wall stands; None for the simulation.
        say: Called with the axis whose search begins.

    Raises:
        ValueError: Damping, period or delay cannot be, or the set of hands is empty.
    """
    if not (math.isfinite(damping) and damping >= 0.0):
        raise ValueError(f"damping is {damping!r} N s/m; it must be finite and not negative")
    delays = (DELAY[0] * period, DELAY[1] * period, DELAY[2] * period) if delay is None else (delay, delay, delay)
    Timing(period, delays[2], CURRENT_LAG)  # refuses what cannot be
    if not hands:
        raise ValueError("the set of hands is empty; at least one is needed")
    estimator = linear_model(default_estimator(period))
    mass = linearise(nominal_plant(machine), machine.centre).smallest_mass
    cap = damping_cap(mass, period, delays[2], estimator, current_lag=CURRENT_LAG)
    loop = WallLoop(machine, cap.applied(damping), period, delays, estimator, hands)

    def simulated(axis: str, c: Corner, seed: int) -> Predicate:
        return WallBench(
            machine, axis, hands[c.hand], c.friction, c.delay, damping=loop.damping, seed=seed, period=period,
            substeps=SUBSTEPS,
        ).stands  # fmt: skip

    walls = []
    for axis in axes:
        say(axis)
        walls.append(_axis_wall(loop, axis, ask or simulated))
    return Stiffness(tuple(walls), period, delays, damping, cap)


def _axis_wall(loop: WallLoop, axis: str, ask: _Ask) -> AxisWall:
    trials = 0

    def stable_at(corner: Corner, seed: int = 0) -> Predicate:
        stands = ask(axis, corner, seed)
        answers: dict[float, bool] = {}

        def answer(stiffness: float) -> bool:
            nonlocal trials
            if stiffness not in answers:
                trials += 1
                answers[stiffness] = stands(stiffness)
            return answers[stiffness]

        return answer

    name = NOMINAL_HAND if NOMINAL_HAND in loop.hands else next(iter(loop.hands))
    corner = Corner(name, "nominal", loop.delays[1])
    nominal = search(stable_at(corner), tolerance=NOMINAL_TOLERANCE)
    linear = linear_limits(loop, axis)
    (middle,) = linear_limits(replace(loop, hands={name: loop.hands[name]}), axis, ("nominal",))
    limit = nominal.bisection
    return AxisWall(
        axis=axis,
        nominal=nominal,
        corner=corner,
        linear_nominal=middle.stiffness,
        simulated=simulated_range(linear, stable_at),
        linear=Range(linear[0], linear[-1]),
        published=MM_PER_M * STIFFNESS_N_PER_MM[axis],
        steady={
            hand: all(stable_at(Corner(hand, "nominal", loop.delays[1]), seed)(START) for seed in range(PLACES))
            for hand in loop.hands
        },
        default_verdict=_passivity(loop, axis, START),
        limit_verdict=_passivity(loop, axis, limit) if limit > 0.0 else None,
        trials=trials,
    )


def linear_limits(loop: WallLoop, axis: str, levels: tuple[Level, ...] = ("least", "largest")) -> list[End]:
    """Limits of the linear loop of the whole device, ascending, one for each case.

    Args:
        loop: The sampled loop.
        axis: "x", "y" or "z".
        levels: Friction: its ends with the ends of the delay, or the nominal one with the nominal delay.

    Returns:
        The limits, N/m, with their cases.
    """
    viscous = dict(zip(LEVELS, joint_friction(loop.machine).viscous, strict=True))
    delays = loop.delays[1:2] if levels == ("nominal",) else sorted({loop.delays[0], loop.delays[2]})
    ends = []
    for level, delay in product(levels, delays):
        here = linearise(nominal_plant(loop.machine)._replace(viscous=viscous[level]), loop.machine.centre)
        timing = Timing(loop.period, delay, CURRENT_LAG)
        for name, hand in loop.hands.items():
            sampled = here.joint_loop(AXES[axis], hand, timing, loop.estimator)
            ends.append(End(sampled.stiffness_limit(loop.damping).value, Corner(name, level, delay)))
    return sorted(ends, key=lambda end: end.stiffness)


def simulated_range(linear: Sequence[End], stable_at: Callable[[Corner], Predicate]) -> Range:
    """Both ends of the simulated range, as the module's docstring has it.

    Args:
        linear: Limits of the linear loop, ascending.
        stable_at: The simulated answer for a case.
    """
    low = edge(stable_at(linear[0].corner), linear[0])
    for rival in linear[1:]:
        if rival.stiffness > RIVAL * linear[0].stiffness:
            break
        stands = stable_at(rival.corner)
        if low.stiffness > FLOOR and not stands(low.stiffness):
            low = edge(stands, End(low.stiffness, rival.corner))
    high = edge(stable_at(linear[-1].corner), linear[-1])
    for rival in reversed(linear[:-1]):
        if high.open or rival.stiffness * RIVAL < linear[-1].stiffness:
            break
        stands = stable_at(rival.corner)
        above = max(high.stiffness, FLOOR) * (1.0 + TOLERANCE)
        if above <= CEILING and stands(above):
            high = edge(stands, End(above, rival.corner))
    return Range(low, high)


def edge(stands: Predicate, guess: End) -> End:
    """A stable stiffness, with an unstable one `TOLERANCE` above it, nearest to a guess.

    A simulated wall need not be stable up to one stiffness and nowhere above it: counts stir some soft walls that a
    stiffer one swallows. Of several such edges this is the one that is met first from the guess.

    Args:
        stands: Whether a wall of a stiffness (N/m) stands.
        guess: Stiffness at which the search begins, and the case.

    Returns:
        The edge; 0 where the softest wall tried does not stand, open where the stiffest does.
    """
    at = min(max(guess.stiffness, FLOOR), CEILING)
    if stands(at):
        low = at
        while low < CEILING:
            at = min(low * _STRIDE, CEILING)
            if not stands(at):
                break
            low = at
        else:
            return End(CEILING, guess.corner, open=True)
        high = at
    else:
        high = at
        while high > FLOOR:
            at = max(high / _STRIDE, FLOOR)
            if stands(at):
                break
            high = at
        else:
            return End(0.0, guess.corner)
        low = at
    return End(bisect(stands, low, high, ratio=1.0 + TOLERANCE)[0], guess.corner)


def _passivity(loop: WallLoop, axis: str, stiffness: float) -> Verdict:
    """Passivity verdict with nominal friction and delay."""
    here, normal = linearise(nominal_plant(loop.machine), loop.machine.centre), AXES[axis]
    mass, friction = here.effective_mass(normal), here.effective_friction(normal)
    timing = Timing(loop.period, loop.delays[1], CURRENT_LAG)
    return verdict(mass, friction, timing, loop.estimator, stiffness, loop.damping, loop.hands)
