"""`drawings`: the drawings of the made parts and of the assembly alone."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.commands.machine import MACHINE_OPTIONS, made

if TYPE_CHECKING:
    from delta_cad.design import Design
    from delta_cad.export.drawings.write import Drawn

NAME = "drawings"
TEXT = "dimensioned drawings of manufactured parts and assembly, in OUT/NAME/drawings"
OPTIONS = MACHINE_OPTIONS


@dataclass(frozen=True)
class DrawnOutcome:
    """What came of the drawings of a design, and the folder they are in."""

    name: str
    drawn: Drawn
    folder: Path

    @property
    def passed(self) -> bool:
        """Decides whether every drawing is sound."""
        return not self.drawn.faults

    def record(self) -> dict[str, Any]:
        """Gives the facts as JSON types."""
        facts = {"schema": "delta-drawings/1", "name": self.name, "passed": self.passed}
        return facts | {"drawings": self.drawn.count, "faults": self.drawn.faults}


def run(given: argparse.Namespace) -> int:
    """Draws the design and returns the exit code."""
    return made(given, _drawn, _place, folder=True, tell=tell)


def _place(design: Design, given: argparse.Namespace) -> Path:
    return given.out / design.name / "drawings"


def _drawn(design: Design, given: argparse.Namespace, progress: Callable[[str], None]) -> DrawnOutcome:
    from delta_cad.assembly.assemble import assemble  # loads the CAD kernel
    from delta_cad.common.files import whole_folder
    from delta_cad.dimensions import dimensions
    from delta_cad.export.drawings.write import write_drawings
    from delta_cad.export.mass_properties import mass_report

    d = dimensions(design)
    assembly = assemble(d, lambda part: progress(f"solid {part}"))
    with whole_folder(_place(design, given)) as folder:
        drawn = write_drawings(d, assembly, mass_report(assembly), folder, progress)
    return DrawnOutcome(design.name, drawn, _place(design, given))


def tell(outcome: DrawnOutcome) -> None:
    """One line a fault, and where the files are."""
    for name, faults in outcome.drawn.faults.items():
        for fault in faults:
            print(f"FAILS {name}: {fault}")
    print(f"{outcome.drawn.count} drawings in {outcome.folder}")
