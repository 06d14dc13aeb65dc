# ruff: noqa: ARG001
"""Height of the elbows, which a cover above the arms must leave room for."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import at, constant, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import enclosure_of
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import arm_direction
from delta_cad.mechanism.limits.limit import Field, FigureOfMerit, ThresholdLimit


def _heights(limit: ElbowHeight, g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    return g.upper_arm_length * arm_direction(g, p)[1]


@compiled
def _margin(pose, k, n, i):
    """Computes the height allowed less that of an elbow: the wrist's less the forearm's part along z."""
    height = subtract(at(pose, forms.Z), at(pose, forms.VERTICAL + i))
    return subtract(constant(k[n], 0.0), height)


@dataclass(frozen=True)
class ElbowHeight(ThresholdLimit):
    """Largest height of an elbow's centre above the base plane, m."""

    height_max: float

    name: ClassVar = "elbow_height"
    evaluates: ClassVar = ("angles",)
    fields_: ClassVar = (Field("elbow_height_max_mm", "largest height of an elbow above the base plane", gt=0),)
    keys: ClassVar = {"height_max": "elbow_height_max_m"}
    output_key: ClassVar = "max_elbow_height_mm"
    figures: ClassVar = (FigureOfMerit("elbow_height", "mm", _heights, "height_max", (1e-6, 10.0)),)
    enclosure: ClassVar = enclosure_of(_margin, forms.CHAINS, size=1)

    def numbers(self) -> tuple[float, ...]:
        """Gives the height allowed, m."""
        return (self.height_max,)

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes the height allowed less L_A sin(theta) of each chain."""
        return [sin.times(-pose.upper_arm).plus(exact(self.height_max)) for sin in pose.sin]

    def margin(self, f: Any) -> np.ndarray:
        """Computes the room above the highest elbow as a share of L_A."""
        return (self.height_max + self.search_quantities(f)["below"]) / f.designs[:, 0, None]

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes how far below the base plane the highest elbow is."""
        return {"below": -f.designs[:, 0, None] * np.sin(np.minimum(f.shoulder_max, np.pi / 2.0))}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Gives the height of the highest elbow."""
        return -least["below"]
