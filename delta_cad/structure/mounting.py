"""What the machine stands on: flexibility of plates and supports under the three foot blocks, tipping, sliding.

The plate is a thin plate (Kirchhoff) whose deflection is a polynomial in x and y (Rayleigh and Ritz). Its supports are
springs at points: the face that a screwed plate lies on is left out, and so is what a foot block adds to the plate
under it. A bench plate is such a plate, too, under the base plate's screws and on its pads. Against a solid model of
the plate, clamped in its mounting holes, the motion of a foot block is within 35 %.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf, pi
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, link_placement
from delta_cad.dimensions.platform import (
    BENCH_MATERIAL,
    MOUNT_SCREW,
    PAD_MM,
    BenchDimensions,
    edges,
    sliding_N_kg,
)
from delta_cad.structure.section import POISSON

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
        shares: "base plate", "supports" and, where there is one, "bench plate" -> (18, 18) their shares of the motion
            of the blocks by these wrenches.
        reactions: (n, 18) upright force of each support on the base plate for unit wrenches.
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
    stiff = {"base plate": plate.stiffness}
    if d.bench is not None:
        lower, on_pads = _bench(d.bench, b.centre_hole_mm), np.tile(_pad_N_mm(), len(d.bench.pads_mm))
        half, size, own = d.bench.thickness_mm / 2.0, len(plate.stiffness), len(lower.stiffness)
        top = lower.displacements(under.places_mm, np.full(len(under.places_mm), half))
        pads = lower.displacements(np.array(d.bench.pads_mm), np.full(len(d.bench.pads_mm), -half - PAD_MM[1]))
        held = np.concatenate([held, -top], axis=-1)
        loads = np.pad(loads, ((0, 0), (0, own)))
        stiff = {
            "base plate": np.pad(plate.stiffness, (0, own)),
            "bench plate": np.pad(lower.stiffness, (size, 0)),
        }
        grounded = np.pad(pads, ((0, 0), (0, 0), (size, 0))).reshape(-1, size + own)
        rows = np.concatenate([held.reshape(-1, size + own), grounded])
        springs = np.concatenate([springs, on_pads])
    else:
        rows = held.reshape(-1, held.shape[-1])
    stiff["supports"] = rows.T @ (springs[:, None] * rows)
    moved = np.linalg.solve(np.sum(list(stiff.values()), axis=0), loads.T)
    shares = {name: moved.T @ own @ moved for name, own in stiff.items()}
    return Mounting(blocks, shares, -under.axial_N_mm * held[:, 2] @ moved)


def _pad_N_mm() -> tuple[float, float, float]:
    """Stiffness of a pad along x, y and z."""
    axial, lateral = rubber_N_mm(*PAD_MM)
    return lateral, lateral, axial


def _bench(bench: BenchDimensions, hole_mm: float) -> _Plate:
    """The bench plate with its middle hole."""
    rims = tuple((x, y, 1.0) for x, y in bench.corners_mm(1.0))
    youngs = catalogue.material(BENCH_MATERIAL).youngs_modulus_Pa * 1e-6
    rigidity = youngs * bench.thickness_mm**3 / (12.0 * (1.0 - POISSON**2))
    return _Plate(rims, [(0.0, 0.0, hole_mm / 2.0)], rigidity)


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
        added_kg: Mass at the middle of the feet with which neither is less than the force that the machine is to bear;
            infinite where gravity does not press them on the table.
    """

    tips_N: float
    slides_N: float
    tips_mm: np.ndarray
    added_kg: float


def upset(d: Dimensions, bodies: Mapping[str, Any], positions_mm: np.ndarray, knob_mm: float, force_N: float) -> Upset:
    """Computes what tips and slides a machine that stands free, see `dimensions.platform.edges`.

    Args:
        d: Its dimensions.
        bodies: `bodies` of its mass report.
        positions_mm: (n, 3) of the platform.
        knob_mm: Height of the knob's centre over the wrists.
        force_N: Force at the handle that it is to bear.
    """
    gravity = np.array(d.design.requirements.gravity_m_s2)
    frames = link_placement(d)(positions_mm)
    mass, moment = 0.0, np.zeros((len(positions_mm), 3))
    for link, body in bodies.items():
        frame, own = np.broadcast_to(frames[link], (len(positions_mm), 4, 4)), float(body["mass_kg"])
        moment += own * (frame[:, :3, :3] @ (np.array(body["centre_m"]) * MM_PER_M) + frame[:, :3, 3])
        mass += own
    tips, added = np.full(len(positions_mm), np.inf), 0.0
    knob = positions_mm + np.array([0.0, 0.0, knob_mm])
    for held, lever, gained in edges(np.array(d.feet_mm), d.floor_mm, mass, moment / mass, knob, gravity):
        tips = np.minimum(tips, held / lever)
        lacking = float((force_N * lever - held).max())
        added = max(added, lacking / gained if gained > 0.0 else inf)
    slides = sliding_N_kg(gravity)
    added = max(added, force_N / slides - mass if slides > 0.0 else inf)
    k = int(tips.argmin())
    return Upset(max(float(tips[k]), 0.0), slides * mass, positions_mm[k], added)
