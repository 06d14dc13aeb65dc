"""What a page is about: a machine that was built, and what its checks came to."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.clearance import Near
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.export.views.views import Stage


@dataclass(frozen=True)
class Subject:
    """A machine and its checks.

    Attributes:
        dimensions: Of the design.
        assembly: The machine.
        meshes: Part number -> mesh, mm.
        masses: Result of `mass_report`.
        limits: The cube and what is asked of it.
        results: All checks.
        stage: Outline, the way round in which it fits best, and cube.
        reach_mm: (4,) bound on the swept outline along +x, -x, +y, -y; None where it has none.
        unverified: Numbers of the bought parts whose data are not all verified.
        near: What is closest over the cube, as `MeshClearance` tells it.
    """

    dimensions: Dimensions
    assembly: Assembly
    meshes: Meshes
    masses: Mapping[str, Any]
    limits: CheckLimits
    results: Sequence[CheckResult]
    stage: Stage
    reach_mm: np.ndarray | None
    unverified: tuple[str, ...] = ()
    near: Sequence[Near] = ()

    @property
    def design(self) -> Design:
        """The design that was built."""
        return self.dimensions.design

    @property
    def reachable(self) -> bool:
        """Whether every sampled position of the cube is within reach: figures over it have no meaning otherwise."""
        return all(result.passed for result in self.results if result.name == "reach")


def plain(value: Any, digits: int | None = None) -> Any:
    """Gives arrays and numbers as JSON types, rounded to significant digits where they are given; None for NaN."""
    if isinstance(value, Mapping):
        return {str(key): plain(one, digits) for key, one in value.items()}
    if isinstance(value, str | bool) or value is None:
        return value
    if isinstance(value, Sequence) or np.ndim(value):
        return [plain(one, digits) for one in value]
    if isinstance(value, int):
        return value
    number = float(value)
    if not np.isfinite(number):
        return None
    return number if digits is None else float(f"{number:.{digits}g}")
