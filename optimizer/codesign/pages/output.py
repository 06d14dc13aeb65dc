"""What `design` writes beside a build: the design file, its certificate, and how it was found."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.design import Design, design_to_json
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import load_masses
from delta_cad.report.page import SOUGHT
from optimizer.certify.certificate import Certificate, certify, limits_of
from optimizer.certify.file import certificate_text
from optimizer.certify.gravity import share_of_masses
from optimizer.codesign.costs import Cost
from optimizer.codesign.tried import Tried
from optimizer.problem.brief import DesignBrief, brief_hash

if TYPE_CHECKING:
    from delta_cad.checks.report import CheckResult
    from delta_cad.commands.pipeline import Outcome
    from optimizer.codesign.bound import Bound

BINDS = 0.01  # share of a limit within which it binds
FIGURES = {
    "effective mass": "effective_mass_max_kg",
    "structure stiffness at the knob": "stiffness_min_N_mm",
    "envelope width": "envelope_width_mm",
    "envelope depth": "envelope_depth_mm",
    "clearance": "clearance_mm",
    "torque with gravity": "holding_torque_N_m",
    "structure first mode": "first_mode_Hz",
    "friction": "friction_max_N",
    "position step": "position_step_max_mm",
    "kappa": "kappa_max",
}
"""Name of a check -> key of its value among the facts."""
UNITS = {
    "cube_side": "mm of cube",
    "outline": "mm of width and depth",
    "effective_mass": "kg felt",
    "cost": "EUR",
}
OUTLINE = ("envelope width", "envelope depth")
NO_BOUND = "none"  # of a bound that is not proved


def with_provenance(design: Design, brief: DesignBrief, command: str, seed: int) -> Design:
    """Gives a design that says where it comes from."""
    told = {
        "program": "optimizer design",
        "version": importlib.metadata.version("delta-haptics"),
        "command": command,
        "seed": seed,
        "requirements_sha256": brief_hash(brief),
    }
    return design.model_copy(update={"provenance": told})


def placed(design: Design, brief: DesignBrief, folder: Path) -> Design:
    """Gives a design whose file stands in a folder, from which it names that of own parts."""
    if design.hardware.catalogue is None:
        return design
    own = brief.hardware_from(folder, {})["catalogue"]
    return design.model_copy(update={"hardware": design.hardware.model_copy(update={"catalogue": own})})


def certificate_of(design: Design, masses: Path) -> Certificate:
    """Certifies a machine that was built, with its own masses.

    Args:
        design: The design.
        masses: `mass_properties.json` of its build.
    """
    share = share_of_masses(masses, design)
    inertia = load_masses(masses, design).handle_inertia
    return certify(design, limits_of(design, share, inertia), gravity=share)


def write_design(folder: Path, design: Design) -> None:
    """Writes `design.json` into the folder of a build."""
    (folder / "design.json").write_text(design_to_json(design), encoding="utf-8")


def write_beside(folder: Path, design: Design, text: str, page: str, certificate: Certificate) -> None:
    """Writes `design.json`, `design.md`, `design.html` and `certificate.json` into the folder of a build."""
    (folder / SOUGHT).write_text(page, encoding="utf-8")
    write_design(folder, design)
    (folder / "design.md").write_text(text, encoding="utf-8")
    text = certificate_text(certificate, "certificate.json")  # the folder's own lock is held by the build
    (folder / "certificate.json").write_text(text, encoding="utf-8")


def binding(results: Iterable[CheckResult]) -> list[str]:
    """Names the checks whose value is within a hundredth of its limit; at it stands what was stated or counted."""
    found = []
    for one in results:
        if one.value is None or not one.limit or one.name.startswith(("solid ", "running gap")):
            continue
        if 0.0 < abs(one.value - one.limit) <= BINDS * abs(one.limit):
            found.append(one.name)
    return found


def facts_of(brief: DesignBrief, outcome: Outcome, tried: Tried, bound: Bound | None) -> dict[str, Any]:
    """Gives what came of a run as JSON types.

    Args:
        brief: What was asked.
        outcome: The machine that passed.
        tried: What the search went through.
        bound: What is proved of the machine's family; None where the cube is not what is sought.
    """
    design, values = outcome.design, {one.name: one.value for one in outcome.results}
    figures = {key: values.get(name) for name, key in FIGURES.items() if name not in OUTLINE}
    outline = [values.get(name) for name in OUTLINE]
    drive = drive_torque(design)
    return {
        "name": brief.name,
        "passed": outcome.passed,
        "objective": brief.objective,
        "cube_side_mm": 2.0 * design.cube.half_side_mm,
        "bound_mm": None if bound is None else bound.side_mm,
        "gap": None if bound is None else bound.gap,
        "bound": NO_BOUND if bound is None else bound.statement,
        **figures,
        "outline_mm": outline,
        "cost_EUR": outcome.cost_EUR,
        "motor": drive.motor,
        "ratio": drive.ratio,
        "moving_mass_kg": outcome.masses["moving_mass_kg"],
        "total_mass_kg": outcome.masses["total_mass_kg"],
        "binding": binding(outcome.results),
        "folder": None if outcome.folder is None else str(outcome.folder),
        "tried": tried.candidates,
        "built": len(tried.built),
        "nearest": None,
    }


def figures_of(results: Iterable[CheckResult]) -> list[str]:
    """Lists what is felt of a machine and what it leaves, beside what was asked, a line each."""
    known = {one.name: one for one in results}
    lines = []
    for name in FIGURES:
        if (one := known.get(name)) is None or one.value is None:
            continue
        asked = "" if one.limit is None else f", {one.limit:.4g} asked"
        lines.append(f"- {name.removeprefix('structure ')}: {one.value:.4g} {one.unit}".rstrip() + asked)
    return lines


def _of_bound(bound: Bound | None) -> list[str]:
    """States what is proved of a machine's family, or that nothing is."""
    title = ["## Proved bound", ""]
    return (
        [*title, NO_BOUND.capitalize() + ".", ""]
        if bound is None
        else [
            *title,
            f"{bound.statement} What lies between:",
            "",
            *(f"- {part:.2f} mm: {what}" for what, part in bound.losses),
            "",
            "Those machines also have",
            "",
            *(f"- {line}" for line in bound.family),
            "",
        ]
    )


def _price(cost_EUR: float | None) -> str:
    """Tells what a machine costs, "" where it is not known."""
    return "" if cost_EUR is None else f"; about {cost_EUR:.0f} EUR for one, by estimate, see cost.json"


def report(
    told: dict[str, Any],
    results: Iterable[CheckResult],
    tried: Tried,
    why: Iterable[str],
    notes: Iterable[str],
    costs: Iterable[Cost],
    bound: Bound | None,
) -> str:
    """Writes `design.md`: what was reached, what binds, what each limit costs, what was tried and what it taught."""
    width, depth = told["outline_mm"]
    unit = UNITS[told["objective"]]
    lines = [
        f"# {told['name']}",
        "",
        f"A cube of {told['cube_side_mm']:.2f} mm, with {told['motor']} at {told['ratio']:g}:1, within "
        f"{width:.1f} x {depth:.1f} mm as built{_price(told['cost_EUR'])}.",
        "",
        "## Figures",
        "",
        *figures_of(results),
        "",
        *_of_bound(bound),
        "## What binds",
        "",
        *(f"- {name}" for name in told["binding"]),
        "",
        "## What each limit costs",
        "",
        "Estimated with this hardware and what was learnt of it:",
        "",
        *(f"- {one.field} = {one.wider:g} instead of {one.asked:g}: {one.gain:.3g} {unit} better" for one in costs),
        "",
        "## What was tried",
        "",
        f"{told['tried']} candidates; machines built: {told['built']}",
        "",
        *(
            f"- {2.0 * design.cube.half_side_mm:.2f} mm with {design.hardware.motor}: "
            + (f"fails {', '.join(failed)}" if failed else "passes every check")
            for design, failed in tried.built
        ),
        *(f"- {hardware}: given up, {reason}" for hardware, reason in tried.stuck.items()),
        "",
        *(("## What was learnt on the way", "") if why else ()),
        *(f"- {reason}" for reason in why),
        "",
        *(f"Note: {note}" for note in notes),
    ]
    return "\n".join(lines).rstrip() + "\n"
