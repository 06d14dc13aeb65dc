"""Whether a part that is brought in along straight legs meets what is there already.

The way is gone from the seat outwards. As far as two meshes are apart, so far a part goes on unseen: a translation
moves every point alike, so that nothing is passed over. Where meshes meet, as in every fit, discs that hold all that a
round part sweeps on the rest of its way prove at once that it is free, see `swept`; where they do not the exact solids
decide, `SLIDE_MM` a step; what is closer than `LEAST_MM` goes on by that. What slides along a plane and stays on one
side of it, to `_TOUCH_MM`, never meets what is on the other.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, Meshes
from delta_cad.checks.clearance.bodies import DistanceEngine, body
from delta_cad.checks.contact.features import features
from delta_cad.checks.contact.order.swept_bodies import PARALLEL, Span, common_with_discs, solid_extents
from delta_cad.checks.contact.placing import Key, relative_key
from delta_cad.checks.contact.shared_volume import SLIDING_MM3, runs_into
from delta_cad.common.vectors import cross, cross_length
from delta_cad.mechanism.placement import frames

LEAST_MM = 1.0  # of a step beside something that is closer
SLIDE_MM = 2.0  # of a step in a fit: its parts run into one another over their own lengths, if they do
_TOUCH_MM = 1e-6  # distance of meshes that counts as met
Leg = tuple[np.ndarray, float]
"""Unit vector of a part's motion towards its seat, and how long it goes on so, mm; infinite: from outside."""


@dataclass(frozen=True)
class Met:
    """What a part runs into on its way.

    Attributes:
        moving: Occurrence that moves.
        other: Occurrence that it runs into.
        out_mm: How far from its seat, along the way.
    """

    moving: str
    other: str
    out_mm: float


class Ways:
    """The parts of a machine where they sit at home, to be asked what one meets on its way there."""

    def __init__(self, assembly: Assembly, meshes: Meshes) -> None:
        self._of = {o.name: o for o in assembly.occurrences}
        self.frames = {name: np.asarray(frame) for name, frame in assembly.poses(assembly.home_mm).items()}
        self._meshes = meshes
        self._pieces = {frozenset((fit.a, fit.b)) for fit in assembly.fits if fit.kind == "piece"}
        self._engine = DistanceEngine()
        self._bodies = {
            part.number: body("", part.number, "", meshes[part.number], np.eye(4)) for part in assembly.parts
        }
        self._extents: dict[tuple[str, bytes], tuple[np.ndarray, np.ndarray]] = {}
        self._free: dict[Key, float | None] = {}

    def met(self, moving: Iterable[str], others: Iterable[str], legs: Sequence[Leg]) -> Met | None:
        """Looks for what parts that move together run into.

        Args:
            moving: Names of the occurrences that move.
            others: Names of those that are there.
            legs: In the order in which they are gone, the one that ends in the seat last.

        Returns:
            The first that is found; None where the way is free.
        """
        moving, others = list(moving), list(others)
        start, gone = np.zeros(3), 0.0
        for along, length in reversed(legs):
            out = -np.asarray(along, dtype=float)
            axes = _axes(out)
            seen = {name: self._box(name, axes) for name in (*moving, *others)}
            shift = axes @ start
            for a in moving:
                low, high = seen[a][0] + shift, seen[a][1] + shift
                for b in others:
                    other_low, other_high = seen[b]
                    if ((low[1:] >= other_high[1:] - _TOUCH_MM) | (high[1:] <= other_low[1:] + _TOUCH_MM)).any():
                        continue
                    begin, end = max(0.0, other_low[0] - high[0]), min(length, other_high[0] - low[0])
                    if begin < end and frozenset((a, b)) not in self._pieces:
                        at = self._met_between(a, b, start, out, begin, end)
                        if at is not None:
                            return Met(a, b, gone + at)
            start, gone = start + out * (length if np.isfinite(length) else 0.0), gone + length
        return None

    def _box(self, name: str, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest coordinates of an occurrence along three axes (rows), mm."""
        frame = self.frames[name]
        seen, at = axes @ frame[:3, :3], axes @ frame[:3, 3]
        key = self._of[name].part.number, np.round(seen, 9).tobytes()
        if key not in self._extents:
            mesh, (low, high) = self._mesh(name), solid_extents(self._of[name].part.solid).extents(seen)
            heights = mesh.vertices @ seen.T
            lowest, highest = heights.min(axis=0) - mesh.deviation_mm, heights.max(axis=0) + mesh.deviation_mm
            self._extents[key] = np.maximum(low, lowest), np.minimum(high, highest)
        low, high = self._extents[key]
        return at + low, at + high

    def _mesh(self, name: str) -> Mesh:
        return self._meshes[self._of[name].part.number]

    def _met_between(
        self, a: str, b: str, start: np.ndarray, out: np.ndarray, begin: float, end: float
    ) -> float | None:
        """Where, between two distances from the seat, one occurrence runs into another; None: nowhere."""
        inverse = np.linalg.inv(self.frames[b])
        first = self.frames[a].copy()
        first[:3, 3] += start
        seen = inverse @ first
        way = np.eye(4)
        way[:3, 3] = inverse[:3, :3] @ out
        parts = self._of[a].part, self._of[b].part
        key = (id(parts[0]), id(parts[1]), *relative_key("", "", seen), *relative_key("", "", way), round(end, 3))
        if key not in self._free:
            self._free[key] = self._advanced(a, b, seen, way[:3, 3], begin, end)
        return self._free[key]

    def _advanced(self, a: str, b: str, seen: np.ndarray, way: np.ndarray, begin: float, end: float) -> float | None:
        mesh_a, mesh_b = self._mesh(a), self._mesh(b)
        near = mesh_a.deviation_mm + mesh_b.deviation_mm
        at = max(begin, LEAST_MM)  # the seat itself is what all other checks look at
        is_required = False
        while at < end:
            frame = seen.copy()
            frame[:3, 3] += at * way
            apart, normal = self._closest(a, b, frame)
            if apart > _TOUCH_MM:
                # between two slabs across the line of the closest points nothing is met, however far the way goes
                gap = float((mesh_b.vertices @ normal).min() - (mesh_a.vertices @ (frame[:3, :3].T @ normal)).max())
                gap -= float(frame[:3, 3] @ normal) + near
                nearing = float(way @ normal)
                if gap > 0.0 and gap > nearing * (end - at):
                    return None
                at += max(apart - near, gap / nearing if nearing > 0.0 else 0.0, LEAST_MM)
                continue
            if not is_required and self._slides(a, b, seen, way, (at, end)):
                return None
            is_required = True
            if runs_into(self._of[b].part.solid, self._of[a].part.solid, frame):
                return at
            at += SLIDE_MM
        return None

    def _slides(self, a: str, b: str, seen: np.ndarray, way: np.ndarray, between: Span) -> bool:
        """Whether discs that hold all that the round one of two sweeps between two distances share no volume with one.

        Either may be the round one: seen from the part that comes in, the other one goes the other way.
        """
        back = np.linalg.inv(seen)
        moved = (a, b, back, back[:3, :3] @ way, between), (b, a, seen, -way, between)
        return any(self._leaves_room(*one) for one in moved)

    def _leaves_room(self, a: str, b: str, b_in_a: np.ndarray, way: np.ndarray, between: Span) -> bool:
        """Whether what `a` sweeps along a way in its own frame, as discs about an axis along it, leaves `b` alone."""
        part, other = self._of[a].part, self._of[b].part
        along = [c for c in features(part.solid).cylinders if cross_length(c.direction, way) < PARALLEL]
        outer = max((c for c in along if not c.is_hollow), key=lambda c: c.radius_mm, default=None)
        if outer is None:
            return False
        axis = frames(_axes(way)[1], way, outer.point)
        discs = solid_extents(part.solid).discs(axis, between)
        common = common_with_discs(discs, axis, other.solid, b_in_a, SLIDING_MM3)
        return common is not None and common <= SLIDING_MM3

    def _closest(self, a: str, b: str, a_in_b: np.ndarray) -> tuple[float, np.ndarray]:
        """Distance of two meshes, mm, and the (3,) direction from the first to the second where they are closest."""
        one, other = (self._bodies[self._of[name].part.number] for name in (a, b))
        apart, at_a, at_b = self._engine.closest_points(one, other, a_in_b, np.eye(4))
        there = at_b - at_a
        return apart, there / max(float(np.linalg.norm(there)), _TOUCH_MM)


def _axes(out: np.ndarray) -> np.ndarray:
    """(3, 3) rows: a direction, then two square to it, in a level plane and up where there is a choice."""
    aside = cross(np.array([0.0, 0.0, 1.0] if abs(out[2]) < 0.9 else [1.0, 0.0, 0.0]), out)
    aside /= np.linalg.norm(aside)
    return np.stack([out, aside, cross(out, aside)])
