"""Rows of the law table, checked as they are made: resistance, spring, constant force, home, walls.

The paper's settings of the resistance are here too. All rows are (12,) doubles as `laws` lays them out, with gain 1.
Damping is what is applied: what the loop and the mass allow is decided before, in the stability module.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism import Cube
from haptics.rendering.kernel import (
    ANCHOR,
    BLEND,
    COLUMNS,
    CONSTANT,
    DAMPING,
    FIRST,
    GAIN,
    HOME,
    KIND,
    KINDS,
    RESISTANCE,
    SECOND,
    SPRING,
    STIFFNESS,
    WALL,
)

RESISTANCE_BLEND = 1e-3
"""Way beyond r0 over which the damping of the resistance fades in, m; less than r1 - r0 of the paper's settings."""
WALL_BLEND = 0.5e-3
"""Depth over which the damping of a wall fades in, m: what a hand of 3 N reaches in a wall of 6 N/mm."""
AXES = {"x": 0, "y": 1, "z": 2}


class LawError(ValueError):
    """A force law that is refused; the message names field, value and what is allowed."""


class Resistance(NamedTuple):
    """A setting of the operating resistance, eq. (23).

    Attributes:
        stiffness: k, N/m.
        damping: b as asked for, N s/m.
        dead_radius: r0, m.
        full_radius: r1, m.
        source: Where it comes from.
    """

    stiffness: float
    damping: float
    dead_radius: float
    full_radius: float
    source: str

    @property
    def plateau(self) -> float:
        """K (r1 - r0): force at and beyond r1 at rest, N, before saturation."""
        return self.stiffness * (self.full_radius - self.dead_radius)

    def row(
        self, origin: ArrayLike = (0.0, 0.0, 0.0), *, damping: float | None = None, blend: float = RESISTANCE_BLEND
    ) -> np.ndarray:
        """Row of the law table.

        Args:
            origin: (3,) where the resistance is zero, base frame, m.
            damping: N s/m as applied; None: as asked for.
            blend: m.

        Returns:
            (12,) row.

        Raises:
            LawError: A figure is out of its bounds.
        """
        return resistance_row(
            stiffness=self.stiffness,
            damping=self.damping if damping is None else damping,
            dead_radius=self.dead_radius,
            full_radius=self.full_radius,
            origin=origin,
            blend=blend,
        )


PAPER_SETTINGS = {
    "k0.4": Resistance(400.0, 500.0, 1.5e-3, 10e-3, "[RCIM2018] eq. (23), first measured setting"),
    "k0.8": Resistance(800.0, 500.0, 1.5e-3, 5e-3, "[RCIM2018] eq. (23), second measured setting"),
}
"""The paper's two settings. They rise to 3.4 N and 2.8 N: of the first it is the 3 N limit that decides, by saturation.
At 1 kHz b = 500 N s/m is more than the sampled loop can hold; the damping applied is another figure."""


def resistance_row(
    *,
    stiffness: float,
    damping: float,
    dead_radius: float,
    full_radius: float,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    blend: float = RESISTANCE_BLEND,
) -> np.ndarray:
    """Operating resistance: nothing within r0, a spring to the origin up to r1, a constant pull beyond, and damping.

    Args:
        stiffness: k, N/m, at least 0.
        damping: b as applied, N s/m, at least 0.
        dead_radius: r0, m, at least 0.
        full_radius: r1, m, more than r0.
        origin: (3,) base frame, m.
        blend: Way beyond r0 over which the damping fades in, m, positive.

    Returns:
        (12,) row.

    Raises:
        LawError: A figure is out of its bounds.

    Source:
        [RCIM2018] eq. (23), with the damping faded in.
    """
    row = _row(RESISTANCE, _vector("origin", origin, "m"), stiffness, damping)
    row[FIRST] = _at_least_0("dead_radius", dead_radius, "m")
    row[SECOND] = _number("full_radius", full_radius, "m")
    if not full_radius > dead_radius:
        raise LawError(f"full_radius is {full_radius!r} m; it must be greater than dead_radius, {dead_radius!r} m")
    row[BLEND] = _positive("blend", blend, "m")
    return row


def spring_row(*, stiffness: float, damping: float, point: ArrayLike) -> np.ndarray:
    """Spring and damper to a point, everywhere.

    Args:
        stiffness: N/m, at least 0.
        damping: As applied, N s/m, at least 0.
        point: (3,) base frame, m.

    Returns:
        (12,) row.

    Raises:
        LawError: A figure is out of its bounds.
    """
    return _row(SPRING, _vector("point", point, "m"), stiffness, damping)


def constant_row(force: ArrayLike) -> np.ndarray:
    """The same force everywhere.

    Args:
        force: (3,) on the handle, base frame, N.

    Returns:
        (12,) row.

    Raises:
        LawError: The force is not three finite numbers.
    """
    return _row(CONSTANT, _vector("force", force, "N"), 0.0, 0.0)


def home_row(*, stiffness: float, damping: float, speed: float, origin: ArrayLike = (0.0, 0.0, 0.0)) -> np.ndarray:
    """Home function: brings the handle from anywhere to the origin, no faster than the speed limit.

    It is damping against the difference to a wanted velocity, `F = b (w - v)`, where w points home and is
    `min(k d / b, speed)`: a spring whose pull ends at `b speed`. A free mass never gets faster than the limit, or than
    it was: while |v| exceeds it, `m d|v|^2/dt = 2 b (w . v - |v|^2) < 0`. The pull must exceed the friction of the
    joints for the handle to arrive. Switch it on by its gain (`laws.fade`), then there is no step.

    Args:
        stiffness: k near the origin, N/m, positive.
        damping: b as applied, N s/m, positive.
        speed: Speed limit of the approach, m/s, positive.
        origin: (3,) base frame, m.

    Returns:
        (12,) row.

    Raises:
        LawError: A figure is out of its bounds.
    """
    row = _row(HOME, _vector("origin", origin, "m"), stiffness, damping)
    row[STIFFNESS] = _positive("stiffness", stiffness, "N/m")
    row[DAMPING] = _positive("damping", damping, "N s/m")
    row[FIRST] = _positive("speed", speed, "m/s")
    return row


def wall_row(
    *, stiffness: float, point: ArrayLike, normal: ArrayLike, damping: float = 0.0, blend: float = WALL_BLEND
) -> np.ndarray:
    """Virtual wall in any plane: pushes back along its normal, only while it is touched, and never pulls.

    Args:
        stiffness: K_e, N/m, at least 0.
        point: (3,) any point of the plane, base frame, m.
        normal: (3,) towards the free side; any length but 0.
        damping: As applied, N s/m, at least 0.
        blend: Depth over which the damping fades in, m, positive; so a touch-down at speed makes no step.

    Returns:
        (12,) row.

    Raises:
        LawError: A figure is out of its bounds.

    Source:
        [RCIM2018] eq. (24), with damping.
    """
    row = _row(WALL, _vector("point", point, "m"), stiffness, damping)
    n = _vector("normal", normal, "1")
    largest = float(np.abs(n).max())
    if largest == 0.0:
        raise LawError("normal is (0, 0, 0); it must have a direction")
    n = n / largest  # so that its squares neither vanish nor overflow
    row[FIRST : FIRST + 3] = n / np.sqrt(n @ n)
    row[BLEND] = _positive("blend", blend, "m")
    return row


def axis_wall_row(
    met: str, position: float, *, stiffness: float, damping: float = 0.0, blend: float = WALL_BLEND
) -> np.ndarray:
    """Virtual wall across an axis of the base frame.

    Args:
        met: Direction of motion that meets the wall: "+x", "-x", "+y", "-y", "+z" or "-z".
        position: Coordinate of its face along that axis, m.
        stiffness: N/m, at least 0.
        damping: As applied, N s/m, at least 0.
        blend: m, positive.

    Returns:
        (12,) row.

    Raises:
        LawError: A figure is out of its bounds, or the direction is none of the six.
    """
    if len(met) != 2 or met[0] not in "+-" or met[1] not in AXES:
        raise LawError(f'met is {met!r}; it must be "+x", "-x", "+y", "-y", "+z" or "-z"')
    axis = np.eye(3)[AXES[met[1]]]
    normal = -axis if met[0] == "+" else axis
    point = axis * _number("position", position, "m")
    return wall_row(stiffness=stiffness, damping=damping, point=point, normal=normal, blend=blend)


def cube_rows(cube: Cube, *, stiffness: float, damping: float = 0.0, blend: float = WALL_BLEND) -> np.ndarray:
    """Six walls around the cube workspace.

    Args:
        cube: Inside of it no wall is touched.
        stiffness: N/m, at least 0.
        damping: As applied, N s/m, at least 0.
        blend: m, positive.

    Returns:
        (6, 12) rows: +x, +y, +z, -x, -y, -z.

    Raises:
        LawError: A figure is out of its bounds, or the cube has no width: its walls would push against each other.
    """
    _positive("half_side", cube.half_side, "m")
    corners = (("+", cube.upper), ("-", cube.lower))
    return np.stack(
        [
            axis_wall_row(sign + axis, corner[k], stiffness=stiffness, damping=damping, blend=blend)
            for sign, corner in corners
            for axis, k in AXES.items()
        ]
    )


def law_table(*rows: ArrayLike) -> np.ndarray:
    """Puts rows together to the table that the kernel takes.

    Args:
        rows: Each (12,) or (n, 12); none for no force.

    Returns:
        (n, 12) table, contiguous.

    Raises:
        LawError: A row has another length or kind, holds a figure that is not finite, or a gain outside 0 to 1.
    """
    table = np.empty((0, COLUMNS))
    for given in rows:
        block = np.atleast_2d(np.asarray(given, dtype=float))
        if block.ndim != 2 or block.shape[1] != COLUMNS:
            raise LawError(f"a row of laws has the shape {np.shape(given)}; it must be ({COLUMNS},) or (n, {COLUMNS})")
        table = np.vstack([table, block])
    for i, row in enumerate(table):
        if not np.isfinite(row).all():
            raise LawError(f"law {i} holds {row[~np.isfinite(row)][0]!r}; its figures must be finite")
        if row[KIND] not in KINDS:
            raise LawError(f"law {i} is of kind {row[KIND]:g}; it must be one of {', '.join(map(str, KINDS))}")
        if not 0.0 <= row[GAIN] <= 1.0:
            raise LawError(f"law {i} has gain {row[GAIN]!r}; it must be between 0 and 1")
    return np.ascontiguousarray(table)


def _row(kind: int, anchor: np.ndarray, stiffness: float, damping: float) -> np.ndarray:
    row = np.zeros(COLUMNS)
    row[KIND], row[GAIN] = kind, 1.0
    row[ANCHOR : ANCHOR + 3] = anchor
    row[STIFFNESS] = _at_least_0("stiffness", stiffness, "N/m")
    row[DAMPING] = _at_least_0("damping", damping, "N s/m")
    return row


def _number(field: str, value: float, unit: str) -> float:
    if not math.isfinite(value):
        raise LawError(f"{field} is {value!r} {unit}; it must be finite")
    return float(value)


def _at_least_0(field: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value >= 0.0):
        raise LawError(f"{field} is {value!r} {unit}; it must be finite and not negative")
    return float(value)


def _positive(field: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise LawError(f"{field} is {value!r} {unit}; it must be finite and positive")
    return float(value)


def _vector(field: str, value: ArrayLike, unit: str) -> np.ndarray:
    array = np.asarray(value, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise LawError(f"{field} is {value!r}; it must be three finite numbers ({unit})")
    return array
