"""The columns that every row of the catalogue has, and what a cell may hold.

Every length is in mm and every mass in g, as the field names say. `verified` is honest about where a row stands:
"yes: <date, what was read where>" when every number was found in a source that was opened, "partly: <the same>; <the
rest> no, from memory, check before ordering", or "no, <why>, check before ordering".

A default is what a user's own row has where it leaves the column out, or its cell empty; order code and description
are its id then. Rows of this project state everything but what may be None or "".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Annotated, ClassVar

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field
from pydantic.dataclasses import dataclass

from delta_cad.common.refusal import visible

MOST_LETTERS = 4000  # of a text; the longest of ours has a half
ROW = ConfigDict(extra="forbid", allow_inf_nan=False, validate_default=True, defer_build=True)


def _split(cell: object) -> object:
    return tuple(cell.split(";")) if isinstance(cell, str) else cell


def _ascending(numbers: tuple[float, ...]) -> tuple[float, ...]:
    if list(numbers) != sorted(set(numbers)):
        raise ValueError("must ascend")
    return numbers


# No figure of a part is near either bound, and powers and quotients of such stay within doubles.
Quantity = Annotated[float, Field(ge=1e-12, le=1e12)]
NotNegative = Annotated[float, Field(ge=0, le=1e12)]
Count = Annotated[int, Field(gt=0, lt=10**15)]  # each is a double, too
MaybeText = Annotated[str, BeforeValidator(visible), Field(max_length=MOST_LETTERS)]
Text = Annotated[MaybeText, Field(min_length=1)]
Texts = Annotated[tuple[Text, ...], BeforeValidator(_split)]  # in one cell, separated by semicolons
Lengths = Annotated[tuple[Quantity, ...], BeforeValidator(_split), AfterValidator(_ascending)]


@dataclass(frozen=True, kw_only=True, config=ROW)
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
        partners: Columns that hold an id of another family -> that family.
        derived: Columns that a user's own row may leave out -> what they hold then, by the other columns' numbers.
    """

    partners: ClassVar[Mapping[str, str]] = {}
    derived: ClassVar[Mapping[str, Callable[[Callable[[str], float]], float]]] = {}

    id: Annotated[Text, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9.-]*$")]
    standard: MaybeText = ""
    maker: Text = "any"
    order_code: Text
    description: Text
    source: Text = "the user's own catalogue"
    verified: Annotated[Text, Field(pattern=r"^(yes: \S|partly: \S|no, \S)")] = "no, stated by the user"
    price_EUR: Quantity | None = None
    price_source: MaybeText = ""

    @property
    def to_drawing(self) -> bool:
        """Whether nobody has it in stock: it is made by a drawing of ours, as its order or its description says."""
        return "to drawing" in f"{self.order_code} {self.description}"

    def fault(self) -> str:
        """Says what cannot be true of the row, or nothing; each family adds what holds between its fields."""
        return ""


def outside(name: str, value: float, bounds: tuple[float, float], unit: str) -> str:
    """Says that a figure is not within what can be true, bounds included, or nothing."""
    low, high = bounds
    return "" if low <= value <= high else f"{name} = {value:g}: must be {low:g} to {high:g} {unit}"
