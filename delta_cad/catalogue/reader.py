"""Families of the catalogue: CSV files read into frozen records, and rows that cannot be true refused."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Any, Generic, Protocol, TypeVar, cast, get_args, get_type_hints

from delta_cad.catalogue.row import CatalogueRow
from delta_cad.common.reading import ReadError, read_bounded, text_of
from delta_cad.common.refusal import printable, visible

DATA = Path(__file__).parent / "data"
MOST_BYTES = 4_000_000  # of a family; ours have a thousandth of it
R = TypeVar("R", bound=CatalogueRow)
MOST_DIGITS = 15  # of a whole number: each is a double, too
# Of a number that is not 0: no figure of a part is near either, and powers and quotients of such stay within doubles.
SIZES = 1e-12, 1e12
ID = re.compile(r"[A-Za-z0-9][A-Za-z0-9.-]*")
VERIFIED = re.compile(r"yes: \S.*|partly: \S.*|no, \S.*")
MOST_LETTERS = 4000  # of a text; the longest of ours has a half
MAY_BE_ZERO = frozenset(
    {"red", "green", "blue", "cogging_torque_N_m", "torque_ripple", "pilot_diameter_mm", "pilot_height_mm"}
)
MAY_BE_EMPTY = frozenset({"standard", "price_source", "clearance"})


class CatalogueError(Exception):
    """A part that is not in the catalogue, or a row that breaks the catalogue's rules; one printable line."""

    def __init__(self, text: str) -> None:
        super().__init__(printable(text))


def _number(text: str, zero: bool) -> float:
    try:
        value = float(text)
    except ValueError:  # its message would hold all of the text
        raise ValueError("must be a number") from None
    if not math.isfinite(value) or value < 0.0 or (value == 0.0 and not zero):
        raise ValueError("must be a finite number " + (">= 0" if zero else "> 0"))
    low, high = SIZES
    if value != 0.0 and not low <= value <= high:
        raise ValueError(f"must be {low:g} to {high:g}")
    return value


def _value(text: str, kind: Any, name: str) -> Any:
    """One cell as the type of its field; ValueError says what is wrong."""
    if kind is str:
        if not text and name not in MAY_BE_EMPTY:
            raise ValueError("must not be empty")
        if len(shown := visible(text)) > MOST_LETTERS:
            raise ValueError(f"must have at most {MOST_LETTERS} characters")
        return shown
    if kind is int:
        if not text.isdecimal() or len(text) > MOST_DIGITS or int(text) == 0:
            raise ValueError(f"must be a whole number > 0, of at most {MOST_DIGITS} digits")
        return int(text)
    if kind is float:
        return _number(text, name in MAY_BE_ZERO)
    if type(None) in get_args(kind):
        return _value(text, next(one for one in get_args(kind) if one is not type(None)), name) if text else None
    item = get_args(kind)[0]
    items = tuple(_value(part, item, name) for part in text.split(";"))
    if item is float and list(items) != sorted(set(items)):
        raise ValueError("must ascend")
    return items


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
    kinds = get_type_hints(record)
    names = [field.name for field in fields(record)]
    rows: dict[str, R] = {}
    try:
        text = text_of(read_bounded(path, MOST_BYTES), path.name)
        table = csv.DictReader(io.StringIO(text, newline=""), strict=True)
        header = list(table.fieldnames or ())
        _require_columns(path.name, header, names, optional_columns(record) if own else frozenset())
        for cells in table:
            where = f"{path.name} line {table.line_num}"
            if None in cells or None in cells.values():
                raise CatalogueError(f"{where}: needs {len(header)} cells")
            row = record(**_values(where, cells, kinds, names, record.defaults if own else {}))
            if not ID.fullmatch(row.id) or row.id in rows:
                raise CatalogueError(f"{where}: id = {row.id!r}: must be unique, of letters, digits, . and -")
            if row.id in taken:
                raise CatalogueError(f"{where}: id = {row.id!r}: is a row of ours; must be another: none is replaced")
            if row.price_EUR is not None and not row.price_source:
                raise CatalogueError(f"{where}: price_source = '': must say date and source of price_EUR")
            if fault := row.fault():
                raise CatalogueError(f"{where}: {fault}")
            if not VERIFIED.fullmatch(row.verified):
                rule = "must start with 'yes: ', 'partly: ' or 'no, '"
                raise CatalogueError(f"{where}: verified = {row.verified!r}: {rule}")
            rows[row.id] = row
    except ReadError as error:
        raise CatalogueError(str(error)) from None
    except csv.Error as error:
        raise CatalogueError(f"{path.name}: is not a table we can read: {error}") from None
    return MappingProxyType(rows)


def optional_columns(record: type[CatalogueRow]) -> frozenset[str]:
    """Gives the columns that a user's own file may leave out: those with a default and those that may be None."""
    kinds = get_type_hints(record)
    return frozenset(record.defaults) | {f.name for f in fields(record) if type(None) in get_args(kinds[f.name])}


def _require_columns(file: str, header: list[str], names: list[str], optional: frozenset[str]) -> None:
    """Refuses a header with columns that are missing, not known or repeated."""
    missing = sorted(set(names) - optional - set(header))
    extra = str(sorted(set(header) - set(names)))
    if missing or len(set(header)) < len(header) or not set(header) <= set(names):
        raise CatalogueError(f"{file}: columns missing {missing}, not known {extra}, or repeated")


def _values(
    where: str, cells: Mapping[str, str], kinds: Mapping[str, Any], names: list[str], defaults: Mapping[str, Any]
) -> dict[str, Any]:
    """Makes the fields of a row: first of its cells, then by their defaults those that are empty or left out."""
    values: dict[str, Any] = {}
    left = [name for name in names if name in defaults and not cells.get(name, "").strip()]
    for name in names:
        if name in left:
            continue
        try:
            values[name] = _value(cells.get(name, "").strip(), kinds[name], name)
        except ValueError as error:
            raise CatalogueError(f"{where}: {name} = {cells.get(name, '')!r}: {error}") from None
    for name in left:
        try:
            value = defaults[name](values) if callable(defaults[name]) else defaults[name]
            if isinstance(value, float):
                _number(repr(value), name in MAY_BE_ZERO)
        except ValueError:
            raise CatalogueError(f"{where}: {name}: must be stated: what follows for it is no number > 0") from None
        values[name] = value
    return values


@dataclass(frozen=True)
class OwnParts:
    """A user's own rows.

    Attributes:
        folder: Where they were read.
        rows: Name of a family -> id -> row.
    """

    folder: Path
    rows: Mapping[str, Mapping[str, CatalogueRow]]


class Choice(Protocol):
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
        return tuple(field.name for field in fields(self.record))

    def chosen(self, hardware: Choice) -> R:
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
