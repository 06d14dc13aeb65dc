"""The columns that every row of the catalogue has.

Every length is in mm and every mass in g, as the field names say. `verified` is honest about where a row stands:
"yes: <date, what was read where>" when every number was found in a source that was opened, "partly: <the same>; <the
rest> no, from memory, check before ordering", or "no, <why>, check before ordering".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar


@dataclass(frozen=True)
class CatalogueRow:
    """A row of the catalogue.

    Attributes:
        id: Key in the design file, unique in its family.
        standard: Standard the part follows ("ISO 4762") or "".
        maker: Maker, or "any" for standard parts.
        order_code: What to order.
        description: One line for the bill of materials.
        source: Datasheet, catalogue or table the numbers come from.
        verified: "yes: ...", "partly: ..." or "no, ...".
        price_EUR: Price of one, or of a metre of rope or tube, without tax; None when none was found.
        price_source: Date and source of the price, or "".
        defaults: What columns hold that a user's own row leaves out: a value, or a function of the columns that it
            states and of the defaults before it.
            A column that is neither here nor may be None must be stated.
        partners: Columns that hold an id of another family -> that family.
    """

    defaults: ClassVar[Mapping[str, Any | Callable[[Mapping[str, Any]], Any]]] = {
        "standard": "",
        "maker": "any",
        "order_code": lambda row: row["id"],
        "description": lambda row: row["id"],
        "source": "the user's own catalogue",
        "verified": "no, stated by the user",
        "price_source": "",
    }
    partners: ClassVar[Mapping[str, str]] = {}

    id: str
    standard: str
    maker: str
    order_code: str
    description: str
    source: str
    verified: str
    price_EUR: float | None
    price_source: str

    def fault(self) -> str:
        """Says what cannot be true of the row, or nothing; each family adds what holds between its fields."""
        return ""


def outside(name: str, value: float, bounds: tuple[float, float], unit: str) -> str:
    """Says that a figure is not within what can be true, bounds included, or nothing."""
    low, high = bounds
    return "" if low <= value <= high else f"{name} = {value:g}: must be {low:g} to {high:g} {unit}"
