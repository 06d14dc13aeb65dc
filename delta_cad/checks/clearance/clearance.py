"""Clearance of bodies on different links over the whole cube: proven, found where it is smallest, measured exactly."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.branch_and_bound import CALLS_MAX, ClearanceProof, prove
from delta_cad.checks.clearance.configuration_spaces import ConfigurationSpace
from delta_cad.checks.clearance.containment import holds
from delta_cad.checks.clearance.handle import Handle
from delta_cad.checks.clearance.joint_ranges import FoldError, joint_ranges
from delta_cad.checks.clearance.pairing import ClearancePair, by_several_joints, clearance_pairs, spaces_of
from delta_cad.checks.clearance.sampled import PairSample, Sampler
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import free_tilt, swept_links
from delta_cad.checks.report import CheckResult

_NEAREST = 16  # pairs in which the smallest distance is looked for: those of all three chains, five kinds
PROVING = "clearance: proof over the cube"  # as the progress tells it
MAP_CELLS = 5  # positions along an edge of a map: what is nearest changes by tenths of a millimetre between two
_EXACT_SAMPLES = 8  # kinds of pairs re-measured on the exact solids, 10-100 ms each
_EXACT_MM = 1e-4  # BRepExtrema stops at 1e-7 mm on analytic surfaces and at about this on trimmed ones


@dataclass(frozen=True)
class _CloseSample:
    """One of the closest samples, as it takes to measure it on the exact solids.

    Attributes:
        names: Occurrences of both bodies.
        frames: Frames of both links in the base frame, (4, 4) mm.
        pose_mm: Handle position.
        distance_mm: Distance of the meshes.
        allowed_mm: By how much the exact distance may differ: the deviations of both meshes, and the kernel's own.
        swept: Whether one of them is a body of revolution, of a pinion or a spring: that may be closer, never farther.
    """

    names: tuple[str, str]
    frames: tuple[np.ndarray, np.ndarray]
    pose_mm: tuple[float, float, float]
    distance_mm: float
    allowed_mm: float
    swept: bool


@dataclass(frozen=True)
class Near:
    """The two bodies that are closest at a position: their occurrences, and their least distance, mm."""

    names: tuple[str, str]
    distance_mm: float


@dataclass(frozen=True)
class MeshClearance:
    """What the meshes alone tell of the clearance over the cube.

    Attributes:
        results: As of `mesh_clearance`.
        closest: The samples with the least to spare, one for each two parts.
        over: What is closest at each of `slices_mm(MAP_CELLS)`, in that order, of bodies that more than one joint moves
            against each other; empty where it was not asked or no two are there.
    """

    results: list[CheckResult]
    closest: list[_CloseSample]
    over: list[Near] = field(default_factory=list)


def mesh_clearance(
    assembly: Assembly,
    limits: CheckLimits,
    meshes: Meshes,
    progress: Callable[[str], None] = lambda _: None,
    calls_max: int = CALLS_MAX,
    mapped: bool = False,
    handle: Callable[[], list[ClearanceProof]] | None = None,
) -> MeshClearance:
    """Computes the clearance over the cube from meshes.

    Args:
        assembly: The machine.
        limits: The cube and the clearance.
        meshes: The parts' meshes.
        progress: Told what is being done.
        calls_max: Distance calls that the proof may spend on one space of variables.
        mapped: Whether what is closest over the cube is computed, too.
        handle: Gives what `handle_proofs` does, where another process computes it meanwhile: a machine that fails is
            then sampled no farther than one that passes, where the proof came closest.

    Returns:
        `clearance` (smallest sampled distance: of the pairs that the proof measured closest, or of all where the proof
        fails), one `running gap a / b` for each such fit, `containment` and `clearance proof`.
    """
    pairs, tilt = clearance_pairs(assembly, limits, meshes), free_tilt(assembly)
    progress(PROVING)
    engine = DistanceEngine()
    proofs, refusal = _proofs(assembly, limits, pairs, tilt, engine, calls_max, lambda s: not handle or not _handle(s))
    sampler = Sampler(assembly.placement, limits.clearance_poses_mm(), engine, tilt)
    progress("clearance: running gaps")
    gaps = [s for p in pairs if p.running_gap for s in sampler.closest([p])]
    proofs += handle() if handle else []
    proven = not refusal and not any(p.undecided for p in proofs)
    before = engine.calls
    ordinary = [p for p in pairs if not p.running_gap]
    few = proven or handle is not None
    progress("clearance: closest pairs" if few else "clearance: sampling")
    closest = sampler.closest(_nearest(ordinary, proofs) if few else ordinary, is_sorted=few)
    results = [_sampled("clearance", closest, limits.clearance_min_mm, sampler, engine.calls - before)]
    results += [
        _sampled(f"running gap {s.pair.a.name} / {s.pair.b.name}", [s], s.pair.limit_mm, sampler, 0) for s in gaps
    ]
    results.append(_containment(_contained(pairs, sampler)))
    refuted = [s for s in (*closest, *gaps) if s.certain_mm < s.pair.limit_mm]
    counts = f"{sum(p.boxes for p in proofs)} boxes, {sum(p.calls for p in proofs)} distance calls, {len(pairs)} pairs"
    if refusal:
        refused = CheckResult("clearance proof", False, None, limits.clearance_min_mm, "mm", detail=refusal)
        results.append(refused)
    else:
        results.append(_proof(limits.clearance_min_mm, proofs, refuted, closest, counts))
    over: list[Near] = []
    if mapped:
        progress("clearance: map")
        several = [p for p in _by_margin(ordinary, proofs) if by_several_joints(p, assembly.placement)]
        positions = limits.slices_mm(MAP_CELLS).reshape(-1, 3)
        least = Sampler(assembly.placement, positions, engine, tilt).least(several) if several else []
        over = [Near((s.pair.a.name, s.pair.b.name), s.certain_mm) for s in least]
    return MeshClearance(results, _tightest(assembly, [*closest, *gaps], sampler), over)


def _proofs(
    assembly: Assembly,
    limits: CheckLimits,
    pairs: Sequence[ClearancePair],
    tilt_rad: float,
    engine: DistanceEngine,
    calls_max: int,
    chosen: Callable[[ConfigurationSpace], bool],
) -> tuple[list[ClearanceProof], str]:
    """The proofs of the spaces that are chosen, and why there are none."""
    try:
        ranges = joint_ranges(assembly.placement.geometry, limits.centre_mm, limits.half_side_mm)
    except FoldError as error:
        return [], str(error)
    spaces = spaces_of(pairs, assembly.placement, ranges, limits, tilt_rad)
    return [prove(space, engine, calls_max) for space in spaces if chosen(space)], ""


def _handle(space: ConfigurationSpace) -> bool:
    return isinstance(space, Handle)


def handle_proofs(assembly: Assembly, limits: CheckLimits, meshes: Meshes, calls_max: int) -> list[ClearanceProof]:
    """Proves the clearance of what all three joints move against each other; arguments as of `mesh_clearance`."""
    pairs, tilt = clearance_pairs(assembly, limits, meshes), free_tilt(assembly)
    return _proofs(assembly, limits, pairs, tilt, DistanceEngine(), calls_max, _handle)[0]


def _nearest(pairs: Sequence[ClearancePair], proofs: Sequence[ClearanceProof]) -> list[ClearancePair]:
    """The pairs that the proofs measured closest to their limits; all where they measured none."""
    measured = {frozenset(names) for p in proofs for names in p.closest}
    return _by_margin([p for p in pairs if frozenset((p.a.name, p.b.name)) in measured], proofs)[:_NEAREST] or list(
        pairs
    )


def _by_margin(pairs: Sequence[ClearancePair], proofs: Sequence[ClearanceProof]) -> list[ClearancePair]:
    """The pairs, those first that the proofs measured closest to their limits, those last that they did not measure."""
    margin: dict[frozenset[str], float] = {}
    for names, mm in (item for p in proofs for item in p.closest.items()):
        margin[frozenset(names)] = min(mm, margin.get(frozenset(names), np.inf))
    return sorted(pairs, key=lambda p: margin.get(frozenset((p.a.name, p.b.name)), np.inf))


def _sampled(name: str, samples: Sequence[PairSample], limit: float, sampler: Sampler, calls: int) -> CheckResult:
    if not samples:
        return CheckResult(name, True, None, limit, "mm", detail="no two bodies on different links")
    worst = samples[0]
    a, b = worst.pair.a, worst.pair.b
    swept = any(" revolved in " in x.key for x in (a, b))
    swaying = any(x.key.endswith(" swaying") for x in (a, b))
    detail = (
        f"mesh distance {worst.distance_mm:.3f} mm less the meshes' deviations "
        f"{a.mesh.deviation_mm:.3f} and {b.mesh.deviation_mm:.3f} mm, "
        f"smallest of {sampler.described(worst.pair)}"
        + (f", {calls} distance calls" if calls else "")
        + ("; a geared pinion counts as the body of revolution that it sweeps" if swept else "")
        + ("; a spring counts with all that it strays while its rods lean and turn" if swaying else "")
    )
    passed = worst.certain_mm >= limit
    return CheckResult(name, passed, worst.certain_mm, limit, "mm", _pose(sampler, worst), (a.name, b.name), detail)


def _pose(sampler: Sampler, sample: PairSample) -> tuple[float, float, float]:
    x, y, z = sampler.poses_mm[sample.pose].tolist()
    return x, y, z


def _containment(inside: Sequence[ClearancePair]) -> CheckResult:
    detail = "no body lies inside a body of another link"
    if inside:
        detail = "; ".join(f"{p.a.name} and {p.b.name} lie one inside the other" for p in inside)
    pair = (inside[0].a.name, inside[0].b.name) if inside else None
    return CheckResult("containment", not inside, len(inside), 0, "", worst_pair=pair, detail=detail)


def _tightest(assembly: Assembly, samples: Sequence[PairSample], sampler: Sampler) -> list[_CloseSample]:
    """The samples with the least to spare, one for each two parts: those of the three chains are equal."""
    kinds: dict[frozenset[str], PairSample] = {}
    for s in sorted(samples, key=lambda s: s.certain_mm - s.pair.limit_mm):
        kinds.setdefault(frozenset((s.pair.a.key, s.pair.b.key)), s)
    link = {o.name: o.link for o in assembly.occurrences}
    swept = {*swept_links(assembly.placement), *(o.link for o in assembly.occurrences if o.link.startswith("spring"))}

    def close(s: PairSample) -> _CloseSample:
        """The sample with the frames of the solids, not of the bodies that they sweep."""
        placed = dict(assembly.placement(sampler.poses_mm[s.pose]))
        placed |= {name: frame[s.pose] for name, frame in sampler.frames.items() if name.startswith("rod")}
        a, b = s.pair.a, s.pair.b
        return _CloseSample(
            (a.name, b.name),
            (placed[link[a.name]], placed[link[b.name]]),
            _pose(sampler, s),
            s.distance_mm,
            a.mesh.deviation_mm + b.mesh.deviation_mm + _EXACT_MM,
            link[a.name] in swept or link[b.name] in swept,
        )

    return [close(s) for s in list(kinds.values())[:_EXACT_SAMPLES]]


def with_exact(assembly: Assembly, by_meshes: MeshClearance) -> list[CheckResult]:
    """Adds `clearance exact`, the closest samples on the exact solids, before the proof."""
    *sampled, proof = by_meshes.results
    return [*sampled, _exact(assembly, by_meshes.closest), proof]


def _exact(assembly: Assembly, samples: Sequence[_CloseSample]) -> CheckResult:
    """Compare mesh distances with the exact ones: they must agree within the deviations of the meshes."""
    placements = {o.name: o for o in assembly.occurrences}
    worst, worst_sample, value = -np.inf, None, 0.0
    for sample in samples:
        a, b = (placements[name] for name in sample.names)
        frame_a, frame_b = sample.frames
        exact = exact_distance(a.part.solid, b.part.solid, np.linalg.inv(frame_a @ a.placement) @ frame_b @ b.placement)
        off = sample.distance_mm - exact if sample.swept else abs(sample.distance_mm - exact)
        if off - sample.allowed_mm > worst:
            worst, worst_sample, value = off - sample.allowed_mm, sample, off
    if worst_sample is None:
        return CheckResult("clearance exact", True, None, None, "mm", detail="nothing to compare")
    return CheckResult(
        "clearance exact",
        worst <= 0.0,
        value,
        value - worst,
        "mm",
        worst_sample.pose_mm,
        worst_sample.names,
        f"difference of mesh and exact (BRepExtrema) distance of the {len(samples)} samples with the least to spare; "
        "the limit is the sum of both deviations",
    )


def _contained(pairs: Sequence[ClearancePair], sampler: Sampler) -> list[ClearancePair]:
    """The pairs of which one body holds the other, at the sampler's first position.

    One position is enough: a body cannot get in or out while the distance of the surfaces is proven positive.
    """
    bodies = {id(b): b for pair in pairs for b in (pair.a, pair.b)}
    middle = {key: sampler.middle(b, 0) for key, b in bodies.items()}
    apart = np.reshape([middle[id(pair.a)] - middle[id(pair.b)] for pair in pairs], (-1, 3))
    largest = np.array([max(pair.a.radius, pair.b.radius) for pair in pairs])
    near = np.linalg.norm(apart, axis=1) <= largest  # else the smaller one's centre is outside the larger one's sphere
    return [pairs[k] for k in np.flatnonzero(near).tolist() if _holds(pairs[k], sampler)]


def _holds(pair: ClearancePair, sampler: Sampler) -> bool:
    frame_a, frame_b = sampler.frames[pair.a.link][0], sampler.frames[pair.b.link][0]
    return holds(pair.a.mesh, pair.b.mesh, frame_a @ pair.a.placement, frame_b @ pair.b.placement)


def exact_distance(a: object, b: object, b_in_a: np.ndarray) -> float:
    """Exact distance of two solids.

    Args:
        a: One `cadquery.Solid`.
        b: The other.
        b_in_a: (4, 4) frame of b to the frame of a, mm.

    Returns:
        Distance, mm; 0 where they touch, intersect or hold one another.

    Raises:
        ValueError: The kernel found no distance.
    """
    from OCP.BRepExtrema import BRepExtrema_DistShapeShape

    from delta_cad.checks.contact.placing import located

    distance = BRepExtrema_DistShapeShape(a.wrapped, located(b, b_in_a))  # type: ignore[attr-defined]
    if not distance.IsDone():
        raise ValueError("the exact distance of two solids could not be computed")
    return 0.0 if distance.InnerSolution() else float(distance.Value())


def _proof(
    limit_mm: float,
    proofs: Sequence[ClearanceProof],
    refuted: Sequence[PairSample],
    closest: Sequence[PairSample],
    counts: str,
) -> CheckResult:
    """What the proofs came to; a pair that a sample refutes is not told as undecided.

    The pair that fails is that which lacks most of its own limit, and the value the clearance less that: of what was
    measured, at positions that may occur. None where nothing was found lacking, and a proof gave up.
    """
    gone = {frozenset((s.pair.a.name, s.pair.b.name)) for s in refuted}
    left = [(p.closest.get(names, np.inf), names, box) for p in proofs for names, box in p.undecided]
    left.sort(key=lambda pair: pair[0])  # what has least to spare is why, not what the calls did not suffice for
    undecided = [(names, box) for _, names, box in left if frozenset(names) not in gone]
    if undecided or refuted:
        lacking = [(margin, names) for margin, names, _ in left if frozenset(names) not in gone]
        lacking += [(s.certain_mm - s.pair.limit_mm, (s.pair.a.name, s.pair.b.name)) for s in refuted]
        margin, first = min(lacking, key=lambda one: one[0])
        failures = [f"{' / '.join(names)} undecided in {box}" for names, box in undecided[:5]]
        failures += [
            f"{s.pair.a.name} / {s.pair.b.name} refuted by a sample at {s.certain_mm:.3f} mm" for s in refuted[:5]
        ]
        detail = f"{len(undecided)} pairs undecided, {len(refuted)} refuted; {'; '.join(failures)}; {counts}"
        value = limit_mm + margin if margin < 0.0 else None
        return CheckResult("clearance proof", False, value, limit_mm, "mm", worst_pair=first, detail=detail)
    sampled = f"; smallest found {closest[0].certain_mm:.3f} mm" if closest else ""
    return CheckResult(
        "clearance proof",
        True,
        limit_mm,
        limit_mm,
        "mm",
        detail=f"proved minimum clearance >= {limit_mm:g} mm over the cube, "
        f"running gaps at their own limits{sampled}; {counts}",
    )
