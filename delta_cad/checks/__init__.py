"""Checks of a placed machine: each takes the assembly and returns records that say what holds, by how much and where.

A check takes the `assembly` and, as it needs them, the `limits` with the cube of handle positions, and the parts'
`meshes`, of which those that are missing are made; `progress` is called with the name of what is being done.
Nothing here loads the CAD kernel on import.
"""

from __future__ import annotations

from collections.abc import Callable

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.background_sweep import Sweep
from delta_cad.checks.clearance.clearance import with_exact
from delta_cad.checks.contact.access import check_access
from delta_cad.checks.contact.attachment import check_attachment
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.checks.contact.fits import check_fits
from delta_cad.checks.contact.gaps import check_largest_gaps
from delta_cad.checks.contact.order.check import check_order
from delta_cad.checks.contact.screws import check_screws
from delta_cad.checks.contact.stops import check_stops
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.range.forward import check_forward
from delta_cad.checks.range.joint_axes import check_joint_axes
from delta_cad.checks.range.joints import check_joints
from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.checks.solidity import check_solidity

__all__ = ["CheckLimits", "CheckResult", "Sweep", "all_passed", "run_checks"]


def run_checks(
    assembly: Assembly,
    limits: CheckLimits,
    meshes: MeshLibrary,
    progress: Callable[[str], None] = lambda _: None,
    sweep: Sweep | None = None,
    meanwhile: Callable[[], None] = lambda: None,
) -> list[CheckResult]:
    """Runs every check, in the order in which a later one relies on an earlier one.

    Args:
        assembly: The machine.
        limits: The cube and what is asked.
        meshes: The parts' meshes.
        progress: Told what is being done.
        sweep: Computes what needs no solids, perhaps in another process; None: in this one.
        meanwhile: Called once when the solids are checked, to do what else there is while the sweep goes on.

    Returns:
        The results. Where the cube is not reachable, or a part is no sound solid, the checks that need it are left
        out: the report then holds the failures only up to there.
    """
    progress("ranges of the mechanism")
    results = check_ranges(assembly.placement.geometry, limits)
    reachable = next(r.passed for r in results if r.name == "reach")
    sweep = sweep or Sweep()
    if reachable:
        sweep.begin(assembly, limits, meshes, progress)
    progress("solids")
    results += check_solidity(assembly.parts, meshes)
    if not reachable or not all(r.passed for r in results if r.name.startswith("solid ") and r.value is None):
        sweep.cancel()
        meanwhile()
        return results
    progress("joints")
    results.append(check_forward(assembly.placement.geometry, limits))
    results += check_joints(assembly, limits)
    results.append(check_joint_axes(assembly))
    results += [check_contacts(assembly), check_stops(assembly)]
    results += check_fits(assembly, limits, meshes, progress)
    results += check_largest_gaps(assembly, limits, meshes)
    progress("parts attached")
    results.append(check_attachment(assembly, meshes))
    results += check_screws(assembly, meshes)
    progress("access")
    results += check_access(assembly, limits, meshes)
    progress("order of assembly")
    results += check_order(assembly, limits, meshes)
    meanwhile()
    results += sweep.outline()
    by_meshes = sweep.clearance()
    progress("clearance: exact distances")
    return results + with_exact(assembly, by_meshes)
