"""What the machine stands on: flexibility of base plate and supports under the three foot blocks, tipping, sliding.

The plate is a thin plate (Kirchhoff) whose deflection is a polynomial in x and y (Rayleigh and Ritz). Its supports are
springs at points: the face that a screwed plate lies on is left out, and so is what a foot block adds to the plate
under it. Against a solid model of the plate, clamped in its mounting holes, the motion of a foot block is within 35 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, pi, sqrt
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, link_placement
from delta_cad.dimensions.platform import MOUNT_SCREW
from delta_cad.structure.section import POISSON

FACTOR = 1.5  # of the largest force at the handle: a user pushes against what the machine renders, and more
FOOT_FRICTION = 0.5  # of a rubber foot on a dry, smooth table; from memory, the low end of 0.5 to 0.8
SHORE_A = 50.0  # of a rubber foot: the soft end of the usual 55 +-5
_DEGREE = 10  # of the polynomial: the flexibility grows by less than 1 % beyond it
_STEP_MM = 3.0  # of the grid on which the plate's energy is summed
_CIRCLE = 48  # points for each circle of the plate's outline
_PATCH = 6  # points along each edge of a foot block


@dataclass(frozen=True)
class Supports:
    """Springs under the base plate.

    Attributes:
        places_mm: (n, 2) in the base frame.
        below_mm: How far under the plate's middle they hold it sideways.
        axial_N_mm: Stiffness of each, upright.
        lateral_N_mm: Stiffness of each, sideways.
    """

    places_mm: np.ndarray
    below_mm: float
    axial_N_mm: float
    lateral_N_mm: float


@dataclass(frozen=True)
class Mounting:
    """Base plate on its supports, with locked brackets on it.

    Wrenches are (3 chains, 6): force and moment on the plate about the middle of a foot block's lower face, base axes,
    N and N mm; flattened to 18.

    Attributes:
        blocks_mm: (3, 3) these middles.
        shares: "base plate" and "supports" -> (18, 18) their shares of the motion of the blocks by these wrenches.
        reactions: (n, 18) upright force of each support on the plate for unit wrenches.
    """

    blocks_mm: np.ndarray
    shares: dict[str, np.ndarray]
    reactions: np.ndarray

    def to_blocks(self, at_mm: np.ndarray, axes: np.ndarray) -> np.ndarray:
        """Moves a wrench on each chain to its foot block, (..., 3, 6, 6).

        Args:
            at_mm: (..., 3, 3) where the wrenches act.
            axes: (..., 3, 3, 3) their axes as rows.
        """
        turn = np.swapaxes(axes, -1, -2)
        lever = (at_mm - self.blocks_mm)[..., None]
        found = np.zeros((*turn.shape[:-2], 6, 6))
        found[..., :3, :3] = found[..., 3:, 3:] = turn
        found[..., 3:, :3] = np.cross(np.broadcast_to(lever, turn.shape), turn, axis=-2)
        return found


def rubber_N_mm(diameter_mm: float, height_mm: float, shore_A: float = SHORE_A) -> tuple[float, float]:
    """Computes the stiffness of a round rubber foot between two faces that hold it: upright and sideways, N/mm.

    Source:
        Young's modulus by hardness: Gent, On the relation between indentation hardness and Young's modulus (1958);
        shape factor `1 + 2 S^2` with S the area of one face over that of the free side: Gent and Lindley (1959).
    """
    youngs = 0.0981 * (56.0 + 7.62336 * shore_A) / (0.137505 * (254.0 - 2.54 * shore_A))
    area, shape = pi / 4.0 * diameter_mm**2, diameter_mm / (4.0 * height_mm)
    return youngs * (1.0 + 2.0 * shape**2) * area / height_mm, youngs / 3.0 * area / height_mm


def supports(d: Dimensions) -> Supports:
    """Gives what a machine's base plate is carried by: its feet, or the screws that hold it down.

    A screw counts as its own shank and thread in tension (VDI 2230: half a diameter more at head and at thread); the
    clamped parts, several times as stiff, are left out.
    """
    half = d.base.thickness_mm / 2.0
    if not d.is_screwed_down:
        return Supports(
            np.array(d.base.feet_mm), half + d.foot.height_mm, *rubber_N_mm(d.foot.diameter_mm, d.foot.height_mm)
        )
    row, steel = catalogue.screw(MOUNT_SCREW), catalogue.material("steel").youngs_modulus_Pa * 1e-6
    area = pi / 4.0 * (row.diameter_mm - 0.9382 * row.pitch_mm) ** 2
    rate = steel * area / (d.base.thickness_mm + d.sleeve_mm + row.diameter_mm)
    return Supports(np.array(d.base.mounts_mm), half + d.sleeve_mm, rate, rate)


def mounting(d: Dimensions) -> Mounting:
    """Computes how the base plate of a machine gives under its foot blocks."""
    b, k, layers = d.base, d.bracket, d.layers
    youngs = catalogue.material(d.material_of("base_plate")).design_modulus_Pa * 1e-6
    rigidity = youngs * b.thickness_mm**3 / (12.0 * (1.0 - POISSON**2))
    rims = b.rim_mm or ((0.0, 0.0, b.radius_mm),)
    aside = layers.encoder_cheek_mm[1], layers.motor_cheek_mm[0]
    patches = [d.stand(i) @ _patch((k.foot_u_mm[0], k.foot_u_mm[1]), aside) for i in range(3)]
    blocks = np.array([patch[:3].mean(axis=-1) for patch in patches])
    blocks[:, 2] = b.top_mm
    under = supports(d)
    turns = [d.stand(i)[:3, :2].T for i in range(3)]
    plate = _Plate(rims, b.holes_mm, rigidity)
    loads = np.concatenate(
        [plate.loads(patch[:2].T, axes, b.thickness_mm / 2.0) for patch, axes in zip(patches, turns, strict=True)]
    )
    held = plate.displacements(under.places_mm, np.full(len(under.places_mm), -under.below_mm))
    springs = np.tile([under.lateral_N_mm, under.lateral_N_mm, under.axial_N_mm], len(under.places_mm))
    rows = held.reshape(-1, held.shape[-1])
    of_springs = rows.T @ (springs[:, None] * rows)
    moved = np.linalg.solve(plate.stiffness + of_springs, loads.T)
    shares = {"base plate": moved.T @ plate.stiffness @ moved, "supports": moved.T @ of_springs @ moved}
    return Mounting(blocks, shares, -under.axial_N_mm * held[:, 2] @ moved)


def _patch(along_mm: tuple[float, float], aside_mm: tuple[float, float]) -> np.ndarray:
    """(4, n) points spread evenly over a foot block's lower face, in the chain's plane of the base."""
    middles = (np.arange(_PATCH) + 0.5) / _PATCH
    u, v = (low + (high - low) * middles for low, high in (along_mm, aside_mm))
    x, y = (grid.ravel() for grid in np.meshgrid(u, v))
    return np.stack([x, y, np.zeros_like(x), np.ones_like(x)])


class _Plate:
    """Coordinates of a plate: two displacements and a turn in its plane, then the coefficients of its deflection."""

    def __init__(
        self,
        rims: tuple[tuple[float, float, float], ...],
        holes: list[tuple[float, float, float]],
        rigidity_N_mm: float,
    ) -> None:
        from scipy.spatial import ConvexHull

        angle = 2.0 * pi * np.arange(_CIRCLE) / _CIRCLE
        round_ = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        outline = np.concatenate([np.array([x, y]) + r * round_ for x, y, r in rims])
        self._low, self._high = outline.min(axis=0), outline.max(axis=0)
        self._pairs = [(i, j) for i in range(_DEGREE + 1) for j in range(_DEGREE + 1 - i)]
        counts = np.ceil((self._high - self._low) / _STEP_MM).astype(int)
        cell = (self._high - self._low) / counts
        axes = [low + step * (np.arange(n) + 0.5) for low, step, n in zip(self._low, cell, counts, strict=True)]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        sides = ConvexHull(outline).equations
        inside = (points @ sides[:, :2].T + sides[:, 2] <= 0.0).all(axis=-1)
        for x, y, r in holes:
            inside &= ((points - (x, y)) ** 2).sum(axis=-1) >= r**2
        xx, yy, xy = (self.deflections(points[inside], *by) for by in ((2, 0), (0, 2), (1, 1)))
        mixed = xx.T @ yy
        energy = xx.T @ xx + yy.T @ yy + POISSON * (mixed + mixed.T) + 2.0 * (1.0 - POISSON) * xy.T @ xy
        self.stiffness = np.zeros((3 + len(self._pairs),) * 2)
        self.stiffness[3:, 3:] = rigidity_N_mm * float(cell.prod()) * energy

    def deflections(self, points: np.ndarray, by_x: int = 0, by_y: int = 0) -> np.ndarray:
        """(n, coefficients) of the deflection, or of its derivatives, at (n, 2) points."""
        scale = 2.0 / (self._high - self._low)
        at = (points - self._low) * scale - 1.0
        eye = np.eye(_DEGREE + 1)
        x, y = (
            legendre.legval(at[:, axis], legendre.legder(eye, by) if by else eye) * scale[axis] ** by
            for axis, by in ((0, by_x), (1, by_y))
        )
        return np.stack([x[i] * y[j] for i, j in self._pairs], axis=-1)

    def displacements(self, points: np.ndarray, height_mm: np.ndarray) -> np.ndarray:
        """(n, 3, coordinates) displacement of points at heights over the plate's middle."""
        found = np.zeros((len(points), 3, len(self.stiffness)))
        found[:, 0, 0], found[:, 1, 1] = 1.0, 1.0
        found[:, 0, 2], found[:, 1, 2] = -points[:, 1], points[:, 0]
        found[:, 0, 3:] = -height_mm[:, None] * self.deflections(points, 1, 0)
        found[:, 1, 3:] = -height_mm[:, None] * self.deflections(points, 0, 1)
        found[:, 2, 3:] = self.deflections(points)
        return found

    def loads(self, points: np.ndarray, axes: np.ndarray, height_mm: float) -> np.ndarray:
        """(6, coordinates) work of unit forces and moments that are spread over a rectangle, base axes.

        Args:
            points: (n, 2) spread evenly over it.
            axes: (2, 3) its edges' directions.
            height_mm: Of the face that bears the load over the plate's middle.
        """
        moved = self.displacements(points, np.full(len(points), height_mm))
        along = (points - points.mean(axis=0)) @ axes[:, :2].T
        slopes = (along / (along**2).sum(axis=0)).T @ moved[:, 2]  # of the deflection, along the edges
        x, y = axes[:, :2].T @ slopes
        about_z = np.zeros(len(self.stiffness))
        about_z[2] = 1.0
        return np.concatenate([moved.mean(axis=0), [y, -x, about_z]])


@dataclass(frozen=True)
class Upset:
    """Least forces at the handle, over positions and directions, that move a machine which stands free.

    Attributes:
        tips_N: That tip it over the line through two feet.
        slides_N: That slide it over the table.
        tips_mm: Position of the platform where it tips first.
        added_kg: Mass at the middle of the feet with which the forces are `FACTOR` times the largest at the handle;
            infinite where gravity does not press them on the table.
    """

    tips_N: float
    slides_N: float
    tips_mm: np.ndarray
    added_kg: float


def upset(d: Dimensions, bodies: Mapping[str, Any], positions_mm: np.ndarray, knob_mm: float, force_N: float) -> Upset:
    """Computes what tips and slides a machine on its feet.

    A force F at the height h over the table, a way s inside the line through two feet, turns it about this line by
    `F sqrt(h^2 + s^2)` at most over its directions; its weight holds by `W a`, its centre a way a inside. On a level
    table it slides at `W mu / sqrt(1 + mu^2)`, the force raised by the angle of friction.

    Args:
        d: Dimensions of a machine on feet.
        bodies: `bodies` of its mass report.
        positions_mm: (n, 3) of the platform.
        knob_mm: Height of the knob's centre over the wrists.
        force_N: Largest force at the handle.
    """
    feet = np.array(d.base.feet_mm)
    ground = d.base.top_mm - d.base.thickness_mm - d.foot.height_mm
    gravity = np.array(d.design.requirements.gravity_m_s2)
    down, aside = -float(gravity[2]), float(np.hypot(gravity[0], gravity[1]))
    frames = link_placement(d)(positions_mm)
    mass, moment = 0.0, np.zeros((len(positions_mm), 3))
    for link, body in bodies.items():
        frame, own = np.broadcast_to(frames[link], (len(positions_mm), 4, 4)), float(body["mass_kg"])
        moment += own * (frame[:, :3, :3] @ (np.array(body["centre_m"]) * MM_PER_M) + frame[:, :3, 3])
        mass += own
    centre, knob = moment / mass, positions_mm + np.array([0.0, 0.0, knob_mm])
    tips, added = np.full(len(positions_mm), np.inf), 0.0
    middle = feet.mean(axis=0)
    for one, other in zip(feet, np.roll(feet, -1, axis=0), strict=True):
        inwards = np.array([one[1] - other[1], other[0] - one[0]]) / np.linalg.norm(other - one)
        lever = np.hypot(knob[:, 2] - ground, (knob[:, :2] - one) @ inwards)
        restoring = mass * (down * ((centre[:, :2] - one) @ inwards) + gravity[:2] @ inwards * (centre[:, 2] - ground))
        tips = np.minimum(tips, restoring / lever)
        lacking = float((FACTOR * force_N * lever - restoring).max())
        gained = down * float((middle - one) @ inwards)  # N mm for each kg that is added
        added = max(added, lacking / gained if gained > 0.0 else inf)
    held = max(FOOT_FRICTION * down - aside, 0.0) / sqrt(1.0 + FOOT_FRICTION**2)  # N of sliding force for each kg
    added = max(added, FACTOR * force_N / held - mass if held > 0.0 else inf)
    k = int(tips.argmin())
    return Upset(max(float(tips[k]), 0.0), held * mass, positions_mm[k], added)
