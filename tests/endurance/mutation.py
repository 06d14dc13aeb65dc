"""Damage to valid files, by their grammar and by their bytes: the same for the same random numbers."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable
from random import Random
from typing import Any

NAMES = (
    "",
    "a.b",
    "\x1b[2J",
    "\x1b]0;title\x07",
    "\u202etxt",
    "\ud800",
    "\0",
    "\n\r",
    "__proto__",
    "k" * 5000,
    "ü" * 40,
)
NUMBERS = (
    0, -1, 1, 2**31, 2**63, 2**64, -(2**63), 10**15, 10**400, 0.0, -0.0, 5e-324, 1e-320, 1e-9, 0.1, 1.5, 1e9, 1e308,
    -1e308, math.inf, -math.inf, math.nan,
)  # fmt: skip
OTHERS = (None, True, False, [], {}, [[]], [{}], [None, "", 0], {"a": {"b": []}}, {"linspace": [0, 1, 3]}, [0.0] * 3000)
LARGEST = 1e300  # of what is scaled: it stays a double
PIECES = (b"\0", b"\xff\xfe", b"\xed\xa0\x80", b"\xc0\xaf", b"\x1b[31m", b"\r", b'"', b"'", b"{", b"[" * 50, b"," * 9)


def strange(rng: Random) -> Any:
    """A value that few fields expect."""
    kind = rng.randrange(6)
    if kind == 0:
        return rng.choice(NAMES)
    if kind == 1:
        return rng.choice(NUMBERS)
    if kind == 2:
        return copy.deepcopy(rng.choice(OTHERS))
    if kind == 3:
        return _nested(rng, rng.choice((3, 30, 33, 100, 200)))
    if kind == 4:
        return rng.uniform(-1.0, 1.0) * 10.0 ** rng.randint(-12, 12)
    return rng.randint(-1000, 1000)


def _nested(rng: Random, depth: int) -> Any:
    value: Any = 1
    for _ in range(depth):
        value = [value] if rng.random() < 0.5 else {"a": value}
    return value


def places(data: Any) -> list[tuple[Any, Any]]:
    """Every object or list of nested data, with each of its keys or indices."""
    found = []
    keys = data.keys() if isinstance(data, dict) else range(len(data)) if isinstance(data, list) else ()
    for key in keys:
        found.append((data, key))
        found += places(data[key])
    return found


def mutated(data: Any, rng: Random) -> Any:
    """A copy of plain data with one to three values changed, scaled, taken away, added, moved or renamed."""
    data = copy.deepcopy(data)
    for _ in range(rng.choice((1, 1, 2, 3))):
        known = places(data)
        if not known:
            return strange(rng)
        part, key = rng.choice(known)
        value, how = part[key], rng.randrange(6)
        if how == 0 and isinstance(value, int | float) and abs(value) < LARGEST:
            part[key] = value * rng.choice((-1, 0, 0.5, 0.999, 1.001, 2, 10, 1000, 1e6))
        elif how == 1:
            del part[key]
        elif how == 2 and isinstance(part, dict):
            part[rng.choice(NAMES)] = strange(rng)
        elif how == 3 and isinstance(part, dict):
            part[rng.choice(NAMES)] = part.pop(key)
        elif how == 4:
            other, there = rng.choice(known)
            part[key] = copy.deepcopy(
                other.get(there) if isinstance(other, dict) else other[there % len(other)] if other else 0
            )
        else:
            part[key] = strange(rng)
    return data


def damaged(content: bytes, rng: Random) -> bytes:
    """Bytes cut off, changed, put in, doubled or in another encoding."""
    how, at = rng.randrange(7), rng.randrange(len(content) + 1)
    if how == 0:
        return content[:at]
    if how == 1:
        return content[:at] + bytes([rng.randrange(256)]) + content[at + 1 :]
    if how == 2:
        return content[:at] + rng.choice(PIECES) + content[at:]
    if how == 3:
        end = min(len(content), at + rng.randint(1, 200))
        return content[:end] + content[at:end] + content[end:]
    if how == 4:
        lines = content.split(b"\n")
        lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
        return b"\n".join(lines)
    if how == 5:
        return content.decode("utf-8", "replace").encode(
            rng.choice(("utf-16", "utf-32", "utf-8-sig", "cp037")), "replace"
        )
    return content[:at] + rng.randbytes(rng.randint(1, 64)) + content[at:]


def json_text(data: Any, rng: Random) -> str:
    """JSON as Python writes it, also what is no JSON; sometimes with a key twice."""
    text = json.dumps(data, ensure_ascii=rng.random() < 0.7, indent=rng.choice((None, 1)))
    if rng.random() < 0.05 and text.startswith("{") and len(text) > 2:
        first = text[1 : text.find(",") if "," in text else -1]
        text = "{" + first + "," + text[1:]
    return text


def toml_text(data: Any, rng: Random) -> str:
    """TOML of nested dictionaries; values as TOML has them, integers also in hexadecimal, None as a date."""
    tables = {key: value for key, value in data.items() if isinstance(value, dict)} if isinstance(data, dict) else {}
    rest = {key: value for key, value in data.items() if key not in tables} if isinstance(data, dict) else {"x": data}
    lines = [f"{_key(key, rng)} = {_value(value, rng)}" for key, value in rest.items()]
    for name, table in tables.items():
        if rng.random() < 0.1:
            lines.append(f"{_key(name, rng)} = {_value(table, rng)}")
        else:
            lines.append(f"[{_key(name, rng)}]")
            lines += [f"{_key(key, rng)} = {_value(value, rng)}" for key, value in table.items()]
    if rng.random() < 0.02:
        lines.append(".".join(["a"] * rng.choice((20, 40, 3000))) + " = 1")
    return "\n".join(lines) + "\n"


def _key(key: str, rng: Random) -> str:
    plain = key.isascii() and key.replace("_", "a").isalnum() and rng.random() < 0.9
    return key if plain else json.dumps(key)


def _value(value: Any, rng: Random) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(key, rng)} = {_value(one, rng)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(_value(one, rng) for one in value) + "]"
    if value is None:
        return "2026-01-01"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int) and value > 1000 and rng.random() < 0.3:
        return hex(value << rng.choice((0, 20_000)))
    if isinstance(value, float):
        return str(value)
    return json.dumps(value)


def csv_text(rows: Any, rng: Random) -> str:
    """A table as CSV, quoted or not; what is no table too."""
    rows = rows if isinstance(rows, list) else [rows]
    quote: Callable[[Any], str] = str if rng.random() < 0.3 else lambda cell: f'"{cell}"'
    lines = [",".join(map(quote, row)) if isinstance(row, list) else str(row) for row in rows]
    return rng.choice(("\n", "\n", "\r\n")).join(lines) + "\n"
