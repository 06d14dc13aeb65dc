"""Limits on the machine, and the handle positions at which it is sampled."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import Cube
from delta_cad.mechanism.limits import Limits

SLICES = 5  # of the cube, from its floor to its top, in a map


@dataclass(frozen=True)
class CheckLimits:
    """The cube and the limits of all checks.

    Attributes:
        bottom_height_mm: Height of the cube's bottom face over the base plane.
        half_side_mm: Half the side of the cube.
        clearance_min_mm: Least distance of bodies on different links.
        envelope_width_mm: One side of the outline rectangle (W).
        envelope_depth_mm: Its other side (D); the machine may lie either way round.
        pose: Limits on every position of the cube, SI units.
        grid: Sampled positions along each edge of the cube.
        clearance_grid: The same where meshes are measured; a proof covers what lies between.
        random_poses: Number of seeded random positions besides the grid.
        seed: Seed of the random positions.
        centre_x_mm: How far the cube's middle stands off the base's axis, in the plane of symmetry.
    """

    bottom_height_mm: float
    half_side_mm: float
    envelope_width_mm: float
    envelope_depth_mm: float
    clearance_min_mm: float = 1.0
    pose: Limits = field(default_factory=Limits.of)
    grid: int = 11
    clearance_grid: int = 7
    random_poses: int = 200
    seed: int = 20180051
    centre_x_mm: float = 0.0

    @property
    def workspace(self) -> Cube:
        """The cube in metres."""
        return Cube(*(mm / MM_PER_M for mm in (self.bottom_height_mm, self.half_side_mm, self.centre_x_mm)))

    @property
    def centre_mm(self) -> np.ndarray:
        """(3,) centre of the cube in the base frame, mm."""
        return np.array([self.centre_x_mm, 0.0, self.bottom_height_mm + self.half_side_mm])

    @property
    def corners_mm(self) -> np.ndarray:
        """(8, 3) corners of the cube, mm."""
        signs = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T
        return self.centre_mm + self.half_side_mm * signs

    def poses_mm(self) -> np.ndarray:
        """(n, 3) corners first, then the grid, then the random positions, mm."""
        return self._positions(self.grid)

    def clearance_poses_mm(self) -> np.ndarray:
        """(n, 3) as `poses_mm`, on the grid where meshes are measured, mm."""
        return self._positions(self.clearance_grid)

    def slices_mm(self, cells: int) -> np.ndarray:
        """(SLICES, cells, cells, 3) positions of a map, along z, y and x, the cube's edges among them, mm."""
        x, z = (np.linspace(-self.half_side_mm, self.half_side_mm, n) for n in (cells, SLICES))
        at_z, at_y, at_x = np.meshgrid(z, x, x, indexing="ij")
        return self.centre_mm + np.stack([at_x, at_y, at_z], axis=-1)

    def _positions(self, count: int) -> np.ndarray:
        axis = np.linspace(-self.half_side_mm, self.half_side_mm, count)
        grid = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
        random = np.random.default_rng(self.seed).uniform(-self.half_side_mm, self.half_side_mm, (self.random_poses, 3))
        return np.concatenate([self.corners_mm, self.centre_mm + grid, self.centre_mm + random])
