"""The front of machines: what more or less of one limit makes of all else, each point a design that parts allow.

For each hardware worth building, weighed by solids of its own, the customer's limits are eased and tightened one after
the other; what closed forms pass becomes a design file with all its figures, which `delta_cad build` makes. A page
sets the points out; each opens its machine where that was built already.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.common.console import NOT_BUILT, ProgressLine, refuse
from delta_cad.common.files import RECORD, record_with, whole_folder, write_all
from delta_cad.common.reading import ReadError, read_json
from delta_cad.design import NAME_LONGEST, Design, design_hash, design_to_json
from delta_cad.dimensions import dimensions
from delta_cad.drive.friction import drive_friction_N_m
from delta_cad.mechanism.limits import EffectiveMass, Friction, Kappa
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.workspace import CubeSearch
from delta_cad.report.page import FILE_NAME
from optimizer.codesign.candidate import Candidate
from optimizer.codesign.hardware import Selection
from optimizer.codesign.page import Scale, rendered
from optimizer.codesign.relaxation import of_task
from optimizer.codesign.search import MOTORS, Lengths, Search
from optimizer.problem.brief import DesignBrief
from optimizer.study.table import json_text

_ANY = 2.0  # limit that figures are asked for with: their values do not depend on it
_REQUIRED = "asked"  # axis of the points whose limits are as required
PAGE, _DESIGNS = "machines.html", "designs"
_WIDTH, _HEIGHT, _LEFT, _BELOW = 460, 340, 44, 300
_COLOURS = ("#2a78c2", "#c8501e", "#1a8f68", "#a8559a", "#b98500", "#3aa0b8")  # on white and on black
_STYLE = """
.plots { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 420px), 1fr)); gap: 1rem; }
.plot { width: 100%; height: auto; }
.plot text { font-size: 12px; fill: var(--ink); }
.plot .grid { stroke: var(--line); }
.plot polyline { fill: none; stroke-width: 1.4; }
.plot circle { stroke-width: 1.6; fill-opacity: 0.85; }
.plot .beaten { fill: var(--paper); }
.plot .failed { stroke-dasharray: 2 2; }
.plot a:hover circle, .plot a:focus circle { stroke: var(--ink); stroke-width: 3; }
.key { display: inline-block; width: 0.8rem; height: 0.8rem; border-radius: 50%; vertical-align: -0.1rem; }
tr:target { background: color-mix(in srgb, #d05a10 22%, var(--paper)); }
"""


@dataclass(frozen=True)
class _Axis:
    """A limit that is moved, and the figure that the cube is plotted over.

    Attributes:
        name: Of the axis, and of its files.
        fields: Table and field of the limits that move together.
        unit: Of a limit.
        factors: By which it is multiplied, from the easiest; the first at which there is no machine ends it.
        figure: Field of `Figures` from which it begins where nothing is asked; "" for none.
        label: Of the abscissa of its plot, with the unit; "" for no plot.
    """

    name: str
    fields: tuple[str, ...]
    unit: str
    factors: tuple[float, ...]
    figure: str = ""
    label: str = ""

    def value(self, figures: Figures) -> float:
        """Gives the abscissa of a machine in the plot of this axis."""
        return getattr(figures, self.figure) if self.figure else figures.outline_mm[0]


AXES = (
    _Axis(
        "effective_mass",
        ("feel.effective_mass_max_kg",),
        "kg",
        (0.9, 0.75, 0.6, 0.5, 0.4, 0.3),
        "effective_mass_kg",
        "effective mass, heaviest direction, kg",
    ),
    _Axis(
        "friction",
        ("feel.friction_max_N",),
        "N",
        (0.9, 0.8, 0.7, 0.6, 0.5),
        "friction_N",
        "friction at the handle, N",
    ),
    _Axis(
        "stiffness",
        ("feel.stiffness_min_N_mm",),
        "N/mm",
        (1.15, 1.3, 1.5, 1.75, 2.0),
        "stiffness_N_mm",
        "stiffness at the knob, softest direction, N/mm",
    ),
    _Axis(
        "outline",
        ("requirements.envelope_width_mm", "requirements.envelope_depth_mm"),
        "mm wide",
        (1.2, 1.1, 0.9, 0.8),
        label="outline, width, mm",
    ),
    _Axis("cube", ("requirements.cube_side_mm",), "mm", (0.7, 0.85, 1.15, 1.3)),
)


@dataclass(frozen=True)
class Figures:
    """What a machine is like: at the worst place of its cube, with the masses of its hardware.

    Attributes:
        cube_side_mm: Side of the cube.
        outline_mm: Width and depth that the design states.
        effective_mass_kg: In the heaviest direction.
        friction_N: In the direction of most, nominal coefficients.
        stiffness_N_mm: At the knob, in the softest direction, actuators held.
        kappa: Condition number.
    """

    cube_side_mm: float
    outline_mm: tuple[float, float]
    effective_mass_kg: float
    friction_N: float
    stiffness_N_mm: float
    kappa: float

    @property
    def merits(self) -> tuple[float, ...]:
        """All of them, larger is better."""
        width, depth = self.outline_mm
        less = width * depth, self.effective_mass_kg, self.friction_N, self.kappa
        return self.cube_side_mm, self.stiffness_N_mm, *(-value for value in less)


@dataclass(frozen=True)
class MachinePoint:
    """One machine of the front.

    Attributes:
        axis: The limit that was moved; `_REQUIRED` for what the customer asks.
        limit: Its value; None for that.
        choice: Hardware.
        design: The machine.
        figures: What it is like.
        on_front: Whether no other point is better in one figure and no worse in the others.
    """

    axis: str
    limit: float | None
    choice: Selection
    design: Design
    figures: Figures
    on_front: bool = True

    @property
    def name(self) -> str:
        """Of its design file, without ending."""
        return _name(self.choice, self.axis, self.limit)


def front(search: Search, points: list[MachinePoint]) -> None:
    """Traces the front of a task.

    Args:
        search: One of the task; its reports and its journal are used.
        points: Takes the points as they come, hardware after hardware; `marked` tells which of them are on the front.

    Raises:
        OutOfTimeError: The time of the search is over; `points` has those so far.
    """
    for number, (_, choice) in enumerate(search.ranked()):
        if number >= MOTORS and points:
            break
        candidate = search.refined(choice)
        search.log.ended(f"{choice.motor} {choice.drive}")
        if candidate is None:
            continue
        points.append(_point(search, _REQUIRED, None, candidate, search.brief))
        for axis in AXES:
            for point in _along(search, axis, points, candidate):
                points.append(point)


def best_machine(search: Search) -> MachinePoint | None:
    """Finds the machine of a task that closed forms pass, of the best hardware; nothing is built."""
    best: Candidate | None = None
    for number, (score, choice) in enumerate(search.ranked()):
        if best is not None and (number >= MOTORS or score <= best.score):
            break
        found = search.refined(choice)
        search.log.ended(f"{choice.motor} {choice.drive}")
        if found is not None and (best is None or found.score > best.score):
            best = found
    return None if best is None else _point(search, _REQUIRED, None, best, search.brief)


def _hardware_of(points: Iterable[MachinePoint]) -> list[Selection]:
    """Gives the different hardware of points, in their order."""
    found: list[Selection] = []
    for point in points:
        found += [point.choice] if point.choice not in found else []
    return found


def _along(search: Search, axis: _Axis, points: list[MachinePoint], candidate: Candidate) -> Iterator[MachinePoint]:
    """The points of one hardware along one axis."""
    (required,) = (p for p in points if p.axis == _REQUIRED and p.choice == candidate.choice)
    values = [search.brief.value(name) for name in axis.fields]
    if axis.figure:
        values = [getattr(required.figures, axis.figure)]
    if any(value is None for value in values):
        return
    start: Lengths | None = candidate.lengths_mm
    for factor in axis.factors:
        moved = [float(value) * factor for value in values if value is not None]
        brief = search.brief.with_values(dict(zip(axis.fields, moved, strict=True)))
        search.begin(f"{candidate.choice.motor}, {axis.name} {moved[0]:.4g}")
        trial = of_task(search, brief, dict(search.corrections))
        found = trial.fixed_point(candidate.choice, start, weighing=False)
        if found is None and axis.figure:
            return
        if found is not None:
            start = found.lengths_mm
            yield _point(trial, axis.name, moved[0], replace(found, choice=candidate.choice), brief)


def _name(choice: Selection, axis: str, limit: float | None) -> str:
    size = "" if limit is None else f"-{limit:.4g}"
    return f"{choice.motor}-{choice.drive}-{axis}{size}".replace(".", "_")


def _point(search: Search, axis: str, limit: float | None, candidate: Candidate, brief: DesignBrief) -> MachinePoint:
    known = search.corrections[candidate.choice.motor, candidate.choice.drive]
    own = _name(candidate.choice, axis, limit)
    name = f"{brief.name[: NAME_LONGEST - 1 - len(own)]}-{own}"  # of its folder when it is built
    design = candidate.design.model_copy(update={"name": name})
    return MachinePoint(axis, limit, candidate.choice, design, figures_of(design, candidate, known.ball_friction_N))


def figures_of(design: Design, candidate: Candidate, ball_friction_N: tuple[float, float]) -> Figures:
    """Computes the figures of a machine with the masses last weighed for its hardware.

    The ball joints' friction is that at the knob: along z, and square to it, N.
    """
    from delta_cad.structure.report import stiffness

    choice, lengths = candidate.choice, candidate.lengths_mm
    inertia = candidate.corrections.mass_estimate.inertia(lengths[0], lengths[1], choice.ratio)
    limits = EffectiveMass(_ANY, inertia), Friction(_ANY, drive_friction_N_m(design)[1], *ball_friction_N), Kappa(_ANY)
    search, g = CubeSearch(design.workspace), design.geometry
    mass, friction, kappa = (worst_of(search, g, limit, limit.figures[0]).value for limit in limits)
    outline = design.requirements.envelope_width_mm, design.requirements.envelope_depth_mm
    softest = stiffness(dimensions(design)).least_N_mm
    return Figures(2.0 * design.cube.half_side_mm, outline, mass, friction, softest, kappa)


def marked(points: list[MachinePoint]) -> list[MachinePoint]:
    """Marks the points that no other dominates."""
    merits = np.array([point.figures.merits for point in points])
    dominated = [((merits >= own).all(axis=1) & (merits > own).any(axis=1)).any() for own in merits]
    return [replace(point, on_front=not beaten) for point, beaten in zip(points, dominated, strict=True)]


def record(points: Sequence[MachinePoint], name: str) -> dict[str, Any]:
    """Gives the points as JSON types."""
    rows = []
    for point in points:
        figures = {**asdict(point.figures), "outline_mm": list(point.figures.outline_mm)}
        hardware = {"motor": point.choice.motor, "drive": point.choice.drive, "ratio": point.choice.ratio}
        place = {"design": f"{_DESIGNS}/{point.name}.json", "on_front": point.on_front}
        rows.append({"axis": point.axis, "limit": point.limit, **hardware, **figures, **place})
    return {"schema": "delta-machines/1", "name": name, "points": rows}


def design_files(points: Sequence[MachinePoint]) -> dict[str, str]:
    """Gives name and text of every design file."""
    return {f"{point.name}.json": design_to_json(point.design) for point in points}


def _in_order(points: Sequence[MachinePoint]) -> list[MachinePoint]:
    """Sorts points as tables list them: what was asked first, then axis after axis by the limit."""
    order = [_REQUIRED, *(axis.name for axis in AXES)]
    return sorted(points, key=lambda p: (order.index(p.axis), p.limit or 0.0))


def _limit_of(point: MachinePoint) -> str:
    """Names the limit that was moved, and its value."""
    if point.limit is None:
        return "as required"
    unit = next(axis.unit for axis in AXES if axis.name == point.axis)
    return f"{point.axis.replace('_', ' ')} {point.limit:.4g} {unit}"


@dataclass(frozen=True)
class _ExistingBuild:
    """A machine of the front that was built.

    Attributes:
        report: Its report.html, from the page's folder.
        failed: Checks that it fails.
    """

    report: str
    failed: tuple[str, ...]


def existing_builds(designs: Mapping[str, Design], out: Path) -> dict[str, _ExistingBuild]:
    """Finds machines that `delta_cad build` has made already.

    Args:
        designs: Name of a point -> its design.
        out: Where builds go; the page's own folder stands there, too.

    Returns:
        Name -> what stands there, of the very same design.
    """
    found = {}
    for name, design in designs.items():
        for folder in (design.name, f"{design.name}.rejected"):
            try:
                record = read_json(out / folder / "checks.json")
                same, failed = record["input_sha256"] == design_hash(design), tuple(map(str, record["failed"]))
            except (ReadError, LookupError, TypeError):  # none, or a file of something else
                continue
            if same and (out / folder / FILE_NAME).is_file():
                found[name] = _ExistingBuild(f"../{folder}/{FILE_NAME}", failed)
    return found


def write_front(points: Sequence[MachinePoint], name: str, place: Path) -> None:
    """Puts the complete folder of a front in its place."""
    with whole_folder(place) as folder:
        (folder / _DESIGNS).mkdir()
        for file, text in design_files(points).items():
            (folder / _DESIGNS / file).write_text(text, encoding="utf-8")
        built = existing_builds({point.name: point.design for point in points}, place.parent)
        (folder / PAGE).write_text(machines_page(points, name, place.as_posix(), built), encoding="utf-8")
        (folder / "machines.json").write_text(json_text(record(points, name)), encoding="utf-8")


def build_front(points: Sequence[MachinePoint], name: str, out: Path, line: ProgressLine) -> None:
    """Builds what no other machine beats and does not stand yet; the page links each as soon as it stands.

    Args:
        points: The front, its page written.
        name: Of the brief.
        out: Where builds go; the page's own folder stands there, too.
        line: Told of progress, and of machines whose geometry could not be made.
    """
    from delta_cad.commands.machine import geometry_errors
    from delta_cad.commands.pipeline import build

    place = out / f"{name}-machines"
    best = {point.name: point.design for point in points if point.on_front}
    for count, (number, design) in enumerate(best.items(), 1):
        if number in existing_builds({number: design}, out):
            continue

        def tell(phase: str, count: int = count, number: str = number) -> None:
            line.show(f"machine {count} of {len(best)}, {number}: {phase}")

        try:
            build(design, out, tell)
        except geometry_errors() as error:
            refuse(f"{number}: {error}", NOT_BUILT)
            continue
        built = existing_builds({point.name: point.design for point in points}, out)
        text = machines_page(points, name, place.as_posix(), built)
        write_all({place / PAGE: text, place / RECORD: record_with(place, {PAGE: text.encode()})})


def machines_page(points: Sequence[MachinePoint], name: str, folder: str, built: Mapping[str, _ExistingBuild]) -> str:
    """Writes the page.

    Args:
        points: The front.
        name: Of the requirements.
        folder: Where the files stand, as commands name it.
        built: Name of a point -> its machine, of those that stand already.
    """
    tables = []
    for k, choice in enumerate(_hardware_of(points)):
        own = [_row(point, folder, built.get(point.name)) for point in _in_order(points) if point.choice == choice]
        tables.append({"title": _hardware(choice), "colour": _COLOURS[k % len(_COLOURS)], "rows": own})
    return rendered(
        "machines.html",
        _STYLE,
        f"{name}: the front of machines",
        name=name,
        count=(len(points), sum(point.on_front for point in points), len(built)),
        plots=[_plot(axis, points, built) for axis in AXES if axis.label],
        size=(_WIDTH, _HEIGHT, _LEFT, _BELOW),
        tables=tables,
    )


def _hardware(choice: Any) -> str:
    return f"{choice.motor}, {choice.drive} {choice.ratio:g}:1"


def _row(point: MachinePoint, folder: str, built: _ExistingBuild | None) -> dict[str, Any]:
    """One machine of a table."""
    f = point.figures
    width, depth = f.outline_mm
    values = f"{f.cube_side_mm:.2f}", f"{width:.0f} × {depth:.0f}", f"{f.effective_mass_kg:.3f}", f"{f.friction_N:.2f}"
    return {
        "id": point.name,
        "limit": _limit_of(point),
        "on_front": point.on_front,
        "values": (*values, f"{f.stiffness_N_mm:.1f}", f"{f.kappa:.2f}"),
        "design": f"{_DESIGNS}/{point.name}.json",
        "built": built,
        "command": f"python -m delta_cad build --design {folder}/{_DESIGNS}/{point.name}.json",
    }


def _plot(axis: _Axis, points: Sequence[MachinePoint], built: Mapping[str, _ExistingBuild]) -> dict[str, Any]:
    """Sets out the cube over one figure."""
    label, value = axis.label, axis.value
    across = Scale([value(point.figures) for point in points], _LEFT, _WIDTH - 12)
    up = Scale([point.figures.cube_side_mm for point in points], _BELOW, 10)
    hardware = _hardware_of(points)
    lines = []
    for k, choice in enumerate(hardware):
        own = [p.figures for p in points if p.choice == choice and p.axis in (axis.name, _REQUIRED)]
        places = [f"{across.at(value(f))},{up.at(f.cube_side_mm)}" for f in sorted(own, key=value)]
        lines.append({"colour": _COLOURS[k % len(_COLOURS)], "places": " ".join(places)})
    dots = []
    for point in points:
        there = built.get(point.name)
        failed = () if there is None else there.failed
        kind = ("" if point.on_front else "beaten ") + ("failed" if failed else "")
        verdict = f"; fails {', '.join(failed)}" if failed else "; passes every check" if there is not None else ""
        dots.append(
            {
                "kind": kind.strip(),
                "x": across.at(value(point.figures)),
                "y": up.at(point.figures.cube_side_mm),
                "r": 7 if point.axis == _REQUIRED else 4.5,
                "colour": _COLOURS[hardware.index(point.choice) % len(_COLOURS)],
                "href": f"#{point.name}" if there is None else there.report,
                "words": f"{_hardware(point.choice)}, {_limit_of(point)}: cube {point.figures.cube_side_mm:.2f} mm, "
                f"{label.rpartition(', ')[0]} {value(point.figures):.3g} {label.rpartition(', ')[2]}{verdict}",
            }
        )
    return {"label": label, "across": across.ticks(), "up": up.ticks(), "lines": lines, "dots": dots}
