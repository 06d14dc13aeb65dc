"""The JSON Schema of the requirements file: fields, units, bounds, what may be used, what must stand together."""

from __future__ import annotations

from typing import Any

from delta_cad import catalogue
from delta_cad.design import Hardware
from optimizer.problem.brief import IN_RECTANGLE, MOVED, UNUSED, DesignBrief
from optimizer.problem.hardware import DRIVES, MOST
from optimizer.problem.quantity import KINDS, pattern
from optimizer.problem.validation import unit_of

_DRAFT = "https://json-schema.org/draft/2020-12/schema"
_WIDTH, _DEPTH, _CUBE = "envelope_width_mm", "envelope_depth_mm", "cube_side_mm"
_Schema = dict[str, Any]


def brief_schema(own: catalogue.OwnParts | None = None) -> _Schema:
    """Makes the JSON Schema, draft 2020-12, of the requirements file as `load_brief` reads it.

    A text with a unit is told by its form alone: whether its number is within the bounds, and which numbers contradict
    each other, is for the reader.

    Args:
        own: The user's own parts, whose ids are legal, too, where the file names a folder.
    """
    schema = DesignBrief.model_json_schema()
    records, fields = schema["$defs"], {}
    for name, inner in schema["properties"].items():
        plain = _not_null(inner)
        fields[name] = _table(records[plain["$ref"].rpartition("/")[2]], name) if "$ref" in plain else _field(inner, "")
    return {
        "$schema": _DRAFT,
        "$defs": {_kind(unit): {"type": "string", "pattern": pattern(unit)} for unit in KINDS},
        "title": "requirements of a delta haptic device",
        "type": "object",
        "additionalProperties": False,
        "required": schema["required"],
        "properties": fields | {"hardware": _hardware(own)},
        "allOf": _together(),
    }


def _not_null(inner: _Schema) -> _Schema:
    """Leaves out that a value may be null, which TOML has not."""
    return next((one for one in inner.get("anyOf", ()) if one.get("type") != "null"), inner)


def _kind(unit: str) -> str:
    """Names the texts with a unit of a kind, such as "length"."""
    return KINDS[unit][0].split()[1]


def _table(table: _Schema, name: str) -> _Schema:
    """Finishes a table's schema."""
    properties = {field: _field(inner, unit_of(name, field)) for field, inner in table["properties"].items()}
    for field, inner in properties.items():
        why = f"stands in {MOVED[f'{name}.{field}']}" if f"{name}.{field}" in MOVED else UNUSED.get(f"{name}.{field}")
        why = UNUSED.get(name, why)
        if why is not None:
            inner |= {"deprecated": True, "$comment": f"of the first edition: {why}"}
    kept = {key: value for key, value in table.items() if key not in ("properties", "title")}
    return kept | {"properties": properties}


def _field(inner: _Schema, unit: str) -> _Schema:
    """Finishes a field's schema."""
    reported = inner.get("description", "") + (f" [{unit}]" if unit else "")
    about = {"description": reported} | ({} if inner.get("default") is None else {"default": inner["default"]})
    rules = {key: value for key, value in _not_null(inner).items() if key not in ("description", "default", "title")}
    return about | _with_units(rules, unit)


def _with_units(rules: _Schema, unit: str) -> _Schema:
    """Lets a number, or those of a list, be a text with a unit, too."""
    if rules.get("type") == "array":
        return rules | {"prefixItems": [_with_units(one, unit) for one in rules["prefixItems"]]}
    if rules.get("type") != "number" or not unit:
        return rules
    return {"anyOf": [rules, {"$ref": f"#/$defs/{_kind(unit)}"}]}


def _hardware(own: catalogue.OwnParts | None) -> _Schema:
    """Makes the schema of table `[hardware]`: of each entry a value, or a list of what may be used."""
    entries = Hardware.model_json_schema()["properties"]
    fields: _Schema = {}
    for entry, inner in entries.items():
        one = _field(inner, unit_of("hardware", entry))
        one.pop("default", None)
        fields[entry] = one if entry == "catalogue" else _or_list(one)
    named = {"required": ["catalogue"]}
    schema = {
        "description": "what may be used, one value or a list; left out: all of the catalogue, or what suits",
        "type": "object",
        "additionalProperties": False,
        "properties": fields,
        "if": named,
        "else": {"properties": _ids(None)},
    }
    return schema if own is None else schema | {"then": {"properties": _ids(own)}}


def _ids(own: catalogue.OwnParts | None) -> _Schema:
    """Makes the schema of the ids that each family has; of motors those that are for a drive."""
    found: _Schema = {}
    for entry in catalogue.CHOSEN:
        rows = catalogue.family(entry, own).items()
        ids = [key for key, row in rows if not isinstance(row, catalogue.Motor) or set(row.drives) & set(DRIVES)]
        found[entry] = _or_list({"enum": ids})
    return found


def _or_list(one: _Schema) -> _Schema:
    about = {"description": one["description"]} if "description" in one else {}
    rules = {key: value for key, value in one.items() if key != "description"}
    return about | {"anyOf": [rules, {"type": "array", "items": rules, "minItems": 1, "maxItems": MOST}]}


def _states(*fields: str) -> _Schema:
    """Makes the schema of a file that states all of some dotted fields."""
    tables: dict[str, list[str]] = {}
    for field in fields:
        table, name = field.split(".")
        tables.setdefault(table, []).append(name)
    return {"required": list(tables), "properties": {table: {"required": names} for table, names in tables.items()}}


def _together() -> list[_Schema]:
    """Makes the schemas of what must, and of what may not, stand together."""
    width, depth, cube = (f"requirements.{name}" for name in (_WIDTH, _DEPTH, _CUBE))
    outline = _states(width, depth)
    goal = {"properties": {"goal": {"properties": {"minimize": {"enum": list(IN_RECTANGLE)}}}}}
    rectangle = {"required": ["placement"], "properties": {"placement": {"const": "rectangle"}}}
    return [
        {"anyOf": [outline, _states(cube)]},
        {"if": {"anyOf": [_states(width), _states(depth)]}, "then": outline},
        {"if": _states("goal.maximize"), "then": outline},
        {"if": _states("goal.minimize"), "then": _states(cube)},
        {"not": _states("goal.maximize", "goal.minimize")},
        {"if": rectangle, "then": {"allOf": [outline, goal, {"not": _states("limits.outline_radius_max_mm")}]}},
        *({"not": _states(old, new)} for old, new in MOVED.items()),
    ]
