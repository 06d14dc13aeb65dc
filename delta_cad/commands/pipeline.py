"""From a design to its folder: dimensions, solids, checks and files, in this order, whole or not at all."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks import background_sweep
from delta_cad.checks.background_sweep import Sweep
from delta_cad.checks.clearance import fast_fail
from delta_cad.checks.clearance.clearance import MeshClearance
from delta_cad.checks.clearance.fast_fail import Moved
from delta_cad.checks.contact.access import missing_spread_mm
from delta_cad.checks.dfm.setups import setups
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.outline.envelope import check_envelope
from delta_cad.checks.range.feel import poor_figures, poor_verdict
from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.registry import CheckedMachine, run_checks
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.checks.structure import check_structure
from delta_cad.common.memoize import cached
from delta_cad.common.worker_process import WorkerProcess
from delta_cad.design import Design, design_hash, design_to_json
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.joint import limit_values
from delta_cad.dimensions.tolerances.machine import general_class
from delta_cad.dimensions.tolerances.record import tolerance_record
from delta_cad.drive import drive_torque
from delta_cad.drive.friction import joint_friction
from delta_cad.drive.held import known_masses
from delta_cad.export import mesh_files
from delta_cad.export.bom import bill_of_materials, write_bom
from delta_cad.export.folder import ARCHIVE, output_folder, write_archive
from delta_cad.export.manifest import versions, write_manifest
from delta_cad.export.mass_properties import mass_report
from delta_cad.export.shop.cost.cost import Cost, cost_record, machine_cost
from delta_cad.export.shop.holes import hole_list, write_holes
from delta_cad.export.shop.profile import FOLDER as PROFILES
from delta_cad.export.shop.profile import write_profiles
from delta_cad.export.shop.template import write_template
from delta_cad.export.views.views import Stage
from delta_cad.mechanism.limits import Lean, Limits, Shoulder
from delta_cad.report.manual import page as manual
from delta_cad.report.page import write_report
from delta_cad.report.subject import Subject
from delta_cad.solids.part import Part, part_digest
from delta_cad.structure.report import structure_record, structure_report

if TYPE_CHECKING:
    from delta_cad.export.drawings.write import Drawn

_DRAWINGS = "delta_cad.export.drawings.write"  # which loads the CAD kernel
LINEAR_MM, ANGULAR_RAD = 0.05, 0.35  # deflection of all meshes: a tenth of a running gap, 18 facets a turn
_Progress = Callable[[str], None]


def quiet(_: str) -> None:
    """Takes the progress of a run that nobody watches."""


@dataclass(frozen=True)
class BuiltMachine:
    """A design made solid: its dimensions, parts placed on links, one mesh a part, and the result of `mass_report`."""

    dimensions: Dimensions
    assembly: Assembly
    meshes: MeshLibrary
    masses: dict[str, Any]


@dataclass(frozen=True)
class Outcome:
    """The result of a build or a check.

    Attributes:
        results: All checks.
        masses: Result of `mass_report`.
        folder: Where the files landed; None when none were written.
        unverified: Numbers of the bought parts whose data are not all verified against a datasheet.
        cost_EUR: Of one machine, estimated; None where it was not asked.
    """

    design: Design
    results: list[CheckResult]
    masses: dict[str, Any]
    folder: Path | None
    unverified: tuple[str, ...]
    cost_EUR: float | None = None

    @property
    def passed(self) -> bool:
        """Decides whether every check holds."""
        return all_passed(self.results)

    @cached_property
    def poor(self) -> list[str]:
        """Figures of a machine that passes which are worse than a default of feel that its design leaves out."""
        return poor_figures(self.design, self.masses) if self.passed else []

    def record(self) -> dict[str, Any]:
        """Facts of the build as JSON types."""
        return {
            "schema": "delta-checks/1",
            "name": self.design.name,
            "input_sha256": design_hash(self.design),
            "passed": self.passed,
            "poor": self.poor,
            "failed": [result.name for result in self.results if not result.passed],
            "total_mass_kg": self.masses["total_mass_kg"],
            "moving_mass_kg": self.masses["moving_mass_kg"],
            "cost_EUR": self.cost_EUR,
            "unverified_parts": list(self.unverified),
            "checks": [result.to_json() for result in self.results],
        }


def make_machine(design: Design, progress: _Progress = quiet) -> BuiltMachine:
    """Makes solids, placement, meshes and masses of a design.

    Raises:
        UnreachableError: A point of the cube is out of reach.
        DimensionError: A part cannot be given sound dimensions.
        BuildError: A solid could not be built.
    """
    from delta_cad.assembly.assemble import assemble  # loads the CAD kernel

    progress("dimensions")
    d = dimensions(design)
    assembly = assemble(d, lambda part: progress(f"solid {part}"))
    progress("masses")
    masses = mass_report(assembly)
    meshes = MeshLibrary(assembly.parts, LINEAR_MM, ANGULAR_RAD)
    for part in assembly.parts:
        progress(f"mesh {part.number}")
        meshes[part.number]
    return BuiltMachine(d, assembly, meshes, masses)


def check_limits(d: Dimensions, masses: Mapping[str, Any]) -> CheckLimits:
    """Gathers the limits that requirements and hardware put on the machine, with the masses that it has."""
    cube, required, (lowest, highest) = d.design.cube, d.design.requirements, d.stops_rad
    stated = Limits.stated(limit_values(d.design, known_masses(masses, d.design)))
    if (demand := stated.get(Shoulder)) is not None:
        lowest, highest = max(lowest, demand.shoulder_min), min(highest, demand.shoulder_max)
    return CheckLimits(
        bottom_height_mm=cube.bottom_height_mm,
        half_side_mm=cube.half_side_mm,
        envelope_width_mm=required.envelope_width_mm,
        envelope_depth_mm=required.envelope_depth_mm,
        clearance_min_mm=required.clearance_min_mm,
        pose=Limits.of(Lean(d.forearm.tilt_limit_rad), *stated, Shoulder(lowest, highest)),
        centre_x_mm=cube.centre_x_mm or 0.0,
    )


def checked(machine: BuiltMachine, progress: _Progress = quiet, sweep: Sweep | None = None) -> CheckedMachine:
    """Gives a machine as the checks see it."""
    d, masses = machine.dimensions, machine.masses
    held = check_limits(d, masses), machine.meshes, d, masses["bodies"]
    return CheckedMachine(machine.assembly, *held, progress, sweep or Sweep())


def check_weighed(machine: BuiltMachine) -> list[CheckResult]:
    """Runs the checks of a machine that take seconds: of ranges, of masses, loads and outline, of room for keys."""
    m = checked(machine)
    results = check_ranges(m.geometry, m.limits)
    if not all(result.passed for result in results if result.name == "reach"):
        return results
    results += check_structure(machine.dimensions, m.bodies)
    results += check_envelope(m.assembly, m.limits, m.meshes)[0]
    missing = missing_spread_mm(m.assembly, m.limits, m.meshes)
    detail = "what the base radius lacks for keys to reach the screws that stand still"
    return [*results, CheckResult("chains apart", missing <= 0.0, missing, 0.0, "mm", detail=detail)]


def check_moving(machine: BuiltMachine, progress: _Progress = quiet) -> Moved:
    """Runs the checks of a machine that look at what moves, see `fast_fail.check_moving`."""
    m = checked(machine)
    return fast_fail.check_moving(m.assembly, m.limits, m.meshes, progress)


def check(design: Design, progress: _Progress = quiet) -> Outcome:
    """Runs the checks of a design without any file; raises as `make_machine`."""
    with WorkerProcess(background_sweep.__name__) as sweeper:
        machine = make_machine(design, progress)
        results = run_checks(checked(machine, progress, Sweep(sweeper)))
    return Outcome(design, results, machine.masses, None, _unverified(machine))


def _unverified(machine: BuiltMachine) -> tuple[str, ...]:
    whole = (part for part in machine.assembly.parts if not part.piece_of)
    return tuple(p.number for p in (*whole, *machine.assembly.supplies) if p.source and "verified: yes" not in p.source)


def build(
    design: Design,
    out: Path,
    progress: _Progress = quiet,
    schema: str = "AP242",
    adjacent: Callable[[Path, Outcome], None] = lambda _folder, _outcome: None,
    drawings: bool = True,
    report: bool = True,
    made: BuiltMachine | None = None,
    clearance: MeshClearance | None = None,
) -> Outcome:
    """Builds a design into `out/<name>`, or into `out/<name>.rejected` when a check fails.

    Args:
        design: A validated design.
        out: Parent folder.
        progress: Told what is being done.
        schema: STEP schema, "AP242" or "AP214".
        adjacent: Called with the folder and what came of the machine, to write more files before the manifest.
        drawings: Whether drawings are made and checked, and the manual, too.
        report: Whether the page and the pictures are made.
        made: The design made solid, where that is known; None: it is made.
        clearance: What the meshes of what was made tell of it, mapped, from `check_moving`; None: it is computed.

    Raises:
        UnreachableError, DimensionError, BuildError: As `make_machine`; nothing is left behind.
    """
    with output_folder(out, design.name) as folder, ExitStack() as others:  # who fills it ends before it is taken away
        sweeper = others.enter_context(WorkerProcess(background_sweep.__name__))
        writer = others.enter_context(WorkerProcess(mesh_files.__name__, low_priority=True))
        draughtsman = others.enter_context(WorkerProcess(_DRAWINGS, low_priority=True)) if drawings else None
        narrator = others.enter_context(WorkerProcess(manual.__name__, low_priority=True)) if drawings else None
        machine, sweep = made or make_machine(design, progress), Sweep(sweeper, report, clearance)
        bare = machine.assembly.without_solids()
        meshes = {part.number: machine.meshes[part.number] for part in bare.parts}
        if draughtsman is not None:
            draughtsman.send((machine.dimensions, machine.assembly, machine.masses, folder.path))
        if narrator is not None:
            narrator.send((machine.dimensions, bare, meshes, machine.masses, folder.path))
        fingerprints: list[str] = []
        costs: list[Cost] = []
        drawn: list[Drawn] = []  # of the machine as a whole

        def meanwhile() -> None:
            moves = (machine.masses, drive_torque(design), machine.dimensions.stops_rad)
            moves += (design.requirements.gravity_m_s2, joint_friction(design))
            writer.send((bare, meshes, folder.path, _stage(machine, sweep) if report else None, moves))
            progress("costs")
            costs.append(cost_of(machine))
            fingerprints.append(write_files(machine, costs[0], folder.path, progress, schema))
            if drawings:
                drawn.append(write_whole(machine, folder.path, progress))
                drawn[0] += write_jigs_of(machine, folder.path, progress)

        results = run_checks(checked(machine, progress, sweep), meanwhile)
        if draughtsman is not None:
            progress("drawings")
            results = [*results, check_drawings(draughtsman.receive() + drawn[0])]
        folder.rejected = not all_passed(results)
        landed = f"{design.name}.rejected" if folder.rejected else design.name
        unverified = _unverified(machine)
        outcome = Outcome(design, results, machine.masses, out / landed, unverified, costs[0].total_EUR())
        (folder.path / "checks.json").write_text(json.dumps(outcome.record(), indent=1) + "\n", encoding="utf-8")
        progress("meshes and pictures" if report else "meshes")
        mesh_files.written(writer)
        if drawings:
            progress("quotation")
            write_quotation_of(machine, folder.path)
        if narrator is not None:
            progress("manual")
            mesh_files.written(narrator)
        adjacent(folder.path, outcome)
        if report:
            progress("report.html")
            _report(machine, sweep, outcome, folder.path)
            progress(ARCHIVE)
            write_archive(folder.path, design.name)
        progress("manifest")
        status = "rejected" if folder.rejected else "passed"
        write_manifest(
            folder.path,
            input_hash=design_hash(design),
            status=status,
            fingerprint=fingerprints[0],
            left_out=(
                *(() if drawings else ("drawings", "manual", "quotation", "jigs")),
                *(() if report else ("report", "pictures", "archive")),
            ),
        )
    return outcome


def write_whole(machine: BuiltMachine, folder: Path, progress: _Progress) -> Drawn:
    """Draws a machine as a whole into the folder of its build; its parts are drawn by another process meanwhile."""
    from delta_cad.export.drawings.write import FOLDER, write_whole_drawing  # loads the CAD kernel

    return write_whole_drawing(machine.dimensions, machine.assembly, machine.masses, folder / FOLDER, progress)


def write_jigs_of(machine: BuiltMachine, folder: Path, progress: _Progress) -> Drawn:
    """Writes a machine's jigs, STEP files and drawings, into the folder of its build."""
    from delta_cad.export.shop.jigs import FOLDER, write_jigs  # loads the CAD kernel

    progress("jigs")
    return write_jigs(machine.dimensions, folder / FOLDER)


def check_drawings(drawn: Drawn) -> CheckResult:
    """Gives the verdict on a machine's drawings: all of them there, all told in them, nothing over anything."""
    count = sum(len(faults) for faults in drawn.faults.values())
    worst = next(iter(drawn.faults), None)
    reported = f"{drawn.count} drawings: every bore and coordinate told once, no text over an edge or another"
    if drawn.missing:
        reported += f"; shown by a substitute: {', '.join(sorted(drawn.missing))}"
    if worst is not None:
        reported = f"{worst}: {'; '.join(drawn.faults[worst][:3])}"
    pair = None if worst is None else (worst,)
    return CheckResult("drawings", not count, count, 0.0, "", worst_pair=pair, detail=reported, kind="Drawings")


def cost_of(machine: BuiltMachine) -> Cost:
    """Computes what a machine costs, clamped as often as the rules of a shop find."""
    made = (part for part in machine.assembly.parts if part.make)
    clampings = {part.number: round(next(setups(part)).value) for part in made}
    return machine_cost(machine.dimensions, machine.assembly, clampings)


def write_files(machine: BuiltMachine, cost: Cost, folder: Path, progress: _Progress, schema: str) -> str:
    """Writes what a machine comes to into a folder, all but its checks, manifest and what meshes alone tell.

    Returns:
        The content fingerprint of `assembly.step`.
    """
    from delta_cad.assembly.printing import print_mesh
    from delta_cad.export.drawings.part.controlled import Controlled, controlled
    from delta_cad.export.meshes import write_3mf
    from delta_cad.export.shop.jigs import jig_rows
    from delta_cad.export.step import write_assembly_step, write_part_step  # load the CAD kernel

    d, assembly = machine.dimensions, machine.assembly
    progress("assembly.step")
    whole, revision = folder / "assembly.step", d.design.drawn_revision

    def written() -> tuple[bytes, str]:
        fingerprint = write_assembly_step(assembly, whole, schema, revision)
        return whole.read_bytes(), fingerprint

    solids = [part_digest(part) for part in assembly.parts]
    content, fingerprint = cached("assembly step", (assembly.without_solids(), solids, schema, revision), written)
    whole.write_bytes(content)
    parts = folder / "parts"
    parts.mkdir(exist_ok=True)  # another process writes meshes there
    general, held = general_class(d), controlled(d)
    for part in assembly.parts:
        if part.is_drawn:
            progress(f"parts/{part.number}")
            path, tolerances = parts / f"{part.number}.step", held.get(part.number)

            def step(part: Part = part, path: Path = path, tolerances: Controlled | None = tolerances) -> bytes:
                write_part_step(part, path, schema, general, tolerances, revision)
                return path.read_bytes()

            path.write_bytes(cached("part step", (part_digest(part), schema, general, tolerances, revision), step))
        if part.make and part.material.process:
            write_3mf(print_mesh(part), parts / f"{part.number}.3mf", part.number, part.description, part.material.name)
    progress("tables")
    unit_mass = {number: body["mass_kg"] for number, body in machine.masses["parts"].items()}
    rows = bill_of_materials(assembly, unit_mass, cost)
    write_bom([*rows, *jig_rows(d, len(rows) + 1)], folder)
    write_holes(hole_list(assembly), folder / "holes.csv")
    if d.panel is not None:
        write_template(d.panel, folder)
    write_profiles(assembly.parts, folder / PROFILES)
    masses = machine.masses | {"input_sha256": design_hash(d.design)}
    bears = structure_record(d, structure_report(d, machine.masses["bodies"]))
    texts = {
        "design.json": design_to_json(d.design),
        "cost.json": json.dumps(cost_record(cost), indent=1) + "\n",
        "tolerances.json": json.dumps(tolerance_record(d), indent=1) + "\n",
        "structure.json": json.dumps(bears | {"input_sha256": design_hash(d.design)}, indent=1) + "\n",
        "mass_properties.json": json.dumps(masses, indent=1) + "\n",
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    return fingerprint


def write_quotation_of(machine: BuiltMachine, folder: Path) -> None:
    """Packs what a shop asks for into the folder of a build, which holds parts, drawings and profiles."""
    from delta_cad.export.shop.jigs import quoted_jigs
    from delta_cad.export.shop.quotation import quoted_parts, write_quotation  # load the CAD kernel

    unit_mass = {number: body["mass_kg"] for number, body in machine.masses["parts"].items()}
    d = machine.dimensions
    write_quotation([*quoted_parts(d, machine.assembly, unit_mass), *quoted_jigs(d)], folder)


def _report(machine: BuiltMachine, sweep: Sweep, outcome: Outcome, folder: Path) -> None:
    """Writes the page of a build into its folder, which holds all else but the manifest."""
    subject = Subject(
        dimensions=machine.dimensions,
        assembly=machine.assembly,
        meshes=machine.meshes,
        masses=machine.masses,
        limits=check_limits(machine.dimensions, machine.masses),
        results=outcome.results,
        stage=_stage(machine, sweep),
        reach_mm=sweep.reach_mm,
        unverified=outcome.unverified,
        near=sweep.over,
    )
    write_report(subject, folder, versions(), poor_verdict(outcome.poor))


def _stage(machine: BuiltMachine, sweep: Sweep) -> Stage:
    """The outline the way round in which it fits best, around the swept machine, and the cube."""
    d = machine.dimensions
    cube, required = d.design.cube, d.design.requirements
    upright = (required.envelope_width_mm, required.envelope_depth_mm)
    turned = (required.envelope_depth_mm, required.envelope_width_mm)
    reach = sweep.reach_mm
    if reach is None:  # a rejected design: its outline has no bound
        reach = np.full(4, d.bracket.shoulder_u_mm + max(d.outs_mm) + d.arm.length_mm)
    size = reach[0::2] + reach[1::2]
    x, y = (reach[0::2] - reach[1::2]) / 2
    fits = min((upright, turned), key=lambda sides: max(size[0] - sides[0], size[1] - sides[1]))
    return Stage(fits, (float(x), float(y)), cube.bottom_height_mm, cube.half_side_mm, cube.centre_x_mm or 0.0)
