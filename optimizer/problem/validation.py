"""Files of requirements validated: numbers with their units made plain, every fault told, not the first alone."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, TypeVar, get_args, get_origin

from pydantic import BaseModel, ValidationError

from delta_cad.common.refusal import RefusedError, bounds_of, not_finite, short, unknown_key, within
from delta_cad.design import NAME_RULE, Hardware
from delta_cad.design.file import UNITS
from optimizer.problem.quantity import DEGREES, KINDS, QuantityError, quantity

MOST_REPORTED = 40  # faults of one file that are told, a line each: more scroll away what they begin with
_Loc = tuple[int | str, ...]
Fault = tuple[str, str, str]
"""Dotted field, its value as text, what would be allowed."""
Edition = TypeVar("Edition", bound=BaseModel)


class RequirementsError(RefusedError):
    """Requirements that are refused."""


class Found(NamedTuple):
    """What of a file is not refused.

    Attributes:
        known: Dotted field, such as "requirements.force_N" -> value, of the fields that have one; the default where it
            is left out.
        stated: The fields that the file states, refused or not.
        hardware: Entries of table `[hardware]`, numbers made plain.
        refused: The fields that are refused.
    """

    known: Mapping[str, Any]
    stated: frozenset[str]
    hardware: Mapping[str, Any]
    refused: frozenset[str]


def read(
    model: type[Edition],
    data: object,
    file: str,
    contradictions: Callable[[Found], Iterable[Fault]],
    check_hardware: Callable[[Mapping[str, Any]], Iterable[RequirementsError]] = lambda _: (),
) -> tuple[Edition, frozenset[str]]:
    """Reads plain data as a record of tables, or refuses it with all its faults.

    Args:
        model: The record; its fields are the file's tables, but the name.
        data: What the TOML file holds: nested dicts, lists, numbers, strings; a string such as "12 cm" counts as the
            number that it means.
        file: Name that error messages start with.
        contradictions: Finds what cannot be asked together.
        check_hardware: Finds the faults of the entries of table `[hardware]`.

    Returns:
        The record; the fields that the file states.

    Raises:
        RequirementsError: A missing or unknown field, a wrong type or unit, a number that is not finite or out of its
            range, a name that is not safe as a file name, or what is found beside these: the first fault, the others,
            each once, as its `more`.
    """
    record, found, faults = _validated(model, data, file)
    faults += [RequirementsError(file, *fault) for fault in contradictions(found)]
    faults += check_hardware(found.hardware)
    if record is not None and not faults:
        return record, found.stated
    first, lines = faults[0], list(dict.fromkeys(map(str, faults)))
    rest = len(lines) - MOST_REPORTED
    first.more = tuple(lines[1:MOST_REPORTED]) + ((f"{first.file}: {rest} more faults",) if rest > 0 else ())
    raise first


def _validated(model: type[Edition], data: object, file: str) -> tuple[Edition | None, Found, list[RequirementsError]]:
    """Validates plain data, each field by itself; without a record where one is refused."""
    if not isinstance(data, Mapping):
        fault = RequirementsError(file, "", short(data), "must be a table")
        return None, Found({}, frozenset(), {}, frozenset({""})), [fault]
    plain, refused = _plain(model, data, file)
    for entry, value in _table(plain.get("hardware")).items():
        if (bad := not_finite({entry: value})) is not None:
            refused["hardware", entry] = RequirementsError(file, f"hardware.{bad[0]}", short(bad[1]), "must be finite")
    record = None
    try:
        record = model.model_validate(plain)
    except ValidationError as error:
        for one in error.errors(include_url=False):
            loc = one["loc"]
            if not any(loc[:depth] in refused for depth in range(1, len(loc) + 1)):
                refused[loc] = _explained(model, file, one["type"], loc, one["input"])
    wrong = {loc[:2] for loc in refused}
    words = {name for name, value in plain.items() if name in model.model_fields and isinstance(value, str)}
    known: dict[str, Any] = {name: plain[name] for name in words if (name,) not in wrong}
    stated: set[str] = set()
    for table, inner in _tables(model).items():
        given = _table(plain.get(table))
        for name, info in inner.model_fields.items():
            field = f"{table}.{name}"
            stated |= {field} if name in given else set()
            if (table,) in wrong or (table, name) in wrong or (name not in given and info.is_required()):
                continue
            value = _as_numbers(given[name]) if name in given else info.get_default(call_default_factory=True)
            known |= {} if value is None else {field: value}
    hardware = {e: v for e, v in _table(plain.get("hardware")).items() if ("hardware", e) not in wrong}
    fields = frozenset(fault.field.split("[")[0] for fault in refused.values())
    return record, Found(known, frozenset(stated), hardware, fields), list(refused.values())


def _table(data: object) -> Mapping[str, Any]:
    return data if isinstance(data, Mapping) else {}


def _tables(model: type[BaseModel]) -> dict[str, type[BaseModel]]:
    """Finds the fields of a record that are tables, and their records."""
    found: dict[str, type[BaseModel]] = {}
    for name, info in model.model_fields.items():
        for kind in (info.annotation, *get_args(info.annotation)):
            if isinstance(kind, type) and issubclass(kind, BaseModel):
                found[name] = kind
    return found


def unit_of(table: str, name: str) -> str:
    """Gives the unit of a field, as its name ends; "" for a number without one."""
    own = {"bounds_mm": "mm", "bounds_deg": "deg"}.get(table)
    return own or next((unit for end, unit in UNITS.items() if name.endswith(end)), "")


def _holds_numbers(annotation: Any) -> bool:
    """Tells whether a field takes a number or numbers, from its annotation."""
    return annotation is float or any(_holds_numbers(part) for part in get_args(annotation))


def _plain(model: type[BaseModel], data: Mapping[str, Any], file: str) -> tuple[dict[str, Any], dict[_Loc, Any]]:
    """Converts texts with a unit to numbers; gives the converted data, and the faults by location."""
    plain: dict[str, Any] = dict(data)
    refused: dict[_Loc, RequirementsError] = {}
    for table, inner in (_tables(model) | ({"hardware": Hardware} if "hardware" in model.model_fields else {})).items():
        given = data.get(table)
        if not isinstance(given, Mapping):
            continue
        plain[table] = dict(given)
        for name, info in inner.model_fields.items():
            if name in given and _holds_numbers(info.annotation):
                loc: _Loc = (table, name)
                plain[table][name] = _number(given[name], unit_of(table, name), loc, refused, file)
    return plain, refused


def _number(value: Any, unit: str, loc: _Loc, refused: dict[_Loc, Any], file: str) -> Any:
    """Converts a text with a unit, or each of a list, to a number."""
    if isinstance(value, list):
        return [_number(one, unit, (*loc, k), refused, file) for k, one in enumerate(value)]
    if isinstance(value, str):
        try:
            found = quantity(value, unit)
        except QuantityError as error:
            refused[loc] = RequirementsError(file, dotted(loc), short(value), str(error))
        else:
            return value if found is None else found
    return value


def _as_numbers(value: Any) -> Any:
    """Converts the whole numbers in an accepted value to doubles."""
    if isinstance(value, list | tuple):
        return tuple(map(_as_numbers, value))
    return float(value) if isinstance(value, int) else value


def dotted(loc: _Loc) -> str:
    """Writes a location as messages have it, such as "bounds_mm.half_side[1]"."""
    return "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in loc).lstrip(".")


def _allowed(model: type[BaseModel], loc: _Loc) -> str:
    """Describes the allowed values of a field, from its declaration."""
    table, tables = str(loc[0]), _tables(model)
    if table == "hardware":
        return "must be a table" if len(loc) == 1 else "must be text, a number, or a list of what may be used"
    if table not in tables and table in model.model_fields:
        words = _inner(model.model_fields[table].annotation, Literal)
        return _one_of(words) if words else NAME_RULE
    if len(loc) == 1:
        return "must be a table"
    name = str(loc[1])
    info, unit = tables[table].model_fields[name], unit_of(table, name)
    if words := _inner(info.annotation, Literal):
        return _one_of(words)
    if numbers := _inner(info.annotation, tuple):
        kind = {"outline_overhead_mm": "[along W, along D], two", "gravity_m_s2": "a list of 3"}
        bounds = bounds_of(get_args(numbers[0])[1].metadata)
        return f"must be {kind.get(name, '[lower, upper], two')} numbers, each {bounds} {unit}"
    return f"must be a number {bounds_of(info.metadata)} {unit}".rstrip()


def _one_of(words: Sequence[object]) -> str:
    return f"must be {' or '.join(short(word) for word in words)}"


def _inner(annotation: Any, origin: Any) -> tuple[Any, ...]:
    """Finds the arguments of a kind within an annotation; none where there is none of it."""
    if get_origin(annotation) is origin:
        return get_args(annotation)
    return next((found for part in get_args(annotation) if (found := _inner(part, origin))), ())


def _explained(model: type[BaseModel], file: str, kind: str, loc: _Loc, value: object) -> RequirementsError:
    """Turns a finding of the validator into our error."""
    field = dotted(loc)
    if kind == "extra_forbidden":
        if len(loc) > 1 and loc[-1] in model.model_fields.keys() - {"name", "hardware"}:
            return RequirementsError(file, field, short(value), "stands at the top of the file, before the tables")
        known = _tables(model).get(str(loc[0]), model) if len(loc) > 1 else model
        other = [f"{table}.{name}" for table, inner in _tables(model).items() for name in inner.model_fields]
        reported = unknown_key(field.rpartition(".")[2], known.model_fields, other)
        if field in getattr(model, "second_edition", ()):
            reported = reported.replace("unknown key", "of the second edition, which design alone reads")
        return RequirementsError(file, field, short(value), reported)
    if kind == "missing" and not isinstance(loc[-1], int):
        return RequirementsError(file, field, "", f"is missing; {_allowed(model, loc)}")
    if kind == "finite_number":
        return RequirementsError(file, field, short(value), "must be finite")
    return RequirementsError(file, field, short(value), _allowed(model, loc) + _in_another_unit(model, loc, value))


def _in_another_unit(model: type[BaseModel], loc: _Loc, value: object) -> str:
    """Suggests the number to write if one out of bounds would be within them in another unit; else ""."""
    table = _tables(model).get(str(loc[0]))
    if table is None or len(loc) != 2 or isinstance(value, bool) or not isinstance(value, int | float):
        return ""
    unit, bounds = unit_of(*map(str, loc)), table.model_fields[str(loc[1])].metadata
    for name, factor in KINDS.get(unit, ("", {}))[1].items():
        meant = float(f"{value * float(factor or DEGREES):.6g}")
        if name != unit and within(bounds, meant):
            return f"; if {name} were meant write {meant:.6g}"
    return ""
