"""JSON files that somebody else may have written: bounded in size and depth, every key once, every number finite.

Every reader of the project goes through here, so that what one refuses all refuse.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path
from typing import Any, NoReturn

MOST_BYTES = 64_000_000  # largest file that is looked at; the files that we write have less than a tenth of it
DEEPEST = 32  # most lists and objects within each other; our files have six
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")


class JsonError(ValueError):
    """A file that is not the JSON we read; the message starts with its name and holds nothing of it unescaped."""


def read_json(path: Path, most_bytes: int = MOST_BYTES) -> Any:
    """Reads a JSON file within bounds.

    Args:
        path: The file.
        most_bytes: Largest file that is looked at; no more is read of any.

    Returns:
        Dictionaries, lists, text, numbers, truths and None.

    Raises:
        JsonError: It cannot be read, is too large, or `parse_json` refuses it.
    """
    return parse_json(read_bounded(path, most_bytes), path.name)


def read_bounded(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """Reads a file, but never more of it than a bound.

    Args:
        path: The file.
        most_bytes: The bound.

    Returns:
        All its bytes.

    Raises:
        JsonError: It cannot be read or is larger.
    """
    try:
        with path.open("rb") as file:
            content = file.read(most_bytes + 1)
    except (OSError, ValueError) as error:  # a name with a null byte is a ValueError
        raise JsonError(f"{path.name}: cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > most_bytes:
        raise JsonError(f"{path.name}: is larger than {most_bytes / 1e6:g} MB; it must be at most that")
    return content


def parse_json(content: bytes, name: str) -> Any:
    """Makes plain data of JSON in UTF-8.

    Args:
        content: The file's bytes.
        name: Of the file, which messages start with.

    Returns:
        Dictionaries, lists, text, numbers, truths and None.

    Raises:
        JsonError: It is no JSON in UTF-8; a key stands twice in one object; a number is not finite or has thousands of
            digits; it is nested deeper than `DEEPEST`; or text in it is no Unicode.
    """
    try:
        text = content.decode("utf-8")
        data = json.loads(text, object_pairs_hook=_once, parse_constant=_no_number, parse_float=_finite)
        if _SURROGATE.search(text):
            json.dumps(data, ensure_ascii=False).encode()
    except RecursionError:
        raise JsonError(f"{name}: is nested deeper than {DEEPEST} levels") from None
    except UnicodeEncodeError:
        raise JsonError(f"{name}: is not JSON we can read: half a surrogate pair is no text") from None
    except ValueError as error:
        raise JsonError(f"{name}: is not JSON we can read: {error}") from None
    level = [data]
    for _ in range(DEEPEST):
        level = [value for part in level for value in _values(part) if isinstance(value, dict | list)]
        if not level:
            return data
    raise JsonError(f"{name}: is nested deeper than {DEEPEST} levels")


def _values(part: Any) -> Any:
    """What an object or a list holds; nothing for a plain value."""
    return part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object; refuses a key that stands twice, of which a plain reader takes the last without a word."""
    data = dict(pairs)
    if len(data) != len(pairs):
        seen: set[str] = set()
        twice = next(key for key, _ in pairs if key in seen or seen.add(key))  # type: ignore[func-returns-value]
        raise ValueError(f"the key {twice[:60]!a} stands twice in one object")
    return data


def _no_number(token: str) -> NoReturn:
    raise ValueError(f"{token} is no number of JSON")


def _finite(token: str) -> float:
    value = float(token)
    if not math.isfinite(value):
        raise ValueError(f"{token[:24]} is larger than any double")
    return value
