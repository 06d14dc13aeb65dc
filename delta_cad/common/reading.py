"""Files that somebody else may have written, read within bounds: of size and depth, in UTF-8, no key given twice.

Every reader of the project goes through here, so that what one refuses all refuse.
"""

from __future__ import annotations

import json
import math
import os
import re
import select
import stat
import time
from pathlib import Path
from typing import Any, NoReturn

from delta_cad.common.refusal import RefusedError, not_finite, short

BINARY = getattr(os, "O_BINARY", 0)  # Windows otherwise reads and writes other line ends
_AT_ONCE = getattr(os, "O_NONBLOCK", 0)
MOST_BYTES = 64_000_000  # largest file that is looked at; the files that we write have less than a tenth of it
MOST_TOML_BYTES = 1_000_000  # what people write by hand has a thousandth of it
_PIECE = 1_000_000  # bytes read at a time
NOBODY_S = 2.0  # from opening a pipe until nobody is expected to write into it any more
_LOOK_MS = 50  # between two looks whether somebody has opened it by now
DEEPEST = 32  # most lists and objects within each other; our files have six
MOST_KEYS = 10_000  # of one object; ours have some tens, and what is wrong with each is gathered before one is told
MOST_VALUES = 2_000_000  # of one file; ours have some ten thousands, and 31 million empty lists take half a minute
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
_MANY_DIGITS = re.compile(r"\d{300}")  # of a whole number that may be larger than any double
# A key of more parts than the deepest table has: reading one takes the square of its length, minutes for 60 kB.
_NAME = r"(?:[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')"
_LONG_KEY = re.compile(rf"(?m)(?:^|[\[{{,])[ \t]*+{_NAME}(?:[ \t]*+\.[ \t]*+{_NAME}){{{DEEPEST}}}")


class ReadError(RefusedError):
    """A file that we cannot read as what it should be."""


class _TwiceError(ValueError):
    """A key that stands twice in one object."""

    def __init__(self, key: str, value: object) -> None:
        super().__init__(key)
        self.key, self.value = key, short(value)


def read_bounded(path: Path, most_bytes: int = MOST_BYTES) -> bytes:
    """Reads a file, but never more of it than a bound.

    A pipe, such as `/dev/stdin` or the shell's `<(command)`, is read until who writes has closed it.

    Args:
        path: The file.
        most_bytes: The bound.

    Returns:
        All its bytes.

    Raises:
        ReadError: It cannot be read or is larger, or is a pipe that nobody opens to write.
    """
    try:
        descriptor = os.open(path, os.O_RDONLY | _AT_ONCE | BINARY)  # that of a pipe would wait for who writes
        try:
            content = _content(descriptor, most_bytes + 1, path.name)
        finally:
            os.close(descriptor)
    except (OSError, ValueError) as error:  # a name with a null byte is a ValueError
        if isinstance(error, ReadError):
            raise
        raise ReadError(path.name, "", "", f"cannot be read: {getattr(error, 'strerror', None) or error}") from None
    if len(content) > most_bytes:
        raise ReadError(path.name, "", "", f"is larger than {most_bytes / 1e6:g} MB; it must be at most that")
    return content


def _content(descriptor: int, most_bytes: int, name: str) -> bytes:
    """Reads up to a number of bytes of an open file, whatever its kind."""
    pipe, deadline = stat.S_ISFIFO(os.fstat(descriptor).st_mode), time.monotonic() + NOBODY_S
    pieces, left = [], most_bytes
    came: Any = select.poll() if _AT_ONCE else None  # where all reading waits, as on Windows, nothing is looked for
    if came is not None:
        came.register(descriptor, select.POLLIN)
    while left:
        try:
            piece = os.read(descriptor, min(left, _PIECE))
        except BlockingIOError:  # somebody has it open and is yet to write
            assert came is not None
            came.poll()
            continue
        if piece:
            pieces.append(piece)
            left -= len(piece)
        elif not pipe or came is None or came.poll(0):  # a pipe reports that its writer has closed it
            break
        elif time.monotonic() > deadline:
            raise ReadError(name, "", "", "is a pipe that nobody writes into; must be a file, or a pipe with a writer")
        else:
            came.poll(_LOOK_MS)  # who opens it and is silent does not end this
    return b"".join(pieces)


def text_of(content: bytes, name: str) -> str:
    """Decodes a file's bytes; the mark that some editors begin a file with is no part of it.

    Args:
        content: The bytes.
        name: Of the file, which messages start with.

    Raises:
        ReadError: They are not UTF-8.
    """
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ReadError(name, "", "", f"is not UTF-8 text: {error.reason} at byte {error.start}") from None


def read_json(path: Path, most_bytes: int = MOST_BYTES, finite: bool = True) -> Any:
    """Reads a JSON file within bounds.

    Args:
        path: The file.
        most_bytes: Largest file that is looked at; no more is read of any.
        finite: As of `parse_json`.

    Returns:
        Dictionaries, lists, text, numbers, truths and None.

    Raises:
        ReadError: It cannot be read, is too large, or `parse_json` refuses it.
    """
    return parse_json(read_bounded(path, most_bytes), path.name, finite)


def parse_json(content: bytes, name: str, finite: bool = True) -> Any:
    """Makes plain data of JSON in UTF-8.

    Args:
        content: The file's bytes.
        name: Of the file, which messages start with.
        finite: Whether to refuse numbers that are not finite; else the caller does, who knows their fields.

    Returns:
        Dictionaries, lists, text, numbers, truths and None.

    Raises:
        ReadError: It is no JSON in UTF-8; a key stands twice in one object, or that has more than `MOST_KEYS`; a number
            is not finite or has thousands of digits; it is nested deeper than `DEEPEST` or has more than `MOST_VALUES`
            values; or text in it is no Unicode.
    """
    text = text_of(content, name)
    if sum(map(text.count, ",[{")) > MOST_VALUES:  # those in strings count, too
        raise ReadError(name, "", "", f"has more than {MOST_VALUES} values; it must have at most that")
    try:
        numbers: dict[str, Any] = {"parse_constant": _no_number, "parse_float": _finite} if finite else {}
        data = json.loads(text, object_pairs_hook=_once, **numbers)
        if finite and _MANY_DIGITS.search(text) and (found := not_finite(data)) is not None:
            raise ReadError(name, found[0], short(found[1]), "is larger than any double")
        if _SURROGATE.search(text):
            json.dumps(data, ensure_ascii=False).encode()
    except RecursionError:
        raise _too_deep(name) from None
    except UnicodeEncodeError:
        raise ReadError(name, "", "", "is not JSON we can read: half a surrogate pair is no text") from None
    except ReadError:
        raise
    except _TwiceError as error:
        rule = "is given more than once in one object; a key must be given once"
        raise ReadError(name, error.key, error.value, rule) from None
    except json.JSONDecodeError as error:
        where = f"line {error.lineno} column {error.colno}"
        raise ReadError(name, "", "", f"is not JSON: {error.msg} at {where}") from None
    except ValueError as error:
        raise ReadError(name, "", "", f"is not JSON we can read: {error}") from None
    return _shallow(data, name)


def parse_toml(content: bytes, name: str) -> dict[str, Any]:
    """Makes plain data of TOML.

    Args:
        content: The file's bytes.
        name: Of the file, which messages start with.

    Returns:
        Its tables: dictionaries, lists, text, numbers, truths and times; integers of any size.

    Raises:
        ReadError: It is no TOML in UTF-8, has a number of thousands of digits, or is nested deeper than `DEEPEST`.
    """
    import tomllib

    text = text_of(content, name)
    if _LONG_KEY.search(text):
        raise _too_deep(name)
    try:
        data = tomllib.loads(text)
    except RecursionError:
        raise _too_deep(name) from None
    except ValueError as error:
        raise ReadError(name, "", "", f"is not TOML we can read: {error}") from None
    return _shallow(data, name)


def _too_deep(name: str) -> ReadError:
    return ReadError(name, "", "", f"is nested deeper than {DEEPEST} levels")


def _shallow(data: Any, name: str) -> Any:
    """Gives the data back if lists and objects are not too deep within each other."""
    level = [data]
    for _ in range(DEEPEST):
        level = [value for part in level for value in _values(part) if isinstance(value, dict | list)]
        if not level:
            return data
    raise _too_deep(name)


def _values(part: Any) -> Any:
    """What an object or a list holds; nothing for a plain value."""
    return part.values() if isinstance(part, dict) else part if isinstance(part, list) else ()


def _once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object; refuses a key that stands twice, of which a plain reader takes the last without a word."""
    if len(pairs) > MOST_KEYS:
        raise ValueError(f"an object has {len(pairs)} keys; it must have at most {MOST_KEYS}")
    data: dict[str, Any] = {}
    for key, value in pairs:
        if key in data:
            raise _TwiceError(key, value)
        data[key] = value
    return data


def _no_number(token: str) -> NoReturn:
    raise ValueError(f"{token} is no number of JSON")


def _finite(token: str) -> float:
    value = float(token)
    if not math.isfinite(value):
        raise ValueError(f"{token[:24]} is larger than any double")
    return value
