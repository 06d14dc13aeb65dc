"""What the sampling leaves away must be farther than what it looks for."""

import numpy as np

from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.pairing import held_apart
from delta_cad.checks.clearance.sampled import Sampler
from tests.delta_cad.checks.machines import LIMITS, machine


def test_what_of_the_platform_is_near_a_ball_keeps_every_distance_below_the_bound() -> None:
    assembly, engine = machine(), DistanceEngine()
    sampler = Sampler(assembly.placement, LIMITS.clearance_poses_mm()[::40], engine)
    pairs = [
        p
        for p in held_apart(assembly, LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
        if "platform" in (p.a.link, p.b.link) and any(b.link.startswith("rod") for b in (p.a, p.b))
    ]
    smaller, below = 0, 0
    for pair in pairs:
        relative = np.linalg.inv(sampler.frames[pair.a.link]) @ sampler.frames[pair.b.link]
        whole = [engine.distance(pair.a, pair.b, pair.a.placement, r @ pair.b.placement) for r in relative]
        for best in (3.0, 12.0):
            local = sampler._near_the_wrist(pair, best)
            if local is None:
                assert min(whole) >= best
                continue
            one, other = local
            smaller += one is not pair.a or other is not pair.b
            for d, r in zip(whole, relative, strict=True):
                if d < best:
                    below += 1
                    assert abs(engine.distance(one, other, one.placement, r @ other.placement) - d) < 1e-6
        assert sampler._near_the_wrist(pair, np.inf) == (pair.a, pair.b)
    assert smaller
    assert below
