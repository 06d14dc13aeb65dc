"""Machines whose three chains differ, each closed by itself in trigonometry; nothing of the package is read."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Figures(NamedTuple):
    """Worst figures of machines at positions, (machines, positions); NaN where a chain is open."""

    elbow_arm: np.ndarray
    determinant: np.ndarray
    torque: np.ndarray
    kappa: np.ndarray
    lean: np.ndarray
    shoulder_min: np.ndarray
    shoulder_max: np.ndarray
    mass: np.ndarray
    couple_index: np.ndarray
    holding_torque: np.ndarray
    friction: np.ndarray
    position_step: np.ndarray
    elbow_angle: np.ndarray


def _singular(m: np.ndarray) -> np.ndarray:
    """Singular values in rising order, to 1e-16 of the square of the condition number, in a fifth of an SVD's time."""
    return np.sqrt(np.maximum(np.linalg.eigvalsh(np.swapaxes(m, -1, -2) @ m), 0.0))


def figures(
    chains: np.ndarray,
    p: np.ndarray,
    force: float = 1.0,
    masses: tuple[float, ...] = (1, 0, 0, 0),
    held: tuple[float, ...] = (0, 0, 0, 0, 0),
    joints: tuple[float, ...] = (1, 0, 0, 1),
    azimuths_deg: tuple[float, float, float] = (0.0, 120.0, 240.0),
) -> Figures:
    """Computes the figures of machines.

    Args:
        chains: (machines, 3, 8) R, offset, height of the shoulder; r, offset, height of the wrist; L_A; L_B; m.
        p: (positions, 3), m.
        force: N.
        masses: Carried, at an elbow, between both (kg), about a joint (kg m^2).
        joints: Friction of a joint (N m), the ball joints' along z and square to it (N), count of an encoder (rad).
        held: Gravity along x and z (m/s^2), kg carried, moments along an arm and square to it (kg m).
        azimuths_deg: Of the chains.
    """
    azimuth = np.radians(azimuths_deg)
    out = np.stack([np.cos(azimuth), np.sin(azimuth), 0.0 * azimuth], -1)
    along = np.stack([-np.sin(azimuth), np.cos(azimuth), 0.0 * azimuth], -1)
    up = np.array([0.0, 0.0, 1.0])

    def at(k):  # the joint of a chain whose three numbers begin at k: (machines, 3, 3)
        return chains[..., k, None] * out + chains[..., k + 1, None] * along + chains[..., k + 2, None] * up

    la, lb = chains[:, None, :, 6], chains[:, None, :, 7]
    d = p[None, :, None, :] + (at(3) - at(0))[:, None]  # shoulder to wrist, (machines, positions, chains, 3)
    q, t, z = (np.einsum("mpca,ca->mpc", d, axis) for axis in (out, along, np.tile(up, (3, 1))))
    with np.errstate(invalid="ignore"):
        # the angle at the shoulder between the line to the wrist, seen along the axis, and the upper arm
        flat = np.hypot(q, z)
        inner = np.arccos((flat**2 + la**2 - (lb**2 - t**2)) / (2.0 * la * flat))
        theta = np.arctan2(z, q) - inner
        arm = np.cos(theta)[..., None] * out + np.sin(theta)[..., None] * up
        turn = -np.sin(theta)[..., None] * out + np.cos(theta)[..., None] * up
        s = d - la[..., None] * arm
        w = np.einsum("mpca,mpca->mpc", s, turn)
        inverse = s / (la * w)[..., None]  # theta_dot = inverse v
        closed = np.isfinite(inverse).all((-1, -2))
        safe = np.where(closed[..., None, None], inverse, np.eye(3))
        size = _singular(safe)
        jacobian = np.linalg.inv(safe)
        carried, elbow, cross, joint = masses
        rows = la[..., None] * safe
        m = carried * np.eye(3) + np.einsum("mpc,mpca,mpcb->mpab", elbow + joint / la**2 + 0.0 * w, rows, rows)
        mixed = np.einsum("mpca,mpcb->mpab", rows, turn)
        m = m + cross * (mixed + np.swapaxes(mixed, -1, -2))
        carried_load = np.cross(along, s / lb[..., None])
        index = _singular(np.where(closed[..., None, None], carried_load, 0.0))[..., 0]
        heaviest = np.linalg.eigvalsh(np.where(np.isfinite(m), m, 0.0))[..., -1]

    gravity = np.array([held[0], 0.0, held[1]])
    fall = held[2] * np.einsum("a,mpac->mpc", gravity, jacobian) + (held[3] * turn - held[4] * arm) @ gravity
    sized = force * np.linalg.norm(jacobian, axis=-2) + np.abs(fall)

    senses = np.array([[1, b, c] for b in (1, -1) for c in (1, -1)])
    drive, upright, level, count = joints
    sources = drive * np.einsum("kc,mpca->mpka", senses, safe)
    felt = np.hypot(np.abs(sources[..., 2]) + upright, np.hypot(sources[..., 0], sources[..., 1]) + level).max(-1)
    steps = count * np.linalg.norm(np.einsum("kc,mpac->mpka", senses, jacobian), axis=-1).max(-1)

    def known(values):
        return np.where(closed, values, np.nan)

    return Figures(
        known(w.min(-1)),
        known(np.linalg.det(s)),
        known(force * np.linalg.norm(jacobian, axis=-2).max(-1)),
        known(size[..., 2] / size[..., 0]),
        known(np.arcsin(np.abs(t) / lb).max(-1)),
        known(theta.min(-1)),
        known(theta.max(-1)),
        known(heaviest),
        known(index),
        known(sized.max(-1)),
        known(felt),
        known(steps),
        known(np.arctan2(np.linalg.norm(np.cross(arm, s), axis=-1), -np.einsum("mpca,mpca->mpc", arm, s)).min(-1)),
    )
