"""Place of every link of the mechanism at a handle position, in closed form; no constraint solver.

Link frames (mm, right-handed):
    base: the base frame.
    upper_arm_i: origin in the shoulder, x to the elbow, y along the shoulder axis (tangential).
    pinion_i: origin on the pinion's axis, y along it; turns against the arm by the drive ratio.
    rod_i_j: origin in the elbow ball of side j (0: -y side, 1: +y side of the chain), x to the wrist ball,
        y the part of the chain's tangential direction that is square to x: the axis of the sockets.
    spring_i_k: origin half-way between the eyes of spring k, one eye on either rod of chain i; y from the eye on side
        0 to that on side 1, z as of the rods. It hangs on both rods and is carried by neither.
    platform: origin in the platform centre, axes along the base frame.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry, joint_angles
from delta_cad.mechanism.geometry import VERTICAL
from delta_cad.mechanism.inverse import require_closed

_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]
CHAINS = range(3)
SIDES = range(2)
_SWAY_STEPS = 256  # ranges of the lean: the bounds are 1 % wide with these
LINKS = (
    "base",
    *(f"upper_arm_{i}" for i in CHAINS),
    *(f"pinion_{i}" for i in CHAINS),
    *(f"rod_{i}_{j}" for i in CHAINS for j in SIDES),
    *(f"spring_{i}_{k}" for i in CHAINS for k in SIDES),
    "platform",
)


def chain_turn(g: DeltaGeometry, i: int) -> np.ndarray:
    """(4, 4) rotation about z that takes chain i's (radial, tangential, z) directions to the base frame."""
    frame = np.eye(4)
    frame[:3, 0], frame[:3, 1] = g.radial[i], g.tangential[i]
    return frame


def chain_stand(g: DeltaGeometry, i: int) -> np.ndarray:
    """(4, 4) frame in which all of chain i that stands on the base lies as chain 0's does in the base frame, mm.

    It is turned to the chain's azimuth and moved out by R_i - R_0: three equal chains, each in its place.
    """
    frame = chain_turn(g, i)
    frame[:3, 3] = (g.base_radii[i] - g.base_radius) * MM_PER_M * g.radial[i]
    return frame


def frames(x: np.ndarray, y: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """(..., 4, 4) frames with the given unit x and y axes (..., 3), z = x cross y, at `origin` (..., 3)."""
    x, y, origin = np.broadcast_arrays(x, y, origin)
    out = np.zeros((*x.shape[:-1], 4, 4))
    z = (
        x[..., _NEXT] * y[..., _AFTER] - x[..., _AFTER] * y[..., _NEXT]
    )  # np.cross of few vectors takes five times as long
    out[..., :3, 0], out[..., :3, 1], out[..., :3, 2], out[..., :3, 3] = x, y, z, origin
    out[..., 3, 3] = 1.0
    return out


@dataclass(frozen=True)
class SpringSway:
    """How far a spring across a pair of rods strays from a line along the shoulder axis through its own middle.

    Attributes:
        along_mm: Its middle, along the shoulder axis.
        across_mm: Its middle, square to the shoulder axis.
        turn_rad: Its direction from the shoulder axis.
    """

    along_mm: float
    across_mm: float
    turn_rad: float


def spring_sway(width_mm: float, eye_inside_mm: float, eye_aside_mm: float, tilt_rad: float) -> SpringSway:
    """Bounds how far a spring strays while its rods lean and turn about themselves, each as far as its joints let it.

    An eye at v from its rod's axis, e inwards and z aside, moves by `(Q - 1) v` when its rod turns by `turn`: at most
    `z sin(turn) + e (1 - cos(turn))` along the parallelogram and `z (1 - cos(turn)) + e sin(turn)` square to it; the
    spring's middle moves no farther. Its direction is that of the width along the shoulder axis less both eyes. The
    parallelogram leans from that axis, and `cos(lean) cos(turn) >= cos(tilt)`: where the rods lean they turn less.

    Args:
        width_mm: Distance of the rods along the shoulder axis.
        eye_inside_mm: How far inside its rod's axis an eye lies.
        eye_aside_mm: How far beside it.
        tilt_rad: Largest tilt of the joints.

    Returns:
        The bounds, over ranges of the lean, of which each end is taken where it does most.
    """
    e, z = eye_inside_mm, abs(eye_aside_mm)
    lean = np.linspace(0.0, tilt_rad, _SWAY_STEPS + 1)
    turn = np.arccos(np.clip(np.cos(tilt_rad) / np.cos(lean[:-1]), 0.0, 1.0))
    leaning = np.sin(lean[1:])
    along = z * np.sin(turn) + e * (1.0 - np.cos(turn))
    adjacent = z * (1.0 - np.cos(turn)) + e * np.sin(turn)
    apart, off = 2.0 * (e + z * np.sin(turn)), z * (1.0 - np.cos(turn)) + 2.0 * e * np.sin(turn)
    direction = np.arctan(np.hypot(off, apart * leaning) / (width_mm - apart))
    return SpringSway(float(along.max()), float(np.hypot(adjacent, along * leaning).max()), float(direction.max()))


@dataclass(frozen=True)
class LinkPlacement:
    """Closed-form placement of all links.

    Attributes:
        geometry: The mechanism, metres.
        parallelogram_width_mm: Distance of the two rods of a chain along the shoulder axis.
        pinion_centre_mm: (2,) x and z of the pinion's axis in the chain's frame, `chain_stand`.
        drive_ratio: Turns of the pinion per turn of the arm, positive; 1 for a direct drive, whose pinion link
            turns with the arm.
        springs_mm: Of each of a pair's two springs x and z of its eyes in the rods' frames.
        eye_inside_mm: How far inside its rod's axis an eye lies.
    """

    geometry: DeltaGeometry
    parallelogram_width_mm: float
    pinion_centre_mm: tuple[float, float]
    drive_ratio: float
    springs_mm: tuple[tuple[float, float], tuple[float, float]] = ((0.0, 0.0), (0.0, 0.0))
    eye_inside_mm: float = 0.0

    def __call__(self, p_mm: np.ndarray) -> Mapping[str, np.ndarray]:
        """Computes the transforms of all links.

        Args:
            p_mm: (..., 3) platform centre in the base frame, mm.

        Returns:
            Link name -> (..., 4, 4), link frame to base frame, mm.

        Raises:
            UnreachableError: A chain cannot be closed at one of the positions.
        """
        p = np.asarray(p_mm, dtype=float)
        g = self.geometry
        require_closed(g, p / MM_PER_M)
        theta = joint_angles(g, p / MM_PER_M)
        arm = g.upper_arm_length * MM_PER_M
        wrist_radius = g.platform_radius * MM_PER_M
        shape = p.shape[:-1]
        links: dict[str, np.ndarray] = {"base": np.broadcast_to(np.eye(4), (*shape, 4, 4))}
        platform = np.broadcast_to(np.eye(4), (*shape, 4, 4)).copy()
        platform[..., :3, 3] = p
        for i in CHAINS:
            radius, u, t, z = g.base_radii[i] * MM_PER_M, g.radial[i], g.tangential[i], VERTICAL
            angle = theta[..., i, None]
            x = np.cos(angle) * u + np.sin(angle) * z
            links[f"upper_arm_{i}"] = frames(x, t, radius * u)
            sense = -1.0 if self.drive_ratio > 1.0 else 1.0
            turned = sense * self.drive_ratio * angle
            links[f"pinion_{i}"] = frames(
                np.cos(turned) * u + np.sin(turned) * z,
                t,
                self.pinion_centre_mm[0] * u + self.pinion_centre_mm[1] * z + chain_stand(g, i)[:3, 3],
            )
            elbow = radius * u + arm * x
            s = p + wrist_radius * u - elbow
            along = s / np.linalg.norm(s, axis=-1, keepdims=True)
            across = t - (along @ t)[..., None] * along
            across = across / np.linalg.norm(across, axis=-1, keepdims=True)
            for j in SIDES:
                side = (j - 0.5) * self.parallelogram_width_mm * t
                links[f"rod_{i}_{j}"] = frames(along, across, elbow + side)
            normal = np.cross(along, across)
            between = self.parallelogram_width_mm * t - 2.0 * self.eye_inside_mm * across
            between = between / np.linalg.norm(between, axis=-1, keepdims=True)
            for k, (x_mm, z_mm) in enumerate(self.springs_mm):
                middle = elbow + x_mm * along + z_mm * normal
                links[f"spring_{i}_{k}"] = frames(np.cross(between, normal), between, middle)
        links["platform"] = platform
        return links
