"""A push against a virtual wall in the time domain: a hand comes, leans on the wall and holds still.

The handle rests `_GAP` before the wall, the hand moves its aim smoothly into it until it leans on it with `LEAN`, and
holds. `oscillation` decides on what follows. Nothing is linear here: counts, bristles, saturation, the supervisor and
leaving the wall are all in it. One trial of two seconds takes some 40 ms. Importing this module loads numba.

`oscillation` is one criterion for simulated and measured series. After the push the hand holds still, so position and
force should settle. The last two windows of the record are compared, each with its straight line (creep) taken off. It
oscillates if in the last one the position

- still swings by more than a few counts of the encoder, as seen at the handle: a cycle of one count is quantisation,
  and is reported as an amplitude but not called an oscillation;
- swings to and fro, at least `_REVERSALS` times across half a count (a quarter to each side): a bend of the creep
  does not;
- has not fallen below `decay` times what it was in the window before: what is halved each half second dies away. Here
  the root mean square is compared under a Hann window, which the phase of two or three swings hardly touches.

A record with a value that is not finite has diverged, and oscillates.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism import jacobian
from haptics.control.supervisor.faults import LATCHING, FaultCode
from haptics.control.wall_cap import UNCAPPED
from haptics.loop.assumptions import DELAY, default_controller, encoder_count, joint_friction, nominal_plant
from haptics.loop.choice import LoopChoice
from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors
from haptics.loop.simulation import SUBSTEPS, SimulatedRun, simulate, timing
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand, Plant
from haptics.model.sensor import EXACT
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import AXES, WALL_BLEND, axis_wall

PERIOD = 1e-3  # Period of the paper's loop, s
_GAP = 2e-3  # Between the handle and the wall at the start, m
# Force with which the hand leans on the wall, as a share of the design's: well felt, and room for swings below the
# limit.
LEAN = 0.6
# To which the hand aims into a soft wall, m; softer walls are leaned on with less, so that the cube is not left.
_DEEPEST = 10e-3
READY = 0.6  # Before the hand sets out, s: the supervisor's ramp of half a second, and the handle at rest
_COMES = 0.4  # Time in which the hand's aim moves into the wall, s
LOOP_SUBSTEPS = 2  # Steps of the plant in a period of a loop of 8 kHz: a twelfth of what rings fastest in it
# Deviations of an encoder's noise that count as a count: with three of them a swing is beyond what noise draws in 1 s.
_WIDTH = 3.0
# Swings up to three times this, 10 um peak to peak, are no oscillation, however fine the encoder: about what fingers
# feel at 40 to 60 Hz, at which walls swing; from memory.
LEAST = 10e-6 / 3.0
_CALMS = 0.1  # Time left out, in which what the push itself stirs up dies away, s
_WINDOW = 0.5  # Length of each of the two windows that are tested for oscillation, s
Level = Literal["least", "nominal", "largest"]
LEVELS: tuple[Level, ...] = ("least", "nominal", "largest")  # Places in the ranges of `assumptions.Friction`


@dataclass(frozen=True)
class WallTrial:
    """One push against one wall.

    Attributes:
        stiffness: Stiffness of the wall, N/m.
        recording: What happened; the hand sets out at `READY`.
        depth: (n,) of the handle in the wall, m; negative before it.
        push: (n,) force of the wall that the laws ask for, N.
        verdict: Verdict from when the push is over; None where the supervisor cut the force.
        resolution: One count at the handle along the normal, or the width of the encoder's noise, m.
        faults: What the supervisor latched.
        limited: Whether it took force away after the push, since the wall had given the hand all the energy it may.
    """

    stiffness: float
    recording: SimulatedRun
    depth: np.ndarray
    push: np.ndarray
    verdict: _Oscillation | None
    resolution: float
    faults: int
    limited: bool = False

    @property
    def stable(self) -> bool:
        """Whether the wall stands: no oscillation, no fault, and all of its force."""
        return self.verdict is not None and not self.verdict.oscillates and not self.limited

    @property
    def reached(self) -> bool:
        """Whether the wall was touched at all; else friction held the handle, or it was driven off."""
        return bool((self.push != 0.0).any())


def with_friction(machine: MachineModel, level: Level) -> Plant:
    """The device with friction at one place of its range.

    Args:
        machine: The device.
        level: Place in the range.

    Raises:
        ValueError: There is no such place.
    """
    if level not in LEVELS:
        raise ValueError(f"friction is {level!r}; it must be one of {', '.join(LEVELS)}")
    return joint_friction(machine).of(nominal_plant(machine), LEVELS.index(level))


class WallBench:
    """Pushes of a hand against walls of any stiffness across one axis, through the centre of the cube.

    Args:
        machine: The device.
        met: Direction of the push that meets the wall, "+x" to "-z"; "x" is "+x".
        hand: The hand that pushes; it needs a stiffness to lean with.
        friction: Place in the range of the joints' friction.
        delay: Time from reading to torque, s.
        damping: Damping of the wall, N s/m.
        seed: Seed of the places of the encoders' counts; the same seed gives the same trials.
        period: Period of the loop, s.
        substeps: Steps of the plant in a period; with 4 a trial takes 40 % of the time, and limits stay where they are.
        loop: In place of period and delay a loop with all that the device has: cable and structure that give way, drive
            damping, noise; its delay the nominal one, its damping the least of the wall's.

    Raises:
        LawError: Damping or direction are refused.
        ValueError: Delay, period or the friction's name are refused, or the hand has no stiffness.
    """

    def __init__(
        self,
        machine: MachineModel,
        met: str,
        hand: Hand,
        friction: Level = "nominal",
        delay: float = DELAY[1] * PERIOD,
        *,
        damping: float = 0.0,
        seed: int = 0,
        period: float = PERIOD,
        substeps: int = SUBSTEPS,
        loop: LoopChoice | None = None,
    ) -> None:
        if loop is not None:
            period, delay = loop.period, loop.delay + reading_age(machine, loop)
            damping, substeps = max(damping, loop.damping), LOOP_SUBSTEPS
        self.blend = WALL_BLEND if loop is None else loop.blend
        self.met = met if met[:1] in ("+", "-") else f"+{met}"
        axis_wall(self.met, 0.0, stiffness=0.0, damping=damping)  # refuses a wrong direction or damping
        if not (math.isfinite(hand.stiffness) and hand.stiffness > 0.0):
            raise ValueError(f"the hand's stiffness is {hand.stiffness!r} N/m; it must be positive to lean on a wall")
        self.along = np.array(AXES[self.met[1]]) * (1.0 if self.met[0] == "+" else -1.0)
        self.damping, self.hand, self.seed = damping, hand, seed
        force = machine.design.requirements.force_N
        self.centre = machine.centre
        self.face = float(self.centre["xyz".index(self.met[1])])
        self.lean = LEAN * force
        self.plant, self.errors = with_friction(machine, friction), EXACT
        if loop is not None:
            self.plant, self.errors = real_plant(machine, loop, LEVELS.index(friction)), sensor_errors(machine, loop)
        controller = default_controller(machine, period) if loop is None else board_controller(machine, loop)
        self.controller = controller._replace(force=force, walls=UNCAPPED)  # what is looked for is the limit
        self.clock, self.count = timing(period, delay, substeps), encoder_count(machine)
        reach = float(np.abs(self.along @ jacobian(machine.geometry, self.centre)).max())
        self.resolution = max(self.count, _WIDTH * self.errors.noise) * reach
        ticks = round((READY + _COMES + _CALMS + 2.0 * _WINDOW) / period) + 1  # rounding must not shorten the windows
        share = np.clip((np.arange(ticks) * period - READY) / _COMES, 0.0, 1.0)
        self.share = share**3 * (10.0 + share * (6.0 * share - 15.0))
        self.still = np.zeros((ticks, 3))

    def stands(self, stiffness: float) -> bool:
        """Whether a wall of this stiffness (N/m) is stable, for `walls.search`; a trial takes some 40 ms."""
        return self.trial(stiffness).stable

    def trial(self, stiffness: float) -> WallTrial:
        """One push against a wall of a stiffness K_e (N/m).

        Raises:
            LawError: The stiffness is refused.
        """
        start = self.centre - _GAP * self.along
        depth = min(self.lean / stiffness, _DEEPEST) if stiffness > 0.0 else _DEEPEST
        way = _GAP + depth + min(self.lean, stiffness * depth) / self.hand.leaning
        recording = simulate(
            self.plant,
            self.controller,
            law_table(axis_wall(self.met, self.face, stiffness=stiffness, damping=self.damping, blend=self.blend)),
            self.clock,
            start,
            hand=self.hand,
            anchor=start + self.share[:, None] * way * self.along,
            push=self.still,
            count=self.count,
            errors=self.errors,
            seed=self.seed,
        )
        depth = (recording.position - self.centre) @ self.along
        push = -recording.force @ self.along
        faults = int(np.bitwise_or.reduce(recording.bits)) & LATCHING
        settled = slice(round((READY + _COMES + _CALMS) / self.clock.period), None)
        verdict = None
        if not faults and (push[settled] != 0.0).any():
            verdict = oscillation(
                depth[settled], push[settled], self.clock.period, max(self.resolution, LEAST), window=_WINDOW
            )
        limited = bool(int(np.bitwise_or.reduce(recording.bits[settled])) & FaultCode.ENERGY_LIMITED.bit)
        return WallTrial(stiffness, recording, depth, push, verdict, self.resolution, faults, limited)


# Two full swings in a window of half a second are 4 Hz; the softest wall of the protocol with the heaviest hand of the
# set, 1100 N/m on 0.27 kg, swings at 10 Hz.
_REVERSALS = 4
_GROWS = (
    1.1  # Ratio of two windows' swings from which growth is distinguished from beats and rounding of a steady cycle
)
Kind = Literal["settles", "sustained", "grows", "diverged"]


@dataclass(frozen=True)
class _Oscillation:
    """Oscillation of a record: its swing, its decay and its frequency.

    Attributes:
        kind: "settles", "sustained", "grows" or "diverged".
        swing: Peak to peak of the position in the last window, m.
        ratio: Ratio of the root mean squares of the last window and the one before; 0 if both are still, infinite if it
            began in the last.
        force_swing: Peak to peak of the force in the last window, N.
        frequency: From the reversals in the last window, Hz; 0 without any.
        contact: Share of both windows in which the wall pushes; below 1 the handle bounces.
    """

    kind: Kind
    swing: float
    ratio: float
    force_swing: float
    frequency: float
    contact: float

    @property
    def oscillates(self) -> bool:
        """Whether it would be called an oscillation."""
        return self.kind != "settles"


def oscillation(
    position: ArrayLike,
    force: ArrayLike,
    period: float,
    resolution: float,
    *,
    window: float = 0.5,
    counts: float = 3.0,
    decay: float = 0.5,
) -> _Oscillation:
    """Decides whether a record oscillates, from where the push is steady.

    Args:
        position: (n,) true position along the wall's normal, m; measured ones will do, a count coarser.
        force: (n,) force of the wall, N; 0 outside.
        period: Between samples, s.
        resolution: One count of the encoder at the handle along the normal, m.
        window: s; the record must hold two.
        counts: Swings up to so many counts are quantisation.
        decay: Ratio of the last window's swing to the one's before, below which it dies away.

    Raises:
        ValueError: The series differ in length or are shorter than two windows, a parameter is not positive, or the
            handle was not at the wall at all in both windows.
    """
    x, f = np.asarray(position, dtype=float), np.asarray(force, dtype=float)
    for name, value in (("period", period), ("resolution", resolution), ("window", window)):
        if not (np.isfinite(value) and value > 0.0):
            raise ValueError(f"{name} is {value!r}; it must be finite and positive")
    n = round(window / period)
    if x.ndim != 1 or x.shape != f.shape or len(x) < 2 * n or n < 2:
        raise ValueError(f"position {x.shape} and force {f.shape} must be alike and hold two windows of {n} samples")
    if not (np.isfinite(x).all() and np.isfinite(f).all()):
        return _Oscillation("diverged", np.inf, np.inf, np.inf, 0.0, float(np.mean(f[-2 * n :] != 0.0)))
    contact = float(np.mean(f[-2 * n :] != 0.0))
    if contact == 0.0:
        raise ValueError(
            f"the handle was not at the wall in the last {2.0 * window:g} s; the record says nothing of it"
        )
    last, ratio = off_line(x[-n:]), decay_ratio(x[-2 * n :])
    swing, reversals = float(np.ptp(last)), _reversals(last, resolution / 4.0)
    small = swing <= counts * resolution or reversals < _REVERSALS
    kind: Kind = "settles" if small or ratio < decay else "grows" if ratio > _GROWS else "sustained"
    return _Oscillation(kind, swing, ratio, float(np.ptp(off_line(f[-n:]))), reversals / (2.0 * window), contact)


def decay_ratio(series: np.ndarray) -> float:
    """Root mean square of the second half of a series to that of the first, each off its straight line; 0 if both are
    still, infinite if the motion began in the second.
    """
    n = len(series) // 2
    now, was = (_root_mean_square(off_line(half)) for half in (series[-n:], series[-2 * n : -n]))
    return now / was if was > 0.0 else (np.inf if now > 0.0 else 0.0)


def strongest_line(series: np.ndarray, period: float) -> float:
    """Frequency of the strongest line of a series off its straight line, Hz, to an eighth of its length's inverse."""
    n = len(series)
    _, weight = _hann(n)
    spectrum = np.abs(np.fft.rfft(weight * off_line(series), 8 * n))
    return float(np.argmax(spectrum)) / (8 * n * period)


def off_line(series: np.ndarray) -> np.ndarray:
    """A series less its straight line of least squares, weighted by a Hann window: from two swings on, a swing itself
    hardly tilts that line, whatever its phase.
    """
    t, weight = _hann(len(series))
    level = (weight @ series) / weight.sum()
    slope = (weight * t @ series) / (weight * t @ t)
    return series - level - slope * t


def _root_mean_square(series: np.ndarray) -> float:
    _, weight = _hann(len(series))
    return float(np.sqrt(weight @ series**2 / weight.sum()))


def _hann(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Places from -1 to 1 and their weights."""
    t = np.linspace(-1.0, 1.0, n)
    return t, np.cos(np.pi / 2.0 * t) ** 2


def _reversals(series: np.ndarray, dead: float) -> int:
    """Changes of side, where only values beyond a dead band take a side."""
    sides = np.sign(series[np.abs(series) > dead])
    return int(np.count_nonzero(sides[1:] != sides[:-1]))
