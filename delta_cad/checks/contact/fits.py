"""Bodies that may touch: parts on one link, and contacts across links, must not share volume.

A pair whose common volume the kernel cannot tell is a failure that says so.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine, bodies_of, body
from delta_cad.checks.clearance.containment import holds
from delta_cad.checks.contact.order.swept_bodies import common_with_discs, solid_extents
from delta_cad.checks.contact.placing import Key, gaps_on_one_link, relative_key
from delta_cad.checks.contact.poses import Turning, contact_positions
from delta_cad.checks.contact.shared_volume import NOISE_MM3, common_volume
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import carried_by_link
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Occurrence, Part

_TOUCH_MM = 1e-6  # of two flat faces upon one another: 0.01 mm^3 takes a square of 100 mm
OVERLAP_MM3 = 0.01  # a 0.2 mm cube: above what booleans leave on coincident faces, below any real clash


@dataclass(frozen=True)
class Touch:
    """Two occurrences to be tested for common volume.

    Attributes:
        a: One occurrence.
        b: The other.
        b_in_a: (4, 4) frame of part b in the frame of part a, mm.
        limit_mm3: Largest common volume.
        pose_mm: Handle position, for occurrences on different links that were placed by one.
        turning: The joint, where b stands there as one of the positions into which it turns.
    """

    a: Occurrence
    b: Occurrence
    b_in_a: np.ndarray
    limit_mm3: float
    pose_mm: tuple[float, float, float] | None = None
    turning: Turning | None = None


def check_fits(assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary) -> list[CheckResult]:
    """Bounds the common volumes of parts on one link, and of contacts across links over the range of their joints.

    Returns:
        `fits declared` (the names in fits exist), `overlap on one link`, `overlap of contacts`.
    """
    names = {o.name for o in assembly.occurrences}
    unknown = [f"{name} of {fit.a} / {fit.b}" for fit in assembly.fits for name in (fit.a, fit.b) if name not in names]
    unknown += [f"kind {fit.kind!r}" for fit in assembly.fits if fit.kind not in ("contact", "running gap", "piece")]
    drawn = {o.name: o.part.piece_of or o.part.number for o in assembly.occurrences}
    unknown += [
        f"{fit.a} / {fit.b} as pieces of one part"
        for fit in assembly.fits
        if fit.kind == "piece" and drawn.get(fit.a, fit.a) != drawn.get(fit.b, fit.b)
    ]
    detail = "not known: " + "; ".join(unknown) if unknown else f"{len(assembly.fits)} fits name parts that exist"
    declared = CheckResult("fits declared", not unknown, len(unknown), 0, "", detail=detail)
    if unknown:
        return [declared]
    solver = _Overlaps(meshes)
    within = solver.worst("overlap on one link", _within_links(assembly, meshes))
    across = solver.worst("overlap of contacts", _across_links(assembly, limits))
    return [declared, within, across]


def _within_links(assembly: Assembly, meshes: MeshLibrary) -> list[Touch]:
    """Pairs on one link whose bounding boxes meet."""
    bodies = bodies_of(assembly.occurrences, meshes)
    allowed = {frozenset((f.a, f.b)): f.overlap_mm3 for f in assembly.fits if f.kind == "contact"}
    touching = []
    for group in carried_by_link(assembly).values():
        pairs = list(combinations(group, 2))
        if not pairs:
            continue
        gap = gaps_on_one_link([(bodies[a.name], bodies[b.name]) for a, b in pairs])
        for (a, b), apart in zip(pairs, gap, strict=True):
            if apart <= 0.0:
                limit = max(OVERLAP_MM3, allowed.get(frozenset((a.name, b.name)), 0.0))
                touching.append(Touch(a, b, np.linalg.inv(a.placement) @ b.placement, limit))
    return touching


def _across_links(assembly: Assembly, limits: CheckLimits) -> list[Touch]:
    """Contacts across links, at the positions of `contact_positions`."""
    occurrences = {o.name: o for o in assembly.occurrences}
    positions = contact_positions(assembly, limits)
    most = [max(OVERLAP_MM3, c.fit.overlap_mm3) for c in positions]
    return [
        Touch(occurrences[c.fit.a], occurrences[c.fit.b], c.b_in_a, limit, c.pose_mm, c.turning)
        for c, limit in zip(positions, most, strict=True)
    ]


class _Overlaps:
    """Common volumes, computed once for equal parts in equal relative positions."""

    def __init__(self, meshes: MeshLibrary) -> None:
        self._meshes, self._engine = meshes, DistanceEngine()
        self._known: dict[Key, float | None] = {}
        self._turned: dict[Key, float | None] = {}

    def worst(self, name: str, touches: list[Touch]) -> CheckResult:
        """The pair closest to or farthest over its limit."""
        before = len(self._known) + len(self._turned)
        volumes = [self._volume(t) for t in touches]
        excess = [np.inf if v is None else v - t.limit_mm3 for v, t in zip(volumes, touches, strict=True)]
        if not touches:
            return CheckResult(name, True, 0.0, OVERLAP_MM3, "mm^3", detail="no two parts are near each other")
        k = int(np.argmax(excess))
        t, v = touches[k], volumes[k]
        different = len(self._known) + len(self._turned) - before
        counted = f"{len(touches)} pairs with meeting bounding boxes, {different} different ones"
        bad = [
            f"{touch.a.name} / {touch.b.name} " + ("(booleans disagree)" if volume is None else f"{volume:.3f} mm^3")
            for touch, volume, over in zip(touches, volumes, excess, strict=True)
            if over > 0.0
        ]
        detail = f"{len(bad)} overlap: {'; '.join(bad[:8])}; {counted}" if bad else f"largest common volume; {counted}"
        return CheckResult(name, not bad, v, t.limit_mm3, "mm^3", t.pose_mm, (t.a.name, t.b.name), detail)

    def _volume(self, t: Touch) -> float | None:
        """Common volume, mm^3; None where the kernel contradicts itself."""
        a, b = t.a.part, t.b.part
        if t.turning is not None and (most := self._at_any_turn(a, b, t.turning)) is not None and most <= t.limit_mm3:
            return most
        key = relative_key(a.number, b.number, t.b_in_a)
        if key not in self._known and self._certainly_apart(a, b, t.b_in_a):
            self._known[key] = 0.0
        if key not in self._known:
            self._known[key] = common_volume(a.solid, b.solid, t.b_in_a)
        return self._known[key]

    def _at_any_turn(self, a: Part, b: Part, turning: Turning) -> float | None:
        """Bound on the common volume however the two turn about their joint, mm^3; None where the kernel finds none."""
        key = (*relative_key(a.number, b.number, turning.in_a), *relative_key("", "", turning.in_b))
        if key not in self._turned:
            back = None if turning.range_rad is None else (-turning.range_rad[1], -turning.range_rad[0])
            most = self._about(a, turning.in_a, b, turning.in_b, turning.range_rad)
            if most is None or most > OVERLAP_MM3:
                other = self._about(b, turning.in_b, a, turning.in_a, back)
                most = min((v for v in (most, other) if v is not None), default=None)
            self._turned[key] = most
        return self._turned[key]

    def _about(
        self,
        turned: Part,
        joint: np.ndarray,
        other: Part,
        joint_there: np.ndarray,
        range_rad: tuple[float, float] | None,
    ) -> float | None:
        """Volume of a part within the discs that hold what of another one comes to its angles about the joint."""
        between = None if range_rad is None else solid_extents(other.solid).angles(joint_there)
        if between is not None and range_rad is not None:
            between = (between[0] + range_rad[0], between[1] + range_rad[1])
        discs = solid_extents(turned.solid).discs(joint, within_rad=between)
        return common_with_discs(discs, joint, other.solid, joint @ np.linalg.inv(joint_there), NOISE_MM3)

    def _certainly_apart(self, a: Part, b: Part, b_in_a: np.ndarray) -> bool:
        """Whether a face of a box about one has the other beyond it, or the meshes are apart, neither in the other."""
        axes = np.concatenate([np.eye(3), b_in_a[:3, :3].T])
        low, high = solid_extents(a.solid).extents(axes)
        low_b, high_b = (x + axes @ b_in_a[:3, 3] for x in solid_extents(b.solid).extents(axes @ b_in_a[:3, :3]))
        if max((low_b - high).max(), (low - high_b).max()) >= -_TOUCH_MM:
            return True
        one = body(a.number, a.number, "", self._meshes[a.number], np.eye(4))
        other = body(b.number, b.number, "", self._meshes[b.number], np.eye(4))
        apart = self._engine.distance(one, other, np.eye(4), b_in_a)
        if apart <= one.mesh.deviation_mm + other.mesh.deviation_mm:
            return False
        return not holds(one.mesh, other.mesh, np.eye(4), b_in_a)
