"""The cube workspace: its points, and the extremes of every figure of merit over it, README (21)-(22)."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism.errors import GeometryError
from delta_cad.mechanism.geometry import LENGTH_MAX, DeltaGeometry
from delta_cad.mechanism.inverse import (
    arm_direction,
    closure_margin,
    forearm_angle,
    joint_angles,
    require_closed,
    rod_lean,
)
from delta_cad.mechanism.statics import conditioning, direct_margin, serial_margin, singular_values, worst_joint_torque

# The polish halves the grid's step so often: where a figure is smooth, its error falls with the square of the step.
HALVINGS = 22
# Values within this share are one extreme, which symmetry puts at several places: rounding, different on every machine,
# must not choose. Named is the place first in order of x, y, z, rounded to so many decimals of a metre.
_TIE, _PLACES = 1e-9, 9
_CROSSING_STEPS = 60  # Bisections between two points of opposite determinant: more than a double can resolve.


@dataclass(frozen=True)
class Cube:
    """Cube workspace with sides along the base frame's axes: x in [x_c - L, x_c + L], y in [-L, L], z in [H, H + 2 L].

    Attributes:
        bottom_height: H, height of the bottom face above the base plane, m.
        half_side: L, half the side, m; 0 is the single point in the centre of the bottom face.
        centre_x: x_c, how far the cube's middle stands off the base's axis, in the plane of symmetry, m.

    Raises:
        GeometryError: A length is not finite or out of its bounds.
    """

    bottom_height: float
    half_side: float
    centre_x: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 < self.bottom_height <= LENGTH_MAX:
            bound = f"it must be greater than 0 and at most {LENGTH_MAX:g} m"
            raise GeometryError(f"bottom_height is {self.bottom_height!r} m; {bound}")
        if not 0.0 <= self.half_side <= LENGTH_MAX:
            raise GeometryError(
                f"half_side is {self.half_side!r} m; it must be at least 0 and at most {LENGTH_MAX:g} m"
            )
        if not abs(self.centre_x) <= LENGTH_MAX:
            raise GeometryError(
                f"centre_x is {self.centre_x!r} m; it must be within {-LENGTH_MAX:g} and {LENGTH_MAX:g} m"
            )

    @property
    def lower(self) -> np.ndarray:
        """(3,) corner of the smallest coordinates, m."""
        return np.array([self.centre_x - self.half_side, -self.half_side, self.bottom_height])

    @property
    def upper(self) -> np.ndarray:
        """(3,) corner of the largest coordinates, m."""
        return np.array([self.centre_x + self.half_side, self.half_side, self.bottom_height + 2.0 * self.half_side])

    @property
    def centre(self) -> np.ndarray:
        """(3,) middle of the cube, m."""
        return np.array([self.centre_x, 0.0, self.bottom_height + self.half_side])


def cube_grid(cube: Cube, n: int) -> np.ndarray:
    """Gives the points of an even grid over the volume, faces and corners included.

    Args:
        cube: The cube.
        n: Points along an edge, at least 2.

    Returns:
        (n^3, 3) positions, m, z running fastest.

    Raises:
        GeometryError: n is less than 2.
    """
    if n < 2:
        raise GeometryError(f"n is {n} points along an edge; it must be at least 2")
    axes = [np.linspace(a, b, n) for a, b in zip(cube.lower, cube.upper, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def cube_surface(cube: Cube, n: int) -> np.ndarray:
    """Gives the points of the even grid that lie on the six faces, each once.

    Args:
        cube: The cube.
        n: Points along an edge, at least 2.

    Returns:
        (6 n^2 - 12 n + 8, 3) positions, m.

    Raises:
        GeometryError: n is less than 2.
    """
    return cube_grid(cube, n)[_on_surface(n)]


@lru_cache(maxsize=8)
def _on_surface(n: int) -> np.ndarray:
    index = np.indices((n, n, n)).reshape(3, -1)
    return ((index == 0) | (index == n - 1)).any(axis=0)


class Extreme(NamedTuple):
    """An extreme value over the cube and the position (x, y, z) in m where it occurs."""

    value: float
    position: tuple[float, float, float]


class CubeExtremes:
    """Extremes over the cube and over the three chains; sampled and polished, not a proof.

    Each is searched for at its first use.

    Attributes:
        shoulder_min: Smallest shoulder angle, rad.
        shoulder_max: Largest shoulder angle, rad.
        lean_max: Largest lean of a rod either way, rad.
        forearm_angle_min: Smallest angle between upper arm and forearm, rad.
        forearm_angle_max: Largest angle between upper arm and forearm, rad.
        torque_max: Largest joint torque over all directions of the force, N m; infinite if singular.
        kappa_max: Largest condition number; infinite if singular.
        singular_value_min: Smallest singular value of J, m/rad.
        singular_value_max: Largest singular value of J, m/rad; infinite if singular.
        closure_margin_min: Smallest closure margin w^2, m^2.
        serial_margin_min: Smallest distance to a fold, w / L_B.
        direct_margin_min: Smallest determinant of the forearm directions; positive when the platform is above the
            elbows in the whole cube.
        elbow_z_min: Lowest elbow centre, m.
        elbow_z_max: Highest elbow centre, m.
    """

    def __init__(self, g: DeltaGeometry, cube: Cube, force: float, n: int) -> None:
        self._of, self._search = (g, force), CubeSearch(cube, n)
        self.direct_margin_min, crossing = self._search.singularity(g)
        if crossing is not None:
            self.torque_max = self.kappa_max = self.singular_value_max = Extreme(math.inf, crossing)

    def __getattr__(self, name: str) -> Extreme:
        """Searches for a figure of merit, once."""
        if name.startswith("_"):
            raise AttributeError(name)
        known = _figures(*self._of)
        if name not in known:
            raise AttributeError(name)
        found = vars(self)[name] = self._search(*known[name])
        return found


_Figure = Callable[[np.ndarray], np.ndarray]


@lru_cache(maxsize=64)
def cube_extremes(g: DeltaGeometry, cube: Cube, force: float, n: int = 41) -> CubeExtremes:
    """Searches for the extremes of the figures of merit over the cube: a grid, then a local search inside the cube.

    The grid is the surface, where the extremes lie, README (21), and a coarse one inside. From the best point of
    each face a compass search over 26 neighbours, kept inside the cube, halves its step down to 2^-22 of the
    grid's. What was found last is kept: dimensions, checks and tables ask for the same machine.

    Args:
        g: The mechanism.
        cube: The cube.
        force: Magnitude of the force on the handle, N.
        n: Grid points along an edge, at least 2.

    Returns:
        The extremes and where they occur.

    Raises:
        UnreachableError: A chain cannot be closed in a point of the cube; the message names chain and point.
        GeometryError: n is less than 2.
    """
    return CubeExtremes(g, cube, force, n)


def _figures(g: DeltaGeometry, force: float) -> dict[str, tuple[_Figure, float]]:
    """Field of `CubeExtremes` -> figure of the worst chain, and the sign that makes its extreme a minimum."""

    def least(of: Callable[[DeltaGeometry, np.ndarray], np.ndarray]) -> tuple[_Figure, float]:
        return lambda p: of(g, p).min(axis=-1), +1.0

    def most(of: Callable[[DeltaGeometry, np.ndarray], np.ndarray]) -> tuple[_Figure, float]:
        return lambda p: of(g, p).max(axis=-1), -1.0

    def elbow_z(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
        return g.upper_arm_length * arm_direction(g, p)[1]

    return {
        "shoulder_min": least(joint_angles),
        "shoulder_max": most(joint_angles),
        "lean_max": most(lambda g, p: np.abs(rod_lean(g, p))),
        "forearm_angle_min": least(forearm_angle),
        "forearm_angle_max": most(forearm_angle),
        "torque_max": most(lambda g, p: worst_joint_torque(g, p, force)),
        "kappa_max": (lambda p: conditioning(g, p), -1.0),
        "singular_value_min": least(singular_values),
        "singular_value_max": most(singular_values),
        "closure_margin_min": least(closure_margin),
        "serial_margin_min": least(serial_margin),
        "elbow_z_min": least(elbow_z),
        "elbow_z_max": most(elbow_z),
    }


class CubeSearch:
    """Search for the extremes of figures over one cube: the surface, a coarse grid inside, then a compass search.

    Args:
        cube: The cube.
        n: Grid points along an edge, at least 2.
    """

    def __init__(self, cube: Cube, n: int = 41) -> None:
        self.cube, self.n = cube, n
        self.points = np.concatenate([cube_surface(cube, n), cube_grid(cube, max(2, (n + 3) // 4))])
        at_ends = (*(self.points == cube.lower).T, *(self.points == cube.upper).T)
        self._faces = [np.flatnonzero(face) for face in at_ends]

    def __call__(self, figure: _Figure, sign: float) -> Extreme:
        """Finds the smallest value of a figure, or for a sign of -1 the largest, polished inside the cube.

        Args:
            figure: (n, 3) positions in m -> (n,) values; NaN counts as no extreme.
            sign: +1 for the smallest, -1 for the largest.
        """

        def cost(p: np.ndarray) -> np.ndarray:
            values = sign * figure(p)
            return np.where(np.isnan(values), np.inf, values)

        cube, points, n = self.cube, self.points, self.n
        lower, upper = cube.lower, cube.upper
        costs = cost(points)
        starts = [int(np.argmin(costs))]
        starts += [int(face[np.argmin(costs[face])]) for face in self._faces]
        best, best_cost = points[starts], costs[starts]
        offsets = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
        step = 2.0 * cube.half_side / (n - 1)
        rows = np.arange(len(best))
        for _ in range(HALVINGS):
            # twice a step: a search that moves on has the grid's own error to make up at most
            for _ in range(2):
                around = np.clip(best[:, None, :] + step * offsets, lower, upper)
                around_costs = cost(around)
                chosen = np.argmin(around_costs, axis=1)
                better = around_costs[rows, chosen] < best_cost
                if not better.any():
                    break
                best = np.where(better[:, None], around[rows, chosen], best)
                best_cost = np.where(better, around_costs[rows, chosen], best_cost)
            step /= 2.0
        least = float(best_cost.min())
        equal = np.flatnonzero(best_cost <= least + _TIE * abs(least)) if np.isfinite(least) else [0]
        x, y, z = min((best[i].tolist() for i in equal), key=lambda p: np.round(p, _PLACES).tolist())
        return Extreme(float(sign * least), (x, y, z))

    def singularity(self, g: DeltaGeometry) -> tuple[Extreme, tuple[float, float, float] | None]:
        """Searches the cube for a direct singularity, between the smallest and the largest determinant of the forearms.

        Returns:
            The smallest determinant of the unit forearms; the position of the singularity, m, or None where the
            determinant keeps its sign.

        Raises:
            UnreachableError: A chain cannot be closed in a point of the cube; the message names chain and point.
        """
        closure = self(lambda p: closure_margin(g, p).min(axis=-1), +1.0)
        require_closed(g, np.array([closure.position]))
        lowest = self(lambda p: direct_margin(g, p), +1.0)
        if lowest.value > 0.0 or (highest := self(lambda p: direct_margin(g, p), -1.0)).value < 0.0:
            return lowest, None
        a, b = np.array(lowest.position), np.array(highest.position)
        for _ in range(_CROSSING_STEPS):
            middle = (a + b) / 2.0
            if direct_margin(g, middle) <= 0.0:
                a = middle
            else:
                b = middle
        return lowest, (float(a[0]), float(a[1]), float(a[2]))
