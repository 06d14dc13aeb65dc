"""The report of `design`: results next to set limits, JSON, `design.md`, `design.html`, certificate.

A limit that the user's file sets, a value derived from it or from the machine, and a result are three things: a result
is held here against set limits, never against what was derived.
"""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from scipy.optimize import brentq

from delta_cad.checks.range.feel import feel_figures, poor_verdict
from delta_cad.design import Design, design_to_json
from delta_cad.design.task import LEAST
from delta_cad.dimensions import dimensions
from delta_cad.drive import drive_torque
from delta_cad.drive.held import held_masses
from delta_cad.drive.masses import load_masses
from delta_cad.mechanism.limits import HoldingTorque
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.workspace import CubeSearch
from delta_cad.report.page import FILE_NAME, SEARCHED
from optimizer.certify.certificate import Certificate, certify, limits_of
from optimizer.certify.file import certificate_text
from optimizer.certify.gravity import allowance_of_masses
from optimizer.codesign.page import Scale, rendered
from optimizer.codesign.relaxation import Cost
from optimizer.codesign.search_log import SearchLog, Trial, Verdict, worded
from optimizer.problem.brief import DesignBrief, brief_hash
from optimizer.problem.variables import is_symmetric

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome
    from optimizer.codesign.bound import Bound
    from optimizer.codesign.candidate import Candidate

_UNITS = {
    "cube_side": "mm of cube",
    "outline": "mm of width and depth",
    "effective_mass": "kg effective mass",
    "cost": "EUR",
}
_NO_BOUND = "none"  # of a bound that is not proved
_WIDTH, _LEFT, _ROW, _TOP = 960, 250, 26, 34
_STYLE = """
.tried { max-width: none; vertical-align: middle; }
.tried text { font-size: 12px; fill: var(--ink); }
.tried .grid { stroke: var(--line); }
.tried line.proved { stroke: var(--accent); stroke-dasharray: 5 3; }
.tried text.proved { fill: var(--accent); }
.tried .posed { fill: none; stroke: var(--soft); }
.tried .failed { fill: var(--bad); fill-opacity: 0.8; }
.tried .passed { fill: var(--good); stroke: var(--paper); }
#tried table { max-width: 900px; }
meter { width: 12rem; }
"""
_BINDS = 0.01  # share of a set limit within which a result binds
_FORCE_ROOM_N = 1e-5  # to which a force is found, rather too little


@dataclass(frozen=True)
class _Figure:
    """A result.

    Attributes:
        key: Among the facts of a run.
        words: What a person reads.
        unit: Unit; "" for none.
        field: Table and field of the requirements that limits it; "" for none.
        least: Whether that is the least it may be; else the most.
        check: Name of the check that finds it, if it is among the checks; "" where none does.
        head: Whether it is in the headline.
    """

    key: str
    words: str
    unit: str
    field: str = ""
    least: bool = False
    check: str = ""
    head: bool = False


FIGURES = (
    _Figure("cube_side_mm", "cube", "mm", "requirements.cube_side_mm", True),
    _Figure("force_N", "continuous force", "N", "requirements.force_N", True, head=True),
    _Figure("peak_force_N", "peak force", "N", "requirements.peak_force_N", True, head=True),
    _Figure(
        "effective_mass_max_kg", "effective mass", "kg", "feel.effective_mass_max_kg", check="effective mass", head=True
    ),
    _Figure("friction_max_N", "friction", "N", "feel.friction_max_N", check="friction", head=True),
    _Figure(
        "stiffness_min_N_mm",
        "stiffness",
        "N/mm",
        "feel.stiffness_min_N_mm",
        True,
        "structure stiffness at the knob",
        True,
    ),
    _Figure("height_mm", "height", "mm", "requirements.height_max_mm", check="height", head=True),
    _Figure("outline_width_mm", "outline, width", "mm", "requirements.envelope_width_mm", check="envelope width"),
    _Figure("outline_depth_mm", "outline, depth", "mm", "requirements.envelope_depth_mm", check="envelope depth"),
    _Figure("outline_radius_mm", "R + L_A", "mm", "limits.outline_radius_max_mm"),
    _Figure("clearance_mm", "clearance", "mm", "requirements.clearance_min_mm", True, "clearance"),
    _Figure("kappa_max", "condition number", "", "feel.kappa_max", check="kappa"),
    _Figure("couple_index_min", "rotational stiffness index", "", "feel.couple_index_min", True, "couple index"),
    _Figure("position_step_max_mm", "position step", "mm", "feel.position_step_max_mm", check="position step"),
    _Figure("lean_deg", "lean of the rods", "deg", "limits.lean_max_deg", check="lean"),
    _Figure("elbow_angle_deg", "angle at the elbow", "deg", "limits.elbow_angle_min_deg", True, "elbow angle"),
    _Figure(
        "holding_torque_N_m",
        "joint torque, force and weight together",
        "N m",
        "requirements.joint_torque_N_m",
        check="torque with gravity",
    ),
    _Figure("first_mode_Hz", "first mode", "Hz", check="structure first mode"),
)


@dataclass(frozen=True)
class _ResultAtLimit:
    """A result with its limit.

    Attributes:
        figure: What it is.
        value: The result.
        limit: The limit.
    """

    figure: _Figure
    value: float
    limit: float

    @property
    def margin(self) -> float:
        """Room to the limit, as a share of it; less than 0 beyond it."""
        return (self.value - self.limit if self.figure.least else self.limit - self.value) / abs(self.limit)

    def __str__(self) -> str:
        sense = "at least" if self.figure.least else "at most"
        return f"{self.figure.words} {self.value:.3g} {self.figure.unit}".rstrip() + f", {sense} {self.limit:.3g}"


def results_of(outcome: Outcome) -> dict[str, float]:
    """Computes the results of a machine that was built, whatever limits are set.

    Returns:
        Key of a figure -> value, the worst over the cube; those of checks are theirs.
    """
    design, d = outcome.design, dimensions(outcome.design)
    m = design.mechanism
    found: dict[str, float] = {
        "cube_side_mm": 2.0 * design.cube.half_side_mm,
        "height_mm": d.height_mm,
        "outline_radius_mm": m.base_radius_mm + m.upper_arm_length_mm,
        "force_N": force_N(design, outcome.masses, design.requirements.joint_torque_N_m),
        "peak_force_N": force_N(design, outcome.masses, drive_torque(design).required_peak_N_m),
        **feel_figures(design, outcome.masses),
    }
    from delta_cad.structure.report import stiffness

    found["stiffness_min_N_mm"] = stiffness(d).least_N_mm
    checked = {one.name: one.value for one in outcome.results if one.value is not None}
    return found | {one.key: checked[one.check] for one in FIGURES if one.check in checked}


def force_N(design: Design, masses: Mapping[str, Any], torque_N_m: float) -> float:
    """Computes the force that a joint torque gives in addition to gravity, in any direction, anywhere in the cube.

    Returns:
        The force, N; 0 where the weight takes all of the torque.
    """
    held = held_masses(design.name, masses["bodies"], design)
    search = CubeSearch(design.workspace)

    def needed(force: float) -> float:
        limit = HoldingTorque(force, torque_N_m, held)
        return worst_of(search, design.geometry, limit, limit.figures[0]).value

    if needed(LEAST) >= torque_N_m:
        return 0.0
    high = design.requirements.force_N
    while needed(high) <= torque_N_m:
        high *= 2.0
    found: Any = brentq(lambda force: needed(force) - torque_N_m, LEAST, high, xtol=_FORCE_ROOM_N)
    return max(float(found) - _FORCE_ROOM_N, 0.0)


def set_limits(brief: DesignBrief, values: Mapping[str, float | None]) -> list[_ResultAtLimit]:
    """Lists the results of which the requirements file sets a limit, in the order of `FIGURES`."""
    return [
        _ResultAtLimit(one, value, limit)
        for one in FIGURES
        if one.field in brief.stated
        and (limit := brief.value(one.field)) is not None
        and (value := values.get(one.key)) is not None
    ]


def binding(brief: DesignBrief, values: Mapping[str, float | None]) -> list[_ResultAtLimit]:
    """Lists the set limits that bind: those within a hundredth of which the machine is."""
    return [one for one in set_limits(brief, values) if abs(one.margin) <= _BINDS]


def with_provenance(design: Design, brief: DesignBrief, command: str, seed: int) -> Design:
    """Gives a design that says where it comes from."""
    provenance = {
        "program": "optimizer design",
        "version": importlib.metadata.version("delta-haptics"),
        "command": command,
        "seed": seed,
        "requirements_sha256": brief_hash(brief),
    }
    return design.model_copy(update={"provenance": provenance})


def placed(design: Design, brief: DesignBrief, folder: Path) -> Design:
    """Gives a design whose file is in a folder; the folder of own parts is relative to it."""
    if design.hardware.catalogue is None:
        return design
    own = brief.hardware_from(folder, {})["catalogue"]
    return design.model_copy(update={"hardware": design.hardware.model_copy(update={"catalogue": own})})


def certificate_of(design: Design, masses: Path) -> Certificate:
    """Certifies a machine that was built, with its own masses."""
    share = allowance_of_masses(masses, design)
    inertia = load_masses(masses, design).handle_inertia
    return certify(design, limits_of(design, share, inertia), gravity=share)


def placement_of(brief: DesignBrief, machine: Candidate, symmetric: Candidate | None) -> dict[str, Any] | None:
    """Says where the chains and the cube of a machine are placed, and what that bought, as JSON types.

    Args:
        brief: The requirements.
        machine: The machine that was built.
        symmetric: The three-fold symmetric candidate of the same search; None where it has none.

    Returns:
        Keys `azimuths_deg`, `base_radii_mm`, `centre_x_mm`, `symmetric_side_mm` (None where no symmetric machine was
        found) and `bought`, a sentence; None of a three-fold symmetric machine.
    """
    mechanism, cube = machine.design.mechanism, machine.design.cube
    if is_symmetric(machine.lengths_mm):
        return None
    azimuths = [round(angle, 9) for angle in mechanism.azimuths_deg or (0.0, 120.0, -120.0)]
    bought = "no three-fold symmetric machine was found"
    if symmetric is not None:
        unit, gain = _UNITS[brief.objective].split()[0], machine.score - symmetric.score
        gain = gain if machine.score > 0.0 else -gain
        other = f"{worded(brief.objective, symmetric.score)}, {'weighed' if symmetric.weighed else 'by closed forms'}"
        bought = f"{gain:+.3g} {unit} over the symmetric machine of the same search ({other}, not built)"
    return {
        "azimuths_deg": azimuths,
        "base_radii_mm": list(mechanism.base_radii_mm or (mechanism.base_radius_mm,) * 3),
        "centre_x_mm": cube.centre_x_mm or 0.0,
        "symmetric_side_mm": symmetric and symmetric.side_mm,
        "bought": bought,
    }


def _placement_words(placement: Mapping[str, Any]) -> str:
    """Says where chains and cube are placed, and what it bought."""
    azimuths, radii = (", ".join(f"{v:g}" for v in placement[key]) for key in ("azimuths_deg", "base_radii_mm"))
    return (
        f"Chains at azimuths of {azimuths} deg, {radii} mm out, the cube's middle {placement['centre_x_mm']:g} mm "
        f"off the axis: {placement['bought']}."
    )


def facts_of(
    brief: DesignBrief,
    outcome: Outcome,
    log: SearchLog,
    bound: Bound | None,
    placement: dict[str, Any] | None = None,
) -> dict[str, Any]:
    """Gathers what came of a run as JSON types; without a bound where the cube is not the objective."""
    design, values = outcome.design, results_of(outcome)
    drive = drive_torque(design)
    own = None if bound is None or bound.placed_mm is not None else bound  # that of the machine itself
    return {
        "name": brief.name,
        "verdict": str(Verdict.BUILT),
        "passed": outcome.passed,
        "objective": brief.objective,
        "bound_mm": None if own is None else own.side_mm,
        "gap": None if own is None else own.gap,
        "bound": _NO_BOUND if bound is None else bound.statement,
        **{one.key: values.get(one.key) for one in FIGURES},
        "outline_mm": [values.get(f"outline_{side}_mm") for side in ("width", "depth")],
        "placement": placement,
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


_EMPTY = (
    "cube_side_mm",
    "bound_mm",
    "gap",
    *(one.key for one in FIGURES),
    "outline_mm",
    "placement",
    "motor",
    "ratio",
    "folder",
)
"""Keys of the facts that have no value without a machine."""


def no_facts(name: str, ends: Verdict, log: SearchLog, nearest: dict[str, Any]) -> dict[str, Any]:
    """Gives what came of a run without a machine as JSON types."""
    facts: dict[str, Any] = {"name": name, "verdict": str(ends), "passed": False} | dict.fromkeys(_EMPTY)
    return facts | {"binding": [], "poor": [], "tried": log.candidates, "nearest": nearest or None}


def _headline(facts: dict[str, Any]) -> str:
    """Gives the figures that always come first in one line."""
    return ", ".join(f"{one.words} {facts[one.key]:.3g} {one.unit}" for one in FIGURES if one.head and facts[one.key])


def shown(facts: dict[str, Any]) -> str:
    """States in what a machine is a poor haptic device, or else its figures that come first."""
    return poor_verdict(facts["poor"]) or _headline(facts)


@dataclass(frozen=True)
class DesignReport:
    """What came of a run that built a machine, as pages list it.

    Attributes:
        brief: The requirements.
        facts: See `facts_of`.
        log: What the search went through, this machine last.
        why: What each correction of its hardware was made for, a line each.
        notes: Of the requirements and of the run.
        costs: What each limit costs, the dearest first.
        bound: What is proved of the machine's family; None where nothing is.
    """

    brief: DesignBrief
    facts: dict[str, Any]
    log: SearchLog
    why: Sequence[str]
    notes: Sequence[str]
    costs: Sequence[Cost]
    bound: Bound | None

    @property
    def unit(self) -> str:
        """Unit of the objective."""
        return _UNITS[self.facts["objective"]]

    def write(self, folder: Path, design: Design, certificate: Certificate) -> None:
        """Writes `design.json`, `design.md`, `design.html` and `certificate.json` into the folder of a build."""
        (folder / SEARCHED).write_text(self.html(), encoding="utf-8")
        write_design(folder, design)
        (folder / "design.md").write_text(self.markdown(), encoding="utf-8")
        text = certificate_text(certificate, "certificate.json")  # the folder's own lock is held by the build
        (folder / "certificate.json").write_text(text, encoding="utf-8")

    def markdown(self) -> str:
        """Writes `design.md`: what was reached, what binds, what each limit costs, what was tried."""
        facts, bound = self.facts, self.bound
        width, depth = facts["outline_mm"]
        price = (
            ""
            if facts["cost_EUR"] is None
            else f"; about {facts['cost_EUR']:.0f} EUR for one, by estimate, see cost.json"
        )
        limits = {one.figure.key: one for one in set_limits(self.brief, facts)}
        first = _headline(facts)
        lines = [
            f"# {facts['name']}",
            "",
            f"A cube of {facts['cube_side_mm']:.2f} mm, with {facts['motor']} at {facts['ratio']:g}:1, within "
            f"{width:.1f} x {depth:.1f} mm as built{price}.",
            f"{first[:1].upper()}{first[1:]}.",
            *(() if facts["placement"] is None else (_placement_words(facts["placement"]),)),
            "",
            *((f"**{poor_verdict(facts['poor'])}**", "") if facts["poor"] else ()),
            "## Results",
            "",
            *(
                f"- {limits[one.key]} set"
                if one.key in limits
                else f"- {one.words} {facts[one.key]:.4g} {one.unit}".rstrip()
                for one in FIGURES
                if facts[one.key] is not None
            ),
            "",
            "## Proved bound",
            "",
        ]
        if bound is None:
            lines += [_NO_BOUND.capitalize() + ".", ""]
        else:
            lines += [bound.statement if bound.placed_mm else f"{bound.statement} What lies between:", ""]
            lines += [*(f"- {part:.2f} mm: {what}" for what, part in bound.losses if not bound.placed_mm), ""]
            lines += ["Those machines also have", "", *(f"- {line}" for line in bound.family), ""]
        lines += [
            "## What binds",
            "",
            *(f"- {one.figure.field} = {one.limit:g}: {one.value:.4g}" for one in binding(self.brief, facts)),
            "",
            "## What each limit costs",
            "",
            "Estimated with this hardware:" if self.costs else "Less than the search resolves.",
            "",
            *(
                f"- {c.field} = {c.wider:g} instead of {c.requested:g}: {c.gain:.3g} {self.unit} better"
                for c in self.costs
            ),
            "",
            "## What was tried",
            "",
            f"{facts['tried']} candidates; machines built: {facts['built']}",
            "",
            *(
                f"- {2.0 * design.cube.half_side_mm:.2f} mm with {design.hardware.motor}: "
                + (f"fails {', '.join(failed)}" if failed else "passes every check")
                for design, failed in self.log.built
            ),
            *(f"- {line}" for line in self.log.placed),
            *(f"- {hardware}: given up, {reason}" for hardware, reason in self.log.no_progress.items()),
            "",
            *(("## What was learnt on the way", "") if self.why else ()),
            *(f"- {reason}" for reason in self.why),
            "",
            *(f"Note: {note}" for note in self.notes),
        ]
        return "\n".join(lines).rstrip() + "\n"

    def html(self) -> str:
        """Writes `design.html`: the same with every candidate in a plot, in the style of report.html."""
        return rendered(
            "design.html",
            _STYLE,
            f"{self.facts['name']}: how it was found",
            run=self,
            cards=self._cards(),
            plot=_plot(self.log.trials, self.facts["bound_mm"], self.unit),
            binding=binding(self.brief, self.facts),
            poor=poor_verdict(self.facts["poor"]),
            dearest=max((one.gain for one in self.costs), default=1.0),
            report=FILE_NAME,
        )

    def _cards(self) -> list[tuple[str, str, str, str]]:
        """The figures at the top of the page: label, value, unit, text below."""
        facts = self.facts
        width, depth = facts["outline_mm"]
        cards = [
            ("Cube", f"{facts['cube_side_mm']:.2f}", "mm", ""),
            ("Drive", f"{facts['ratio']:g}", ": 1", facts["motor"]),
            ("Swept outline", f"{width:.1f} × {depth:.1f}", "mm", "as built"),
            *(
                (f"{one.words[:1].upper()}{one.words[1:]}", f"{facts[one.key]:.3g}", one.unit, "")
                for one in FIGURES
                if one.head and facts[one.key] is not None
            ),
        ]
        if facts["bound_mm"] is not None:
            cards.insert(1, ("Proved bound", f"{facts['bound_mm']:.2f}", "mm", f"{100.0 * facts['gap']:.2g} % more"))
        if facts["placement"] is not None:
            words, _, why = facts["placement"]["bought"].partition(" (")
            cards.append(("Placed chains", words, "", why.removesuffix(")")))
        if facts["cost_EUR"] is not None:
            cards.append(("Cost of one", f"{facts['cost_EUR']:.0f}", "EUR", "by estimate, see cost.json"))
        return cards


def write_design(folder: Path, design: Design) -> None:
    """Writes `design.json` into the folder of a build."""
    (folder / "design.json").write_text(design_to_json(design), encoding="utf-8")


def _plot(trials: Sequence[Trial], bound_mm: float | None, unit: str) -> dict[str, Any]:
    """Sets out the candidates, a row a motor, those first that come farthest."""
    best: dict[str, float] = {}
    for one in trials:
        name = f"{one.choice.motor} {one.choice.drive}"
        best[name] = max(one.score, best.get(name, -math.inf))
    rows = {name: _TOP + _ROW * k for k, name in enumerate(sorted(best, key=lambda name: -best[name]))}
    values = [abs(one.score) for one in trials] + ([] if bound_mm is None else [bound_mm])
    across = Scale(values, _LEFT, _WIDTH - 20)
    dots = []
    for one in sorted(trials, key=lambda one: (one.failed is not None, one.failed == ())):  # what passes on top
        kind = "posed" if one.failed is None else "failed" if one.failed else "passed"
        hardware = f"{one.choice.motor} {one.choice.drive}"
        words = f"{hardware} at {one.choice.ratio:g}:1, {one.choice.width_mm:g} mm wide: {abs(one.score):.4g} {unit}"
        words += "" if kind != "failed" else f"; fails {', '.join(one.failed or ())}"
        dots.append(
            {
                "kind": kind,
                "x": across.at(abs(one.score)),
                "y": rows[hardware],
                "r": 3.5 if kind == "posed" else 6,
                "words": words,
            }
        )
    floor = _TOP + _ROW * len(rows)
    return {
        "unit": unit,
        "width": _WIDTH,
        "height": floor + 44,
        "floor": floor,
        "rows": [(y, name) for name, y in rows.items()],
        "ticks": across.ticks(),
        "bound": None if bound_mm is None else across.at(bound_mm),
        "dots": dots,
    }
