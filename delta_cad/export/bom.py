"""Bill of materials, as CSV for people and JSON for programs."""

from __future__ import annotations

import csv
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from io import StringIO
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.assembly.machine import Assembly
from delta_cad.common.refusal import as_cell
from delta_cad.common.units import G_PER_KG
from delta_cad.export.shop.cost.cost import CENTS, Cost, CostLine
from delta_cad.solids.part import Consumable, Part

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

_SCHEMA = "delta-bom/1"
MASS_DECIMALS = 4  # masses are printed to 0.1 mg, far below what any scale in a workshop shows.


@dataclass(frozen=True)
class BomRow:
    """One line of the bill of materials; texts as those of the `Part`.

    Attributes:
        item: Line number from 1; made parts first, each group in order of first use.
        quantity: How many are in the machine, or of a jig in the shop.
        make_or_buy: "make", "buy", or "jig": made or bought once for any number of machines, and no part of one.
        unit_mass_g: Mass of one, g.
        total_mass_g: Mass of all, g.
        unit_cost_EUR: Price of one, when one machine is made, EUR without tax; None where none was computed.
        total_cost_EUR: Price of all, EUR.
        cost_source: Where the price is from, or that it is an estimate.
    """

    item: int
    part_number: str
    description: str
    quantity: int
    make_or_buy: str
    material: str
    unit_mass_g: float
    total_mass_g: float
    standard: str
    order_code: str
    source: str
    unit_cost_EUR: float | None = None
    total_cost_EUR: float | None = None
    cost_source: str = ""


def items_of(assembly: Assembly) -> dict[str, int]:
    """Numbers the parts that are ordered or made, from 1: the made ones first. Number of each part -> its item."""
    whole = sorted((part for part in assembly.parts if not part.piece_of), key=lambda part: not part.is_drawn)
    return {part.number: item for item, part in enumerate(whole, start=1)}


def bill_of_materials(assembly: Assembly, unit_mass_kg: Mapping[str, float], cost: Cost | None = None) -> list[BomRow]:
    """Lists parts and supplies, one row each: made parts first, then bought ones, then what has no place of its own.

    A part that is drawn in pieces, as a cable on two drums, is one row with the mass of all of them.

    Args:
        assembly: The machine.
        unit_mass_kg: Mass of one of each part by its number, kg.
        cost: Of the machine; None: no prices.

    Returns:
        The rows.
    """
    quantity = Counter(occurrence.part.number for occurrence in assembly.occurrences)
    items = items_of(assembly)
    rows = []
    for part in sorted((part for part in assembly.parts if part.number in items), key=lambda part: items[part.number]):
        pieces = [part, *(piece for piece in assembly.parts if piece.piece_of == part.number)]
        mass_g = sum(unit_mass_kg[piece.number] for piece in pieces) * G_PER_KG
        kind = "make" if part.is_drawn else "buy"
        rows.append(_row(items[part.number], part, quantity[part.number], kind, part.material.name, mass_g))
    for item, supply in enumerate(assembly.supplies, start=len(rows) + 1):
        rows.append(_row(item, supply, supply.quantity, "buy", supply.material, supply.unit_mass_g))
    return rows if cost is None else [_priced(row, cost.by_number[row.part_number]) for row in rows]


def _row(item: int, one: Part | Consumable, quantity: int, make_or_buy: str, material: str, mass_g: float) -> BomRow:
    unit = round(mass_g, MASS_DECIMALS)
    return BomRow(
        item=item,
        part_number=one.number,
        description=one.description,
        quantity=quantity,
        make_or_buy=make_or_buy,
        material=material,
        unit_mass_g=unit,
        total_mass_g=round(unit * quantity, MASS_DECIMALS),
        standard=one.standard,
        order_code=one.order_code,
        source=one.source,
    )


def _priced(row: BomRow, line: CostLine) -> BomRow:
    unit = line.unit_EUR[0]
    total = round(unit * row.quantity, CENTS)
    return replace(row, unit_cost_EUR=unit, total_cost_EUR=total, cost_source=line.source)


def write_bom(rows: list[BomRow], directory: Path) -> None:
    """Writes `bom.csv` and `bom.json` into a folder."""
    write_csv(directory / "bom.csv", BomRow, rows)
    text = json.dumps({"schema": _SCHEMA, "items": [asdict(row) for row in rows]}, indent=1, ensure_ascii=False)
    (directory / "bom.json").write_text(text + "\n", encoding="utf-8")


def write_csv(path: Path, record: type[DataclassInstance], rows: Sequence[DataclassInstance]) -> None:
    """Writes records of one kind, comma-separated, UTF-8, one line feed a row: the same bytes on every system.

    A text that a spreadsheet would compute is written as text, see `as_cell`.
    """
    path.write_text(csv_text(record, rows), encoding="utf-8", newline="")


def csv_text(record: type[DataclassInstance], rows: Sequence[DataclassInstance]) -> str:
    """Gives the text of the same."""
    out = StringIO(newline="")
    writer = csv.DictWriter(out, [field.name for field in fields(record)], lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: as_cell(value) for name, value in asdict(row).items()} for row in rows)
    return out.getvalue()
