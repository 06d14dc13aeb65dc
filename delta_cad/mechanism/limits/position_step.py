"""Position step: how far the handle may move unseen by the encoders, README (59)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, at, constant, multiply, put, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose, cross, norm2
from delta_cad.mechanism.enclosure.table import EXCLUDED, Enclosure, keep, store
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import elbow_arm, forearm_determinant, forearm_vectors
from delta_cad.mechanism.jacobian import forearm_faces
from delta_cad.mechanism.limits.friction import SIGNS, signed_sum
from delta_cad.mechanism.limits.limit import DEGREE, Field, FigureOfMerit, ThresholdLimit
from delta_cad.mechanism.limits.numbers import require

_RANGE = (1e-9, 1e3)
"""m: keeps every product of the proof far from underflow and overflow."""
_COUNTS = (1e-9, 10.0)
"""rad: likewise."""


def position_step(g: DeltaGeometry, p: np.ndarray, count: float) -> np.ndarray:
    """Computes how far apart two positions may be that all encoders read alike, README (59).

    Each joint may lie anywhere in its count, one wide: `|J q|` with every `|q_i| <= count`, largest in a corner.

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.
        count: Turn of a joint for one count of its encoder, rad.

    Returns:
        (...) m; infinite at a direct singularity, NaN where a chain is open.
    """
    s = forearm_vectors(g, p)
    moves = forearm_faces(s) * (g.upper_arm_length * elbow_arm(g, p))[..., None]
    det = np.abs(forearm_determinant(s))
    most = count * longest_sum(moves)
    return np.where(det == 0.0, np.inf, most / np.where(det == 0.0, 1.0, det))


def longest_sum(moves: np.ndarray) -> np.ndarray:
    """Computes the length of the longest sum of three vectors, each with either sign.

    Args:
        moves: (..., 3 chains, 3) vectors.

    Returns:
        (...) length.
    """
    sums = SIGNS @ moves
    return np.sqrt((sums * sums).sum(axis=-1)).max(axis=-1)


@compiled
def _margin(pose, k, n, work, sense):
    """Computes `(d / q)^2 det^2 - |sum +-L_A w_i s_j x s_k|^2` for one sense, README (59)."""
    det = at(pose, forms.DETERMINANT)
    left = multiply(constant(k[n], k[n + 1]), multiply(det, det))
    for axis in range(3):
        way = signed_sum(work, axis, sense)
        left = subtract(left, multiply(way, way))
    return left


@compiled
def _moves(pose, work):
    """Fills the first nine rows of the room to work in with L_A w_i s_j x s_k, x, y, z a chain."""
    for i in range(3):
        lever = multiply(at(pose, forms.UPPER_ARM), at(pose, forms.W + i))
        a, b = forms.FOREARM + 3 * ((i + 1) % 3), forms.FOREARM + 3 * ((i + 2) % 3)
        for x in range(3):
            y, z = (x + 1) % 3, (x + 2) % 3
            face = subtract(multiply(at(pose, a + y), at(pose, b + z)), multiply(at(pose, a + z), at(pose, b + y)))
            put(work, 3 * i + x, multiply(lever, face))


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes the margin of each sense."""
    _moves(pose, work)
    for sense in range(4):
        store(out, row + sense, _margin(pose, k, n, work, sense))


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds the margin of each sense; nothing is divided by what may vanish."""
    _moves(pose, work)
    for sense in range(4):
        count = keep(cuts, count, _margin(pose, k, n, work, sense))
        if count == EXCLUDED:
            return count
    return count


@dataclass(frozen=True)
class PositionStep(ThresholdLimit):
    """Largest way of the handle within one count of every encoder, m, with that count."""

    step_max: float
    count: float

    name: ClassVar = "position_step"
    fields_: ClassVar = (
        Field("position_step_max_mm", "largest movement of the handle that the encoders may miss", gt=0, le=5),
    )
    keys: ClassVar = {"step_max": "position_step_max_m", "count": "encoder_count_rad"}
    figures: ClassVar = (
        FigureOfMerit(
            "position_step", "mm", lambda limit, g, p: position_step(g, p, limit.count)[..., None], "step_max", _RANGE
        ),
    )
    needs: ClassVar = "encoder_count"
    needed: ClassVar = "the count of the encoders: state table [joints]"
    infinite_at_singularity: ClassVar = True
    output_key: ClassVar = "max_position_step_mm"
    enclosure: ClassVar = Enclosure(forms.FOREARMS, 2, 4, _enclose, _cut, 4)

    def __post_init__(self) -> None:
        super().__post_init__()
        require("count", self.count, _COUNTS[0] <= self.count <= _COUNTS[1], "within 1e-9 and 10 rad")

    def numbers(self) -> tuple[float, ...]:
        """Gives (d / q)^2 and its error, m^2."""
        ratio = self.step_max / self.count
        return ratio**2, ROUND * ratio**2

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes the same margins from the cross products themselves."""
        moves = []
        for i in range(3):
            lever = pose.arm[i].times(pose.upper_arm)
            moves.append([part * lever for part in cross(pose.forearm[i - 2], pose.forearm[i - 1])])
        allowed = pose.determinant.square().times((exact(self.step_max) * exact(self.count).inverse()).square())
        margins = []
        for signs in SIGNS:
            x, y, z = (
                moves[0][k] + moves[1][k].times(exact(signs[1])) + moves[2][k].times(exact(signs[2])) for k in range(3)
            )
            margins.append(allowed - norm2((x, y, z)))
        return margins

    def margin(self, f: Any) -> np.ndarray:
        """Computes det - (q / d) times the longest sum of moves: also refuses every direct singularity."""
        return f.determinant - self.count / self.step_max * f.scaled_step()

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes determinant, closure, and the step of a count of 1 rad with its sign turned."""
        floor = np.maximum(f.determinant, np.finfo(float).tiny)
        return {"determinant": f.determinant, "closure": f.closure, "step": -f.scaled_step() / floor}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Computes the largest step; infinite where a chain is open or the platform not held."""
        held = least["determinant"] > 0.0 and least["closure"] >= 0.0
        return -least["step"] * self.count if held else math.inf

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is required, and of what machine."""
        return f"{super().words(rounded)} for counts of {rounded(self.count * DEGREE, False)} deg"

    def less_strict_than(self, than: Any) -> bool:
        """Compares the thresholds, and the counts: a finer one is another machine, and so less strict."""
        return super().less_strict_than(than) or self.count < than.count
