"""What a device will feel like: figures over its cube, their summary, and three answers to a designer's questions.

Whether the handle stays where it is left, whether a wall is hard, whether it buzzes: each follows from the figures of
`field.feel_at` and the walls of `loop_sheet`, with the assumptions of `assumptions`. Importing this module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import jacobian
from haptics.feel.field import COMMAND_STEPS, Drive, feel_at
from haptics.feel.holds import Hold, holds
from haptics.feel.loops import DEFAULT_WALL, LoopLimits, LoopSheet, loop_sheet
from haptics.feel.summary import QUANTITIES, WALL, Summary, summarise
from haptics.loop.assumptions import encoder_count, joint_friction
from haptics.loop.hardware import real_plant
from haptics.loop.noise import FORCE, LEAST_FELT, MOTION
from haptics.loop.walls import rendered
from haptics.model.hands import CORNERS
from haptics.model.machine import MachineModel

# Points an edge of the cube for the summary, its corners, edges and faces among them; extremes are those of the points,
# nothing is proven between them.
GRID = 15
_SLICE = 41  # Points an edge of a map
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
_FELT = 0.04


@dataclass(frozen=True)
class _Answer:
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
        positions: (3 heights, SLICE y, SLICE x, 3) three planes of the cube, m.
        slices: Each of `QUANTITIES` by its name on these planes.
        rendered: Name of a loop -> the walls that it renders over the cube: the loop that is chosen, and the same with
            drives of the other kind.
        loop: The device in its loop.
        holds: How long forces may be held.
        answers: To a designer's questions.
    """

    machine: MachineModel
    drive: Drive
    summaries: dict[str, Summary]
    positions: np.ndarray
    slices: dict[str, np.ndarray]
    rendered: dict[str, Summary]
    loop: LoopSheet
    holds: tuple[Hold, ...]
    answers: tuple[_Answer, ...]


def joint_drive(machine: MachineModel) -> Drive:
    """What the joints of a device do, friction nominal.

    Both torques are those of the drive as far as the peak that the design asks for, at which the controller stops, lets
    them; the drive's own peak stands beside them.
    """
    drive, par = machine.drive, real_plant(machine)
    return Drive(
        continuous=min(drive.continuous_torque_N_m, drive.controlled_torque_N_m),
        peak=drive.controlled_torque_N_m,
        motor=drive.peak_torque_N_m,
        coulomb=joint_friction(machine).drive[1],
        count=encoder_count(machine),
        step=2.0 * drive.peak_torque_N_m / COMMAND_STEPS,
        ripple=par.ripple,
        cogging=par.cogging,
    )


def cube_points(machine: MachineModel, nx: int, ny: int, nz: int) -> np.ndarray:
    """(nz, ny, nx, 3) positions that fill the cube to its faces, m."""
    half = machine.half_side
    x, y, z = (np.linspace(-half, half, n) for n in (nx, ny, nz))
    up, across, along = np.meshgrid(z, y, x, indexing="ij")
    return np.stack([along, across, up], axis=-1) + machine.centre


def feel(
    machine: MachineModel,
    loops: Callable[[MachineModel], LoopSheet] = loop_sheet,
    say: Callable[[str], None] = lambda _: None,
) -> Feel:
    """All figures of a device.

    Args:
        machine: The device.
        loops: Function that computes the device in its loop.
        say: Called with the step that begins.

    Raises:
        UnreachableError: A point of the cube cannot be reached.
        SingularError: The forearms lie in one plane at one.
        ValueError: The loop bears no wall somewhere.
    """
    drive = joint_drive(machine)
    say("figures over the cube")
    cube, planes = cube_points(machine, GRID, GRID, GRID), cube_points(machine, _SLICE, _SLICE, 3)
    field, middle, slices = (feel_at(machine, drive, p) for p in (cube, machine.centre, planes))
    held, loop = holds(machine, drive, cube), loops(machine)

    def wall(one: LoopLimits, p: np.ndarray) -> np.ndarray:
        return rendered(one.cap, jacobian(machine.geometry, p))[0]

    over = {
        one.loop.name: summarise(WALL, float(wall(one, machine.centre)), wall(one, cube), cube)
        for one in (loop.walls, loop.other)
    }
    summaries = {
        quantity.name: over[loop.loop.name]
        if quantity is WALL
        else summarise(quantity, float(middle[quantity.name]), field[quantity.name], cube)
        for quantity in QUANTITIES
    }
    slices[WALL.name] = wall(loop.walls, planes)
    answers = (stays(machine, drive, summaries), hard(loop, over), buzzes(loop, summaries))
    return Feel(machine, drive, summaries, planes, slices, over, loop, held, answers)


def stays(machine: MachineModel, drive: Drive, summaries: dict[str, Summary]) -> _Answer:
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
    return _Answer("Will the handle stay where it is left?", good, short, text)


def hard(loop: LoopSheet, over: dict[str, Summary]) -> _Answer:
    """Compares the wall that is rendered everywhere with what passes for hard and for rigid, for both kinds of drives.

    Args:
        loop: The device in its loop.
        over: Name of a loop -> the walls that it renders over the cube.
    """
    text = []
    for one in (loop.walls, loop.other):
        axis, walls = one.worst
        wall = over[one.loop.name]
        limit = wall.worst[0]
        kind = "nobody tells it from rigid" if limit >= RIGID else "it feels hard" if limit >= HARD else "it feels soft"
        who = "a corner of the ranges" if walls.worst_hand in CORNERS else walls.worst_hand
        text.append(
            f"{one.loop.label}: the wall that is rendered has {limit / MM_PER_M:.1f} N/mm at the worst pose and "
            f"{wall.centre / MM_PER_M:.1f} at the centre: {kind}. Across {axis} at the centre it is stable up to "
            f"{walls.worst / MM_PER_M:.1f} N/mm with the worst of all hands ({who}) and {walls.nominal / MM_PER_M:.1f} "
            f"with the nominal one; passive up to {walls.passive / MM_PER_M:.1f}, by the device's own damping up to "
            f"{walls.own / MM_PER_M:.2f}."
        )
    good = over[loop.loop.name].worst[0] >= HARD
    short = f"{'Yes' if good else 'No'}, where {loop.loop.condition}."
    scale = f"Hard from about {HARD / MM_PER_M:.0f} N/mm, rigid from about {RIGID / MM_PER_M:.0f} N/mm."
    return _Answer("Is the wall hard?", good, short, " ".join([*text, scale]))


def buzzes(loop: LoopSheet, summaries: dict[str, Summary]) -> _Answer:
    """Asks whether the default wall stands with each hand and is quiet, here and all over the cube, whatever the
    structure, and whether a count is felt.
    """
    step, friction = DEFAULT_WALL * summaries["position_step"].worst[0], summaries["friction_min"].centre
    wall = f"A wall of {DEFAULT_WALL / MM_PER_M:g} N/mm at the centre "
    with_whom = ", ".join(f"{axis} with the {hand} hand" for axis, hand in loop.unstable_cases)
    wall += f"buzzes: {with_whom}" if loop.unstable_cases else "is steady with each hand of the set"
    steady = loop.wall_noise.steady and all(one.most.steady for one in loop.noise.values())
    loudest = max(loop.noise.values(), key=lambda one: one.most.motion)
    force = max((one.most.force for one in loop.noise.values()), default=math.inf)
    tremor, over = (steady and loudest.most.motion > most for most in (LEAST_FELT, MOTION))
    if steady:
        ranges = ", ".join(
            f"{1e6 * one.least.motion:.3f} to {1e6 * one.most.motion:.3f} um at the {name}"
            for name, one in loop.noise.items()
        )
        wall += (
            f". The encoders' noise commands at most {force:.3f} N rms in the walls that are rendered "
            f"({'within' if force <= FORCE else 'OVER'} the limit of {FORCE:g} N), and moves a "
            f"handle let go of in 150 to 500 Hz by {ranges}, rms, as stiff and as damped as its structure is"
        )
        bits = math.log2(2.0 * math.pi / min(one.reading for one in loop.noise.values()))
        loss = max(one.loss for one in loop.noise.values())
        damped = f", or a structure that damps {100.0 * loss:.0f} % of critical" if loss < math.inf else ""
        wall += (
            f": up to {loudest.most.over_threshold:.1f} times what the most sensitive subjects of a study felt, and "
            f"{'more' if over else 'less'} than the limit of {1e6 * MOTION:g} um"
        )
        if over:
            wall += f", which with this law readings would keep whose noise is a count of {bits:.1f} bits{damped}"
    if step < _FELT:
        grain = "too little to be felt"
    elif step < friction:
        grain = "which a fine fingertip may feel while moving"
    else:
        grain = "which is felt as grain"
    text = f"{wall}. One count of an encoder steps its force by up to {1e3 * step:.0f} mN, {grain} (from about "
    text += f"{1e3 * _FELT:.0f} mN on a still handle; friction is {friction:.2f} N)."
    good = not loop.unstable_cases and steady and force <= FORCE and step < friction
    short = "Yes." if not good else "Finely, for the most sensitive hands." if tremor else "No."
    return _Answer("Does it buzz?", good and not tremor, short, text)
