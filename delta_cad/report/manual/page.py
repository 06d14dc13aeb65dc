"""Writes `manual/manual.html`, one file with its pictures in it, set for A4; in a build by a second process."""

from __future__ import annotations

import re
from base64 import b64encode
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import Meshes
from delta_cad.design import design_hash
from delta_cad.dimensions import Dimensions
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.drawings.sheet_io.lettering import face_rules
from delta_cad.report.manual.pictures import SIZE, Colour, Studio
from delta_cad.report.manual.steps import Chapter, chapters, scenes
from delta_cad.report.page import ASSETS, environment

FOLDER, _FILE_NAME = "manual", "manual.html"
TORQUES = (
    "Torques of cap screws: 0.7 of the proof stress of A2-70 at a friction of 0.14 (VDI 2230, ISO 3506-1), in the "
    "thread, or below the socket of a low head where that bears less; of set screws from memory: check. Where the "
    "maker of a motor or of a bought part says less, that holds."
)
LOADS = (
    "jinja2",
    "vtkmodules.util.numpy_support",
    "vtkmodules.vtkFiltersHybrid",
    "vtkmodules.vtkIOImage",
    "vtkmodules.vtkImagingCore",
    "vtkmodules.vtkRenderingOpenGL2",
)
_Order = tuple[Dimensions, Assembly, Meshes, Mapping[str, Any], Path]


def results(order: _Order) -> Iterator[Path]:
    """Writes the manual of a machine, for `WorkerProcess`.

    Yields:
        Its file.
    """
    yield write_manual(*order)


def write_manual(d: Dimensions, assembly: Assembly, meshes: Meshes, masses: Mapping[str, Any], folder: Path) -> Path:
    """Draws all steps and writes the page below a build's folder; the machine's solids are not needed.

    Returns:
        The file.

    Raises:
        PictureError: There is no OpenGL.
        OSError: It cannot be written.
    """
    rows = bill_of_materials(assembly, {number: body["mass_kg"] for number, body in masses["parts"].items()})
    with TemporaryDirectory() as drawn:
        colours = _pictures(assembly, meshes, Path(drawn))
        wording = chapters(assembly, rows, colours)
        embedded = {path.name: _embedded(path) for path in Path(drawn).iterdir()}
    path = folder / FOLDER / _FILE_NAME
    path.parent.mkdir(exist_ok=True)
    path.write_text(page(d, assembly, wording, embedded), encoding="utf-8")
    return path


def _pictures(assembly: Assembly, meshes: Meshes, folder: Path) -> dict[str, Mapping[str, Colour]]:
    """Draws every step into a folder: picture -> part number -> colour."""
    studio, colours = Studio(assembly, meshes), {}
    try:
        for _, steps in scenes(assembly.order):
            for one in steps:
                colours[one.picture] = studio.draw(one.step, one.coming, one.there, folder / one.picture)
    finally:
        studio.close()
    return colours


def _embedded(path: Path) -> str:
    return "data:image/png;base64," + b64encode(path.read_bytes()).decode("ascii")


def page(d: Dimensions, assembly: Assembly, wording: list[Chapter], pictures: Mapping[str, str]) -> str:
    """Gives the page's text; `pictures` are URLs by name."""
    from markupsafe import Markup

    tools = dict.fromkeys(tool for chapter in wording for step in chapter.steps for tool in step.tools)
    text = (
        environment()
        .get_template("manual.html")
        .render(
            name=assembly.name,
            chapters=wording,
            steps=sum(len(chapter.steps) for chapter in wording),
            parts=len(assembly.occurrences),
            tools=sorted(tools, key=_sorted_as),
            torques=TORQUES,
            others=_others(d),
            pictures=pictures,
            size=SIZE,
            hash=design_hash(d.design),
            style=Markup((ASSETS / "manual.css").read_text(encoding="utf-8")),
        )
    )
    return text.replace("</style>", f"{face_rules(sorted(set(text)))}</style>", 1)


def _others(d: Dimensions) -> str:
    """Where chains 1 and 2 stand."""
    if d.design.geometry.three_fold:
        return "chains 1 and 2 follow at 120 degrees each, counter-clockwise seen from above."
    (_, first, second), out = d.design.azimuths_deg, d.outs_mm[1]
    words = f"chains 1 and 2 stand at {first:.6g} and {second:.6g} degrees, counter-clockwise seen from above"
    return f"{words}, {abs(out):.6g} mm {'farther out' if out > 0.0 else 'nearer'}." if out else f"{words}."


def _sorted_as(tool: str) -> tuple[str, float]:
    """Keys by their size, all else by its name."""
    size = re.search(r"[\d.]+", tool)
    return (tool[: size.start()], float(size[0].strip("."))) if size else (tool, 0.0)
