"""What a device will feel like: figures over its cube, their summary, and three answers to a designer's questions.

Whether the handle stays where it is left, whether a wall is hard, whether it buzzes: each follows from the figures of
`feel_field` and the walls of `stiffness`, with the assumptions of `assumptions`. Importing this module loads numba.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from haptics.feel.field import COMMAND_STEPS, Drive, FeelField, feel_at
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.rendering.laws.virtual_wall import AXES
from haptics.simulation.assumptions import (
    CURRENT_LAG,
    DELAY,
    default_estimator,
    encoder_count,
    joint_friction,
    nominal_plant,
)
from haptics.stability.discrete import Timing
from haptics.stability.estimator_models import linear_models
from haptics.stability.linear import linearise
from haptics.stability.stiffness import NOMINAL_HAND, Stiffness, largest_walls
from haptics.stability.wall_limit import START
from haptics.stability.wall_trial import PERIOD

# Points an edge of the cube for the summary, its corners, edges and faces among them; extremes are those of the points,
# nothing is proven between them.
GRID = 15
SLICE = 41  # Points an edge of a map
# Points of the map of the linear wall limit along x, y, z: it varies by 3 % over that of the committed design.
WALL_GRID = (5, 5, 3)
# Share by which the masses of the gravity compensation may be off: screws, cables and density of what is built.
MASS_ERROR = 0.05
# N/m from which a wall passes for hard: L. B. Rosenberg, B. D. Adelstein, IEEE Symposium on Research Frontiers in
# Virtual Reality, 1993; from memory, not opened.
HARD = 2000.0
# N/m from which a wall passes for rigid: 15 to 42 N/mm, H. Z. Tan et al., ASME IMECE DSC 55-1, 1994; from memory, not
# opened.
RIGID = 15e3
# N: smallest step of a force that fingertips feel on a still handle, about; from memory (detection thresholds of 0.03
# to 0.06 N), no single source was opened.
FELT = 0.04


@dataclass(frozen=True)
class Quantity:
    """A figure of the sheet: its name, unit and what is better.

    Attributes:
        name: In `FeelField.named`, or "wall".
        label: Text for a person.
        unit: Unit that a person sees.
        factor: From SI to that unit.
        digits: Decimals after the point.
        small: Whether less is better.
    """

    name: str
    label: str
    unit: str
    factor: float
    digits: int
    small: bool

    @property
    def key(self) -> str:
        """Name of the figure with its unit, for files."""
        return f"{self.name}_{self.unit.replace(' ', '_').replace('/', '_per_')}"


QUANTITIES = (
    Quantity("mass_max", "effective mass, heaviest direction", "g", 1e3, 0, True),
    Quantity("mass_min", "effective mass, lightest direction", "g", 1e3, 0, True),
    Quantity("mass_x", "effective mass along x", "g", 1e3, 0, True),
    Quantity("mass_y", "effective mass along y", "g", 1e3, 0, True),
    Quantity("mass_z", "effective mass along z", "g", 1e3, 0, True),
    Quantity("friction_max", "friction at the handle, worst direction", "N", 1.0, 2, True),
    Quantity("friction_min", "friction at the handle, best direction", "N", 1.0, 2, True),
    Quantity("force_step", "force step of the command", "mN", 1e3, 0, True),
    Quantity("position_step", "handle's way for one count", "um", 1e6, 0, True),
    Quantity("force_continuous", "force in every direction, continuous", "N", 1.0, 1, False),
    Quantity("force_peak", "force in every direction, peak", "N", 1.0, 1, False),
    Quantity("force_motor", "force in every direction, motor's own limit", "N", 1.0, 1, False),
    Quantity("force_peak_best", "force in the best direction, peak", "N", 1.0, 1, False),
    Quantity("wall", "largest stable wall, linear, worst axis", "N/mm", 1e-3, 1, False),
    Quantity("gravity", "gravity torque, largest joint", "mN m", 1e3, 0, True),
)


@dataclass(frozen=True)
class Summary:
    """A figure over the cube, SI.

    Attributes:
        quantity: The quantity.
        centre: In the cube's centre.
        best: The best value, and its position (3,), m.
        worst: The worst value, and its position (3,), m.
    """

    quantity: Quantity
    centre: float
    best: tuple[float, np.ndarray]
    worst: tuple[float, np.ndarray]


@dataclass(frozen=True)
class Answer:
    """One of a designer's questions.

    Attributes:
        question: The question.
        good: Whether the answer is the one that is hoped for.
        short: Yes or no.
        text: The answer with its figures.
    """

    question: str
    good: bool
    short: str
    text: str


@dataclass(frozen=True)
class Feel:
    """What a device will feel like.

    Attributes:
        machine: The device.
        drive: What its joints do.
        summaries: By name, one for each of `QUANTITIES`.
        slices: Figures on three planes of the cube, (3 heights, SLICE y, SLICE x).
        walls: Linear wall limits, N/m, at `wall_positions` (nz, ny, nx, 3).
        wall_positions: m.
        stiffness: The simulated and linear walls at the centre.
        answers: To a designer's questions.
    """

    machine: MachineModel
    drive: Drive
    summaries: dict[str, Summary]
    slices: FeelField
    walls: np.ndarray
    wall_positions: np.ndarray
    stiffness: Stiffness
    answers: tuple[Answer, ...]


def joint_drive(machine: MachineModel) -> Drive:
    """What the joints of a device do, friction nominal.

    Both torques are those of the drive as far as the peak that the design asks for, at which the controller stops, lets
    them; the drive's own peak stands beside them.
    """
    drive = machine.drive
    return Drive(
        continuous=min(drive.continuous_torque_N_m, drive.controlled_torque_N_m),
        peak=drive.controlled_torque_N_m,
        motor=drive.peak_torque_N_m,
        coulomb=joint_friction(machine).drive[1],
        count=encoder_count(machine),
        step=2.0 * drive.peak_torque_N_m / COMMAND_STEPS,
    )


def cube_points(machine: MachineModel, nx: int, ny: int, nz: int) -> np.ndarray:
    """(nz, ny, nx, 3) positions that fill the cube to its faces, m."""
    half = machine.half_side
    x, y, z = (np.linspace(-half, half, n) for n in (nx, ny, nz))
    up, across, along = np.meshgrid(z, y, x, indexing="ij")
    return np.stack([along, across, up], axis=-1) + machine.centre


def linear_wall(machine: MachineModel, p: np.ndarray) -> float:
    """Smallest linear limit of walls across x, y and z at a position, N/m, in the nominal case without damping."""
    here = linearise(nominal_plant(machine), p)
    (model, *_) = linear_models(default_estimator(PERIOD))  # of no effect without damping
    timing = Timing(PERIOD, DELAY[1] * PERIOD, CURRENT_LAG)
    return min(
        here.joint_loop(normal, HANDS[NOMINAL_HAND], timing, model).stiffness_limit().value for normal in AXES.values()
    )


def feel(
    machine: MachineModel,
    *,
    walls: Callable[[MachineModel], Stiffness] = largest_walls,
    say: Callable[[str], None] = lambda _: None,
) -> Feel:
    """All figures of a device.

    Args:
        machine: The device.
        walls: Function that finds its largest walls.
        say: Called with the step that begins.

    Returns:
        The figures.

    Raises:
        UnreachableError: A point of the cube cannot be reached.
        SingularError: The forearms lie in one plane at one.
    """
    drive = joint_drive(machine)
    say("figures over the cube")
    field = feel_at(machine, drive, cube_points(machine, GRID, GRID, GRID))
    middle = feel_at(machine, drive, machine.centre)
    slices = feel_at(machine, drive, cube_points(machine, SLICE, SLICE, 3))
    say("linear walls over the cube")
    positions = cube_points(machine, *WALL_GRID)
    limits = np.array([linear_wall(machine, p) for p in positions.reshape(-1, 3)]).reshape(positions.shape[:-1])
    say("largest walls")
    stiffness = walls(machine)
    summaries: dict[str, Summary] = {}
    for quantity in QUANTITIES:
        if quantity.name == "wall":
            summaries["wall"] = summarise(quantity, linear_wall(machine, machine.centre), limits, positions)
        else:
            value = float(middle.named()[quantity.name])
            summaries[quantity.name] = summarise(quantity, value, field.named()[quantity.name], field.position)
    answers = (stays(machine, drive, summaries), hard(stiffness), buzzes(stiffness, summaries))
    return Feel(machine, drive, summaries, slices, limits, positions, stiffness, answers)


def summarise(quantity: Quantity, middle: float, values: np.ndarray, positions: np.ndarray) -> Summary:
    """Best and worst value of a quantity with their positions.

    Args:
        quantity: The quantity.
        middle: Value in the centre.
        values: (...) SI.
        positions: (..., 3) m.
    """
    flat, places = values.reshape(-1), positions.reshape(-1, 3)
    least, most = int(np.argmin(flat)), int(np.argmax(flat))
    best, worst = (least, most) if quantity.small else (most, least)
    return Summary(quantity, middle, (float(flat[best]), places[best]), (float(flat[worst]), places[worst]))


def stays(machine: MachineModel, drive: Drive, summaries: dict[str, Summary]) -> Answer:
    """Compares each joint's friction with what its compensation misses of the weight, so that the handle stays where it
    is left: at rest all three torques can be held if and only if none exceeds its friction.
    """
    least = joint_friction(machine).drive[0]
    gravity = summaries["gravity"].worst[0]
    missed = MASS_ERROR * gravity
    good = missed <= least
    text = (
        f"With masses {100.0 * MASS_ERROR:.0f} % off, the gravity compensation misses up to {1e3 * missed:.1f} mN m of "
        f"{1e3 * gravity:.0f} mN m at a joint; friction holds {1e3 * least:.1f} mN m at least and "
        f"{1e3 * drive.coulomb:.1f} mN m nominally, so that the handle "
        + ("stays" if good else "stays where friction is nominal" if missed <= drive.coulomb else "creeps away")
        + f". It stays all over the cube up to masses {100.0 * least / gravity:.0f} % off with the least friction, "
        f"{100.0 * drive.coulomb / gravity:.0f} % with the nominal one."
    )
    short = "Yes." if good else "Unless friction is at its least." if missed <= drive.coulomb else "No."
    return Answer("Will the handle stay where it is left?", good, short, text)


def hard(stiffness: Stiffness) -> Answer:
    """Compares the largest stable wall with what passes for hard and for rigid."""
    wall = min(stiffness.axes, key=lambda axis: axis.nominal.bisection)
    limit = wall.nominal.bisection
    low = min((axis.simulated.lowest for axis in stiffness.axes), key=lambda end: end.stiffness)
    high = max((axis.simulated.highest for axis in stiffness.axes), key=lambda end: end.stiffness)
    kind = "nobody tells it from rigid" if limit >= RIGID else "it feels hard" if limit >= HARD else "it feels soft"
    text = (
        f"The stiffest stable wall across {wall.axis}, the worst axis, has {limit / MM_PER_M:.1f} N/mm "
        f"({wall.corner}): {kind} (hard from "
        f"about {HARD / MM_PER_M:.0f} N/mm, rigid from about {RIGID / MM_PER_M:.0f} N/mm). It depends on who holds it: "
        f"{low.stiffness / MM_PER_M:.2f} N/mm ({low.corner}) to {high.stiffness / MM_PER_M:.0f} N/mm ({high.corner})."
    )
    return Answer("Is the wall hard?", limit >= HARD, "Yes." if limit >= HARD else "No.", text)


def buzzes(stiffness: Stiffness, summaries: dict[str, Summary]) -> Answer:
    """Compares the walls with the default one, and the force step of a count with what is felt."""
    step, friction = START * summaries["position_step"].worst[0], summaries["friction_min"].centre
    shaken = stiffness.shaken
    with_whom = ", ".join(f"{axis} with the {hand} hand" for axis, hand in shaken)
    low = min((axis.simulated.lowest for axis in stiffness.axes), key=lambda end: end.stiffness)
    wall = f"A wall of {START / MM_PER_M:g} N/mm "
    wall += f"buzzes: {with_whom}" if shaken else "is steady with each hand of the set, friction and delay nominal"
    if low.stiffness < START:
        wall += f"; in the worst case ({low.corner}) any wall above {low.stiffness / MM_PER_M:.2f} N/mm may swing"
    if step < FELT:
        grain = "too little to be felt"
    elif step < friction:
        grain = "which a fine fingertip may feel while moving"
    else:
        grain = "which is felt as grain"
    text = f"{wall}. One count of an encoder steps its force by up to {1e3 * step:.0f} mN, {grain} (from about "
    text += f"{1e3 * FELT:.0f} mN on a still handle; friction is {friction:.2f} N)."
    short = "Yes." if shaken else "Not with nominal friction and delay." if low.stiffness < START else "No."
    return Answer("Does it buzz?", not shaken and step < friction, short, text)
