"""The columns that every row of the catalogue has.

Every length is in mm and every mass in g, as the field names say. `verified` is honest about where a row stands:
"yes: <where>" when all of it was confirmed, "partly: <what and where>; <the rest> no, from memory, check before
ordering", or "no, from memory, check before ordering".
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class CatalogueRow:
    """A row of the catalogue.

    Attributes:
        id: Key in the design file, unique in its family, lower case.
        standard: Standard the part follows ("ISO 4762") or "".
        maker: Maker, or "any" for standard parts.
        order_code: What to order.
        description: One line for the bill of materials.
        source: Datasheet, catalogue or table the numbers come from.
        verified: "yes: ...", "partly: ..." or "no, ...".
    """

    id: str
    standard: str
    maker: str
    order_code: str
    description: str
    source: str
    verified: str

    def fault(self) -> str:
        """Says what cannot be true of the row, or nothing; each family adds what holds between its fields."""
        return ""
