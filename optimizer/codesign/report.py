"""What `design` writes beside a build: the design file, its certificate, and how it was found."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.checks.range.feel import poor_verdict
from delta_cad.design import Design, design_to_json
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import load_masses
from delta_cad.report.page import SOUGHT
from optimizer.certify.certificate import Certificate, certify, limits_of
from optimizer.certify.file import certificate_text
from optimizer.certify.gravity import share_of_masses
from optimizer.codesign.costs import Cost
from optimizer.codesign.figures import FIGURES, binding, results_of, set_limits
from optimizer.codesign.search_log import SearchLog, Verdict
from optimizer.problem.brief import DesignBrief, brief_hash

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome
    from optimizer.codesign.bound import Bound

UNITS = {"cube_side": "mm of cube", "outline": "mm of width and depth", "effective_mass": "kg felt", "cost": "EUR"}
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


def facts_of(brief: DesignBrief, outcome: Outcome, log: SearchLog, bound: Bound | None) -> dict[str, Any]:
    """Gives what came of a run as JSON types.

    Args:
        brief: What was asked.
        outcome: The machine that passed.
        log: What the search went through.
        bound: What is proved of the machine's family; None where the cube is not what is sought.
    """
    design, values = outcome.design, results_of(outcome)
    drive = drive_torque(design)
    return {
        "name": brief.name,
        "verdict": str(Verdict.BUILT),
        "passed": outcome.passed,
        "objective": brief.objective,
        "bound_mm": None if bound is None else bound.side_mm,
        "gap": None if bound is None else bound.gap,
        "bound": NO_BOUND if bound is None else bound.statement,
        **{one.key: values.get(one.key) for one in FIGURES},
        "outline_mm": [values.get(f"outline_{side}_mm") for side in ("width", "depth")],
        "cost_EUR": outcome.cost_EUR,
        "motor": drive.motor,
        "ratio": drive.ratio,
        "moving_mass_kg": outcome.masses["moving_mass_kg"],
        "total_mass_kg": outcome.masses["total_mass_kg"],
        "binding": [one.figure.field for one in binding(brief, values)],
        "poor": outcome.poor,
        "folder": None if outcome.folder is None else str(outcome.folder),
        "tried": log.candidates,
        "built": len(log.built),
        "nearest": None,
    }


EMPTY = ("cube_side_mm", "bound_mm", "gap", *(one.key for one in FIGURES), "outline_mm", "motor", "ratio", "folder")
"""Keys of the facts that have no value where no machine stands."""


def no_facts(name: str, ends: Verdict, log: SearchLog, nearest: dict[str, Any]) -> dict[str, Any]:
    """Gives what came of a run without a machine as JSON types.

    Args:
        name: Of the requirements.
        ends: The verdict.
        log: What the search went through.
        nearest: Facts of the machine of the nearest requirements that have one; {} for none.
    """
    facts: dict[str, Any] = {"name": name, "verdict": str(ends), "passed": False} | dict.fromkeys(EMPTY)
    return facts | {"binding": [], "poor": [], "tried": log.candidates, "nearest": nearest or None}


def headline(facts: dict[str, Any]) -> str:
    """Gives the figures that are always told first in one line."""
    told = (f"{one.words} {facts[one.key]:.3g} {one.unit}" for one in FIGURES if one.head and facts[one.key])
    return ", ".join(told)


def shown(facts: dict[str, Any]) -> str:
    """States in what a machine is a poor haptic device, or else its figures that come first."""
    return poor_verdict(facts["poor"]) or headline(facts)


def _lines_of(brief: DesignBrief, facts: dict[str, Any]) -> list[str]:
    """Lists the results, each with the limit that is set, a line each."""
    limits = {one.figure.key: one for one in set_limits(brief, facts)}
    return [
        f"- {limits[one.key]} set" if one.key in limits else f"- {one.words} {facts[one.key]:.4g} {one.unit}".rstrip()
        for one in FIGURES
        if facts[one.key] is not None
    ]


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
    brief: DesignBrief,
    told: dict[str, Any],
    log: SearchLog,
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
        f"{headline(told)[:1].upper()}{headline(told)[1:]}.",
        "",
        *((f"**{poor_verdict(told['poor'])}**", "") if told["poor"] else ()),
        "## Results",
        "",
        *_lines_of(brief, told),
        "",
        *_of_bound(bound),
        "## What binds",
        "",
        *(f"- {one.figure.field} = {one.limit:g}: {one.value:.4g}" for one in binding(brief, told)),
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
            for design, failed in log.built
        ),
        *(f"- {hardware}: given up, {reason}" for hardware, reason in log.no_progress.items()),
        "",
        *(("## What was learnt on the way", "") if why else ()),
        *(f"- {reason}" for reason in why),
        "",
        *(f"Note: {note}" for note in notes),
    ]
    return "\n".join(lines).rstrip() + "\n"
