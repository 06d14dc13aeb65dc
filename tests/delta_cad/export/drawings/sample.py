"""A plate that is dimensioned by hand here, and its drawing."""

from __future__ import annotations

import cadquery as cq

from delta_cad.export.drawings.part.controlled import Controlled, Length
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.sheet import Drawing
from delta_cad.export.drawings.title import Titles
from delta_cad.export.drawings.write import part_drawing
from delta_cad.solids.part import Hole, Material, Part

METAL = Material("Aluminium EN AW-6082 T6", 2700.0, (0.7, 0.7, 0.7))
TITLES = Titles("plate", "plate 60 x 40", METAL.name, "2", "36 g", "60 x 40 x 8 mm", "sample", "A")
HELD = Controlled((Length(2, 0.0, 8.0, 0.02),))
HOLES = (
    Hole(8.0, 1, "8 H7 through, shaft"),
    Hole(3.3, 2, "M4 x 6, drilled 6 deep"),
    Hole(5.5, 2, "5.5 through, screws"),
    Hole(10.0, 2, "counterbore 5 deep"),
)


def plate() -> Part:
    """60 x 40 x 8 from a corner: a bore, two blind threads, two counterbored holes, all from above."""
    body = cq.Workplane().box(60, 40, 8, centered=False)
    body = body.faces(">Z").workplane(origin=(0, 0, 8)).pushPoints([(30, 20)]).hole(8.0)
    body = body.faces(">Z").workplane(origin=(0, 0, 8)).pushPoints([(10, 20), (50, 20)]).hole(3.3, 6.0)
    body = body.faces(">Z").workplane(origin=(0, 0, 8)).pushPoints([(30, 7), (30, 33)]).cboreHole(5.5, 10.0, 5.0)
    (solid,) = body.val().Solids()  # type: ignore[union-attr]
    return Part("plate", "plate 60 x 40", solid, METAL, True, HOLES, extent_mm=((0, 60), (0, 40), (0, 8)))


def drawn(part: Part | None = None, held: Controlled = HELD) -> tuple[Drawing, Features]:
    """The drawing of the plate, or of a part, and what it had to tell."""
    return part_drawing(part or plate(), held, TITLES)


def texts(drawing: Drawing) -> list[str]:
    """All that stands on a drawing."""
    return [text.text for sheet in drawing.sheets for text in sheet.texts]
