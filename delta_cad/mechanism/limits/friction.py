"""Friction at the handle, in the direction of most: of the joints and of the rods' ball joints, README (53)-(58)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    TERMS,
    TINY,
    UP,
    add,
    at,
    constant,
    inverse,
    multiply,
    put,
    scale,
    slope,
    subtract,
)
from delta_cad.mechanism.enclosure.interval import Interval, Slopes, exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose, Vector, middle_of
from delta_cad.mechanism.enclosure.table import HIGH, INSIDE, Enclosure, keep, store
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import elbow_arm, forearm_vectors
from delta_cad.mechanism.limits.limit import Field, FigureOfMerit, ThresholdLimit
from delta_cad.mechanism.limits.numbers import require

_RANGE = (1e-6, 1e6)
"""N: keeps every product of the proof far from underflow and overflow."""
SIGNS = np.array([(1.0, 1.0, 1.0), (1.0, 1.0, -1.0), (1.0, -1.0, 1.0), (1.0, -1.0, -1.0)])
"""(4, 3) senses in which the three joints may turn; the opposite ones rub alike."""
LEAST = 1e-12  # 1 / m; least of what is divided by where a part of a sum of rows vanishes
_EDGE = 2.0**-500  # keeps roots off 0, where the other arithmetic has none


class HandleFriction(NamedTuple):
    """Sources of the friction while the handle moves; the same for the three chains.

    Attributes:
        drive: Friction of a joint's drive, N m.
        upright: Bound of the ball joints' friction at the handle over the whole cube, for a motion along z, N.
        level: The same for any motion square to z, N.
    """

    drive: float
    upright: float
    level: float


def friction(g: DeltaGeometry, p: np.ndarray, sources: HandleFriction) -> np.ndarray:
    """Computes the friction at the handle in the direction of most, README (54).

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.
        sources: Friction of drives and ball joints.

    Returns:
        (...) N; infinite at a fold, NaN where a chain is open. With ball joints that rub it is a bound, for theirs
        are.
    """
    arm = g.upper_arm_length * elbow_arm(g, p)
    folded = np.asarray((arm == 0.0).any(axis=-1))
    rows = forearm_vectors(g, p) / np.where(arm == 0.0, 1.0, arm)[..., None]
    return np.where(folded, np.inf, worst_of_rows(rows, sources))


def worst_of_rows(rows: np.ndarray, sources: HandleFriction) -> np.ndarray:
    """Computes the friction in the direction of most from the joints' rates.

    Args:
        rows: (..., 3 chains, 3) rows of the inverse Jacobian, 1 / m.
        sources: Friction of drives and ball joints.

    Returns:
        (...) N.
    """
    sums = sources.drive * (SIGNS @ rows)  # (..., 4, 3)
    level = np.hypot(sums[..., 0], sums[..., 1]) + sources.level
    return np.hypot(np.abs(sums[..., 2]) + sources.upright, level).max(axis=-1)


@compiled
def signed_sum(rows, axis, sense):
    """Computes a component of the sum of three vectors, the first nine of some forms, with the signs of a sense."""
    second, third = at(rows, 3 + axis), at(rows, 6 + axis)
    if sense >= 2:
        second = scale(-1.0, second)
    if sense % 2 == 1:
        third = scale(-1.0, third)
    return add(at(rows, axis), add(second, third))


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes the square of the friction allowed less that of each sense in which the joints turn, README (55)."""
    allowed, drive, upright, level = k[n], k[n + 1], k[n + 2], k[n + 3]
    for i in range(3):
        lever = inverse(multiply(at(pose, forms.UPPER_ARM), at(pose, forms.W + i)))
        for axis in range(3):
            put(work, 3 * i + axis, multiply(at(pose, forms.FOREARM + 3 * i + axis), lever))
    left = constant(allowed**2 - upright**2 - level**2, ROUND * (allowed**2 + upright**2 + level**2) + TINY)
    along, aside, own = drive * upright, drive * level, drive * drive
    for sense in range(4):
        x, y, z = signed_sum(work, 0, sense), signed_sum(work, 1, sense), signed_sum(work, 2, sense)
        rx, ry, rz = slope(x) + x[TERMS - 1], slope(y) + y[TERMS - 1], slope(z) + z[TERMS - 1]
        flat = math.sqrt(x[0] * x[0] + y[0] * y[0])
        # 2 d <= d^2 / q + q for every q > 0: this one is the root of the mean of d^2 over the box, or near it
        qz = max(math.sqrt(z[0] * z[0] + rz * rz), LEAST)
        qh = max(math.sqrt(flat * flat + rx * rx + ry * ry), LEAST)
        by_z, by_h = own + along / qz, own + aside / qh
        dissipated = add(
            multiply(constant(by_z, 2.0 * ROUND * by_z), multiply(z, z)),
            multiply(constant(by_h, 2.0 * ROUND * by_h), add(multiply(x, x), multiply(y, y))),
        )
        more = along * qz + aside * qh
        dissipated = add(dissipated, constant(more, ROUND * more))
        store(out, row + sense, subtract(left, dissipated))
        slack = along * (abs(qz - abs(z[0])) + rz) ** 2 / qz + aside * (abs(qh - flat) + rx + ry) ** 2 / qh
        out[row + sense, HIGH] += (slack + ROUND * more) * forms.LIFT * UP


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds that the friction in the direction that is worst at the box's middle is allowed, times `L_A w_1 w_2 w_3`."""
    allowed, drive, upright, level = k[n], k[n + 1], k[n + 2], k[n + 3]
    w1, w2, w3 = pose[forms.W, 0], pose[forms.W + 1, 0], pose[forms.W + 2, 0]
    la = pose[forms.UPPER_ARM, 0]
    if not (w1 > 0.0 and w2 > 0.0 and w3 > 0.0 and la > 0.0):
        return count
    best, vx, vy, vz, second, third = -1.0, 0.0, 0.0, 0.0, 1.0, 1.0
    for sense in range(4):
        b, c = 1.0 if sense < 2 else -1.0, 1.0 if sense % 2 == 0 else -1.0
        f1, f2, f3 = drive / (la * w1), b * drive / (la * w2), c * drive / (la * w3)
        s = forms.FOREARM
        x = f1 * pose[s, 0] + f2 * pose[s + 3, 0] + f3 * pose[s + 6, 0]
        y = f1 * pose[s + 1, 0] + f2 * pose[s + 4, 0] + f3 * pose[s + 7, 0]
        z = f1 * pose[s + 2, 0] + f2 * pose[s + 5, 0] + f3 * pose[s + 8, 0]
        flat = math.sqrt(x * x + y * y)
        high, wide = abs(z) + upright, flat + level
        size = math.sqrt(high * high + wide * wide)
        if size > best:
            best, second, third = size, b, c
            wide, high = wide / size * INSIDE * INSIDE, high / size * INSIDE * INSIDE
            vx, vy = (wide * (x / flat), wide * (y / flat)) if flat > 0.0 else (wide, 0.0)
            vz = high if z >= 0.0 else -high
    left = allowed - upright * abs(vz) - level * math.sqrt(vx * vx + vy * vy)
    f1, f2, f3 = at(pose, forms.W), at(pose, forms.W + 1), at(pose, forms.W + 2)
    others = (multiply(f2, f3), scale(second, multiply(f1, f3)), scale(third, multiply(f1, f2)))
    error = 2.0 * ROUND * (allowed + upright + level)
    total = multiply(constant(left, error), multiply(at(pose, forms.UPPER_ARM), multiply(f1, others[0])))
    for i in range(3):
        s = forms.FOREARM + 3 * i
        along = add(add(scale(vx, at(pose, s)), scale(vy, at(pose, s + 1))), scale(vz, at(pose, s + 2)))
        total = subtract(total, scale(drive, multiply(along, others[i])))
    return keep(cuts, count, total)


@dataclass(frozen=True)
class Friction(ThresholdLimit):
    """Largest friction at the handle over all directions, N, with its sources."""

    friction_max: float
    drive: float
    upright: float
    level: float

    name: ClassVar = "friction"
    fields_: ClassVar = (Field("friction_max_N", "largest friction at the handle, in any direction", gt=0, le=100),)
    keys: ClassVar = {
        "friction_max": "friction_max_N",
        "drive": "joint_friction_N_m",
        "upright": "ball_friction_upright_N",
        "level": "ball_friction_level_N",
    }
    figures: ClassVar = (
        FigureOfMerit(
            "friction", "N", lambda limit, g, p: friction(g, p, limit.sources)[..., None], "friction_max", _RANGE
        ),
    )
    needs: ClassVar = "friction"
    needed: ClassVar = "what sources in the joints: rods for which there is a spring, or table [joints]"
    output_key: ClassVar = "max_friction_N"
    enclosure: ClassVar = Enclosure(forms.FOREARMS, 4, 4, _enclose, _cut, 1)

    def __post_init__(self) -> None:
        super().__post_init__()
        for name, value in zip(HandleFriction._fields, self.sources, strict=True):
            require(name, value, 0.0 <= value <= _RANGE[1], "within 0 and 1e6")

    @property
    def sources(self) -> HandleFriction:
        """Friction of drives and ball joints."""
        return HandleFriction(self.drive, self.upright, self.level)

    def numbers(self) -> tuple[float, ...]:
        """Gives the friction allowed and its sources."""
        return self.friction_max, *self.sources

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes the same margins as README (55), its q from the boxes' centres and widths."""
        allowed, drive, upright, level = (exact(x) for x in self.numbers())
        left = allowed.square() - upright.square() - level.square()
        margins = []
        for x, y, z in _sums(pose):
            squares = (z.square(), drive * upright), (x.square() + y.square(), drive * level)
            total: Slopes | None = None
            for square, mixed in squares:
                q = exactly(np.maximum(np.sqrt(np.abs(middle_of(square.box))), LEAST))
                part = square.times(-(drive.square() + mixed * q.inverse())).plus(-(mixed * q))
                total = part if total is None else total + part
            assert total is not None
            margins.append(total.plus(left))
        return margins

    def refuted_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> bool:
        """Shows a direction in which the friction at a position is more than allowed."""
        allowed, drive, upright, level = (exact(x) for x in self.numbers())
        for sums in _sums(pose):
            x, y, z = (middle_of(part.centre) for part in sums)
            turn, wide = np.arctan2(y, x), self.drive * np.hypot(x, y) + self.level
            high = self.drive * np.abs(z) + self.upright
            vx, vy, vz = (exactly(a) for a in (wide * np.cos(turn), wide * np.sin(turn), np.copysign(high, z)))
            flat = vx.square() + vy.square()
            size, aside = ((square + exactly(_EDGE**2)).root() for square in (flat + vz.square(), flat))
            along = sums[0].centre * vx + sums[1].centre * vy + sums[2].centre * vz
            felt = drive * along + upright * exactly(high) + level * (aside - exactly(_EDGE))  # aside: too long by EDGE
            if bool((felt - allowed * size).lo[0] > 0.0):
                return True
        return False

    def margin(self, f: Any) -> np.ndarray:
        """Computes what is allowed by the friction less 1; below -1 where a chain is open."""
        return self.friction_max * self.search_quantities(f)["inverse_friction"] - 1.0

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes 1 / friction; the closure where that is negative."""
        return {"inverse_friction": f.inverse_friction(self.sources)}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Computes the largest friction; infinite at a fold."""
        return 1.0 / least["inverse_friction"] if least["inverse_friction"] > 0.0 else math.inf

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is required, and of what machine."""
        drive, upright, level = (rounded(x, False) for x in self.sources)
        return (
            f"{super().words(rounded)} of joints of {drive} N m and ball joints of {upright} N upright, {level} N level"
        )

    def less_strict_than(self, than: Any) -> bool:
        """Compares the thresholds and the sources: less friction is another machine, and so less strict."""
        less = any(mine < other for mine, other in zip(self.sources, than.sources, strict=True))
        return less or super().less_strict_than(than)


def _sums(pose: SlopePose) -> list[Vector]:
    """The sums of the rows of the inverse Jacobian, for the four senses."""
    (a, b, c), found = pose.inverse_jacobian, []
    for second, third in SIGNS[:, 1:]:
        left = [a[k] + b[k] if second > 0.0 else a[k] - b[k] for k in range(3)]
        x, y, z = (left[k] + c[k] if third > 0.0 else left[k] - c[k] for k in range(3))
        found.append((x, y, z))
    return found
