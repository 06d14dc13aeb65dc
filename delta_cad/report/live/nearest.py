"""The two bodies that are closest at a position of the handle, as the report's map of the clearance has them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.pairing import by_several_joints, clearance_pairs
from delta_cad.checks.clearance.sampled import Sampler
from delta_cad.checks.limits import CheckLimits


@dataclass(frozen=True)
class Nearest:
    """Two bodies: their occurrences, their least distance, mm, and the (2, 3) points where it is, base frame, mm."""

    names: tuple[str, str]
    distance_mm: float
    ends_mm: np.ndarray


class Neighbours:
    """The bodies of a machine that more than one joint moves against each other."""

    def __init__(self, assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> None:
        self._placement, self._engine, self.limit_mm = assembly.placement, DistanceEngine(), limits.clearance_min_mm
        held = (pair for pair in clearance_pairs(assembly, limits, meshes) if not pair.running_gap)
        self._pairs = [pair for pair in held if by_several_joints(pair, assembly.placement)]

    def at(self, p_mm: np.ndarray) -> Nearest | None:
        """Finds the closest two at a position (3,), mm, rods as they are drawn; None where there are no two."""
        if not self._pairs:
            return None
        sampler = Sampler(self._placement, np.asarray(p_mm)[None, :], self._engine)
        (found,) = sampler.least(self._pairs)
        pair = found.pair
        self._pairs.remove(pair)
        self._pairs.insert(0, pair)  # most likely the closest at the next position, too
        frames = (sampler.frames[b.link][0] @ b.placement for b in (pair.a, pair.b))
        _, *ends = self._engine.closest_points(pair.a, pair.b, *frames)
        return Nearest((pair.a.name, pair.b.name), found.certain_mm, np.array(ends))
