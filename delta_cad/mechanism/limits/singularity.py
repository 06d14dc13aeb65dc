"""Direct singularity: det S keeps one sign in the whole cube."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import at, scale
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import keep, store
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits.limit import FigureOfMerit, PoseLimit, Values, require
from delta_cad.mechanism.statics import direct_margin


def _determinant(limit: Singularity, g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    del limit
    return direct_margin(g, p)[..., None]


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes det S with the sign that it should have."""
    store(out, row, scale(k[n], at(pose, forms.DETERMINANT)))


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds det S >= 0: the platform above the elbows."""
    return keep(cuts, count, at(pose, forms.DETERMINANT))


@dataclass(frozen=True)
class Singularity(PoseLimit):
    """The sign of det S at the cube's centre must be that of every position."""

    name: ClassVar = "singularity"
    constraint: ClassVar = False
    keys: ClassVar = {"": "singularity"}
    figures: ClassVar = (FigureOfMerit("", "det S / L_B^3", "", 1.0, False, False, _determinant, "", (0.0, 0.0)),)
    tier: ClassVar = forms.FOREARMS
    rows: ClassVar = 1
    size: ClassVar = 1
    strict: ClassVar = True
    enclose: ClassVar = staticmethod(_enclose)
    cut: ClassVar = staticmethod(_cut)
    cuts: ClassVar = 1

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self:
        """Asks for one sign."""
        del values, strict
        return cls()

    def describe(self, values: Values) -> str:
        """Says what is asked."""
        del values
        return "no direct singularity in the cube"

    def numbers(self, g: DeltaGeometry | None, sign: float) -> tuple[float, ...]:
        """Gives the sign."""
        del g
        return (sign,)

    def second(self, pose: SlopePose, sign: float, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes det S with the sign that it should have."""
        return [pose.determinant.times(exact(sign))]

    def broken(self, g: DeltaGeometry, sign: float, point: np.ndarray) -> float:
        """Computes the determinant of unit forearms times the sign that it should have."""
        return float(sign * direct_margin(g, point))

    def told(self) -> float:
        """Gives the bound of the determinant."""
        return 0.0

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is asked."""
        del rounded
        return "det S of one sign"

    def record(self) -> dict[str, Any]:
        """Says that it is asked."""
        return {"singularity": True}

    @classmethod
    def from_record(cls, data: Any) -> Self | None:
        """Reads whether it is asked."""
        asked = data.get("singularity")
        require("singularity", asked, asked is None or isinstance(asked, bool), "true, false or null")
        return cls() if asked else None
