"""Checks of a placed machine: each takes the assembly and returns records that say what holds, by how much and where.

A check takes the `assembly` and, as it needs them, the `limits` with the cube of handle positions, and the parts'
`meshes`, of which those that are missing are made; `progress` is called with the name of what is being done.
Nothing here loads the CAD kernel on import.
"""

from __future__ import annotations

from collections.abc import Callable

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.clearance import check_clearance
from delta_cad.checks.contact.attachment import check_attachment
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.checks.contact.fits import check_fits
from delta_cad.checks.contact.gaps import check_largest_gaps
from delta_cad.checks.contact.screws import check_screws
from delta_cad.checks.contact.stops import check_stops
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.outline.envelope import check_envelope
from delta_cad.checks.presence import check_presence
from delta_cad.checks.range.forward import check_forward
from delta_cad.checks.range.joint_axes import check_joint_axes
from delta_cad.checks.range.joints import check_joints
from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.checks.solidity import check_solidity

__all__ = ["CheckLimits", "CheckResult", "all_passed", "run_checks"]


def run_checks(
    assembly: Assembly,
    limits: CheckLimits,
    meshes: MeshLibrary,
    progress: Callable[[str], None] = lambda _: None,
) -> list[CheckResult]:
    """Runs every check, in the order in which a later one relies on an earlier one.

    Returns:
        The results. Where the cube is not reachable, or a part is no sound solid, the checks that need it are left
        out: the report then holds the failures only up to there.
    """
    progress("ranges of the mechanism")
    results = check_ranges(assembly.placement.geometry, limits)
    results.append(check_presence(assembly))
    progress("solids")
    results += check_solidity(assembly.parts, meshes)
    reachable = next(r.passed for r in results if r.name == "reach")
    if not reachable or not all(r.passed for r in results if r.name.startswith("solid ") and r.value is None):
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
    progress("outline")
    results += check_envelope(assembly, limits, meshes)
    results += check_clearance(assembly, limits, meshes, progress)
    return results
