"""The checks of a build, the quick ones first, until one refuses; what did not change is not looked at again."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, MeshLibrary
from delta_cad.checks import CheckLimits, CheckResult
from delta_cad.checks.clearance.clearance import check_clearance
from delta_cad.checks.contact.access import check_access
from delta_cad.checks.contact.anchors import check_anchors
from delta_cad.checks.contact.attachment import check_attachment
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.checks.contact.fits import check_fits
from delta_cad.checks.contact.gaps import check_largest_gaps
from delta_cad.checks.contact.screws import check_screws
from delta_cad.checks.contact.stops import check_stops
from delta_cad.checks.dfm.makes import check_makes
from delta_cad.checks.outline.envelope import check_envelope
from delta_cad.checks.panel import check_panel
from delta_cad.checks.presence import check_presence
from delta_cad.checks.range.cable import check_cable
from delta_cad.checks.range.joint_axes import check_joint_axes
from delta_cad.checks.sections import check_sections
from delta_cad.checks.solidity import check_solidity
from delta_cad.commands.pipeline import ANGULAR_RAD, LINEAR_MM, check_limits
from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import dimensions
from delta_cad.export.mass_properties import mass_report
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import BuildError
from delta_cad.structure.spans import structure_spans
from tests.committed import changed


class _Meshes(MeshLibrary):
    """Meshes of a machine, those of its sound parts from the library of the sound machine."""

    def __init__(self, parts: tuple[Part, ...], known: MeshLibrary, sound: set[int]) -> None:
        super().__init__(parts, LINEAR_MM, ANGULAR_RAD)
        self._known, self._sound = known, {part.number for part in parts if id(part) in sound}

    def __getitem__(self, number: str) -> Mesh:
        return self._known[number] if number in self._sound else super().__getitem__(number)


class Refusing:
    """Runs the checks of a build that look at solids, and stops at the first that refuses."""

    def __init__(self, assembly: Assembly, design: Design | None = None) -> None:
        self._sound = {id(part) for part in assembly.parts}
        self._meshes = MeshLibrary(assembly.parts, LINEAR_MM, ANGULAR_RAD)
        self._d = d = dimensions(design or design_from_dict(changed()))
        self._limits = check_limits(d, mass_report(assembly))
        self._spans = structure_spans(d)

    def first_refusal(self, assembly: Assembly) -> str | None:
        """Names the first check that refuses a machine, with its detail; None where all pass."""
        try:
            for check in self._checks(assembly):
                for result in check():
                    if not result.passed:
                        return f"{result.name}: {result.detail[:160]}"
        except BuildError as error:  # a build ends there, too
            return str(error)
        return None

    def _checks(self, a: Assembly) -> Iterator[Callable[[], list[CheckResult]]]:
        meshes = _Meshes(a.parts, self._meshes, self._sound)
        parts: list[Part] = [part for part in a.parts if id(part) not in self._sound]
        limits: CheckLimits = self._limits
        wrong = {part.number for part in parts}
        yield lambda: [check_presence(a)]
        yield lambda: check_solidity(parts, meshes)
        yield lambda: [check_makes(a)]
        if spans := [span for span in self._spans if span.part in wrong]:
            yield lambda: check_sections(a, spans)
        yield lambda: [check_contacts(a), check_anchors(a), check_stops(a)]
        yield lambda: [check_joint_axes(a)]
        yield lambda: check_cable(a)
        yield lambda: check_screws(a, meshes)
        yield lambda: [check_attachment(a, meshes)]
        yield lambda: check_panel(a, self._d, limits, meshes)
        yield lambda: check_fits(a, limits, meshes)
        yield lambda: check_largest_gaps(a, limits, meshes)
        yield lambda: check_access(a, limits, meshes)
        yield lambda: check_envelope(a, limits, meshes)[0]
        yield lambda: check_clearance(a, limits, meshes)
