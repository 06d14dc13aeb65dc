"""How the search for the smallest sampled clearance grows with bodies and with positions, and the outline's bound."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import process_time

import numpy as np

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.pairing import ClearancePair, clearance_pairs
from delta_cad.checks.clearance.sampled import Sampler
from delta_cad.checks.outline.envelope import swept_outline
from delta_cad.commands.pipeline import ANGULAR_RAD, LINEAR_MM, check_limits
from delta_cad.design import load_design
from delta_cad.dimensions import dimensions
from delta_cad.export.mass_properties import mass_report
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.part import Occurrence
from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT, interleaved, slope

SUBJECT = "checks"
GRIDS = (4, 6, 9)  # positions along each edge of the cube
OUTLINES = 5


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    say("solids and meshes of best.json")
    d = dimensions(load_design(ROOT / "best.json"))
    assembly = assemble(d)
    limits = check_limits(d, mass_report(assembly))
    meshes = MeshLibrary(assembly.parts, LINEAR_MM, ANGULAR_RAD)
    for part in assembly.parts:
        meshes[part.number]
    say("outline")
    outline = interleaved({"": lambda: swept_outline(assembly, limits, meshes)}, OUTLINES)[""]
    figures = [of_repeats(SUBJECT, "bound of the swept outline", outline, "s")]

    bodies, pairs, times = [], [], []
    held, seconds, called = [], 0.0, 0
    for chains in range(1, len(CHAINS) + 1):
        part = _of_chains(assembly, chains)
        held = [p for p in clearance_pairs(part, limits, meshes) if not p.running_gap]
        say(f"smallest clearance of {len(part.occurrences)} bodies, {len(held)} pairs")
        bodies.append(len(part.occurrences))
        pairs.append(len(held))
        seconds, called = _seconds(part, held, limits.poses_mm())
        times.append(seconds)
    note = f"{_listed(bodies)} bodies, {_listed(pairs)} pairs, {len(limits.poses_mm()):,} positions: {_listed(times)} s"
    figures.append(Figure(SUBJECT, "smallest clearance, whole machine, processor time", times[-1], "s"))
    figures.append(Figure(SUBJECT, "growth: time against bodies, log-log slope", slope(bodies, times), "", note=note))

    whole = len(limits.poses_mm()), seconds, called
    counts, times, calls = [], [], []
    for grid in GRIDS:
        poses = replace(limits, grid=grid, random_poses=0).poses_mm()
        say(f"smallest clearance at {len(poses)} positions")
        seconds, called = _seconds(assembly, held, poses)
        counts.append(len(poses))
        times.append(seconds)
        calls.append(called)
    counts, times, calls = [*counts, whole[0]], [*times, whole[1]], [*calls, whole[2]]
    note = f"{_listed(counts)} positions: {_listed(times)} s with {_listed(calls)} distance calls"
    name = "growth: time against positions, log-log slope"
    return [*figures, Figure(SUBJECT, name, slope(counts, times), "", note=note)]


def _of_chains(assembly: Assembly, count: int) -> Assembly:
    """The base, the platform and the first chains; parts of base and platform by the first number of their name."""

    def kept(o: Occurrence) -> bool:
        moving = o.link not in ("base", "platform")
        numbers = [int(word) for word in (o.link if moving else o.name).split("_") if word.isdigit()]
        return not numbers or numbers[0] < count

    return replace(assembly, occurrences=tuple(o for o in assembly.occurrences if kept(o)))


def _seconds(assembly: Assembly, held: Sequence[ClearancePair], poses: np.ndarray) -> tuple[float, int]:
    """Processor time of one search from nothing, s, and its distance calls."""
    engine = DistanceEngine()
    start = process_time()
    Sampler(assembly.placement, poses, engine).closest(held)
    return process_time() - start, engine.calls


def _listed(values: Sequence[float]) -> str:
    return ", ".join(f"{v:.2g}" if isinstance(v, float) else f"{v:,}" for v in values)
