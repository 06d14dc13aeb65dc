"""Proof over every point of a cube, not over samples: `python examples/prove_cube.py`."""

from math import radians

from delta_cad.design import load_design
from delta_cad.mechanism.limits import AssemblyMode, Kappa, Lean, Limits, Torque
from delta_cad.mechanism.proof.prove import prove

design = load_design("best.json")
cube = design.workspace

# Expect all conditions proved: the worst condition number is 2.26999..., just below 2.27.
limits = Limits.of(AssemblyMode(), Torque(force=3.0, torque_max=0.39), Kappa(2.27), Lean(radians(28.0)))
proof = prove(design.geometry, cube, limits)
for finding in proof.findings:
    print(f"{finding.condition:12s} {finding.verdict} in {proof.boxes} boxes")

# Expect a point of the cube that breaks a limit of 2: a refutation is a proof, too.
refuted = prove(design.geometry, cube, Limits.of(Kappa(2.0)))
for finding in refuted.findings:
    if finding.verdict == "refuted" and finding.point is not None:
        at = ", ".join(f"{1000 * x:.1f}" for x in finding.point)
        print(f"{finding.condition:12s} {finding.value:.4f} > {finding.limit} at ({at}) mm")
