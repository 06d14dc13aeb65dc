"""What the noise of the encoders does to a rendered spring or wall: force and motion, exact for the sampled linear
loop.

Readings err by normal numbers of one deviation, of which the encoder's filter keeps a share until the next. With the
state's transition A and what an error adds, G, errors among the state, the covariance X of the state solves
`X = A X A^T + G R G^T` (Lyapunov), that of the command follows, and at a frequency w the handle moves by
`L (e^(jwT) - A)^-1 G` for each unit of error. Left out: counts (a twelfth of their
square is their variance, where noise is wider than they are), friction that sticks, which holds the joints of a resting
handle but not the knob that rings on its structure: simulated, that moves within a quarter of what is told.

Source:
    Of 19 subjects who grasped a cylinder, some detected a sine of less than 0.01 um at 150 to 200 Hz, where thresholds
    are lowest: A. J. Brisben, S. S. Hsiao, K. O. Johnson, J. Neurophysiology 81, 1999 (abstract opened on 2026-11-27;
    it does not say whether peak or rms, nor what most subjects detected).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import matrix_balance, solve_discrete_lyapunov

from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import BOARD, LoopChoice
from haptics.loop.discrete import SampledLoop, bisect, sampled_loop
from haptics.loop.hardware import BUILT_SHARES, LOSS, STIFFER, real_plant, sensor_errors
from haptics.loop.linear import LinearLoop, Structure, linearise, structure_at
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand, Plant

# Limits of this project for noise: force that is commanded, N rms, and motion of the handle in the band in which skin
# feels most, m rms. No source says that a hand does not feel these.
FORCE, MOTION, BAND_Hz = 0.05, 0.05e-6, (150.0, 500.0)
LEAST_FELT = 0.01e-6  # Motion in the band that the most sensitive subjects of the source detect, m
_POINTS = 600  # Frequencies of the band, even: the loop's response is smooth over 0.6 Hz
SPRING = (400.0, 20.0)  # N/m and N s/m of the spring that is held
# A handle all but let go of: what keeps it from wandering along a wall, a five-hundredth of the wall's own stiffness.
BARELY = Hand(mass=0.0, damping=0.5, stiffness=10.0)
# N s/m: beyond what any loop here bears; less than a spring of `SPRING` needs to stand; steps from one to the other
_MOST_DAMPING, _LEAST_DAMPING, STEPS = 1e3, 1e-2, 41
# Share of critical up to which a structure's damping is asked for, and to what share of itself it is found.
_MOST_LOSS, _FOUND_TO = 1.0, 0.03


@dataclass(frozen=True)
class NoiseFigures:
    """What noise does.

    Attributes:
        force: Command at the handle in its noisiest direction, N rms.
        motion: Handle in that band and its noisiest direction, m rms.
        steady: Whether the loop is stable at all; else both are infinite.
    """

    force: float
    motion: float
    steady: bool

    @property
    def quiet(self) -> bool:
        """Whether both limits hold."""
        return self.steady and self.force <= FORCE and self.motion <= MOTION

    @property
    def over_threshold(self) -> float:
        """Motion over what the most sensitive subjects detect."""
        return self.motion / LEAST_FELT


def covariance(
    loop: SampledLoop, stiffness: float, damping: float, error: np.ndarray, kept: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """Covariance of a loop's state and of its command.

    Args:
        loop: A stable loop.
        stiffness: K, N/m.
        damping: B, N s/m.
        error: (m, m) covariance of the errors of what is read.
        kept: Share of an error that is in the next one, too.

    Returns:
        (N, N), and (m, m) N^2.
    """
    moves, enters = loop.matrix(stiffness, damping), _enters(loop, stiffness, damping)
    size, m = enters.shape
    whole = np.block([[moves, enters], [np.zeros((m, size)), kept * np.eye(m)]])
    balanced, (scale, _) = matrix_balance(whole, permute=False, separate=True)  # units of the state differ by 1e12
    fresh = np.zeros((size + m, size + m))
    fresh[size:, size:] = (1.0 - kept**2) * error / np.outer(scale[size:], scale[size:])
    state = np.asarray(solve_discrete_lyapunov(balanced, fresh)) * np.outer(scale, scale)
    asks = stiffness * loop.ask[0] + damping * loop.ask[1]
    return state[:size, :size], asks @ state @ asks.T


def band(
    loop: SampledLoop, stiffness: float, damping: float, error: np.ndarray, place: np.ndarray, kept: float = 0.0
) -> np.ndarray:
    """Covariance of a place's motion in the band.

    Args:
        loop: A stable loop.
        stiffness: K, N/m.
        damping: B, N s/m.
        error: (m, m) covariance of the errors of what is read.
        place: (k, n) of the body's coordinates.
        kept: Share of an error that is in the next one, too.

    Returns:
        (k, k) m^2.
    """
    moves, enters = loop.matrix(stiffness, damping), _enters(loop, stiffness, damping)
    low, high = (2.0 * math.pi * f for f in BAND_Hz)
    w = np.linspace(low, min(high, math.pi / loop.period), _POINTS)
    turn = np.exp(1j * w * loop.period)[:, None, None]
    response = np.linalg.solve(
        turn * np.eye(len(moves)) - moves, np.broadcast_to(enters + 0j, (_POINTS, *enters.shape))
    )
    moved = place @ response[:, : place.shape[1]]
    density = np.real(moved @ error @ np.conj(np.swapaxes(moved, -1, -2)))
    density *= (1.0 - kept**2) / np.abs(1.0 - kept / turn) ** 2
    return loop.period / math.pi * np.asarray(np.trapezoid(density, w, axis=0))


def _enters(loop: SampledLoop, stiffness: float, damping: float) -> np.ndarray:
    return loop.error[0] + stiffness * loop.error[1] + damping * loop.error[2]


def _reading_deviation(machine: MachineModel, loop: LoopChoice) -> float:
    """Standard deviation of one reading of a design's encoders, counts included, rad."""
    return math.hypot(sensor_errors(machine, loop).noise, encoder_count(machine) / math.sqrt(12.0))


class NoisyLoop(LinearLoop):
    """The loop of a device about a pose, with the noise of its encoders.

    Args:
        machine: The device.
        loop: The loop.
        p: (3,) pose, m; the cube's centre if left out.
        hand: Who holds the handle.
        noise: Of a reading, rad; the design's own encoder's, counts included, if left out.
        kept: Share of it that is in the next reading; the design's own encoder's if left out.
        normal: (3,) of a wall; a spring in all directions if left out.
        par: The plant; the design's with nominal friction if left out.
        structure: What gives way under the knob; that of a plant that is given, else that of the device, if left out.
    """

    def __init__(
        self,
        machine: MachineModel,
        loop: LoopChoice = BOARD,
        p: np.ndarray | None = None,
        hand: Hand = FREE,
        *,
        noise: float | None = None,
        kept: float | None = None,
        normal: np.ndarray | None = None,
        par: Plant | None = None,
        structure: Structure | None = None,
    ) -> None:
        at = machine.centre if p is None else p
        if par is None:
            par, structure = real_plant(machine, loop), structure or structure_at(machine, at)
        here = linearise(par if normal is None else par.in_contact, at, structure)
        super().__init__(machine, loop, here)
        body, self.place = here.body(hand)
        along = np.eye(3) if normal is None else np.asarray(normal, dtype=float)[:, None]
        deviation = _reading_deviation(machine, loop) if noise is None else noise
        self.kept = self.errors.kept if kept is None else kept
        ports = here.ports(along, len(body.mass), self.at_motor)
        scale = here.effective_mass(np.eye(3)[0]) + hand.mass
        self.loop = sampled_loop(body, self.timing, self.estimator, ports, scale)
        through = here.jacobian.T @ along
        self.error = deviation**2 * through.T @ through

    def figures(self, stiffness: float, damping: float) -> NoiseFigures:
        """What noise does to a spring or wall of K (N/m) and B (N s/m)."""
        if not self.loop.radius(stiffness, damping) < 1.0:
            return NoiseFigures(math.inf, math.inf, False)
        _, command = covariance(self.loop, stiffness, damping, self.error, self.kept)
        motion = band(self.loop, stiffness, damping, self.error, self.place, self.kept)
        force, moved = (math.sqrt(float(np.linalg.eigvalsh(one)[-1])) for one in (command, motion))
        return NoiseFigures(force, moved, True)

    def damping_limit(self, stiffness: float) -> float:
        """Largest damping with a stiffness (N/m) at which noise is within the limits of force and motion, N s/m.

        Returns:
            N s/m; 0 where none is quiet enough.
        """

        def quiet(damping: float) -> bool:
            return self.figures(stiffness, damping).quiet

        low = next(filter(quiet, dampings := np.geomspace(_MOST_DAMPING, _LEAST_DAMPING, STEPS).tolist()), 0.0)
        if low in (0.0, _MOST_DAMPING):
            return low
        return bisect(quiet, low, dampings[dampings.index(low) - 1], ratio=1.005)[0]


@dataclass(frozen=True)
class NoiseRange:
    """What noise does over structures and what they damp, which nobody has measured.

    Attributes:
        least: Least force and least motion of all cases.
        most: Most force and most motion of all cases.
        reading: Deviation of one reading, counts included, at which the most would be just within limits, rad rms.
        loss: Share of critical damping that every structure would need for the motion to be within its limit, readings
            as they are; the least of what is assumed (`LOSS`) if that is enough, infinite if none is.
    """

    least: NoiseFigures
    most: NoiseFigures
    reading: float
    loss: float


def shares(machine: MachineModel) -> tuple[float, ...]:
    """Structures that a device may have, as shares of what is known of it: as built, or as its design requires."""
    return STIFFER if machine.structure is None else BUILT_SHARES


def noise_range(
    machine: MachineModel, loop: LoopChoice, p: np.ndarray, walls: Sequence[tuple[np.ndarray, float, float]]
) -> NoiseRange:
    """What noise does at a pose, all but let go of, over walls, structures (`shares`) and what these and cables damp.

    A hand takes a few per cent off what a handle let go of moves by.

    Args:
        machine: The device.
        loop: The loop.
        p: (3,) pose, m.
        walls: Normal (3,), stiffness (N/m) and damping (N s/m) of each.
    """
    plain = [real_plant(machine, loop, place) for place in range(len(LOSS))]

    def over(par: Plant, loss: float) -> list[NoiseFigures]:
        structures = [structure_at(machine, p, loss, share) for share in shares(machine)]
        return [
            NoisyLoop(machine, loop, p, BARELY, normal=n, par=par, structure=s).figures(k, b)
            for s in structures
            for n, k, b in walls
        ]

    found = [one for par, loss in zip(plain, LOSS, strict=True) for one in over(par, loss)]
    steady = all(one.steady for one in found)
    least, most = (NoiseFigures(of(f.force for f in found), of(f.motion for f in found), steady) for of in (min, max))
    reading = _reading_deviation(machine, loop) * min(FORCE / most.force, MOTION / most.motion)
    low, high = LOSS[0], _MOST_LOSS
    if most.motion <= MOTION:
        return NoiseRange(least, most, reading, low)
    if max(one.motion for one in over(plain[0], high)) > MOTION:
        return NoiseRange(least, most, reading, math.inf)
    _, high = bisect(
        lambda loss: max(one.motion for one in over(plain[0], loss)) > MOTION, low, high, ratio=1.0 + _FOUND_TO
    )
    return NoiseRange(least, most, reading, high)
