"""The best fit of parameters to measured poses, their uncertainty, and the parameters that are not identifiable.

Weighted least squares of positions: each row is divided by what the noise of positions and of readings explains of it.
Manufacturing tolerances weigh in as one more measurement of each parameter, so that what poses do not determine stays
as drawn. `Fit.singular_values` are those of the poses' equations with every parameter in units of its tolerance, and
with the tracker's frame taken out: below 1 the drawing says more of a direction than the poses do.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.chains import chain_angles, chain_derivatives, chain_positions
from delta_cad.mechanism.geometry import DeltaGeometry
from haptics.calibration.poses import Poses
from haptics.calibration.unknowns import COUNT, LENGTHS, NAMES, WAVE_SIGMA, ZERO, Unknowns, nominal, sigmas

_UNIDENTIFIABLE = 3  # of the unknowns: the sum of each chain's two radii
_MARGIN = 4  # poses beyond as many as there are unknowns, from which one sees how well they fit
# Of a tracker's frame beyond the closest one: so wide that it says nothing, and yet finite where nothing else does.
_TURN_SIGMA, _SHIFT_SIGMA = 0.3, 0.1
_FAR = 20e-3  # m, of half the poses with the zeros alone fitted: lengths within 5 mm of the drawing leave less
_NO_DEVICE = "readings and positions belong to no device like the drawn one"
STEPS = 60  # of a search, of which 5 to 15 are enough where there is a device
STEP = 1e-6  # rad, of the difference that gives how positions follow a turn of their frame


class FitError(ValueError):
    """Poses that determine no parameters; the message is one line.

    Attributes:
        poses: Numbers of the poses at which the drawn device cannot be, from 0; empty where none is to blame.
    """

    def __init__(self, text: str, lost: np.ndarray | None = None) -> None:
        self.poses = () if lost is None else tuple(int(n) for n in np.flatnonzero(np.isnan(lost).any(axis=1)))
        super().__init__(f"pose {self.poses[0] + 1}: {text}" if self.poses else text)


@dataclass(frozen=True)
class Noise:
    """Standard deviations of what was measured.

    Attributes:
        position: Of each coordinate of a position, m.
        angle: Of a reading, rad.
    """

    position: float = 0.02e-3
    angle: float = math.radians(0.005)


@dataclass(frozen=True)
class _Frame:
    """Where the frame of the positions lies: `p_base = rotation p + shift`.

    Attributes:
        rotation: (3, 3).
        shift: (3,) m.
        solved: Whether it was sought; else positions are in the base frame.
    """

    rotation: np.ndarray
    shift: np.ndarray
    solved: bool

    def to_base(self, p: np.ndarray) -> np.ndarray:
        """Gives positions (n, 3) in the base frame, m."""
        return p @ self.rotation.T + self.shift


@dataclass(frozen=True)
class Fit:
    """What came of the poses.

    Attributes:
        unknowns: The parameters.
        frame: The positions' frame.
        sigma: (3, 11) standard deviation of each parameter; larger by the misfit, where that is above 1.
        singular_values: (k,) of the poses' equations, largest first, and 0 for what no pose tells.
        directions: (33, 33) as rows the combinations of parameters that they tell, in units of `sigmas`.
        before: (n,) distance of each pose from where the drawn device has its readings, m; NaN where it has none.
        after: (n,) from the calibrated one, m.
        misfit: Root of the mean square of what is left, in units of the noise: 1 where noise alone explains it.
        problem: The equations, from which the error at any position follows.
        x: (n,) solution of the equations: 33 parameters and, where the frame was sought, its turn and shift, each in
            units of what it may be off before it is measured.
        covariance: (n, n) of `x`.
    """

    unknowns: Unknowns
    frame: _Frame
    sigma: np.ndarray
    singular_values: np.ndarray
    directions: np.ndarray
    before: np.ndarray
    after: np.ndarray
    misfit: float
    problem: _Problem
    x: np.ndarray
    covariance: np.ndarray

    @property
    def unlike(self) -> tuple[float, str]:
        """How far a length or offset is off the drawing at most, standard deviations of a part's, and which one."""
        off = self.x[: 3 * COUNT].reshape(3, COUNT)[:, :LENGTHS]
        chain, k = np.unravel_index(np.abs(off).argmax(), off.shape)
        mm = MM_PER_M * off[chain, k] * self.problem.scale[chain * COUNT + k]
        return abs(float(off[chain, k])), f"{NAMES[k]} of chain {chain} is {mm:+.2f} mm off the drawing"

    def at(self, positions: np.ndarray) -> _Problem:
        """Gives the equations of poses that the calibrated device would have at positions (m, 3) in the base frame, m.

        Raises:
            FitError: It does not reach one of them.
        """
        theta = chain_angles(self.unknowns.mechanism, positions)
        if np.isnan(theta).any():
            lost = MM_PER_M * positions[np.isnan(theta).any(axis=1)][0]
            raise FitError("the calibrated device does not reach ({:.1f}, {:.1f}, {:.1f}) mm".format(*lost))
        measured = (positions - self.frame.shift) @ self.frame.rotation
        return replace(self.problem, poses=Poses(measured, self.unknowns.readings(theta)))


def poses_needed(own_frame: bool) -> int:
    """Computes how many poses the parameters need: three equations a pose, and some to spare."""
    unknown = 3 * COUNT - _UNIDENTIFIABLE + (6 if own_frame else 0)
    return math.ceil(unknown / 3) + _MARGIN


def fit(
    g: DeltaGeometry,
    poses: Poses,
    *,
    turns: float = 1.0,
    noise: Noise | None = None,
    own_frame: bool = False,
    wave: float = WAVE_SIGMA,
) -> Fit:
    """Finds the parameters of a device.

    Args:
        g: The device as drawn.
        poses: What was measured.
        turns: Turns of an encoder in one of the arm.
        noise: Of positions and readings.
        own_frame: Whether positions are in a frame of their own, which is sought, too.
        wave: Standard deviation of an encoder's wave before it is measured, rad.

    Raises:
        FitError: There are too few poses, the drawn device cannot be at one of them, or no device like it has them.
    """
    noise = Noise() if noise is None else noise
    count, needed = len(poses.positions), poses_needed(own_frame)
    if count < needed:
        unknowns = f"{3 * COUNT - _UNIDENTIFIABLE} identifiable parameters{' and a frame' if own_frame else ''}"
        raise FitError(
            f"{count} poses; at least {needed} are needed for {unknowns}, {_MARGIN} of them to judge the fit"
        )
    drawn = nominal(g, turns)
    scale, frame = sigmas(wave).ravel(), _Frame(np.eye(3), np.zeros(3), own_frame)
    reached = _reached(drawn, poses)
    if own_frame:
        scale = np.concatenate([scale, [_TURN_SIGMA] * 3, [_SHIFT_SIGMA] * 3])
        frame = _closest(poses.positions, reached)
    before = np.linalg.norm(reached - frame.to_base(poses.positions), axis=1)
    problem = _Problem(poses, drawn, frame, scale, noise)
    x = _zeros_alone(problem)
    try:
        for _ in range(2):  # the noise's share follows the pose, so once more with that of the calibrated device
            problem = replace(problem, whitening=problem.whitened(x))
            x = _least_squares(problem.residuals, x, problem.jacobian)
    except np.linalg.LinAlgError:  # at a direct singularity
        raise FitError(_NO_DEVICE) from None
    unknowns, frame = problem.at(x)
    jacobian, rows = problem.jacobian(x), 3 * count
    # what parts are made to holds each combination of unknowns, too: of one that poses tell s times better, noise takes
    # s^2 / (1 + s^2) of a measurement
    resolution = np.linalg.svd(jacobian[:rows], compute_uv=False) ** 2
    freedom = rows - (resolution / (1.0 + resolution)).sum()
    misfit = float(np.sqrt((problem.residuals(x)[:rows] ** 2).sum() / freedom))
    sure = jacobian.copy()
    sure[:rows] /= max(1.0, misfit)  # what is left beyond the noise makes the poses worth less, not the drawing
    covariance = np.linalg.inv(sure.T @ sure)
    data = jacobian[:rows, : 3 * COUNT]
    if own_frame:
        q, _ = np.linalg.qr(jacobian[:rows, 3 * COUNT :])
        data = data - q @ (q.T @ data)
    _, singular_values, directions = np.linalg.svd(data, full_matrices=False)
    return Fit(
        unknowns=unknowns,
        frame=frame,
        sigma=(np.sqrt(np.diag(covariance)) * scale)[: 3 * COUNT].reshape(3, COUNT),
        singular_values=singular_values,
        directions=directions,
        before=before,
        after=np.linalg.norm(problem.apart(x), axis=1),
        misfit=misfit,
        problem=problem,
        x=x,
        covariance=covariance,
    )


@dataclass(frozen=True)
class _Problem:
    """Residuals of unknowns x, each in units of its standard deviation and counted from the drawn device.

    Attributes:
        poses: Where the equations are.
        drawn: The device as drawn.
        frame: Frame of the positions where x is 0.
        scale: (n,) standard deviation of each unknown before it is measured, m and rad.
        noise: Of positions and readings.
        whitening: (m, 3, 3) by which noise becomes of unit variance, once it is known.
    """

    poses: Poses
    drawn: Unknowns
    frame: _Frame
    scale: np.ndarray
    noise: Noise
    whitening: np.ndarray | None = None

    def at(self, x: np.ndarray) -> tuple[Unknowns, _Frame]:
        """The device and the frame."""
        step = self.scale * x
        table = self.drawn.table + step[: 3 * COUNT].reshape(3, COUNT)
        frame = self.frame
        if frame.solved:
            frame = _moved(frame, step[3 * COUNT : 3 * COUNT + 3], step[3 * COUNT + 3 :])
        return replace(self.drawn, table=table), frame

    def apart(self, x: np.ndarray) -> np.ndarray:
        """(n, 3) from the measured position to that of the readings, m."""
        unknowns, frame = self.at(x)
        return _reached(unknowns, self.poses) - frame.to_base(self.poses.positions)

    def residuals(self, x: np.ndarray) -> np.ndarray:
        """(3 n + m,) of the poses, and of the parameters as drawn."""
        return np.concatenate([(self._whitening() @ self.apart(x)[..., None]).ravel(), x])

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """(3 n + m, m) of `residuals`."""
        whole = (self._whitening() @ self.rows(x)).reshape(-1, len(x))
        return np.vstack([whole, np.eye(len(x))])

    def rows(self, x: np.ndarray) -> np.ndarray:
        """(n, 3, m) derivative of `apart` by the unknowns, m."""
        unknowns, frame = self.at(x)
        theta = unknowns.angles(self.poses.readings)
        p = chain_positions(unknowns.mechanism, theta)
        by_joint, by_length = chain_derivatives(unknowns.mechanism, theta, p)
        by_angle = by_joint[..., None] * unknowns.waves(self.poses.readings)[:, None, :, :]
        rows = np.concatenate([by_length, by_angle], axis=-1).reshape(len(p), 3, 3 * COUNT)
        if frame.solved:
            moves = []
            for step in STEP * np.eye(3):
                turn = self.scale[3 * COUNT : 3 * COUNT + 3] * x[3 * COUNT : 3 * COUNT + 3]
                either = (_moved(self.frame, turn + sign * step, np.zeros(3)) for sign in (1.0, -1.0))
                ahead, behind = (one.to_base(self.poses.positions) for one in either)
                moves.append((behind - ahead) / (2.0 * STEP))
            shifts = np.broadcast_to(-np.eye(3), (len(p), 3, 3))
            rows = np.concatenate([rows, np.stack(moves, axis=-1), shifts], axis=-1)
        return rows * self.scale

    def whitened(self, x: np.ndarray) -> np.ndarray:
        """(n, 3, 3) by which noise becomes of unit variance."""
        unknowns, _ = self.at(x)
        theta = unknowns.angles(self.poses.readings)
        by_joint, _ = chain_derivatives(unknowns.mechanism, theta, chain_positions(unknowns.mechanism, theta))
        both = self.noise.position**2 * np.eye(3) + self.noise.angle**2 * by_joint @ np.swapaxes(by_joint, 1, 2)
        return np.linalg.inv(np.linalg.cholesky(both))

    def _whitening(self) -> np.ndarray:
        assert self.whitening is not None
        return self.whitening


def _reached(unknowns: Unknowns, poses: Poses) -> np.ndarray:
    """(n, 3) where the readings put the handle, m; NaN where no position fits."""
    return chain_positions(unknowns.mechanism, unknowns.angles(poses.readings))


def _moved(frame: _Frame, turn: np.ndarray, shift: np.ndarray) -> _Frame:
    from scipy.spatial.transform import Rotation

    rotation = Rotation.from_rotvec(turn).as_matrix()
    return _Frame(rotation @ frame.rotation, rotation @ frame.shift + shift, frame.solved)


def _closest(measured: np.ndarray, reached: np.ndarray) -> _Frame:
    """The frame that brings the measured positions closest to those of the drawn device."""
    from scipy.spatial.transform import Rotation

    if np.isnan(reached).any():
        raise FitError(
            "no position of the drawn device has these readings; with a frame of its own the zeros must be right to "
            "some degrees: put them in first",
            reached,
        )
    middle, goal = measured.mean(axis=0), reached.mean(axis=0)
    rotation = Rotation.align_vectors(reached - goal, measured - middle)[0].as_matrix()
    return _Frame(rotation, goal - rotation @ middle, True)


def _zeros_alone(problem: _Problem) -> np.ndarray:
    """Unknowns of which only the zeros, and the frame, are not as drawn: where the whole search begins."""
    x, poses, drawn = np.zeros(len(problem.scale)), problem.poses, problem.drawn
    zeros = np.arange(3) * COUNT + ZERO
    if not problem.frame.solved:
        theta = chain_angles(drawn.mechanism, poses.positions)
        if np.isnan(theta).any():
            raise FitError("the drawn device does not reach its position", theta)
        off = theta - poses.readings
        x[zeros] = np.angle(np.exp(1j * off).mean(axis=0)) / problem.scale[zeros]
    else:
        some = np.concatenate([zeros, np.arange(3 * COUNT, len(x))])

        def apart(part: np.ndarray) -> np.ndarray:
            x[some] = part
            return np.nan_to_num(problem.apart(x), nan=1.0).ravel()

        x[some] = _least_squares(apart, x[some])
    if np.isnan(left := problem.apart(x)).any():
        raise FitError("its readings and its position do not belong to the drawn device", left)
    if np.median(np.linalg.norm(left, axis=1)) > _FAR:
        raise FitError(_NO_DEVICE)
    return x


def _least_squares(
    residuals: Callable[[np.ndarray], np.ndarray],
    start: np.ndarray,
    jacobian: Callable[[np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    from scipy.optimize import least_squares

    try:
        by: Any = "3-point" if jacobian is None else jacobian
        found = least_squares(residuals, start, by, xtol=1e-12, ftol=1e-12, max_nfev=STEPS)
    except ValueError:  # a residual that is not finite
        raise FitError(_NO_DEVICE) from None
    return found.x
