"""The cost of a machine: every line of its bill of materials, for one, ten and a hundred machines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.export.shop.cost.bought import Price, part_price, prices
from delta_cad.export.shop.cost.rates import (
    BATCHES,
    BREAKS,
    CURRENCY,
    ESTIMATE,
    OTHER,
    PRINTED_EUR_KG,
    PRINTS,
    STOCKS,
    Rates,
)
from delta_cad.export.shop.cost.work import Making, Work, coat_of, making, material_id, printing, work_of
from delta_cad.solids.part import Part

_SCHEMA = "delta-cost/1"
CENTS, _MILLS = 2, 3
_OTHER_STOCK = "other"
_FORMULA = (
    "unit = stock_EUR + material + coat + piece_min rate + (batch_min rate + coat's lot) / pieces; "
    "piece_min = cutting (1 + idle) + tools + clampings handling + deburring; cutting = removed / removal + "
    "area / finish + bores (drill) + threads + fits; batch_min = programming + clampings set-up; of stock as bought: "
    "piece_min = the saw's cut, or bores (erode) + fits, + handling; batch_min = set-up; of sheet: piece_min = "
    "handling + deburring, and the beam's lot / pieces + its area + contours; parts with the same coat share its lot"
)
_MADE = f"{ESTIMATE} from stock, cutting and clampings, see cost.json"
_PRINTED = f"{ESTIMATE} from material, the printer's hours and work by hand, see cost.json"
_LEFT_OUT = ("assembly", "electronics and motor drives", "inspection", "freight", "tax")


@dataclass(frozen=True)
class CostLine:
    """What one part number costs.

    Attributes:
        number: Part number.
        quantity: In a machine.
        made: Whether it is machined.
        unit_EUR: Of one, for each of `BATCHES`, to the cent.
        source: Of the price.
        work: What there is to do, of a made part.
        making: What that costs, likewise.
        stock: What of `assumed.stock` it is cut from, likewise.
        stock_EUR: Of one, for each of `BATCHES`: what is cut was bought by the piece or metre; likewise.
    """

    number: str
    quantity: int
    made: bool
    unit_EUR: tuple[float, ...]
    source: str
    work: Work | None = None
    making: Making | None = None
    stock: str = ""
    stock_EUR: tuple[float, ...] = ()


@dataclass(frozen=True)
class Cost:
    """What a machine costs, line by line; `rates` is the shop."""

    lines: tuple[CostLine, ...]
    rates: Rates

    def total_EUR(self, batch: int = 0, made: bool | None = None) -> float:
        """Sums what one machine costs, EUR.

        Args:
            batch: Index into `BATCHES`.
            made: Only what is made, or bought; None: all.
        """
        lines = (line for line in self.lines if made is None or line.made is made)
        return round(sum(line.quantity * line.unit_EUR[batch] for line in lines), CENTS)

    @property
    def by_number(self) -> dict[str, CostLine]:
        """Part number -> its line."""
        return {line.number: line for line in self.lines}


def machine_cost(d: Dimensions, assembly: Assembly, clampings: Mapping[str, int], rates: Rates | None = None) -> Cost:
    """Computes what a machine with its solids costs; clampings by part number, the usual rates where none are given."""
    shop, known = rates or Rates(), prices(d)
    quantity = Counter(occurrence.part.number for occurrence in assembly.occurrences)
    lines, coats = [], Counter(filter(None, map(coat_of, assembly.parts)))
    for part in (part for part in assembly.parts if not part.piece_of):
        count = quantity[part.number]
        if not part.make:
            lines.append(_bought(part.number, count, known.get(part.number) or part_price(part.number)))
            continue
        material = material_id(part)
        if part.material.process:
            lines.append(_printed(part, count, material, shop))
            continue
        work = work_of(part, clampings.get(part.number, 1), shop)
        todo, stock = making(work, material, shop), known.get(part.number)
        if coat := coat_of(part):  # parts of an order with the same coat are one lot
            todo = replace(todo, batch_EUR=todo.batch_EUR / coats[coat])
        paid = [0.0 if stock is None else stock.of_one(count, machines) for machines in BATCHES]
        units = (
            round(todo.of_one(count * machines, shop) + bought, CENTS)
            for machines, bought in zip(BATCHES, paid, strict=True)
        )
        source = _MADE if stock is None else f"{_MADE}; stock: {stock.source}"
        name = material if material in STOCKS else _OTHER_STOCK
        lines.append(CostLine(part.number, count, True, tuple(units), source, work, todo, name, tuple(paid)))
    lines += [
        _bought(one.number, one.quantity, known.get(one.number) or part_price(one.number)) for one in assembly.supplies
    ]
    return Cost(tuple(lines), shop)


def _printed(part: Part, count: int, material: str, shop: Rates) -> CostLine:
    """The line of a printed part: filament or powder, the printer's hours, and what is done by hand."""
    todo = printing(part, material)
    units = tuple(round(todo.of_one(count * machines, shop), CENTS) for machines in BATCHES)
    return CostLine(part.number, count, True, units, _PRINTED, making=todo, stock=material)


def _bought(number: str, quantity: int, price: Price) -> CostLine:
    units = (round(price.of_one(quantity, machines), CENTS) for machines in BATCHES)
    return CostLine(number, quantity, False, tuple(units), price.source)


def cost_record(cost: Cost) -> dict[str, Any]:
    """Gives a cost with all that it rests on as JSON types: `cost.json`."""
    return {
        "schema": _SCHEMA,
        "currency": CURRENCY,
        "assumed": {
            "shop": cost.rates.record(),
            "stock": {name: asdict(stock) for name, stock in STOCKS.items()} | {_OTHER_STOCK: asdict(OTHER)},
            "stock_source": f"{ESTIMATE} for cut lengths and a small mill; volume of the part with its allowance",
            "print": {name: asdict(one) for name, one in PRINTS.items()} | {"material_EUR_kg": PRINTED_EUR_KG},
            "bought_share_by_machines": {str(count): share for count, share in BREAKS.items()},
            "bought_share_source": ESTIMATE,
            "formula": _FORMULA,
            "left_out": list(_LEFT_OUT),
        },
        "machines": list(BATCHES),
        "total_EUR": [cost.total_EUR(k) for k in range(len(BATCHES))],
        "made_EUR": [cost.total_EUR(k, True) for k in range(len(BATCHES))],
        "bought_EUR": [cost.total_EUR(k, False) for k in range(len(BATCHES))],
        "lines": [_line_record(line) for line in cost.lines],
    }


def _line_record(line: CostLine) -> dict[str, Any]:
    found: dict[str, Any] = {
        "part_number": line.number,
        "quantity": line.quantity,
        "made": line.made,
        "unit_EUR": list(line.unit_EUR),
        "source": line.source,
    }
    if line.made:
        found |= {"stock": line.stock, "stock_EUR": [round(paid, _MILLS) for paid in line.stock_EUR]}
    for name, record in (("work", line.work), ("making", line.making)):
        if record is not None:
            found[name] = {
                key: round(value, _MILLS) if isinstance(value, float) else value
                for key, value in asdict(record).items()
            }
    return found
