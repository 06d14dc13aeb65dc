"""Assembly mode: det S > 0 in the whole cube, the platform above the elbows and no direct singularity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import at
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import enclosure_of
from delta_cad.mechanism.limits.limit import FigureOfMerit, PoseLimit
from delta_cad.mechanism.limits.numbers import require
from delta_cad.mechanism.statics import direct_margin


@compiled
def _margin(pose, k, n, i):
    """Computes det S."""
    return at(pose, forms.DETERMINANT)


@dataclass(frozen=True)
class AssemblyMode(PoseLimit):
    """The machine's own assembly, the one that forward kinematics returns: det S > 0 at every position.

    A mechanism of the same lengths whose platform hangs below its elbows has det S < 0; between the two lies a direct
    singularity, det S = 0.
    """

    name: ClassVar = "assembly_mode"
    keys: ClassVar = {"": "assembly_mode"}
    described: ClassVar = "assembly mode (det S > 0 in the whole cube: platform above the elbows)"
    figures: ClassVar = (
        FigureOfMerit(
            "",
            "",
            lambda _, g, p: direct_margin(g, p)[..., None],
            "",
            (0.0, 0.0),
            upper=False,
            relative=False,
            words="assembly mode, det S / L_B^3",
        ),
    )
    strict: ClassVar = True
    enclosure: ClassVar = enclosure_of(_margin, forms.FOREARMS, size=0, rows=1)

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes det S."""
        del exact
        return [pose.determinant]

    def margin(self, f: Any) -> np.ndarray:
        """Computes det S / L_B^3."""
        return f.determinant

    def record(self) -> dict[str, Any]:
        """Says that it is required."""
        return {"assembly_mode": True}

    @classmethod
    def from_record(cls, data: Any) -> Self | None:
        """Reads whether it is required."""
        stated = data.get("assembly_mode")
        require("assembly_mode", stated, stated is None or isinstance(stated, bool), "true, false or null")
        return cls() if stated else None
