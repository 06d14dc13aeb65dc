"""What a sweep costs that only asks whether bodies collide: raw FCL at the closest pairs of the design's machine.

The pairs are those on different links whose bounding spheres come closest at the centre of the cube; the positions are
seeded. Only the placing of the collision objects and the collision calls are timed, in one thread, as processor time.
"""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import process_time
from typing import Any

import numpy as np

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT

SUBJECT = "checks"
PAIRS, POSES, REPEATS = 70, 100, 5
TARGET_MS = 0.2


def run(say: Callable[[str], None] = print) -> list[Figure]:
    """The sweep's time per position: collision of `PAIRS` pairs, distance of the same pairs, and their ratio.

    Args:
        say: Told what is being done.
    """
    import fcl

    from delta_cad.checks.clearance.bodies import DistanceEngine
    from delta_cad.checks.clearance.pairing import clearance_pairs
    from delta_cad.checks.clearance.sampled import Sampler
    from delta_cad.commands.pipeline import check_limits, make_machine
    from delta_cad.design import load_design

    say("solids and meshes of best.json")
    machine = make_machine(load_design(ROOT / "best.json"))
    limits = check_limits(machine.dimensions, machine.masses)
    random = np.random.default_rng(limits.seed).uniform(-1.0, 1.0, (POSES, 3)) * limits.half_side_mm
    poses = np.concatenate([limits.centre_mm[None], limits.centre_mm + random])
    sampler = Sampler(machine.assembly.placement, poses, DistanceEngine())
    pairs = clearance_pairs(machine.assembly, limits, machine.meshes)
    apart = [np.linalg.norm(sampler.middle(p.a, 0) - sampler.middle(p.b, 0)) - p.a.radius - p.b.radius for p in pairs]
    closest = [pairs[k] for k in np.argsort(apart)[:PAIRS]]

    trees: dict[str, Any] = {}
    for body in {b.key: b for p in closest for b in (p.a, p.b)}.values():
        tree = fcl.BVHModel()
        tree.beginModel(len(body.mesh.vertices), len(body.mesh.faces))
        tree.addSubModel(body.mesh.vertices, body.mesh.faces)
        tree.endModel()
        trees[body.key] = tree
    bodies = {b.name: b for p in closest for b in (p.a, p.b)}
    objects = {name: fcl.CollisionObject(trees[b.key]) for name, b in bodies.items()}
    couples = [(objects[p.a.name], objects[p.b.name]) for p in closest]
    frames = {name: sampler.frames[b.link][1:] @ b.placement for name, b in bodies.items()}

    def sweep(ask: Any) -> float:
        start = process_time()
        for k in range(POSES):
            for name, placed in objects.items():
                frame = frames[name][k]
                placed.setTransform(fcl.Transform(frame[:3, :3], frame[:3, 3]))
            for one, other in couples:
                ask(one, other)
        return (process_time() - start) / POSES * 1000.0

    say(f"{PAIRS} pairs at {POSES} positions")
    collide = [sweep(fcl.collide) for _ in range(REPEATS)]
    distance = sweep(fcl.distance)
    note = f"the {PAIRS} closest of {len(pairs):,} pairs, {len(objects)} bodies, {POSES} positions, one thread"
    return [
        of_repeats(SUBJECT, "collide-only sweep, per position", collide, "ms", TARGET_MS, note=note),
        Figure(SUBJECT, "distances of the same pairs, per position", distance, "ms"),
        Figure(SUBJECT, "distances over collisions", distance / median(collide), "x"),
    ]


if __name__ == "__main__":
    for figure in run():
        print(f"{figure.name}: {figure.value:.3f} {figure.unit} {figure.spread or ''} {figure.note}")
