"""What `front --machines` writes: machines.html, whose points open their machines, the points as JSON, design files."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from delta_cad.common.console import ProgressLine
from delta_cad.common.files import RECORD, record_with, write_all
from delta_cad.common.reading import ReadError, read_json
from delta_cad.design import Design, design_hash, design_to_json
from delta_cad.report.page import FILE_NAME
from optimizer.codesign.pages.design import rendered
from optimizer.codesign.pages.plot import Scale
from optimizer.codesign.variants.front import AXES, Figures, MachinePoint, hardware_of

PAGE = "machines.html"
DESIGNS = "designs"
UNITS = {"effective_mass": "kg", "friction": "N", "stiffness": "N/mm", "outline": "mm wide", "cube": "mm"}
WIDTH, HEIGHT, LEFT, BELOW = 460, 340, 44, 300
COLOURS = ("#2a78c2", "#c8501e", "#1a8f68", "#a8559a", "#b98500", "#3aa0b8")  # on white and on black
PANELS: tuple[tuple[str, str, Callable[[Figures], float]], ...] = (
    ("effective_mass", "effective mass, heaviest direction, kg", lambda f: f.effective_mass_kg),
    ("friction", "friction at the handle, N", lambda f: f.friction_N),
    ("stiffness", "stiffness at the knob, softest direction, N/mm", lambda f: f.stiffness_N_mm),
    ("outline", "outline, width, mm", lambda f: f.outline_mm[0]),
)
STYLE = """
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


def record(points: Sequence[MachinePoint], name: str) -> dict[str, Any]:
    """Gives the points as JSON types."""
    told = []
    for point in points:
        figures = {**asdict(point.figures), "outline_mm": list(point.figures.outline_mm)}
        hardware = {"motor": point.choice.motor, "drive": point.choice.drive, "ratio": point.choice.ratio}
        place = {"design": f"{DESIGNS}/{point.name}.json", "on_front": point.on_front}
        told.append({"axis": point.axis, "limit": point.limit, **hardware, **figures, **place})
    return {"schema": "delta-machines/1", "name": name, "points": told}


def design_files(points: Sequence[MachinePoint]) -> dict[str, str]:
    """Gives name and text of every design file."""
    return {f"{point.name}.json": design_to_json(point.design) for point in points}


def in_order(points: Sequence[MachinePoint]) -> list[MachinePoint]:
    """Sorts points as tables list them: what was asked first, then axis after axis by the limit."""
    order = ["asked", *(axis.name for axis in AXES)]
    return sorted(points, key=lambda p: (order.index(p.axis), p.limit or 0.0))


def limit_of(point: MachinePoint) -> str:
    """Names the limit that was moved, and its value."""
    if point.limit is None:
        return "as required"
    return f"{point.axis.replace('_', ' ')} {point.limit:.4g} {UNITS[point.axis]}"


@dataclass(frozen=True)
class Standing:
    """A machine of the front that was built.

    Attributes:
        report: Its report.html, from the page's folder.
        failed: Checks that it fails.
    """

    report: str
    failed: tuple[str, ...]


def standing(designs: Mapping[str, Design], out: Path) -> dict[str, Standing]:
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
                found[name] = Standing(f"../{folder}/{FILE_NAME}", failed)
    return found


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
        if number in standing({number: design}, out):
            continue

        def tell(phase: str, count: int = count, number: str = number) -> None:
            line.show(f"machine {count} of {len(best)}, {number}: {phase}")

        try:
            build(design, out, tell)
        except geometry_errors() as error:
            line.keep(f"{number}: {error}")
            continue
        built = standing({point.name: point.design for point in points}, out)
        text = machines_page(points, name, place.as_posix(), built)
        write_all({place / PAGE: text, place / RECORD: record_with(place, {PAGE: text.encode()})})


def machines_page(points: Sequence[MachinePoint], name: str, folder: str, built: Mapping[str, Standing]) -> str:
    """Writes the page.

    Args:
        points: The front.
        name: Of the requirements.
        folder: Where the files stand, as commands name it.
        built: Name of a point -> its machine, of those that stand already.
    """
    tables = []
    for k, choice in enumerate(hardware_of(points)):
        own = [_row(point, folder, built.get(point.name)) for point in in_order(points) if point.choice == choice]
        tables.append({"title": _hardware(choice), "colour": COLOURS[k % len(COLOURS)], "rows": own})
    return rendered(
        "machines.html",
        STYLE,
        name=name,
        count=(len(points), sum(point.on_front for point in points), len(built)),
        plots=[_plot(axis, points, built) for axis in PANELS],
        size=(WIDTH, HEIGHT, LEFT, BELOW),
        tables=tables,
    )


def _hardware(choice: Any) -> str:
    return f"{choice.motor}, {choice.drive} {choice.ratio:g}:1"


def _row(point: MachinePoint, folder: str, built: Standing | None) -> dict[str, Any]:
    """One machine of a table."""
    f = point.figures
    width, depth = f.outline_mm
    values = f"{f.cube_side_mm:.2f}", f"{width:.0f} × {depth:.0f}", f"{f.effective_mass_kg:.3f}", f"{f.friction_N:.2f}"
    return {
        "id": point.name,
        "limit": limit_of(point),
        "on_front": point.on_front,
        "values": (*values, f"{f.stiffness_N_mm:.1f}", f"{f.kappa:.2f}"),
        "design": f"{DESIGNS}/{point.name}.json",
        "built": built,
        "command": f"python -m delta_cad build --design {folder}/{DESIGNS}/{point.name}.json",
    }


def _plot(
    axis: tuple[str, str, Callable[[Figures], float]],
    points: Sequence[MachinePoint],
    built: Mapping[str, Standing],
) -> dict[str, Any]:
    """Sets out the cube over one figure."""
    name, label, value = axis
    across = Scale([value(point.figures) for point in points], LEFT, WIDTH - 12)
    up = Scale([point.figures.cube_side_mm for point in points], BELOW, 10)
    hardware = hardware_of(points)
    lines = []
    for k, choice in enumerate(hardware):
        own = [p.figures for p in points if p.choice == choice and p.axis in (name, "asked")]
        places = [f"{across.at(value(f))},{up.at(f.cube_side_mm)}" for f in sorted(own, key=value)]
        lines.append({"colour": COLOURS[k % len(COLOURS)], "places": " ".join(places)})
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
                "r": 7 if point.axis == "asked" else 4.5,
                "colour": COLOURS[hardware.index(point.choice) % len(COLOURS)],
                "href": f"#{point.name}" if there is None else there.report,
                "words": f"{_hardware(point.choice)}, {limit_of(point)}: cube {point.figures.cube_side_mm:.2f} mm, "
                f"{label.rpartition(', ')[0]} {value(point.figures):.3g} {label.rpartition(', ')[2]}{verdict}",
            }
        )
    return {"label": label, "across": across.ticks(), "up": up.ticks(), "lines": lines, "dots": dots}
