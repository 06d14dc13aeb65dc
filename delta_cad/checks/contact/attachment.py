"""Every part of a link is held by its neighbours: nothing floats."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, MeshLibrary
from delta_cad.checks.clearance.bodies import CollisionBody, DistanceEngine, bodies_of
from delta_cad.checks.clearance.clearance import exact_distance
from delta_cad.checks.contact.placing import Key, gaps_on_one_link, relative_key
from delta_cad.checks.links import carried_by_link
from delta_cad.checks.report import CheckResult
from delta_cad.checks.solidity import ON_SURFACE_MM
from delta_cad.solids.part import Occurrence

SEAT_MM = 0.1  # above what is drawn between parts that hold one another: glue 0.05 of a diameter, threads 0.02
CHUNK = 256  # vertices of one part held against all of the other's at once: 20 MB


def check_attachment(assembly: Assembly, meshes: MeshLibrary) -> CheckResult:
    """Checks that the parts of every rigid link hang together, neighbours being parts within `SEAT_MM` of one another.

    Pieces that a part is drawn in hang on its other pieces, on whatever link, and are left out. What hangs on the
    dashboard hangs together by itself.

    Returns:
        `parts attached`: the largest distance, mm, at which a part that no chain of neighbours joins to the largest
        group of its link stands off the rest of the link; 0 where there is none.
    """
    links = {link: [o for o in carried if not o.part.piece_of] for link, carried in carried_by_link(assembly).items()}
    if assembly.dashboard:
        over = [o for o in links["base"] if o.name in assembly.dashboard]
        links |= {"base": [o for o in links["base"] if o not in over], "dashboard": over}
    bodies, neighbours = bodies_of(assembly.occurrences, meshes), _Neighbours()
    loose = [(gap, o, link) for link, carried in links.items() for gap, o in _floating(carried, bodies, neighbours)]
    floating = sorted(loose, key=lambda part: -part[0])
    detail = (
        f"{len(assembly.occurrences)} parts on {len(links)} links, each joined to its link by parts within "
        f"{SEAT_MM:g} mm of one another; {neighbours.exact} distances measured on the exact solids"
    )
    if not floating:
        return CheckResult("parts attached", True, 0.0, SEAT_MM, "mm", detail=detail)
    floaters = "; ".join(f"{o.name} is {gap:.3f} mm off the rest of {link}" for gap, o, link in floating[:8])
    names = tuple(o.name for _, o, _ in floating[:8])
    detail = f"{len(floating)} parts float: {floaters}; {detail}"
    return CheckResult("parts attached", False, floating[0][0], SEAT_MM, "mm", worst_pair=names, detail=detail)


def _floating(
    carried: Sequence[Occurrence], bodies: dict[str, CollisionBody], neighbours: _Neighbours
) -> list[tuple[float, Occurrence]]:
    """The parts outside the largest group of a link, with their group's distance from the nearest other part."""
    pairs = list(combinations(range(len(carried)), 2))
    if not pairs:
        return []
    of = [bodies[o.name] for o in carried]
    gap = gaps_on_one_link([(of[i], of[j]) for i, j in pairs])
    group = list(range(len(carried)))
    near = [pair for pair, apart in zip(pairs, gap.tolist(), strict=True) if apart <= SEAT_MM]
    unsure: list[tuple[int, int]] = []
    for exactly in (False, True):  # what the meshes decide first: then few exact distances are left to be needed
        for i, j in unsure if exactly else near:
            if group[i] == group[j]:
                continue
            touching = neighbours.touch(of[i], of[j], carried[i], carried[j], exactly)
            if touching is None:
                unsure.append((i, j))
            elif touching:
                group = [group[i] if g == group[j] else g for g in group]
    sizes = {g: group.count(g) for g in group}
    largest = max(sizes, key=lambda g: sizes[g])
    islands = []
    for g in sizes:
        if g == largest:
            continue
        alone = [i for i in range(len(carried)) if group[i] == g]
        others = [i for i in range(len(carried)) if group[i] != g]
        apart = min(neighbours.distance(of[i], of[j]) for i in alone for j in others)
        islands += [(apart, carried[i]) for i in alone]
    return islands


def _share_a_point(a: Mesh, b: Mesh, b_in_a: np.ndarray) -> bool:
    """Whether two vertices, which lie on the exact surfaces, are within `SEAT_MM`; `b_in_a` is a (4, 4) frame, mm."""
    near = SEAT_MM - 2.0 * ON_SURFACE_MM
    points = [a.vertices, b.vertices @ b_in_a[:3, :3].T + b_in_a[:3, 3]]
    for k in (0, 1):  # of each only what is within reach of the other's box
        other = points[1 - k]
        if not len(other):
            return False
        low, high = other.min(axis=0) - near, other.max(axis=0) + near
        points[k] = points[k][((points[k] >= low) & (points[k] <= high)).all(axis=1)]
    one, other = points
    squares = (((one[k : k + CHUNK, None] - other) ** 2).sum(axis=2) for k in range(0, len(one), CHUNK))
    return len(other) > 0 and any((square <= near**2).any() for square in squares)


class _Neighbours:
    """Whether two parts are within `SEAT_MM`, found once for equal parts in equal relative positions."""

    def __init__(self) -> None:
        self._engine = DistanceEngine()
        self._known: dict[Key, bool | None] = {}
        self.exact = 0

    def distance(self, a: CollisionBody, b: CollisionBody) -> float:
        """Distance of two meshes on one link, mm."""
        return self._engine.distance(a, b, a.placement, b.placement)

    def touch(
        self, a: CollisionBody, b: CollisionBody, one: Occurrence, other: Occurrence, exactly: bool
    ) -> bool | None:
        """Whether two bodies are neighbours; None if their meshes do not decide it and the solids are not used."""
        b_in_a = np.linalg.inv(a.placement) @ b.placement
        key = relative_key(a.key, b.key, b_in_a)
        if key not in self._known:
            apart = self._engine.distance(a, b, np.eye(4), b_in_a)
            unsure = a.mesh.deviation_mm + b.mesh.deviation_mm
            near = apart + unsure <= SEAT_MM
            decided = near or apart - unsure > SEAT_MM
            self._known[key] = near if decided else True if _share_a_point(a.mesh, b.mesh, b_in_a) else None
        if self._known[key] is None and exactly:
            self.exact += 1
            self._known[key] = exact_distance(one.part.solid, other.part.solid, b_in_a) <= SEAT_MM
        return self._known[key]
