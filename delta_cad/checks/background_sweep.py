"""Outline and clearance of the moving machine, computed from meshes alone so that a worker process can do it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes, MeshLibrary
from delta_cad.checks.clearance.clearance import PROVING, MeshClearance, Near, mesh_clearance
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.outline.envelope import check_envelope
from delta_cad.checks.report import CheckResult
from delta_cad.common.memoize import cached
from delta_cad.common.worker_process import WorkerProcess

LOADS = ("fcl", "scipy.spatial")
_Order = tuple[Assembly, CheckLimits, Meshes, bool, MeshClearance | None]
_Outlined = tuple[list[CheckResult], np.ndarray | None]


def results(order: _Order, progress: Callable[[str], None] = lambda _: None) -> Iterator[Any]:
    """Computes the results of `check_envelope`, then those of `mesh_clearance` where they are not known."""
    assembly, limits, meshes, mapped, known = order
    of = assembly, limits, {part.number: meshes[part.number] for part in assembly.parts}
    progress("outline")
    yield cached("outline", of, lambda: check_envelope(assembly, limits, meshes))
    yield known or cached(
        "clearance", (of, mapped), lambda: mesh_clearance(assembly, limits, meshes, progress, mapped=mapped)
    )


class Sweep:
    """The sweep of one machine.

    Args:
        adjacent: Process that computes it while this one goes on, started from this module; without it everything is
            computed where it is asked for.
        mapped: As `mesh_clearance` takes it.
        known: What that gave for the same machine; None: it is computed.

    Attributes:
        over: What is closest over the cube, as `MeshClearance` tells it, once the clearance was given.
    """

    def __init__(
        self, adjacent: WorkerProcess | None = None, mapped: bool = False, known: MeshClearance | None = None
    ) -> None:
        self._adjacent, self._mapped, self._known = adjacent, mapped, known
        self.over: list[Near] = []
        self._here: Iterator[Any] = iter(())
        self._progress: Callable[[str], None] | None = None
        self._outline: _Outlined | None = None

    def begin(
        self, assembly: Assembly, limits: CheckLimits, meshes: MeshLibrary, progress: Callable[[str], None]
    ) -> None:
        """Begins with a machine."""
        self._progress = progress
        if self._adjacent:
            made = {part.number: meshes[part.number] for part in assembly.parts}
            self._adjacent.send((assembly.without_solids(), limits, made, self._mapped, self._known))
        else:
            self._here = results((assembly, limits, meshes, self._mapped, self._known), progress)

    def cancel(self) -> None:
        """Leaves what was begun: a part is no sound solid, so that nothing is to be had of its mesh."""
        self._progress = None

    def outline(self) -> list[CheckResult]:
        """Gives the results of `check_envelope`."""
        return self._outlined()[0]

    @property
    def reach_mm(self) -> np.ndarray | None:
        """(4,) bound on the outline along +x, -x, +y, -y, mm; None where it has none, or no sweep goes on."""
        return self._outlined()[1] if self._progress else None

    def _outlined(self) -> _Outlined:
        outline: _Outlined = self._outline or (self._adjacent.receive() if self._adjacent else next(self._here))
        self._outline = outline
        return outline

    def clearance(self) -> MeshClearance:
        """Gives the results of `mesh_clearance`, after the outline.

        Raises:
            RuntimeError: No sweep was begun.
        """
        if not self._progress:
            raise RuntimeError("no sweep goes on")
        self._outlined()
        if self._adjacent:
            self._progress(PROVING)
        clearance: MeshClearance = self._adjacent.receive() if self._adjacent else next(self._here)
        self.over = clearance.over
        return clearance
