"""What the device renders in the loop on its board: walls, rates side by side, Z-width, impedance, noise, dynamics.

Each figure is one that the field uses; `DEFINITIONS` says what it means here and where that comes from. Importing this
module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from haptics.model.hands import CORNERS, HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.rendering.laws.virtual_wall import AXES
from haptics.simulation.hardware import sensor_errors
from haptics.simulation.loops import BOARD, LoopChoice, RATES_Hz, at_rate
from haptics.stability.bodies import continuous, loaded
from haptics.stability.noise import SPRING, NoiseFigures, NoisyLoop
from haptics.stability.port import impedance
from haptics.stability.wall_trial import WallBench
from haptics.stability.walls import NOBODY, SHARE, FourWalls, WallAt, computed_wall

DEFAULT_WALL = 5000.0  # N/m, which the board's loop is to bear at the centre with every hand
DAMPINGS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # of the K-B plane, N s/m
N_PER_MM = 1e-3  # N/m in N/mm
AXIS = "x"  # Along which K-B plane and impedance are drawn: the softest of the three at the centre
FIXED = 1e9  # N m/rad that hold a motor whose structure alone is to swing

DEFINITIONS = {
    "own": "largest wall that is passive by the device's own damping, B = 0, exact for the sampled loop (Colgate and "
    "Schenkel 1997, not opened: b > K T / 2 + B; terms for delay, filter, lag and what gives way are derived in "
    "`stability/port.py`)",
    "port": "largest wall whose averaged impedance at the handle takes energy at all frequencies, with B",
    "worst": "largest wall stable with every hand of the set, with the corners of their ranges, and with nobody",
    "nominal": "largest wall stable with the nominal hand",
    "allowed": f"what is rendered: {SHARE:g} of the largest wall that is stable let go of with the least friction and "
    "the largest delay, at its pose",
    "z_width": "K-B plane: largest stiffness at a damping, by hand and rate, with the passive region (Colgate and "
    "Brown, as Chawda, Celik, O'Malley, Application of Levant's differentiator, tell it; first page opened)",
    "dynamic_range": "continuous force in every direction over friction in the worst, worst of the cube (Hayward and "
    "Astley 1996, unverified)",
    "peak_acceleration": "peak force in every direction over the largest effective mass, worst of the cube (Hayward "
    "and Astley 1996, unverified)",
    "isotropy": "smallest over largest effective mass of all directions",
    "force_bandwidth": "corner of the current loop, 1 / (2 pi lag)",
    "first_resonance": "lowest mode with the motors held, the structure lumped as one spring of the stiffness that the "
    "design asks for: a lower bound",
    "impedance": "force over velocity at the handle along the axis, the other directions free, averaged, let go and at "
    f"the wall that is rendered, of {N_PER_MM * DEFAULT_WALL:g} N/mm at most: at the cube's centre, in its floor's "
    "middle, and in the corner whose wall may have the least stiffness",
    "noise": "force that the encoders' noise commands and motion of the handle in 150 to 500 Hz, rms, by covariance",
}


@dataclass(frozen=True)
class PlaceImpedance:
    """Impedance at one place, along `AXIS`.

    Attributes:
        position: (3,) m.
        wall: Stiffness of the wall there, N/m.
        free: (m,) |Z| let go, N s/m.
        at_wall: (m,) |Z| at that wall, N s/m.
    """

    position: np.ndarray
    wall: float
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
        wall_noise: Noise in the default wall, the noisiest of hands and axes.
        noise_rad: Of one reading.
        standing: (axis, hand) -> whether the default wall stands in the simulation.
        frequency: (m,) Hz.
        impedances: Place -> impedance there.
        first_resonance: Hz.
        force_bandwidth: Hz.
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
    noise_rad: float
    standing: dict[tuple[str, str], bool]
    frequency: np.ndarray
    impedances: dict[str, PlaceImpedance]
    first_resonance: float
    force_bandwidth: float

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
    walls = {name: WallAt(machine, loop, normal=normal).four(everybody) for name, normal in AXES.items()}
    rates = {rate: _rate(machine, at_rate(rate, loop)) for rate in RATES_Hz}
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
        for hand in HANDS.values()
        for normal in AXES.values()
    ]
    standing = {
        (axis, name): WallBench(machine, axis, hand, loop=loop).stands(DEFAULT_WALL)
        for axis in AXES
        for name, hand in HANDS.items()
    }
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
        wall_noise=max(noisy, key=lambda one: one.force),
        noise_rad=sensor_errors(machine).noise,
        standing=standing,
        frequency=handle.frequency / (2.0 * math.pi),
        impedances={name: impedance_at(machine, p, loop) for name, p in places(machine, loop).items()},
        first_resonance=first_resonance(machine, loop),
        force_bandwidth=1.0 / (2.0 * math.pi * loop.current_lag),
    )


def _rate(machine: MachineModel, loop: LoopChoice) -> dict[str, FourWalls]:
    return {name: WallAt(machine, loop, normal=normal).four() for name, normal in AXES.items()}


def _plane(machine: MachineModel, loop: LoopChoice) -> dict[str, np.ndarray]:
    at = WallAt(machine, loop, normal=AXES[AXIS])
    hands = {NOBODY: FREE, **HANDS}
    return {name: np.array([at.stable(hand, b) for b in DAMPINGS]) for name, hand in hands.items()}


def places(machine: MachineModel, loop: LoopChoice = BOARD) -> dict[str, np.ndarray]:
    """Gives where impedance is told, (3,) m each: centre, floor's middle, and the corner of the softest wall."""
    half = machine.half_side
    corners = [machine.centre + half * np.array(signs) for signs in product((-1.0, 1.0), repeat=3)]
    worst = min(corners, key=lambda p: computed_wall(machine, p, AXES[AXIS], loop))
    return {"centre": machine.centre, "floor's middle": machine.centre - [0.0, 0.0, half], "worst corner": worst}


def impedance_at(machine: MachineModel, p: np.ndarray, loop: LoopChoice = BOARD) -> PlaceImpedance:
    """Computes the impedance at a place, (3,) m, let go and at the wall that is rendered there."""
    at = WallAt(machine, loop, p, AXES[AXIS])
    handle, stiff = at.at_handle(), min(SHARE * computed_wall(machine, p, AXES[AXIS], loop), DEFAULT_WALL)
    free, wall = (impedance(handle, at.estimator, k, b) for k, b in ((0.0, 0.0), (stiff, loop.damping)))
    return PlaceImpedance(p, stiff, np.abs(free), np.abs(wall))


def first_resonance(machine: MachineModel, loop: LoopChoice = BOARD) -> float:
    """Lowest mode at the centre with the motors held, Hz."""
    here = WallAt(machine, replace(loop, drive_damping=0.0)).here
    body, _ = here.body(FREE)
    motors = here.ports(np.eye(3), len(body.mass)).push.T @ np.eye(len(body.mass))
    held = loaded(body, motors, stiffness=FIXED)
    roots = np.linalg.eigvals(continuous(held, np.zeros((len(body.mass), 1)))[0])
    return float(np.abs(roots.imag[np.abs(roots.imag) > 1.0]).min() / (2.0 * math.pi))
