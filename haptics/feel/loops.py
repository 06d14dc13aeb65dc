"""What the device renders in the loop on its board: walls, rates side by side, Z-width, impedance, noise, dynamics.

Each figure is one that the field uses; `DEFINITIONS` says what it means here and where that comes from. Importing this
module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from delta_cad.mechanism import jacobian
from haptics.control.wall_cap import WallCap
from haptics.feel.structure import Bandwidth, first_resonance, force_bandwidth
from haptics.model.hands import CORNERS, HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand
from haptics.rendering.laws.virtual_wall import AXES
from haptics.simulation.hardware import sensor_errors, wall_cap
from haptics.simulation.loops import BOARD, LoopChoice, RATES_Hz, at_rate
from haptics.stability.noise import BARELY, SPRING, NoiseFigures, NoiseRange, NoisyLoop, noise_range
from haptics.stability.port import impedance
from haptics.stability.wall_share import closed_form, proven_cap
from haptics.stability.wall_trial import WallBench
from haptics.stability.walls import NOBODY, SHARE, FourWalls, WallAt

DEFAULT_WALL = 5000.0  # N/m, which the board's loop is to bear at the centre with every hand
DAMPINGS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # of the K-B plane, N s/m
N_PER_MM = 1e-3  # N/m in N/mm
AXIS = "x"  # Along which K-B plane and impedance are drawn: the softest of the three at the centre

DEFINITIONS = {
    "own": "largest wall that is passive by the device's own damping, B = 0, its drives' at a wall among it, exact "
    "for the sampled loop (Colgate and Schenkel 1997, not opened: b > K T / 2 + B; terms for delay, filter, lag and "
    "what gives way are derived in `stability/port.py`)",
    "port": "largest wall whose averaged impedance at the handle takes energy at all frequencies, with B",
    "worst": "largest wall stable with every hand of the set, with the corners of their ranges, and with nobody",
    "nominal": "largest wall stable with the nominal hand",
    "rendered": f"what the tick lets through at a pose, by the arms' angles: {SHARE:g} of the formula with the least "
    "friction and the largest delay, damping held to what the joints' inertia bears, scaled where eigenvalues bear "
    "less (`stability/wall_share.py`); across the direction in which that is least",
    "met": "what is rendered and the structural stiffness one behind the other, K S / (K + S), the worst with the "
    "softest; the encoders sit behind the cable, which counts in S all the same: at least this",
    "z_width": "K-B plane: largest stiffness at a damping, by hand and rate, with the passive region (Colgate and "
    "Brown, as Chawda, Celik, O'Malley, Application of Levant's differentiator, tell it; first page opened)",
    "dynamic_range": "continuous force in every direction over friction in the worst, at one position (ratio of the "
    "largest to the smallest force, as A. Mohand-Ousaid et al., Haptic interface transparency achieved through viscous "
    "coupling, IJRR 2012, first page opened, tell it of Hayward and Astley 1996, not opened)",
    "acceleration": "of the free handle in every direction, by the peak torques beside the weight: the largest ball in "
    "the set of accelerations (the measure is Hayward and Astley's 1996, not opened)",
    "isotropy": "smallest over largest effective mass of all directions, at one position",
    "force_bandwidth": "force on a handle that is held still over the force commanded, with hold, current loop, cable "
    "and structure: up to where it keeps within 3 dB, and from where it has lost 3 dB for good; between them what "
    "gives way resonates",
    "current_loop": "corner of the current loop, 1 / (2 pi lag)",
    "first_resonance": "lowest mode at the centre with the motors held, in the model of these loops, whose structure "
    "is one spring as soft as the design asks for",
    "structural_stiffness": "force over way at the knob in the softest direction with the motors held, cable included, "
    "as the build computes it from its parts (`structure.json`)",
    "impedance": "force over velocity at the handle along the axis, the other directions free, averaged, let go and at "
    f"the wall that is rendered, of {N_PER_MM * DEFAULT_WALL:g} N/mm at most: at the cube's centre, in its floor's "
    "middle, and in the corner whose wall may have the least stiffness",
    "noise": "force that the encoders' noise commands and motion of the handle in 150 to 500 Hz, rms, by covariance, "
    "let go of; the range is over the structure, one to ten times as stiff as the design asks for, over what cable "
    "and structure damp, 1 to 5 % of critical, and over the normals x, y, z",
    "thresholds": "a wall is hard from 2 N/mm (L. B. Rosenberg, B. D. Adelstein 1993) and rigid from 15 N/mm (H. Z. "
    "Tan et al. 1994), fingertips feel steps of 0.04 N: all from memory, not opened; 0.05 um lies above the least "
    "thresholds of a grasped cylinder, 0.01 um of some subjects at 150 to 200 Hz (A. J. Brisben et al. 1999, abstract, "
    "as a study of this project tells it)",
}


@dataclass(frozen=True)
class PlaceImpedance:
    """Impedance at one place, along `AXIS`.

    Attributes:
        position: (3,) m.
        wall: Stiffness of the wall there, N/m.
        damping: Of it, N s/m.
        free: (m,) |Z| let go, N s/m.
        at_wall: (m,) |Z| at that wall, N s/m.
    """

    position: np.ndarray
    wall: float
    damping: float
    free: np.ndarray
    at_wall: np.ndarray


@dataclass(frozen=True)
class LoopSheet:
    """The device in its loop.

    Attributes:
        loop: The loop on the board.
        walls: Axis -> its four walls at the centre, hands with all corners of their ranges.
        rates: Rate (Hz) -> axis -> four walls at the centre.
        dampings: (n,) of the K-B plane, N s/m.
        z_width: Rate (Hz) -> hand -> (n,) largest stiffness at these, N/m.
        passive: (n,) the same of the averaged port at the board's rate, N/m.
        spring: Noise of the spring that is held, at the damping applied.
        spring_damping: Damping that noise allows beside that spring, N s/m.
        wall_noise: Noise in the default wall at the centre, the noisiest of hands and axes, the structure as soft as
            the design asks for.
        noise: Place -> the range of noise in the wall that is rendered there, of `DEFAULT_WALL` at most.
        noise_rad: Of one reading.
        standing: (axis, hand) -> whether the default wall stands in the simulation.
        frequency: (m,) Hz.
        impedances: Place -> impedance there.
        first_resonance: Hz.
        force_bandwidth: Along x at the centre, of the softest and the stiffest structure.
    """

    loop: LoopChoice
    walls: dict[str, FourWalls]
    rates: dict[float, dict[str, FourWalls]]
    dampings: tuple[float, ...]
    z_width: dict[float, dict[str, np.ndarray]]
    passive: np.ndarray
    spring: NoiseFigures
    spring_damping: float
    wall_noise: NoiseFigures
    noise: dict[str, NoiseRange]
    noise_rad: float
    standing: dict[tuple[str, str], bool]
    frequency: np.ndarray
    impedances: dict[str, PlaceImpedance]
    first_resonance: float
    force_bandwidth: tuple[Bandwidth, Bandwidth]

    @property
    def shaken(self) -> list[tuple[str, str]]:
        """Axis and hand with which the default wall does not stand."""
        return [case for case, stands in self.standing.items() if not stands]

    @property
    def worst(self) -> tuple[str, FourWalls]:
        """The axis whose wall with the worst hand is the softest, and its walls."""
        axis = min(self.walls, key=lambda name: self.walls[name].worst)
        return axis, self.walls[axis]


def loop_sheet(
    machine: MachineModel, loop: LoopChoice = BOARD, say: Callable[[str], None] = lambda _: None
) -> LoopSheet:
    """The device in its loop, at the cube's centre.

    Args:
        machine: The device.
        loop: The loop on its board.
        say: Called with the step that begins.
    """
    say("walls of the board's loop")
    everybody = {**HANDS, **CORNERS}
    walls = _rate(machine, loop, everybody)
    rates = {
        rate: walls if rate * loop.period == 1.0 else _rate(machine, at_rate(rate, loop), everybody)
        for rate in RATES_Hz
    }
    say("Z-width")
    z_width = {rate: _plane(machine, at_rate(rate, loop)) for rate in RATES_Hz}
    at = WallAt(machine, loop, normal=AXES[AXIS])
    handle = at.at_handle()
    passive = np.array([min(at.averaged(b, handle), at.stable(FREE, b)) for b in DAMPINGS])
    say("noise, and the default wall with each hand")
    spring = NoisyLoop(machine, loop)
    allowed = spring.damping_limit(SPRING[0])
    noisy = [
        NoisyLoop(machine, loop, hand=hand, normal=np.array(normal)).figures(DEFAULT_WALL, loop.damping)
        for hand in (BARELY, *HANDS.values())
        for normal in AXES.values()
    ]
    standing = {
        (axis, name): WallBench(machine, axis, hand, loop=loop).stands(DEFAULT_WALL)
        for axis in AXES
        for name, hand in HANDS.items()
    }
    cap, found = proven_cap(machine, loop), places(machine, loop)
    noise = {name: noise_range(machine, loop, p, rendered_walls(machine, cap, p)) for name, p in found.items()}
    say("impedance")
    return LoopSheet(
        loop=loop,
        walls=walls,
        rates=rates,
        dampings=DAMPINGS,
        z_width=z_width,
        passive=passive,
        spring=spring.figures(SPRING[0], min(SPRING[1], allowed)),
        spring_damping=allowed,
        wall_noise=NoiseFigures(
            max(one.force for one in noisy), max(one.motion for one in noisy), all(one.steady for one in noisy)
        ),
        noise=noise,
        noise_rad=sensor_errors(machine, loop).noise,
        standing=standing,
        frequency=handle.frequency / (2.0 * math.pi),
        impedances={name: impedance_at(machine, p, cap, loop) for name, p in found.items()},
        first_resonance=first_resonance(machine, loop),
        force_bandwidth=force_bandwidth(machine, np.array(AXES[AXIS]), loop),
    )


def _rate(machine: MachineModel, loop: LoopChoice, hands: Mapping[str, Hand]) -> dict[str, FourWalls]:
    return {name: WallAt(machine, loop, normal=normal).four(hands) for name, normal in AXES.items()}


def _plane(machine: MachineModel, loop: LoopChoice) -> dict[str, np.ndarray]:
    at = WallAt(machine, loop, normal=AXES[AXIS])
    hands = {NOBODY: FREE, **HANDS}
    return {name: np.array([at.stable(hand, b) for b in DAMPINGS]) for name, hand in hands.items()}


def places(machine: MachineModel, loop: LoopChoice = BOARD) -> dict[str, np.ndarray]:
    """Gives where impedance is told, (3,) m each: centre, floor's middle, and the corner of the softest wall."""
    half = machine.half_side
    corners = [machine.centre + half * np.array(signs) for signs in product((-1.0, 1.0), repeat=3)]
    cap = wall_cap(machine, loop)
    worst = min(corners, key=lambda p: closed_form(cap, jacobian(machine.geometry, p), np.array(AXES[AXIS]))[0])
    return {"centre": machine.centre, "floor's middle": machine.centre - [0.0, 0.0, half], "worst corner": worst}


def rendered_walls(machine: MachineModel, cap: WallCap, p: np.ndarray) -> list[tuple[np.ndarray, float, float]]:
    """Gives normal, stiffness and damping of the walls that are rendered at a place across x, y and z, of
    `DEFAULT_WALL` at most.
    """
    columns = jacobian(machine.geometry, p)
    walls = [(np.array(normal), *closed_form(cap, columns, np.array(normal))) for normal in AXES.values()]
    return [(normal, min(stiffness, DEFAULT_WALL), damping) for normal, stiffness, damping in walls]


def impedance_at(machine: MachineModel, p: np.ndarray, cap: WallCap, loop: LoopChoice = BOARD) -> PlaceImpedance:
    """Computes the impedance at a place, (3,) m, let go and at the wall that is rendered there."""
    touched = WallAt(machine, loop, p, AXES[AXIS])
    away = WallAt(machine, replace(loop, contact_damping=loop.drive_damping), p, AXES[AXIS])
    _, stiff, damping = rendered_walls(machine, cap, p)[list(AXES).index(AXIS)]
    cases = ((away, 0.0, 0.0), (touched, stiff, damping))
    free, wall = (impedance(at.at_handle(), at.estimator, k, b) for at, k, b in cases)
    return PlaceImpedance(p, stiff, damping, np.abs(free), np.abs(wall))
