"""A small checker of JSON Schema, draft 2020-12, for the keywords that our schemas use."""

from __future__ import annotations

import re
from typing import Any


def violations(schema: dict[str, Any], data: object, root: dict[str, Any]) -> list[str]:
    """What data has against a schema; an unknown keyword fails."""
    found: list[str] = []
    for key, rule in schema.items():
        number = isinstance(data, int | float) and not isinstance(data, bool)
        match key:
            case "title" | "description" | "default" | "$defs" | "$schema" | "$comment" | "deprecated" | "examples":
                pass
            case "if":
                then = schema.get("else" if violations(rule, data, root) else "then", {})
                found += violations(then, data, root)
            case "then" | "else":
                pass  # of "if"
            case "allOf":
                found += [violation for part in rule for violation in violations(part, data, root)]
            case "not":
                found += [] if violations(rule, data, root) else [key]
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
            case "items":
                items = data[len(schema.get("prefixItems", ())) :] if isinstance(data, list) else ()
                found += [violation for item in items for violation in violations(rule, item, root)]
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
