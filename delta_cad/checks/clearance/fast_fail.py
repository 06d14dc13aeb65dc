"""Room for keys, outline and clearance of a machine that may fail: soon told, on two cores."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes, MeshLibrary
from delta_cad.checks.clearance.branch_and_bound import ClearanceProof
from delta_cad.checks.clearance.clearance import MeshClearance, handle_proofs, mesh_clearance, with_exact
from delta_cad.checks.contact.access import check_access
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.outline.envelope import check_envelope
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.common.worker_process import WorkerProcess

LOADS = ("fcl", "scipy.spatial")
_CALLS_FEW = 60_000  # distance calls of a space: machines of 130 mm that pass take up to 43 000, a dashboard's 6 000
_Order = tuple[Assembly, CheckLimits, Meshes]


@dataclass(frozen=True)
class Moved:
    """What came of the checks of what moves.

    Attributes:
        results: Those of `check_access`, and where they hold those of `check_envelope` and the clearance.
        clearance: What `mesh_clearance` gave, mapped, for the checks of the whole machine; None where keys lack room.
    """

    results: list[CheckResult]
    clearance: MeshClearance | None = None


def results(order: _Order) -> Iterator[list[ClearanceProof]]:
    """Computes the result of `handle_proofs`, half of the whole: the other process."""
    yield handle_proofs(*order, _CALLS_FEW)


def check_moving(
    assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary, progress: Callable[[str], None]
) -> Moved:
    """Runs the checks of keys' access, outline and clearance; what fails is not told where it is worst, but soon.

    Args:
        assembly: The machine.
        limits: The cube, the outline and the clearance.
        meshes: The parts' meshes.
        progress: Told what is being done.

    Returns:
        What came of them.
    """
    made = {part.number: meshes[part.number] for part in assembly.parts}
    with WorkerProcess(__name__) as prover:
        prover.send((assembly.without_solids(), limits, made))
        reached = check_access(assembly, limits, meshes)
        if not all_passed(reached):
            return Moved(reached)
        progress("outline")
        outline = check_envelope(assembly, limits, made)[0]
        clearance = mesh_clearance(assembly, limits, made, progress, _CALLS_FEW, True, prover.receive)
        return Moved([*reached, *outline, *with_exact(assembly, clearance)], clearance)
