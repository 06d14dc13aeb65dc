"""What a shop asks for before it names a price, in one archive: of each made part its files, and a table of all.

A part's STEP file holds one body. The archive is the same bytes for the same machine, as every file of a build.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import G_PER_KG
from delta_cad.dimensions import Dimensions
from delta_cad.export.bom import csv_text
from delta_cad.export.drawings.notes import finish_of
from delta_cad.export.drawings.title import Titles, grams
from delta_cad.export.drawings.write import titles_of
from delta_cad.export.meshes import write_package
from delta_cad.export.shop.profile import SUFFIX
from delta_cad.solids.part import Part

FILE = "quotation.zip"
TABLE = "quotation.csv"
_CUT, _PRINTED = (".step", ".pdf", SUFFIX), (".step", ".pdf", ".3mf")  # only the 3MF has a print's own holes


@dataclass(frozen=True)
class QuotedPart:
    """A row of the table.

    Attributes:
        part_number: Number of the part, and first part of its files' names.
        quantity: How many a machine has.
        material: As its drawing orders it.
        process: "cut", or how it is printed, such as "fdm".
        finish: What is done to it after that.
        size_mm: What it reaches along its axes.
        mass_g: Of one.
        files: Names in the archive.
    """

    part_number: str
    quantity: int
    material: str
    process: str
    finish: str
    size_mm: str
    mass_g: str
    files: str = ""


def quoted(part: Part, titles: Titles) -> QuotedPart:
    """Gives the row of a part, in the words of its drawing's title block."""
    size, mass = titles.size.removesuffix(" mm"), titles.mass.removesuffix(" g")
    process = part.material.process or "cut"
    return QuotedPart(part.number, int(titles.quantity), titles.material, process, finish_of(part), size, mass)


def quoted_parts(d: Dimensions, assembly: Assembly, unit_mass_kg: Mapping[str, float]) -> list[QuotedPart]:
    """Lists the made parts of a machine.

    Args:
        d: Its dimensions.
        assembly: The machine.
        unit_mass_kg: Mass of one of each part by its number, kg.
    """
    count = Counter(one.part.number for one in assembly.occurrences)
    made = (part for part in assembly.parts if part.is_drawn)
    return [
        quoted(part, titles_of(d, part, count[part.number], grams(unit_mass_kg[part.number] * G_PER_KG)))
        for part in made
    ]


def write_quotation(rows: Sequence[QuotedPart], folder: Path) -> None:
    """Packs the files of each part that the folder has, with the table of all: a cut one's profile, a print's 3MF."""
    entries, listed = dict[str, bytes](), list[QuotedPart]()
    for row in rows:
        suffixes = _CUT if row.process == "cut" else _PRINTED
        names = {row.part_number + suffix for suffix in suffixes}
        files = sorted(path for path in folder.rglob(f"{row.part_number}.*") if path.name in names)
        own = {f"{row.part_number}/{path.name}": path.read_bytes() for path in files}
        entries |= own
        listed.append(replace(row, files=" ".join(own)))
    table = csv_text(QuotedPart, listed).encode()
    write_package(folder / FILE, {TABLE: table, **entries})
