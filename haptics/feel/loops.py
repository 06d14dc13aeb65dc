"""The device in its sampled loop: walls with drives of both kinds, rates, Z-width, impedance, noise, dynamics.

Each figure is one that the field uses; `DEFINITIONS` says what it means here and where that comes from. Importing this
module loads numba.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism import jacobian
from haptics.control.wall_cap import WallCap
from haptics.loop.choice import BOARD, LoopChoice, RATES_Hz, at_rate, other_drives
from haptics.loop.discrete import continuous, loaded
from haptics.loop.hardware import LOSS, real_plant, sensor_errors, wall_cap
from haptics.loop.linear import linearise, structure_at
from haptics.loop.noise import BARELY, SPRING, NoiseFigures, NoiseRange, NoisyLoop, noise_range, shares
from haptics.loop.passivity import impedance
from haptics.loop.wall_trial import WallBench
from haptics.loop.walls import NOBODY, STABILITY_MARGIN, StiffnessLimits, WallStability, closed_form, proven_cap
from haptics.model.hands import CORNERS, HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand
from haptics.rendering.laws.virtual_wall import AXES

# What gives way as a person meets it: first resonance, and bandwidth of the force on a held handle.
_FIXED = 1e9  # N m/rad that hold a motor whose structure alone is to swing, and N/m that hold a handle
_LEVEL = 10.0 ** (3.0 / 20.0)  # 3 dB
_SWEEP_Hz = np.geomspace(1.0, 3000.0, 3000)


class _Bandwidth(NamedTuple):
    """Of the force on a held handle over the command, Hz.

    Attributes:
        within: Up to which it keeps within 3 dB.
        less: From which it has lost 3 dB for good.
    """

    within: float
    less: float


def first_resonance(machine: MachineModel) -> float:
    """Lowest mode at the centre with the motors held, as the walls' model has it, Hz."""
    here = linearise(real_plant(machine, BOARD), machine.centre, structure_at(machine, machine.centre))
    body, _ = here.body(FREE)
    motors = here.ports(np.eye(3), len(body.mass)).push.T @ np.eye(len(body.mass))
    held = loaded(body, motors, stiffness=_FIXED)
    roots = np.linalg.eigvals(continuous(held, np.zeros((len(body.mass), 1)))[0])
    return float(np.abs(roots.imag[np.abs(roots.imag) > 1.0]).min() / (2.0 * math.pi))


def held_force(
    machine: MachineModel, normal: np.ndarray, frequency: np.ndarray, loop: LoopChoice = BOARD, share: float = 1.0
) -> np.ndarray:
    """Force on a handle that is held still over the force commanded, at the cube's centre.

    Args:
        machine: The device.
        normal: (3,) direction of the force.
        frequency: (n,) Hz.
        loop: Whose hold and current loop stand between.
        share: Of the structure's stiffness.

    Returns:
        (n,) complex, dimensionless; without the delay, which turns its phase alone.
    """
    here = linearise(real_plant(machine, loop), machine.centre, structure_at(machine, machine.centre, LOSS[1], share))
    body, place = here.body(FREE)
    n = len(body.mass)
    rate, required = continuous(
        loaded(body, place, stiffness=_FIXED), here.ports(normal[:, None], n).push, loop.current_lag
    )
    s = 2j * math.pi * frequency[:, None, None] * np.eye(len(rate))
    moved = np.linalg.solve(s - rate, np.broadcast_to(required + 0j, (len(s), *required.shape)))
    return _FIXED * (normal @ place @ moved[:, :n, 0].T) * np.sinc(frequency * loop.period)


def force_bandwidth(
    machine: MachineModel, normal: np.ndarray, loop: LoopChoice = BOARD
) -> tuple[_Bandwidth, _Bandwidth]:
    """Bandwidth of the force on a held handle, with the softest and the stiffest structure of `shares`.

    Args:
        machine: The device.
        normal: (3,) direction of the force.
        loop: The loop.
    """
    found = []
    for share in (shares(machine)[0], shares(machine)[-1]):
        level = np.abs(held_force(machine, normal, _SWEEP_Hz, loop, share))
        off, less = np.flatnonzero(np.abs(np.log(level)) > math.log(_LEVEL)), np.flatnonzero(level >= 1.0 / _LEVEL)
        within = _SWEEP_Hz[off[0]] if len(off) else _SWEEP_Hz[-1]
        found.append(_Bandwidth(float(within), float(_SWEEP_Hz[less[-1]])))
    return found[0], found[1]


DEFAULT_WALL = 5000.0  # N/m, which the board loop is to bear at the centre with every hand
DAMPINGS = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)  # of the K-B plane, N s/m
N_PER_MM = 1e-3  # N/m in N/mm
_DRAWN = ("x", "z")  # Axes of the K-B planes and of impedance: across the device's axis, and along it
_CENTRE, _CORNER = "centre", "worst corner"

DEFINITIONS = {
    "own": "largest wall that is passive by the device's own damping, B = 0, its drives' at a wall included, exact "
    "for the sampled loop (Colgate and Schenkel 1997, not opened: b > K T / 2 + B; terms for delay, filter, lag and "
    "what gives way are derived in `loop/passivity.py`)",
    "passive": "largest wall that is passive with any passive hand, with the loop's wall damping B, likewise exact",
    "worst": "largest wall stable with every hand of the set, with the corners of their ranges, and with nobody",
    "nominal": "largest wall stable with the nominal hand",
    "rendered": f"what the tick lets through at a pose, by the arms' angles: {STABILITY_MARGIN:g} of the formula with "
    "the least friction and the largest delay, damping held to what the joints' inertia bears, scaled where "
    "eigenvalues bear less (`loop/walls.py`); across the direction in which that is least",
    "met": "what is rendered and the structural stiffness in series, K S / (K + S), the worst with the softest; the "
    "encoders sit behind the cable, which counts in S all the same: at least this",
    "z_width": "K-B plane: largest stable stiffness at a damping, by hand and rate, with the passive region, and the "
    "range of impedance from the free handle's to that at the stiffest wall rendered (Colgate and Brown, as Chawda, "
    "Celik, O'Malley, Application of Levant's differentiator, tell it; first page opened)",
    "quantum": "a wall up to 2 f_c / quantum has no limit cycle of its encoder's counts: Coulomb friction of a joint "
    "over its count, the least friction over the cube at the largest way for one count (N. Diolaiti et al., IEEE "
    "Trans. Robotics 22(2), 2006; J. J. Abbott, A. M. Okamura, IEEE Trans. Robotics 21(5), 2005; not opened)",
    "dynamic_range": "continuous force in every direction over friction in the worst, at one position (ratio of the "
    "largest to the smallest force, as A. Mohand-Ousaid et al., Haptic interface transparency achieved through viscous "
    "coupling, IJRR 2012, first page opened, tell it of Hayward and Astley 1996, not opened)",
    "acceleration": "of the free handle in every direction, by the peak torques beside the weight: the largest ball in "
    "the set of accelerations (the measure is Hayward and Astley's 1996, not opened)",
    "isotropy": "smallest over largest effective mass of all directions, at one position",
    "ripple": "largest deviation of the force at the handle by the motors' torque ripple and cogging, the three in "
    "phase, in the worst direction",
    "force_bandwidth": "force on a handle that is held still over the force commanded, with hold, current loop, cable "
    "and structure: up to where it keeps within 3 dB, and from where it has lost 3 dB for good; between them what "
    "gives way resonates",
    "current_loop": "corner of the current loop, 1 / (2 pi lag)",
    "first_resonance": "lowest mode at the centre with the motors held, nobody at the handle",
    "structural_stiffness": "force over way at the knob in the softest direction with the motors held, cable included, "
    "as the build computes it from its parts (`structure.json`)",
    "impedance": "force over velocity at the handle along the axis, the other directions free, averaged: of the free "
    "handle, which bounds Z-width from below, and at the stiffest wall that is rendered there",
    "noise": "force that the encoders' noise commands and motion of the handle in 150 to 500 Hz, rms, by covariance, "
    f"let go of, in the wall that is rendered, of {N_PER_MM * DEFAULT_WALL:g} N/mm at most, across x, y and z; the "
    "range is over the structure (as built, a fifth softer to a fifth stiffer; without a build one to ten times as "
    "stiff as the design requires) and over what cable and structure damp, 1 to 5 % of critical",
    "thresholds": "a wall is hard from 2 N/mm (L. B. Rosenberg, B. D. Adelstein 1993) and rigid from 15 N/mm (H. Z. "
    "Tan et al. 1994), fingertips feel steps of 0.04 N: all from memory, not opened; the most "
    "sensitive of 19 subjects detected a sine of 0.01 um at 150 to 200 Hz through a grasped cylinder (A. J. Brisben et "
    "al. 1999, abstract); 0.05 um rms is a limit of this project, which no source calls unfelt",
}


@dataclass(frozen=True)
class LoopLimits:
    """Walls of a device in one loop.

    Attributes:
        loop: The loop.
        axes: Axis -> its four walls at the centre, hands with all corners of their ranges.
        cap: What its tick renders.
    """

    loop: LoopChoice
    axes: dict[str, StiffnessLimits]
    cap: WallCap

    @property
    def worst(self) -> tuple[str, StiffnessLimits]:
        """The axis whose wall with the worst hand is the softest, and its walls."""
        axis = min(self.axes, key=lambda name: self.axes[name].worst)
        return axis, self.axes[axis]


@dataclass(frozen=True)
class Plane:
    """Z-width along an axis at a place: the K-B plane and the range of impedance.

    Attributes:
        stable: Rate (Hz) -> hand -> (n,) largest stable stiffness at `DAMPINGS`, N/m.
        passive: (n,) the same that is passive with any passive hand, of the loop itself, N/m.
        passive_other: (n,) likewise with drives of the other kind.
        position: (3,) m.
        wall: Stiffness of the stiffest wall that is rendered there, N/m.
        damping: Of it, N s/m.
        lower: (m,) |Z| of the free handle, N s/m.
        upper: (m,) |Z| at that wall, N s/m.
    """

    stable: dict[float, dict[str, np.ndarray]]
    passive: np.ndarray
    passive_other: np.ndarray
    position: np.ndarray
    wall: float
    damping: float
    lower: np.ndarray
    upper: np.ndarray


@dataclass(frozen=True)
class LoopSheet:
    """The device in its loop.

    Attributes:
        walls: Walls of the loop that is chosen.
        other: Walls with drives of the other kind: that damp, where those of the loop do not.
        rates: Rate (Hz) -> axis -> four walls at the centre, of the loop that is chosen.
        dampings: (n,) of the K-B plane, N s/m.
        z_width: (place, axis) -> K-B plane and impedance there.
        frequency: (m,) Hz, of the impedances.
        spring: Noise of the spring that is held, at the damping applied.
        spring_damping: Damping that noise allows together with that spring, N s/m.
        wall_noise: Noise in the default wall at the centre, the noisiest of hands and axes.
        noise: Place -> the range of noise in the wall that is rendered there, of `DEFAULT_WALL` at most.
        noise_rad: Of one reading.
        default_wall_stable: (axis, hand) -> whether the default wall stands in the simulation.
        first_resonance: As built where that is known, else with the structure that the design requires, Hz.
        force_bandwidth: Along x at the centre, of the softest and the stiffest structure.
    """

    walls: LoopLimits
    other: LoopLimits
    rates: dict[float, dict[str, StiffnessLimits]]
    dampings: tuple[float, ...]
    z_width: dict[tuple[str, str], Plane]
    frequency: np.ndarray
    spring: NoiseFigures
    spring_damping: float
    wall_noise: NoiseFigures
    noise: dict[str, NoiseRange]
    noise_rad: float
    default_wall_stable: dict[tuple[str, str], bool]
    first_resonance: float
    force_bandwidth: tuple[_Bandwidth, _Bandwidth]

    @property
    def loop(self) -> LoopChoice:
        """The loop that is chosen."""
        return self.walls.loop

    @property
    def unstable_cases(self) -> list[tuple[str, str]]:
        """Axis and hand with which the default wall does not stand."""
        return [case for case, stands in self.default_wall_stable.items() if not stands]


def loop_sheet(
    machine: MachineModel, loop: LoopChoice = BOARD, say: Callable[[str], None] = lambda _: None
) -> LoopSheet:
    """The device in its loop.

    Args:
        machine: The device.
        loop: The loop of its controller.
        say: Called with the step that begins.

    Raises:
        ValueError: The loop, or the same with drives of the other kind, bears no wall somewhere.
    """
    say("walls of the loop")
    everybody = {**HANDS, **CORNERS}
    walls, other = (
        LoopLimits(one, _rate(machine, one, everybody), proven_cap(machine, one)) for one in (loop, other_drives(loop))
    )
    rates = {
        rate: walls.axes if rate * loop.period == 1.0 else _rate(machine, at_rate(rate, loop), everybody)
        for rate in RATES_Hz
    }
    say("Z-width")
    found = places(machine, loop)
    z_width = {
        (name, axis): plane(machine, walls, other.loop, found[name], axis)
        for name, axis in product((_CENTRE, _CORNER), _DRAWN)
    }
    say("noise, and the default wall with each hand")
    spring = NoisyLoop(machine, loop)
    allowed = spring.damping_limit(SPRING[0])
    noisy = [
        NoisyLoop(machine, loop, hand=hand, normal=np.array(normal)).figures(DEFAULT_WALL, loop.damping)
        for hand in (BARELY, *HANDS.values())
        for normal in AXES.values()
    ]
    default_wall_stable = {
        (axis, name): WallBench(machine, axis, hand, loop=loop).stands(DEFAULT_WALL)
        for axis in AXES
        for name, hand in HANDS.items()
    }
    return LoopSheet(
        walls=walls,
        other=other,
        rates=rates,
        dampings=DAMPINGS,
        z_width=z_width,
        frequency=WallStability(machine, loop).at_handle().frequency / (2.0 * math.pi),
        spring=spring.figures(SPRING[0], min(SPRING[1], allowed)),
        spring_damping=allowed,
        wall_noise=NoiseFigures(
            max(one.force for one in noisy), max(one.motion for one in noisy), all(one.steady for one in noisy)
        ),
        noise={name: noise_range(machine, loop, p, noisy_walls(machine, walls.cap, p)) for name, p in found.items()},
        noise_rad=sensor_errors(machine, loop).noise,
        default_wall_stable=default_wall_stable,
        first_resonance=first_resonance(machine) if machine.structure is None else machine.structure.mode,
        force_bandwidth=force_bandwidth(machine, np.array(AXES["x"]), loop),
    )


def _rate(machine: MachineModel, loop: LoopChoice, hands: Mapping[str, Hand]) -> dict[str, StiffnessLimits]:
    return {name: WallStability(machine, loop, normal=normal).walls(hands) for name, normal in AXES.items()}


def plane(machine: MachineModel, walls: LoopLimits, other: LoopChoice, p: np.ndarray, axis: str) -> Plane:
    """Computes Z-width along an axis at a place.

    Args:
        machine: The device.
        walls: Its loop and what that renders.
        other: The same loop with drives of the other kind.
        p: (3,) m.
        axis: "x", "y" or "z".
    """
    loop, normal = walls.loop, AXES[axis]
    stable = {}
    for rate in RATES_Hz:
        at = WallStability(machine, at_rate(rate, loop), p, normal)
        stable[rate] = {
            name: np.array([at.stable(hand, b) for b in DAMPINGS]) for name, hand in {NOBODY: FREE, **HANDS}.items()
        }
    touched, away = WallStability(machine, loop, p, normal), WallStability(machine, loop.untouched, p, normal)
    stiff, damping = closed_form(walls.cap, touched.here.jacobian, np.array(normal))
    cases = ((away, 0.0, 0.0), (touched, stiff, damping))
    lower, upper = (np.abs(impedance(at.at_handle(), at.estimator, k, b)) for at, k, b in cases)
    own, others = (
        np.array([at.passive(b, handle) for b in DAMPINGS])
        for at in (touched, WallStability(machine, other, p, normal))
        for handle in (at.at_handle(),)
    )
    return Plane(stable, own, others, p, stiff, damping, lower, upper)


def places(machine: MachineModel, loop: LoopChoice = BOARD) -> dict[str, np.ndarray]:
    """Gives where noise is computed, (3,) m each: centre, floor's middle, and the corner of the softest wall."""
    half = machine.half_side
    corners = [machine.centre + half * np.array(signs) for signs in product((-1.0, 1.0), repeat=3)]
    cap = wall_cap(machine, loop)
    worst = min(corners, key=lambda p: closed_form(cap, jacobian(machine.geometry, p), np.array(AXES["x"]))[0])
    return {_CENTRE: machine.centre, "floor's middle": machine.centre - [0.0, 0.0, half], _CORNER: worst}


def noisy_walls(machine: MachineModel, cap: WallCap, p: np.ndarray) -> list[tuple[np.ndarray, float, float]]:
    """Gives normal, stiffness and damping of the walls that are rendered at a place across x, y and z, of
    `DEFAULT_WALL` at most.
    """
    columns = jacobian(machine.geometry, p)
    walls = [(np.array(normal), *closed_form(cap, columns, np.array(normal))) for normal in AXES.values()]
    return [(normal, min(stiffness, DEFAULT_WALL), damping) for normal, stiffness, damping in walls]
