"""A push against a virtual wall in the time domain: a hand comes, leans on the wall and holds still.

The handle rests `GAP` before the wall, the hand moves its aim smoothly into it until it leans on it with `LEAN`, and
holds. `oscillation` decides on what follows. Nothing is linear here: counts, bristles, saturation, the supervisor and
leaving the wall are all in it. One trial of two seconds takes some 40 ms. Importing this module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from delta_cad.mechanism import jacobian
from haptics.control.supervisor.faults import LATCHING, FaultCode
from haptics.control.wall_cap import UNCAPPED
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand, Plant
from haptics.model.sensor import EXACT
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import AXES, WALL_BLEND, axis_wall
from haptics.simulation.assumptions import DELAY, default_controller, encoder_count, joint_friction, nominal_plant
from haptics.simulation.hardware import board_controller, reading_age, real_plant, sensor_errors
from haptics.simulation.loop import SUBSTEPS, SimulatedRun, simulate, timing
from haptics.simulation.loops import LoopChoice
from haptics.stability.oscillation import Oscillation, oscillation

PERIOD = 1e-3  # Period of the paper's loop, s
GAP = 2e-3  # Between the handle and the wall at the start, m
# Force with which the hand leans on the wall, as a share of the design's: well felt, and room for swings below the
# limit.
LEAN = 0.6
# To which the hand aims into a soft wall, m; softer walls are leaned on with less, so that the cube is not left.
DEEPEST = 10e-3
READY = 0.6  # Before the hand sets out, s: the supervisor's ramp of half a second, and the handle at rest
COMES = 0.4  # Time in which the hand's aim moves into the wall, s
LOOP_SUBSTEPS = 2  # Steps of the plant in a period of a loop of 8 kHz: a twelfth of what rings fastest in it
# Deviations of an encoder's noise that count as a count: with three of them a swing is beyond what noise draws in 1 s.
WIDTH = 3.0
# Swings up to three times this, 10 um peak to peak, are no oscillation, however fine the encoder: about what fingers
# feel at 40 to 60 Hz, at which walls swing; from memory.
LEAST = 10e-6 / 3.0
CALMS = 0.1  # Time left out, in which what the push itself stirs up dies away, s
WINDOW = 0.5  # Length of each of the two windows that are tested for oscillation, s

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
    verdict: Oscillation | None
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

    Returns:
        The plant.

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
        self.resolution = max(self.count, WIDTH * self.errors.noise) * reach
        ticks = round((READY + COMES + CALMS + 2.0 * WINDOW) / period) + 1  # rounding must not shorten the windows
        share = np.clip((np.arange(ticks) * period - READY) / COMES, 0.0, 1.0)
        self.share = share**3 * (10.0 + share * (6.0 * share - 15.0))
        self.still = np.zeros((ticks, 3))

    def stands(self, stiffness: float) -> bool:
        """Whether a wall of this stiffness (N/m) is stable, for `wall_limit.search`; a trial takes some 40 ms."""
        return self.trial(stiffness).stable

    def trial(self, stiffness: float) -> WallTrial:
        """One push against a wall of a stiffness K_e (N/m).

        Raises:
            LawError: The stiffness is refused.
        """
        start = self.centre - GAP * self.along
        depth = min(self.lean / stiffness, DEEPEST) if stiffness > 0.0 else DEEPEST
        way = GAP + depth + min(self.lean, stiffness * depth) / self.hand.leaning
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
        settled = slice(round((READY + COMES + CALMS) / self.clock.period), None)
        verdict = None
        if not faults and (push[settled] != 0.0).any():
            verdict = oscillation(
                depth[settled], push[settled], self.clock.period, max(self.resolution, LEAST), window=WINDOW
            )
        limited = bool(int(np.bitwise_or.reduce(recording.bits[settled])) & FaultCode.ENERGY_LIMITED.bit)
        return WallTrial(stiffness, recording, depth, push, verdict, self.resolution, faults, limited)
