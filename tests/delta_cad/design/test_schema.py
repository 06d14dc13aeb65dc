"""The JSON Schema of the design file: it takes what the reader takes and refuses what the reader refuses."""

from __future__ import annotations

import copy
import json
import math
import re
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given

from delta_cad.catalogue import CatalogueError
from delta_cad.design import Design, design_schema, design_to_json
from tests.committed import BEST
from tests.designs import REFUSED, UNTIMED, changed, designs, minimal, named


def violations(schema: dict[str, Any], data: object, root: dict[str, Any]) -> list[str]:
    """A small JSON Schema checker, for the keywords that the schema uses; an unknown keyword fails."""
    found: list[str] = []
    for key, rule in schema.items():
        number = isinstance(data, int | float) and not isinstance(data, bool)
        match key:
            case "title" | "description" | "default" | "$defs" | "$schema" | "items":
                pass
            case "if":
                then = schema.get("else" if violations(rule, data, root) else "then", {})
                found += violations(then, data, root)
            case "then" | "else":
                pass  # of "if"
            case "minLength":
                found += [key] if isinstance(data, str) and len(data) < rule else []
            case "maxLength":
                found += [key] if isinstance(data, str) and len(data) > rule else []
            case "$ref":
                found += violations(root["$defs"][rule.removeprefix("#/$defs/")], data, root)
            case "type":
                kinds = {
                    "object": isinstance(data, dict),
                    "array": isinstance(data, list),
                    "string": isinstance(data, str),
                    "number": number,
                    "null": data is None,
                }
                found += [] if kinds[rule] else [key]
            case "required":
                found += [f"{key} {name}" for name in rule if isinstance(data, dict) and name not in data]
            case "properties" if isinstance(data, dict):
                found += [f"{n}: {v}" for n in rule if n in data for v in violations(rule[n], data[n], root)]
            case "additionalProperties" if isinstance(data, dict) and rule is False:
                found += [f"{key} {name}" for name in data if name not in schema["properties"]]
            case "properties" | "additionalProperties":
                pass
            case "const":
                found += [] if data == rule else [key]
            case "enum":
                found += [] if data in rule else [key]
            case "pattern":
                found += [] if not isinstance(data, str) or re.search(rule, data) else [key]
            case "anyOf":
                found += [] if any(not violations(option, data, root) for option in rule) else [key]
            case "prefixItems":
                pairs = zip(rule, data, strict=False) if isinstance(data, list) else ()
                found += [violation for part, item in pairs for violation in violations(part, item, root)]
            case "minItems":
                found += [key] if isinstance(data, list) and len(data) < rule else []
            case "maxItems":
                found += [key] if isinstance(data, list) and len(data) > rule else []
            case "exclusiveMinimum":
                found += [key] if number and not data > rule else []
            case "minimum":
                found += [key] if number and not data >= rule else []
            case "exclusiveMaximum":
                found += [key] if number and not data < rule else []
            case "maximum":
                found += [key] if number and not data <= rule else []
            case _:
                raise AssertionError(f"the checker does not know {key}")
    return found


def test_the_schema_accepts_what_the_reader_accepts() -> None:
    schema = design_schema()
    assert violations(schema, json.loads(BEST.read_text(encoding="utf-8")), schema) == []
    assert violations(schema, minimal(), schema) == []
    assert violations(schema, json.loads(json.dumps(schema["$defs"]["Hardware"]["properties"])), schema) != []


@UNTIMED
@given(design=designs())
def test_the_schema_accepts_every_written_design(design: Design) -> None:
    schema = design_schema()
    assert violations(schema, json.loads(design_to_json(design)), schema) == []


IN_SCHEMA = [
    (path, value)
    for path, value, _ in REFUSED
    if "provenance" not in path and not (isinstance(value, float) and not math.isfinite(value))
]


@pytest.mark.parametrize(("path", "value"), IN_SCHEMA, ids=named)
def test_the_schema_refuses_what_the_reader_refuses(path: str, value: object) -> None:
    schema = design_schema()
    assert violations(schema, changed(path, value), schema) != []


def test_the_schema_is_json_and_does_not_change_when_read() -> None:
    schema = design_schema()
    untouched = copy.deepcopy(schema)
    schema["$defs"]["Hardware"]["else"]["properties"]["motor"]["enum"].clear()
    assert design_schema() == untouched == json.loads(json.dumps(untouched))


def test_the_schema_takes_own_ids_where_a_folder_is_named(tmp_path: Path) -> None:
    (tmp_path / "cable.csv").write_text("id,diameter_mm,breaking_load_N\nmine,0.5,150\n", encoding="utf-8")
    ours, known = design_schema(), design_schema(tmp_path)
    for hardware, accepted in (
        ({"cable": "mine"}, (False, False)),
        ({"cable": "mine", "catalogue": None}, (False, False)),
        ({"cable": "mine", "catalogue": "parts"}, (True, True)),
        ({"cable": "yours", "catalogue": "parts"}, (True, False)),
        ({"cable": "steel-0.54-7x7", "catalogue": "parts"}, (True, True)),
        ({"catalogue": ""}, (False, False)),
    ):
        data = changed("hardware", hardware)
        assert tuple(violations(schema, data, schema) == [] for schema in (ours, known)) == accepted, hardware
    with pytest.raises(CatalogueError):
        design_schema(tmp_path / "none")
