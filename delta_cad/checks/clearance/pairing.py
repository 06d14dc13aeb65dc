"""The pairs of bodies that need clearance, the required distance, and the configuration space that proves each."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.bodies import CollisionBody, bodies_of, body, is_round, spun, turned_hull
from delta_cad.checks.clearance.configuration_spaces import (
    CELLS,
    ConfigurationSpace,
    Fixed,
    Pairs,
    ParallelRods,
    Swing,
    TwoSwings,
    X,
    Y,
    same_pieces,
)
from delta_cad.checks.clearance.handle import Handle
from delta_cad.checks.clearance.joint_ranges import JointRanges, Raster
from delta_cad.checks.clearance.rod_at_joint import RodAtJoint, SpringAtJoint
from delta_cad.checks.clearance.segments import cells_of, cut, near, segments_of
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import chain_of, fixed_frame, free_tilt, rigid_link, sway_of, swept_links
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.placement import CHAINS, LinkPlacement, chain_stand, chain_turn

_REACH_GUARD_MM = 0.01  # what is left away is farther than the limit by this much, far more than roundings
_SLICE_MM = 20.0  # of a rod beside the base: the travel over a slice is a sixth of that from elbow to wrist
_SOCKET_SLICE_MM = 2.0  # of sockets beside those of another chain: most slices stay within a ball about their wrist
_SOCKETS_MM = 20.0  # from the wrist on, where they are
_BY_ONE_JOINT = {
    ("base", "base"),
    ("base", "upper_arm"),
    ("platform", "rod"),
    ("platform", "swaying"),
}  # kinds of links
EQUAL_MM = 1e-7  # placements of the three chains come from the same numbers; 1e-7 is a thousand roundings
_CHAIN = np.eye(
    3
)  # what is near a joint is cut along the chain, whatever way round its part is: the same for all three

Chains = tuple[int, ...]
_Found = tuple[CollisionBody, CollisionBody, float, int]
"""Bodies of a pair on the links of a space, its limit, mm, and its chain."""


@dataclass(frozen=True)
class ClearancePair:
    """A pair of bodies on different links and the distance it must keep.

    Attributes:
        a: One body.
        b: The other, on another link.
        limit_mm: The distance.
        running_gap: Whether the limit is that of a `running gap` fit.
    """

    a: CollisionBody
    b: CollisionBody
    limit_mm: float
    running_gap: bool


def clearance_pairs(assembly: Assembly, limits: CheckLimits, meshes: Meshes) -> list[ClearancePair]:
    """All pairs on different links but the contacts.

    Args:
        assembly: The machine.
        limits: The general clearance.
        meshes: The parts' meshes.

    Returns:
        The pairs; parts of geared pinions as the bodies of revolution that they sweep, springs with all they stray.
        Beside what hangs on the same rods a spring is as it is drawn: its eyes are the rods', however these turn.
    """
    moved = [replace(o, link=rigid_link(o, assembly.placement)) for o in assembly.occurrences]
    sway = sway_of(assembly.placement, free_tilt(assembly))
    bodies = bodies_of(moved, meshes, swept_links(assembly.placement), sway)
    drawn = bodies_of((o for o in moved if o.link.startswith("spring")), meshes)
    fits = {frozenset((fit.a, fit.b)): fit for fit in assembly.fits}
    pairs = []
    for a, b in combinations(bodies.values(), 2):
        if a.link == b.link:
            continue
        fit = fits.get(frozenset((a.name, b.name)))
        if _on_one_pair(a, b):
            a, b = (drawn.get(x.name, x) for x in (a, b))
        if fit is None:
            pairs.append(ClearancePair(a, b, limits.clearance_min_mm, False))
        elif fit.kind == "running gap":
            pairs.append(ClearancePair(a, b, fit.gap_mm, True))
    return pairs


def by_several_joints(pair: ClearancePair, placement: LinkPlacement) -> bool:
    """Decides whether more than one joint moves two bodies against each other, so that the position matters."""
    fixed = {"base", *swept_links(placement)}
    one, other = sorted("base" if b.link in fixed else b.link for b in (pair.a, pair.b))
    if (one.rstrip("_012"), other.rstrip("_012")) in _BY_ONE_JOINT:
        return False
    return chain_of(one) != chain_of(other) or chain_of(one) < 0


def _on_one_pair(a: CollisionBody, b: CollisionBody) -> bool:
    """Whether both bodies are rods or springs of one chain."""
    return chain_of(a.link) == chain_of(b.link) and all(x.link.startswith(("rod", "spring", "swaying")) for x in (a, b))


def spaces_of(
    pairs: Sequence[ClearancePair], placement: LinkPlacement, ranges: JointRanges, limits: CheckLimits, tilt_rad: float
) -> list[ConfigurationSpace]:
    """Sorts pairs into the configuration spaces in which they are proven.

    Where the sockets leave the rods a tilt, each body of a rod counts at every turn of the rod about itself: as the
    body of revolution that it sweeps where it is round; otherwise within convex bodies that hold all turns of a slice
    each, or, beside the holder of its own ball, with the turn as a variable. There the lean takes its share of the
    tilt. A space covers the joint angles of those chains about which its pairs occur; of a three-fold symmetric machine
    all are taken as one that occurs about each.

    Args:
        pairs: The pairs.
        placement: The placement of the links.
        ranges: The joint angles over the cube.
        limits: The cube.
        tilt_rad: Free tilt of the rods' sockets, see `free_tilt`.

    Returns:
        The spaces with at least one pair each.
    """
    g = placement.geometry
    base, wrist = g.base_radius * MM_PER_M, g.platform_radius * MM_PER_M
    arm, forearm = g.upper_arm_length * MM_PER_M, g.forearm_length * MM_PER_M
    width = placement.parallelogram_width_mm
    groups: dict[tuple[str, int], list[_Found]] = defaultdict(list)
    moved = _Moved(swept_links(placement))
    for pair in pairs:
        kind, chain, a, b = _classified(pair, placement, moved)
        turn = tilt_rad and kind in ("handle", "rods")
        ones, others = (moved.turning(x, tilt_rad) if turn and x.link.startswith("rod") else [x] for x in (a, b))
        which = chain if kind == "arms" and not g.three_fold else 0  # which two arms, where that matters
        groups[kind, which] += [(one, other, pair.limit_mm, chain) for one, other in product(ones, others)]

    def over(angles: np.ndarray, chains: Chains) -> tuple[float, float]:
        low, high = angles[list(chains)].T
        return float(low.min()), float(high.max())

    def of(rasters: Sequence[Raster], chains: Chains) -> list[Raster]:
        return [rasters[i] for i in chains]

    def at_joint(name: str, p: Pairs, joint: tuple[np.ndarray, float], rasters: Sequence[Raster]) -> list[RodAtJoint]:
        spaces: list[RodAtJoint] = []
        for round_holders, q in _by_roundness(p, joint[0]):
            cut_up = _in_segments(q, *joint, width, bool(tilt_rad))
            reported = f"{name}, what is round" if round_holders else name
            turning = np.array([bool(tilt_rad) and not is_round(cut_up.bodies[k]) for k in cut_up.second], dtype=bool)
            if not turning.all():
                spaces.append(RodAtJoint(reported, cut_up.chosen(~turning), *joint, width, rasters, round_holders))
            if turning.any():
                turned = cut_up.chosen(turning).cut(_socket_in_cells)
                reported = f"{reported}, turning"
                spaces.append(RodAtJoint(reported, turned, *joint, width, rasters, round_holders, tilt_rad))
        return spaces

    made: dict[str, Callable[[Pairs, Chains], Sequence[ConfigurationSpace]]] = {
        "fixed": lambda p, _: [Fixed("fixed links", p, ("fixed",))],
        "swing": lambda p, c: [
            Swing("an arm and what is fixed (shoulder angle)", _arms_in_segments(p), base, over(ranges.theta, c))
        ],
        "arms": lambda p, c: [
            TwoSwings("two arms (shoulder angles)", p, base, of(ranges.neighbours, c), _next_stand(g, c[0]))
        ],
        "rods": lambda p, c: [ParallelRods("the rods of a chain (lean)", p, placement, over(ranges.lean, c))],
        "spring at wrist": lambda p, c: [
            SpringAtJoint("a spring and the platform", p, wrist * X, forearm, placement, of(ranges.at_wrist, c))
        ],
        "spring at elbow": lambda p, c: [
            SpringAtJoint("a spring and its arm", p, arm * X, 0.0, placement, of(ranges.at_elbow, c))
        ],
        "wrist": lambda p, c: at_joint("a rod and the platform", p, (wrist * X, forearm), of(ranges.at_wrist, c)),
        "elbow": lambda p, c: at_joint("a rod and its arm", p, (arm * X, 0.0), of(ranges.at_elbow, c)),
        "handle": lambda p, _: [
            Handle(
                "handle position",
                p.cut(
                    lambda b: _slices(b) if b.link.startswith("rod") else [b],
                    lambda a, b: "base" in (a.link, b.link),
                ).cut(
                    lambda b: _slices(b, _SOCKET_SLICE_MM),
                    lambda a, b: all(_at_wrist(x, forearm) for x in (a, b)),
                ),
                placement,
                limits.centre_mm,
                limits.half_side_mm,
                ranges.theta,
            )
        ],
    }
    kinds = [(make, found) for name, make in made.items() for (kind, _), found in groups.items() if kind == name]
    return [space for make, found in kinds for chains, p in _unique(found, g.three_fold) for space in make(p, chains)]


def _next_stand(g: DeltaGeometry, i: int) -> np.ndarray:
    """(4, 4) where chain i + 1 stands, seen from where chain i does, mm."""
    return np.linalg.inv(chain_stand(g, i)) @ chain_stand(g, (i + 1) % len(CHAINS))


def _classified(
    pair: ClearancePair, placement: LinkPlacement, moved: _Moved
) -> tuple[str, int, CollisionBody, CollisionBody]:
    """The space of a pair, its chain (of two the first; where none counts 0), its bodies on that space's links."""
    g = placement.geometry
    a, b = sorted((pair.a, pair.b), key=lambda x: x.link)
    fixed = [x.link == "base" or x.link in moved.swept for x in (a, b)]
    chain_a, chain_b = chain_of(a.link), chain_of(b.link)
    if all(fixed):
        one, other = (moved(x, "fixed", fixed_frame(x.link, placement)) for x in (a, b))
        return "fixed", 0, one, other
    if fixed[0] and b.link.startswith("upper_arm"):
        back = np.linalg.inv(chain_stand(g, chain_b))
        return "swing", chain_b, moved(a, "fixed", back @ fixed_frame(a.link, placement)), moved(b, "arm")
    if a.link.startswith("upper_arm") and b.link.startswith("upper_arm"):
        if (chain_a + 1) % len(CHAINS) != chain_b:
            a, b, chain_a = b, a, chain_b
        return "arms", chain_a, moved(a, "arm"), moved(b, "next_arm")
    if _on_one_pair(a, b):
        one, other = (moved(x, f"{x.link.split('_')[0]}_{x.link[-1]}") for x in (a, b))
        return "rods", chain_a, one, other
    if a.link == "platform" and b.link.startswith("swaying"):
        back = np.linalg.inv(chain_turn(g, chain_b))
        return "spring at wrist", chain_b, moved(a, "holder", back), moved(b, f"spring_{b.link[-1]}")
    if a.link.startswith("swaying") and b.link.startswith("upper_arm") and chain_a == chain_b:
        return "spring at elbow", chain_a, moved(b, "holder"), moved(a, f"spring_{a.link[-1]}")
    if a.link == "platform" and b.link.startswith("rod"):
        back = np.linalg.inv(chain_turn(g, chain_b))
        return "wrist", chain_b, moved(a, "holder", back), moved(b, f"rod_{b.link[-1]}")
    if a.link.startswith("rod") and b.link.startswith("upper_arm") and chain_a == chain_b:
        return "elbow", chain_a, moved(b, "holder"), moved(a, f"rod_{a.link[-1]}")
    return "handle", 0, a, b


class _Moved:
    """Bodies on other links, each made once."""

    def __init__(self, swept: Sequence[str]) -> None:
        self.swept = swept
        self._made: dict[tuple[int, str, bytes], CollisionBody] = {}  # by identity; the pairs keep them alive
        self._turning: dict[tuple[str, bytes], list[CollisionBody]] = {}
        self._turned: dict[int, list[CollisionBody]] = {}  # likewise

    def __call__(self, b: CollisionBody, link: str, frame: np.ndarray | None = None) -> CollisionBody:
        """The body on another link that holds its old one at `frame`, or is the same."""
        key = (id(b), link, b"" if frame is None else frame.tobytes())
        if key not in self._made:
            moved = replace(b, link=link) if frame is None else body(b.name, b.key, link, b.mesh, frame @ b.placement)
            self._made[key] = moved
        return self._made[key]

    def turning(self, b: CollisionBody, tilt_rad: float) -> list[CollisionBody]:
        """What holds a body of a rod while the rod turns about itself: of a long one that is not round each slice.

        A cup's hull that held its spigot as well would reach far beyond both.
        """
        key = b.key, b.placement.tobytes()
        if key not in self._turning:
            slices = [b] if is_round(b) else _slices(b)
            self._turning[key] = [spun(x) if is_round(x) else turned_hull(x, tilt_rad) for x in slices]
        if id(b) not in self._turned:
            self._turned[id(b)] = [replace(x, name=b.name, link=b.link) for x in self._turning[key]]
        return self._turned[id(b)]


def _unique(found: Sequence[_Found], alike: bool) -> Iterator[tuple[Chains, Pairs]]:
    """Pairs of bodies by index, those that are equal in shape, link and placement taken once at their larger limit.

    Args:
        found: Bodies, limit and chain of each pair.
        alike: Whether the chains stand alike: each pair then counts as one of all of them.

    Yields:
        The chains about which pairs occur, and these pairs.
    """
    bodies: list[CollisionBody] = []
    index: dict[tuple[object, ...], int] = {}
    limit: dict[tuple[int, int], float] = {}
    names: dict[tuple[int, int], tuple[str, str]] = {}
    chains: dict[tuple[int, int], set[int]] = defaultdict(set)
    known: dict[int, int] = {}  # by identity; what was found keeps the bodies alive

    def number(b: CollisionBody) -> int:
        if id(b) not in known:
            key = (b.key, b.link, *np.round(b.placement[:3] / EQUAL_MM).astype(np.int64).ravel().tolist())
            known[id(b)] = index.setdefault(key, len(bodies))
            if known[id(b)] == len(bodies):
                bodies.append(b)
        return known[id(b)]

    for a, b, gap, chain in found:
        pair = (number(a), number(b))
        limit[pair] = max(gap, limit.get(pair, gap))
        names.setdefault(pair, (a.name, b.name))
        chains[pair] |= set(CHAINS) if alike else {chain}
    of: dict[Chains, list[tuple[int, int]]] = defaultdict(list)
    for pair, about in chains.items():
        of[tuple(sorted(about))].append(pair)
    for about, pairs in of.items():
        used, held = np.unique(np.array(pairs), return_inverse=True)
        first, second = held.reshape(-1, 2).T
        gaps, named = np.array([limit[pair] for pair in pairs]), [names[pair] for pair in pairs]
        yield about, Pairs([bodies[k] for k in used.tolist()], first, second, gaps, named)


def _by_roundness(pairs: Pairs, centre_mm: np.ndarray) -> Iterator[tuple[bool, Pairs]]:
    """The pairs at a ball joint whose holders are not round about the line through the balls, and those that are.

    The round ones count as the bodies of revolution that hold them.
    """
    to_axis = np.eye(4)
    to_axis[:3, 3] = -centre_mm
    bodies = list(pairs.bodies)
    are_round = np.zeros(len(bodies), dtype=bool)
    for k in np.unique(pairs.first).tolist():
        if is_round(bodies[k], to_axis):
            are_round[k], bodies[k] = True, spun(bodies[k], to_axis)
    for wanted in (False, True):
        chosen = are_round[pairs.first] == wanted
        if chosen.any():
            yield wanted, replace(pairs, bodies=bodies).chosen(chosen)


def _in_segments(pairs: Pairs, centre_mm: np.ndarray, ball_mm: float, width_mm: float, turning: bool) -> Pairs:
    """The pairs at a ball joint, cut down to what can meet.

    The rods' bodies are cut into segments about the held ball, at x = `ball_mm` of the rod. A segment stays within its
    lever of the ball's centre however the rod is turned, so of the holder only what is within lever + limit counts.
    Of rods that turn about themselves what is round counts as its body of revolution.
    """

    def pieces_of(b: CollisionBody) -> Sequence[CollisionBody]:
        pieces = segments_of(b, ball_mm)
        return [spun(x) if is_round(x) else x for x in pieces] if turning else pieces

    equal: dict[tuple[str, str, bytes], Sequence[CollisionBody]] = {}
    segments = [same_pieces(b, pieces_of, equal) if b.link.startswith("rod") else [] for b in pairs.bodies]
    bodies: list[CollisionBody] = []
    index: dict[tuple[int, int], int] = {}
    reached: dict[tuple[int, str, float], int | None] = {}
    first, second, origin = [], [], []
    for k, (a, b) in enumerate(zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)):
        holder = pairs.bodies[a]
        for j, segment in enumerate(segments[b]):
            side = -0.5 if segment.link == "rod_0" else 0.5
            reach = segment.lever(ball_mm * X) + pairs.limit[k] + holder.mesh.deviation_mm + _REACH_GUARD_MM
            key = (a, segment.link, reach)
            if key not in reached:
                local = near(holder, centre_mm + side * width_mm * Y, reach, _CHAIN)
                reached[key] = None if local is None else len(bodies)
                bodies += [] if local is None else [local]
            if (b, j) not in index:
                index[b, j] = len(bodies)
                bodies.append(segment)
            held = reached[key]
            if held is not None:
                first.append(held)
                second.append(index[b, j])
                origin.append(k)
    names = [pairs.names[k] for k in origin]
    return Pairs(bodies, np.array(first, dtype=int), np.array(second, dtype=int), pairs.limit[origin], names)


def _arms_in_segments(pairs: Pairs) -> Pairs:
    """The pairs of an arm and what is fixed, the arm's bodies cut along the arm.

    What turns beside a cheek at a constant small gap, which its profile about the shoulder proves at once, is then
    apart from the elbow's boss, which reaches over the cheek's plane elsewhere.
    """
    return pairs.cut(lambda b: segments_of(b, 0.0) if b.link == "arm" else [b])


def _socket_in_cells(b: CollisionBody) -> list[CollisionBody]:
    """A body of a rod in cells: a socket reaches round its stud, so that what it nearly touches lies in its hull."""
    return cells_of(b, CELLS) if b.link.startswith("rod") else [b]


def _at_wrist(b: CollisionBody, forearm_mm: float) -> bool:
    """Whether a body is on a rod, and about its wrist."""
    return b.link.startswith("rod") and float(b.vertices[:, 0].min()) > forearm_mm - _SOCKETS_MM


def _slices(b: CollisionBody, size_mm: float = _SLICE_MM) -> list[CollisionBody]:
    """A rod's body cut across into equal slices: near a fold the elbow moves much more than the wrist."""
    x, plane = b.vertices[:, 0], b.placement[0, :3]
    levels = np.linspace(x.min(), x.max(), int(np.ptp(x) / size_mm) + 1, endpoint=False)[1:] - b.placement[0, 3]
    if not len(levels):
        return [b]
    slices, where = cut(b.mesh, plane, levels), np.round(b.placement, 7).tolist()
    return [
        body(b.name, f"{b.key} slice {k} of {size_mm:g} in {where}", b.link, mesh, b.placement)
        for k, mesh in enumerate(slices)
    ]
