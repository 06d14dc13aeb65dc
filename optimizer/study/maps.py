"""Maps of the condition number and of the worst joint torque over slices of the cube."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import Cube, DeltaGeometry, SingularError, cube_surface
from delta_cad.mechanism.inverse import require_closed
from delta_cad.mechanism.statics import conditioning, direct_margin, worst_joint_torque

GRID = 121  # points along an edge of a map; odd, so that the cube's middle is one of them
_SURFACE = 21  # points along an edge of the surface on which a cube is looked at before it is mapped
_MARGIN = 0.2  # margin around the cube that a map shows, as a part of the half side


def require_held(g: DeltaGeometry, cube: Cube) -> None:
    """Refuses a cube that has no maps.

    Raises:
        UnreachableError: A chain cannot be closed in a point of the cube's surface.
        SingularError: The platform is not above the elbows in the whole surface.
    """
    p = cube_surface(cube, _SURFACE)
    require_closed(g, p)
    if not (direct_margin(g, p) > 0.0).all():
        raise SingularError("the platform is not above the elbows in the whole cube")


class Slice(NamedTuple):
    """Two maps over one plane through the cube.

    Attributes:
        title: Which plane.
        axes: Names of the two coordinates.
        across: (n,) first coordinate, m.
        up: (n,) second coordinate, m.
        kappa: (n, n) condition number, rows along `up`; NaN where a chain cannot be closed or the platform is not
            above the elbows.
        torque: (n, n) largest joint torque over all directions of the force, N m; NaN likewise.
        outline: (left, right, lower, upper) sides of the cube in this plane, m.
    """

    title: str
    axes: tuple[str, str]
    across: np.ndarray
    up: np.ndarray
    kappa: np.ndarray
    torque: np.ndarray
    outline: tuple[float, float, float, float]

    @property
    def inside(self) -> np.ndarray:
        """(n, n) whether a point of the map is one of the cube, its edges included."""
        left, right, lower, upper = self.outline
        x, y = np.meshgrid(self.across, self.up)
        return (x >= left) & (x <= right) & (y >= lower) & (y <= upper)

    def worst(self, values: np.ndarray) -> tuple[float, float, float]:
        """Finds the largest value inside the cube, and where: value, first and second coordinate in m."""
        row, column = np.unravel_index(int(np.nanargmax(np.where(self.inside, values, np.nan))), values.shape)
        return float(values[row, column]), float(self.across[column]), float(self.up[row])


def slices(g: DeltaGeometry, cube: Cube, force: float, n: int = GRID) -> list[Slice]:
    """Computes the maps of the cube's bottom, middle and top plane, and of its mirror plane.

    Args:
        g: The mechanism.
        cube: Its cube.
        force: Magnitude of the force on the handle, N.
        n: Points along an edge of the cube.

    Returns:
        The four slices, each reaching a fifth of the half side beyond the cube.
    """
    (left, front, low), (right, back, high) = cube.lower.tolist(), cube.upper.tolist()
    line, rise, depth = _axis(left, right, n), _axis(low, high, n), _axis(front, back, n)
    x, y = np.meshgrid(line, depth)
    planes = []
    for name, z in (("bottom", low), ("middle", float(cube.centre[2])), ("top", high)):
        p = np.stack([x, y, np.full_like(x, z)], axis=-1)
        title, sides = f"{name}, z = {MM_PER_M * z:.1f} mm", (left, right, front, back)
        planes.append(_slice(g, p, force, title, ("x", "y"), line, depth, sides))
    across, up = np.meshgrid(line, rise)
    p = np.stack([across, np.zeros_like(across), up], axis=-1)
    sides = (left, right, low, high)
    planes.append(_slice(g, p, force, "side, y = 0", ("x", "z"), line, rise, sides))
    return planes


def _axis(low: float, high: float, n: int) -> np.ndarray:
    """Computes even steps from edge to edge, both among them to the last bit, and as many more as the margin takes."""
    further = np.arange(1, round(_MARGIN * (n - 1) / 2.0) + 1) * (high - low) / (n - 1)
    return np.concatenate([low - further[::-1], np.linspace(low, high, n), high + further])


def _slice(
    g: DeltaGeometry,
    p: np.ndarray,
    force: float,
    title: str,
    axes: tuple[str, str],
    across: np.ndarray,
    up: np.ndarray,
    outline: tuple[float, float, float, float],
) -> Slice:
    with np.errstate(invalid="ignore"):  # NaN where a chain cannot be closed
        above = direct_margin(g, p) > 0.0
        kappa = np.where(above, conditioning(g, p), np.nan)
        torque = np.where(above, worst_joint_torque(g, p, force).max(axis=-1), np.nan)
    return Slice(title, axes, across, up, kappa, torque, outline)
