"""Lean of the rods out of their chain's plane, which their ball joints must allow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    add,
    at,
    constant,
    lower,
    multiply,
    scale,
    subtract,
    upper,
)
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import HIGH, LOW, Enclosure, store
from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.inverse import rod_lean
from delta_cad.mechanism.limits.lengths.outline import OUTWARDS
from delta_cad.mechanism.limits.limit import DesignBounds, Field, FigureOfMerit, ThresholdLimit
from delta_cad.mechanism.limits.numbers import cosine_sine, require

_RANGE = (0.0, math.nextafter(math.pi / 2.0, 0.0))


def _share(side_cosine: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """The sine s of chain 1's azimuth, and s + |c|: t is `c y - s x`, at most `s |x_c| + (s + |c|) L`, L or more."""
    c = np.asarray(side_cosine)
    s = np.sqrt((1.0 - c) * (1.0 + c))
    return s, s + np.abs(c)


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes L_B sin(lean_max) - |t| of each chain; linear but for t's sign."""
    room = multiply(at(pose, forms.FOREARM_LENGTH), constant(k[n], k[n + 1]))
    for i in range(3):
        t = at(pose, forms.T + i)
        side = -1.0 if t[0] > 0.0 else 1.0
        store(out, row + i, add(room, scale(side, t)))
        out[row + i, LOW] = min(out[row + i, LOW], lower(subtract(room, scale(side, t))))
        out[row + i, HIGH] = min(out[row + i, HIGH], upper(room))


@dataclass(frozen=True)
class Lean(ThresholdLimit):
    """Largest lean of a rod out of its chain's plane either way, rad."""

    lean_max: float

    name: ClassVar = "lean"
    fields_: ClassVar = (Field("lean_max_deg", "largest lean of a rod", gt=0, lt=90),)
    keys: ClassVar = {"lean_max": "lean_max_rad"}
    figures: ClassVar = (
        FigureOfMerit("lean", "deg", lambda _, g, p: np.abs(rod_lean(g, p)), "lean_max", _RANGE, relative=False),
    )
    enclosure: ClassVar = Enclosure(forms.COORDINATES, 2, 3, _enclose)

    def __post_init__(self) -> None:
        require("lean_max", self.lean_max, 0.0 < self.lean_max < math.pi / 2.0, "within 0 and pi/2 rad")

    def numbers(self) -> tuple[float, ...]:
        """Gives sin(lean_max) and its error."""
        return cosine_sine(self.lean_max, self.lean_max)[1], ROUND

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes L_B sin(lean_max) -+ t."""
        _, sine = cosine_sine(self.lean_max, self.lean_max)
        room = pose.rounded(sine) * pose.forearm_length
        return [t.times(exact(side)).plus(room) for t in pose.t for side in (1.0, -1.0)]

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes sin(lean_max) - t / L_B at the worst corner of the cube, for chains 1 and 2."""
        _, c, centre = lengths_mm[6:]
        s, sideways = _share(c)
        return math.sin(self.lean_max) - (sideways * lengths_mm[5] + s * np.abs(centre)) / lengths_mm[1]

    def design_bounds(self) -> DesignBounds:
        """Gives the shortest forearm for a cube."""
        sideways = float(_share(THREE_FOLD)[1])
        return DesignBounds(forearm_per_half_side_min=sideways / math.sin(self.lean_max) * (1.0 - OUTWARDS))
