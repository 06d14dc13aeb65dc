"""`certify`: proof of a design over every point of its cube, and the certificate of it."""

from __future__ import annotations

import argparse
import json
import math
import sys
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING

from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, ProgressLine, refuse
from delta_cad.common.files import require_room
from delta_cad.common.options import (
    CATALOGUE,
    DESIGN,
    JSON,
    MASS_PROPERTIES,
    POSITIVE,
    Option,
    number,
    proof_minutes,
    whole,
)

if TYPE_CHECKING:
    from delta_cad.design import Design
    from delta_cad.mechanism.limits import HandleInertia
    from delta_cad.mechanism.proof.prove import Progress
    from optimizer.certify.certificate import Certificate
    from optimizer.certify.gravity import GravityAllowance
    from optimizer.certify.tolerance import LargestTolerance

NAME = "certify"
TEXT = "prove the limits of a design at every point of its cube; writes a certificate for `verify`"


_MAX, _PARTS = "max", "parts"


class _UnprovableError(ValueError):
    """A requirement beyond what the prover's arithmetic takes; the message names its field."""


OPTIONS = (
    DESIGN,
    CATALOGUE,
    Option(
        "--out",
        type=Path,
        default=Path("certificate.json"),
        metavar="FILE",
        help="certificate to write; default: certificate.json",
    ),
    (
        MASS_PROPERTIES.but(
            help="mass_properties.json of a build, to include the weight of the moving parts in the torque and to "
            "prove effective_mass_max_kg; default: out/NAME/mass_properties.json, if that is of this design",
        ),
        Option(
            "--gravity-torque", type=float, metavar="N_m", help="torque to reserve for gravity at every joint instead"
        ),
    ),
    (
        Option(
            "--tight",
            action="store_true",
            help="certify the tightest limits that can be proved, not only the required ones",
        ),
        Option(
            "--tolerance",
            type=number(POSITIVE, unit="mm", words=(_MAX, _PARTS)),
            metavar="MM|max|parts",
            help="certify every machine whose lengths and offsets, of each chain separately, deviate by at most this; "
            "max: the largest deviation that can be proved, to 1 %%; parts: that of the tolerances of the parts",
        ),
    ),
    Option(
        "--max-boxes",
        type=whole(0),
        default=5_000_000,
        metavar="N",
        help="boxes to examine before giving up; default: 5000000",
    ),
    proof_minutes("of all proofs together"),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.design import DesignError, load_design
    from delta_cad.drive.masses import MassError
    from delta_cad.mechanism import GeometryError
    from optimizer.certify.gravity import GravityError

    try:
        design = load_design(given.design, given.catalogue)
        if given.tolerance == _PARTS:
            given.tolerance = _of_parts(design)
        _require_tolerance(design, given.tolerance)
        require_room(given.out)
        if given.mass_properties is None and given.gravity_torque is None:
            given.mass_properties = _masses_of_build(design)
        share = _allowance_of(design, given.mass_properties, given.gravity_torque)
        inertia = None if given.mass_properties is None else _known_inertia(design, given.mass_properties)
        return _certify(given, design, share, inertia)
    except (DesignError, GravityError, MassError, _UnprovableError) as error:
        return refuse(str(error), BAD_INPUT)
    except GeometryError as error:
        return refuse(f"{given.design.name}: {error}", BAD_INPUT)


def _masses_of_build(design: Design) -> Path | None:
    """Finds the masses of the design's build in this folder, and says so; None where there is none, or of another."""
    from delta_cad.drive.masses import MassError, load_masses

    path = Path("out") / design.name / "mass_properties.json"
    try:
        load_masses(path, design)
    except MassError:
        return None
    print(f"--mass-properties {path}: taken, as none was given", file=sys.stderr, flush=True)
    return path


def _provable(file: str, design: Design, inertia: HandleInertia | None) -> Design:
    """Leaves out the limit that needs masses where none are known, and says so."""
    mass = design.requirements.effective_mass_max_kg
    if mass is None or inertia is not None:
        return design
    print(
        f"{file}: requirements.effective_mass_max_kg = {mass:g} is left out, it needs the masses of what moves: give "
        "--mass-properties, the mass_properties.json of a build; it is not proved: exit code 1",
        file=sys.stderr,
        flush=True,
    )
    return design.model_copy(
        update={"requirements": design.requirements.model_copy(update={"effective_mass_max_kg": None})}
    )


def _of_parts(design: Design) -> float:
    """Computes what the tolerances of a machine's parts come to in its lengths, mm, rounded up to a micrometre."""
    from delta_cad.dimensions import DimensionError, dimensions
    from delta_cad.dimensions.tolerances.machine import general_class, largest_deviation_mm

    try:
        d = dimensions(design)
    except DimensionError as error:
        raise _UnprovableError(f"{design.name}: --tolerance {_PARTS} needs parts: {error}") from None
    return math.ceil(1000.0 * largest_deviation_mm(d, general_class(d)) - 1e-9) / 1000.0


def _require_tolerance(design: Design, requested: float | str | None) -> None:
    """Refuses a tolerance that is not small beside the links."""
    from delta_cad.common.units import MM_PER_M
    from delta_cad.mechanism.geometry import largest_tolerance

    most = largest_tolerance(design.geometry) * MM_PER_M
    if isinstance(requested, float) and requested > most:
        raise _UnprovableError(f"--tolerance = {requested:g}: must be at most {most:g} mm, a tenth of the shorter link")


def _allowance_of(
    design: Design, masses: Path | None, reserve: float | None, tolerance: float = 0.0
) -> GravityAllowance | None:
    """Computes what is taken off for gravity, by `mass_properties.json` of a build or by a torque given by hand, N m.

    Raises:
        GravityError: The file or the number is refused.
    """
    from optimizer.certify.gravity import allowance_of_masses, given_allowance

    if masses is not None:
        return allowance_of_masses(masses, design, tolerance)
    return None if reserve is None else given_allowance(design, reserve)


def _known_inertia(design: Design, masses: Path) -> HandleInertia | None:
    """Reads what moves; None where the file says too little of it and no limit needs it."""
    from delta_cad.drive.masses import MassError, load_masses

    try:
        return load_masses(masses, design).handle_inertia
    except MassError:
        if design.requirements.effective_mass_max_kg is not None:
            raise
        return None


def _certify(
    given: argparse.Namespace, design: Design, share: GravityAllowance | None, inertia: HandleInertia | None
) -> int:
    from delta_cad.mechanism import UnreachableError
    from delta_cad.mechanism.limits import Limits
    from delta_cad.mechanism.proof.extremes import worst_figures
    from optimizer.certify import report
    from optimizer.certify.bounds import bounds, tightened
    from optimizer.certify.certificate import CertificateError, certify, limits_of, values_of
    from optimizer.certify.file import write_certificate

    geometry, cube, provable = design.geometry, design.workspace, _provable(given.design.name, design, inertia)
    limits = limits_of(provable, share, inertia)
    with ProgressLine() as line:
        progress = _Clock(line, given.proof_minutes)
        line.show("searching the cube")
        try:
            worst = worst_figures(geometry, cube, Limits.measured(values_of(provable, inertia, share)))
        except UnreachableError:
            worst = []
        line.show("loading the prover; it is compiled once on a machine, in some 20 s")
        certificate = certify(
            design, limits, gravity=share, max_boxes=given.max_boxes, progress=progress("the limits asked")
        )
        proved_bounds = bounds(geometry, cube, worst, progress("the tightest limits"))
        written = certificate
        if given.tight and certificate.verdict == "proved":
            tight = tightened(limits, proved_bounds)
            written = certify(
                design,
                tight,
                gravity=share,
                max_boxes=given.max_boxes,
                progress=progress("all of them together"),
            )
            written = written if written.verdict == "proved" else certificate
        largest = None
        if given.tolerance is not None and certificate.verdict == "proved":
            written, largest = _within(
                given, design, provable, inertia, certificate, progress("all machines within a tolerance")
            )
    rows = report.report_rows(certificate, proved_bounds)
    try:
        write_certificate(written, given.out)
    except CertificateError as error:
        return refuse(str(error), NOT_MET)
    if given.json:
        data = report.facts(certificate, rows) | {
            "certificate": str(given.out),
            "tight": largest is None and written is not certificate,
            "tolerance": report.tolerance_facts(written, largest),
        }
        print(json.dumps(data, indent=1))
    else:
        side, low = 2.0 * design.cube.half_side_mm, design.cube.bottom_height_mm
        verdict = "proved at every point" if certificate.verdict == "proved" else certificate.verdict
        print(f"{design.name}: {verdict} of the cube of {side:g} mm, {low:g} to {low + side:g} mm high")
        print(report.table(rows))
        print(report.gravity_sentence(certificate))
        about = "the limits asked" if written is certificate else "the column `proved`"
        if largest is not None:
            print(report.tolerance_sentence(written, largest))
            about = f"the limits asked, within {report.mm(written.tolerance)} mm" if written.tolerance > 0.0 else about
        print(f"{given.out} is about {about}: {written.boxes} boxes examined, {len(written.leaves)} kept")
    unanswered = largest is not None and largest.late == "largest" and given.tolerance == _MAX
    if largest is not None and (unanswered or written.verdict != "proved"):
        return refuse(f"{given.design.name}: {report.tolerance_sentence(written, largest)}", NOT_MET)
    if given.tight and certificate.verdict == "proved" and written is certificate and progress.over:
        tighter = "the time was over before the tightest limits were proved together: raise --proof-minutes"
        return refuse(f"{given.design.name}: {tighter}", NOT_MET)
    if certificate.verdict == "proved":
        return DONE if provable is design else NOT_MET  # a limit that is stated was left out, as was said
    reasons = dict.fromkeys(report.shortfall(row) for row in report.broken(rows))
    if progress.over and certificate.verdict == "undecided":
        reasons[f"the time was over after {certificate.boxes} boxes: raise --proof-minutes"] = None
    return refuse(f"{given.design.name}: {'; '.join(reasons)}", NOT_MET)


def _within(
    given: argparse.Namespace,
    design: Design,
    provable: Design,
    inertia: HandleInertia | None,
    drawn: Certificate,
    progress: Progress,
) -> tuple[Certificate, LargestTolerance]:
    """Makes the certificate of all machines within the tolerance asked, or the largest, which is looked for anyway.

    Where no tolerance is proved it is that of the drawn machine.
    """
    from delta_cad.common.units import MM_PER_M
    from optimizer.certify.certificate import certify, limits_of
    from optimizer.certify.tolerance import search_tolerance

    def share(about: float) -> GravityAllowance | None:
        return _allowance_of(design, given.mass_properties, given.gravity_torque, about)

    def within(tolerance: float, tell: Progress) -> Certificate:
        gravity = share(tolerance)
        return certify(
            design,
            limits_of(provable, gravity, inertia),
            gravity=gravity,
            tolerance=tolerance,
            max_boxes=given.max_boxes,
            progress=tell,
        )

    requested = None if given.tolerance == _MAX else given.tolerance / MM_PER_M
    written = None if requested is None else within(requested, progress)  # the required tolerance before the largest
    largest = search_tolerance(
        design.geometry, design.workspace, lambda about: limits_of(provable, share(about), inertia), requested, progress
    )

    def tell(boxes: int, part: float) -> None:  # and end nothing: the search has just proved it, in a second or two
        progress(boxes, part)

    if written is None:
        written = within(largest.tolerance, tell) if largest.tolerance > 0.0 else drawn
    return written, largest


class _Clock:
    """Shows progress of a command's proofs and ends them when their time is over."""

    def __init__(self, line: ProgressLine, minutes: float) -> None:
        self._line, self._deadline = line, monotonic() + 60.0 * minutes
        self.over = False

    def __call__(self, what: str) -> Progress:
        """Gives the progress callback of one proof."""

        def tell(boxes: int, share: float) -> bool:
            self._line.show(f"proving {what}: {boxes} boxes, {share:.1%} of the cube")
            self.over = monotonic() > self._deadline
            return self.over

        return tell
