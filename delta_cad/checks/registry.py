"""Every check of a machine, one line each, in the order of the report, and the run of all.

A new check is its module, its line in `CHECKS` and its test: from a `CheckedMachine` to `CheckResult` records.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

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
from delta_cad.checks.contact.stops import check_stop_pressure, check_stops
from delta_cad.checks.dfm.check import check_dfm
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.outline.height import check_height
from delta_cad.checks.panel import check_panel
from delta_cad.checks.range.cable import check_cable, check_cable_setting
from delta_cad.checks.range.drive import check_bend, check_drive
from delta_cad.checks.range.forward import check_forward
from delta_cad.checks.range.joint_axes import check_joint_axes
from delta_cad.checks.range.joints import check_joints
from delta_cad.checks.range.mates import check_mates
from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.range.tolerances import check_tolerances
from delta_cad.checks.report import CheckResult
from delta_cad.checks.sections import check_sections
from delta_cad.checks.solidity import check_solidity
from delta_cad.checks.structure import check_structure
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.machine import general_class
from delta_cad.drive import drive_torque
from delta_cad.mechanism import DeltaGeometry
from delta_cad.structure.spans import structure_spans

_Stage = Literal["mechanism", "solids", "assembly", "sweep", "design"]


@dataclass(frozen=True)
class CheckedMachine:
    """A machine as the checks see it.

    Attributes:
        assembly: The placed parts.
        limits: The cube and what the machine is held to.
        meshes: The parts' meshes.
        dimensions: Those of its design; None leaves out the checks of stage "design".
        bodies: `bodies` of its mass report, for the same checks.
        progress: Called with the label of each check as it begins.
        sweep: Computes outline and clearance, perhaps in another process.
    """

    assembly: Assembly
    limits: CheckLimits
    meshes: MeshLibrary
    dimensions: Dimensions | None = None
    bodies: Mapping[str, Any] = field(default_factory=dict)
    progress: Callable[[str], None] = lambda _: None
    sweep: Sweep = field(default_factory=Sweep)

    @property
    def geometry(self) -> DeltaGeometry:
        """The mechanism."""
        return self.assembly.placement.geometry

    @property
    def d(self) -> Dimensions:
        """The dimensions, which checks of stage "design" have."""
        assert self.dimensions is not None
        return self.dimensions


@dataclass(frozen=True)
class _Check:
    """A check.

    Attributes:
        name: Unique.
        stage: When it runs. "mechanism": first; where a position is out of reach, what is next but "design" is left
            out, as it is where a part is no sound solid after "solids". "assembly": of exact solids. "sweep": outline
            and clearance of meshes, computed from the beginning in another process. "design": of dimensions.
        cost_s: Processor time on `best.json`, one core of 2026, s; 0: below 10 ms.
        label: What it is about, for a reader.
        run: Its results.
        family: Whether they are named `<name> <of what>`: a page then has the label in place of the name.
    """

    name: str
    stage: _Stage
    cost_s: float
    label: str
    run: Callable[[CheckedMachine], list[CheckResult]]
    family: bool = False


CHECKS = (
    _Check("ranges", "mechanism", 0.96, "Limits over the cube", lambda m: check_ranges(m.geometry, m.limits)),
    _Check("solid", "solids", 0.49, "Solids", lambda m: check_solidity(m.assembly.parts, m.meshes)),
    _Check("forward", "assembly", 0.0, "Forward kinematics", lambda m: [check_forward(m.geometry, m.limits)]),
    _Check("joints", "assembly", 0.01, "Joints", lambda m: check_joints(m.assembly, m.limits)),
    _Check("axes", "assembly", 0.01, "Axes of the solids", lambda m: [check_joint_axes(m.assembly)]),
    _Check("contacts", "assembly", 0.29, "Contacts", lambda m: [check_contacts(m.assembly)]),
    _Check("stops", "assembly", 0.23, "Stops", lambda m: [check_stops(m.assembly)]),
    _Check("fits", "assembly", 4.1, "Common volumes", lambda m: check_fits(m.assembly, m.limits, m.meshes)),
    _Check("gaps", "assembly", 0.02, "Widest gaps", lambda m: check_largest_gaps(m.assembly, m.limits, m.meshes)),
    _Check("attachment", "assembly", 0.21, "Loose parts", lambda m: [check_attachment(m.assembly, m.meshes)]),
    _Check("screws", "assembly", 0.4, "Screws", lambda m: check_screws(m.assembly, m.meshes)),
    _Check("access", "assembly", 1.1, "Tool access", lambda m: check_access(m.assembly, m.limits, m.meshes)),
    _Check("order", "assembly", 2.6, "Assembly sequence", lambda m: check_order(m.assembly, m.limits, m.meshes)),
    _Check("outline", "sweep", 0.57, "Swept outline", lambda m: m.sweep.outline()),
    _Check("clearance", "sweep", 13.0, "Clearance", lambda m: with_exact(m.assembly, m.sweep.clearance())),
    _Check("drive", "design", 0.0, "Drive torque", lambda m: check_drive(drive_torque(m.d.design))),
    _Check("cable", "design", 0.02, "Cable path", lambda m: check_cable(m.assembly)),
    _Check("setting", "design", 0.9, "Cable setting", lambda m: check_cable_setting(m.assembly, m.d, m.meshes)),
    _Check("bend", "design", 0.0, "Cable bending", lambda m: check_bend(drive_torque(m.d.design))),
    _Check("height", "design", 0.0, "Height", lambda m: [check_height(m.d)]),
    _Check("tolerance", "design", 0.0, "Tolerances", lambda m: check_tolerances(m.d), True),
    _Check(
        "mates",
        "design",
        0.7,
        "Mating patterns",
        lambda m: check_mates(m.assembly, general_class(m.d)),
        True,
    ),
    _Check(
        "stop pressure",
        "design",
        0.05,
        "Pressure of stop pins",
        lambda m: [check_stop_pressure(m.assembly, drive_torque(m.d.design).required_peak_N_m)],
    ),
    _Check("panel", "design", 0.0, "Panel", lambda m: check_panel(m.assembly, m.d, m.limits, m.meshes)),
    _Check(
        "sections", "design", 0.93, "Cross-sections", lambda m: check_sections(m.assembly, structure_spans(m.d)), True
    ),
    _Check("dfm", "design", 1.4, "For the shop", lambda m: check_dfm(m.assembly.parts), True),
    _Check("structure", "design", 0.1, "Strength", lambda m: check_structure(m.d, m.bodies), True),
)
"""All there are."""


def run_checks(m: CheckedMachine, meanwhile: Callable[[], None] = lambda: None) -> list[CheckResult]:
    """Runs every check, in the order in which a later one relies on an earlier one.

    Args:
        m: The machine.
        meanwhile: Called once when the exact solids are checked, to do what else there is while the sweep goes on.

    Returns:
        The results in the order of `CHECKS`. Where the cube is not reachable, or a part is no sound solid, the checks
        that need it are left out: the report then holds the failures only up to there.
    """

    def of(stage: _Stage) -> list[CheckResult]:
        results: list[CheckResult] = []
        for check in (check for check in CHECKS if check.stage == stage):
            m.progress(check.label)
            results += [replace(result, kind=check.label) for result in check.run(m)]
        return results

    results = of("mechanism")
    if reachable := next(r.passed for r in results if r.name == "reach"):
        m.sweep.begin(m.assembly, m.limits, m.meshes, m.progress)
    results += of("solids")
    sound = reachable and all(r.passed or r.value is not None for r in results if r.name.startswith("solid "))
    if sound:
        results += of("assembly")
    else:
        m.sweep.cancel()
    meanwhile()
    design = of("design") if m.dimensions is not None else []
    return results + (of("sweep") if sound else []) + design
