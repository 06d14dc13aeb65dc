"""A requirements file that sliders change: the same text with other numbers, comments and all else kept."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from delta_cad.common.reading import MOST_TOML_BYTES, ReadError, parse_toml, read_bounded
from optimizer.problem.brief import MOVED, DesignBrief, brief_from_dict
from optimizer.problem.validation import RequirementsError

_TABLE = re.compile(r"\s*\[([^\[\]]+)\]\s*(?:#.*)?")
_COMMENT_COLUMN = 34  # where `init` begins sentences
_BARE = re.compile(r"[A-Za-z0-9_-]+")


@dataclass(frozen=True)
class Document:
    """A requirements file as it was read.

    Attributes:
        text: Its text.
        file: Name that errors start with.
        folder: Its folder, from which own parts are named.
        own_parts: Folder of own parts in place of that one, if a command names one.
    """

    text: str
    file: str
    folder: Path
    own_parts: Path | None = None

    @classmethod
    def read(cls, path: Path, own_parts: Path | None = None) -> Document:
        """Reads a file.

        Raises:
            RequirementsError: It cannot be read, or is no TOML.
        """
        name = path.name or str(path)
        try:
            content = read_bounded(path, MOST_TOML_BYTES)
            parse_toml(content, name)
        except ReadError as error:
            raise RequirementsError(name, "", "", error.allowed) from None
        return cls(content.decode(), name, path.parent, own_parts)

    def brief(self, values: Mapping[str, Any] | None = None) -> DesignBrief:
        """Reads it as a task, with other values of some fields.

        Args:
            values: Table and field, or a field outside all tables -> value; None removes it.

        Raises:
            RequirementsError: What `brief_from_dict` refuses.
        """
        return brief_from_dict(self._data(values or {}), self.file, self.folder, self.own_parts)

    def _data(self, values: Mapping[str, Any]) -> dict[str, Any]:
        data = deepcopy(tomllib.loads(self.text))
        for field, value in values.items():
            table, name = self._place(data, field)
            own = data.setdefault(table, {}) if table else data
            if value is not None:
                own[name] = value
            else:
                own.pop(name, None)
        return data

    @staticmethod
    def _place(data: Mapping[str, Any], field: str) -> tuple[str, str]:
        """Table and name of a field where the file has it: the first edition has some elsewhere."""
        for place in (field, *(old for old, new in MOVED.items() if new == field)):
            table, _, name = place.rpartition(".")
            if isinstance(data.get(table), dict) and name in data[table]:
                return table, name
        table, _, name = field.rpartition(".")
        return table, name

    def with_values(self, values: Mapping[str, Any]) -> str:
        """Writes its text with other values, lines and comments kept; plain TOML where its form allows no such edit.

        A field that is commented out is put in force; one that is removed is commented out.
        """
        wanted, text = self._data(values), self.text
        for field, value in values.items():
            table, name = self._place(tomllib.loads(self.text), field)
            text = _edited(text, table, name, value)
        try:
            kept = tomllib.loads(text)
        except tomllib.TOMLDecodeError:
            kept = {}
        same = {k: v for k, v in kept.items() if v != {}} == {k: v for k, v in wanted.items() if v != {}}
        return text if same else plain(wanted)


def _edited(text: str, table: str, name: str, value: Any) -> str:
    """A text with one field of one table set, or commented out."""
    lines, now, found, inert = text.splitlines(), "", None, None
    last = -1 if table == "" else None  # after which a line of the table may stand
    live = re.compile(rf"(\s*){re.escape(name)}(\s*=\s*)([^#]*?)(\s*#.*)?")
    dead = re.compile(rf"\s*#\s?{re.escape(name)}\s*=\s*([^#]*?)(\s*#.*)?")
    for k, line in enumerate(lines):
        if opened := _TABLE.fullmatch(line):
            now = opened[1].strip()
            last = k if now == table else last
        elif now == table:
            last = k if line.strip() and not line.lstrip().startswith("#") else last
            if live.fullmatch(line):
                found = k
            elif dead.fullmatch(line) and inert is None:
                inert = k
    if value is None:
        if found is not None:
            lines[found] = f"# {lines[found].lstrip()}"
        return "\n".join(lines) + "\n"
    written = f"{name} = {_value(value)}"
    if found is not None:
        match = live.fullmatch(lines[found])
        assert match is not None
        lines[found] = _commented(f"{match[1]}{name}{match[2]}{_value(value)}", match[4])
    elif inert is not None:
        match = dead.fullmatch(lines[inert])
        assert match is not None
        lines[inert] = _commented(written, match[2])
    elif last is not None:
        lines.insert(last + 1, written)
    else:
        lines += ["", f"[{table}]", written]
    return "\n".join(lines) + "\n"


def _commented(line: str, comment: str | None) -> str:
    return line if comment is None else f"{line:{_COMMENT_COLUMN - 1}} {comment.lstrip()}"


def _value(value: Any) -> str:
    """A value as TOML writes it; tables inline."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, float):
        return f"{value:.10g}"
    return json.dumps(value, ensure_ascii=False)


def _key(name: str) -> str:
    return name if _BARE.fullmatch(name) else json.dumps(name)


def plain(data: Mapping[str, Any]) -> str:
    """Writes a requirements file from its data, without comments: values first, then each table."""
    lines = [f"{_key(name)} = {_value(value)}" for name, value in data.items() if not isinstance(value, dict)]
    for name, table in data.items():
        if isinstance(table, dict):
            lines += ["", f"[{_key(name)}]", *(f"{_key(k)} = {_value(v)}" for k, v in table.items())]
    return "\n".join(lines) + "\n"
