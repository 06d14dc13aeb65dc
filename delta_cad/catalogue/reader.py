"""Families of the catalogue: CSV files read into frozen records, and rows that cannot be true refused."""

from __future__ import annotations

import csv
import io
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar, cast, get_args

from pydantic import ValidationError
from pydantic.fields import FieldInfo

from delta_cad.catalogue.row import MOST_LETTERS, CatalogueRow
from delta_cad.common.reading import ReadError, read_bounded, text_of
from delta_cad.common.refusal import bounds_of, printable

DATA = Path(__file__).parent / "data"
MOST_BYTES = 4_000_000  # of a family; ours have a thousandth of it
R = TypeVar("R", bound=CatalogueRow)
_NAMED_BY_ID = ("order_code", "description")  # where a user's own row leaves them out
_NAMED_RULES = {  # by the column, or by the kind of what is wrong
    "too_short": "must not be empty",
    "too_long": f"must have at most {MOST_LETTERS} characters",
    "value_error": "must ascend",
    "id": "must be of letters, digits, . and -",
    "verified": "must start with 'yes: ', 'partly: ' or 'no, '",
}


class CatalogueError(Exception):
    """A part that is not in the catalogue, or a row that breaks the catalogue's rules; one printable line."""

    def __init__(self, text: str) -> None:
        super().__init__(printable(text))


def read_family(path: Path, record: type[R], *, own: bool = False, taken: Collection[str] = ()) -> Mapping[str, R]:
    """Reads one family of the catalogue.

    Args:
        path: CSV file, UTF-8, whose header is the record's fields in any order.
        record: The record type of a row.
        own: Whether it is a user's file: it may leave out columns, and leave cells empty, that have a default or may
            be None.
        taken: Ids of rows that are there already.

    Returns:
        Id -> record, read-only, in the order of the file.

    Raises:
        CatalogueError: Unreadable file, wrong columns, a cell that is not what its field says, a negative or zero
            quantity, fields that contradict each other, a repeated or taken id, or a `verified` that does not say yes,
            partly or no.
    """
    rows: dict[str, R] = {}
    optional = optional_columns(record)
    may_be_empty = {name for name in optional if own or columns_of(record)[name].default in (None, "")}
    try:
        text = text_of(read_bounded(path, MOST_BYTES), path.name)
        table = csv.DictReader(io.StringIO(text, newline=""), strict=True)
        header = list(table.fieldnames or ())
        _require_columns(path.name, header, list(columns_of(record)), optional if own else frozenset())
        for cells in table:
            where = f"{path.name} line {table.line_num}"
            if None in cells or None in cells.values():
                raise CatalogueError(f"{where}: needs {len(header)} cells")
            stated: dict[str, Any] = {
                name: cell.strip() for name, cell in cells.items() if cell.strip() or name not in may_be_empty
            }
            if own:
                _derive(stated, record)
            try:
                row = record(**stated)
            except ValidationError as error:
                raise CatalogueError(f"{where}: {_explained(error, record)}") from None
            if row.id in rows:
                raise CatalogueError(f"{where}: id = {row.id!r}: must be unique")
            if row.id in taken:
                raise CatalogueError(f"{where}: id = {row.id!r}: is a row of ours; must be another: none is replaced")
            if row.price_EUR is not None and not row.price_source:
                raise CatalogueError(f"{where}: price_source = '': must say date and source of price_EUR")
            if fault := row.fault():
                raise CatalogueError(f"{where}: {fault}")
            rows[row.id] = row
    except ReadError as error:
        raise CatalogueError(str(error)) from None
    except csv.Error as error:
        raise CatalogueError(f"{path.name}: is not a table we can read: {error}") from None
    return MappingProxyType(rows)


def columns_of(record: type[CatalogueRow]) -> dict[str, FieldInfo]:
    """Gives the columns of a record: those of every row first."""
    return record.__pydantic_fields__  # pyright: ignore[reportAttributeAccessIssue]


def optional_columns(record: type[CatalogueRow]) -> frozenset[str]:
    """Gives the columns that a user's own file may leave out: those with a default, which is None for some."""
    defaults = {name for name, field in columns_of(record).items() if not field.is_required()}
    return frozenset(defaults | record.derived.keys() | set(_NAMED_BY_ID))


def _derive(stated: dict[str, Any], record: type[CatalogueRow]) -> None:
    """Adds what follows for columns that are left out; what follows from no number is told of that number's column."""

    def cell(name: str) -> float:
        return float(stated.get(name, columns_of(record)[name].default))

    for name in _NAMED_BY_ID:
        stated.setdefault(name, stated.get("id"))
    for name in record.derived.keys() - stated.keys():
        with suppress(ValueError, TypeError, ArithmeticError):
            stated[name] = record.derived[name](cell)


def _require_columns(file: str, header: list[str], names: list[str], optional: frozenset[str]) -> None:
    """Refuses a header with columns that are missing, not known or repeated."""
    missing = sorted(set(names) - optional - set(header))
    extra = str(sorted(set(header) - set(names)))
    if missing or len(set(header)) < len(header) or not set(header) <= set(names):
        raise CatalogueError(f"{file}: columns missing {missing}, not known {extra}, or repeated")


def _explained(error: ValidationError, record: type[CatalogueRow]) -> str:
    """Says what is wrong with a row: column, cell and what is allowed."""
    first = min(error.errors(include_url=False), key=lambda one: one["type"] == "missing")  # which follows from others
    name, kind = str(first["loc"][0]), first["type"]
    field = columns_of(record)[name]
    inner = (info for part in get_args(field.annotation) for info in getattr(part, "__metadata__", ()))
    bounds = bounds_of([*field.metadata, *(bound for info in inner for bound in getattr(info, "metadata", ()))])
    number = f"must be a {'whole ' * kind.startswith('int')}number {bounds}"
    rule = _NAMED_RULES.get(name if kind == "string_pattern_mismatch" else kind)
    return f"{name} = {first['input']!r}: {rule or (number if bounds else first['msg'].removeprefix('Value error, '))}"


@dataclass(frozen=True)
class OwnParts:
    """A user's own rows.

    Attributes:
        folder: Where they were read.
        rows: Name of a family -> id -> row.
    """

    folder: Path
    rows: Mapping[str, Mapping[str, CatalogueRow]]


class _Choice(Protocol):
    """What names one row of each family that it has an attribute of: a design's hardware."""

    @property
    def own_parts(self) -> OwnParts | None:
        """The user's own rows, which come beside ours."""
        ...


class Family(Generic[R]):
    """A family of bought parts; called with an id it gives that row.

    Attributes:
        name: As the design file and error messages name it.
        file: CSV file in the catalogue's folder `data`.
        record: Record of a row; its fields are the columns.
    """

    def __init__(self, name: str, file: str, record: type[R]) -> None:
        self.name, self.file, self.record = name, file, record

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns of its file, those of every row first."""
        return tuple(columns_of(self.record))

    def chosen(self, hardware: _Choice) -> R:
        """Gives the row that a design's hardware names, from the user's own parts or ours.

        Raises:
            CatalogueError: There is none; the message lists the legal ids of ours.
        """
        key = getattr(hardware, self.name)
        own = hardware.own_parts
        row = None if own is None else own.rows.get(self.name, {}).get(key)
        return self(key) if row is None else cast(R, row)

    @cached_property
    def rows(self) -> Mapping[str, R]:
        """Id -> record, in the order of the file; read when first asked for.

        Raises:
            CatalogueError: The file breaks a rule (the message says where).
        """
        return read_family(DATA / self.file, self.record)

    def __call__(self, key: str) -> R:
        """Gives the row with an id.

        Raises:
            CatalogueError: There is none; the message lists the legal ids.
        """
        if key not in self.rows:
            legal = ", ".join(self.rows)
            raise CatalogueError(f"no {self.name.replace('_', ' ')} {key!r} in the catalogue; legal: {legal}")
        return self.rows[key]
