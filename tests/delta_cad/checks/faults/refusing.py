"""The checks of a build, and what the tests expect of its parts, until one refuses; the quick ones come first.

What did not change is not looked at again.

The sound machine has passed all checks: of contacts, stops, bores' places, pairs held apart and common volumes only
those are looked at in which a fault changed a body, and the outline takes what it changed beside what decides that of
the sound machine.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import cached_property
from typing import Any
from unittest.mock import patch

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Mesh, MeshLibrary
from delta_cad.checks.clearance import clearance
from delta_cad.checks.contact import fits
from delta_cad.checks.contact.access import check_access
from delta_cad.checks.contact.attachment import check_attachment
from delta_cad.checks.contact.engagement import check_contacts
from delta_cad.checks.contact.fits import check_fits
from delta_cad.checks.contact.gaps import check_largest_gaps
from delta_cad.checks.contact.screws import check_screws
from delta_cad.checks.contact.stops import check_stops
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.outline import envelope
from delta_cad.checks.outline.envelope import check_envelope, swept_outline
from delta_cad.checks.panel import check_panel
from delta_cad.checks.range.cable import check_cable
from delta_cad.checks.range.joint_axes import check_joint_axes
from delta_cad.checks.report import CheckResult
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
from tests.delta_cad.assembly.expected.anchors import anchor_faults
from tests.delta_cad.assembly.expected.comparing import make_faults, part_faults
from tests.delta_cad.checks.machines import check_clearance


class _Meshes(MeshLibrary):
    """Meshes of a machine, those of its sound parts from the library of the sound machine."""

    def __init__(self, parts: tuple[Part, ...], known: MeshLibrary, sound: set[int]) -> None:
        super().__init__(parts, LINEAR_MM, ANGULAR_RAD)
        self._known, self._sound = known, {part.number for part in parts if id(part) in sound}

    def __getitem__(self, number: str) -> Mesh:
        return self._known[number] if number in self._sound else super().__getitem__(number)


@contextmanager
def only_of(changed: Collection[str], deciding: Collection[str]) -> Iterator[None]:
    """Leaves out of clearance and common volumes the pairs without a changed body, and bodies of less reach.

    Args:
        changed: Names of the occurrences that a fault changed.
        deciding: Those that decide the sound machine's outline.
    """
    held, within, across, bodies = clearance.clearance_pairs, fits._within_links, fits._across_links, envelope.bodies_of

    def of_changed(find: Callable[..., list[Any]]) -> Callable[..., list[Any]]:
        return lambda *given: [pair for pair in find(*given) if not {pair.a.name, pair.b.name}.isdisjoint(changed)]

    def far(*given: Any) -> dict[str, Any]:
        return {name: one for name, one in bodies(*given).items() if name in changed or name in deciding}

    with ExitStack() as stack:
        for module, name, fewer in (
            (clearance, "clearance_pairs", of_changed(held)),
            (fits, "_within_links", of_changed(within)),
            (fits, "_across_links", of_changed(across)),
            (envelope, "bodies_of", far),
        ):
            stack.enter_context(patch.object(module, name, fewer))
        yield


def _of_tests(name: str, faults: list[str]) -> list[CheckResult]:
    return [CheckResult(name, not faults, len(faults), 0, "", detail="; ".join(faults))]


class Refusing:
    """Runs the checks of a build that look at solids, and stops at the first that refuses."""

    def __init__(self, assembly: Assembly, design: Design | None = None) -> None:
        self._assembly, self._sound = assembly, {id(part) for part in assembly.parts}
        self.meshes = MeshLibrary(assembly.parts, LINEAR_MM, ANGULAR_RAD)
        self._d = d = dimensions(design or design_from_dict(changed()))
        self.limits = check_limits(d, mass_report(assembly))
        self._spans = structure_spans(d)

    def first_refusal(self, assembly: Assembly, shared: bool = True) -> str | None:
        """Names the first check that refuses a machine, with its detail; None where all pass.

        Args:
            assembly: The machine.
            shared: Whether pairs without a changed body are left out: enough for all but what one body does to others,
                as a spring off its place, of which all springs count with more that they stray.
        """
        if assembly is self._assembly or not shared:
            return self._refused(assembly, {o.name for o in assembly.occurrences})
        as_before, there = {id(o) for o in self._assembly.occurrences}, {o.name for o in assembly.occurrences}
        changed = {o.name for o in assembly.occurrences if id(o) not in as_before}
        changed |= {o.name for o in self._assembly.occurrences} - there
        with only_of(changed, self._deciding):
            return self._refused(assembly, changed)

    @cached_property
    def _deciding(self) -> set[str]:
        """Names of the bodies that decide the sound machine's outline."""
        return {body.name for body in swept_outline(self._assembly, self.limits, self.meshes).bodies}

    def _refused(self, assembly: Assembly, changed: Collection[str]) -> str | None:
        try:
            for check in self._checks(assembly, changed):
                for result in check():
                    if not result.passed:
                        return f"{result.name}: {result.detail[:160]}"
        except BuildError as error:  # a build ends there, too
            return str(error)
        return None

    def _checks(self, a: Assembly, changed: Collection[str]) -> Iterator[Callable[[], list[CheckResult]]]:
        meshes = _Meshes(a.parts, self.meshes, self._sound)
        parts: list[Part] = [part for part in a.parts if id(part) not in self._sound]
        limits: CheckLimits = self.limits
        wrong = {part.number for part in parts}
        yield lambda: _of_tests("parts expected", part_faults(a, self._d))
        yield lambda: check_solidity(parts, meshes)
        yield lambda: _of_tests("makes expected", make_faults(a, self._d))
        if spans := [span for span in self._spans if span.part in wrong]:
            yield lambda: check_sections(a, spans)
        contacts = tuple(c for c in a.contacts if not {c.a, c.b}.isdisjoint(changed))
        stops = tuple(s for s in a.stops if not {s.a, s.b}.isdisjoint(changed))
        near = replace(a, contacts=contacts, stops=stops)
        if contacts:
            yield lambda: [check_contacts(near)]
        yield lambda: _of_tests("anchors expected", anchor_faults(a, self._d))
        if stops:
            yield lambda: [check_stops(near)]
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
