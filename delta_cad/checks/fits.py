"""Bodies that may touch: parts on one link, and contacts across links, must not share volume.

The common volume is the kernel's boolean. Coincident faces (a screw in its hole, a bearing in its seat) are what
booleans get wrong, so a result is only believed when `volume(A) - volume(A cut B)` agrees with `volume(A common B)`;
otherwise fuzzy tolerances are tried one after another, and a pair that never agrees is a failure that says so.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from delta_cad.assembly import Assembly
from delta_cad.checks.bodies import Body, DistanceEngine, bodies_of, boxes_gap
from delta_cad.checks.kernel import located
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import rigid_link
from delta_cad.checks.pairing import EQUAL_MM
from delta_cad.checks.report import CheckResult
from delta_cad.part import Occurrence, Part
from delta_cad.tessellation import MeshLibrary

OVERLAP_MM3 = 0.01  # a 0.2 mm cube: above what booleans leave on coincident faces, below any real clash
FUZZY_MM = (0.0, 1e-5, 1e-4, 1e-3)  # from exact to a tenth of a fit; the first that agrees counts
AGREEMENT = 1e-6  # of the smaller solid's volume: Gauss integration of the kernel is good to about 1e-9


@dataclass(frozen=True)
class Touch:
    """Two occurrences to be tested for common volume.

    Attributes:
        a: One occurrence.
        b: The other.
        b_in_a: (4, 4) frame of part b in the frame of part a, mm.
        limit_mm3: Largest common volume.
        pose_mm: Handle position, for occurrences on different links.
    """

    a: Occurrence
    b: Occurrence
    b_in_a: np.ndarray
    limit_mm3: float
    pose_mm: tuple[float, float, float] | None = None


def check_fits(
    assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary, progress: Callable[[str], None] = lambda _: None
) -> list[CheckResult]:
    """Common volumes of parts on one link, and of contacts across links at the centre and the corners of the cube.

    Args:
        assembly: The machine.
        limits: The cube.
        meshes: The parts' meshes.
        progress: Told what is being done.

    Returns:
        `fits declared` (the names in fits exist), `overlap on one link`, `overlap of contacts`.
    """
    names = {o.name for o in assembly.occurrences}
    unknown = [f"{name} of {fit.a} / {fit.b}" for fit in assembly.fits for name in (fit.a, fit.b) if name not in names]
    unknown += [f"kind {fit.kind!r}" for fit in assembly.fits if fit.kind not in ("contact", "running gap")]
    detail = "not known: " + "; ".join(unknown) if unknown else f"{len(assembly.fits)} fits name parts that exist"
    declared = CheckResult("fits declared", not unknown, len(unknown), 0, "", detail=detail)
    if unknown:
        return [declared]
    progress("fits: common volumes")
    solver = _Overlaps(meshes)
    within = solver.worst("overlap on one link", _within_links(assembly, meshes))
    across = solver.worst("overlap of contacts", _across_links(assembly, limits))
    return [declared, within, across]


def _within_links(assembly: Assembly, meshes: MeshLibrary) -> list[Touch]:
    """Pairs on one link whose bounding boxes meet."""
    bodies = bodies_of(assembly.occurrences, meshes)
    allowed = {frozenset((f.a, f.b)): f.overlap_mm3 for f in assembly.fits if f.kind == "contact"}
    links: dict[str, list[Occurrence]] = defaultdict(list)
    for o in assembly.occurrences:
        links[rigid_link(o, assembly.placement)].append(o)
    found = []
    for group in links.values():
        pairs = list(combinations(group, 2))
        if not pairs:
            continue
        gap = _boxes_gap([(bodies[a.name], bodies[b.name]) for a, b in pairs])
        for (a, b), apart in zip(pairs, gap, strict=True):
            if apart <= 0.0:
                limit = max(OVERLAP_MM3, allowed.get(frozenset((a.name, b.name)), 0.0))
                found.append(Touch(a, b, np.linalg.inv(a.placement) @ b.placement, limit))
    return found


def _boxes_gap(pairs: list[tuple[Body, Body]]) -> np.ndarray:
    """(n,) lower bounds on the distances of bodies on one link, mm."""
    return boxes_gap(
        np.array([b.centre - a.centre for a, b in pairs]),
        np.array([a.axes for a, _ in pairs]),
        np.array([a.half for a, _ in pairs]),
        np.array([b.axes for _, b in pairs]),
        np.array([b.half for _, b in pairs]),
    )


def _across_links(assembly: Assembly, limits: CheckLimits) -> list[Touch]:
    """Contacts across links at the cube's centre and where the two parts are turned and tilted most from there."""
    poses = np.concatenate([limits.centre_mm[None], limits.corners_mm])
    links = assembly.placement(poses)
    occurrences = {o.name: o for o in assembly.occurrences}
    found = []
    for fit in assembly.fits:
        a, b = occurrences[fit.a], occurrences[fit.b]
        if fit.kind != "contact" or rigid_link(a, assembly.placement) == rigid_link(b, assembly.placement):
            continue
        relative = np.linalg.inv(links[a.link] @ a.placement) @ (links[b.link] @ b.placement)
        turn = np.trace(np.swapaxes(relative[:1, :3, :3], 1, 2) @ relative[:, :3, :3], axis1=1, axis2=2)
        tilt = relative[:, :3, 1] @ relative[0, :3, 1]
        for k in sorted({0, int(turn.argmin()), int(tilt.argmin())}):
            x, y, z = poses[k].tolist()
            found.append(Touch(a, b, relative[k], max(OVERLAP_MM3, fit.overlap_mm3), (x, y, z)))
    return found


class _Overlaps:
    """Common volumes, computed once for equal parts in equal relative positions."""

    def __init__(self, meshes: MeshLibrary) -> None:
        self._meshes, self._engine = meshes, DistanceEngine()
        self._known: dict[tuple[object, ...], float | None] = {}

    def worst(self, name: str, touches: list[Touch]) -> CheckResult:
        """The pair closest to or farthest over its limit."""
        before = len(self._known)
        volumes = [self._volume(t) for t in touches]
        excess = [np.inf if v is None else v - t.limit_mm3 for v, t in zip(volumes, touches, strict=True)]
        if not touches:
            return CheckResult(name, True, 0.0, OVERLAP_MM3, "mm^3", detail="no two parts are near each other")
        k = int(np.argmax(excess))
        t, v = touches[k], volumes[k]
        counted = f"{len(touches)} pairs with meeting bounding boxes, {len(self._known) - before} different ones"
        bad = [
            f"{touch.a.name} / {touch.b.name} " + ("(booleans disagree)" if volume is None else f"{volume:.3f} mm^3")
            for touch, volume, over in zip(touches, volumes, excess, strict=True)
            if over > 0.0
        ]
        detail = f"{len(bad)} overlap: {'; '.join(bad[:8])}; {counted}" if bad else f"largest common volume; {counted}"
        return CheckResult(name, not bad, v, t.limit_mm3, "mm^3", t.pose_mm, (t.a.name, t.b.name), detail)

    def _volume(self, t: Touch) -> float | None:
        """Common volume, mm^3; None where the kernel contradicts itself."""
        rounded = tuple(np.round(t.b_in_a[:3] / EQUAL_MM).astype(np.int64).ravel().tolist())
        key = (t.a.part.number, t.b.part.number, rounded)
        if key not in self._known:
            apart = self._certainly_apart(t.a.part, t.b.part, t.b_in_a)
            self._known[key] = 0.0 if apart else common_volume(t.a.part.solid, t.b.part.solid, t.b_in_a)
        return self._known[key]

    def _certainly_apart(self, a: Part, b: Part, b_in_a: np.ndarray) -> bool:
        """Whether the meshes are farther apart than their deviations, neither inside the other."""
        from delta_cad.checks.bodies import body
        from delta_cad.checks.containment import holds

        one = body(a.number, a.number, "", self._meshes[a.number], np.eye(4))
        other = body(b.number, b.number, "", self._meshes[b.number], np.eye(4))
        apart = self._engine.distance(one, other, np.eye(4), b_in_a)
        if apart <= one.mesh.deviation_mm + other.mesh.deviation_mm:
            return False
        return not holds(one.mesh, other.mesh, np.eye(4), b_in_a)


def common_volume(a: Any, b: Any, b_in_a: np.ndarray) -> float | None:
    """Volume that two solids share.

    Args:
        a: One `cadquery.Solid`.
        b: The other.
        b_in_a: (4, 4) frame of b in the frame of a, mm.

    Returns:
        Volume, mm^3; None where common and cut contradict each other at every fuzzy tolerance.
    """
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Common, BRepAlgoAPI_Cut

    one, other = a.wrapped, located(b, b_in_a)
    whole, smaller = _measure(one), min(_measure(one), _measure(other))
    for fuzzy in FUZZY_MM:
        common = _boolean(BRepAlgoAPI_Common(), one, other, fuzzy)
        rest = _boolean(BRepAlgoAPI_Cut(), one, other, fuzzy)
        if common is None or rest is None:
            continue
        # what the fuzzy tolerance itself may move is far below the limit on the volume
        if abs(whole - rest - common) <= max(AGREEMENT * smaller, OVERLAP_MM3 / 10.0):
            return max(common, 0.0)
    return None


def _boolean(operation: Any, a: Any, b: Any, fuzzy_mm: float) -> float | None:
    """Volume of a boolean's result, mm^3; None where it fails."""
    from OCP.TopTools import TopTools_ListOfShape

    arguments, tools = TopTools_ListOfShape(), TopTools_ListOfShape()
    arguments.Append(a)
    tools.Append(b)
    operation.SetArguments(arguments)
    operation.SetTools(tools)
    operation.SetNonDestructive(True)
    if fuzzy_mm:
        operation.SetFuzzyValue(fuzzy_mm)
    operation.Build()
    if not operation.IsDone() or operation.Shape() is None:
        return None
    return _measure(operation.Shape())


def _measure(shape: Any) -> float:
    """Volume of a shape, mm^3."""
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps

    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, properties)
    return float(properties.Mass())
