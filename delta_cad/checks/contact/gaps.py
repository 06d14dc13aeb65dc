"""Running gaps with an upper limit, such as the air gap of an encoder."""

from __future__ import annotations

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine, bodies_of
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult


def check_largest_gaps(assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary) -> list[CheckResult]:
    """Holds the widest distance of each running gap that has a `gap_max_mm` against it.

    The two parts of such a gap turn about one axis, which leaves their distance nearly the same: the cube's centre and
    corners stand for all positions. The smallest distance is held over the whole cube by the clearance.
    """
    limited = [(f, w) for f in assembly.fits if f.kind == "running gap" and (w := f.gap_max_mm) is not None]
    if not limited:
        return []
    poses = np.concatenate([limits.centre_mm[None], limits.corners_mm])
    placed = assembly.poses(poses)
    names = {name for f, _ in limited for name in (f.a, f.b)}
    bodies = bodies_of([o for o in assembly.occurrences if o.name in names], meshes)
    engine = DistanceEngine()
    results = []
    for fit, widest in limited:
        a, b = bodies[fit.a], bodies[fit.b]
        apart = [engine.distance(a, b, placed[fit.a][k], placed[fit.b][k]) for k in range(len(poses))]
        k = int(np.argmax(apart))
        unsure = a.mesh.deviation_mm + b.mesh.deviation_mm
        value = apart[k] + unsure
        passed = value <= widest
        x, y, z = poses[k].tolist()
        detail = (
            f"mesh distance {apart[k]:.3f} mm and the meshes' deviations {unsure:.3f} mm, largest of {len(poses)} "
            f"positions; {fit.reason}"
        )
        if not passed:
            detail = f"the gap is wider than {widest:g} mm: {detail}"
        name = f"largest gap {fit.a} / {fit.b}"
        results.append(CheckResult(name, passed, value, widest, "mm", (x, y, z), (fit.a, fit.b), detail))
    return results
